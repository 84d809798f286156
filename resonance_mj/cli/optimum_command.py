"""`resonance-mj optimum`: the best constant springs of an experiment."""

from __future__ import annotations

import argparse

from . import keys_as_options
from .console import DONE, console

HELP = "the best constant springs of an experiment"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Give a parser the options of the command."""
    keys_as_options.add_options(parser)


def execute(options: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    experiment = keys_as_options.experiment(options)
    from ..plan.plan import plan_for
    from . import tables

    plan = plan_for(experiment)
    console().print(tables.optimum(plan))
    return DONE
