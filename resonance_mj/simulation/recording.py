"""What is kept of a run while it is simulated: whole cycles in time, and every cycle in brief."""

from __future__ import annotations

import math

import numpy as np
import xarray as xr

from ..experiments.experiment import Experiment
from ..laws.memory import COLUMNS, Memory
from ..motions.kinematics import Kinematics
from ..robots.robot import Robot
from ..springs import spring as springs
from ..springs.optimum import Optimum, best_springs

UNITS = {
    "q": "rad",
    "dq": "rad/s",
    "x": "m",
    "x_desired": "m",
    "y": "rad/s",
    "tau": "N m",
    "u": "N m",
    "stiffness": "N m/rad",
    "offset": "N m",
    "equilibrium": "rad",
    "center": "rad",
}
MEANING = {
    "q": "joint angle",
    "dq": "joint velocity",
    "x": "tool position",
    "x_desired": "desired tool position x_d",
    "y": "error signal (8)",
    "tau": "motor torque (4)",
    "u": "learned torque (9)",
    "stiffness": "stiffness k (6)",
    "offset": "offset torque q_e bar (7) about the center",
    "equilibrium": "equilibrium angle q_e of the spring",
    "center": "center q_c of the offset torque",
}

OF_SLIDES = {
    "rad": "m",
    "rad/s": "m/s",
    "m^2/s": "m^2/s",
    "N m": "N",
    "N m/rad": "N/m",
}
"""Units of a hinge joint's variables, and of a slide joint's."""

POSES = 8
"""Poses of a cycle at which its distance from singular poses is measured."""

HARDER, GROWN = 3.0, 10.0
"""Multiples of torque² without springs, and of the lowest before, above which a run diverges."""


class Recording:
    """The samples of one robot's run.

    Args:
        experiment: what is simulated.
        robot: the robot of the experiment.
        optima: the optimum of each motion.
    """

    def __init__(self, experiment: Experiment, robot: Robot, optima: list[Optimum]) -> None:
        self._experiment, self._robot, self._optima = experiment, robot, optima
        self._dt = experiment.simulation.timestep
        self._segment = np.repeat(np.arange(len(optima)), [m.cycles for m in experiment.motion])
        self._kept = _kept(experiment)
        self._samples: dict[str, list[np.ndarray]] = {name: [] for name in UNITS}
        self._times: list[np.ndarray] = []
        self._sample_cycles: list[np.ndarray] = []
        self._torque_squared: list[float] = []
        self._tracking_rms: list[float] = []
        self._stiffness: list[np.ndarray] = []
        self._offset: list[np.ndarray] = []
        self._time = 0.0
        self._rotation_rms: list[float] = []
        self._singular: list[float] = []
        self._made: dict[int, Optimum] = {}
        self._kinematics = Kinematics(robot)
        self._limited = bool(np.isfinite(robot.torque_limit).any())
        self._at_limit = np.zeros(robot.n)
        self._lowest = np.inf
        self.hardest = ""
        """The joint whose motor worked hardest in the last whole cycle."""

    def diverges(self) -> str:
        """Why the last cycle shows that the run diverges; empty if it does not.

        It does where the motors work harder than without springs by far, and than they did in this
        motion before by farther. The first cycle of a motion, which may begin with a jump, is no
        measure; stiff springs that adapt from far away are high, but do not grow like that.
        """
        last = len(self._torque_squared) - 1
        segment = self._segment[last] if last >= 0 else -1
        if last < 2 or segment != self._segment[last - 2]:
            return ""
        if last < 3 or segment != self._segment[last - 3]:
            self._lowest = np.inf
        self._lowest = lowest = min(self._lowest, self._torque_squared[last - 1])
        now = self._torque_squared[last]
        without = self._optima[segment].torque_squared_without_springs
        if now <= HARDER * without or now <= GROWN * lowest:
            return ""
        return (
            f"torque² has grown to {now / without:.3g} times that of the motion without springs, "
            f"{now / lowest:.3g} times the lowest before, most of it in {self.hardest}"
        )

    def add(self, memory: Memory, robot: int, steps: int, whole: int) -> None:
        """Take a cycle from the controller's memory.

        Args:
            memory: the controller's memory after the cycle.
            robot: index of this robot in it.
            steps: control steps recorded.
            whole: control steps of a whole cycle; only a whole one counts as a cycle.
        """
        cycle = len(self._torque_squared)
        taken = {name: memory.recorded(name, steps)[robot] for name in COLUMNS}
        taken["x_desired"] = memory["x_desired"][robot, :steps]
        if cycle in self._kept or steps < whole:
            copies = {name: signal.copy() for name, signal in taken.items()}
            self._keep(copies, memory["q_c"][robot].copy(), cycle, steps)
        if steps == whole:
            tau = taken["tau"]
            by_joint = np.einsum("tj,tj->j", tau, tau) / steps
            self._torque_squared.append(float(by_joint.sum()))
            self.hardest = self._robot.joints[int(by_joint.argmax())]
            miss = taken["x"] - taken["x_desired"]
            positions = len(self._robot.position_axes)
            self._tracking_rms.append(_rms(miss[:, :positions]))
            if self._robot.rotates:
                self._rotation_rms.append(_rms(miss[:, positions:]))
            some = taken["q"][:: max(1, steps // POSES)]
            J = np.array([self._kinematics.jacobian(q) for q in some])
            self._singular.append(float(np.linalg.svd(J, compute_uv=False)[:, -1].min()))
            low, high = self._robot.torque_limit.T
            if self._limited:
                self._at_limit = ((taken["tau"] <= low) | (taken["tau"] >= high)).mean(axis=0)
            if self._robot.m < self._robot.n:
                self._made[int(self._segment[cycle])] = self._best_for(taken, memory, robot)
            self._stiffness.append(memory["stiffness"][robot].copy())
            self._offset.append(memory["offset"][robot].copy())
            self._time += whole * self._dt

    def _best_for(self, taken: dict[str, np.ndarray], memory: Memory, robot: int) -> Optimum:
        """The optimum for the joint motion that was made, from motor and spring torque together."""
        q, center = taken["q"].copy(), memory["q_c"][robot].copy()
        spring = springs.torque(taken["stiffness"], taken["offset"], q, center)
        segment = int(self._segment[len(self._torque_squared) - 1])
        return best_springs(
            q,
            taken["tau"] + spring,
            center=center,
            period=self._experiment.motion[segment].period,
            bounds=self._experiment.springs,
        )

    def optima(self) -> list[Optimum]:
        """The optimum of each motion.

        Where the task leaves joints free, it does not determine the joint motion: then that of the
        joint motion that was made in the motion's last whole cycle.
        """
        if self._robot.m == self._robot.n:
            return self._optima
        return [self._made.get(i, best) for i, best in enumerate(self._optima)]

    def notes(self) -> list[str]:
        """What the run showed that its user should know, a line each."""
        return [
            f"{joint}'s motor was at its limit for {share:.0%} of the last cycle"
            for joint, share in zip(self._robot.joints, self._at_limit, strict=True)
            if share > 0
        ]

    def _keep(self, taken: dict[str, np.ndarray], center: np.ndarray, cycle: int, n: int) -> None:
        taken["center"] = np.broadcast_to(center, taken["q"].shape)
        taken["equilibrium"] = equilibrium(taken["stiffness"], taken["offset"], center)
        for name, values in taken.items():
            self._samples[name].append(values)
        self._times.append(self._time + np.arange(n) * self._dt)
        self._sample_cycles.append(np.full(n, cycle + 1))

    def dataset(self) -> xr.Dataset:
        """The run so far, as labelled arrays with units."""
        experiment, robot, optima = self._experiment, self._robot, self.optima()
        cycles = len(self._torque_squared)
        coords = {
            "time": ("time", _joined(self._times), {"units": "s"}),
            "cycle": ("cycle", np.arange(1, cycles + 1), {"units": "1"}),
            "segment": ("segment", np.arange(1, len(optima) + 1), {"units": "1"}),
            "joint": ("joint", list(robot.joints), {"units": "1"}),
            "slides": ("joint", robot.slides, {"units": "1", "long_name": "1 for a slide joint"}),
            "axis": ("axis", list(robot.axes), {"units": "1"}),
            "cycle_of_sample": ("time", _joined(self._sample_cycles).astype(int), {"units": "1"}),
            "segment_of_cycle": ("cycle", self._segment[:cycles] + 1, {"units": "1"}),
        }
        data = xr.Dataset(coords=coords)
        for name, units in UNITS.items():
            dims = ("time", "axis" if name.startswith("x") else "joint")
            width = robot.m if name.startswith("x") else robot.n
            data[name] = (dims, _joined(self._samples[name], width), _about(units, MEANING[name]))
        if experiment.law.jacobian == "transpose":
            data["y"].attrs["units"] = "m^2/s"
        best_torque = [
            optima[self._segment[part[0] - 1]].torque[: len(part)]
            for part in self._sample_cycles
            if len(part)
        ]
        data["tau_optimal"] = (
            ("time", "joint"),
            _joined(best_torque, robot.n),
            _about("N m", "motor torque with the optimal springs, tau_dopt"),
        )
        squared = "N^2 m^2"
        for name, values, units, meaning in (
            ("torque_squared", self._torque_squared, squared, "mean of tau^T tau over the cycle"),
            ("tracking_rms", self._tracking_rms, "m", "root mean square of the position error"),
            ("rotation_rms", self._rotation_rms, "rad", "root mean square of the rotation error"),
            ("singular_value", self._singular, "m/rad", "smallest singular value of J"),
        ):
            if name == "rotation_rms" and not robot.rotates:
                continue
            data[name] = ("cycle", np.asarray(values, float), _about(units, meaning))
        for name, rows in (("stiffness", self._stiffness), ("offset", self._offset)):
            table = np.asarray(rows, float).reshape(cycles, robot.n)
            about = _about(UNITS[name], f"{MEANING[name]} at the end of the cycle")
            data[f"{name}_per_cycle"] = (("cycle", "joint"), table, about)
        for name, units in (("stiffness", "N m/rad"), ("offset", "N m"), ("equilibrium", "rad")):
            table = np.array([getattr(best, name) for best in optima])
            about = _about(units, f"{name} of the optimal springs")
            data[f"{name}_optimal"] = (("segment", "joint"), table, about)
        for name, attribute in (
            ("torque_squared_optimal", "torque_squared"),
            ("torque_squared_without_springs", "torque_squared_without_springs"),
        ):
            row = np.array([getattr(best, attribute) for best in optima])
            data[name] = ("segment", row, _about(squared, name.replace("_", " ")))
        ends = np.cumsum([motion.duration for motion in experiment.motion])
        starts = np.concatenate([[0.0], ends[:-1]])
        data["start"] = ("segment", starts, _about("s", "start of the motion"))
        data["end"] = ("segment", ends, _about("s", "end of the motion"))
        periods = [motion.period for motion in experiment.motion]
        data["period"] = ("segment", periods, _about("s", "cycle time T"))
        if robot.slides.any():
            for variable in data.values():
                if "joint" in variable.dims:
                    units = variable.attrs["units"]
                    variable.attrs["units"] = f"{units}; {OF_SLIDES[units]} for slide joints"
        data.attrs["thinned"] = int(len(self._kept) < len(self._segment))
        return data


def _kept(experiment: Experiment) -> set[int]:
    """Cycles whose samples are kept: all, or pairs in a row over each motion with both ends.

    What is learned from a cycle shows in the next.
    """
    dt, budget = experiment.simulation.timestep, experiment.simulation.samples
    total = sum(motion.cycles * motion.steps(dt) for motion in experiment.motion)
    share = min(1.0, budget / total)
    kept: set[int] = set()
    first = 0
    for motion in experiment.motion:
        pairs = max(4, int(share * motion.cycles)) // 2
        if share == 1.0 or 2 * pairs >= motion.cycles:
            kept.update(range(first, first + motion.cycles))
        else:
            begins = first + np.linspace(0, motion.cycles - 2, pairs).round().astype(int)
            kept.update(begins, begins + 1)
        first += motion.cycles
    return {int(cycle) for cycle in kept}


def equilibrium(k: np.ndarray, offset: np.ndarray, center: np.ndarray) -> np.ndarray:
    """Equilibrium angles q_e of springs (N, n) [rad]; `springs.equilibrium` has it of one."""
    k = np.where((k == 0) & (offset != 0), springs.LIMP, k)
    return np.divide(offset, k, out=np.zeros_like(k), where=k != 0) + center


def _rms(miss: np.ndarray) -> float:
    """Root mean square of the length of a vector over a cycle (N, ·)."""
    return math.sqrt(np.vdot(miss, miss) / len(miss))


def _about(units: str, meaning: str) -> dict[str, str]:
    return {"units": units, "long_name": meaning}


def _joined(parts: list[np.ndarray], width: int | None = None) -> np.ndarray:
    if parts:
        return np.concatenate(parts)
    return np.empty(0 if width is None else (0, width))
