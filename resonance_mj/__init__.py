"""Tune a robot's joint springs to its motion, in MuJoCo."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .certificates import certify
    from .claims import Certificate, Certificates
    from .comparison import Comparison, compare
    from .errors import ResonanceError
    from .experiment import Experiment, load
    from .optimal_springs import Optimum, optimum
    from .run import Run, Status
    from .simulation import simulate, simulate_many

_HOMES = {
    "Certificate": "claims",
    "Certificates": "claims",
    "certify": "certificates",
    "Comparison": "comparison",
    "compare": "comparison",
    "ResonanceError": "errors",
    "Experiment": "experiment",
    "load": "experiment",
    "Optimum": "optimal_springs",
    "optimum": "optimal_springs",
    "Run": "run",
    "Status": "run",
    "simulate": "simulation",
    "simulate_many": "simulation",
}

__all__ = [
    "Certificate",
    "Certificates",
    "Comparison",
    "Experiment",
    "Optimum",
    "ResonanceError",
    "Run",
    "Status",
    "certify",
    "compare",
    "load",
    "optimum",
    "simulate",
    "simulate_many",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: the command line's help needs none of them."""
    if name in _HOMES:
        return getattr(import_module(f".{_HOMES[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
