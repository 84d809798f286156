"""How a run ends."""

from enum import StrEnum


class Status(StrEnum):
    """How a run ended."""

    OK = "ok"
    """All cycles were simulated."""
    DIVERGED = "diverged"
    """The arm left all bounds: try `law.lead = 1`, a smaller `law.beta` or a shorter time step."""
