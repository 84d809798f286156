"""How much of the optimum each law keeps under each imperfection of a real arm."""

from __future__ import annotations

import csv
import io
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from ..experiments.experiment import Experiment
from ..files import writable, write
from ..laws.learning import low_pass
from ..plan.plan import Plan, plan_for
from ..progress import Asked
from ..results.cycles import Cycle, kept
from ..results.metrics import LEAST_REDUCTION
from ..results.run import Run
from ..simulation.simulation import simulate_many
from ..springs.bounds import Bounds
from ..springs.cost import KINDS, mean_cost
from ..springs.elements import NO_ELEMENTS
from ..springs.fit import LinearSprings, fit
from ..status import Status
from ..text import NOTHING, minus, number
from .comparison import Contender, contending

CYCLES, LAST = 40, 5
"""Cycles of each motion, and how many of the last the torque is a mean of."""

LAWS = ("feedback", "learning", "printed-lead", "joint-space", "transfer")
"""Of the laws that `compare` compares those that stand here, and two more."""

MORE = (
    Contender("motor-torque", "by motor torque", {"law.kind": "motor-torque"}),
    Contender(
        "wrong-model",
        "computed torque, model 10 % wrong",
        {"law.kind": "computed-torque", "law.overestimate": 0.1},
    ),
)

HARMONICS = 20
"""Of the torque that a motion needs; beyond them is what feedback makes of noise."""


Strength = float | str
"""In the imperfection's unit; of presets the name."""


class Imperfection(NamedTuple):
    """What is not ideal, at three strengths."""

    name: str
    unit: str
    strengths: tuple[Strength, Strength, Strength]

    def changes(self, strength: Strength, plan: Plan) -> dict[str, Any]:
        """Keys of an experiment, which is planned already."""
        experiment = plan.experiment
        if isinstance(strength, str):
            return {"reality": strength}
        if self.name == "payload":
            mass = strength / 100 * float(plan.robot.model.body_subtreemass[0])
            return {f"motion.{i}.payload": mass for i in range(len(experiment.motion))}
        if self.name == "motors":
            peaks = [np.abs(best.torque).max(axis=0) for best in plan.optima]
            most = np.maximum(strength / 100 * np.max(peaks, axis=0), 1e-6)
            return {"reality.motor_torque": most.tolist()}
        return {f"reality.{self.name}": strength / SCALES.get(self.unit, 1.0)}


SCALES = {"ms": 1e3, "%": 1e2}

IMPERFECTIONS = (
    Imperfection("encoder_noise", "rad", (1e-4, 3e-4, 1e-3)),
    Imperfection("encoder_resolution", "rad", (5e-5, 4e-4, 1.5e-3)),
    Imperfection("measurement_delay", "ms", (2.0, 5.0, 10.0)),
    Imperfection("torque_delay", "ms", (2.0, 5.0, 10.0)),
    Imperfection("control_period", "ms", (2.0, 5.0, 10.0)),
    Imperfection("friction", "%", (1.0, 10.0, 30.0)),
    Imperfection("spring_stiffening", "1/rad²", (0.2, 0.5, 2.0)),
    Imperfection("spring_hysteresis", "%", (5.0, 10.0, 20.0)),
    Imperfection("link_error", "%", (0.2, 1.0, 5.0)),
    Imperfection("motors", "%", (150.0, 125.0, 105.0)),
    Imperfection("payload", "%", (10.0, 20.0, 40.0)),
    Imperfection("preset", "", ("encoder", "lab", "cheap")),
)
"""Motors in percent of what the best springs leave at their peak, payloads of the file's mass."""


MARKS = {
    Status.NOT_TRACKING: ("off path", "off"),
    Status.DIVERGED: ("diverged", "×"),
    Status.DIVERGING: ("diverging", "↑"),
    Status.IN_CONTACT: ("in contact", "hit"),
    Status.NOISY: ("noisy", "~"),
}
"""What is said of a run in the map in place of its figure, and in short."""


@dataclass(frozen=True)
class Cell:
    """A law under an imperfection, the worst of the motions.

    Attributes:
        law: its name.
        imperfection: its name, or "ideal".
        strength: in the imperfection's unit, or a preset's name; 0 for ideal.
        share: of the possible reduction of torque² that the springs found would give; None where
            the run did not come to its end, or no spring can help.
        kept: reduction of torque² that the motors gave, as a share of what is possible; likewise.
        tracking_rms: of the tool in the last cycle [m]; likewise.
        status: how the run ended.
        message: why.
    """

    law: str
    imperfection: str
    strength: Strength
    share: float | None
    kept: float | None
    tracking_rms: float | None
    status: str
    message: str


@dataclass(frozen=True)
class RobustnessMap:
    """Laws beside each other under imperfections.

    Attributes:
        experiment: on which they are compared.
        titles: what each law is called, by its name.
        cells: each law under each imperfection at each strength, laws within imperfections.
    """

    experiment: Experiment
    titles: dict[str, str]
    cells: tuple[Cell, ...]

    @property
    def cost(self) -> str:
        """What the springs leave the least of."""
        return KINDS[self.experiment.springs.cost].name

    def save(self, folder: Any) -> str:
        """Write the cells as a table for a spreadsheet; returns the file's name.

        Raises:
            OutputError: the folder cannot be written.
        """
        text = io.StringIO()
        table = csv.DictWriter(text, list(Cell.__dataclass_fields__), lineterminator="\n")
        table.writeheader()
        table.writerows(vars(cell) for cell in self.cells)
        write(writable(folder), {"robustness.csv": text.getvalue().encode()})
        return "robustness.csv"


def robustness(
    experiment: Experiment, *, threads: int = 0, progress: Asked = None
) -> RobustnessMap:
    """Simulate an experiment under each law and each imperfection at three strengths.

    Args:
        experiment: an ideal one; each motion is repeated 40 times after the passage into it that is
            found, and each law has its default gains.
        threads: how many to use; 0 for all cores.
        progress: as for `simulate_many`.

    Raises:
        RobotError: the robot cannot be loaded.
        MotionError: a motion leaves the arm's reach or passes through a singular pose.
    """
    motions: dict[str, Any] = {"simulation.samples": 1}  # the last cycle of each is enough
    for i, one in enumerate(experiment.motion):
        motions |= {f"motion.{i}.duration": CYCLES * one.period, f"motion.{i}.blend": None}
    # Gains that somebody chose for an ideal arm would be compared, not laws.
    base = experiment.replace({"law": {}}).replace(motions)
    plan = plan_for(base, looks=False)
    given = {law.name: (law, one) for law, one in contending(base)}
    laws = [given[name] for name in LAWS]
    laws += [(law, base.replace(law.changes)) for law in MORE]
    ideal: list[tuple[str, Strength, dict[str, Any]]] = [("ideal", 0.0, {})]
    rows = ideal + [
        (one.name, strength, one.changes(strength, plan))
        for one in IMPERFECTIONS
        for strength in one.strengths
    ]
    each = [one.replace(changes) for _, _, changes in rows for _, one in laws]
    runs = simulate_many(each, threads=threads, progress=progress)
    names = [(law.name, name, strength) for name, strength, _ in rows for law, _ in laws]
    cells = tuple(Cell(*at, **figures(run)) for at, run in zip(names, runs, strict=True))
    return RobustnessMap(base, {law.name: law.title for law, _ in laws}, cells)


def figures(run: Run) -> dict[str, Any]:
    """What a run kept, in its worst motion: share, kept, tracking_rms, status, message of a `Cell`.

    None for what it did not come to, and for shares where no spring can help.
    """
    found: dict[str, Any] = dict.fromkeys(("share", "kept", "tracking_rms"))
    if all(len(one.cycles) >= LAST for one in run.motions) and run.status is not Status.DIVERGED:
        last = {cycle.motion: cycle for cycle in kept(run)}
        each = [_share(last[i], run.plan.gains.bounds) for i in range(len(run.motions))]
        kept_of = [float(motion.share[-LAST:].mean()) for motion in run.motions]
        found["tracking_rms"] = max(float(motion.tracking_rms[-1]) for motion in run.motions)
        for name, values in (("share", each), ("kept", kept_of)):
            if np.isfinite(values).any():
                found[name] = float(np.nanmin(values))
    return found | {"status": str(run.status), "message": run.message}


def _share(cycle: Cycle, bounds: Bounds) -> float:
    """What a cycle's springs would save of what the best would; NaN where no spring can help.

    Those of laws that change them within a cycle are taken at their mean, and the torque that the
    motion needs without what feedback makes of noise.
    """
    q, dq, made_of = cycle.q, cycle.dq, (NO_ELEMENTS, bounds.material)
    exerted = LinearSprings(cycle.stiffness, cycle.offset, cycle.center, *made_of).torque(q, dq)
    total = low_pass(cycle.tau + exerted, HARMONICS)
    means = cycle.stiffness.mean(axis=0), cycle.offset.mean(axis=0)
    mean = LinearSprings(*means, cycle.center, *made_of)
    best = fit(q, total, bounds, cycle.center, dq)
    needed, left, least = (
        mean_cost(bounds.objective, torque, cycle.dq)
        for torque in (total, total - mean.torque(q, dq), total - best.torque(q, dq))
    )
    possible = needed - least
    return (needed - left) / possible if possible > LEAST_REDUCTION * needed else np.nan


def written(cell: Cell, *, short: bool = False) -> str:
    """A cell in words: the reduction kept, or how the run ended if not well.

    The torque of a tool that is off its path is that of another motion.
    """
    if cell.status != Status.OK:
        words = MARKS.get(Status(cell.status), (cell.status, cell.status))
        return words[short]
    if cell.kept is None:
        return NOTHING
    kept = number(100 * cell.kept, 0) if cell.kept > -1 else f"{1 - cell.kept:.0f} ×"
    return minus(kept)


def described(name: str, strength: Strength) -> str:
    """A row of the map in words."""
    if isinstance(strength, str):
        return f"{name} {strength}"
    one = next((each for each in IMPERFECTIONS if each.name == name), None)
    if one is None:
        return name
    of = {"motors": "motors at", "payload": "payload of"}.get(name, name.replace("_", " "))
    return f"{of} {strength:g} {one.unit}"
