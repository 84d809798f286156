"""The keys of an experiment as options: --law.beta 3."""

import tomllib
from argparse import Namespace
from typing import Any

import resonance_mj as rmj

from ..errors import ExperimentError
from ..text import cut
from .command import argument

HELP = (
    "Every key of the experiment is an option, with its value as in the file: --law.beta 3, "
    "--law.k_v 200,300, --springs.stiffness=-inf,inf, --motion.0.period 0.5. "
    "`resonance-mj keys` lists them."
)

ALONE = ("name", "reality")
"""Keys without a section: a text each, reality of a preset."""

MAP = "--reality"
"""Without a value, of `compare`: all imperfections."""

EXPERIMENT = argument(
    "experiment", "a built-in name, a TOML file, or an arm", metavar="NAME|PATH", nargs="?"
)
ROBOT = argument(
    "--robot", "an arm, in place of the experiment's or with none given", metavar="MJCF"
)


def experiment(options: Namespace) -> rmj.Experiment:
    """The experiment that EXPERIMENT, ROBOT and the keys ask for."""
    from ..experiments.loading import for_robot

    if options.experiment is None and options.robot is None:
        raise ExperimentError(
            "give the NAME or PATH of an experiment or an arm, or --robot MJCF; "
            "`resonance-mj list` has names"
        )
    if options.experiment is None:
        return for_robot(options.robot).replace(options.changes)
    robot = {} if options.robot is None else {"robot.mjcf": options.robot}
    return rmj.load(options.experiment).replace(options.changes | robot)


def split(arguments: list[str]) -> tuple[dict[str, Any], list[str]]:
    """Take the keys, `--law.beta 3`, `--law.beta=3` or `--name mine`, out of the arguments."""
    changes: dict[str, Any] = {}
    rest: list[str] = []
    left = list(reversed(arguments))
    while left:
        token = left.pop()
        key, equals, text = token.removeprefix("--").partition("=")
        if not token.startswith("--") or not ("." in key or key in ALONE):
            rest.append(token)
            continue
        if not equals:
            following = left.pop() if left else None
            if following is None or following.startswith("--"):
                if token == MAP and arguments[0] == "compare":
                    rest.append(token)
                    left += [following] if following else []
                    continue
                key = cut(key)
                raise ExperimentError(f"--{key}: a value must follow, as in --{key}=VALUE")
            text = following
        changes[key] = text if key in ALONE else value(text)
    return changes, rest


def value(text: str) -> Any:
    """A value as a TOML file would have it; `1,2` is a list, and what is no TOML is a string."""
    for literal in (text, f"[{text}]") if "," in text else (text,):
        try:
            read = tomllib.loads(f"value = {literal}")
        except (ValueError, RecursionError):
            continue
        if len(read) == 1:
            return read["value"]
    return text.split(",") if "," in text else text
