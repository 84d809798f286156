"""How a run ends."""

from enum import StrEnum


class Status(StrEnum):
    """How a run ended."""

    OK = "ok"
    """All cycles were simulated, and at the end of each motion the tool follows its path."""
    NOT_TRACKING = "not tracking"
    """The tool does not follow its path: its RMS error is more than 2 % of the path's size."""
    DIVERGING = "diverging"
    """The tool still follows its path, with an error that has grown from cycle to cycle."""
    IN_CONTACT = "in contact"
    """The tool follows its path, and the arm touches something on its way, or a joint its stop."""
    NOISY = "noisy"
    """The tool follows its path, and most of the motors' torque is no part of the motion."""
    INTERRUPTED = "interrupted"
    """It was asked to stop before all cycles were simulated; what there is was kept."""
    DIVERGED = "diverged"
    """The arm left all bounds: try `law.lead = 1`, a smaller `law.beta` or a shorter time step."""
