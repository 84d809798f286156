"""`resonance-mj`: which command is meant, and how each of them ends."""

import argparse
import os
import signal
import sys
from collections.abc import Sequence
from contextlib import suppress
from typing import NoReturn

from ..errors import ExperimentError, ResonanceError
from ..text import cut, nearest, one_line
from . import (
    comparison_commands,
    experiment_commands,
    keys_as_options,
    library_commands,
    run_commands,
    sweep_commands,
    view_commands,
)
from .command import BAD_INPUT, DONE, ENDED_BY_SIGNAL, complain

COMMANDS = {
    "run": experiment_commands.run,
    "optimum": experiment_commands.optimum,
    "inspect": experiment_commands.inspect,
    "compare": comparison_commands.compare,
    "sweep": sweep_commands.sweep,
    "tune": sweep_commands.tune,
    "plot": run_commands.plot,
    "springs": run_commands.springs,
    "certify": run_commands.certify,
    "check": experiment_commands.check,
    "render": run_commands.render,
    "view": view_commands.view,
    "report": run_commands.report,
    "list": library_commands.list_,
    "keys": library_commands.keys,
    "schema": library_commands.schema,
    "version": library_commands.version,
    "completion": library_commands.completion,
}


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
        options = _options(rest)
        options.changes = changes
        if changes and not options.command.takes_keys:
            key = next(iter(changes))
            raise ExperimentError(f"--{cut(key)}: this command takes no keys of an experiment")
        return options.command.execute(options) or DONE
    except ResonanceError as error:
        complain(str(error))
        return BAD_INPUT
    except KeyboardInterrupt as error:
        by = signal.Signals(error.args[0] if error.args else signal.SIGINT)
        with suppress(OSError):  # the terminal may be gone
            complain(f"ended by {by.name}; no file is left half-written")
        return ENDED_BY_SIGNAL + by
    except BrokenPipeError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except OSError as error:
        # What the operating system refuses is a path that was given, or the folder one is in.
        gone = "the working folder" if isinstance(error, FileNotFoundError) else ""
        where = f"{name}: " if (name := error.filename or gone) else ""
        complain(one_line(f"{where}{error.strerror or error}"))
        return BAD_INPUT


def _options(arguments: list[str]) -> argparse.Namespace:
    """The options that arguments ask for.

    Raises:
        ExperimentError: one of them is none; it names the nearest that is.
    """
    name = arguments[0] if arguments else "--help"
    if not name.startswith("-") and name not in COMMANDS:
        raise ExperimentError(
            f"COMMAND {cut(name)!r} is unknown{nearest(name, COMMANDS)}; there are "
            f"{', '.join(COMMANDS)}"
        )
    options, unknown = parser().parse_known_args(arguments or [name])
    if unknown:
        known = [one for names, _ in options.command.arguments for one in names]
        given = cut(unknown[0].partition("=")[0])
        raise ExperimentError(
            f"{name} does not take {given}{nearest(given, known)}; see resonance-mj {name} --help"
        )
    return options


class _Parser(argparse.ArgumentParser):
    """A parser whose errors are one line."""

    def error(self, message: str) -> NoReturn:
        raise ExperimentError(f"{message}; see {self.prog} --help")


class _Version(argparse.Action):
    """Prints the program's version, which is looked up only then."""

    def __call__(self, parser: argparse.ArgumentParser, *_: object) -> NoReturn:
        from importlib.metadata import version

        print(f"{parser.prog} {version('resonance-mj')}")
        parser.exit()


def parser() -> _Parser:
    """What is known of commands and their arguments, but for the keys of an experiment."""
    parser = _Parser(
        prog="resonance-mj",
        description="Tune a robot's joint springs to its motion, in MuJoCo.",
        allow_abbrev=False,
    )
    parser.add_argument("--version", action=_Version, nargs=0, help="the program's version")
    commands = parser.add_subparsers(title="commands", required=True, metavar="COMMAND")
    for name, command in COMMANDS.items():
        what = command.execute.__doc__ or ""
        each = commands.add_parser(
            name,
            help=what[0].lower() + what[1:].removesuffix("."),
            description=what,
            epilog=command.more + keys_as_options.HELP if command.takes_keys else None,
            allow_abbrev=False,
        )
        each.set_defaults(command=command, program=parser)
        for names, settings in command.arguments:
            each.add_argument(*names, **settings)
    return parser
