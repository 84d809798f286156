"""The command that shows a run, or an experiment as it is simulated, in a window or a browser."""

from __future__ import annotations

import os
from argparse import Namespace
from pathlib import Path

import resonance_mj as rmj

from .. import library
from ..errors import ExperimentError
from ..pictures.viewer.clock import KEYS_HELP, PORT
from . import keys_as_options
from .command import DONE, NOT_WELL, Screen, argument, command, complain, flag
from .run_commands import PARTS, SPAN, looks, picture


@command(
    argument(
        "experiment",
        "a run's folder, which is replayed; or a built-in name or a TOML file, which is "
        "simulated while you watch",
        metavar="RUN|NAME|PATH",
        nargs="?",
    ),
    keys_as_options.ROBOT,
    argument("--speed", "seconds of the run per second; 1", type=float, default=1.0),
    *SPAN,
    flag("--once", "close the window at the end; runs are repeated else"),
    flag("--web", "on a page in the browser, which needs no display, also over SSH"),
    argument("--port", f"of that page, 0 for any; {PORT}", metavar="N", type=int, default=PORT),
    *picture("sky, white or dark", {part: PARTS[part] for part in PARTS if part != "plots"}),
    keys=True,
    more=f"{KEYS_HELP}. ",
)
def view(options: Namespace) -> int:
    """Watch a saved run again, or an experiment live, in MuJoCo's viewer."""
    # Windows are GLFW's, whatever pictures are drawn with; MuJoCo reads this when it is imported.
    if not options.web:
        os.environ["MUJOCO_GL"] = "glfw"
    what = _what(options)
    screen = Screen(options)
    failed = []

    def ended(run: rmj.Run) -> None:
        if run.status is not rmj.Status.OK:
            failed.append(run)
            complain(f"{run.experiment.name}: {run.status}: {run.message}")

    rmj.view(
        what,
        speed=options.speed,
        start=options.start,
        stop=options.stop,
        once=options.once,
        options=looks(options),
        note=screen.note,
        ended=ended,
        web=options.web,
        port=options.port,
    )
    return NOT_WELL if failed else DONE


def _what(options: Namespace) -> rmj.Run | rmj.Experiment:
    """The run, or else the experiment, that the options ask for."""
    if not _is_run(options.experiment):
        return keys_as_options.experiment(options)
    given = [f"--{key}" for key in options.changes] + ["--robot"] * (options.robot is not None)
    if given:
        raise ExperimentError(
            f"{options.experiment}: a run is shown as it was: leave out {', '.join(given)}, or "
            "give the name or path of its experiment, which is simulated anew"
        )
    return rmj.Run.load(options.experiment)


def _is_run(given: str | None) -> bool:
    """Whether a folder of a run is meant: one with a run in it is, whatever else has its name."""
    path = Path(given or "")
    if given is None or given in library.experiments():
        return given is not None and (path / "run.nc").is_file()
    return path.is_dir() or (len(path.parts) > 1 and path.suffix != ".toml" and not path.is_file())
