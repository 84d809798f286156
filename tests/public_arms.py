"""Arms that others made, run as a user would: `python tests/public_arms.py arms`, homes or shapes.

arms: every file of public_arms.toml with nothing else given, the first table of docs/robots.md.
homes: four arms, position and pose, from 160 seeded random home poses, or the first so many.
shapes: the same arms, 127 seeded motions of other shapes, periods and sizes, or the first so many.

All are judged by judge.py, which reads none of the program's own figures.
"""

from __future__ import annotations

import re
import sys
import tomllib
from collections import Counter
from collections.abc import Iterable, Mapping
from concurrent.futures import ProcessPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import wheels
from judge import CLAIMED, OF_TORQUE, Judgement, judge

import resonance_mj as rmj
from resonance_mj.experiments.loading import for_robot
from resonance_mj.plan.plan import plan_for
from resonance_mj.text import Caution

PROCESSES = 2

OPTIMUM = "optimum"
"""Expected of an arm that does what is asked; else a regular expression of what must be said."""

TABLE = Path(__file__).with_suffix(".toml")

FOUR = ("ur5e", "panda", "iiwa", "seven_joint")
"""Arms of `homes` and `shapes`: three of robosuite's, and one that comes with the program."""

POSE = ("x", "y", "z", "rotation")


@dataclass(frozen=True)
class Arm:
    """A file of a wheel, keys that are given besides, and what is expected."""

    wheel: str
    file: str
    changes: Mapping[str, str]
    expected: str

    @property
    def name(self) -> str:
        """As in the table."""
        return " ".join((f"{self.wheel}: {self.file}", *map("=".join, self.changes.items())))

    @property
    def path(self) -> Path:
        """Of the file."""
        return wheels.folder(self.wheel) / self.file


@dataclass(frozen=True)
class Outcome:
    """What became of one experiment.

    Attributes:
        status: of the run, or refused.
        said: why it is not simply at the optimum: the message, or the verdict of the motion.
        warned: what was said before the first step that lets one expect trouble.
        wrong: those of them that the run then belied.
        joints: number of joints.
        coordinates: the task's.
        cycle: the first at the optimum, as the program says.
        judged: the judge's figures; None if no cycle was made.
    """

    status: str
    said: str
    warned: tuple[str, ...] = ()
    wrong: tuple[str, ...] = ()
    joints: int = 0
    coordinates: str = ""
    cycle: int | None = None
    judged: Judgement | None = None

    @property
    def at_optimum(self) -> bool:
        """Whether it did what was asked, the judge agreeing."""
        return self.status == "ok" and bool(self.judged and self.judged.good)

    @property
    def wrong_ok(self) -> bool:
        """Whether the program says that all is well and the judge does not."""
        if self.status != "ok":
            return False
        claimed = self.said == "at optimum"
        return not self.judged.follows or (claimed and not self.judged.within(CLAIMED))

    def meets(self, expected: str) -> bool:
        """Whether this is what was expected."""
        if expected == OPTIMUM:
            return self.at_optimum
        said = f"{self.status}: {self.said}"
        return not self.at_optimum and not self.wrong_ok and bool(re.search(expected, said))


ARMS = [
    Arm(wheel, file, dict(one.split("=") for one in given), expected)
    for wheel, arms in tomllib.loads(TABLE.read_text(encoding="utf-8")).items()
    for (file, *given), expected in ((name.split(), said) for name, said in arms.items())
]


def measure(path: str, changes: Mapping[str, Any]) -> Outcome:
    """Run a robot's file with some keys given, and judge the run."""
    try:
        run = rmj.simulate(for_robot(path).replace(changes))
    except rmj.ResonanceError as error:
        return Outcome("refused", str(error))
    return outcome(run)


def outcome(run: rmj.Run) -> Outcome:
    """Judge a run."""
    robot, motion = run.plan.robot, run.motions[0]
    warned = tuple(
        note
        for note in run.plan.notes
        if isinstance(note, Caution) and any(sign in note for sign in SIGNS)
    )
    judged = judge(run) if len(motion.cycles) else None
    return Outcome(
        status=str(run.status),
        said=run.message or motion.verdict,
        warned=warned,
        wrong=tuple(note for note in warned if belied(note, run, judged)),
        joints=robot.n,
        coordinates=" ".join(robot.axes),
        cycle=motion.cycles_to_optimum,
        judged=judged,
    )


SIGNS = {
    "comes near a singular pose: the": "singular",
    "beyond its range": "range",
    " touch ": "touches",
    "even with the best springs": "motor",
    "unstable when sampled": "feedback",
    "learning diverges": "learning",
}
"""Words of the notes before a run that let one expect trouble, and what it is."""


def belied(note: str, run: rmj.Run, judged: Judgement | None) -> bool:
    """Whether what a note said before a run did not come about in its last cycle."""
    kind = next(kind for sign, kind in SIGNS.items() if sign in note)
    if judged is None or not judged.good or run.status is not rmj.Status.OK:
        return False
    if "and this run ends" in note:
        return False
    return not {
        "singular": judged.singular,
        "range": judged.at_range,
        "motor": judged.at_motor,
    }.get(kind, False)


def all_of(jobs: Iterable[tuple[str, Mapping[str, Any]]]) -> Iterable[Outcome]:
    """Outcomes of many experiments, in order."""
    with ProcessPoolExecutor(PROCESSES) as pool:
        futures = [pool.submit(measure, path, changes) for path, changes in jobs]
        for future in futures:
            yield future.result()


HEADS = (
    "| arm | joints | task | status | torque² / optimum | RMS [mm] | of the path | at the optimum "
)
HEADS += "from cycle | what is said |"


def row(arm: Arm, found: Outcome) -> str:
    """A row of the table."""
    judged, said = found.judged, "" if found.at_optimum else found.said
    cells = [arm.name, found.joints or "", found.coordinates, found.status]
    if judged:
        needed = judged.optimum > OF_TORQUE * judged.without
        cells += [f"{judged.ratio:.3f}" if needed else "none needed", f"{judged.rms * 1e3:.3f}"]
        cells += [f"{judged.rms / judged.size:.2%}", found.cycle or "never"]
    else:
        cells += [""] * 4
    for folder in (arm.path.parent, wheels.folder(arm.wheel)):
        said = said.replace(f"{folder}/", "")
    cells.append(said if found.meets(arm.expected) else f"**not as expected** {said}")
    return "| " + " | ".join(str(cell).replace("|", "/") for cell in cells) + " |"


def arms() -> None:
    """Print the table of docs/robots.md."""
    print(HEADS + "\n" + "|---" * (HEADS.count("|") - 1) + "|")
    right, wrong_ok = 0, []
    for arm, found in zip(ARMS, all_of((str(a.path), a.changes) for a in ARMS), strict=True):
        print(row(arm, found), flush=True)
        right += found.meets(arm.expected)
        wrong_ok += [arm.name] * found.wrong_ok
    print(f"\n{right} of {len(ARMS)} as expected, {len(wrong_ok)} wrong OKs {wrong_ok or ''}")


def _file(name: str) -> str:
    if name == "seven_joint":
        return f"{name}.xml"
    return str(wheels.folder("robosuite") / "robots" / name / "robot.xml")


def homes(many: int) -> list[tuple[str, dict[str, Any]]]:
    """Random home poses within 80 % of the joints' ranges, the first so many of 160."""
    jobs = []
    for index, name in enumerate(FOUR):
        robot = plan_for(for_robot(_file(name))).robot
        low, high = robot.model.jnt_range[robot.joint_id].T
        low, high = np.where(robot.limited, [low, high], [[-np.pi], [np.pi]])
        rng = np.random.default_rng([12, index])
        for k in range(40):
            q = (low + high) / 2 + 0.8 * (high - low) / 2 * rng.uniform(-1, 1, robot.n)
            changes: dict[str, Any] = {"robot.home": [round(angle, 4) for angle in q.tolist()]}
            if k % 2:
                changes["task.coordinates"] = POSE
            jobs.append((k, (_file(name), changes)))
    return [job for _, job in sorted(jobs, key=lambda job: job[0])][:many]


def shapes(many: int) -> list[tuple[str, dict[str, Any]]]:
    """Motions at the homes that the program finds, the first so many of 127."""
    rng, jobs = np.random.default_rng(12), []
    planes = [("x", "y"), ("x", "z"), ("y", "z")]
    for k in range(127):
        period = round(0.5 * 8 ** rng.uniform(), 2)
        size = 0.02 * 10 ** rng.uniform()
        motion: dict[str, Any] = {
            "shape": ("ellipse", "line", "eight", "polygon")[rng.integers(4)],
            "period": period,
            "duration": round(20 * period, 2),
            "size": [round(size, 4), round(size * rng.uniform(0.3, 1), 4)],
            "plane": planes[rng.integers(3)],
        }
        if motion["shape"] == "polygon":
            motion["corners"] = int(rng.integers(3, 7))
        changes: dict[str, Any] = {"motion": [motion]}
        if k // 4 % 2:
            changes["task.coordinates"] = POSE
        jobs.append((_file(FOUR[k % 4]), changes))
    return jobs[:many]


def count(jobs: list[tuple[str, dict[str, Any]]]) -> None:
    """Run them, print what was not at the optimum, and count."""
    counts, kinds, wrong, caution, said = Counter(), Counter(), Counter(), Counter(), 0
    for (path, changes), found in zip(jobs, all_of(jobs), strict=True):
        kind = (
            "at the optimum and tracking"
            if found.at_optimum
            else "ok but wrong"
            if found.wrong_ok
            else "ok, but not within 2 % and 1.5 mm"
            if found.status == "ok" and not found.warned
            else "refused before the run"
            if found.status == "refused"
            else "warned before the run, and not at the optimum"
            if found.warned
            else "failed without a word before"
        )
        counts[kind] += 1
        said += len(found.warned)
        kinds.update(_kind(note) for note in found.warned)
        wrong.update(_kind(note) for note in found.wrong)
        caution.update(_kind(note) for note in found.warned if found.at_optimum)
        if not found.at_optimum or found.warned:
            judged = found.judged
            figures = f"ratio {judged.ratio:.4g} RMS {judged.rms * 1e3:.3g} mm" if judged else ""
            arm = Path(path).parent.name or path
            print(f"- {kind}: {arm} {changes}: {found.status} {figures}: {found.said}")
            for note in found.warned:
                print(f"    before{' (WRONG)' if note in found.wrong else ''}: {note}", flush=True)
    print(f"\n{len(jobs)} runs")
    for kind, number in counts.most_common():
        print(f"{number:4} ({number / len(jobs):.1%}) {kind}")
    print(f"{said} messages before a run that was not refused {dict(kinds)}:")
    print(f"{wrong.total()} that the last cycle belied {dict(wrong)}")
    print(f"{caution.total()} before a run that came to the optimum all the same {dict(caution)}")


def _kind(note: str) -> str:
    return next(kind for sign, kind in SIGNS.items() if sign in note)


if __name__ == "__main__":
    what, *how_many = sys.argv[1:] or ["arms"]
    if what == "arms":
        arms()
    else:
        count({"homes": homes, "shapes": shapes}[what](int(how_many[0]) if how_many else 160))
