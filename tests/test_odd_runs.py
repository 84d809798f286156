"""Figures and reports of runs in which something is zero, missing, long or strange."""

import base64
import re
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import matplotlib
import pytest
from matplotlib.figure import Figure
from PIL import Image

import resonance_mj as rmj
from resonance_mj import cli, library
from resonance_mj.errors import PictureError
from resonance_mj.experiments.loading import for_robot
from resonance_mj.pictures.figures import catalogue
from resonance_mj.pictures.figures.catalogue import save
from resonance_mj.pictures.film import plots
from resonance_mj.pictures.film.options import RenderOptions

PENDULUM = """<mujoco><worldbody><body><joint name="hinge" axis="0 1 0" damping="0.02"/>
<geom type="sphere" pos="0 0 -0.4" size="0.03" mass="1.2" contype="0" conaffinity="0"/>
<site name="tool" pos="0 0 -0.5"/></body></worldbody>
<keyframe><key name="home" qpos="0"/></keyframe></mujoco>"""
SLOWLY = {"duration": 8.0, "period": 4.0, "shape": "line", "size": (0.1, 0.0), "center": [0.0]}
STILL = {"duration": 3.0, "shape": "fourier", "offset": [-0.3, 0.0], "blend": 0}
MATHEMATICS, MARKUP, LONG = r"$\bad$", "<b>&amp;</b>", "left_" + 38 * "very_" + "long"


def chain(joints):
    """An arm of so many joints in a plane, bent by 20 degrees at each."""
    links = "".join(
        f'<body pos="{0.1 if j else 0} 0 0">'
        f'<joint name="joint{j + 1}" axis="0 -1 0" damping="0.1"/>'
        '<geom type="capsule" fromto="0 0 0 0.1 0 0" size="0.01" mass="0.2" contype="0" '
        'conaffinity="0"/>'
        for j in range(joints)
    )
    return (
        f'<mujoco><worldbody>{links}<site name="tool" pos="0.1 0 0"/>{joints * "</body>"}'
        f'</worldbody><keyframe><key name="home" qpos="{joints * "-0.35 "}"/></keyframe></mujoco>'
    )


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Where robots are, and what is drawn: a folder that is nobody else's business."""
    return tmp_path_factory.mktemp("a place of my own")


@pytest.fixture(scope="module")
def simulated(folder):
    """A run by its name; each is simulated once."""
    runs = {}

    def paper(changes):
        short = {"motion.0.duration": 2.0, "motion.1.duration": 2.0, "expect": {}}
        return rmj.load("paper").replace(short | changes)

    def robot(name, xml):
        path = folder / f"{name.replace(' ', '-')}.xml"
        path.write_text(xml)
        return str(path)

    def renamed(name, joint):
        two_link = library.robots()["two_link.xml"].read_text()
        written = joint.replace("&", "&amp;").replace("<", "&lt;")
        return paper({"robot.mjcf": robot(name, two_link.replace("joint1", written))})

    made = {
        "no spring helps": lambda name: for_robot(robot(name, PENDULUM)).replace(
            {"task.coordinates": ["x"], "motion": [SLOWLY]}
        ),
        "no torque": lambda name: paper({"simulation.gravity": [0, 0, 0], "motion": [STILL]}),
        "no motion": lambda name: paper({"motion": [STILL]}),
        "one cycle": lambda name: paper(
            {"motion": [rmj.load("paper").motion[0].model_dump() | {"duration": 1.0}]}
        ),
        "twelve joints": lambda name: for_robot(robot(name, chain(12))).replace(
            {"motion.0.duration": 3.0}
        ),
        "mathematics": lambda name: renamed(name, MATHEMATICS),
        "markup": lambda name: renamed(name, MARKUP),
        "long names": lambda name: renamed(name, LONG).replace({"name": LONG[:100]}),
        "diverges at once": lambda name: paper({"law.k_v": 1e9}),
        "diverges in the first cycle": lambda name: paper({"law.k_v": 1000.0}),
    }

    def run(name):
        if name not in runs:
            runs[name] = rmj.simulate(made[name](name))
        return runs[name]

    run.names = tuple(made)
    return run


class Words(HTMLParser):
    """The words of a page or a figure, without style, script and what a program reads."""

    def __init__(self, text):
        super().__init__()
        self.found, self._tag = [], ""
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        self._tag = tag

    def handle_data(self, data):
        if data.strip() and self._tag not in ("style", "script", "code"):
            self.found.append(data.strip())


def words_of(path):
    return Words(path.read_text(encoding="utf-8")).found


NAMES = (
    "no spring helps", "no torque", "no motion", "one cycle", "twelve joints", "mathematics",
    "markup", "long names", "diverges in the first cycle",
)  # fmt: skip


@pytest.fixture(scope="module")
def reported(simulated, folder):
    """The report of a run by its name; each is made once."""
    pages = {}

    def report(name):
        if name not in pages:
            pages[name] = rmj.report(simulated(name), folder / f"{name}.html", video=False)
        return pages[name]

    return report


def said_in(page):
    return " ".join(words_of(page)).replace("\u202f", " ")


@pytest.mark.parametrize(
    "name", [*NAMES[:1], *(pytest.param(name, marks=pytest.mark.slow) for name in NAMES[1:])]
)
def test_a_report_with_all_figures_is_made_and_no_number_in_it_is_none(simulated, reported, name):
    page = reported(name)
    figures = catalogue.fitting([simulated(name)])
    assert page.read_text(encoding="utf-8").count("<svg viewBox") == len(figures) > 0
    assert not re.search(r"(?<![\w.])[+−-]?(nan|inf)(?![\w.])", said_in(page))


def test_a_motion_that_needs_no_torque_is_said_to_and_nothing_is_at_its_optimum(reported):
    said = said_in(reported("no torque"))
    assert "no torque is needed without springs" in said
    assert "needs no torque" in said  # the figures
    assert not re.search(r"\d % less", said)
    assert not re.search(r"within 5 % of them (never|from cycle)", said)


def test_where_no_spring_helps_nothing_is_promised_of_one(reported):
    said = said_in(reported("no spring helps"))
    assert "no spring helps" in said
    assert "best constant springs 0.0 %" in said


def test_the_optimum_of_a_joint_that_is_held_still_is_no_torque_at_all(reported):
    said = said_in(reported("no motion"))
    assert "best constant springs 100.0 %" in said
    assert "within 5 % of them –" in said  # of nothing
    assert "stands still" in said


@pytest.mark.parametrize(
    ("name", "joint"),
    [
        ("mathematics", MATHEMATICS),
        pytest.param("markup", MARKUP, marks=pytest.mark.slow),
    ],
)
def test_a_joint_is_called_by_its_name_whatever_it_means_elsewhere(
    simulated, reported, folder, name, joint
):
    kinds = ["svg", "png", "pdf"]
    figure, *_ = rmj.plot(simulated(name), folder, figures=["overview"], formats=kinds)
    assert f"(c) stiffness k of {joint} [N m/rad]" in words_of(figure)
    page = reported(name)
    assert joint in words_of(page)
    assert "<b>" not in page.read_text(encoding="utf-8")


@pytest.mark.parametrize("name", NAMES)
def test_the_plots_of_a_film_are_drawn_of_any_run_and_leave_the_style_as_it_was(simulated, name):
    before = dict(matplotlib.rcParams)
    assert plots.draw(simulated(name), RenderOptions(size=(640, 480)), 640).before.any()
    assert dict(matplotlib.rcParams) == before


def test_a_run_that_diverged_in_its_first_step_has_no_figure_and_a_report_that_says_so(
    simulated, reported, folder
):
    run = simulated("diverges at once")
    assert run.data.sizes["time"] == run.data.sizes["cycle"] == 0
    with pytest.raises(PictureError, match="no figure can be drawn"):
        rmj.plot(run, folder / "none")
    assert not (folder / "none").exists()
    said = said_in(reported("diverges at once"))
    assert "The run diverged after 0 whole cycles of 4. It has no whole cycle to measure." in said


def test_a_run_that_diverged_in_its_first_cycle_is_drawn_as_far_as_it_came(simulated, folder):
    run = simulated("diverges in the first cycle")
    assert run.status is rmj.Status.DIVERGED
    assert run.data.sizes["time"] > 0 == run.data.sizes["cycle"]
    assert [path.name for path in rmj.plot(run, folder / "part", formats=["svg"])] == ["figure.svg"]


@pytest.mark.slow
def test_a_page_holds_no_folder_of_its_sender(simulated, folder, tmp_path, monkeypatch):
    """Neither in what is read nor in what can be saved from it, nor in its notes."""
    run = simulated("long names").experiment
    law = folder / "my laws" / "own.py"
    law.parent.mkdir()
    notes = (f"{law}: is a law", f'read "{law}"', "in C:\\Users\\me\\arms\\arm.xml, 3 N m/rad")
    saved = replace(simulated("long names"), notes=notes).save(folder / "of mine" / "run")
    assert str(folder) in run.robot.mjcf
    monkeypatch.chdir(tmp_path)
    report = rmj.report(saved, "page.html", video=False)
    text = report.read_text(encoding="utf-8")
    attached = [
        base64.b64decode(data).decode()
        for data in re.findall(r"data:application/\w+;base64,([\w+/=]+)", text)
    ]
    assert len(attached) == 2
    for part in (text, *attached):
        for place in (str(folder), str(folder.parent), str(tmp_path), "Users", str(Path.home())):
            assert place not in part
    assert all("long-names.xml" in part for part in (text, attached[0]))
    assert "3 N m/rad" in text


def test_a_figure_that_is_taller_than_a_png_can_be_has_fewer_pixels_per_inch(tmp_path):
    (png,) = save(Figure(figsize=(0.2, 120)), tmp_path, "tall", ["png"], dpi=600)
    with Image.open(png) as picture:
        assert 64_990 <= picture.height <= 65_000
        assert picture.info["dpi"][1] == pytest.approx(65_000 / 120, rel=1e-3)


@pytest.mark.parametrize("command", ["plot", "report"])
def test_a_folder_that_is_not_there_yet_is_made(simulated, folder, tmp_path, command):
    saved = simulated("one cycle").save(folder / "saved")
    new = tmp_path / "missing" / "deep"
    options = {
        "plot": ["--out", str(new), "--dpi", "50"],
        "report": ["-o", str(new / "x.html"), "--no-video"],
    }
    assert cli.main([command, str(saved), *options[command]]) == 0
    assert list(new.iterdir())


@pytest.mark.slow
def test_many_threads_plot_at_once_and_each_figure_is_as_if_drawn_alone(tmp_path):
    """In a process of its own, which a deadlock does not outlive."""
    code = f"""
import faulthandler, pathlib
from concurrent.futures import ThreadPoolExecutor
import resonance_mj as rmj
faulthandler.dump_traceback_later(90, exit=True)
short = {{"motion.0.duration": 2.0, "motion.1.duration": 2.0, "expect": {{}}}}
run = rmj.simulate(rmj.load("paper").replace(short))
folder = pathlib.Path({str(tmp_path)!r})
def plot(name):
    return [p.read_bytes() for p in rmj.plot(run, folder / str(name), figures=['cycles'], dpi=50)]
alone = plot("alone")
with ThreadPoolExecutor(4) as pool:
    assert all(each == alone for each in pool.map(plot, range(8)))
"""
    done = subprocess.run([sys.executable, "-c", code], timeout=120, capture_output=True, text=True)
    assert (done.returncode, done.stderr) == (0, "")
