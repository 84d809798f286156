"""Tune a robot's joint springs to its motion, in MuJoCo."""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .certificates.certificates import certify
    from .comparison.comparison import Comparison, compare
    from .errors import ResonanceError
    from .experiments.claims import Certificate, Certificates
    from .experiments.experiment import Experiment
    from .experiments.loading import load
    from .figures.plot import plot
    from .optimal_springs import Optimum, optimum
    from .reports.report import report
    from .results.run import Run, Status
    from .simulation.simulation import simulate, simulate_many
    from .video.look import Look
    from .video.video import render
    from .viewer.view import view

_HOMES = {
    "Certificate": "experiments.claims",
    "Certificates": "experiments.claims",
    "certify": "certificates.certificates",
    "Comparison": "comparison.comparison",
    "compare": "comparison.comparison",
    "ResonanceError": "errors",
    "Experiment": "experiments.experiment",
    "load": "experiments.loading",
    "Look": "video.look",
    "Optimum": "optimal_springs",
    "optimum": "optimal_springs",
    "plot": "figures.plot",
    "report": "reports.report",
    "Run": "results.run",
    "Status": "results.run",
    "simulate": "simulation.simulation",
    "simulate_many": "simulation.simulation",
    "render": "video.video",
    "view": "viewer.view",
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
    "plot",
    "render",
    "report",
    "simulate",
    "simulate_many",
    "view",
]


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: the command line's help needs none of them."""
    if name in _HOMES:
        return getattr(import_module(f".{_HOMES[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
