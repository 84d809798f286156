"""The commands that take saved runs: plot, certify, render, view and report."""

from __future__ import annotations

from argparse import Namespace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import resonance_mj as rmj

from ..errors import ExperimentError, OutputError, PictureError
from ..files import writable
from ..pictures.figures.catalogue import DPI, FIGURES, FORMATS
from ..progress import bar
from .command import Argument, Screen, argument, command, flag

if TYPE_CHECKING:
    from ..evaluation.certificates.certificates import Certificates

PARTS = {
    "path": "the desired path",
    "trail": "the tool's recent trail",
    "springs": "springs and equilibria",
    "motors": "the motors' torque",
    "plots": "the plots below",
    "head-up": "the line above",
    "legend": "what the overlays mean",
}
"""What can be left out of a picture, by the names of RenderOptions."""

SPAN = (
    argument("--from", "seconds, or a cycle: 8c begins with the 8th", dest="start", metavar="TIME"),
    argument("--to", "seconds, or a cycle: 10c ends with the 10th", dest="stop", metavar="TIME"),
)


def _runs(meaning: str) -> Argument:
    return argument("runs", f"a run's folder{meaning}", metavar="RUN", type=Path, nargs="+")


def picture(backgrounds: str, parts: dict[str, str]) -> list[Argument]:
    """The arguments that `looks` reads, with these backgrounds and parts to leave out."""
    return [
        argument(
            "--camera",
            "of the model, or azimuth,elevation,distance as in --camera=120,-20,1.5; "
            "one that frames the motion",
            metavar="NAME|VIEW",
        ),
        flag("--follow", "go with the tool"),
        argument(
            "--orbit",
            "go around the arm, degrees per second of the run",
            metavar="SPEED",
            type=float,
            default=0.0,
        ),
        argument("--background", f"{backgrounds}; sky", metavar="KIND", default="sky"),
        *(flag(f"--no-{part}", f"leave out {meaning}") for part, meaning in parts.items()),
    ]


def looks(options: Namespace, **more: Any) -> rmj.RenderOptions:
    """What the options of `picture` ask for, and `more`."""
    names = (part.replace("-", "_") for part in PARTS)
    more |= {name: not getattr(options, f"no_{name}", False) for name in names}
    return rmj.RenderOptions(
        camera=options.camera,
        follow=options.follow,
        orbit=options.orbit,
        background=options.background,
        **more,
    )


@command(
    _runs(", such as runs/paper, or a sweep's; several runs: compared in one figure"),
    argument(
        "--figure",
        f"{', '.join(entry.name for entry in FIGURES)}; again or with commas for several; "
        "all that the runs have samples for",
        dest="figures",
        metavar="NAME",
        action="append",
    ),
    argument("--format", "any of svg,png,pdf; svg,png", metavar="KIND", default=",".join(FORMATS)),
    argument("--width", "column, page, or inches; page: 7.16", metavar="WIDTH", default="page"),
    argument("--dpi", f"pixels per inch of a PNG; {DPI:g}", metavar="N", type=float, default=DPI),
    argument("--height", "inches; what the panels need", metavar="INCHES", type=float),
    flag("--title", "say above a figure what was run"),
    argument("--font", "family of the letters; matplotlib's own", metavar="NAME"),
    argument("--font-size", "of labels [pt]; 8", metavar="PT", type=float, default=8.0),
    argument("--out", "where to write; the first run's folder", metavar="FOLDER", type=Path),
)
def plot(options: Namespace) -> None:
    """Draw the figures of a saved run, or several runs in one figure."""
    from ..sweeps.dataset import opened

    names = [name for given in options.figures or [] for name in given.split(",")]
    of_sweep = options.runs[0] / "sweep.nc"
    if of_sweep.is_file() and len(options.runs) > 1:
        raise ExperimentError(f"{options.runs[0]}: is a sweep; a sweep is drawn alone")
    written = rmj.plot(
        opened(of_sweep) if of_sweep.is_file() else [rmj.Run.load(one) for one in options.runs],
        options.out or options.runs[0],
        figures=names or None,
        formats=options.format.split(","),
        width=options.width,
        dpi=options.dpi,
        height=options.height,
        title=options.title,
        font=options.font,
        font_size=options.font_size,
    )
    screen = Screen(options)
    for path in written:
        screen.line(path)


@command(
    argument("run", "a run's folder, such as runs/paper", metavar="RUN", type=Path),
    argument("--out", "where to draw; the run's folder", metavar="FOLDER", type=Path),
    figures=True,
)
def certify(options: Namespace) -> None:
    """Check on a saved run what the stability proof claims."""
    from . import tables

    run, screen = rmj.Run.load(options.run), Screen(options)
    folder = writable(options.out or options.run)
    found, names = certified(run, folder)
    screen.table(certificates(found), tables.certificates(found))
    for name in names:
        screen.line(folder / name)


@command(
    argument("run", "a run's folder, such as runs/paper", metavar="RUN", type=Path),
    argument("--catalogue", "CSV of springs that can be bought", metavar="FILE", type=Path),
    argument(
        "--together",
        "one set of parts for all motions: the least in the mean, or of the worst",
        choices=("mean", "worst"),
    ),
    figures=True,
)
def springs(options: Namespace) -> None:
    """Say what springs a saved run asks for, which of a catalogue serve, and what they save."""
    from ..evaluation.spring_catalogue import read
    from ..evaluation.spring_parts import spring_parts
    from ..evaluation.spring_selection import selections
    from . import spring_tables

    run, screen = rmj.Run.load(options.run), Screen(options)
    if options.together and not options.catalogue:
        raise OutputError("--together chooses from a catalogue: give --catalogue FILE")
    catalogue = read(options.catalogue) if options.catalogue else ()
    found = spring_parts(run)
    chosen = selections(found, catalogue, options.together) if catalogue else ()
    data = spring_tables.data(found, chosen)
    screen.table(data, *spring_tables.parts(found), *spring_tables.chosen(found, chosen))


def certified(run: rmj.Run, folder: Path) -> tuple[Certificates, list[str]]:
    """Find and draw a run's certificates; with the names of the files that were written."""
    from ..pictures.figures import certificate_figure
    from ..pictures.figures.catalogue import save

    found = rmj.certify(run)
    drawn = save(certificate_figure.figure(found), folder, "certificates")
    return found, [path.name for path in drawn]


def certificates(found: Certificates) -> list[dict[str, Any]]:
    """Certificates as data."""
    figures = ("motion", "holds", "worst", "where", "note", "cycles", "values")
    return [
        item.claim._asdict() | {name: getattr(item, name) for name in figures}
        for item in found.items
    ]


@command(
    _runs("; several: side by side"),
    argument("-o --output", ".mp4, .webp or .gif; RUN/motion.mp4", metavar="FILE", type=Path),
    *SPAN,
    argument("--speed", "seconds of the run per second of video; 1", type=float, default=1.0),
    argument("--fps", "frames per second; 30", type=float, default=30.0),
    argument("--size", "of the picture [pixels]; 1280x720", metavar="WxH", default="1280x720"),
    *picture("sky, white, dark or transparent", PARTS),
    argument("--label", "what the picture calls a run; one each", dest="labels", action="append"),
    argument("--workers", "processes that draw; one per core", metavar="N", type=int),
)
def render(options: Namespace) -> None:
    """Film a saved run, or several side by side and in step."""
    chosen = looks(options, size=_size(options.size))
    runs = [rmj.Run.load(folder) for folder in options.runs]
    labels = options.labels
    if labels is None and len({run.experiment.name for run in runs}) < len(runs):
        labels = [folder.resolve().name for folder in options.runs]
    path = options.output or options.runs[0] / "motion.mp4"
    screen = Screen(options)
    with bar(path.name, "frames", screen.console) as show:
        written = rmj.render(
            runs,
            path,
            options.start,
            options.stop,
            options.fps,
            speed=options.speed,
            options=chosen,
            labels=labels,
            workers=options.workers,
            progress=show,
            note=screen.note,
        )
    screen.line(written)


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    if not (width.isdecimal() and height.isdecimal()):
        raise PictureError(f"size {text!r}: give width and height in pixels, as in 1280x720")
    return int(width), int(height)


@command(
    _runs(", or a sweep's; several runs: compared"),
    argument(
        "-o --output",
        "RUN/report.html; of several, comparison.html in the first one's folder",
        metavar="FILE",
        type=Path,
    ),
    argument("--title", "of the page; the names of the runs"),
    argument("--label", "what the page calls a run; one each", dest="labels", action="append"),
    flag("--no-video", "leave out the video, which takes most of the time"),
)
def report(options: Namespace) -> None:
    """Write a run, several beside each other, or a sweep as one page to read and to send."""
    screen = Screen(options)
    with bar("report", "pictures", screen.console) as show:
        written = rmj.report(
            options.runs,
            options.output,
            video=not options.no_video,
            title=options.title,
            labels=options.labels,
            progress=show,
            note=screen.note,
        )
    screen.line(f"{written}: {written.stat().st_size / 1e6:.1f} MB")
