"""The command that compares laws."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path

import resonance_mj as rmj

from ..files import could_be_written
from ..progress import bar
from . import keys_as_options
from .command import Screen, argument, command, flag
from .keys_as_options import EXPERIMENT, ROBOT


@command(
    EXPERIMENT,
    ROBOT,
    argument(
        "--long",
        "how often the last motion is repeated to see which law lasts; 1000, and 0 for not",
        metavar="CYCLES",
        type=int,
        default=1000,
    ),
    flag(
        "--reality", "under each imperfection of a real arm at three strengths, with default gains"
    ),
    argument("--out", "where to write; runs/NAME-compare", metavar="FOLDER", type=Path),
    keys=True,
    figures=True,
)
def compare(options: Namespace) -> None:
    """The laws that users compare, on one experiment."""
    experiment = keys_as_options.experiment(options)
    from ..pictures.figures import comparison_figure
    from ..pictures.figures.catalogue import save
    from . import comparison_tables

    folder = could_be_written(options.out or Path("runs") / f"{experiment.name}-compare")
    screen = Screen(options)
    if options.reality:
        _robustness(experiment, folder, screen)
        return
    with bar(f"{experiment.name}: all laws", "cycles", screen.console) as show:
        found = rmj.compare(experiment, long=options.long, progress=show)
    found.save(folder)
    save(comparison_figure.figure(found), folder, "compare")
    screen.table(found.rows(), comparison_tables.comparison(found))
    screen.line(
        f"{folder}: compare.svg, compare.png, compare.json, compare.csv, and a run in each of "
        f"{', '.join(found.runs)}"
    )


def _robustness(experiment: rmj.Experiment, folder: Path, screen: Screen) -> None:
    """Compare the laws under imperfections, and print, draw and write what they keep."""
    from ..evaluation.robustness import robustness
    from ..pictures.figures import robustness_figure
    from ..pictures.figures.asked import PAGE
    from ..pictures.figures.catalogue import save
    from . import comparison_tables

    with bar(f"{experiment.name}: all laws", "cycles", screen.console) as show:
        found = robustness(experiment, progress=show)
    written = [found.save(folder)]
    drawn = save(robustness_figure.figure(found, PAGE), folder, "robustness")
    written += [path.name for path in drawn]
    screen.table([vars(cell) for cell in found.cells], comparison_tables.robustness(found))
    screen.line(f"{folder}: {', '.join(written)}")
