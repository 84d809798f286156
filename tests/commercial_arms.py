"""Seven arms of robosuite's wheel, as cases for the law: `python tests/commercial_arms.py`.

The table that this prints is the second one in docs/robots.md.
"""

from __future__ import annotations

from dataclasses import dataclass

import wheels
from public_arms import Outcome, outcome

import resonance_mj as rmj
from resonance_mj.experiments.experiment import Experiment
from resonance_mj.experiments.loading import for_robot

# The usual home poses [rad], from each arm's init_qpos in the wheel.
USUAL_HOME = {
    "panda": (0.0, 0.19635, 0.0, -2.61799, 0.0, 2.94159, 0.785398),
    "ur5e": (-0.470, -1.735, 2.480, -2.275, -1.590, -1.991),
    "iiwa": (0.0, 0.650, 0.0, -1.890, 0.0, 0.600, 0.0),
    "kinova3": (0.0, 0.650, 0.0, 1.890, 0.0, 0.600, -1.570796),
    "jaco": (3.192, 3.680, 0.0, 1.170, 0.050, 3.760, 3.142),
    "sawyer": (0.0, -1.18, 0.0, 2.18, 0.0, 0.57, -1.57),
    "xarm7": (0.0, 0.0, 0.0, 1.225221, 0.0, 1.225221, 0.0),
}

POSE = ("x", "y", "z", "rotation")
EIGHT_CM = {"period": 1.0, "duration": 20.0, "shape": "ellipse", "size": (0.08, 0.08)}


@dataclass(frozen=True)
class Case:
    """One arm, one home pose, one task, one motion."""

    arm: str
    home: str
    task: str
    motion: str

    def experiment(self) -> Experiment:
        """The experiment: nothing but the file is given where the case says found or default."""
        changes: dict[str, object] = {}
        if self.home == "usual":
            changes["robot.home"] = USUAL_HOME[self.arm]
        if self.task == "pose":
            changes["task.coordinates"] = POSE
        if self.motion == "8 cm":
            changes["motion"] = [EIGHT_CM]
        return for_robot(
            str(wheels.folder("robosuite") / "robots" / self.arm / "robot.xml")
        ).replace(changes)


CASES = [
    Case(arm, home, task, motion)
    for arm in USUAL_HOME
    for home in ("found", "usual")
    for task in ("position", "pose")
    for motion in ("default", "8 cm")
]


SAID = {
    Case("iiwa", "usual", "pose", "8 cm"): "takes joint_4 .* beyond its range",
    Case("xarm7", "found", "pose", "default"): "a larger law.omega",
    Case("xarm7", "found", "pose", "8 cm"): "a larger law.omega",
}
"""What is said of the cases that do not come to the optimum: one leaves the range of a joint, and
the light wrist of another turns against its dry friction."""


def measure(case: Case) -> tuple[rmj.Run, Outcome]:
    """Run a case, and judge it."""
    run = rmj.simulate(case.experiment())
    return run, outcome(run)


HEADS = (
    "| arm | home | task | motion | status | less torque² than without springs | torque² / bounded "
)
HEADS += (
    "optimum of the motion made | position RMS [mm] | rotation RMS [mrad] | first cycle at the "
)
HEADS += "optimum |"


def row(case: Case, run: rmj.Run, found: Outcome) -> str:
    """A row of the table."""
    (motion,), judged = run.motions, found.judged
    turned = f"{motion.rotation_rms[-1] * 1e3:.2f}" if case.task == "pose" else ""
    return (
        f"| {case.arm} | {case.home} | {case.task} | {case.motion} | {run.status} | "
        f"{1 - judged.torque_squared / judged.without:.2%} | {judged.ratio:.4f} | "
        f"{judged.rms * 1e3:.3f} | {turned} | {motion.cycles_to_optimum or 'never'} |"
    )


def main() -> None:
    """Print the table."""
    print(HEADS + "\n" + "|---" * (HEADS.count("|") - 1) + "|")
    for case in CASES:
        print(row(case, *measure(case)), flush=True)


if __name__ == "__main__":
    main()
