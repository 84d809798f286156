"""Many experiments as one dataset: the same runs as one by one, and nothing lost on the way."""

import csv
import json
import os
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
import xarray as xr

import resonance_mj as rmj
from resonance_mj.cli import main
from resonance_mj.experiments.sweeping import load_sweep
from resonance_mj.pictures.figures import sweep_figure

SHORT = (
    rmj.load("two-link-transfer")
    .replace(
        {"motion": [rmj.load("two-link-transfer").model_dump(exclude_unset=True)["motion"][0]]}
    )
    .replace({"motion.0.duration": 4.0})
)
BETAS = [2.0, 5.0, 10.0]


def written(tmp_path, text, name="mine.toml"):
    (tmp_path / "short.toml").write_text(SHORT.to_toml())
    path = tmp_path / name
    path.write_text('experiment = "short.toml"\n' + text)
    return path


def test_a_grid_has_a_dimension_of_each_key_and_the_figures_of_each_run_alone():
    data = rmj.sweep(SHORT, {"law.beta": BETAS, "law.lead": [1, 2]})
    assert dict(data.sizes) == {"law.beta": 3, "law.lead": 2, "motion": 1, "joint": 2, "cycle": 4}
    assert data["law.beta"].values.tolist() == BETAS
    for beta in BETAS:
        for lead in (1, 2):
            run = rmj.simulate(SHORT.replace({"law.beta": beta, "law.lead": lead}))
            (segment,) = run.summary()["segments"]
            at = data.sel({"law.beta": beta, "law.lead": lead, "motion": 1})
            assert at["status"] == "ok"
            for name in ("torque_squared", "torque_reduction", "tracking_rms"):
                assert float(at[name]) == segment[name]
            assert at["stiffness"].values.tolist() == segment["stiffness"]
            per_cycle = run.data["torque_squared"].values.tolist()
            assert at["torque_squared_per_cycle"].values.tolist() == per_cycle
    assert data["torque_squared"].attrs["units"] == "N^2 m^2"


def test_runs_that_diverge_or_cannot_begin_disturb_no_other():
    keys = {"motion.0.offset": [[-0.3, 0.0], [-9.0, 0.0], [-0.25, 0.05]]}
    data = rmj.sweep(SHORT, keys)
    assert data["status"].values.tolist() == ["ok", "refused", "ok"]
    assert "reach" in str(data["message"].values[1])
    assert np.isnan(data["torque_squared"].values[1]).all()
    alone = rmj.simulate(SHORT.replace({"motion.0.offset": [-0.25, 0.05]}))
    assert data["torque_squared"].values[2, 0] == alone.summary()["segments"][0]["torque_squared"]


def test_the_order_of_the_values_orders_the_results_and_nothing_else():
    one, other = (rmj.sweep(SHORT, {"law.beta": betas}) for betas in (BETAS, BETAS[::-1]))
    names = ("torque_squared", "tracking_rms", "stiffness", "torque_squared_per_cycle")
    for name in names:
        np.testing.assert_array_equal(one[name].values, other[name].values[::-1])


def test_a_zip_goes_through_its_keys_together_and_a_sample_covers_its_ranges(tmp_path):
    zipped = written(
        tmp_path,
        'how = "zip"\n[keys]\nlaw.beta = [5.0, 10.0]\nmotion.0.duration = [3.0, 4.0]\n',
    )
    data = rmj.sweep(zipped)
    assert data.sizes["run"] == 2
    assert data["motion.0.duration"].values.tolist() == [3.0, 4.0]
    assert np.isnan(data["torque_squared_per_cycle"].values[0, 3])
    text = 'how = "sample"\ncount = 64\nseed = 3\n[keys]\n'
    text += 'law.beta = { from = 1.0, to = 100.0, scale = "log" }\nlaw.lead = [1, 2]\n'
    points = load_sweep(str(written(tmp_path, text))).points()
    beta = np.array([point["law.beta"] for point in points])
    # A Sobol sample: as many in each eighth of the logarithm.
    assert np.bincount((8 * np.log(beta) / np.log(100)).astype(int)).tolist() == [8] * 8
    assert sum(point["law.lead"] == 1 for point in points) == 32
    again = load_sweep(str(written(tmp_path, text))).points()
    assert again == points
    other = load_sweep(str(written(tmp_path, text.replace("seed = 3", "seed = 4")))).points()
    assert other != points


def test_a_sweep_of_a_file_is_written_for_other_programs_and_drawn(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    text = "[keys]\nlaw.beta = { from = 2.0, to = 8.0, count = 3, scale = 'log' }\nlaw.lead = [1]\n"
    written(tmp_path, text)
    assert main(["sweep", "mine.toml", "--dry-run"]) == 0
    assert "3 experiments, 1.2e+04 time steps" in capsys.readouterr().out
    assert main(["sweep", "mine.toml", "--quiet"]) == 0
    folder = tmp_path / "runs" / "mine"
    assert {path.name for path in folder.iterdir()} == {"sweep.nc", "summary.csv", "sweep.json"}
    with xr.open_dataset(folder / "sweep.nc") as data:
        assert data["law.beta"].values.tolist() == [2.0, 4.0, 8.0]
    rows = list(csv.DictReader((folder / "summary.csv").read_text().splitlines()))
    assert [row["law.beta"] for row in rows] == ["2.0", "4.0", "8.0"]
    assert all(row["status"] == "ok" for row in rows)
    capsys.readouterr()
    assert main(["plot", str(folder), "--format", "png", "--dpi", "50"]) == 0
    assert (folder / "torque_share.png").stat().st_size > 3000
    assert main(["plot", str(folder), "--figure", "speed"]) == 2
    assert "metric 'speed' is unknown" in capsys.readouterr().err
    assert main(["sweep", "mine.toml", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["status"] == {"ok": 3}


KILLED = """
import sys, resonance_mj as rmj
from resonance_mj.sweeps import sweep
sweep.SHARD = 2
rmj.sweep(sys.argv[1], folder=sys.argv[2], progress=lambda *_: print("shard", flush=True))
"""


@pytest.mark.slow
def test_a_sweep_that_is_killed_goes_on_and_ends_with_the_same_bits(tmp_path):
    path = written(
        tmp_path, "[keys]\nlaw.beta = [2.0, 3.0, 4.0, 5.0, 6.0, 7.0]\nlaw.lead = [1, 2]\n"
    )

    def start(folder):
        arguments = [sys.executable, "-c", KILLED, str(path), str(tmp_path / folder)]
        return subprocess.Popen(arguments, stdout=subprocess.PIPE, text=True)

    whole = start("whole")
    assert whole.communicate(timeout=120)[0].count("shard") == 6
    finished = 0
    for after in (1, 2):
        process = start("killed")
        for _ in range(finished + after):
            assert process.stdout.readline() == "shard\n"
        time.sleep(0.02 * after)
        os.kill(process.pid, signal.SIGKILL)
        process.communicate()
        finished = len(list((tmp_path / "killed" / "shards").glob("[!.]*")))
        assert finished >= after
    assert start("killed").communicate(timeout=120)[0].count("shard") == 6
    for name in ("sweep.nc", "summary.csv", "sweep.json"):
        one, other = ((tmp_path / folder / name).read_bytes() for folder in ("whole", "killed"))
        assert one == other
    assert not (tmp_path / "killed" / "shards").exists()


def test_a_folder_is_of_one_sweep_and_a_finished_one_is_not_simulated_again(tmp_path):
    path = written(tmp_path, "[keys]\nlaw.beta = [5.0]\n")
    first = rmj.sweep(path, folder=tmp_path / "out")
    (tmp_path / "out" / "shards" / ".of-a-killed-one").mkdir(parents=True)
    asked = []
    again = rmj.sweep(path, folder=tmp_path / "out", progress=lambda *done: asked.append(done))
    assert asked == []
    assert not (tmp_path / "out" / "shards").exists()
    xr.testing.assert_identical(first, again)
    written(tmp_path, "[keys]\nlaw.beta = [6.0]\n")
    with pytest.raises(rmj.ResonanceError, match="holds another sweep"):
        rmj.sweep(path, folder=tmp_path / "out")
    (tmp_path / "other").mkdir()
    (tmp_path / "other" / "thesis.tex").write_text("")
    with pytest.raises(rmj.ResonanceError, match="not empty"):
        rmj.sweep(path, folder=tmp_path / "other")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("[keys]\nlaw.bta = [1.0]\n", ["law.bta", "beta"]),
        ("[keys]\nlaw.beta = [-1.0]\n", ["law.beta = -1"]),
        ("[keys]\nlaw.beta = []\n", ["keys.law.beta", "at least one"]),
        ("[keys]\n", ["keys"]),
        ("", ["keys", "missing"]),
        ("[keys]\nlaw.beta = { from = 3, to = 2, count = 4 }\n", ["from 3 to 2"]),
        ("[keys]\nlaw.beta = { from = 0, to = 2, count = 4, scale = 'log' }\n", ["above 0"]),
        ("[keys]\nlaw.beta = { from = 1, to = 2 }\n", ["needs a count"]),
        ("[keys]\nlaw.beta = { from = 1, count = 2 }\n", ["keys.law.beta.to", "missing"]),
        (f"[keys]\nlaw.beta = {'[' * 5000}{']' * 5000}\n", ["nested too deeply"]),
        (f"[keys]\n{'.'.join(['a'] * 3000)} = [1]\n", ["nested too deeply"]),
        ("how = 'zip'\n[keys]\nlaw.beta = [1]\nlaw.lead = [1, 2]\n", ["law.lead has 2"]),
        ("how = 'sample'\n[keys]\nlaw.beta = {from = 1, to = 2}\n", ["needs count"]),
        ("how = 'grd'\n[keys]\nlaw.beta = [1]\n", ["how", "grid"]),
        (
            "[keys]\nlaw.beta = {from = 1, to = 2, count = 2000}\n"
            "law.eta = {from = 0, to = 1, count = 2000}\n",
            ["4000000 experiments", "--yes"],
        ),
    ],
)
def test_a_sweep_that_cannot_be_is_refused_in_a_line(tmp_path, capsys, text, words):
    path = written(tmp_path, text)
    assert main(["sweep", str(path), "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert said.count("\n") == 1
    assert all(word in said for word in words), said
    assert not (tmp_path / "out").exists()


def test_the_sweeps_that_come_with_the_program_can_be_made():
    for name in ("gains", "tempo"):
        sweep = load_sweep(name)
        assert len(sweep.experiments()) == sweep.size > 5


def test_what_is_predicted_to_diverge_is_beside_what_did(tmp_path):
    settings = {"experiment": "two-link-transfer", "predict": True}
    fixed = {"law.kind": "learning", "motion.0.duration": 60.0, "motion.1.duration": 2.0}
    keys = {"law.beta": [2.0, 40.0], "law.lead": [1, 2]}
    path = tmp_path / "sweep.toml"
    lines = [f"{key} = {json.dumps(value)}" for key, value in settings.items()]
    lines += ["[fixed]", *(f"{key} = {json.dumps(value)}" for key, value in fixed.items())]
    lines += ["[keys]", *(f"{key} = {json.dumps(value)}" for key, value in keys.items())]
    path.write_text("\n".join(lines))
    data = rmj.sweep(path)
    diverged = (data["status"] == "diverged").values
    np.testing.assert_array_equal(diverged, [[False, False], [True, True]])
    np.testing.assert_array_equal(data["predicted_to_diverge"].values, diverged)
    (file, *_) = rmj.plot(data, tmp_path, figures=["torque_squared"], formats=["svg"])
    assert "diverges beyond the line" in file.read_text(encoding="utf-8")
    drawn = sweep_figure.figure(data, "torque_squared", 7.16)
    ends = [line.get_xydata().tolist() for line in drawn.axes[0].lines]
    assert ends == [[[1, 0], [1, 1]], [[1, 1], [1, 2]]]


def test_seeds_are_a_spread_about_their_median(tmp_path):
    one = rmj.load("two-link-transfer").motion[0].model_dump() | {"duration": 20.0, "blend": 1}
    base = rmj.load("two-link-transfer").replace({"law": {}, "motion": [one]})
    keys = {"reality.encoder_noise": [1e-4, 1e-3], "reality.seed": [0, 1, 2]}
    data = rmj.sweep(base, keys)
    assert (data["status"] == "ok").all()
    of_motion = data["tracking_rms"].sel(motion=1)
    assert of_motion.std("reality.seed").min() > 0
    ax = sweep_figure.figure(data, "tracking_rms", 7.16).axes[0]
    (line, *_) = ax.lines
    np.testing.assert_allclose(line.get_ydata(), of_motion.median("reality.seed"))
    (band,) = ax.collections
    low, high = band.get_paths()[0].vertices[:, 1].min(), band.get_paths()[0].vertices[:, 1].max()
    assert (low, high) == pytest.approx((float(of_motion.min()), float(of_motion.max())))
    assert ax.get_xlabel() == "reality.encoder_noise"


def test_a_key_that_varies_and_changes_nothing_is_refused_with_why():
    with pytest.raises(rmj.ResonanceError, match=r"law\.eta has no effect: law\.beta is given"):
        rmj.sweep(SHORT, {"law.eta": [0.2, 0.5]})
    # In some of the runs it has.
    data = rmj.sweep(SHORT, {"law.kind": ["transfer", "computed-torque"], "law.beta": [2.0, 5.0]})
    assert data.sizes["law.beta"] == 2


def test_runs_of_a_sample_are_points_and_no_line_in_the_order_in_which_they_were_drawn():
    among = {"law.beta": {"from": 2.0, "to": 6.0}}
    sample = rmj.sweep(SHORT, among, how="sample", count=4, progress=False)
    grid = rmj.sweep(SHORT, {"law.beta": BETAS}, progress=False)

    def joined(data):
        (ax,) = sweep_figure.figure(data, "torque_share", 3.5).axes
        longest = max(ax.lines, key=lambda line: len(line.get_xdata()))
        return longest.get_linestyle() not in ("None", "", " ")

    assert joined(grid)
    assert not joined(sample)


@pytest.mark.parametrize("keys", [["law.beta"], ["law.beta", "law.lead"]])
def test_numbers_along_logarithmic_axes_are_plain(keys):
    values = {"law.beta": [1.0, 4.0, 16.0], "law.lead": [0.0, 1.0]}
    shape = [len(values[key]) for key in keys]
    rms = np.geomspace(1e-6, 1e-2, int(np.prod(shape))).reshape(*shape, 1)
    data = xr.Dataset(
        {"tracking_rms": ([*keys, "motion"], rms), "status": (keys, np.full(shape, "ok"))},
        coords={key: values[key] for key in keys} | {"motion": [1]},
        attrs={"title": "resonance-mj sweep of this"},
    )
    drawn = sweep_figure.figure(data, "tracking_rms", 3.5)
    drawn.draw_without_rendering()
    of_axes = [label.get_text() for ax in drawn.axes for label in ax.get_yticklabels(which="both")]
    of_axes += [label.get_text() for ax in drawn.axes for label in ax.get_xticklabels(which="both")]
    assert "0.0001" in of_axes
    assert not any("$" in text for text in of_axes)
