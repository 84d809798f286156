"""The report of a sweep: what its tables say is in the dataset, and the page opens anywhere."""

import html
import re

import numpy as np
import pytest
import xarray as xr
from test_sweep import SHORT

import resonance_mj as rmj
from resonance_mj.cli import main
from resonance_mj.experiments.sweeping import load_sweep

KEYS = {"law.beta": [2.0, 5.0, 60.0], "law.lead": [0, 1]}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A grid of which some runs diverge."""
    at = tmp_path_factory.mktemp("sweeps") / "grid"
    longer = SHORT.replace({"motion.0.duration": 12.0})
    rmj.sweep(longer, KEYS, folder=at, progress=False)
    return at


@pytest.fixture(scope="module")
def page(folder):
    return rmj.report(folder, progress=False).read_text()


def rows(page, table):
    """The cells of a table's body, as they are read."""
    start = page.index(f'aria-labelledby="{table}">\n<table')
    body = page[page.index("<tbody>", start) : page.index("</table>", start)]
    cells = [re.findall(r"<t[dh][^>]*>(.*?)</t[dh]>", row) for row in body.split("<tr>")[1:]]
    return [[html.unescape(re.sub("<.*?>", "", cell)) for cell in row] for row in cells]


def data_values(page, table):
    start = page.index(f'aria-labelledby="{table}">\n<table')
    body = page[start : page.index("</table>", start)]
    return [
        [float(value) for value in re.findall(r'<data value="([^"]+)"', row)]
        for row in body.split("<tr>")[2:]
    ]


def test_each_run_is_in_the_table_with_the_dataset_s_numbers(folder, page):
    data = xr.open_dataset(folder / "sweep.nc").load()
    found = rows(page, "all-table")
    assert len(found) == 6
    numbers = data_values(page, "all-table")
    for row, values in zip(found, numbers, strict=True):
        one = data.sel({"law.beta": float(row[0]), "law.lead": float(row[1]), "motion": 1})
        assert row[2] == str(one["status"].item())
        expected = [one["torque_reduction"], one["torque_reduction_optimal"]]
        expected += [one["torque_squared"], one["tracking_rms"]]
        finite = [float(value) for value in expected if np.isfinite(value)]
        assert values[: len(finite)] == pytest.approx(finite, rel=1e-6)


def test_the_best_is_the_one_that_leaves_least_of_those_that_are_ok(folder, page):
    data = xr.open_dataset(folder / "sweep.nc").load()
    well = data["torque_squared"].where(data["status"] == "ok")
    at = well.isel(motion=0).argmin(...)
    best = rows(page, "best-1")
    assert float(best[0][0]) == data["law.beta"][at["law.beta"]]
    assert float(best[0][1]) == data["law.lead"][at["law.lead"]]
    assert len(best) == min(5, int((data["status"] == "ok").sum()))


def test_runs_that_are_not_ok_are_counted_and_say_why(folder, page):
    data = xr.open_dataset(folder / "sweep.nc").load()
    counts = dict(zip(*np.unique(data["status"], return_counts=True), strict=True))
    assert counts["diverged"] > 0
    ended = {row[0]: row for row in rows(page, "ended-table")}
    for status, count in counts.items():
        assert f"{count} {status}" in page
        if status != "ok":
            assert ended[status.upper()][1] == str(count)
    first = str(data["message"].values[data["status"].values == "diverged"][0])
    assert first in ended["DIVERGED"][2]


def test_the_sweep_on_the_page_is_the_sweep(folder, page, tmp_path):
    text = html.unescape(re.search(r'<pre id="settings"[^>]*><code>(.*?)</code>', page, re.S)[1])
    (tmp_path / "again.toml").write_text(text)
    again = load_sweep(str(tmp_path / "again.toml"))
    assert again.values() == {"law.beta": KEYS["law.beta"], "law.lead": KEYS["law.lead"]}


def test_it_opens_without_a_word_and_without_a_network(folder, page, browser):
    said, asked = [], []
    opened = browser.new_page(viewport={"width": 390, "height": 800})
    opened.on("console", lambda message: said.append(message.text))
    opened.on("pageerror", lambda error: said.append(str(error)))
    opened.on("request", lambda request: asked.append(request.url.partition(":")[0]))
    opened.goto((folder / "report.html").as_uri())
    opened.wait_for_timeout(200)
    assert said == []
    assert set(asked) <= {"file", "data"}
    assert opened.evaluate("document.documentElement.scrollWidth") <= 390
    assert opened.locator("figure.drawing svg").count() == 2  # none is at its optimum in 12 cycles
    opened.close()


@pytest.mark.parametrize("how", ["sample", "refused"])
def test_samples_and_runs_that_could_not_begin_have_a_report(how, tmp_path):
    keys = {"law.beta": {"from": 2.0, "to": 6.0}}
    more = {"how": "sample", "count": 4}
    if how == "refused":
        keys, more = {"motion.0.center": [[5.0, 5.0], [6.0, 5.0]]}, {}
    given = SHORT if how == "sample" else SHORT.replace({"motion": [ELLIPSE]})
    rmj.sweep(given, keys, folder=tmp_path / "s", progress=False, **more)
    page = rmj.report(tmp_path / "s", tmp_path / "page.html", progress=False).read_text()
    found = rows(page, "all-table")
    assert len(found) == (4 if how == "sample" else 2)
    if how == "refused":
        assert "No run is ok" in page
        assert rows(page, "ended-table")[0][:2] == ["REFUSED", "2"]


ELLIPSE = {"duration": 3.0, "shape": "ellipse", "center": [-0.3, 0.0], "size": [0.05, 0.1]}


def test_a_sweep_stands_alone_and_its_settings_must_be_there(folder, tmp_path, capsys):
    assert main(["report", str(folder), str(folder)]) == 2
    assert "is a sweep" in capsys.readouterr().err
    copy = tmp_path / "copy"
    copy.mkdir()
    (copy / "sweep.nc").write_bytes((folder / "sweep.nc").read_bytes())
    for content in (None, "{", "[]", '{"experiment": "x"}'):
        if content is not None:
            (copy / "sweep.json").write_text(content)
        assert main(["report", str(copy)]) == 2
        said = capsys.readouterr().err
        assert "sweep.json" in said
        assert said.count("\n") == 1
    (copy / "sweep.json").write_text('{"experiment": "x", "keys": {"law.alpha": [1.0]}}')
    assert main(["report", str(copy)]) == 2
    assert "sweep.nc: lacks law.alpha" in capsys.readouterr().err
    (copy / "sweep.nc").write_bytes(b"nothing")
    (copy / "sweep.json").write_bytes((folder / "sweep.json").read_bytes())
    assert main(["report", str(copy)]) == 2
    assert not (copy / "report.html").exists()


def test_runs_that_ask_for_the_least_of_another_cost_are_judged_by_it(tmp_path):
    keys = {"law.eta": [0.3, 0.5, 0.8]}
    longer = SHORT.replace({"motion.0.duration": 12.0, "springs.cost": "energy", "law": {}})
    data = rmj.sweep(longer, keys, folder=tmp_path / "sweep", progress=False)
    assert data.attrs["cost"] == "energy"
    assert data["cost"].attrs["units"] == "W"
    page = rmj.report(tmp_path / "sweep", progress=False).read_text()
    assert "The runs that leave least electrical power in motion 1" in page
    assert "mean electrical power<br>[W]" in page
    assert "torque²" not in re.sub("<svg.*?</svg>", "", page, flags=re.DOTALL)
    best = [row[:1] for row in rows(page, "best-1")]
    cost = data["cost"].sel(motion=1)
    assert [float(row[0]) for row in best] == list(cost["law.eta"].values[np.argsort(cost.values)])
    # What costs less need not be what asks for less torque².
    mixed = {"springs.cost": ["torque-squared", "energy"]}
    data = rmj.sweep(SHORT, mixed, folder=tmp_path / "mixed", progress=False)
    assert data.attrs["cost"] == "torque-squared"
