"""Tune a robot's joint springs to its motion, in MuJoCo."""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from .errors import ResonanceError
    from .evaluation.certificates.certificates import Certificate, Certificates, certify
    from .evaluation.comparison import Comparison, compare
    from .experiments.experiment import Experiment
    from .experiments.loading import load
    from .pictures.figures.catalogue import plot
    from .pictures.film.options import RenderOptions
    from .pictures.film.video import render
    from .pictures.page.report import report
    from .pictures.viewer.view import view
    from .plan.plan import optimum
    from .results.run import Run, Status
    from .simulation.outside import Controller
    from .simulation.simulation import simulate, simulate_many
    from .springs.optimum import Optimum
    from .sweeps.sweep import sweep
    from .sweeps.tune import Tuned, tune

_HOMES = {
    "Certificate": "evaluation.certificates.certificates",
    "Certificates": "evaluation.certificates.certificates",
    "certify": "evaluation.certificates.certificates",
    "Comparison": "evaluation.comparison",
    "compare": "evaluation.comparison",
    "ResonanceError": "errors",
    "Experiment": "experiments.experiment",
    "load": "experiments.loading",
    "Optimum": "springs.optimum",
    "optimum": "plan.plan",
    "plot": "pictures.figures.catalogue",
    "RenderOptions": "pictures.film.options",
    "report": "pictures.page.report",
    "Controller": "simulation.outside",
    "Run": "results.run",
    "Status": "results.run",
    "simulate": "simulation.simulation",
    "simulate_many": "simulation.simulation",
    "render": "pictures.film.video",
    "sweep": "sweeps.sweep",
    "Tuned": "sweeps.tune",
    "tune": "sweeps.tune",
    "view": "pictures.viewer.view",
}

__all__ = [
    "Certificate",
    "Certificates",
    "Comparison",
    "Controller",
    "Experiment",
    "Optimum",
    "RenderOptions",
    "ResonanceError",
    "Run",
    "Status",
    "Tuned",
    "certify",
    "compare",
    "load",
    "optimum",
    "plot",
    "render",
    "report",
    "simulate",
    "simulate_many",
    "sweep",
    "tune",
    "view",
]


def __dir__() -> list[str]:
    return __all__


def __getattr__(name: str) -> Any:
    """Import a public name when it is first used: the command line's help needs none of them."""
    if name in _HOMES:
        return getattr(import_module(f".{_HOMES[name]}", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
