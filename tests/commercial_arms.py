"""The arms that the robosuite wheel ships, as cases for the law: `python tests/commercial_arms.py`.

The wheel is taken apart, not installed: its MJCF files are all that is needed. The table that this
prints is the one in docs/robots.md.
"""

from __future__ import annotations

import subprocess
import sys
import tempfile
import zipfile
from dataclasses import dataclass
from functools import cache
from pathlib import Path

import resonance_mj as rmj
from resonance_mj.experiments.experiment import Experiment
from resonance_mj.experiments.loading import for_robot
from resonance_mj.springs.optimum import best_springs

WHEEL = "robosuite==1.5.2"

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
        return for_robot(str(robots() / self.arm / "robot.xml")).replace(changes)


CASES = [
    Case(arm, home, task, motion)
    for arm in USUAL_HOME
    for home in ("found", "usual")
    for task in ("position", "pose")
    for motion in ("default", "8 cm")
]


@dataclass(frozen=True)
class Found:
    """What a case came to in its last cycle."""

    run: rmj.Run
    torque_ratio: float
    reduction: float
    tracking_rms: float
    rotation_rms: float


@cache
def robots() -> Path:
    """Folder of the arms' MJCF files, downloaded once per process."""
    folder = Path(tempfile.gettempdir()) / f"resonance-mj-{WHEEL}"
    assets = folder / "robosuite/models/assets/robots"
    if not assets.is_dir():
        folder.mkdir(exist_ok=True)
        pip = [sys.executable, "-m", "pip", "download", "--quiet", "--no-deps", WHEEL]
        subprocess.run([*pip, "--dest", str(folder)], check=True)
        (wheel,) = folder.glob("*.whl")
        with zipfile.ZipFile(wheel) as archive:
            arms = [f"models/assets/robots/{arm}/" for arm in USUAL_HOME]
            names = [name for name in archive.namelist() if any(arm in name for arm in arms)]
            archive.extractall(folder, names)
        wheel.unlink()
    return assets


def measure(case: Case) -> Found:
    """Run a case, and compare its last cycle with the bounded optimum of the motion made."""
    run = rmj.simulate(case.experiment())
    data = run.data
    last = data.sel(time=data["cycle_of_sample"] == data.sizes["cycle"])
    q, center = last["q"].values, last["center"].values
    spring = last["offset"].values - last["stiffness"].values * (q - center)
    best = best_springs(
        q,
        last["tau"].values + spring,
        center=q.mean(axis=0),
        period=1.0,
        bounds=run.experiment.springs,
    )
    return Found(
        run=run,
        torque_ratio=float(data["torque_squared"][-1]) / best.torque_squared,
        reduction=1 - float(data["torque_squared"][-1]) / best.torque_squared_without_springs,
        tracking_rms=float(data["tracking_rms"][-1]),
        rotation_rms=float(data["rotation_rms"][-1]) if "rotation_rms" in data else 0.0,
    )


def main() -> None:
    """Print the table."""
    heads = ("arm", "home", "task", "motion", "status", "less torque² than without springs")
    heads += (
        "torque² / bounded optimum of the motion made",
        "position RMS [mm]",
        "rotation RMS [mrad]",
    )
    heads += ("first cycle at the optimum",)
    print("| " + " | ".join(heads) + " |")
    print("|" + "---|" * len(heads))
    for case in CASES:
        found = measure(case)
        turned = f"{found.rotation_rms * 1e3:.2f}" if case.task == "pose" else ""
        print(
            f"| {case.arm} | {case.home} | {case.task} | {case.motion} | {found.run.status} | "
            f"{found.reduction:.2%} | {found.torque_ratio:.4f} | {found.tracking_rms * 1e3:.3f} | "
            f"{turned} | {found.run.motions[0].cycles_to_optimum or 'never'} |",
            flush=True,
        )


if __name__ == "__main__":
    main()
