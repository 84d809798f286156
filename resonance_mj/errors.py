"""The errors that a user's input can cause. Each message is one line that can be acted on."""

from .text import one_line


class ResonanceError(Exception):
    """Base of every error that this package raises on purpose.

    The message names the file, key or element, the value received, and what would be valid. It is
    one line of a length that can be read, whatever stands in the names and values.
    """

    def __init__(self, message: str) -> None:
        super().__init__(one_line(message))


class ExperimentError(ResonanceError):
    """An experiment file, a dotted override or a name is not valid."""


class RobotError(ResonanceError):
    """The MJCF is missing, MuJoCo rejects it, or it has no arm that the law could drive."""


class MotionError(ResonanceError):
    """The desired motion is out of the arm's reach or passes through a singular pose."""


class StabilityError(ResonanceError):
    """The feedback or the learning will diverge, and the caller asked to refuse that."""


class CallbackError(ResonanceError):
    """The control callback cannot be installed."""


class OutputError(ResonanceError):
    """A folder or file cannot be written, or does not hold a run."""


class ClusterError(ResonanceError):
    """A Dask cluster cannot be reached, was lost, or has workers of another version."""


class PictureError(ResonanceError):
    """A picture or video was asked for that cannot be made, or OpenGL to draw it is missing."""


class DivergedWarning(UserWarning):
    """A simulated run diverged, which its status says too: Python shows it where nobody looks."""
