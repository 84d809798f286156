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
    from ..robots import robot
    from ..springs.optimum import along, follow, resolved
    from . import tables

    arm = robot.build(experiment)
    experiment = resolved(experiment, arm)
    best = along(experiment, arm, follow(experiment, arm))
    console().print(tables.optimum(experiment, arm, best))
    return DONE
