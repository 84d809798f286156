"""The viewer in a browser: a page on this machine's own address, to which frames are sent.

Over SSH: `ssh -L 8765:localhost:8765 HOST`, and the page opens on the user's machine.
"""

from __future__ import annotations

import contextlib
import queue
import threading
import time
from collections.abc import Callable
from dataclasses import replace
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from typing import Any

import numpy as np

from ...errors import PictureError
from ...text import listed
from ..film.captions import fields
from ..film.frame_data import FrameData, Scale
from ..film.options import RenderOptions
from ..film.overlays import TRAIL
from ..page.page import live
from ..page.scene import Stage, in_html
from .clock import PORT, Clock

FRAME = 1 / 30
"""Time between frames [s]."""

HELD = 90
"""Frames that the page keeps, for the trail; the path has as many points."""

WAITING = 4
"""Frames that wait for a slow browser; what comes then is left out."""

QUIET = 10.0
"""Seconds without a frame after which the browser is told that all is well."""


class WebWindow:
    """A page on a run, there while the `with` block runs; used as `Window` is.

    Args:
        shown: which arm; its samples are in the picture for certain.
        options: camera, background and what is drawn.
        clock: is set by the page's buttons.
        note: is called with each line that the user should know, and with the page's address.
        port: on this machine; 0 for any that is free.

    Attributes:
        address: of the page.

    Raises:
        PictureError: the port is taken, or the model has no such camera.
        RobotError: the arm's file is missing or MuJoCo rejects it.
    """

    def __init__(
        self,
        shown: FrameData,
        options: RenderOptions,
        clock: Clock,
        note: Callable[[str], None],
        port: int = PORT,
    ) -> None:
        self._options, self._clock = options, clock
        self._stage = Stage(shown, options, note)
        self._cycle, self._next = -1, 0.0
        self._path: dict[str, Any] = {}
        self._browsers: list[queue.Queue[str | None]] = []
        self._changing = threading.Lock()
        self.pushes = np.zeros((self._stage.arm.model.nbody, 6))
        still = self._stage.still | {"live": HELD, "paths": [], "spans": [[0.0, 0.0, 0]]}
        self._page = live(shown.label, in_html(still)).encode()
        try:
            self._server = _Server(("127.0.0.1", port), self)
        except (OSError, OverflowError) as error:
            raise PictureError(
                f"port {port}: {getattr(error, 'strerror', None) or error}; give another, or 0 "
                "for any that is free"
            ) from None
        unused = [name for name in ("follow", "orbit") if getattr(options, name)]
        unused += ["background"] * (options.background != RenderOptions.background)
        if unused:
            note(f"of no effect in a browser, where one turns the scene oneself: {listed(unused)}")
        self.address = f"http://localhost:{self._server.server_port}/"
        tunnel = f"ssh -L {self._server.server_port}:localhost:{self._server.server_port} HOST"
        note(f"{self.address} shows it until Ctrl-C; from another machine: {tunnel}")

    def __enter__(self) -> WebWindow:
        self._thread = threading.Thread(target=self._server.serve_forever, daemon=True)
        self._thread.start()
        return self

    def __exit__(self, *_: object) -> None:
        with self._changing:
            for browser in self._browsers:
                with contextlib.suppress(queue.Full):
                    browser.put_nowait(None)
        self._server.shutdown()
        self._server.server_close()
        self._thread.join()

    @property
    def late(self) -> bool:
        """Whether the next frame is due."""
        return time.perf_counter() >= self._next

    def show(self, shown: FrameData, sample: int, scales: Scale, state: str = "") -> None:
        """Send a sample, and wait until the next frame is due.

        Args:
            shown: a part of the arm's run.
            sample: its number in it.
            scales: what the overlays' full thickness, colour and length stand for.
            state: what the line above adds to the run's name.
        """
        rows = self._stage.frames(shown, [sample], scales)
        found: dict[str, Any] = {name: values[0].round(5) for name, values in rows.items()}
        label, options = self._clock.words(shown.label, state), self._options
        words = fields(replace(shown, label=label), sample) if options.head_up else [label]
        found["said"] = " · ".join(" ".join(part.split()) for part in words)
        found["starts"] = self._clock.starts
        for name, there in (("stiffness", options.springs), ("motor", options.motors)):
            found[name] = found[name] * there  # none is drawn of what is as weak as that
        if shown.cycle[sample] != self._cycle:
            self._cycle = int(shown.cycle[sample])
            self._path = self._desired(shown, sample, found["tool"])
        self._send(found)
        time.sleep(max(0.0, self._next - time.perf_counter()))
        self._next = time.perf_counter() + FRAME

    def _desired(self, shown: FrameData, sample: int, tool: np.ndarray) -> dict[str, Any]:
        """Desired path of a sample's cycle, and how many frames its trail is long."""
        inside = np.flatnonzero(shown.cycle == shown.cycle[sample])
        index = inside[np.linspace(0, len(inside) - 1, HELD).round().astype(int)]
        points = np.tile(tool, (HELD, 1))
        points[:, shown.axes] = shown.x_desired[index]
        period = float(np.diff(shown.time[inside[:2]]).sum()) * float(shown.period[sample])
        trail = TRAIL * period / FRAME / self._clock.speed
        found: dict[str, Any] = {"trail": min(trail, HELD - 1.0) * self._options.trail}
        return found | ({"path": points.round(5)} if self._options.path else {})

    def _send(self, found: dict[str, Any]) -> None:
        """Send a frame to each browser, with the path it is along: what is lost does not matter."""
        text = in_html(found | self._path)
        with self._changing:
            for browser in self._browsers:
                with contextlib.suppress(queue.Full):
                    browser.put_nowait(text)

    def press(self, key: int) -> None:
        """Do what a button asks for, which stands for a key of the window."""
        self._clock.press(key)

    @contextlib.contextmanager
    def listening(self) -> Any:
        """Frames as they come, for one browser."""
        browser: queue.Queue[str | None] = queue.Queue(WAITING)
        with self._changing:
            self._browsers.append(browser)
        try:
            yield browser
        finally:
            with self._changing:
                self._browsers.remove(browser)


class _Server(ThreadingHTTPServer):
    """Serves one page to browsers of this machine."""

    daemon_threads = True
    allow_reuse_address = True

    def __init__(self, address: tuple[str, int], window: WebWindow) -> None:
        self.window = window
        super().__init__(address, _Handler)


class _Handler(BaseHTTPRequestHandler):
    """Answers a browser: the page, its frames, its buttons."""

    server: _Server
    protocol_version = "HTTP/1.1"

    def do_GET(self) -> None:
        """The page, or the frames as they come (server-sent events)."""
        if self.path == "/":
            self._answer(200, self.server.window._page, "text/html; charset=utf-8")
        elif self.path == "/frames" and self._own:
            self._frames()
        else:
            self._answer(404, b"", "text/plain")

    def do_POST(self) -> None:
        """A button: /press/KEY."""
        _, _, key = self.path.rpartition("/press/")
        if not (self._own and key.isdecimal() and len(key) < 5):
            self._answer(404, b"", "text/plain")
            return
        self.server.window.press(int(key))
        self._answer(204, b"", "text/plain")

    @property
    def _own(self) -> bool:
        """Whether it is this page that asks: no other site's name may lead here."""
        there, origin = self.headers.get("Host", ""), self.headers.get("Origin")
        name, _, _ = there.rpartition(":")  # a tunnel may have another port at the user's end
        return name in ("localhost", "127.0.0.1") and origin in (None, f"http://{there}")

    def _frames(self) -> None:
        self.send_response(200)
        self.send_header("Content-Type", "text/event-stream")
        self.send_header("Cache-Control", "no-store")
        self.send_header("Connection", "close")
        self.end_headers()
        self.close_connection = True
        with self.server.window.listening() as frames, contextlib.suppress(OSError):
            while True:
                try:
                    text = frames.get(timeout=QUIET)
                except queue.Empty:
                    self.wfile.write(b": all is well\n\n")
                    continue
                if text is None:
                    self.wfile.write(b"event: end\ndata: {}\n\n")
                    return
                self.wfile.write(f"data: {text}\n\n".encode())

    def _answer(self, status: int, body: bytes, kind: str) -> None:
        self.send_response(status)
        self.send_header("Content-Type", kind)
        self.send_header("Content-Length", str(len(body)))
        self.send_header("Cache-Control", "no-store")
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_: object) -> None:
        """Say nothing of each request."""
