"""The viewer's window: the arm in its surroundings, overlays and captions, and the user's keys."""

from __future__ import annotations

import queue
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from types import TracebackType

import mujoco
import mujoco.viewer
import numpy as np

from ...errors import PictureError
from ..film.frame_data import FrameData, Scale
from ..film.options import RenderOptions
from ..film.render_model import RenderModel, prepare
from . import display
from .captions import Captions
from .clock import Clock
from .decoration import Decoration

FRAME = 1 / 60
"""Time between frames [s]; a display that is slower shows fewer."""


class Closed(Exception):  # noqa: N818 (nothing went wrong)
    """The user closed the window."""


class Window:
    """A window on a run, open while the `with` block runs.

    Args:
        shown: which arm; its samples are in the picture for certain.
        options: camera, background and what is drawn.
        scales: what full thickness, colour and length of the overlays stand for.
        clock: is set by the user's keys.
        note: is called with each line that the user should know.

    Raises:
        PictureError: the model has no such camera, or on macOS this is not mjpython.
        RobotError: the arm's file is missing or MuJoCo rejects it.
    """

    def __init__(
        self,
        shown: FrameData,
        options: RenderOptions,
        scales: Scale,
        clock: Clock,
        note: Callable[[str], None],
    ) -> None:
        self._shown, self._options, self._scales, self._clock = shown, options, scales, clock
        self._render_model = RenderModel(
            shown, options, *prepare(shown, options, options.size, note)
        )
        self._render_model.camera(1.0)  # one that is not there is said before the window opens
        self._captions = Captions(options)
        self._keys: queue.SimpleQueue[int] = queue.SimpleQueue()
        self._opened = False
        self._next, self._state = 0.0, ""

    def __enter__(self) -> Window:
        try:
            with _interrupts_wait():
                self._open()
        except BaseException:
            self._close()
            raise
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self._close()

    def _open(self) -> None:
        before = set(threading.enumerate())
        try:
            self._viewer = mujoco.viewer.launch_passive(
                self._render_model.model,
                self._render_model.data,
                key_callback=self._keys.put,
                show_left_ui=False,
                show_right_ui=False,
            )
        except RuntimeError:
            raise PictureError(display.ON_MACOS) from None
        self._threads, self._opened = set(threading.enumerate()) - before, True
        # Images are drawn where they belong only after a figure: one of a pixel, which they cover.
        self._viewer.set_figures((mujoco.MjrRect(0, 0, 1, 1), mujoco.MjvFigure()))
        with self._viewer.lock():
            eye = self._place_camera()
        self._overlays = self._render_model.overlays(self._scales, eye)
        self._decoration = Decoration(self._render_model.model, self._viewer.user_scn)

    def _close(self) -> None:
        if self._opened:
            self._viewer.close()
            for thread in self._threads:
                # A process that ends while the window closes crashes.
                thread.join()

    @property
    def late(self) -> bool:
        """Whether the next frame is due."""
        return time.perf_counter() >= self._next

    @property
    def pushes(self) -> np.ndarray:
        """Forces and torques with which the user pulls at bodies (nbody, 6) [N, N m]."""
        return self._render_model.data.xfrc_applied

    def go_on(self, shown: FrameData, scales: Scale, state: str = "") -> None:
        """Show another part of the same arm's run, or more of it, from the next frame on.

        Args:
            shown: the part.
            scales: what the overlays' full thickness, colour and length stand for from now on.
            state: what the line above adds to the run's name.
        """
        self._shown, self._state = shown, state
        self._overlays.go_on(shown, scales)

    def show(self, sample: int) -> None:
        """Show a sample."""
        render_model = self._render_model
        render_model.pose(self._shown.q[sample])
        with self._viewer.lock():
            camera = self._viewer.cam
            if self._options.follow and camera.type == mujoco.mjtCamera.mjCAMERA_FREE:
                camera.lookat[:] = render_model.data.site_xpos[render_model.site]
            eye = np.array(render_model.eye(camera))
        self._overlays.update(render_model.data, sample, eye)
        self._decoration.update()
        self._write(sample)
        self._viewer.sync()

    def wait(self) -> None:
        """Wait until the next frame is due, and do what keys ask for.

        Raises:
            Closed: there is no window any more.
        """
        time.sleep(max(0.0, self._next - time.perf_counter()))
        self._next = time.perf_counter() + FRAME
        while not self._keys.empty():
            self._clock.press(self._keys.get())
        if not self._viewer.is_running():
            raise Closed

    def _place_camera(self) -> np.ndarray:
        """Look at the motion from where the options say; where that is (3,) [m]."""
        port, mine = self._viewer.viewport, self._viewer.cam
        found = self._render_model.camera(port.width / max(port.height, 1))
        for name in ("type", "fixedcamid", "azimuth", "elevation", "distance"):
            setattr(mine, name, getattr(found, name))
        mine.lookat[:] = found.lookat
        return np.array(self._render_model.eye(found))

    def _write(self, sample: int) -> None:
        """Write the line above and that at the foot, where something in them has changed."""
        clock = self._clock
        speed = f"× {clock.speed:g}" if clock.speed != 1 else ""
        parts = [self._shown.label, self._state, speed, "paused" if clock.paused else ""]
        label, port = ", ".join(filter(None, parts)), self._viewer.viewport
        images = self._captions.images(self._shown, label, sample, port)
        if images is not None:
            self._viewer.set_images(images)


@contextmanager
def _interrupts_wait() -> Iterator[None]:
    """Let an interrupt wait for the end of the block: a window half open cannot be closed."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    came: list[int] = []
    before = signal.signal(signal.SIGINT, lambda number, _: came.append(number))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, before)
    if came:
        raise KeyboardInterrupt
