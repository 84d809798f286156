"""`resonance-mj`: which command is meant, and how each of them ends."""

from __future__ import annotations

import argparse
import os
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress
from importlib import import_module
from typing import NoReturn

from ..errors import ExperimentError, ResonanceError
from ..text import cut, one_line
from . import keys_as_options
from .console import BAD_INPUT, DONE, ENDED_BY_SIGNAL

COMMANDS = {
    "run": "run_command",
    "optimum": "optimum_command",
    "inspect": "inspect_command",
    "compare": "compare_command",
    "plot": "plot_command",
    "certify": "certify_command",
    "check": "check_command",
    "render": "render_command",
    "view": "view_command",
    "report": "report_command",
    "list": "list_command",
    "keys": "keys_command",
    "version": "version_command",
}
"""Each command and its module, which has HELP, `add_options` and `execute`."""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line.

    Returns:
        The exit status: 0 done, 1 the run did not end well, 2 bad input, 128 and the number of the
        signal that ended it.
    """
    arguments = list(sys.argv[1:] if argv is None else argv)
    try:
        if any("\0" in argument for argument in arguments):
            raise ExperimentError("an argument has a NUL byte, which no name or value has")
        changes, rest = keys_as_options.split(arguments)
        options = _parser().parse_args(rest)
        options.changes = changes
        if changes and not options.takes_keys:
            key = next(iter(changes))
            raise ExperimentError(f"--{cut(key)}: this command takes no keys of an experiment")
        return int(options.execute(options))
    except ResonanceError as error:
        print(f"resonance-mj: {error}", file=sys.stderr)
        return BAD_INPUT
    except KeyboardInterrupt as error:
        by = signal.Signals(error.args[0] if error.args else signal.SIGINT)
        with suppress(OSError):  # the terminal may be gone
            said = f"resonance-mj: ended by {by.name}; no file is left half-written"
            print(said, file=sys.stderr)
        return ENDED_BY_SIGNAL + by
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except OSError as error:
        # What the operating system refuses is a path that was given, or the folder one is in.
        gone = "the working folder" if isinstance(error, FileNotFoundError) else ""
        where = f"{name}: " if (name := error.filename or gone) else ""
        print(one_line(f"resonance-mj: {where}{error.strerror or error}"), file=sys.stderr)
        return BAD_INPUT


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    def error(self, message: str) -> NoReturn:
        raise ExperimentError(f"{message}; see {self.prog} --help")


def _parser() -> _Parser:
    parser = _Parser(
        prog="resonance-mj",
        description="Tune a robot's joint springs to its motion, in MuJoCo.",
        allow_abbrev=False,
    )
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for name, module in COMMANDS.items():
        command = import_module(f".{module}", __package__)
        each = commands.add_parser(
            name,
            help=command.HELP,
            description=f"{command.HELP[0].upper()}{command.HELP[1:]}.",
            allow_abbrev=False,
        )
        each.set_defaults(execute=command.execute, takes_keys=False)
        command.add_options(each)
    return parser
