"""The viewer as a user gets it: a real window on a virtual display; its clock in closed form."""

import http.client
import json
import os
import re
import signal
import socket
import subprocess
import sys

import numpy as np
import pytest
from virtual_display import display, until

import resonance_mj as rmj
from resonance_mj import cli
from resonance_mj.errors import PictureError
from resonance_mj.pictures.film import frame_data
from resonance_mj.pictures.film.overlays import Overlays
from resonance_mj.pictures.film.render_model import RenderModel
from resonance_mj.pictures.film.surroundings import prepare
from resonance_mj.pictures.viewer import display as displays
from resonance_mj.pictures.viewer import live as living
from resonance_mj.pictures.viewer import view as views
from resonance_mj.pictures.viewer.clock import Clock
from resonance_mj.pictures.viewer.view import frame
from resonance_mj.pictures.viewer.web import WebWindow
from resonance_mj.plan.plan import plan_for

GREY_ARM = """<mujoco><worldbody><body name="link"><joint name="hinge" axis="0 1 0"/>
<geom type="capsule" fromto="0 0 0 .3 0 0" size=".03"/><body name="fore" pos=".3 0 0">
<joint name="elbow" axis="0 1 0"/><geom type="capsule" fromto="0 0 0 .2 0 0" size=".02"/>
<site name="tool" pos=".2 0 0"/></body></body></worldbody></mujoco>"""
SHORT = {"motion.0.duration": 2.0, "motion.1.duration": 2.0}
SHORT_OPTIONS = [part for key, value in SHORT.items() for part in (f"--{key}", str(value))]
NO_DISPLAY = {key: value for key, value in os.environ.items() if "DISPLAY" not in key}
SPACE, UP, DOWN, BACKSPACE = 32, 265, 264, 259


class Wall:
    """A wall's clock that is set by hand."""

    now = 100.0

    def __call__(self):
        return self.now


class Pretended:
    """A window without a display: each frame takes a sixtieth of a second of `wall`."""

    frames, keys, pushed = 1 << 30, {}, 0.0

    def __init__(self, shown, options, clock, note):
        self.data, self.clock, self.late, self.shown = shown, clock, False, []
        self.wall = clock._now if isinstance(clock._now, Wall) else Wall()
        self.pushes = np.zeros((3, 6))

    def __enter__(self):
        type(self).last = self
        return self

    def __exit__(self, *_):
        pass

    def show(self, shown, sample, scales, state=""):
        self.data, self.state = shown, state
        self.shown.append((round(float(self.data.time[sample]), 6), self.state))
        if len(self.shown) >= self.frames:
            raise living.Closed
        self.wall.now += 1 / 60
        self.pushes[:, 0] = self.pushed
        if key := self.keys.get(len(self.shown)):
            self.clock.press(key)


@pytest.fixture
def pretended(monkeypatch):
    """A class of windows for one test, in place of the real one."""
    window = type("Window", (Pretended,), {"keys": {}})
    monkeypatch.setattr(views, "_opened", lambda web, port: window)
    return window


@pytest.fixture(scope="module")
def prepared():
    return plan_for(rmj.load("paper").replace(SHORT))


@pytest.fixture(scope="module")
def run():
    return rmj.simulate(rmj.load("paper").replace(SHORT))


@pytest.fixture(scope="module")
def folder(run, tmp_path_factory):
    return run.save(tmp_path_factory.mktemp("runs") / "short")


@pytest.fixture(scope="module")
def screen(tmp_path_factory):
    with display(tmp_path_factory.mktemp("screen")) as found:
        yield found


def live(prepared, speed=1.0, once=True):
    return living.live(
        prepared,
        rmj.RenderOptions(),
        Clock(speed, Wall()),
        once,
        lambda run: None,
        print,
        views._opened(web=False, port=0),
    )


def test_the_clock_is_piecewise_linear_in_the_walls_time():
    wall = Wall()
    clock = Clock(2.0, wall)
    for seconds, key, expected in (
        (3.0, SPACE, 6.0),  # 2 x 3
        (9.0, SPACE, 6.0),  # paused
        (0.5, UP, 7.0),  # + 2 x 0.5
        (0.5, DOWN, 9.0),  # + 4 x 0.5
        (1.0, BACKSPACE, 11.0),  # + 2 x 1
        (0.25, 0, 0.5),  # from the start
    ):
        wall.now += seconds
        assert clock.seconds == pytest.approx(expected)
        clock.press(key)
    assert (clock.speed, clock.starts, clock.paused) == (2.0, 2, False)


def test_a_time_step_has_passed_when_it_is_over_and_rounding_takes_none_away():
    wall = Wall()
    clock = Clock(1.0, wall)
    for steps in (1, 3, 700, 12345):
        clock.go_on_at(steps * 1e-3)
        assert clock.steps(1e-3) == steps
    clock.go_on_at(0.0009)
    assert clock.steps(1e-3) == 0


def test_a_replay_begins_again_after_its_last_frame_or_ends_there():
    assert [frame(steps, 4, once=False) for steps in (0, 3, 4, 11)] == [0, 3, 0, 3]
    assert [frame(steps, 4, once=True) for steps in (0, 3, 4, 11)] == [0, 3, None, None]


@pytest.mark.parametrize("speed", [1.0, 7.0])
def test_what_is_watched_is_the_run_that_simulate_makes_bit_for_bit(
    prepared, run, pretended, speed
):
    watched = live(prepared, speed)
    assert watched.status is rmj.Status.OK
    assert watched.data.equals(run.data)


def test_payloads_and_passages_are_watched_as_they_are_simulated(pretended):
    experiment = rmj.load("two-link-changes")
    cycles = {
        f"motion.{i}.duration": motion.period * (motion.passage + 2)
        for i, motion in enumerate(experiment.motion)
    }
    experiment = experiment.replace(cycles | {"motion.2.payload": [[0.1, 0.5, 1.0]]})
    one = plan_for(experiment)
    assert one.robot.payload is not None
    assert len(one.parts(2)) == 3
    assert one.passages
    assert live(one, 5.0).data.equals(rmj.simulate(experiment).data)


def test_each_frame_shows_the_last_step_that_the_clock_has_passed(prepared, pretended):
    live(prepared, speed=3.0)
    shown = np.array([time for time, _ in pretended.last.shown])
    # At a frame the clock shows 3 n / 60 s; the last of so many steps began one before.
    clock = 3.0 / 60 * np.arange(len(shown))
    np.testing.assert_allclose(shown[1:], clock[1:] - 1e-3, atol=1e-9)


def test_the_film_of_a_cycle_is_what_a_video_of_its_run_shows(prepared, run, pretended):
    live(prepared)
    watched = pretended.last.data
    saved = frame_data.of_run(run, run.data["time"].values[2000:], "paper")
    same = saved.time >= watched.time[0] - 1e-9
    assert set(watched.cycle) == {3, 4}
    for name in living.OF_SAMPLES:
        expected = getattr(saved, name)[same]
        # The last frame came before the last steps.
        np.testing.assert_allclose(getattr(watched, name), expected, rtol=1e-12, atol=1e-12)


def test_beginning_again_leaves_nothing_of_the_run_before(prepared, run, pretended):
    pretended.keys = {100: BACKSPACE}
    watched = live(prepared)
    assert watched.data.equals(run.data)
    times = [time for time, _ in pretended.last.shown]
    assert np.argmin(np.diff(times)) in (99, 100)


def test_a_pause_stops_the_simulation_until_it_is_over(prepared, pretended):
    pretended.keys = {50: SPACE, 80: SPACE}
    live(prepared)
    times = [time for time, _ in pretended.last.shown]
    assert len(set(times[50:79])) == 1
    assert times[-1] > 3.9


def test_who_pulls_at_the_arm_moves_it(prepared, run, pretended):
    pretended.pushed = 1.0
    watched = live(prepared)
    assert watched.status is rmj.Status.OK
    assert np.abs(watched.data["q"] - run.data["q"]).max() > 1e-4


def test_a_window_closed_before_the_end_leaves_no_run_and_after_it_the_run(prepared, pretended):
    pretended.frames = 20
    assert live(prepared) is None
    pretended.frames = 400
    assert live(prepared, once=False).status is rmj.Status.OK
    assert pretended.last.shown[-1][1] == "the end"


def test_a_run_that_diverges_is_said_at_once_and_is_exit_status_1(pretended, monkeypatch, capsys):
    monkeypatch.setattr(displays, "check", lambda: None)
    monkeypatch.setenv("MUJOCO_GL", os.environ.get("MUJOCO_GL", ""))
    monkeypatch.setattr(Clock, "steps", lambda self, timestep: 1 << 30)
    pretended.frames = 3
    assert cli.main(["view", "paper", "--law.beta", "40"]) == 1
    said = capsys.readouterr().err
    assert "paper: diverged: motion 1 diverged in cycle" in said
    assert "try" in said
    assert len(said.splitlines()) == 1
    assert pretended.last.shown[-1][1] == "diverged"


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["nothing"], "no experiment is called 'nothing'"),
        (["runs/nothing"], "holds no run: there is no run.nc in it"),
        (["RUN", "--law.beta", "3", "--robot", "x"], "leave out --law.beta, --robot"),
        (["RUN", "--from", "3", "--to", "9"], "lasts from 0 to 4 s"),
        (["RUN", "--speed", "0"], "speed = 0"),
        (["RUN", "--background", "transparent"], "sky, white or dark"),
        (["paper", "--from", "3"], "a span is part of a saved run"),
        (["RUN"], "neither DISPLAY nor WAYLAND_DISPLAY is set; `resonance-mj render RUN` films"),
        (["paper"], "neither DISPLAY nor WAYLAND_DISPLAY is set; `resonance-mj render RUN` films"),
    ],
)
def test_what_cannot_be_shown_is_one_line(folder, monkeypatch, capsys, options, words):
    monkeypatch.setenv("MUJOCO_GL", os.environ.get("MUJOCO_GL", ""))
    for name in ("DISPLAY", "WAYLAND_DISPLAY"):
        monkeypatch.delenv(name, raising=False)
    assert cli.main(["view", *(str(folder) if one == "RUN" else one for one in options)]) == 2
    said = capsys.readouterr().err
    assert words in said
    assert len(said.splitlines()) == 1


def test_a_display_that_is_not_there_is_said_with_its_name(monkeypatch):
    monkeypatch.setenv("DISPLAY", ":987")
    monkeypatch.delenv("WAYLAND_DISPLAY", raising=False)
    with pytest.raises(PictureError, match=r"\(DISPLAY=:987: .+\); `resonance-mj render"):
        displays.check()


def command(screen, *arguments):
    """The command, started on a display."""
    return subprocess.Popen(
        [sys.executable, "-m", "resonance_mj.cli", "view", *map(str, arguments)],
        env=screen.environment,
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        # A shell that starts the tests in the background has interrupts ignored.
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )


def like(picture, red, green, blue):
    """How many pixels have a colour's hue, in the light or in the shadow."""
    colour = np.array([red, green, blue]) / np.linalg.norm([red, green, blue])
    length = np.linalg.norm(picture, axis=2)
    return int(((picture @ colour > 0.985 * length) & (length > 110)).sum())


@pytest.mark.slow
def test_an_experiment_is_simulated_in_a_window_that_pauses_and_closes_by_keys(screen, tmp_path):
    (tmp_path / "arm.xml").write_text(GREY_ARM)
    process = command(screen, "--robot", tmp_path / "arm.xml", "--robot.home", "0.5,1.0")
    try:
        # The line above is the last to be drawn.
        assert until(lambda: (screen.picture()[1, :400] > 240).all() or process.poll())
        assert process.poll() is None, process.communicate()
        moving = screen.picture()
        assert until(lambda: like(screen.picture(), 0xAA, 0x33, 0x77) > 30), "motor torque"
        assert until(lambda: like(screen.picture(), 0xE6, 0x9F, 0x00) > 100), "spring"
        assert like(screen.picture(), 0x00, 0x72, 0xB2) > 30, "tool"
        # The model has no light and no floor of its own.
        assert screen.picture()[40:280, :400].mean() > 90
        screen.press("space")

        def still():
            before = screen.picture()
            subprocess.run(["sleep", "1"], check=True)
            return (before == screen.picture()).all()

        assert until(still)
        assert not (moving == screen.picture()).all()
        screen.press("Control_L", "q")
        assert process.wait(timeout=30) == 0
        said = process.communicate()
        assert "Space pauses" in said[0]
        assert said[1] == ""
    finally:
        process.kill()


@pytest.mark.slow
def test_a_replay_ends_once_its_span_is_over(screen, folder):
    process = command(screen, folder, "--from", "2c", "--to", "2c", "--speed", "4", "--once")
    said = process.communicate(timeout=60)
    assert (process.returncode, said[1]) == (0, "")
    assert (screen.picture() == 0).all()


@pytest.mark.slow
def test_windows_open_one_after_the_other_in_one_process(screen, folder):
    code = (
        "import sys, resonance_mj as rmj\n"
        "run = rmj.Run.load(sys.argv[1])\n"
        "print([rmj.view(run, stop=0.2, once=True) is run for _ in range(2)])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(folder)],
        env=screen.environment,
        capture_output=True,
        text=True,
        timeout=60,
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "[True, True]\n", "")


@pytest.mark.slow
def test_an_interrupt_closes_the_window_and_is_one_line(screen, folder):
    process = command(screen, folder, "--background", "dark", "--no-legend", "--no-head-up")
    assert until(lambda: screen.picture().any())
    process.send_signal(signal.SIGINT)
    said = process.communicate(timeout=30)
    assert (process.returncode, len(said[1].splitlines())) == (130, 1)
    assert (screen.picture() == 0).all()


# In a browser


@pytest.fixture
def watched():
    """`view --web` in a process of its own, and the address that it says."""
    started = []

    def start(*options):
        command = [sys.executable, "-m", "resonance_mj", "view", *options, "--web", "--port", "0"]
        process = subprocess.Popen(
            command,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
            env=NO_DISPLAY,
            # What runs the tests may ignore it, as a shell does for what it runs in the background.
            preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
        )
        started.append(process)
        for line in process.stdout:
            if found := re.search(r"http://localhost:(\d+)/", line):
                return process, int(found[1])
        raise AssertionError("it says no address")

    yield start
    for process in started:
        process.kill()
        process.wait()
        process.stdout.close()


def asked(port, method, path, **headers):
    """The status, and the first bytes, of what this machine's page answers."""
    connection = http.client.HTTPConnection("localhost", port, timeout=10)
    connection.request(method, path, headers=headers)
    answer = connection.getresponse()
    first = answer.read1(1 << 16) if answer.status == 200 else b""
    connection.close()
    return answer.status, first


def test_an_experiment_is_watched_in_a_browser_that_pauses_it_and_begins_again(watched, browser):
    process, port = watched("paper", *SHORT_OPTIONS)
    page = browser.new_page()
    said = []
    page.on("console", lambda message: said.append(message.text))
    page.on("pageerror", lambda error: said.append(str(error)))
    page.goto(f"http://localhost:{port}/")
    reading = page.locator("output")

    def until(words):
        for _ in range(400):
            if words in reading.text_content():
                return
            page.wait_for_timeout(50)
        raise AssertionError(f"{words!r} is not in {reading.text_content()!r}")

    until("tracking error")
    page.click("button[data-press='32']")
    until("paused")
    page.click("button[data-press='259']")
    until("paused · 0.0")
    page.click("button[data-press='265']")
    until("× 2, paused")
    page.click("button[data-press='32']")
    until("the end, × 2 · 4.00 s")
    assert page.evaluate("Number(document.querySelector('canvas').dataset.drawn)") > 2
    process.send_signal(signal.SIGINT)
    assert process.wait(20) == 130
    until("the viewer has ended")
    assert said == []
    page.close()


@pytest.mark.slow
def test_a_replay_is_sent_to_a_browser_until_its_end(watched, folder):
    process, port = watched(str(folder), "--once", "--speed", "0.5")
    status, page = asked(port, "GET", "/")
    assert (status, page[:15]) == (200, b"<!doctype html>")
    status, frame = asked(port, "GET", "/frames")
    assert status == 200
    sent = json.loads(frame.decode().split("\n\n")[0].removeprefix("data: "))
    run = rmj.Run.load(folder)
    at = int(np.argmin(np.abs(run.data["time"].values - sent["times"])))
    np.testing.assert_allclose(np.array(sent["tool"])[[0, 2]], run.data["x"].values[at], atol=2e-5)
    assert process.wait(30) == 0


def test_the_page_answers_no_other_site_and_nothing_that_it_does_not_have(watched):
    _, port = watched("paper")
    here = f"localhost:{port}"
    assert asked(port, "POST", "/press/32", Host=here, Origin=f"http://{here}")[0] == 204
    for refused in (
        ("POST", "/press/32", {"Origin": "http://elsewhere.example"}),
        ("POST", "/press/32", {"Host": "elsewhere.example"}),
        ("GET", "/frames", {"Origin": "http://elsewhere.example"}),
        ("GET", "/frames", {"Host": "elsewhere.example"}),
        ("POST", "/press/x", {}),
        ("GET", "/../pyproject.toml", {}),
    ):
        method, path, headers = refused
        assert asked(port, method, path, **headers)[0] == 404, refused


def test_a_port_that_is_taken_is_said_in_one_line(folder, capsys):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        port = str(taken.getsockname()[1])
        assert cli.main(["view", str(folder), "--web", "--port", port]) == 2
    assert f"port {port}: Address already in use; give another" in capsys.readouterr().err
    assert cli.main(["view", str(folder), "--web", "--port", "99999"]) == 2
    assert "port 99999: " in capsys.readouterr().err


def test_what_is_left_out_of_the_page_is_not_sent_and_what_it_cannot_do_is_said(run):
    said = []
    options = rmj.RenderOptions(springs=False, motors=False, path=False, trail=False, orbit=9.0)
    shown = frame_data.of_run(run, run.data["time"].values[:50], "short")
    with (
        WebWindow(shown, options, Clock(1.0, Wall()), said.append, port=0) as window,
        window.listening() as frames,
    ):
        window.show(shown, 10, frame_data.scale([shown]))
        sent = json.loads(frames.get(timeout=5))
    assert not any(sent["stiffness"] + sent["motor"])
    assert "path" not in sent
    assert sent["trail"] == 0
    assert any(line.endswith("oneself: orbit") for line in said)


def test_a_camera_goes_around_a_live_run_as_time_goes_whatever_part_of_it_is_at_hand(run):
    times = run.data["time"].values
    shown = frame_data.of_run(run, times[:100], "short")
    options = rmj.RenderOptions(orbit=30.0, size=(320, 180))
    arm = RenderModel(shown, options, *prepare(shown, options, options.size, print))
    camera = arm.camera(1.0)
    begin, overlays = camera.azimuth, Overlays(arm, camera)
    later = frame_data.of_run(run, times[1000:1100], "short")
    overlays.show(later, int(later.sample[0]), frame_data.scale([later]), camera)
    assert camera.azimuth - begin == pytest.approx(30.0 * times[1000])
