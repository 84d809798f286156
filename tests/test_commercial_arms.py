"""Arms that nobody here has seen converge with no parameter given: `make test-robots`."""

import pytest
from commercial_arms import CASES, measure

import resonance_mj as rmj

pytestmark = pytest.mark.robots


@pytest.mark.parametrize("case", CASES, ids=lambda case: "-".join(vars(case).values()))
def test_an_arm_reaches_the_bounded_optimum_and_tracks_within_20_cycles(case):
    found = measure(case)
    assert found.run.status is rmj.Status.OK, found.run.message
    assert found.torque_ratio < 1.02
    assert found.tracking_rms < 1.5e-3
