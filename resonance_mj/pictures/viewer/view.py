"""A saved run, or an experiment as it is simulated, in MuJoCo's viewer."""

from collections.abc import Callable
from contextlib import suppress
from functools import partial
from typing import Any

from ...errors import PictureError
from ...experiments.experiment import Experiment
from ...results.run import Run
from ..film import frame_data
from ..film.frame_data import FrameData
from ..film.options import RenderOptions
from . import display
from .clock import KEYS_HELP, PORT, Clock, Closed


def view(
    what: Run | Experiment,
    *,
    speed: float = 1.0,
    start: float | str | None = None,
    stop: float | str | None = None,
    once: bool = False,
    options: RenderOptions | None = None,
    note: Callable[[str], None] | None = None,
    ended: Callable[[Run], None] | None = None,
    web: bool = False,
    port: int = PORT,
) -> Run | None:
    """Replay a run, or simulate an experiment, in a window; returns when the window is closed.

    Args:
        what: a run, which is repeated, or an experiment, which is simulated in step with the
            clock, or as fast as this computer can if that is slower.
        speed: seconds of the run per second.
        start: where to begin in a run: seconds, or a cycle such as "8c"; its start.
        stop: where to end: seconds, or a cycle such as "10c" with whose end it ends; its end.
        once: close the window at the end.
        options: camera, background and what is drawn; its size and plots are for videos.
        note: is called with each line that the user should know.
        ended: is called with the run that was simulated as soon as it ends; the window stays.
        web: show it on a page in the browser instead, without a display; an interrupt ends it.
        port: of that page on this machine; 0 for any that is free.

    Returns:
        The run; of an experiment None if the window was closed before its end.

    Raises:
        PictureError: the span, the speed, the camera or the background is not valid, or there is
            no display.
        RobotError: the robot cannot be loaded.
        MotionError: a motion leaves the arm's reach or passes through a singular pose.
        CallbackError: a simulation is running in this process.
    """
    options, note, ended = options or RenderOptions(), note or _ignore, ended or _ignore
    if not 0 < speed < float("inf"):
        raise PictureError(f"speed = {speed:g}: it must be greater than 0")
    if options.background == "transparent":
        raise PictureError("background 'transparent': a window is not; give sky, white or dark")
    if isinstance(what, Experiment) and (start is not None or stop is not None):
        raise PictureError(
            f"{what.name}: a span is part of a saved run, and this is an experiment, which begins "
            "at its beginning"
        )
    clock = Clock(speed)
    if isinstance(what, Run):
        low, high = frame_data.span(what, start, stop)
        step = what.experiment.simulation.timestep
        given = start is not None or stop is not None
        times = frame_data.times((what,), low, high, step, given)
        shown = frame_data.of_run(what, times, what.experiment.name)
        scale = frame_data.scale([shown])
        with _opened(web, port)(shown, options, clock, note) as window, suppress(Closed):
            clock.go_on_at(0.0)
            while (number := frame(clock.steps(step), len(times), once)) is not None:
                window.show(shown, int(shown.sample[number]), scale)
        return what
    window_of = _opened(web, port)
    from ...callback.callback import refuse_foreign
    from ...plan.plan import plan_for
    from .live import live

    refuse_foreign()
    prepared = plan_for(what)
    for line in prepared.notes:
        note(line)
    return live(prepared, options, clock, once, ended, note, window_of)


def _opened(web: bool, port: int) -> Callable[..., Any]:
    """What opens a window, or a page: the display is looked at before the long work."""
    if web:
        from .web import WebWindow

        return partial(WebWindow, port=port)
    display.check()
    from .window import Window

    def window(shown: FrameData, options: RenderOptions, clock: Clock, note: Any) -> Window:
        note(KEYS_HELP)
        return Window(shown, options, clock, note)

    return window


def frame(steps: int, frames: int, once: bool) -> int | None:
    """Number of the frame to show.

    Args:
        steps: time steps that have passed since the start.
        frames: how many there are, a time step apart.
        once: whether they end, instead of beginning again.

    Returns:
        The number; None after the end.
    """
    return None if once and steps >= frames else steps % frames


def _ignore(_: object) -> None:
    """Do nothing."""
