"""Experiment files: what is read is what was written, and what is wrong is said in one line."""

import math
import time
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import resonance_mj as rmj
from resonance_mj import library
from resonance_mj.experiments.experiment import describe

SHORT = """
[robot]
mjcf = "two_link.xml"

[[motion]]
duration = 2.0
shape = "fourier"
offset = [-0.3, 0.0]
sin = [[0.05], [-0.2]]
"""


def deep(levels):
    """Brackets in brackets."""
    inside = 1.0
    for _ in range(levels):
        inside = [inside]
    return inside


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


def test_replace_keeps_what_was_given_and_nothing_else(tmp_path):
    experiment = rmj.load(written(tmp_path, SHORT)).replace({"law.eta": 0.4}).replace({"name": "x"})
    assert experiment.law.model_fields_set == {"eta"}
    assert experiment.motion[0].model_fields_set == {"duration", "shape", "offset", "sin"}
    assert experiment.springs.model_fields_set == set()


def test_numbers_and_arrays_of_numpy_and_paths_are_taken_as_plain_ones(tmp_path):
    plain = {
        "law.beta": 2.0,
        "law.lead": 1,
        "law.k_v": [200.0, 300.0],
        "motion.0.sin": [[0.05], [0.1]],
        "robot.contacts": False,
        "robot.mjcf": "arm.xml",
    }
    arrays = {
        "law.beta": np.float64(2),
        "law.lead": np.int32(1),
        "law.k_v": [np.float32(200), np.int64(300)],
        "motion.0.sin": np.array([[0.05], [0.1]]),
        "robot.contacts": np.bool_(False),
        "robot.mjcf": Path("arm.xml"),
    }
    paper = rmj.load("paper")
    assert paper.replace(arrays) == paper.replace(plain)
    path = written(tmp_path, paper.replace(arrays).to_toml())
    assert rmj.load(path) == paper.replace(plain)


@pytest.mark.parametrize("key", ["law.parameters", "robot.home", "motion.0.offset"])
def test_a_list_of_one_number_needs_no_brackets(key):
    plain = rmj.load("paper").replace({"motion": [{"shape": "fourier", "offset": [0]}]})
    assert plain.replace({key: 3}) == plain.replace({key: [3.0]})


def test_twenty_thousand_numbers_are_written_and_read_back_in_a_second(tmp_path):
    numbers = np.random.default_rng(0).normal(size=20_000)
    experiment = rmj.load("paper").replace({"law.parameters": numbers})
    began = time.perf_counter()
    path = written(tmp_path, experiment.to_toml())
    assert rmj.load(path) == experiment
    assert time.perf_counter() - began < 1.0


@given(name=st.text(max_size=20).filter(lambda text: "\0" not in text))
def test_any_name_survives_the_way_to_toml_and_back(name, tmp_path_factory):
    experiment = rmj.load("paper").replace({"robot.tool": name, "robot.mjcf": name + ".xml"})
    path = tmp_path_factory.mktemp("toml") / "x.toml"
    path.write_text(experiment.to_toml(), encoding="utf-8", newline="")
    assert rmj.load(path) == experiment


def test_every_key_is_described_with_its_meaning():
    rows = describe()
    assert {key for key, _, _ in rows} >= {"law.beta", "simulation.timestep", "robot.mjcf"}
    assert all(meaning for _, _, meaning in rows)
    assert not any("\n" in meaning for _, _, meaning in rows)


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
        ({"springs.stiffness": [3, 1]}, ["springs.stiffness = [3, 1]", "lower <= upper"]),
        ({"springs.equilibrium": [-1, 1]}, ["equilibrium = [-1.0, 1.0]", "not convex"]),
        ({"name": "../up"}, ["name = '../up'"]),
        ({"name": "a" * 300}, ["name = 'aaa", "at most 100"]),
        ({"law.beta": 1e300}, ["law.beta = 1e+300", "less than or equal to 1000000000"]),
        ({"law.q_c": 1e300}, ["law.q_c = 1e+300", "less than or equal to 1000000"]),
        ({"law.beta": "3"}, ["law.beta = '3'", "number"]),
        ({"law.beta": True}, ["law.beta = True", "number"]),
        ({"law.lead": 1 << 100_000}, ["law.lead = an integer of 100001 bits", "100000"]),
        ({"motion.0.payload": 1e308}, ["motion.0.payload", "less than or equal to 1000000"]),
        ({"simulation.gravity": [0, 0, -1e308]}, ["gravity.2 = -1e+308", "equal to -1000000"]),
        ({"springs.stiffness": [0, 1e300]}, ["stiffness.1 = 1e+300", "-1e9 to 1e9", "inf"]),
        ({"springs.stiffness": [math.nan, 1]}, ["springs.stiffness.0 = nan", "-1e9 to 1e9"]),
        ({"springs.stiffness": [1, 5], "springs.initial_stiffness": 7},
         ["initial_stiffness = 7.0", "stiffness = [1.0, 5.0]"]),
        ({"simulation.timestep": 1e-9}, ["motion.0.period", "1e+09 time steps", "8 to 100000"]),
        ({"simulation.timestep": 5e-324}, ["motion.0.period", "inf time steps", "8 to 100000"]),
        ({"motion.0.period": 0.002}, ["motion.0.period", "2 time steps", "8 to 100000"]),
        ({"motion.0.duration": 1e9}, ["motion.0", "duration 1e+09 s", "up to 1000000"]),
        ({"motion.0.duration": 1e6}, ["motion.0.duration", "1000040 cycles", "1000000 cycles"]),
        ({"motion.0.period": 1e-300}, ["motion.0", "periods of 1e-300 s", "up to 1000000"]),
        ({"law.k_v": ["x" * 700_000]}, ["law.k_v.0 = 'xxx", "number"]),
        ({"x" * 700_000: 1}, ["unknown key", "robot"]),
        ({"a." * 20_000 + "b": 1}, ["nested too deeply"]),
        ({"law.beta" + ".a" * 20_000: 1}, ["law.beta.a", "inside a value"]),
        ({"law.k_v": deep(200)}, ["law.k_v", "number"]),
        ({"law.k_v": deep(100_000)}, ["nested too deeply"]),
        ({"robot.mjcf": "a\0b"}, ["robot.mjcf = 'a\\x00b'"]),
        ({"robot.mjcf": "\udcff"}, ["robot.mjcf = '\\udcff'", "unicode"]),
        ({3: 4}, ["3: unknown key", "robot"]),
    ],
)  # fmt: skip
def test_a_bad_value_is_refused_in_one_line_that_names_key_value_and_remedy(changes, words):
    with pytest.raises(rmj.ResonanceError) as caught:
        rmj.load("paper").replace(changes)
    message = str(caught.value)
    assert message.isprintable()
    assert len(message) < 500
    assert [word for word in words if word not in message] == []


@pytest.mark.parametrize(
    ("text", "words"),
    [
        (f"x = {'[' * 500}{']' * 500}", ["nested too deeply", "keys"]),
        ("a." * 20_000 + "b = 1", ["nested too deeply", "keys"]),
        (f"x = {'9' * 5000}", ["not valid TOML"]),
        ("#" * 4_000_001, ["longer than 4 MB", "paper"]),
        ("x = '\0'", ["not valid TOML"]),
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


@pytest.mark.parametrize("encoding", ["utf-16", "utf-32", "latin-1"])
def test_a_file_in_another_encoding_is_refused_with_the_one_that_is_needed(tmp_path, encoding):
    path = tmp_path / "mine.toml"
    path.write_text("# größe\n" + SHORT, encoding=encoding)
    with pytest.raises(rmj.ResonanceError, match=r"mine.toml: byte \d+ is not UTF-8"):
        rmj.load(path)


def test_a_file_of_windows_is_read(tmp_path):
    path = tmp_path / "mine.toml"
    path.write_text(SHORT, encoding="utf-8-sig", newline="\r\n")
    assert rmj.load(path) == rmj.load(written(tmp_path, SHORT))


def test_an_unknown_name_lists_those_that_exist():
    with pytest.raises(rmj.ResonanceError, match="did you mean 'paper'") as caught:
        rmj.load("papr")
    assert all(name in str(caught.value) for name in library.experiments())


@pytest.mark.parametrize("make", [Path.mkdir, Path.touch])
def test_what_lies_beside_a_file_is_not_taken_for_the_law_that_it_names(tmp_path, make):
    """As the folder of the run of an experiment that is called as its law: runs/paper."""
    make(tmp_path / "paper")
    (tmp_path / "mine.toml").write_text('[robot]\nmjcf = "two_link.xml"\n[law]\nkind = "paper"\n')
    assert rmj.load(tmp_path / "mine.toml").law.kind == "paper"


def test_a_section_that_is_given_as_a_dict_is_merged_and_an_empty_one_is_reset():
    paper = rmj.load("paper")
    assert paper.replace({"law": {"beta": 3.0}}) == paper.replace({"law.beta": 3.0})
    assert paper.replace({"law": {"beta": 3.0}}).law.k_v == paper.law.k_v != None  # noqa: E711
    reset = paper.replace({"law": {}, "expect": {}})
    assert reset.law == type(paper.law)()
    assert reset.springs == paper.springs
    changes = {"law": {}, "law.kind": "transfer"}
    assert paper.replace(changes).law.kind == "transfer"
    assert changes == {"law": {}, "law.kind": "transfer"}
    with pytest.raises(rmj.ResonanceError, match=r"law\.betta: unknown key"):
        paper.replace({"law": {"betta": 3.0}})
