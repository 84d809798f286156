"""Words and numbers: short, exact, and in the unit that suits them."""

import pickle

import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj import text


@pytest.mark.parametrize(
    ("value", "said"),
    [
        (3.0, "3.0"),
        ("up", "'up'"),
        (rmj.Status.OK, "'ok'"),
        ((-1.0, 1.0), "[-1.0, 1.0]"),
        (((0.1,), ()), "[[0.1], []]"),
        ([[[0.125]]], "[[[0.125]]]"),
        (np.float64(0.1), "0.1"),
        (np.array([1, 2]), "[1, 2]"),
        ({"a": 1}, "{ a = 1 }"),
        (range(3), "range(0, 3)"),
    ],
)
def test_a_short_value_is_shown_as_it_would_be_written(value, said):
    assert text.shown(value) == said


@pytest.mark.parametrize(
    "value",
    [
        "x" * 700_000,
        [0.1] * 100_000,
        [[0.1] * 100_000] * 1000,
        {str(key): 0 for key in range(100_000)},
        {"x" * 100_000: 0},
        1 << 100_000,
        b"\0" * 100_000,
        "\n" * 100,
        "\udc80",
    ],
    ids=[*range(9)],
)
def test_no_value_takes_more_than_a_glance_or_breaks_the_line(value):
    said = text.shown(value)
    assert len(said) <= 80
    assert said.isprintable()


def test_a_list_that_is_cut_says_how_long_it_is():
    assert text.shown([0.5] * 1000).startswith("[0.5, 0.5")
    assert "1000 in all" in text.shown([0.5] * 1000)


@pytest.mark.parametrize(
    ("said", "wanted"),
    [
        (text.listed(["a", "", "b"]), "a, b"),
        (text.listed([]), "none"),
        (text.listed(map(str, range(1000)), most=2), "0, 1, … 1000 in all"),
        (text.joined(["a"]), "a"),
        (text.joined(["a", "b", "c"]), "a, b and c"),
        (text.nearest("bta", ["beta", "eta"]), " (did you mean 'beta'?)"),
        (text.number(-0.0001), "0.000"),
        (text.number(2.5e7), "2.5e+07"),
        (text.number(float("nan")), "–"),
        (text.percent(0.9801), "98.0\u202f%"),
        (text.percent(None), "–"),
        (text.length(2.0), "2.00\u202fm"),
        (text.length(0.0132), "13.2\u202fmm"),
        (text.length(2.9e-4), "0.290\u202fmm"),
        (text.length(3e-8), "30.0\u202fnm"),
        (text.length(-3e-5), "-30.0\u202fµm"),
        (text.length(0.0), "0\u202fm"),
        (text.angle(0.25), "250\u202fmrad"),
        (text.duration(20.0), "20 s"),
        (text.duration(7200.0), "2 h"),
        (text.duration(1e12), "3.17e+04 years"),
        (text.minus("-3 to 4e-05, two-link"), "−3 to 4e−05, two-link"),
        (text.of_joint("k [N m/rad]", True), "k [N/m]"),
    ],
)
def test_words_and_numbers_read_well(said, wanted):
    assert said == wanted


def test_runs_of_one_name_are_told_apart_by_what_differs():
    paper = {"name": "paper", "law": {"beta": 1.0, "q_c": (0.0, 1.5)}}
    other = {"name": "paper", "law": {"beta": 3.0, "q_c": (0.0, 1.5)}}
    labels = text.told_apart(["paper", "paper", "mine", "paper"], [paper, other, paper, paper])
    assert labels == ["paper, law.beta 1 (1)", "paper, law.beta 3", "mine", "paper, law.beta 1 (2)"]


def test_every_error_is_one_line_that_can_be_read_and_survives_a_process_boundary():
    error = rmj.ResonanceError(f"two\nlines \x1b[31m {'x' * 100_000} … at last 0.3\u202fmm")
    assert len(str(error).splitlines()) == 1
    assert "\x1b" not in str(error)
    assert len(str(error)) <= 2000
    assert str(error).endswith("at last 0.3\u202fmm")
    assert str(pickle.loads(pickle.dumps(error))) == str(error)
