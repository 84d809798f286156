"""The search for the best keys: what it finds, keeps to, resumes and refuses."""

import subprocess
import sys

import numpy as np
import pytest
import xarray as xr

import resonance_mj as rmj
from resonance_mj.errors import ExperimentError

FIRST = rmj.load("two-link-transfer").model_dump(exclude_unset=True)["motion"][0]
BASE = rmj.load("two-link-transfer").replace({"law": {}, "motion": [FIRST | {"duration": 12.0}]})
ETA = {"law.eta": {"from": 0.05, "to": 1.2}}


def tuned(keys=ETA, base=BASE, **how):
    return rmj.tune(
        base, keys, **{"minimize": "tracking_rms", "trials": 32, "progress": False} | how
    )


@pytest.fixture(scope="module")
def errors():
    """The tracking error over η, on a grid."""
    eta = np.linspace(0.05, 1.2, 47).tolist()
    data = rmj.sweep(BASE, {"law.eta": eta}, progress=False)
    return eta, data["tracking_rms"].max("motion").where(data["status"] == "ok").values


def test_it_finds_what_a_fine_grid_finds(errors):
    found = tuned()
    eta, rms = errors
    ok = rms[np.isfinite(rms)].min()
    assert found.value <= 1.1 * ok
    assert found.keys["law.eta"] == pytest.approx(eta[int(np.nanargmin(rms))], abs=0.15)
    run = rmj.simulate(found.experiment)
    assert max(motion.tracking_rms[-1] for motion in run.motions) == found.value
    assert found.data.sizes["run"] == 32
    assert float(found.data["objective"][found.data.attrs["best"]]) == found.value


@pytest.mark.slow
def test_what_is_beyond_a_constraint_is_never_the_best(errors):
    _, rms = errors
    level = float(np.nanquantile(rms, 0.5))
    found = tuned(
        maximize="tracking_rms", minimize=None, constraints={"tracking_rms": {"max": level}}
    )
    worst = found.data["tracking_rms"].max("motion")
    assert 0.5 * level < float(worst[found.data.attrs["best"]]) <= level
    assert not found.data["feasible"].where(worst > level, False).any()
    assert (worst > level).any()


def test_lists_and_counted_ranges_are_tried_by_their_values():
    keys = {"law.lead": [1, 3], "law.eta": {"from": 0.4, "to": 0.8, "count": 3}}
    data = tuned(keys, trials=16).data
    assert set(data["law.lead"].values) <= {1.0, 3.0}
    assert set(data["law.eta"].values) <= {0.4, 0.6, 0.8}


def test_runs_that_diverge_or_cannot_begin_are_no_best():
    keys = {"motion.0.offset": [[-0.3, 0.0], [-9.0, 0.0]], "motion.0.period": [1.0, 0.3333]}
    found = tuned(keys, trials=16)
    assert found.keys == {"motion.0.offset": [-0.3, 0.0], "motion.0.period": 1.0}
    assert {"refused", "ok"} <= set(found.data["status"].values.tolist())


def test_where_nothing_is_within_the_constraints_nothing_is_found(tmp_path):
    within = {"tracking_rms": {"max": 0.0}}
    found = tuned(trials=4, constraints=within, folder=tmp_path / "out")
    assert not (tmp_path / "out" / "best.toml").exists()
    assert found.keys == {}
    assert np.isnan(found.value)
    assert found.experiment == BASE


@pytest.mark.slow
def test_an_interrupted_search_goes_on_and_ends_with_the_same_bits(tmp_path):
    whole = tuned(folder=tmp_path / "whole")

    def stopping(done, total, bad):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        tuned(folder=tmp_path / "cut", progress=stopping)
    (kept,) = (tmp_path / "cut" / "shards").iterdir()
    before = kept.stat().st_mtime_ns
    again = tuned(folder=tmp_path / "cut")
    assert again.data.identical(whole.data)
    assert kept.stat().st_mtime_ns == before
    for name in ("sweep.nc", "summary.csv", "best.toml"):
        both = [(tmp_path / one / name).read_bytes() for one in ("whole", "cut")]
        assert both[0] == both[1]
    with pytest.raises(rmj.ResonanceError, match="holds another sweep"):
        tuned(folder=tmp_path / "cut", seed=1)


@pytest.mark.slow
def test_the_command_writes_an_experiment_that_is_the_best(tmp_path):
    (tmp_path / "short.toml").write_text(BASE.to_toml())
    (tmp_path / "eta.toml").write_text(
        'experiment = "short.toml"\nminimize = "tracking_rms"\ntrials = 16\n'
        "[keys]\nlaw.eta = { from = 0.05, to = 1.2 }\n"
    )
    command = [sys.executable, "-m", "resonance_mj", "tune", "eta.toml", "--out", "out"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
    assert "best: tracking_rms = " in done.stdout
    assert done.stderr.count("\n") <= 2  # the bar
    best = rmj.load(tmp_path / "out" / "best.toml")
    run = rmj.simulate(best)
    with xr.open_dataset(tmp_path / "out" / "sweep.nc") as data:
        least = float(data["objective"].where(data["feasible"]).min())
    assert max(motion.tracking_rms[-1] for motion in run.motions) == least


@pytest.mark.parametrize(
    ("how", "words"),
    [
        ({"minimize": "tracking_rm"}, "'tracking_rm' is no figure of a motion (did you mean"),
        ({"minimize": None}, "give either minimize or maximize"),
        ({"maximize": "tracking_rms"}, "give either minimize or maximize"),
        ({"constraints": {"tracking_rms": {}}}, "give min, max, or both"),
        ({"constraints": {"speed": {"max": 1.0}}}, "'speed' is no figure"),
        ({"keys": {"law.eta": []}}, "at least one value"),
        ({"keys": {"law.etta": [1.0]}}, "law.etta"),
        ({"keys": {"law.eta": {"from": -3.0, "to": 1.0}}}, "law.eta = -3.0"),
        ({"trials": 0}, "trials = 0"),
        ({"keys": {"law.gamma_qe": [1.0], "law.overestimate": [0.1]}}, "law.overestimate has no"),
    ],
)
def test_what_cannot_be_looked_for_is_refused_in_one_line(how, words):
    with pytest.raises(ExperimentError) as refused:
        tuned(**how)
    assert words in str(refused.value)
    assert "\n" not in str(refused.value)
