"""The viewer's window: the arm in its surroundings, overlays and captions, and the user's keys."""

from __future__ import annotations

import queue
import signal
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import replace
from typing import Any

import mujoco
import mujoco.viewer
import numpy as np
from PIL import ImageColor

from ...errors import PictureError
from ..film.captions import HeadUp, Legend
from ..film.frame_data import FrameData, Scale
from ..film.options import RenderOptions
from ..film.overlays import Overlays
from ..film.render_model import RenderModel
from ..film.surroundings import prepare
from . import display
from .clock import Clock, Closed

FRAME = 1 / 60
"""Time between frames [s]; a display that is slower shows fewer."""
READABLE = 0.1
"""Time between changes of the line above [s]: numbers that change faster cannot be read."""


class Window:
    """A window on a run, open while the `with` block runs.

    Args:
        shown: which arm; its samples are in the picture for certain.
        options: camera, background and what is drawn.
        clock: is set by the user's keys.
        note: is called with each line that the user should know.

    Raises:
        PictureError: the model has no such camera, or on macOS this is not mjpython.
        RobotError: the arm's file is missing or MuJoCo rejects it.
    """

    def __init__(
        self, shown: FrameData, options: RenderOptions, clock: Clock, note: Callable[[str], None]
    ) -> None:
        self._options, self._clock = options, clock
        self._arm = RenderModel(shown, options, *prepare(shown, options, options.size, note))
        self._arm.camera(1.0)  # one that is not there is said before the window opens
        self._keys: queue.SimpleQueue[int] = queue.SimpleQueue()
        self._viewer: Any = None
        self._next = self._since = 0.0
        self._written: tuple[object, ...] = ()

    def __enter__(self) -> Window:
        try:
            with _interrupts_wait():
                self._open()
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        if self._viewer:
            self._viewer.close()
            for thread in self._threads:
                # A process that ends while the window closes crashes.
                thread.join()

    def _open(self) -> None:
        before, model = set(threading.enumerate()), self._arm.model
        try:
            self._viewer = mujoco.viewer.launch_passive(
                model,
                self._arm.data,
                key_callback=self._keys.put,
                show_left_ui=False,
                show_right_ui=False,
            )
        except RuntimeError:
            raise PictureError(display.ON_MACOS) from None
        self._threads = set(threading.enumerate()) - before
        # Images are drawn where they belong only after a figure: one of a pixel, which they cover.
        self._viewer.set_figures((mujoco.MjrRect(0, 0, 1, 1), mujoco.MjvFigure()))
        with self._viewer.lock():
            port, camera = self._viewer.viewport, self._viewer.cam
            found = self._arm.camera(port.width / max(port.height, 1))
            for name in ("type", "fixedcamid", "azimuth", "elevation", "distance"):
                setattr(camera, name, getattr(found, name))
            camera.lookat[:] = found.lookat
        self._overlays = Overlays(self._arm, found)
        # As decoration of the scene overlays cast no shadow on the arm. The vertices of a skin
        # without colour go on following the model, and a geom of the type skin shows them.
        scene, skins = self._viewer.user_scn, self._overlays.skins.values()
        scene.ngeom = len(skins)
        self._decoration = list(zip(skins, scene.geoms, strict=False))
        for skin, geom in self._decoration:
            none, shape = np.zeros(3), mujoco.mjtGeom.mjGEOM_SKIN
            mujoco.mjv_initGeom(geom, shape, none, none, np.eye(3).ravel(), np.ones(4, np.float32))
            geom.objtype, geom.objid, geom.dataid = int(mujoco.mjtObj.mjOBJ_SKIN), skin, skin
            geom.category = int(mujoco.mjtCatBit.mjCAT_DECOR)
            material = int(model.skin_matid[skin])
            geom.emission = model.mat_emission[material]
            geom.specular = model.mat_specular[material]

    @property
    def late(self) -> bool:
        """Whether the next frame is due."""
        return time.perf_counter() >= self._next

    @property
    def pushes(self) -> np.ndarray:
        """Forces and torques with which the user pulls at bodies (nbody, 6) [N, N m]."""
        return self._arm.data.xfrc_applied

    def show(self, shown: FrameData, sample: int, scales: Scale, state: str = "") -> None:
        """Show a sample, wait until the next frame is due, and do what keys ask for.

        Args:
            shown: a part of the arm's run.
            sample: its number in it.
            scales: what the overlays' full thickness, colour and length stand for.
            state: what the line above adds to the run's name.

        Raises:
            Closed: there is no window any more.
        """
        with self._viewer.lock():
            self._overlays.show(shown, sample, scales, self._viewer.cam)
            colours = self._arm.model.skin_rgba
            for skin, geom in self._decoration:
                geom.rgba[:] = colours[skin]
                colours[skin, 3] = 0.0
        self._write(shown, sample, state)
        self._viewer.sync()
        time.sleep(max(0.0, self._next - time.perf_counter()))
        self._next = time.perf_counter() + FRAME
        while not self._keys.empty():
            self._clock.press(self._keys.get())
        if not self._viewer.is_running():
            raise Closed

    def _write(self, shown: FrameData, sample: int, state: str) -> None:
        """Write the line above and that at the foot, where something in them has changed."""
        port, now = self._viewer.viewport, time.perf_counter()
        label = self._clock.words(shown.label, state)
        place = (label, port.left, port.bottom, port.width, port.height)
        if self._written[:1] == (place,) and (
            self._written[1] == sample or now < self._since + READABLE
        ):
            return
        self._written, self._since = (place, sample), now
        width, height = (min(max(edge, 160), 8192) for edge in (port.width, port.height))
        options = replace(self._options, size=(width, height))
        images, legend = [], Legend(options, port.width)
        if legend.height:
            paper = np.array(ImageColor.getrgb(options.paper), np.uint8)
            foot = np.tile(paper, (legend.height, port.width, 1))
            legend.draw(foot)
            images.append((mujoco.MjrRect(port.left, port.bottom, port.width, len(foot)), foot))
        if options.head_up:
            head_up = HeadUp(replace(shown, label=label), options, port.width)
            top = np.empty((head_up.height, port.width, 3), np.uint8)
            head_up.draw(top, sample)
            bottom = port.bottom + port.height - len(top)
            images.append((mujoco.MjrRect(port.left, bottom, port.width, len(top)), top))
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
