"""A law from outside the package runs through the same callback."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import resonance_mj as rmj
from resonance_mj.callback.frozen import frozen
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


def test_laws_of_files_step_in_one_batch_with_others_each_by_its_own(tmp_path):
    damped = "def command(J, error, rate, q, dq, u, parameters, y, tau):\n    for j in range(2):\n"
    damped += "        y[j] = dq[j]\n        tau[j] = u[j] - {} * dq[j]\n"
    (tmp_path / "soft.py").write_text(damped.format("2.0"))
    (tmp_path / "hard.py").write_text(damped.format("30.0"))
    kinds = [str(tmp_path / "soft.py"), "transfer", str(tmp_path / "hard.py"), "joint-space"]
    motion = [{"duration": 2.0, "size": (0.05, 0.05)}]
    asked = [
        for_robot("two_link.xml").replace({"law.kind": kind, "motion": motion}) for kind in kinds
    ]
    alone = [rmj.simulate(one) for one in asked]
    for one, together in zip(alone, rmj.simulate_many(asked), strict=True):
        for name in ("q", "tau", "u", "stiffness"):
            np.testing.assert_array_equal(together.data[name], one.data[name])
    for one, gain in ((alone[0], 2.0), (alone[2], 30.0)):
        np.testing.assert_allclose(
            one.data["tau"], one.data["u"] - gain * one.data["dq"], atol=1e-9
        )


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("x = 1\n", ["mine.py", "neither `command` nor `learn`"]),
        ("learn = 5\n", ["mine.py", "learn is 5", "a function is needed"]),
        ("import sys\nsys.exit(0)\n", ["mine.py", "SystemExit", "line 2"]),
        ("def learn(u):\n    raise SystemExit\n", ["mine.py", "learn raised SystemExit", "line 2"]),
        ("def learn(u):\n    return learn(u)\n", ["mine.py", "learn raised RecursionError"]),
        ("def learn(u):\n    return None\n", ["mine.py", "learn raised TypeError"]),
        ("def learn(u, x):\n    pass\n", ["mine.py", "the argument 'x'", "bounds"]),
        ("def learn(\n", ["mine.py", "SyntaxError", "line 1"]),
        ("\0", ["mine.py", "cannot be executed"]),
        ("def command(J):\n    pass\n", ["mine.py", "command(J)", "error, rate"]),
        ("import nothing_like_this\n", ["mine.py", "cannot be executed", "nothing_like_this"]),
        (PD.replace("return total", "return 1, total"), ["mine.py", "learn returned", "needed"]),
        (PD.replace("q.mean", "q.meen"), ["mine.py", "learn raised", "meen"]),
        (
            PD.replace("tau[j] = u", "tau[j] = nowhere + u"),
            ["mine.py", "cannot be compiled", "'nowhere' is not defined in line 13", "--interpret"],
        ),
        (
            PD.replace("parameters[0]", "np.nothing(q)"),
            ["mine.py", "cannot be compiled: ", "nothing"],
        ),
        (PD.replace("u[j] - y[j]", "'a'"), ["mine.py: command cannot", "setitem(array"]),
        (PD.replace("total = u", "yield u"), ["mine.py: learn yields"]),
    ],
)
def test_a_law_that_does_not_fit_is_refused_in_one_line(tmp_path, text, words):
    with pytest.raises(rmj.ResonanceError) as caught:
        run_with(tmp_path, text)
    message = str(caught.value)
    assert "\n" not in message
    assert [word for word in words if word not in message] == []


FAILING = {
    "raises": "if q[0] < 9.0:\n        raise ValueError('no')",
    "leaves an array": "tau[0] = parameters[7]",
}


@pytest.mark.parametrize("failing", FAILING)
@pytest.mark.slow
def test_a_law_that_fails_within_a_step_ends_the_run_in_one_line(tmp_path, failing):
    """In processes of their own: the second has the machine code from disk, and no compiler."""
    text = "def command(J, error, rate, q, dq, u, parameters, y, tau):\n    " + FAILING[failing]
    (tmp_path / "mine.py").write_text(text + "\n")
    run = [sys.executable, "-m", "resonance_mj.cli", "run", "--robot", "two_link.xml"]
    run += ["--law.kind", "mine.py", "--motion.0.duration", "2"]
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path / "cache")}
    compiled, loaded, interpreted = (
        subprocess.run([*run, *more], cwd=tmp_path, env=environment, capture_output=True, text=True)
        for more in ([], [], ["--interpret"])
    )
    for done in (compiled, loaded):
        assert done.returncode == 2
        assert re.fullmatch(r"resonance-mj: mine.py: command raised an .*\n", done.stderr)
    assert interpreted.returncode == 2
    assert re.fullmatch(
        r"resonance-mj: mine.py: command raised \w+Error.* in line [23]\n", interpreted.stderr
    )
    assert not (tmp_path / "runs").exists()


@pytest.mark.slow
def test_a_law_that_allocates_runs_from_disk_too(tmp_path):
    text = DAMPER.format(read="import numpy as np", gain="np.full(3, -2.5)[j + 1]")
    (tmp_path / "mine.py").write_text(text)
    code = f"import sys; sys.path.insert(0, {str(Path(__file__).parent)!r}); import test_laws\n"
    code += "from pathlib import Path\nprint(test_laws.applied_gain(Path()))"
    environment = os.environ | {"XDG_CACHE_HOME": str(tmp_path / "cache")}
    for _ in range(2):
        done = subprocess.run(
            [sys.executable, "-c", code],
            cwd=tmp_path,
            env=environment,
            capture_output=True,
            text=True,
        )
        assert done.stdout == "-2.5\n", done.stderr


def test_a_helper_of_a_law_is_plain_python(tmp_path):
    read = "GAIN = -1.5\ndef helper(x):\n    return GAIN * x\n"
    text = DAMPER.format(read=read, gain="1.0").replace("1.0 * dq[j]", "helper(dq[j])")
    (tmp_path / "mine.py").write_text(text)
    assert applied_gain(tmp_path) == pytest.approx(-1.5)


DAMPER = """from pathlib import Path
{read}
def command(J, error, rate, q, dq, u, parameters, y, tau):
    for j in range(tau.size):
        y[j] = q[j]
        tau[j] = {gain} * dq[j]
"""


def applied_gain(folder):
    motion = [{"duration": 2.0, "size": (0.05, 0.05)}]
    changes = {"law.kind": str(folder / "mine.py"), "motion": motion}
    data = rmj.simulate(for_robot("two_link.xml").replace(changes)).data
    return float((data["tau"] / data["dq"])[100, 0])


@pytest.mark.parametrize(
    ("read", "gain", "file"),
    [
        ('GAIN = float((Path(__file__).parent / "gain.py").read_text())', "GAIN", "{}"),
        ("from gain import GAIN", "GAIN", "GAIN = {}"),
        ("import gain", "gain.GAIN", "GAIN = {}"),
        (
            "from gain import GAINS",
            "GAINS.a",
            "from collections import namedtuple\n"
            "GAINS = namedtuple('Gains', 'a b' if {} == -2.0 else 'b a')(-2.0, -3.0)",
        ),
    ],
)
@pytest.mark.slow
def test_what_a_law_reads_or_imports_counts_in_each_run(tmp_path, read, gain, file):
    (tmp_path / "mine.py").write_text(DAMPER.format(read=read, gain=gain))
    for number in (-2.0, -3.0):
        (tmp_path / "gain.py").write_text(file.format(number))
        assert applied_gain(tmp_path) == pytest.approx(number)


@pytest.mark.parametrize(
    "text",
    [
        "GAIN = np.zeros(200_000)\ndef command(): return GAIN[0]",  # compiled as its address
        "import numba\n@numba.njit\ndef f(x): return x\ndef command(): return f(1.0)",
        "from numba import njit\n@njit\ndef f(x): return x\ndef command(): return f(1.0)",
        "class A:\n    b = 1\ndef command(): return A.b",
    ],
)
def test_what_the_code_of_a_law_does_not_tell_is_not_kept(text):
    module = {"np": np, "__name__": "mine"}
    exec(text, module)
    assert frozen(module["command"]) is None


def test_a_law_that_is_the_same_as_before_is_not_compiled_again(tmp_path, monkeypatch):
    (tmp_path / "mine.py").write_text(DAMPER.format(read="GAIN = -2.5", gain="GAIN"))
    assert applied_gain(tmp_path) == pytest.approx(-2.5)
    monkeypatch.setattr(
        "resonance_mj.callback.compilation.translate", lambda *_: pytest.fail("compiled")
    )
    assert applied_gain(tmp_path) == pytest.approx(-2.5)


def test_an_edited_law_is_read_again_within_a_process(tmp_path):
    for step in (1.0, 5.0):
        text = "def learn(u, stiffness, offset, center):\n"
        text += f"    return u, stiffness + {step}, offset, center\n"
        data = run_with(tmp_path, text).data
        np.testing.assert_array_equal(data["stiffness_per_cycle"][-1], step)


def test_the_process_keeps_the_modules_that_it_had(tmp_path, monkeypatch):
    monkeypatch.syspath_prepend(str(tmp_path))
    (tmp_path / "gain.py").write_text("GAIN = -2.0")
    gain = __import__("gain")
    path = list(sys.path)
    (tmp_path / "mine.py").write_text(DAMPER.format(read="from gain import GAIN", gain="GAIN"))
    applied_gain(tmp_path)
    assert sys.modules["gain"] is gain
    assert sys.path == path
    # Nor does a law take the process's module of a name that its own folder has.
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "mine.py").write_text((tmp_path / "mine.py").read_text())
    (tmp_path / "other" / "gain.py").write_text("GAIN = -3.0")
    assert applied_gain(tmp_path / "other") == -3.0
    assert sys.modules.pop("gain") is gain


def test_a_missing_law_is_named(tmp_path):
    with pytest.raises(rmj.ResonanceError, match=r"law.kind = 'no.py': does not exist"):
        rmj.simulate(for_robot("two_link.xml").replace({"law.kind": "no.py"}))


def test_only_what_simulates_executes_a_law_s_file_and_says_so_first(tmp_path, capsys):
    """A stranger's run is opened, drawn, judged and reported without its code."""
    from resonance_mj import cli

    mine, traces = tmp_path / "mine.py", tmp_path / "traces"
    trace = f"with open({str(traces)!r}, 'a') as file:\n    file.write('executed ')\n"
    mine.write_text(trace + PD)
    folder = tmp_path / "run"
    keys = ["--robot", "two_link.xml", "--law.kind", str(mine), "--motion.0.duration", "10"]
    keys += ["--law.parameters", "2000,200", "--motion.0.size", "0.05,0.05"]
    cli.main(["run", *keys, "--out", str(folder)])
    assert traces.read_text() == "executed "
    assert "executes the code of" in " ".join(capsys.readouterr().out.split())
    traces.unlink()
    for command in (["plot", str(folder)], ["certify", str(folder)], ["springs", str(folder)],
                    ["report", str(folder), "--no-video"], ["optimum", *keys]):  # fmt: skip
        assert cli.main(command) == 0
    run = rmj.Run.load(folder)
    assert Path(run.plan.law.file).parent.parent == folder  # a copy travels with the run
    rmj.optimum(run.experiment)
    assert not traces.exists()
