"""Videos as a user gets them: real files, decoded again, by real processes."""

import hashlib
import os
import re
import signal
import subprocess
import sys
import time
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image

import resonance_mj as rmj
from resonance_mj import files
from resonance_mj.cli import main
from resonance_mj.errors import OutputError, PictureError
from resonance_mj.pictures.film import frame_data, gl
from resonance_mj.results import metrics

SMALL = (320, 180)


@pytest.fixture(scope="module")
def run():
    """The paper's arm for two cycles of each motion."""
    experiment = rmj.load("paper").replace({"motion.0.duration": 2.0, "motion.1.duration": 2.0})
    return rmj.simulate(experiment)


@pytest.fixture(scope="module")
def folder(run, tmp_path_factory):
    return run.save(tmp_path_factory.mktemp("runs") / "short")


def filmed(run, name, start=1.0, stop=1.2, fps=10.0, size=SMALL, **options):
    """The frames (F, height, width, 3) of a video, read back from its file."""
    rmj.render(
        run, name, start, stop, fps, options=rmj.RenderOptions(size=size, **options), workers=1
    )
    return decoded(name)


def decoded(path):
    ffmpeg = [imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "info", "-i", str(path)]
    done = subprocess.run(
        [*ffmpeg, "-f", "rawvideo", "-pix_fmt", "rgb24", "-"], capture_output=True, timeout=60
    )
    about = done.stderr.decode()
    assert "yuv420p" in about
    width, height = map(int, re.search(r", (\d{3,4})x(\d{3,4})", about).groups())
    return np.frombuffer(done.stdout, np.uint8).reshape(-1, height, width, 3).astype(int)


def command(*arguments, **options):
    line = [sys.executable, "-m", "resonance_mj.cli", "render", *map(str, arguments)]
    return subprocess.run(line, capture_output=True, text=True, timeout=120, **options)


@pytest.mark.opengl
def test_a_video_has_a_frame_each_step_of_its_span_and_is_h264_that_browsers_play(run, tmp_path):
    frames = filmed(run, tmp_path / "out.mp4", 0.5, 1.0, fps=12.0)
    assert frames.shape == (6, 180, 320, 3)
    data = (tmp_path / "out.mp4").read_bytes()
    assert b"avc1" in data
    # The index comes first: playing begins before all is loaded.
    assert data.index(b"moov") < data.index(b"mdat")


@pytest.mark.opengl
@pytest.mark.slow
def test_each_overlay_changes_the_scene_and_only_the_scene(run, tmp_path):
    whole = filmed(run, tmp_path / "whole.mp4", stop=1.1)[0]
    plots = rmj.RenderOptions(size=SMALL).plots_height
    for part in ("path", "trail", "springs", "motors"):
        less = filmed(run, tmp_path / f"{part}.mp4", stop=1.1, **{part: False}, legend=True)[0]
        changed = np.abs(whole - less).max(axis=2) > 60
        assert changed[:-plots].sum() > 20, part
        assert not changed[-plots + 2 :].any(), part


@pytest.mark.opengl
@pytest.mark.slow
def test_the_strip_shows_a_cursor_that_moves_with_the_video(run, tmp_path):
    frames = filmed(run, tmp_path / "out.mp4", 0.0, 4.0, fps=2.0)
    plots = frames[:, -rmj.RenderOptions(size=SMALL).plots_height :]
    # In the first plot's upper part the cursor is the darkest column.
    columns = [int(frame[12:30, 20:110].sum(axis=(0, 2)).argmin()) for frame in plots]
    assert columns == sorted(columns)
    assert columns[-1] - columns[0] > 50


@pytest.mark.opengl
@pytest.mark.slow
def test_without_strip_and_line_the_arm_takes_the_whole_picture(run, tmp_path):
    bare = filmed(run, tmp_path / "out.mp4", plots=False, head_up=False, legend=False)[0]
    assert bare[-1].std() > 0 or bare[0].std() > 0
    with_all = filmed(run, tmp_path / "all.mp4")[0]
    # The line above is written on white.
    assert (with_all[1] > 240).mean() > 0.9 > (bare[1] > 240).mean()


@pytest.mark.opengl
@pytest.mark.slow
def test_two_runs_stand_side_by_side_in_one_picture_of_the_same_size(run, tmp_path):
    both = filmed((run, run), tmp_path / "both.mp4", size=(640, 180))
    assert both.shape[1:] == (180, 640, 3)
    left, right = both[0][:, :318], both[0][:, 322:]
    # The same run twice: what is left of the difference is that of lossy encoding.
    assert np.abs(left - right).mean() < 3


@pytest.mark.opengl
@pytest.mark.slow
def test_runs_side_by_side_are_in_step_however_many_processes_draw(run, tmp_path):
    options = rmj.RenderOptions(size=SMALL)
    one = rmj.render(run, tmp_path / "1.mp4", 0.0, 0.5, 10.0, options=options, workers=1)
    three = rmj.render(run, tmp_path / "3.mp4", 0.0, 0.5, 10.0, options=options, workers=3)
    np.testing.assert_array_equal(decoded(one), decoded(three))


@pytest.mark.opengl
@pytest.mark.slow
def test_a_time_lapse_shows_more_of_the_run_in_fewer_frames(run, tmp_path):
    path = rmj.render(
        run, tmp_path / "fast.mp4", 0.0, 4.0, 5.0, speed=4.0, options=rmj.RenderOptions(size=SMALL)
    )
    assert len(decoded(path)) == 5


@pytest.mark.opengl
@pytest.mark.parametrize("suffix", [".gif", pytest.param(".webp", marks=pytest.mark.slow)])
def test_pictures_that_move_are_written_by_extension(run, tmp_path, suffix):
    path = tmp_path / f"out{suffix}"
    rmj.render(run, path, 1.0, 1.3, 10.0, options=rmj.RenderOptions(size=SMALL))
    with Image.open(path) as image:
        assert (image.size, image.n_frames, image.info["loop"]) == (SMALL, 3, 0)


@pytest.mark.opengl
def test_a_transparent_background_is_transparent_and_the_arm_is_not(run, tmp_path):
    path = tmp_path / "out.webp"
    options = rmj.RenderOptions(
        size=SMALL, background="transparent", plots=False, head_up=False, legend=False
    )
    rmj.render(run, path, 1.0, 1.1, 10.0, options=options)
    with Image.open(path) as image:
        alpha = np.asarray(image.convert("RGBA"))[..., 3]
    assert (alpha[0] == 0).all()
    assert 0.01 < (alpha == 255).mean() < 0.5


@pytest.mark.opengl
@pytest.mark.slow
def test_a_dark_background_is_dark_and_a_white_one_white(run, tmp_path):
    for background, low, high in (("dark", 0, 60), ("white", 245, 256)):
        frame = filmed(run, tmp_path / f"{background}.mp4", background=background)[0]
        assert low <= np.median(frame) < high


@pytest.mark.opengl
def test_odd_sizes_are_rounded_up_for_h264_and_said_so(run, tmp_path):
    said = []
    path = rmj.render(
        run,
        tmp_path / "o.mp4",
        1.0,
        1.1,
        10.0,
        options=rmj.RenderOptions(size=(321, 181)),
        note=said.append,
    )
    assert decoded(path).shape[1:3] == (182, 322)
    assert "321x181" in said[0]
    assert "322x182" in said[0]


DARK_ARM = """<mujoco><worldbody><body name="link"><joint name="hinge" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 .3 0 0" size=".03"/><body name="fore" pos=".3 0 0">
<joint name="elbow" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .2 0 0" size=".02"/>
<site name="tool" pos=".2 0 0"/></body></body></worldbody>
<visual><global offwidth="64" offheight="48"/></visual></mujoco>"""


@pytest.mark.opengl
def test_a_model_without_light_floor_or_buffer_is_lit_and_its_file_is_not_changed(tmp_path):
    mjcf = tmp_path / "arm.xml"
    mjcf.write_text(DARK_ARM)
    experiment = rmj.Experiment(
        name="dark",
        robot={"mjcf": str(mjcf), "home": [0.5, 1.0]},
        motion=[{"duration": 2.0, "shape": "ellipse", "size": [0.03, 0.03]}],
    )
    before = hashlib.sha256(mjcf.read_bytes()).digest()
    frame = filmed(rmj.simulate(experiment), tmp_path / "out.mp4", legend=False)[0]
    assert hashlib.sha256(mjcf.read_bytes()).digest() == before
    scene = frame[30:-60]
    assert scene.mean() > 90
    # The arm is in the middle of the picture, and differs from what is around it.
    assert scene[:, 100:220].std() > 20


UNSEEN = {
    "no geom": ("", "drawn as lines between its joints"),
    "a hidden group": (
        '<geom type="capsule" fromto="0 0 0 .3 0 0" size=".03" group="3"/>',
        "group",
    ),
    "transparent": (
        '<geom type="capsule" fromto="0 0 0 .3 0 0" size=".03" rgba="1 1 1 0"/>',
        "drawn as lines between its joints",
    ),
}


@pytest.mark.opengl
@pytest.mark.parametrize("kind", UNSEEN)
def test_an_arm_of_which_nothing_would_be_seen_is_seen_and_said_so(tmp_path, kind):
    geom, words = UNSEEN[kind]
    inertial = '<inertial pos=".1 0 0" mass="1" diaginertia=".01 .01 .01"/>'
    mjcf = tmp_path / "arm.xml"
    mjcf.write_text(re.sub("<geom[^>]*>", geom + inertial, DARK_ARM))
    experiment = rmj.Experiment(
        name="unseen",
        robot={"mjcf": str(mjcf), "home": [0.5, 1.0]},
        motion=[{"duration": 2.0, "shape": "ellipse", "size": [0.03, 0.03]}],
    )
    bare = dict.fromkeys(
        ("path", "trail", "springs", "motors", "plots", "head_up", "legend"), False
    )
    options, said = rmj.RenderOptions(size=SMALL, background="white", **bare), []
    video = rmj.render(
        rmj.simulate(experiment),
        tmp_path / "o.mp4",
        0.5,
        0.6,
        10.0,
        options=options,
        note=said.append,
    )
    assert (decoded(video)[0].min(axis=2) < 200).mean() > 0.01
    assert len(said) == 1
    assert words in said[0]


def test_cycles_name_spans_from_the_start_of_the_first_to_the_end_of_the_last(run):
    assert frame_data.span(run, "2c", "3c") == (1.0, 3.0)
    assert frame_data.span(run, None, None) == pytest.approx((0.0, 4.0))
    assert frame_data.span(run, 0.25, "1c") == (0.25, 1.0)


@pytest.mark.parametrize(
    ("start", "stop", "words"),
    [
        (3.0, 9.0, "lasts from 0 to 4 s"),
        (-1.0, 2.0, "lasts from 0 to 4 s"),
        (2.0, 2.0, "empty"),
        ("9c", None, "no cycle 9: the run's cycles are 1c to 4c"),
        ("soon", None, "'soon' is no time"),
    ],
)
def test_spans_that_are_not_in_the_run_are_refused(run, start, stop, words):
    with pytest.raises(PictureError, match=words):
        frame_data.span(run, start, stop)


def test_a_thinned_run_says_which_cycles_are_whole_and_is_filmed_without_the_others(tmp_path):
    experiment = rmj.load("paper").replace(
        {"motion.0.duration": 6.0, "motion.1.duration": 2.0, "simulation.samples": 4000}
    )
    run = rmj.simulate(experiment)
    kept = sorted(set(run.data["cycle_of_sample"].values.tolist()))
    assert len(kept) < 8
    with pytest.raises(PictureError, match="whole are the cycles 1-2, 5-8"):
        frame_data.times((run,), 0.0, 8.0, 0.1, given=True)
    assert len(frame_data.times((run,), 0.0, 8.0, 0.1, given=False)) == 10 * len(kept)


@pytest.mark.opengl
@pytest.mark.slow
def test_an_unknown_camera_is_refused_with_those_that_exist(folder, tmp_path):
    done = command(folder, "-o", tmp_path / "o.mp4", "--to", "0.1", "--camera", "nowhere")
    assert (done.returncode, list(tmp_path.iterdir())) == (2, [])
    assert "no camera 'nowhere'; its cameras are: front" in done.stderr
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["-o", "motion.avi"], "unknown format '.avi'"),
        (["-o", "motion.mp4", "--background", "transparent"], "only .webp"),
        (["-o", "motion.mp4", "--background", "pink"], "sky, white, dark, transparent"),
        (["-o", "motion.mp4", "--size", "big"], "as in 1280x720"),
        (["-o", "motion.mp4", "--fps", "0"], "fps = 0"),
        (["-o", "motion.mp4", "--fps", "1e9"], "fps = 1e+09"),
        (["-o", "motion.mp4", "--speed", "nan"], "speed = nan"),
        (["-o", "motion.mp4", "--speed", "1e-9"], "a video has at most 1000000"),
        (["-o", "motion.mp4", "--camera", "nan,0,1"], "camera nan,0,1: angles"),
        (["-o", "motion.mp4", "--camera", "0,0,1e300"], "camera 0,0,1e300: angles"),
    ],
)
def test_bad_options_are_one_line_and_nothing_is_written(
    folder, tmp_path, options, words, monkeypatch, capsys
):
    monkeypatch.chdir(tmp_path)
    assert main(["render", str(folder), "--to", "0.1", *options]) == 2
    assert list(tmp_path.iterdir()) == []
    said = capsys.readouterr().err
    assert words in said
    assert len(said.splitlines()) == 1


@pytest.mark.opengl
@pytest.mark.slow
def test_a_place_that_cannot_be_written_is_one_line(folder, tmp_path):
    done = command(folder, "--to", "0.1", "-o", "/proc/motion.mp4", cwd=tmp_path)
    assert (done.returncode, list(tmp_path.iterdir())) == (2, [])
    assert "cannot be written" in done.stderr
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.slow
def test_the_users_choice_of_opengl_is_kept_and_a_wrong_one_is_said_with_the_packages(
    folder, tmp_path
):
    environment = os.environ | {"MUJOCO_GL": "nothing"}
    done = command(folder, "-o", tmp_path / "o.mp4", "--to", "0.1", env=environment)
    assert (done.returncode, list(tmp_path.iterdir())) == (2, [])
    assert len(done.stderr.splitlines()) == 1
    for words in (
        "invalid value",
        "MUJOCO_GL was set by you",
        "apt install",
        "dnf install",
        "macOS",
    ):
        assert words in done.stderr
    assert gl.backends({"MUJOCO_GL": "osmesa"}) == ("osmesa",)


def test_what_draws_nothing_asks_for_no_opengl():
    line = [sys.executable, "-m", "resonance_mj.cli", "inspect", "two_link.xml"]
    environment = os.environ | {"MUJOCO_GL": "nothing"}
    done = subprocess.run(line, env=environment, capture_output=True, text=True, timeout=60)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.opengl
@pytest.mark.slow
def test_an_interrupt_leaves_no_video_and_no_process(folder, tmp_path):
    line = [sys.executable, "-m", "resonance_mj.cli", "render", str(folder), "--fps", "100"]
    aside = tmp_path / "aside"
    aside.mkdir()
    process = subprocess.Popen(
        [*line, "-o", str(tmp_path / "o.mp4")],
        env=os.environ | {"TMPDIR": str(aside)},
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        start_new_session=True,
        # A shell that starts the tests in the background has interrupts ignored.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )
    until = time.monotonic() + 60
    while not list(aside.glob("*/video.mp4")) and time.monotonic() < until:
        time.sleep(0.05)
    os.killpg(process.pid, signal.SIGINT)
    assert b"ended by SIGINT" in process.communicate(timeout=60)[1]
    assert process.returncode == 130
    assert (list(tmp_path.iterdir()), list(aside.iterdir())) == ([aside], [])
    with pytest.raises(ProcessLookupError):
        os.killpg(process.pid, 0)


@pytest.mark.opengl
@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
def test_a_full_disk_is_said_and_leaves_nothing(run, tmp_path, monkeypatch):
    # The file is written in a folder of its own first: there it is a device that has no room.
    made = files.tempfile.mkdtemp

    def full(suffix=None, prefix=None, dir=None):
        folder = made(suffix, prefix, dir)
        Path(folder, "o.mp4").symlink_to("/dev/full")
        return folder

    monkeypatch.setattr(files.tempfile, "mkdtemp", full)
    with pytest.raises(OutputError, match=r"o\.mp4: cannot be written: .*[Nn]o space left"):
        rmj.render(run, tmp_path / "o.mp4", 0.0, 0.3, 10.0, options=rmj.RenderOptions(size=SMALL))
    assert list(tmp_path.iterdir()) == []


NOISE = """import resource, sys
from pathlib import Path
import numpy as np
from resonance_mj.errors import OutputError
from resonance_mj.pictures.film.encoding import encoder
resource.setrlimit(resource.RLIMIT_FSIZE, (2000, 2000))
noise = np.random.default_rng(0).integers(0, 256, (20, 90, 160, 3), np.uint8)
try:
    with encoder(Path(sys.argv[1]), (160, 90), 10.0, 3) as encode:
        for frame in noise:
            encode(frame.data.cast("B"))
except OutputError as error:
    sys.exit(str(error))
"""


@pytest.mark.parametrize("suffix", [".mp4", ".gif", ".webp"])
def test_a_temporary_folder_without_room_is_said_and_leaves_nothing(tmp_path, suffix):
    """The files that ffmpeg writes are cut off at 2 kB."""
    line = [sys.executable, "-c", NOISE, str(tmp_path / f"o{suffix}")]
    done = subprocess.run(line, capture_output=True, text=True)
    assert re.fullmatch(r".*cannot be written: ffmpeg stopped after \d+ frames .*\n", done.stderr)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.opengl
def test_what_stands_in_the_working_folder_is_not_executed(folder, tmp_path):
    for name in ("random", "pickle", "signal"):
        (tmp_path / f"{name}.py").write_text("raise SystemExit('executed')")
    video = tmp_path / "o.mp4"
    line = [sys.executable, "-P", "-m", "resonance_mj.cli", "render", str(folder), "--to", "0.1"]
    root = str(Path(rmj.__file__).parents[1])
    done = subprocess.run(
        [*line, "-o", str(video)],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": root},
        capture_output=True,
        text=True,
    )
    assert (done.returncode, done.stderr) == (0, "")
    assert video.stat().st_size > 0


@pytest.mark.opengl
@pytest.mark.slow
def test_a_label_is_one_line_whatever_is_in_it(run, tmp_path):
    options = rmj.RenderOptions(size=SMALL)
    pictures = []
    for label in ("plain", "two\nlines\0", "long " * 1000, ""):
        rmj.render(run, tmp_path / "o.mp4", 1.0, 1.1, 10.0, options=options, labels=[label])
        pictures += list(decoded(tmp_path / "o.mp4"))
    assert len(pictures) == 4
    one_line = round(0.1 * SMALL[1])
    for picture in pictures[1:]:
        assert np.abs(picture[:one_line] - pictures[0][:one_line]).mean() > 1
        assert np.abs(picture[one_line:] - pictures[0][one_line:]).mean() < 1


def test_runs_that_have_no_room_side_by_side_are_refused(run, tmp_path):
    with pytest.raises(PictureError, match=r"9 runs side by side .* 32 columns each"):
        rmj.render([run] * 9, tmp_path / "o.mp4", options=rmj.RenderOptions(size=SMALL))


def test_as_many_labels_as_runs_are_needed(run, tmp_path):
    with pytest.raises(PictureError, match=r"2 labels, a, b, for 1 runs"):
        rmj.render(run, tmp_path / "o.mp4", labels=["a", "b"])


@pytest.mark.opengl
@pytest.mark.slow
def test_what_fails_besides_opengl_is_said_as_what_it_is(run, tmp_path, monkeypatch):
    monkeypatch.setattr(frame_data.FrameData, "__reduce__", lambda self: (int, ("no data",)))
    with pytest.raises(PictureError, match=r"frames cannot be drawn: ValueError"):
        rmj.render(run, tmp_path / "o.mp4", 0.0, 0.1, options=rmj.RenderOptions(size=SMALL))


def test_the_first_sample_of_a_motion_belongs_to_it_however_its_time_is_rounded(monkeypatch):
    monkeypatch.setattr(metrics, "TRACKING", 1.0)  # so that its cycles have a reduction
    paper = rmj.load("paper")
    first, second = (motion.model_dump() for motion in paper.motion)
    first |= {"period": 0.1, "duration": 1.0, "sin": [[0.005], [-0.02]]}
    second |= {"period": 1.0, "duration": 2.0}
    run = rmj.simulate(paper.replace({"motion": [first, second], "law.k_v": 200.0, "expect": {}}))
    shown = frame_data.of_run(run, run.data["time"].values, "x")
    begins = int(np.argmax(shown.cycle == 11))
    assert (shown.period[begins - 1], shown.period[begins]) == (100, 1000)
    assert shown.best[begins] == shown.best[-1]
    assert np.isnan(shown.reduction[shown.cycle == 11]).all()
    assert (shown.reduction[shown.cycle == 12] == run.data["torque_reduction"].values[10]).all()


def test_overlays_are_measured_by_the_stiffest_spring_and_by_the_torque_without_springs():
    """What springs carry, motors do not: with the best springs their arrows are short."""
    run = rmj.simulate(rmj.load("seven-joint"))
    ends = [
        frame_data.times((run,), *frame_data.span(run, c, c), 0.01, True) for c in ("1c", "20c")
    ]
    first, last = (frame_data.of_run(run, times, "") for times in ends)
    for shown in (first, last):
        scale = frame_data.scale([shown])
        assert np.ptp(scale.stiffness) == np.ptp(scale.torque) == 0.0
        together = np.abs(shown.tau + shown.spring()).max()
        assert 0.7 * together < scale.torque[0] <= together * (1 + 1e-6)
    arrows = [np.abs(shown.tau / frame_data.scale([shown]).torque).max() for shown in (first, last)]
    assert arrows[0] > 0.9
    assert arrows[1] < 0.25
    thin = last.stiffness[-1] / frame_data.scale([last]).stiffness
    assert np.isclose(thin.max(), 1.0, rtol=0.01)
    assert thin[-1] < 1e-3


@pytest.mark.opengl
@pytest.mark.slow
def test_a_camera_goes_around_the_arm_at_the_speed_that_is_asked_for(run, tmp_path):
    still, going = (
        filmed(run, tmp_path / f"{speed:g}.mp4", 0.0, 1.0, 2.0, orbit=speed, plots=False)
        for speed in (0.0, 45.0)
    )
    apart = np.abs(still - going).mean(axis=(1, 2, 3))
    assert apart[0] < 1.0  # it begins where a camera that stands is
    assert apart[1] > 5.0
    with pytest.raises(PictureError, match="orbit 1000: give"):
        rmj.RenderOptions(orbit=1000.0)
    with pytest.raises(PictureError, match="cannot go around"):
        rmj.RenderOptions(orbit=1.0, camera="front")


@pytest.mark.opengl
def test_the_floor_has_no_edge_and_fades_into_the_horizon(run, tmp_path):
    (frame,) = filmed(
        run,
        tmp_path / "far.mp4",
        0.0,
        0.1,
        10.0,
        size=(640, 360),
        plots=False,
        springs=False,
        motors=False,
        path=False,
        head_up=False,
        legend=False,
        camera="90,-12,4",
    )
    column = frame[:, 40].mean(axis=1)  # beside the arm: the sky above, the floor below
    steps = np.abs(np.diff(column))
    horizon = slice(int(0.2 * len(column)), int(0.45 * len(column)))
    assert steps[horizon].max() < 30, "no line where the floor ends"
    assert column[5] > column[-5] + 40
