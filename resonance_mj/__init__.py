"""Tune a robot's joint springs to its motion, in MuJoCo."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .certificates import certify
    from .claims import Certificate, Certificates
    from .comparison import Comparison, compare
    from .errors import ResonanceError
    from .experiment import Experiment, load
    from .look import Look
    from .optimal_springs import Optimum, optimum
    from .run import Run, Status
    from .simulation import simulate, simulate_many
    from .video import render

_HOMES = {
    "Certificate": "claims",
    "Certificates": "claims",
    "certify": "certificates",
    "Comparison": "comparison",
    "compare": "comparison",
    "ResonanceError": "errors",
    "Experiment": "experiment",
    "load": "experiment",
    "Look": "look",
    "Optimum": "optimal_springs",
    "optimum": "optimal_springs",
    "Run": "run",
    "Status": "run",
    "simulate": "simulation",
    "simulate_many": "simulation",
    "render": "video",
}

__all__ = [
    "Certificate",
    "Certificates",
    "Comparison",
    "Experiment",
    "Look",
    "Optimum",
    "ResonanceError",
    "Run",
    "Status",
    "certify",
    "compare",
    "load",
    "optimum",
    "render",
    "simulate",
    "simulate_many",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: the command line's help needs none of them."""
    if name in _HOMES:
        return getattr(import_module(f".{_HOMES[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
