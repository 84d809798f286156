"""Reports as a reader gets them: opened from disk in a real browser, printed, and their errors."""

import base64
import dataclasses
import hashlib
import io
import json
import re
import shutil
import subprocess
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from conftest import BROWSERS
from PIL import Image

import resonance_mj as rmj
from resonance_mj import cli
from resonance_mj.errors import OutputError
from resonance_mj.experiments.loading import for_robot
from resonance_mj.pictures import palette
from resonance_mj.pictures.figures import catalogue
from resonance_mj.pictures.film import crew
from resonance_mj.pictures.page import film
from resonance_mj.pictures.page.scene import BUNDLE

PHONE, DESK = 360, 1280


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """The paper's arm for five cycles of each motion, under the paper's law and the transfer."""
    short = {"motion.0.duration": 5.0, "motion.1.duration": 5.0}
    found = []
    for name in ("paper", "two-link-transfer"):
        run = rmj.simulate(rmj.load(name).replace(short))
        found.append(run.save(tmp_path_factory.mktemp("runs") / name))
    return found


@pytest.fixture(scope="module")
def small():
    """Films of few and small frames."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(film, "SIZES", {1: (320, 180), 2: (480, 180)})
        patch.setattr(film, "FPS", 1.0)
        patch.setattr(crew, "cores", lambda: 1)  # getting ready takes longer than so few frames
        yield


@contextmanager
def few_figures():
    """Two figures of a run, and that of several: drawing all takes seconds."""
    chosen = [
        each for each in catalogue.FIGURES if each.name in ("cycles", "springs", "convergence")
    ]
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(catalogue, "FIGURES", tuple(chosen))
        yield


@pytest.fixture
def few():
    with few_figures():
        yield


@pytest.fixture(scope="module")
def single(folders, small):
    with few_figures():
        return rmj.report(folders[0])


@pytest.fixture(scope="module")
def comparison(folders, small):
    with few_figures():
        return rmj.report(folders)


class Opened:
    """A page in a browser, and all that it said and asked for."""

    def __init__(self, browser, path, width=DESK, scheme="light"):
        self.context = browser.new_context(
            viewport={"width": width, "height": 800}, color_scheme=scheme
        )
        self.said, self.asked, self.failed = [], [], []
        page = self.page = self.context.new_page()
        page.on("console", lambda message: self.said.append(message.text))
        page.on("pageerror", lambda error: self.said.append(str(error)))
        page.on("request", lambda request: self.asked.append(request.url))
        page.on("requestfailed", lambda request: self.failed.append(request.url[:100]))
        page.goto(path.resolve().as_uri())

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.context.close()

    def __call__(self, script):
        return self.page.evaluate(script)

    def until(self, script):
        """Wait for what a script says; the page's own policy forbids it to wait in the page."""
        for _ in range(200):
            if self(script):
                return
            self.page.wait_for_timeout(50)
        raise AssertionError(f"never: {script}")


@pytest.mark.parametrize("which", ["single", pytest.param("comparison", marks=pytest.mark.slow)])
def test_a_report_opens_from_disk_without_a_word_and_without_a_network(browser, which, request):
    with Opened(browser, request.getfixturevalue(which)) as opened:
        opened.page.wait_for_timeout(300)
        assert opened.said == []
        assert opened.failed == []
        assert {url.partition(":")[0] for url in opened.asked} <= {"file", "data"}
        # One file: the page itself, and nothing beside it.
        assert sum(url.startswith("file:") for url in opened.asked) == 1


@pytest.mark.opengl
@pytest.mark.parametrize(
    ("which", "width"),
    [
        pytest.param(which, width, marks=pytest.mark.slow)
        for which, width in (("single", 320), ("comparison", 480))
    ],
)
def test_the_video_plays_and_its_scenes_can_be_gone_to(browser, which, width, request):
    with Opened(browser, request.getfixturevalue(which)) as opened:
        if not opened("document.createElement('video').canPlayType('video/mp4; codecs=avc1')"):
            pytest.skip("this Chromium was built without H.264")
        opened.until("document.querySelector('video').readyState >= 2")
        shown = "document.querySelector('video')"
        assert opened(f"[{shown}.videoWidth, {shown}.videoHeight]") == [width, 180]
        # Two cycles of a second each at the start and the end, and four about the change.
        assert opened(f"{shown}.duration") == pytest.approx(8.0, abs=0.1)
        opened(f"{shown}.play()")
        opened.until(f"{shown}.currentTime > 0.3")
        assert opened(f"{shown}.error") is None
        opened(f"{shown}.pause()")
        opened.page.click(".scenes button:last-child")
        begins = float(opened.page.get_attribute(".scenes button:last-child", "data-at"))
        assert opened(f"{shown}.currentTime") == pytest.approx(begins, abs=0.05)


SCENE = "document.querySelector('#scene')"
DRAWN = f"+({SCENE}.querySelector('canvas').dataset.drawn || 0)"


@pytest.fixture(params=[pytest.param(PHONE, marks=pytest.mark.slow), DESK])
def scene(request, browser, single):
    """A report whose scene has been drawn."""
    with Opened(browser, single, request.param) as opened:
        opened(f"{SCENE}.scrollIntoView()")
        opened.until(f"{DRAWN} > 0 || {SCENE}.querySelector('.failed')")
        if said := opened(f"{SCENE}.querySelector('.failure').textContent"):
            pytest.skip(said)
        yield opened


def test_the_scene_plays_is_scrubbed_and_is_turned(scene):
    slider, button = f"{SCENE}.querySelector('input')", "#scene button.play"
    scene.until(f"{DRAWN} > 3")
    scene.page.click(button)
    assert scene.page.text_content(button) == "Play"
    still = scene(f"{slider}.value")
    scene.page.wait_for_timeout(200)
    assert scene(f"{slider}.value") == still
    picture = scene.page.locator("#scene canvas")
    before = picture.screenshot()
    box = picture.bounding_box()
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    scene.page.mouse.move(*middle)
    scene.page.mouse.down()
    scene.page.mouse.move(middle[0] + 60, middle[1] + 10, steps=3)
    scene.page.mouse.up()
    scene.page.wait_for_timeout(500)
    assert picture.screenshot() != before
    scene(f"{{ const s = {slider}; s.value = s.max; s.dispatchEvent(new Event('input')); }}")
    assert "cycle 10" in scene.page.text_content("#scene output")
    scene.page.click("#scene .goto button:first-of-type")
    assert scene.page.text_content("#scene output").startswith("0.00 s")
    assert scene.said == []


def test_the_figures_have_a_cursor_at_the_scene_s_moment_and_go_to_where_one_clicks(scene):
    slider = f"{SCENE}.querySelector('input')"
    panels = scene("JSON.parse(document.querySelector('svg[data-time]').dataset.time)")
    run = f"{{ const s = {slider}; s.value = 0.25 * s.max; s.dispatchEvent(new Event('input')); }}"
    scene(run)
    time_shown = float(scene.page.text_content("#scene output").split(" ")[0])
    lines = scene(
        "[...document.querySelector('svg[data-time]').querySelectorAll('line.cursor')].map(line =>"
        " [line.getAttribute('visibility'), +line.getAttribute('x1')])"
    )
    for (begin, end, left, right, *_), (visibility, x) in zip(panels, lines, strict=True):
        inside = begin <= time_shown <= end
        assert visibility == ("visible" if inside else "hidden")
        if inside:
            wanted = left + (time_shown - begin) / (end - begin) * (right - left)
            assert x == pytest.approx(wanted, abs=0.5)
    svg = scene.page.locator("svg[data-time]").first
    svg.scroll_into_view_if_needed()
    box, (begin, end, left, right, top, bottom) = svg.bounding_box(), panels[-1]
    view = [float(part) for part in svg.get_attribute("viewBox").split()]
    scale = box["width"] / view[2]
    middle = box["x"] + scale * (left + right) / 2, box["y"] + scale * (top + bottom) / 2
    scene.page.mouse.click(*middle)
    shown = float(scene.page.text_content("#scene output").split(" ")[0])
    # Frames are a second apart here.
    assert shown == pytest.approx((begin + end) / 2, abs=1.0)


@pytest.mark.slow
def test_a_curve_under_the_pointer_says_its_value(browser, single):
    run = rmj.Run.load(single.parent)
    with Opened(browser, single) as page:
        svg = page.page.locator("#run-cycles svg, svg[data-panels]").first
        panels = json.loads(svg.get_attribute("data-panels"))
        (torque,) = [each for each in panels if "τᵀτ" in each["title"]]
        left, right, top, bottom = torque["box"]
        low, high, logarithmic = torque["y"]
        assert logarithmic
        values = run.data["torque_squared"].values
        svg.scroll_into_view_if_needed()
        for cycle in (3, 8):
            share = (cycle - torque["x"][0]) / (torque["x"][1] - torque["x"][0])
            up = np.log(values[cycle - 1] / low) / np.log(high / low)
            box = svg.bounding_box()
            scale = box["width"] / float(svg.get_attribute("viewBox").split()[2])
            page.page.mouse.move(
                box["x"] + scale * (left + share * (right - left)) + 1,
                box["y"] + scale * (bottom - up * (bottom - top)) - 2,
            )
            said = svg.locator(".reading text").last.text_content()
            assert said.startswith("measured: ")
            assert said.endswith(f" N² m² at cycle {cycle}")
            assert float(said.split()[1]) == pytest.approx(values[cycle - 1], rel=1e-3)
        page.page.mouse.move(2, 2)
        assert svg.locator(".reading").get_attribute("visibility") == "hidden"
        assert page.said == []


def test_a_joint_s_name_cannot_leave_the_scene_s_data(tmp_path):
    name = "</script><b>joint</b>"
    arm = tmp_path / "arm.xml"
    text = (Path(rmj.__file__).parents[1] / "mjcf" / "two_link.xml").read_text()
    arm.write_text(text.replace('"joint1"', '"&lt;/script>&lt;b>joint&lt;/b>"'))
    run = rmj.simulate(for_robot(str(arm)).replace({"motion.0.duration": 3.0}))
    assert name in run.plan.robot.joints
    page = rmj.report(run, tmp_path / "page.html", video=False).read_text(encoding="utf-8")
    assert name not in page
    (data,) = re.findall(r'id="scene-data">(.*?)</script>', page, re.DOTALL)
    assert json.loads(data)["joints"][0]["name"] == name


def test_without_webgl_the_page_says_so_and_is_whole_else(browser, single):
    found = next(filter(None, map(shutil.which, BROWSERS)))
    blind = browser.browser_type.launch(
        executable_path=found, args=["--no-sandbox", "--disable-gpu", "--disable-3d-apis"]
    )
    with Opened(blind, single) as opened:
        opened.until(f"{SCENE}.querySelector('.failed')")
        assert "no WebGL" in opened.page.text_content("#scene .failure")
        assert opened("document.querySelectorAll('.drawing svg').length") == 2
    blind.close()


@pytest.mark.parametrize("width", [PHONE, DESK])
@pytest.mark.parametrize("which", ["single", pytest.param("comparison", marks=pytest.mark.slow)])
def test_nothing_is_wider_than_the_screen(browser, which, width, request):
    with Opened(browser, request.getfixturevalue(which), width) as opened:
        opened("document.querySelectorAll('details').forEach(each => each.open = true)")
        assert opened("document.documentElement.scrollWidth") <= width
        # What is wider scrolls in its own box; all else is inside the screen.
        out = opened(
            "[...document.querySelectorAll('main *, header *')]"
            ".filter(each => !each.closest('.scroll, pre, svg'))"
            f".filter(each => each.getBoundingClientRect().right > {width} + 1)"
            ".map(each => each.outerHTML.slice(0, 80))"
        )
        assert out == []


@pytest.mark.slow
def test_each_figure_is_drawn_once_and_can_be_read_on_a_phone_and_on_a_desk(browser, single):
    letters = (
        "[...document.querySelectorAll('.drawing')].map(drawing => Math.min("
        "...[...drawing.querySelectorAll('svg text')].map(text =>"
        " parseFloat(getComputedStyle(text).fontSize)"
        " * Math.hypot(text.getScreenCTM().a, text.getScreenCTM().b))))"
    )
    for width in (PHONE, DESK):
        with Opened(browser, single, width) as opened:
            assert opened("document.querySelectorAll('.drawing svg').length") == 2
            smallest = opened(letters)
        assert len(smallest) == 2
        assert min(smallest) > 6  # CSS pixels


@pytest.mark.parametrize("scheme", ["light", "dark"])
@pytest.mark.slow
def test_words_and_lines_of_figures_stand_out_from_their_paper(browser, single, scheme):
    """Each colour of the figures as the browser shows it, beside the paper of the page."""
    colours = set(
        re.findall(r"(?:fill|stroke): (#[0-9a-f]{6})", single.read_text(encoding="utf-8"))
    )
    words = {"#000000", palette.NOTE.lower()}
    assert words < colours
    with Opened(browser, single, scheme=scheme) as opened:
        swatches = [*words, *{each.lower() for each in palette.SERIES[:3]} & colours, "#ffffff"]
        opened(
            f"{swatches}.forEach((colour, i) => document.querySelector('.paper').append("
            "Object.assign(document.createElementNS('http://www.w3.org/2000/svg', 'svg'),"
            "{id: 's' + i})) || document.getElementById('s' + i).setAttribute('style',"
            "`background: ${colour}; width: 9px; height: 9px`))"
        )
        seen = {
            colour: _luminance(opened.page.locator(f"#s{i}").screenshot())
            for i, colour in enumerate(swatches)
        }
        page = _rgb(opened("getComputedStyle(document.body).backgroundColor"))
        panel = _rgb(opened("getComputedStyle(document.querySelector('.paper')).backgroundColor"))
    assert (np.mean(page) > 230, np.mean(panel) > 230) == (scheme == "light",) * 2
    paper = seen.pop("#ffffff")
    assert paper == pytest.approx(_luminance(panel), abs=2e-3)  # no box about a figure
    for colour, luminance in seen.items():
        light, dim = sorted((luminance, paper), reverse=True)
        least = 4.5 if colour in words else 3.0
        assert (light + 0.05) / (dim + 0.05) >= least, colour


def _luminance(colour):
    """Relative luminance (WCAG 2) of the middle of a picture (PNG), or of a colour (3,) to 255."""
    if isinstance(colour, bytes):
        with Image.open(io.BytesIO(colour)) as picture:
            colour = picture.convert("RGB").getpixel((picture.width // 2, picture.height // 2))
    part = np.array(colour) / 255
    linear = np.where(part <= 0.04045, part / 12.92, ((part + 0.055) / 1.055) ** 2.4)
    return float([0.2126, 0.7152, 0.0722] @ linear)


def _rgb(colour):
    return [float(part) for part in re.findall(r"[\d.]+", colour)[:3]]


@pytest.mark.opengl
@pytest.mark.slow
def test_on_paper_there_is_a_picture_for_the_video_and_all_that_was_folded(
    browser, single, tmp_path
):
    with Opened(browser, single, scheme="dark") as opened:
        opened.page.pdf(path=tmp_path / "report.pdf", format="A4")
        opened.page.emulate_media(media="print")
        assert opened("document.querySelector('.poster').checkVisibility()")
        assert not opened("document.querySelector('video').checkVisibility()")
        assert _rgb(opened("getComputedStyle(document.body).backgroundColor"))[:3] == [255] * 3
    assert (tmp_path / "report.pdf").stat().st_size > 50_000
    if shutil.which("pdftotext") is None:
        pytest.skip("pdftotext (poppler-utils) is not installed; the rest has passed")
    done = subprocess.run(
        ["pdftotext", "-layout", str(tmp_path / "report.pdf"), "-"], capture_output=True, text=True
    )
    pages = done.stdout.rstrip("\f").split("\f")
    assert 3 <= len(pages) <= 9
    for words in ("torque reduction", "joint2", "timestep = 0.001", "resonance-mj run paper.toml"):
        assert words in done.stdout


def test_the_numbers_in_the_page_are_those_of_the_summary(browser, single):
    summary = json.loads((single.parent / "summary.json").read_text())
    values = (
        "rows => rows.map(row => [...row.querySelectorAll('td')].map(cell => "
        "cell.querySelector('data') && Number(cell.querySelector('data').value)))"
    )
    with Opened(browser, single) as opened:
        torque, springs = (
            opened.page.eval_on_selector_all(f"[aria-labelledby=run-{name}] tbody tr", values)
            for name in ("torque", "springs")
        )
        text = opened.page.inner_text("#run-numbers")
    keys = ("torque_reduction", "torque_reduction_optimal", "torque_squared")
    keys += ("torque_squared_optimal", "torque_squared_without_springs", "tracking_rms")
    for row, segment in zip(torque, summary["segments"], strict=True):
        assert row == [*(segment[key] for key in keys), segment["cycles_to_optimum"]]
        assert f"{100 * segment['torque_reduction']:.1f}".replace("-", "−") in text
    found = [row for row in springs if row]
    for index, segment in enumerate(summary["segments"]):
        for joint in range(2):
            row = found[2 * index + joint]
            keys = ("stiffness", "stiffness_optimal", "offset", "offset_optimal")
            assert row[:4] == [segment[key][joint] for key in keys]


@pytest.mark.slow
def test_the_experiment_in_the_page_is_that_of_the_run(browser, single, tmp_path):
    with Opened(browser, single) as opened:
        saved = opened("document.querySelector('a[download=\"paper.toml\"]').href")
        shown = opened("document.getElementById('run-toml').textContent")
    path = tmp_path / "paper.toml"
    path.write_bytes(base64.b64decode(saved.partition("base64,")[2]))
    assert rmj.load(path) == rmj.Run.load(single.parent).experiment
    assert shown == path.read_text().strip()


def test_headings_ids_and_pictures_can_be_told_apart_without_seeing_them(browser, comparison):
    with Opened(browser, comparison) as opened:
        levels = opened(
            "[...document.querySelectorAll('h1,h2,h3,h4')].map(each => Number(each.tagName[1]))"
        )
        ids = opened("[...document.querySelectorAll('[id]')].map(each => each.id)")
        targets = opened(
            "[...document.querySelectorAll('a[href^=\"#\"]')].map(e => e.hash.slice(1))"
        )
        used = opened("[...document.querySelectorAll('use')].map(e => e.href.baseVal.slice(1))")
        assert opened("document.documentElement.lang") == "en"
        assert opened("[...document.images].every(each => each.alt)")
        assert opened(
            "[...document.querySelectorAll('svg')].every("
            "each => each.ariaHidden || each.getAttribute('aria-label'))"
        )
    assert levels[0] == 1
    assert levels.count(1) == 1
    assert max(np.diff(levels)) <= 1
    assert len(set(ids)) == len(ids)
    assert set(targets) | set(used) <= set(ids)


def titled(run):
    """How a run is called: with how it ended where it did not end well."""
    missed = "17 of 17 expectations missed"
    ok = run.status is rmj.Status.OK
    return run.experiment.name if ok else f"{run.experiment.name} NOT TRACKING {missed}"


def test_several_runs_have_a_row_each_what_differs_and_their_own_parts(
    browser, comparison, folders
):
    with Opened(browser, comparison) as opened:
        rows = opened.page.eval_on_selector_all(
            "[aria-labelledby=side] tbody tr:has(td)",
            "rows => rows.map(row => [row.querySelector('th').innerText,"
            " Number(row.querySelector('data').value)])",
        )
        keys = opened.page.eval_on_selector_all(
            "#differences tbody th", "all => all.map(each => each.innerText)"
        )
        titles = opened("[...document.querySelectorAll('article > h2')].map(e => e.innerText)")
        assert opened("document.querySelectorAll('#figures svg').length") == 1
    runs = [rmj.Run.load(folder) for folder in folders]
    expected = [
        [titled(run), run.summary()["segments"][motion]["torque_reduction"]]
        for motion in range(2)
        for run in runs
    ]
    assert rows == expected
    assert "law.kind" in keys
    assert "motion.0.period" not in keys
    assert [title.split()[0] for title in titles] == [run.experiment.name for run in runs]


def test_a_run_that_diverged_says_so_and_why(few, tmp_path):
    experiment = rmj.load("paper").replace({"law.beta": 40.0, "motion.0.duration": 10.0})
    run = rmj.simulate(experiment)
    assert run.status is rmj.Status.DIVERGED
    text = rmj.report(run, tmp_path / "report.html", video=False).read_text(encoding="utf-8")
    assert "The run diverged after" in text
    assert str(run.message)[:40].split("'")[0] in text
    assert "MISSED" in text  # its file expects it to end well


def test_a_run_with_no_whole_cycle_is_reported_too(folders, tmp_path):
    run = rmj.Run.load(folders[0])
    empty = dataclasses.replace(
        run, data=run.data.isel(cycle=slice(0, 0), time=slice(0, 0)), status=rmj.Status.DIVERGED
    )
    notes = []
    path = rmj.report(empty, tmp_path / "report.html", note=notes.append)
    assert "has no whole cycle" in path.read_text(encoding="utf-8")
    assert len(notes) == 1
    assert notes[0].startswith("No video: ")


def test_a_film_shows_the_start_the_change_and_the_end_and_no_more(folders):
    run = rmj.simulate(
        rmj.load("paper").replace({"motion.0.duration": 9.0, "motion.1.duration": 7.0})
    )
    planned = film.plan([run], ["paper"])
    spans = [(scene.start, scene.stop) for scene in planned.scenes]
    np.testing.assert_allclose(spans, [(0, 2), (7, 11), (14, 16)])
    assert film.LEAST <= len(planned.times) / film.FPS <= film.MOST
    assert (np.diff(planned.times) > 0).all()


def test_a_thinned_run_is_filmed_in_the_cycles_that_were_kept():
    run = rmj.simulate(
        rmj.load("paper").replace(
            {"motion.0.duration": 30.0, "motion.1.duration": 30.0, "simulation.samples": 6000}
        )
    )
    assert run.data.attrs["thinned"]
    planned = film.plan([run], ["paper"])
    time = run.data["time"].values
    nearest = time[np.searchsorted(time, planned.times + 1e-9, side="right") - 1]
    assert (planned.times - nearest < run.experiment.simulation.timestep).all()
    assert planned.times[-1] >= 59


def test_of_more_runs_than_fit_beside_each_other_the_first_are_filmed(folders):
    runs = [rmj.Run.load(folders[0])] * 4
    planned = film.plan(runs, list("abcd"))
    assert planned.labels == tuple("abc")[: max(film.SIZES)]


def test_what_a_user_wrote_is_text_in_the_page_and_nothing_else(few, folders, tmp_path):
    label = "<script>alert(1)</script>"
    path = rmj.report(folders[0], tmp_path / "r.html", video=False, labels=[label], title=label)
    assert label not in path.read_text(encoding="utf-8")


def test_an_interrupted_report_leaves_nothing_behind(few, folders, tmp_path):
    def interrupt(done, of):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        rmj.report(folders[0], tmp_path / "r.html", video=False, progress=interrupt)
    assert list(tmp_path.iterdir()) == []


def test_progress_counts_every_picture_to_the_end(few, folders, tmp_path):
    steps = []
    rmj.report(folders, tmp_path / "r.html", video=False, progress=lambda *each: steps.append(each))
    assert [done for done, _ in steps] == list(range(1, len(steps) + 1))
    assert {of for _, of in steps} == {len(steps)}


def test_a_run_that_was_not_read_from_a_folder_needs_a_path(folders):
    with pytest.raises(OutputError, match="give the report a path"):
        rmj.report(rmj.Run.load(folders[0]))


def test_without_opengl_the_report_is_written_without_a_video_and_says_so(
    few, folders, tmp_path, monkeypatch, capsys
):
    monkeypatch.setenv("MUJOCO_GL", "none-such")
    path = tmp_path / "report.html"
    assert cli.main(["report", str(folders[0]), "-o", str(path)]) == 0
    text = path.read_text(encoding="utf-8")
    for said in (capsys.readouterr().out, text):
        assert "No video: no OpenGL that draws without a display was found" in said
    assert "<video" not in text


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["{missing}"], "holds no run"),
        (["{run}", "-o", "{file}/below/report.html"], "is not a folder"),
        (["{run}", "-o", "{run}"], "is a folder"),
        (["{run}", "--label", "a", "--label", "b"], "2 labels for 1 runs"),
    ],
)
def test_bad_input_is_one_clear_line(arguments, says, folders, tmp_path, capsys):
    (tmp_path / "file").touch()
    given = {"missing": tmp_path / "none", "run": folders[0], "file": tmp_path / "file"}
    before = time.monotonic()
    assert cli.main(["report", *(text.format(**given) for text in arguments)]) == 2
    error = capsys.readouterr().err
    assert says in error
    assert error.count("\n") == 1
    assert time.monotonic() - before < 5  # before any picture is drawn


def test_the_bundle_of_the_scene_is_made_of_its_source():
    source, bundle = BUNDLE.with_name("scene.js").read_bytes(), BUNDLE.read_text(encoding="utf-8")
    digest = hashlib.sha256(source).hexdigest()[:16]
    assert bundle.startswith(f"/* scene.js {digest} */"), "run npm run build beside scene.js"
    assert "</script" not in bundle


def test_all_that_a_page_is_made_of_travels_with_the_package():
    templates = Path(film.__file__).parent / "templates"
    names = {path.name for path in templates.iterdir()}
    assert {"page.html", "run.html", "comparison.html", "style.css", "script.js"} <= names


def test_a_tool_off_its_path_saves_nothing_on_the_page_or_in_the_figure(tmp_path):
    limp = {"law.omega": 0.0, "motion.0.duration": 4.0}
    run = rmj.simulate(for_robot("two_link.xml").replace(limp))
    run.save(tmp_path / "limp")
    rmj.report(tmp_path / "limp", tmp_path / "limp.html", video=False)
    page = (tmp_path / "limp.html").read_text()
    assert "off its path" in page
    assert "less motor torque² than without springs" not in page
    (drawn,) = rmj.plot(run, tmp_path, figures=["overview"], formats=["svg"])
    words = drawn.read_text()
    assert "off its path" in words or "off path" in words
    assert "less than without springs" not in words
