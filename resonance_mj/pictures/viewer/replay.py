"""A saved run, shown again in its own time."""

from collections.abc import Callable

from ...results.run import Run
from ..film import frame_data
from ..film.frame_data import FrameData
from ..film.options import RenderOptions
from .clock import Clock
from .window import Closed, Window


def taken(run: Run, start: float | str | None, stop: float | str | None) -> FrameData:
    """All samples of a span of a run.

    Args:
        run: the run.
        start: where it begins: seconds, or a cycle such as "8c"; the run's start.
        stop: where it ends: seconds, or a cycle such as "10c" with whose end it ends; the run's.

    Raises:
        PictureError: the span is not within the run, or was not kept.
    """
    low, high = frame_data.span(run, start, stop)
    dt = run.experiment.simulation.timestep
    times = frame_data.times((run,), low, high, dt, start is not None or stop is not None)
    return frame_data.of_run(run, times, run.experiment.name)


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


def replay(
    run: Run,
    shown: FrameData,
    options: RenderOptions,
    clock: Clock,
    once: bool,
    note: Callable[[str], None],
) -> None:
    """Show a run until the window is closed, or to its end.

    Args:
        run: the run.
        shown: what to show of it, from `taken`.
        options: camera, background and what is drawn.
        clock: how fast.
        once: end after the last frame instead of beginning again.
        note: is called with each line that the user should know.
    """
    dt = run.experiment.simulation.timestep
    with Window(shown, options, frame_data.scale([shown]), clock, note) as window:
        clock.go_on_at(0.0)
        try:
            while (number := frame(clock.steps(dt), len(shown.sample), once)) is not None:
                window.show(int(shown.sample[number]))
                window.wait()
        except Closed:
            return
