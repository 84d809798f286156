"""Which second of a run is shown at which second of the wall's clock, and the keys that set it."""

import math
import time
from collections.abc import Callable

PORT = 8765
"""Of the viewer's page in a browser, if nothing else is asked for."""
SLACK = 1e-6
"""Share of a time step by which a time may fall short of it."""
PAUSE, RESTART = 32, 259
FASTER, SLOWER = (265, 61, 334), (264, 45, 333)
"""Keys by GLFW's numbers: Space, Backspace; Up, the key that has + and + of the number pad; Down
and the two with -."""
KEYS_HELP = (
    "Keys in the window: Space pauses and goes on, Up and + double the speed, Down and - halve it, "
    "Backspace begins again, F1 lists MuJoCo's own"
)


class Closed(Exception):  # noqa: N818 (nothing went wrong)
    """The user closed the window."""


class Clock:
    """The time of the run that is to be shown: it stands still, or goes on at some speed.

    Args:
        speed: seconds of the run per second.
        now: the wall's clock [s].

    Attributes:
        speed: as given, until it is changed.
        paused: whether time stands still.
        starts: how often the run was begun.
    """

    def __init__(self, speed: float = 1.0, now: Callable[[], float] = time.perf_counter) -> None:
        self.speed, self.paused, self.starts = speed, False, 1
        self._now = now
        self._from, self._since = 0.0, now()

    @property
    def seconds(self) -> float:
        """Seconds of the run that have passed."""
        return self._from + (0.0 if self.paused else self.speed * (self._now() - self._since))

    def words(self, label: str, state: str = "") -> str:
        """What the line of a viewer begins with: a run's label, its state, and how time goes."""
        speed = f"× {self.speed:g}" if self.speed != 1 else ""
        return ", ".join(filter(None, [label, state, speed, "paused" if self.paused else ""]))

    def go_on_at(self, seconds: float) -> None:
        """Go on from some second of the run."""
        self._from, self._since = seconds, self._now()

    def steps(self, timestep: float) -> int:
        """Whole time steps [s] that have passed."""
        return math.floor(self.seconds / timestep + SLACK)

    def press(self, key: int) -> None:
        """Do what a key asks for; the others are MuJoCo's own."""
        self.go_on_at(0.0 if key == RESTART else self.seconds)
        self.starts += key == RESTART
        self.paused ^= key == PAUSE
        self.speed *= 2.0 ** ((key in FASTER) - (key in SLOWER))
