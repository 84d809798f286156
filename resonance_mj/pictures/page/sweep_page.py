"""What a report says of a sweep: its best runs, its maps, and how the others ended."""

from __future__ import annotations

import json
from collections import Counter
from itertools import product
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray as xr

from ...errors import OutputError
from ...experiments import toml
from ...progress import Progress
from ...springs.cost import KINDS
from ...sweeps.dataset import SETTINGS, WHOLE
from ...text import joined, minus
from ..figures import sweep_figure
from .page import WIDTH, element, html

BEST, MOST = 5, 400
"""Runs that the table of the best has, and lines that the one of all has at most."""

METRICS = {
    "torque_share": ("What springs do", "Share of the possible reduction of torque²."),
    "cycles_to_optimum": ("How soon", "First cycle from which on torque² is at the optimum's."),
    "tracking_rms": ("How near the path", "RMS error of the tool in the last cycle."),
}
"""Figures of the page: title and caption."""

FIGURES = {
    "reduction": "torque_reduction",
    "optimum": "torque_reduction_optimal",
    "left": "torque_squared",
    "rms": "tracking_rms",
    "cycle": "cycles_to_optimum",
}
"""Columns of the tables, and the variables that they are where torque² is to be least."""

OF_COST = {"reduction": "cost_reduction", "optimum": "cost_reduction_optimal", "left": "cost"}
"""The same where all runs ask for the least of something else."""


class Drawing(NamedTuple):
    """A figure's name, title and caption."""

    name: str
    title: str
    caption: str


def page(folder: Path, data: xr.Dataset, title: str | None, progress: Progress) -> str:
    """The report of a sweep, as a page.

    Args:
        folder: of the sweep.
        data: of all its runs.
        title: of the page; which experiment it is of if None.
        progress: is called with the number of figures done and that of all.

    Raises:
        OutputError: the folder does not say of which sweep it is, or holds another.
    """
    try:
        settings = json.loads((folder / SETTINGS).read_bytes())
        keys = list(settings["keys"])
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise OutputError(f"{folder / SETTINGS}: does not say what was swept: {error}") from None
    cost = str(data.attrs.get("cost", "torque-squared"))
    shown = FIGURES | (OF_COST if cost in KINDS and cost != "torque-squared" else {})
    least = KINDS.get(cost, KINDS["torque-squared"])
    if lacking := {"status", "message", "motion", *shown.values(), *keys} - set(data.variables):
        raise OutputError(f"{folder / WHOLE}: lacks {joined(sorted(lacking))}")
    rows = _rows(data, keys, shown)
    motions = data["motion"].values.tolist()
    good = {
        m: [row for row in rows if row["motion"] == m and row["status"] == "ok"] for m in motions
    }
    runs = data["status"].values.ravel().tolist()
    drawn = []
    share = shown["reduction"].replace("reduction", "share")
    metrics = {name.replace("torque_share", share): one for name, one in METRICS.items()}
    known = {name: one for name, one in metrics.items() if sweep_figure.known(data, name)}
    for done, (name, (head, caption)) in enumerate(known.items(), 1):
        figure = sweep_figure.figure(data, name, WIDTH)
        caption = caption.replace("torque²", least.name)
        drawn.append((Drawing(name, head, caption), element(figure, f"sweep-{name}", head)))
        progress(done, len(known))
    of = f"sweep of {settings['experiment']}"
    return html(
        "sweep.html",
        title=title or of,
        lead=_lead(runs, keys),
        swept=keys,
        least=least,
        best={m: sorted(some, key=_left)[:BEST] for m, some in good.items() if some},
        figures=drawn,
        ended=_ended(rows, keys),
        rows=rows if len(rows) <= MOST else [],
        count=len(runs),
        settings=_as_toml(settings),
        scene=None,
    )


def _rows(data: xr.Dataset, keys: list[str], shown: dict[str, str]) -> list[dict[str, Any]]:
    """Each motion of each run: the values of its keys, and its figures; one if it has no motion."""
    grid = "run" not in data.dims
    axes = [data[key].values.tolist() for key in keys]
    points = list(product(*axes)) if grid else list(zip(*axes, strict=True))
    order = keys if grid else ["run"]
    status, message = (
        data[name].transpose(*order).values.ravel() for name in ("status", "message")
    )
    each = {
        short: data[name].transpose(*order, "motion").values.reshape(len(points), -1)
        for short, name in shown.items()
    }
    found = []
    for at, point in enumerate(points):
        for column, motion in enumerate(data["motion"].values.tolist() or [None]):
            figures: dict[str, float | None] = dict.fromkeys(each)
            for short, values in each.items():
                if motion is not None and np.isfinite(values[at, column]):
                    figures[short] = float(values[at, column])
            cycle = figures["cycle"]
            found.append(
                {
                    "at": at,
                    "values": [_value(one) for one in point],
                    "motion": motion,
                    "status": str(status[at]),
                    "message": str(message[at]),
                    **figures,
                    "cycle": None if cycle is None else int(cycle),
                }
            )
    return found


def _left(row: dict[str, Any]) -> float:
    return np.inf if row["left"] is None else float(row["left"])


def _value(value: Any) -> str:
    return minus(f"{value:g}") if isinstance(value, float) else str(value)


def _lead(statuses: list[str], keys: list[str]) -> str:
    """How many runs there are, over what, and how they ended."""
    counts = Counter(statuses)
    ended = joined([f"{count} {status}" for status, count in counts.most_common()])
    return f"{len(statuses)} runs over {joined(keys)}: {ended}."


def _ended(rows: list[dict[str, Any]], keys: list[str]) -> list[dict[str, Any]]:
    """How many runs ended in each way that is not ok, and the first of each."""
    runs = list({row["at"]: row for row in rows}.values())
    counts = Counter(row["status"] for row in runs if row["status"] != "ok")
    found = []
    for status, count in counts.most_common():
        one = next(row for row in runs if row["status"] == status)
        at = ", ".join(f"{key} = {value}" for key, value in zip(keys, one["values"], strict=True))
        found.append({"status": status, "count": count, "at": at, "message": one["message"]})
    return found


def _as_toml(settings: dict[str, Any]) -> str:
    """The sweep's file, with what is not asked of a grid left out."""
    own = {"count", "method", "seed"} if settings.get("how") == "grid" else set()
    given = {
        key: value
        for key, value in settings.items()
        if key not in ("experiments", *own) and value not in (None, False, {})
    }
    return toml.document(given)
