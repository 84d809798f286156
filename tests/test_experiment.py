"""Experiment files: what is read is what was written, and what is wrong is said in one line."""

import math

import pytest
from hypothesis import given
from hypothesis import strategies as st

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.experiments.keys import describe

SHORT = """
[robot]
mjcf = "two_link.xml"

[[motion]]
duration = 2.0
shape = "fourier"
offset = [-0.3, 0.0]
sin = [[0.05], [-0.2]]
"""


def written(tmp_path, text):
    path = tmp_path / "mine.toml"
    path.write_text(text)
    return path


@pytest.mark.parametrize("name", library.experiments())
def test_a_built_in_experiment_goes_to_toml_and_back_unchanged(name, tmp_path):
    experiment = rmj.load(name)
    assert rmj.load(written(tmp_path, experiment.to_toml())) == experiment


@given(
    beta=st.floats(0, 1e6),
    k_v=st.floats(0, 1e6) | st.tuples(st.floats(0, 1e6), st.floats(0, 1e6)),
    upper=st.floats(1e-3, 1e6) | st.just(math.inf),
    gravity=st.none() | st.tuples(*[st.floats(-20, 20)] * 3),
)
def test_any_valid_values_survive_the_way_to_toml_and_back(
    beta, k_v, upper, gravity, tmp_path_factory
):
    experiment = rmj.load("paper").replace(
        {
            "law.beta": beta,
            "law.k_v": k_v,
            "springs.stiffness": [-upper, upper],
            "simulation.gravity": gravity,
        }
    )
    path = written(tmp_path_factory.mktemp("toml"), experiment.to_toml())
    assert rmj.load(path) == experiment


def test_everything_has_a_default_but_the_robot_and_a_motion(tmp_path):
    experiment = rmj.load(written(tmp_path, SHORT))
    assert experiment.name == "mine"
    assert experiment.springs.stiffness == (0.0, math.inf)


def test_an_mjcf_beside_the_file_is_found_from_any_folder(tmp_path, monkeypatch):
    robot = library.robots()["two_link.xml"].read_text()
    (tmp_path / "here").mkdir()
    (tmp_path / "here" / "arm.xml").write_text(robot)
    path = written(tmp_path / "here", SHORT.replace("two_link.xml", "arm.xml"))
    monkeypatch.chdir(tmp_path)
    assert rmj.load(path).robot.mjcf == str(tmp_path / "here" / "arm.xml")


def test_replace_changes_one_value_and_leaves_the_original_alone():
    paper = rmj.load("paper")
    changed = paper.replace({"law.beta": 3.0, "motion.1.period": 0.5, "simulation.timestep": 5e-4})
    assert (changed.law.beta, changed.motion[1].period) == (3.0, 0.5)
    assert paper.law.beta == 1.0
    assert changed.motion[0] == paper.motion[0]


def test_every_key_is_described_with_its_meaning():
    rows = describe()
    assert {key for key, _, _ in rows} >= {"law.beta", "simulation.timestep", "robot.mjcf"}
    assert all(meaning for _, _, meaning in rows)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"law.bta": 1}, ["law.bta", "unknown key", "'beta'", "valid keys"]),
        ({"law.beta": -1}, ["law.beta = -1", "greater than or equal to 0"]),
        ({"law.beta": math.nan}, ["law.beta = nan", "finite"]),
        ({"law.k_p": [2000, math.inf]}, ["law.k_p.1 = inf", "finite"]),
        ({"law.gamma_k": [1, -2]}, ["law.gamma_k.1 = -2", "greater than or equal to 0"]),
        ({"law.lead": 1000}, ["law.lead = 1000", "1000 time steps"]),
        ({"law.harmonics": 501}, ["law.harmonics = 501", "Nyquist", "motion.0", "1 to 500"]),
        ({"law.q_c": "median"}, ["law.q_c = 'median'", "'mean'"]),
        ({"simulation.timestep": 0.0}, ["simulation.timestep = 0.0", "greater than 0"]),
        ({"simulation.timestep": 0.0007}, ["motion.0.period", "1428.57 time steps", "example"]),
        ({"simulation.integrator": "discrete"}, ["'discrete'", "implicitfast", "dissipates"]),
        ({"simulation.integrator": "implicit"}, ["'implicit'", "Euler, implicitfast and RK4"]),
        ({"motion.0.duration": 40.3}, ["motion.0", "40.3 periods", "example 40 s"]),
        ({"motion.0.offset": [0.1]}, ["motion.0", "one per coordinate"]),
        ({"motion.0.sin": [[0.05]]}, ["motion.0", "sin has 1 rows"]),
        ({"motion.5.period": 1.0}, ["motion.5.period", "0 to 1"]),
        ({"task.coordinates": ["x", "x"]}, ["task.coordinates", "once"]),
        ({"springs.stiffness": [3, 1]}, ["springs.stiffness = [3, 1]", "lower < upper"]),
        ({"springs.equilibrium": [-1, 1]}, ["equilibrium = [-1.0, 1.0]", "not convex"]),
        ({"name": "../up"}, ["name = '../up'"]),
    ],
)  # fmt: skip
def test_a_bad_value_is_refused_in_one_line_that_names_key_value_and_remedy(changes, words):
    with pytest.raises(rmj.ResonanceError) as caught:
        rmj.load("paper").replace(changes)
    message = str(caught.value)
    assert "\n" not in message
    assert [word for word in words if word not in message] == []


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x = [", ["mine.toml", "not valid TOML"]),
        (SHORT.replace("duration", "duraton"), ["motion.0.duraton", "'duration'"]),
        ("[[motion]]\nduration = 2\n", ["robot", "missing"]),
        (SHORT + "[laws]\nbeta = 1\n", ["laws", "unknown key", "law"]),
    ],
)
def test_a_bad_file_is_refused_in_one_line_that_names_it(tmp_path, text, words):
    path = written(tmp_path, text)
    with pytest.raises(rmj.ResonanceError) as caught:
        rmj.load(path)
    message = str(caught.value)
    assert message.startswith(str(path))
    assert "\n" not in message
    assert [word for word in words if word not in message] == []


def test_an_unknown_name_lists_those_that_exist():
    with pytest.raises(rmj.ResonanceError, match="did you mean 'paper'") as caught:
        rmj.load("papr")
    assert all(name in str(caught.value) for name in library.experiments())
