"""A key that changes nothing is said; one that changes something never is."""

import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.experiments.effects import without_effect

SHORT = {"motion.0.duration": 3.0, "motion.1.duration": 3.0, "expect": {}}
GIVEN = {
    "parameters": [1.0],
    "beta": 2.0,
    "eta": 0.3,
    "lead": 2,
    "harmonics": 7,
    "omega": 50.0,
    "gamma_k": 20.0,
    "gamma_qe": 30.0,
    "q_c": [4.1, -1.7],
    "q_s": [4.1, -1.7],
    "jacobian": "transpose",
    "alpha": 12.0,
    "alpha_0": 12.0,
}


ADAPTING = {"gamma_k": 10.0, "gamma_qe": 10.0}
BY_HAND = {"k_v": 200.0, "k_p": 2000.0}
KINDS = ["feedback", "learning", "fixed", "joint-space", "paper"]


@pytest.mark.parametrize(
    ("kind", "gains"),
    [
        ("transfer", ADAPTING),
        ("feedback", BY_HAND),
        ("joint-space", {}),
        ("paper", BY_HAND | {"beta": 1.0, "gamma_qe": 10.0}),
        *(
            pytest.param(kind, gains, marks=pytest.mark.slow)
            for kind in KINDS
            for gains in ({}, ADAPTING)
        ),
        pytest.param("computed-torque", BY_HAND, marks=pytest.mark.slow),
    ],
)
def test_what_is_said_to_have_no_effect_has_none_and_the_rest_has(kind, gains):
    """Each key in turn, by whole runs to the last bit."""
    paper = rmj.load("paper")
    motion = [paper.motion[0].model_dump() | {"duration": 2.0}]
    base = paper.replace({"law": {"kind": kind, **gains}, "motion": motion, "expect": {}})
    plain = rmj.simulate(base).data
    wrong = []
    velocity = "difference" if kind in ("paper", "joint-space") else "jacobian"
    for key, value in (GIVEN | {"velocity": velocity}).items():
        changed = base.replace({f"law.{key}": value})
        said = any(line.startswith(f"law.{key} =") for line in without_effect(changed, square=True))
        data = rmj.simulate(changed).data
        same = all(np.array_equal(data[name], plain[name]) for name in ("q", "tau", "stiffness"))
        if said != same:
            wrong.append(key)
    assert wrong == []


def test_where_the_task_leaves_joints_free_a_law_in_joint_space_does_not_use_the_tools_gains():
    arm = rmj.load("planar-three-link").replace({"law": {"kind": "joint-space"}, "expect": {}})
    arm = arm.replace({"motion.0.duration": 2.0})
    given = arm.replace({"law.k_v": 300.0, "law.k_p": 3000.0})
    said, plain = rmj.simulate(given), rmj.simulate(arm)
    assert np.array_equal(said.data["tau"], plain.data["tau"])
    assert [line[:7] for line in said.notes if "no effect" in line] == ["law.k_v", "law.k_p"]


def test_limits_that_no_joint_has_are_said_to_be_off_in_vain():
    given = rmj.load("paper").replace({"robot.limits": False, **SHORT})
    assert any(
        line.startswith("robot.limits = False has no effect") for line in rmj.simulate(given).notes
    )
    assert not without_effect(given, limited=True)


def test_where_springs_must_be_stiff_their_first_equilibrium_counts():
    plain = rmj.load("paper").replace({"law": {}, "springs": {}, **SHORT})
    given = plain.replace({"springs.initial_equilibrium": [4.0, -2.0]})
    assert [line[:27] for line in without_effect(given)] == ["springs.initial_equilibrium"]
    assert not without_effect(given.replace({"springs.stiffness": [5.0, 9.0]}))


def test_what_a_law_of_ones_own_may_read_is_not_said_to_have_no_effect(tmp_path):
    (tmp_path / "own.py").write_text(
        "def learn(u, stiffness, offset, center):\n    return u, stiffness, offset, center\n"
    )
    law = {"kind": str(tmp_path / "own.py"), "parameters": [1.0], "q_c": [1.0, 2.0]}
    paper = rmj.load("paper").replace({"law": {}})
    assert without_effect(paper.replace({"law": law})) == []


def test_the_runs_that_come_with_the_program_have_no_such_key():
    for name in library.experiments():
        assert without_effect(rmj.load(name)) == []


def test_an_experiment_with_every_default_written_out_has_no_such_key(tmp_path):
    path = tmp_path / "arm.toml"
    path.write_text(rmj.load("seven-joint").to_toml())
    assert without_effect(rmj.load(path)) == []


def test_a_run_has_it_among_its_notes():
    changed = rmj.load("paper").replace(
        {"law": {}, "law.kind": "transfer", "law.q_c": [1.0, 2.0], **SHORT}
    )
    (line,) = (line for line in rmj.simulate(changed).notes if "no effect" in line)
    assert line == (
        "law.q_c = [1.0, 2.0] has no effect: law.kind = 'transfer' does not adapt the springs by "
        "(6), (7) here"
    )


def test_what_bounds_are_about_is_said_to_be_idle_where_there_are_none():
    about = {"springs.equilibrium_about": "zero"}
    given = rmj.load("paper").replace(about)
    assert [line[:25] for line in without_effect(given)] == ["springs.equilibrium_about"]
    assert not without_effect(
        given.replace({"springs.equilibrium": [-3, 3], "springs.stiffness": [0, 50]})
    )


def test_a_seed_without_noise_and_a_velocity_of_exact_angles_are_said_to_be_idle():
    given = rmj.load("paper").replace({"reality": {"seed": 3, "velocity": "sensor"}})
    assert [line[:16] for line in without_effect(given)] == ["reality.seed = 3", "reality.velocity"]
    noisy = given.replace({"reality.encoder_noise": 1e-4})
    assert not without_effect(noisy)
