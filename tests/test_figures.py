"""Figures as a reader and a journal meet them: what lines show, sizes, words that can be read."""

import itertools
import re
import subprocess
import sys
from dataclasses import replace

import numpy as np
import pytest
import two_link
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_hex
from matplotlib.text import Text
from PIL import Image

import resonance_mj as rmj
from resonance_mj import cli
from resonance_mj.errors import OutputError, PictureError
from resonance_mj.pictures import palette
from resonance_mj.pictures.figures import asked, catalogue, path, springs
from resonance_mj.pictures.figures.style import Look
from resonance_mj.results.cycles import kept

SHORT = {
    "two-link-transfer": {"motion.0.duration": 12.0, "motion.1.duration": 12.0},
    "scara": {"motion.0.duration": 4.0},
    "six-joint-pose": {"motion.0.duration": 3.0},
    "seven-joint": {"motion.0.duration": 3.0},
}
OF_ONE = [entry.name for entry in catalogue.FIGURES if not entry.several]
DRAWN = {}
WIDTHS = [asked.COLUMN, asked.PAGE]


@pytest.fixture(scope="module")
def runs(resonance_run):
    """Short runs: two joints and motions, a slide joint, rotations, seven joints."""
    return {name: resonance_run(name, changes) for name, changes in SHORT.items()}


@pytest.fixture(scope="module")
def diverged(resonance_run):
    """A run that ends within its first motion, after some whole cycles."""
    changes = {"law.beta": 60.0, "motion.0.duration": 20.0, "motion.1.duration": 2.0}
    run = resonance_run("paper", changes)
    assert run.status is rmj.Status.DIVERGED
    assert run.data.sizes["cycle"] > 2
    return run


def drawn(name, runs, width=asked.PAGE):
    """A figure, laid out so that all of it has its place; each is drawn once, to be looked at."""
    key = name, width, *map(id, runs)
    if key not in DRAWN:
        figure = catalogue.named(name).draw(runs, width)
        FigureCanvasAgg(figure)
        figure.draw_without_rendering()
        DRAWN[key] = figure, runs
    return DRAWN[key][0]


def lines_of(ax, colour):
    return [line for line in ax.lines if to_hex(line.get_color()).upper() == colour]


def words(figure):
    """Every text that is seen, with its box in pixels."""
    ticks = {}
    for ax in figure.axes:
        for axis in (ax.xaxis, ax.yaxis):
            low, high = sorted(axis.get_view_interval())
            slack = 1e-9 * (high - low)
            for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
                ticks[tick.label1] = low - slack <= tick.get_loc() <= high + slack
    renderer = figure.canvas.get_renderer()
    return {
        (index, text.get_text()): text.get_window_extent(renderer)
        for index, text in enumerate(figure.findobj(Text))
        if text.get_text().strip() and text.get_visible() and ticks.get(text, True)
    }


@pytest.mark.parametrize("name", OF_ONE)
@pytest.mark.parametrize("robot", SHORT)
def test_no_words_touch_or_leave_a_page(runs, robot, name):
    if fits(name, runs[robot]):
        assert_readable(drawn(name, [runs[robot]]))


def fits(name, run):
    """Whether a figure can be drawn of a run: springs to buy of one that follows its path."""
    lacks = catalogue.named(name).lacks([run])
    assert not lacks or (name == "parts" and run.status != "ok")
    return not lacks


@pytest.mark.parametrize("name", OF_ONE)
@pytest.mark.parametrize("robot", ["two-link-transfer", "scara"])
def test_no_words_touch_or_leave_a_column(runs, robot, name):
    assert_readable(drawn(name, [runs[robot]], asked.COLUMN))


def assert_readable(figure):
    found = words(figure)
    assert len(found) > 8
    texts = [text for _, text in found]
    x0, y0, x1, y1 = np.array([box.extents for box in found.values()]).T
    right, top = figure.bbox.max
    out = (x0 < -1) | (y0 < -1) | (x1 > right + 1) | (y1 > top + 1)
    assert [texts[i] for i in np.flatnonzero(out)] == []
    across = np.minimum.outer(x1, x1) - np.maximum.outer(x0, x0)
    up = np.minimum.outer(y1, y1) - np.maximum.outer(y0, y0)
    touch = np.argwhere(np.triu((across >= 1) & (up >= 1), 1))
    assert [(texts[i], texts[j]) for i, j in touch] == []


@pytest.mark.parametrize("width", WIDTHS)
def test_no_words_touch_where_runs_are_compared_or_names_are_long(runs, width):
    run = runs["two-link-transfer"]
    many = [
        replace(run, experiment=run.experiment.replace({"law.beta": float(beta)}))
        for beta in range(1, 9)
    ]
    assert_readable(drawn("convergence", many, width))
    long = run.data.assign_coords(joint=["left_shoulder_pan_joint", "left_shoulder_lift_joint"])
    for name in ("overview", "springs"):
        assert_readable(drawn(name, [replace(run, data=long)], width))


@pytest.mark.parametrize("name", OF_ONE)
@pytest.mark.parametrize("robot", SHORT)
def test_every_panel_says_what_it_shows_in_which_unit(runs, robot, name):
    if not fits(name, runs[robot]):
        return
    figure = drawn(name, [runs[robot]])
    for ax in figure.axes:
        above = [each for each in figure.axes if each.get_position().x0 == ax.get_position().x0]
        below = [each for each in above if each.get_position().y0 <= ax.get_position().y0]
        # A panel without numbers below it shares the abscissa of the next that has some.
        shown = max(
            (each for each in below if each.get_xlabel()), key=lambda each: each.get_position().y0
        )
        assert shown.get_xlabel() == "cycle" or re.search(r"\[.+\]$", shown.get_xlabel())
        assert re.search(r"\[.+\]", ax.get_ylabel() or ax.get_title(loc="left"))


def test_there_is_a_panel_for_each_joint_and_coordinate(runs):
    for name, joints, axes in (("two-link-transfer", 2, 2), ("scara", 4, 3), ("seven-joint", 7, 3)):
        motions = len(runs[name].experiment.motion)
        assert len(drawn("overview", [runs[name]]).axes) == axes + 4 * joints + 1
        assert len(drawn("springs", [runs[name]]).axes) == joints * motions
        assert len(drawn("path", [runs[name]]).axes) == 2 * motions
        assert len(drawn("cycles", [runs[name]]).axes) == 2
    assert len(drawn("path", [runs["six-joint-pose"]]).axes) == 2 + 3
    assert len(drawn("cycles", [runs["six-joint-pose"]]).axes) == 3


def test_a_slide_joint_is_shown_in_metres_and_newtons(runs):
    figure = drawn("springs", [runs["scara"]])
    (lift,) = [ax for ax in figure.axes if "lift" in ax.get_title(loc="left")]
    assert (lift.get_xlabel(), lift.get_ylabel()) == ("joint position q [m]", "force [N]")
    assert any("N/m" in text.get_text() and "rad" not in text.get_text() for text in lift.texts)
    titles = [ax.get_title(loc="left") for ax in drawn("overview", [runs["scara"]]).axes]
    assert sum("N/m" in title for title in titles) == 1
    assert any("[N² m² + N²]" in title for title in titles)


def test_cycles_shows_torque_squared_of_the_samples_beside_the_optimum_computed_anew(runs):
    run = runs["two-link-transfer"]
    torque, tracking = drawn("cycles", [run]).axes
    samples = run.data.groupby("cycle_of_sample")
    squared = (run.data["tau"] ** 2).sum("joint").groupby(samples.groupers[0].group).mean().values
    (line, *_) = lines_of(torque, palette.MEASURED)
    np.testing.assert_allclose(line.get_ydata(), squared, rtol=1e-12)
    error = run.data["x"] - run.data["x_desired"]
    mean = (error**2).sum("axis").groupby(samples.groupers[0].group).mean().values
    np.testing.assert_allclose(tracking.lines[0].get_ydata(), 1e3 * np.sqrt(mean), rtol=1e-9)
    heights = {
        to_hex(each.get_color()[0]).upper(): [segment[0, 1] for segment in each.get_segments()]
        for each in torque.collections
        if hasattr(each, "get_segments")
    }
    best = rmj.optimum(run.experiment)
    assert heights[palette.OPTIMAL] == pytest.approx([best[1].torque_squared], rel=1e-9)
    assert torque.get_yscale() == tracking.get_yscale() == "log"


def test_cycles_marks_the_change_of_motion_between_its_cycles_and_where_the_optimum_is_held(runs):
    run = runs["two-link-transfer"]
    torque, tracking = drawn("cycles", [run]).axes
    for ax in (torque, tracking):
        (change,) = [line for line in ax.lines if list(line.get_xdata()) == [12.5, 12.5]]
        assert to_hex(change.get_color()).upper() == palette.MUTED
    diamonds = [line.get_xdata()[0] for line in torque.lines if line.get_marker() == "D"]
    first = run.summary()["segments"][0]["cycles_to_optimum"]
    assert first is not None
    assert diamonds[0] == first


def test_the_loop_that_is_needed_is_the_inverse_dynamics_of_the_motion_made(runs):
    run = runs["two-link-transfer"]
    axes = drawn("springs", [run]).axes
    last = run.data["cycle_of_sample"].values == 12
    q, dq = (run.data[name].values[last] for name in ("q", "dq"))
    dt = run.experiment.simulation.timestep
    ddq = np.diff(dq, axis=0) / dt
    torque = two_link.inverse_dynamics(q[:-1], dq[:-1], ddq)
    for j in (0, 1):
        (needed,) = [
            line for line in lines_of(axes[j], palette.MUTED) if line.get_linestyle() == ":"
        ]
        shown = needed.get_ydata()
        assert shown[0] == shown[-1]  # closed
        np.testing.assert_allclose(shown[:-2], torque[:, j], atol=0.01 * np.ptp(torque[:, j]))
        np.testing.assert_array_equal(needed.get_xdata()[:-1], q[:, j])


def test_the_springs_line_has_the_springs_stiffness_and_is_zero_at_its_equilibrium(runs):
    run = runs["two-link-transfer"]
    axes = drawn("springs", [run]).axes
    last = [cycle for cycle in kept(run) if cycle.number in (12, 24)]
    for ax, (cycle, j) in zip(axes, itertools.product(last, (0, 1)), strict=True):
        k = cycle.stiffness[0, j]  # this law keeps it within a cycle
        colour = palette.SPRING_POSITIVE if k > 0 else palette.SPRING_NEGATIVE
        (line, exerted) = lines_of(ax, colour)
        (left, right), (low, high) = line.get_xdata(), line.get_ydata()
        assert -(high - low) / (right - left) == pytest.approx(k, rel=1e-9)
        angle = float(
            run.data["equilibrium"].values[run.data["cycle_of_sample"] == cycle.number][0, j]
        )
        assert left + low / k == pytest.approx(angle, rel=1e-9)
        said = " ".join(text.get_text() for text in ax.texts).replace("−", "-")
        assert f"k {k:.3g} N m/rad, qₑ {angle:.3f} rad" in said
        (motor,) = lines_of(ax, palette.MOTOR)
        (needed,) = [each for each in lines_of(ax, palette.MUTED) if each.get_linestyle() == ":"]
        np.testing.assert_allclose(
            needed.get_ydata(), exerted.get_ydata() + motor.get_ydata(), atol=1e-12
        )


def test_a_joint_that_stands_still_is_said_to():
    q = np.full(100, 0.5) + 1e-6 * np.sin(np.arange(100))
    still = springs.Exerted(q, np.full(100, 2.0), np.zeros(100), 0.0)
    assert still.still
    assert springs.spring_in_words(still, False) == "stands still, spring 2 N m"
    assert springs.saved_in_words(still, False) == "100.0% less torque²"


def test_the_path_is_drawn_in_its_own_plane_at_the_same_scale_along_both_axes(runs):
    run = runs["six-joint-pose"]
    ax, *_ = drawn("path", [run]).axes
    inches = ax.get_position().size * ax.get_figure().get_size_inches()
    (per_inch, same) = np.diff([ax.get_xlim(), ax.get_ylim()], axis=1)[:, 0] / inches
    assert per_inch == pytest.approx(same, rel=1e-9)
    assert (ax.get_xlabel(), ax.get_ylabel()) == ("x [m]", "z [m]")
    (desired,) = [line for line in lines_of(ax, palette.DESIRED) if line.get_linestyle() == "--"]
    cycle = kept(run)[-1]
    np.testing.assert_array_equal(desired.get_xdata()[:-1], cycle.x_desired[:, 0])
    np.testing.assert_array_equal(desired.get_ydata()[:-1], cycle.x_desired[:, 2])
    assert desired.get_xdata()[0] == desired.get_xdata()[-1]


def test_a_tilted_path_keeps_its_lengths_in_the_plane_it_is_drawn_in():
    t = np.linspace(0, 2 * np.pi, 50, endpoint=False)
    tilt = np.array([[1, 0, 1], [0, 1, 0]]) / np.array([[np.sqrt(2)], [1]])
    circle = np.stack([np.cos(t), np.sin(t)], axis=1) @ tilt + [0.3, 0.1, 0.5]
    directions, labels = path.plane_of(circle, ["x", "y", "z"])
    flat = (circle - circle.mean(axis=0)) @ directions.T
    np.testing.assert_allclose(np.linalg.norm(flat, axis=1), 1.0, rtol=1e-12)
    for label, direction in zip(labels, directions, strict=True):
        numbers = [float(part) for part in re.findall(r"[−\d.]+", label.replace("−", "-"))]
        assert label.startswith("along (")
        np.testing.assert_allclose(np.abs(numbers), np.abs(direction), atol=0.005)


def test_convergence_shows_each_run_as_a_multiple_of_its_own_optimum(runs):
    several = [runs["two-link-transfer"], runs["scara"]]
    torque, tracking = drawn("convergence", several).axes
    for line, run in zip(torque.lines, several, strict=False):
        best = [one.torque_squared for one in rmj.optimum(run.experiment)]
        own = np.repeat(best, [motion.cycles for motion in run.experiment.motion])
        if run is several[1]:  # four joints, three coordinates: the optimum of the motion made
            own = run.data["torque_squared_optimal"].values[0]
        np.testing.assert_allclose(line.get_ydata(), run.data["torque_squared"] / own, rtol=1e-9)
    assert len(tracking.lines) >= 2


def test_runs_of_the_same_name_are_told_apart_by_the_keys_that_differ(runs):
    run = runs["scara"]
    other = replace(run, experiment=run.experiment.replace({"law.beta": 3.0}))
    (legend,) = drawn("convergence", [run, other]).legends
    _, label = [text.get_text() for text in legend.get_texts()]
    assert label == "scara, law.beta 3"


def test_a_run_that_diverged_is_drawn_and_ends_in_a_cross(diverged, runs):
    for entry in catalogue.fitting([diverged]):
        assert_readable(drawn(entry.name, [diverged]))
    fitting = [entry.name for entry in catalogue.fitting([diverged])]
    assert fitting == [name for name in OF_ONE if name != "parts"]
    torque, _ = drawn("cycles", [diverged]).axes
    (cross,) = [line for line in torque.lines if line.get_marker() == "x"]
    assert cross.get_xdata()[0] == diverged.data["cycle"].values[-1]
    several = [diverged, runs["two-link-transfer"]]
    torque, _ = drawn("convergence", several).axes
    assert sum(line.get_marker() == "x" for line in torque.lines) == 1


def test_a_thinned_run_is_drawn_from_the_cycles_that_were_kept(resonance_run):
    changes = {"motion.0.duration": 30.0, "motion.1.duration": 30.0, "simulation.samples": 8000}
    run = resonance_run("two-link-transfer", changes)
    assert run.data.attrs["thinned"]
    assert [entry.name for entry in catalogue.fitting([run])] == OF_ONE
    for name in ("overview", "path"):
        assert_readable(drawn(name, [run]))
    first, last = path.first_and_last(run)[0].values()
    assert (first.number, last.number) == (1, 30)


def test_a_run_without_samples_has_figures_of_its_cycles_alone_and_says_what_is_missing(runs):
    run = runs["two-link-transfer"]
    bare = replace(run, data=run.data.isel(time=slice(0)))
    assert [entry.name for entry in catalogue.fitting([bare])] == ["cycles"]
    assert [entry.name for entry in catalogue.fitting([bare, run])] == ["convergence"]
    for name, missing in (
        ("overview", "samples in time"),
        ("springs", "a whole cycle with samples"),
    ):
        with pytest.raises(PictureError, match=f"{name}.*{missing}.*two-link-transfer"):
            catalogue.named(name).draw([bare])


def test_captions_and_titles_are_there_for_every_figure():
    for entry in catalogue.FIGURES:
        assert not entry.title.endswith(".")
        assert entry.caption.endswith(".")


@pytest.mark.parametrize(("width", "wide"), [("column", 3.5), ("page", 7.16), ("5.2", 5.2)])
def test_files_are_as_wide_as_asked_to_the_pixel_and_the_point(runs, tmp_path, width, wide):
    written = rmj.plot(
        runs["scara"],
        tmp_path,
        figures=["cycles"],
        formats=["svg", "png", "pdf"],
        width=width,
        dpi=100,
    )
    assert [file.name for file in written] == ["cycles.svg", "cycles.png", "cycles.pdf"]
    svg, png, pdf = written
    points = float(re.search(r'<svg[^>]* width="([\d.]+)pt"', svg.read_text())[1])
    assert points == pytest.approx(72 * wide, abs=1e-3)
    with Image.open(png) as picture:
        assert picture.width == int(100 * wide)
        assert picture.info["dpi"] == pytest.approx((100, 100), abs=0.1)
    box = re.search(rb"/MediaBox \[ 0 0 ([\d.]+) ", pdf.read_bytes())[1]
    assert float(box) == pytest.approx(72 * wide, abs=1e-3)


@pytest.mark.slow
def test_pdf_and_svg_are_vectors_with_text_and_fonts_that_journals_take(runs, tmp_path):
    written = rmj.plot(runs["two-link-transfer"], tmp_path, formats=["svg", "pdf"])
    assert {file.stem for file in written} == {"figure", "cycles", "springs", "path", "parts"}
    for file in written:
        content = file.read_bytes()
        if file.suffix == ".pdf":
            assert b"/CIDFontType2" in content  # TrueType: type 42
            assert b"/FontFile2" in content  # embedded
            assert b"/Type3" not in content
            assert b"/Subtype /Image" not in content
        else:
            assert b"<image" not in content
            assert b"<text" in content


def test_the_same_run_gives_the_same_files(runs, tmp_path):
    for folder in ("one", "two"):
        rmj.plot(runs["scara"], tmp_path / folder, figures=["springs"], formats=["svg", "pdf"])
    for file in (tmp_path / "one").iterdir():
        assert file.read_bytes() == (tmp_path / "two" / file.name).read_bytes()


@pytest.mark.parametrize(
    ("options", "said"),
    [
        ({"figures": ["spring"]}, "'spring' is unknown.*overview, cycles, springs, path"),
        ({"figures": ["convergence"]}, "convergence.*shows several runs, and 1 was given"),
        ({"formats": ["jpg"]}, "'jpg' is unknown.*svg, png, pdf"),
        ({"formats": []}, "no format"),
        ({"width": "wide"}, "'wide'.*column, page, or inches"),
        ({"width": 0.5}, "0.5.*from 3 to 20"),
        ({"width": float("nan")}, "nan"),
        ({"dpi": 1}, "dpi 1.*from 50 to 1200"),
    ],
)
def test_bad_input_is_one_line_that_says_what_would_be_valid(runs, tmp_path, options, said):
    with pytest.raises(PictureError, match=said) as raised:
        rmj.plot(runs["scara"], tmp_path / "new", **options)
    assert "\n" not in str(raised.value)
    assert not (tmp_path / "new").exists()


def test_a_folder_that_cannot_be_written_is_refused(runs, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(OutputError, match="file"):
        rmj.plot(runs["scara"], tmp_path / "file", figures=["cycles"])


@pytest.fixture(scope="module")
def folders(runs, tmp_path_factory):
    parent = tmp_path_factory.mktemp("runs")
    return [runs[name].save(parent / name) for name in ("two-link-transfer", "scara")]


def test_the_command_draws_all_that_fits_into_the_runs_folder(folders, capsys):
    assert cli.main(["plot", str(folders[1]), "--dpi", "60"]) == 0
    written = capsys.readouterr().out.split()
    stems = ["figure", "cycles", "springs", "path", "parts"]
    assert written == [str(folders[1] / f"{s}.{kind}") for s in stems for kind in ("svg", "png")]


def test_the_command_takes_names_formats_and_width(folders, tmp_path, capsys):
    line = ["plot", str(folders[0]), "--figure", "path,cycles", "--figure", "path"]
    assert cli.main([*line, "--format", "pdf", "--width", "column", "--out", str(tmp_path)]) == 0
    assert capsys.readouterr().out.split() == [
        str(tmp_path / f"{n}.pdf") for n in ("path", "cycles")
    ]


def test_several_runs_are_compared(folders, tmp_path, capsys):
    line = ["plot", *map(str, folders), "--format", "svg", "--out", str(tmp_path)]
    assert cli.main(line) == 0
    assert capsys.readouterr().out.split() == [str(tmp_path / "convergence.svg")]
    svg = (tmp_path / "convergence.svg").read_text()
    assert "two-link-transfer" in svg
    assert "scara" in svg


@pytest.mark.parametrize(
    ("options", "said"),
    [
        (["--figure", "fig4"], "there are overview, cycles, springs, path, parts, convergence"),
        (["--format", "svg,eps"], "format 'eps' is unknown"),
        (["--width", "2"], "from 3 to 20"),
        (["--dpi", "many"], "--dpi"),
    ],
)
def test_a_bad_option_exits_2_with_one_line_and_leaves_nothing(
    folders, tmp_path, capsys, options, said
):
    out = tmp_path / "new"
    assert cli.main(["plot", str(folders[0]), "--out", str(out), *options]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert said in line
    assert not out.exists()


def test_the_help_names_every_figure_and_needs_nothing_to_draw_with():
    code = (
        "import sys; from resonance_mj.pictures.figures import catalogue; "
        "print([name for name in ('matplotlib', 'numpy', 'xarray') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "[]"


@pytest.mark.parametrize("name", OF_ONE)
@pytest.mark.parametrize("size", [6.0, 10.0])
@pytest.mark.slow
def test_letters_of_another_size_and_family_touch_nothing_either(runs, name, size):
    wanted = Look(titled=True, font="serif", font_size=size)
    for width in WIDTHS:
        figure = catalogue.named(name).draw([runs["two-link-transfer"]], width, wanted)
        FigureCanvasAgg(figure)
        figure.draw_without_rendering()
        assert_readable(figure)
        titles = [ax.title for ax in figure.axes] + [ax._left_title for ax in figure.axes]
        assert {text.get_fontsize() for text in titles} <= {size, size * 7 / 8}
        assert {text.get_fontfamily()[0] for text in titles} == {"serif"}


def test_a_figure_is_as_high_as_asked_and_says_when_it_cannot_be(runs, tmp_path):
    run = runs["two-link-transfer"]
    (file,) = rmj.plot(run, tmp_path, figures=["cycles"], formats=["png"], height=4.0, dpi=100)
    with Image.open(file) as picture:
        assert picture.size == pytest.approx((716, 400), abs=1)
    with pytest.raises(PictureError, match=r"height 1\.2: this figure's panels need at least"):
        rmj.plot(run, tmp_path, figures=["cycles"], height=1.2)


def test_what_was_run_stands_above_a_figure_if_it_is_asked_for_or_went_wrong(runs, diverged):
    entry, run = catalogue.named("cycles"), runs["two-link-transfer"]
    assert entry.draw([run]).get_suptitle() == ""
    assert entry.draw([run], asked=Look(titled=True)).get_suptitle().startswith("two-link-transfer")
    assert entry.draw([diverged]).get_suptitle().endswith("; diverged")


@pytest.mark.parametrize(
    ("options", "words"),
    [
        ({"font": "Comic Hans"}, "'Comic Hans' is not installed"),
        ({"font_size": 40.0}, "give points from 5 to 16"),
        ({"height": float("nan")}, "give inches from 1 to 20"),
    ],
)
def test_no_figure_looks_like_what_cannot_be(runs, tmp_path, options, words):
    with pytest.raises(PictureError, match=words):
        rmj.plot(runs["scara"], tmp_path / "none", **options)
    assert not (tmp_path / "none").exists()


def test_equilibrium_angles_are_shown_beside_the_optimum_s(runs):
    run = runs["two-link-transfer"]
    figure = drawn("overview", [run])
    (ax,) = [ax for ax in figure.axes if "qₑ of joint1" in ax.get_title(loc="left")]
    (line,) = lines_of(ax, palette.MEASURED)
    assert line.get_ydata()[-1] == pytest.approx(run.data["equilibrium"].values[-1, 0], rel=1e-3)
    (best,) = [each for each in ax.collections if len(each.get_segments()) == 2]
    heights = [segment[0, 1] for segment in best.get_segments()]
    assert heights == pytest.approx(run.data["equilibrium_optimal"].values[:, 0].tolist())


def test_what_is_small_beside_the_other_joints_fills_no_panel(runs):
    run = runs["two-link-transfer"]
    noise = 1e-12 * np.random.default_rng(0).standard_normal(run.data.sizes["time"])
    data = run.data.copy(deep=True)
    data["tau"].values[:, 1] = noise
    data["tau_optimal"].values[:, 1] = 0.0
    figure = catalogue.named("overview").draw([replace(run, data=data)])
    other, quiet = [ax for ax in figure.axes if "motor torque" in ax.get_title(loc="left")]
    assert np.ptp(quiet.get_ylim()) > 0.01 * np.ptp(other.get_ylim())
