"""The paper's simulations against the arm in closed form under the law written out: no MuJoCo."""

import closed_form_law
import numpy as np
import pytest
import two_link

import resonance_mj as rmj

PHASE = np.arange(1000) / 1000
MOTIONS = (two_link.first_motion, two_link.second_motion)


def closed_form(name):
    """Last cycle of both motions: k, q̄_e, torque reduction and tracking RMS."""
    mean = two_link.joint_motion(*two_link.first_motion(PHASE))[0].mean(axis=0)
    q_c, q_s = (mean, mean) if name == "paper-centered" else (np.array([-0.5, -2.0]), np.zeros(2))
    found = closed_form_law.simulate(
        MOTIONS, cycles=40, q_c=q_c, q_s=q_s, transpose=name == "paper-transpose"
    )
    for motion, (k, offset, squared, rms) in zip(MOTIONS, found, strict=True):
        torque = two_link.inverse_dynamics(*two_link.joint_motion(*motion(PHASE)))
        without = (torque**2).sum(axis=1).mean()
        yield {
            "stiffness": k,
            "offset": offset,
            "torque_reduction": 1 - squared / without,
            "tracking_rms": rms,
        }


slow = pytest.mark.sensitivity


@pytest.mark.parametrize(
    "name",
    [
        "paper",
        pytest.param("paper-centered", marks=slow),
        pytest.param("paper-transpose", marks=slow),
    ],
)
def test_whole_run_is_that_of_the_closed_form_arm(name):
    """After 80 000 steps to five digits, and the numbers that the file expects are these."""
    experiment = rmj.load(name)
    segments = rmj.simulate(experiment).summary()["segments"]
    expected = experiment.expect.motion
    for exact, segment, motion in zip(closed_form(name), segments, expected, strict=True):
        for figure, value in exact.items():
            np.testing.assert_allclose(segment[figure], value, rtol=1e-5, err_msg=figure)
            written = motion.figures()[figure]
            np.testing.assert_allclose(
                written.value, value, rtol=(written.rel or 0) / 5, atol=(written.abs or 0) / 5
            )
