"""Arms that others made, with nothing given but their file: `make test-robots`."""

import re

import commercial_arms
import pytest
import wheels
from public_arms import ARMS, HEADS, measure, row

import resonance_mj as rmj
from resonance_mj.evaluation.robustness import figures
from resonance_mj.experiments.loading import for_robot

pytestmark = pytest.mark.robots


@pytest.mark.parametrize("arm", ARMS, ids=lambda arm: arm.name)
def test_an_arm_of_a_public_wheel_comes_to_what_is_expected_of_it(arm, record_property):
    found = measure(str(arm.path), arm.changes)
    record_property(HEADS, row(arm, found))
    assert not found.wrong_ok, f"says ok, and the judge finds {found.judged}"
    assert found.meets(arm.expected), f"{found.status}: {found.said}"


@pytest.mark.parametrize(
    "case", commercial_arms.CASES, ids=lambda case: "-".join(vars(case).values())
)
def test_a_commercial_arm_comes_to_the_bounded_optimum_in_20_cycles_or_says_why_not(
    case, record_property
):
    run, found = commercial_arms.measure(case)
    record_property(commercial_arms.HEADS, commercial_arms.row(case, run, found))
    assert not found.wrong_ok, f"says ok, and the judge finds {found.judged}"
    if case in commercial_arms.SAID:
        assert re.search(commercial_arms.SAID[case], "\n".join((run.message, *run.notes)))
    else:
        assert found.at_optimum, f"{found.status}: {found.said}: {found.judged}"


REAL = {
    "robosuite": [
        f"robots/{name}/robot.xml"
        for name in ("panda", "iiwa", "ur5e", "kinova3", "jaco", "xarm7", "sawyer")
    ],
    "example-robot-data": [
        "so_arm_description/urdf/so101.urdf",
        "z1_description/urdf/z1.urdf",
        "ur_description/urdf/ur10_robot.urdf",
        "ur_description/urdf/ur3_robot.urdf",
        "panda_description/urdf/panda.urdf",
        "kinova_description/robots/kinova.urdf",
        "xarm_description/urdf/xarm7.urdf",
    ],
}


@pytest.mark.parametrize(("preset", "least"), [("lab", 0.98), ("cheap", 0.7)])
@pytest.mark.parametrize("arm", [(wheel, file) for wheel, files in REAL.items() for file in files])
def test_an_arm_with_noise_and_delay_comes_to_its_optimum_whatever_the_seed(arm, preset, least):
    wheel, file = arm
    asked = for_robot(str(wheels.folder(wheel) / file)).replace({"motion.0.duration": 60.0})
    seeds = [asked.replace({"reality": preset, "reality.seed": seed}) for seed in range(3)]
    for run in rmj.simulate_many(seeds, progress=False):
        assert run.status is rmj.Status.OK, run.message
        found = figures(run)
        assert found["share"] > 0.99
        assert found["kept"] > least
