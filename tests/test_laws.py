"""A law from outside the package runs through the same callback."""

import re
from pathlib import Path

import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj.experiments.loading import for_robot

PAGE = Path(__file__).parents[1] / "docs" / "custom-law.md"
PD = re.search(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)[1]


def run_with(tmp_path, text, duration=3.0, **options):
    path = tmp_path / "mine.py"
    path.write_text(text, encoding="utf-8")
    motion = [{"duration": duration, "size": (0.05, 0.05)}]
    changes = {"law.kind": str(path), "law.parameters": (2000.0, 200.0), "motion": motion}
    return rmj.simulate(for_robot("two_link.xml").replace(changes), **options)


def test_the_law_of_the_docs_runs_and_tracks(tmp_path):
    run = run_with(tmp_path, PD, duration=10.0)
    assert run.status is rmj.Status.OK
    assert run.data["tracking_rms"][-1] < 0.2 * run.data["tracking_rms"][1]
    assert (run.data["stiffness_per_cycle"][-1] >= 0).all()


def test_a_custom_command_is_what_the_motors_get(tmp_path):
    text = "def command(J, error, rate, q, dq, u, parameters, y, tau):\n"
    text += (
        "    for j in range(tau.size):\n        y[j] = q[j]\n        tau[j] = -2.0 * dq[j] + j\n"
    )
    data = run_with(tmp_path, text).data
    np.testing.assert_allclose(data["tau"], -2 * data["dq"] + [0, 1], rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(data["y"], data["q"])


def test_compiled_and_interpreted_custom_law_agree_to_the_last_bit(tmp_path):
    compiled, interpreted = (run_with(tmp_path, PD, interpret=i).data for i in (False, True))
    for name in ("q", "tau", "u", "stiffness"):
        np.testing.assert_array_equal(compiled[name], interpreted[name])


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x = 1\n", ["mine.py", "neither `command` nor `learn`"]),
        ("def command(J):\n    pass\n", ["mine.py", "command(J)", "error, rate"]),
        ("import nothing_like_this\n", ["mine.py", "cannot be imported", "nothing_like_this"]),
        (PD.replace("return v", "return 1, v"), ["mine.py", "learn returned shapes", "needed"]),
        (PD.replace("mean = q.mean", "mean = q.meen"), ["mine.py", "learn raised", "meen"]),
        (PD.replace("tau[j] = u", "tau[j] = nowhere + u"), ["cannot be compiled", "--interpret"]),
    ],
)
def test_a_law_that_does_not_fit_is_refused_in_one_line(tmp_path, text, words):
    with pytest.raises(rmj.ResonanceError) as caught:
        run_with(tmp_path, text)
    message = str(caught.value)
    assert "\n" not in message
    assert [word for word in words if word not in message] == []


def test_a_missing_law_is_named(tmp_path):
    with pytest.raises(rmj.ResonanceError, match=r"law.kind = 'no.py': no such file"):
        rmj.simulate(for_robot("two_link.xml").replace({"law.kind": "no.py"}))
