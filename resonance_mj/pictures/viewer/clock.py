"""Which second of a run is shown at which second of the wall's clock, and the keys that set it."""

import math
import time
from collections.abc import Callable

SLACK = 1e-6
"""Share of a time step by which a time may fall short of it."""


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

    def go_on_at(self, seconds: float) -> None:
        """Go on from some second of the run."""
        self._from, self._since = seconds, self._now()

    def pause(self) -> None:
        """Stop, or go on."""
        self.go_on_at(self.seconds)
        self.paused = not self.paused

    def faster(self, factor: float = 2.0) -> None:
        """Go on at so many times the speed."""
        self.go_on_at(self.seconds)
        self.speed *= factor

    def slower(self) -> None:
        """Go on at half the speed."""
        self.faster(0.5)

    def restart(self) -> None:
        """Begin again."""
        self.go_on_at(0.0)
        self.starts += 1

    def steps(self, timestep: float) -> int:
        """Whole time steps [s] that have passed."""
        return math.floor(self.seconds / timestep + SLACK)

    def press(self, key: int) -> None:
        """Do what a key asks for; keys that are not in `KEYS` are MuJoCo's own."""
        if key in KEYS:
            KEYS[key](self)


KEYS: dict[int, Callable[[Clock], None]] = {
    32: Clock.pause,  # Space
    265: Clock.faster,  # Up
    61: Clock.faster,  # the key that has +
    334: Clock.faster,  # + of the number pad
    264: Clock.slower,  # Down
    45: Clock.slower,  # -
    333: Clock.slower,  # - of the number pad
    259: Clock.restart,  # Backspace
}
"""What keys do, by GLFW's numbers."""

KEYS_HELP = (
    "Keys in the window: Space pauses and goes on, Up and + double the speed, Down and - halve it, "
    "Backspace begins again, F1 lists MuJoCo's own"
)
