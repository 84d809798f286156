"""`resonance-mj inspect`: what is found in an arm, and a motion and gains for it."""

from __future__ import annotations

import argparse
from typing import Any

from .console import DONE, console
from .keys_as_options import value

HELP = "what is found in an arm, and a motion and gains for it"


def add_options(parser: argparse.ArgumentParser) -> None:
    """Give a parser the options of the command."""
    add = parser.add_argument
    add("robot", metavar="MJCF", help="a path, a built-in name or menagerie:NAME")
    add("--tool", metavar="NAME", help="the site or body that follows the motion")
    add(
        "--home", metavar="KEY|ANGLES", help="a keyframe, or joint angles as in --home=0.5,-1 [rad]"
    )
    add("--toml", action="store_true", help="print an experiment file for it and nothing else")


def execute(options: argparse.Namespace) -> int:
    """Run the command; returns the exit status."""
    from ..evaluation.inspection import inspect
    from ..experiments.loading import for_robot
    from . import arm_tables

    changes: dict[str, Any] = {}
    if options.tool is not None:
        changes["robot.tool"] = options.tool
    if options.home is not None:
        home = value(options.home)
        changes["robot.home"] = [home] if isinstance(home, int | float) else home
    found = inspect(for_robot(options.robot).replace(changes))
    if options.toml:
        print(found.to_toml(), end="")
        return DONE
    screen = console()
    for kind, slides in (("hinge", False), ("slide", True)):
        joints = [joint for joint in found.joints if joint.slides == slides]
        if joints:
            screen.print(arm_tables.joints(f"{found.experiment.name}: {kind} joints", joints))
            screen.print(arm_tables.effort(f"{kind} joints along the suggested motion", joints))
    screen.print(arm_tables.tools(found))
    screen.print(arm_tables.suggestion(found))
    for note in found.notes:
        screen.print(f"  {note}", soft_wrap=True)
    return DONE
