"""A display without a screen, what is on it, and keys pressed on it: Xvfb and XTest."""

import ctypes
import os
import shutil
import subprocess
import time
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest


class Display:
    """An X server of one screen whose pixels can be read and whose keys can be pressed."""

    def __init__(self, name, framebuffer):
        self.name, self._framebuffer = name, framebuffer
        self.environment = {
            key: value
            for key, value in os.environ.items()
            if key not in ("WAYLAND_DISPLAY", "MUJOCO_GL")
        } | {"DISPLAY": name}

    def picture(self):
        """What is on the screen (height, width, 3)."""
        data = self._framebuffer.read_bytes()
        header = np.frombuffer(data[:100], ">u4")
        width, height, line = (int(header[i]) for i in (4, 5, 12))
        start = int(header[0] + 12 * header[19])
        rows = np.frombuffer(data, np.uint8, height * line, start).reshape(height, line)
        return rows[:, : 4 * width].reshape(height, width, 4)[..., 2::-1].astype(int)

    def press(self, *names):
        """Press keys together, with the pointer over the window's upper left."""
        try:
            x, test = ctypes.CDLL("libX11.so.6"), ctypes.CDLL("libXtst.so.6")
        except OSError as error:
            pytest.skip(f"no keys can be pressed: {error}")
        x.XOpenDisplay.restype = ctypes.c_void_p
        x.XStringToKeysym.restype = ctypes.c_ulong
        display = ctypes.c_void_p(x.XOpenDisplay(self.name.encode()))
        keys = [x.XStringToKeysym(name.encode()) for name in names]
        codes = [x.XKeysymToKeycode(display, ctypes.c_ulong(key)) for key in keys]
        test.XTestFakeMotionEvent(display, -1, 200, 150, 0)
        for code in codes:
            test.XTestFakeKeyEvent(display, code, 1, 0)
        for code in reversed(codes):
            test.XTestFakeKeyEvent(display, code, 0, 0)
        x.XSync(display, 0)
        x.XCloseDisplay(display)


@contextmanager
def display(folder, size="640x480"):
    """Run an X server on a display that is free."""
    if shutil.which("Xvfb") is None:
        pytest.skip("Xvfb is not installed: apt install xvfb")
    read, write = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write), "-screen", "0", f"{size}x24", "-fbdir", str(folder)],
        pass_fds=[write],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.DEVNULL,
    )
    os.close(write)
    with os.fdopen(read) as said:
        number = said.readline().strip()
    try:
        yield Display(f":{number}", Path(folder) / "Xvfb_screen0")
    finally:
        server.terminate()
        server.wait()


def until(true, seconds=60.0):
    """Wait until something is true; what it was in the end."""
    end = time.monotonic() + seconds
    while not (found := true()) and time.monotonic() < end:
        time.sleep(0.1)
    return found
