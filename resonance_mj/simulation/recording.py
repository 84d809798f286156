"""What is kept of a run while it is simulated: whole cycles in time, and every cycle in brief."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
import xarray as xr

from ..laws.learning import low_pass
from ..laws.memory import COLUMNS
from ..plan.passages import extents
from ..plan.plan import Plan
from ..results import metrics, schema
from ..springs.cost import KINDS
from ..springs.elements import Elements, names
from ..springs.fit import SPRINGS, LinearSprings
from ..springs.optimum import Optimum, best_springs
from ..springs.spring import equilibrium_angles
from .hindrances import Hindrance, LastCycle
from .motors import of_motors
from .thinning import Samples, Signals

POSES = 4
"""Poses of a cycle at which its distance from singular poses is measured."""

TOGETHER = 64
"""Cycles whose poses are measured in one go, which takes a third of the time."""

HARDER, GROWN = 3.0, 10.0
"""Multiples of torque² without springs, and of the lowest before, above which a run diverges."""

FIGURES = ("torque_squared", "tracking_rms", "singular_value")
"""What is measured of each whole cycle."""

PER_CYCLE = (*SPRINGS, "parameters")
"""What is kept of the springs at the end of each."""


class Recording:
    """The samples of one robot's run."""

    def __init__(self, plan: Plan) -> None:
        self._plan, self._robot = plan, plan.robot
        self._cost = plan.gains.bounds.objective
        self._dt = plan.experiment.simulation.timestep
        self._segment = np.array(plan.schedule)
        parameters = len(names(plan.robot.elements))
        self._width = {"joint": plan.robot.n, "axis": plan.robot.m, "parameter": parameters}
        names_of_samples = (*COLUMNS, "x_desired", "center", "time", "cycle_of_sample")
        self._samples = Samples(plan, {name: self._wide(name) for name in names_of_samples})
        asked = {"cost": self._cost, "rotation_rms": plan.robot.rotates}
        asked["joint_rms"] = plan.robot.joint_space
        also = [name for name, has in asked.items() if has]
        self._cycles = {
            name: np.empty((len(self._segment), *self._wide(name)))
            for name in (*FIGURES, *also, *(f"{name}_per_cycle" for name in PER_CYCLE))
        }
        self._done = 0
        self._time = 0.0
        self.last: dict[int, LastCycle] = {}
        """Of each motion, by its number from 0, the last whole cycle."""
        self._lowest = np.inf
        self._poses: list[np.ndarray] = []
        self.hardest = ""
        """The joint whose motor worked hardest in the last whole cycle."""

    def restore(self, data: xr.Dataset) -> None:
        """Take up what a run so far has recorded."""
        for name in self._cycles.keys() & set(data.variables):
            self._cycles[name][: data.sizes["cycle"]] = data[name].values
        for cycle in range(data.sizes["cycle"]):
            self._time += self._plan.steps(self._plan.schedule[cycle]) * self._dt
            self._done = cycle + 1
            self.diverges()
        of_sample = data["cycle_of_sample"].values
        for cycle in np.unique(of_sample).tolist():
            mine = data.isel(time=np.flatnonzero(of_sample == cycle))
            signals = {name: mine[name].values for name in self._samples.names}
            self._samples.take(cycle - 1, signals)
            q, tau, center = (signals[name] for name in ("q", "tau", "center"))
            parameters = self._cycles["parameters_per_cycle"][cycle - 1]
            others = Elements(self._robot.elements, parameters)
            own = mine["stiffness"].values, mine["offset"].values
            acting = LinearSprings(*own, center[0], others, self._plan.gains.bounds.material)
            dq, segment = mine["dq"].values, int(self._segment[cycle - 1])
            self.last[segment] = LastCycle(q, tau, acting, dq)

    def diverges(self) -> str:
        """Why the last cycle shows that the run diverges; empty if it does not.

        It does where the motors work harder than without springs by far, and than they did in this
        motion before by farther. The first cycle of a motion, which may begin with a jump, is no
        measure; stiff springs that adapt from far away are high, but do not grow like that.
        """
        torque_squared, last = self._cycles["torque_squared"], self._done - 1
        segment = self._segment[last] if last >= 0 else -1
        if last < 2 or segment != self._segment[last - 2]:
            return ""
        if last < 3 or segment != self._segment[last - 3]:
            self._lowest = np.inf
        self._lowest = lowest = min(self._lowest, float(torque_squared[last - 1]))
        now = float(torque_squared[last])
        without = self._plan.optima[segment].torque_squared_without_springs
        if now <= HARDER * without or now <= GROWN * lowest:
            return ""
        return (
            f"torque² has grown to {now / without:.3g} times that of the motion without springs, "
            f"{now / lowest:.3g} times the lowest before, most of it in {self.hardest}"
        )

    def add(self, signals: Signals, springs: LinearSprings, whole: bool) -> None:
        """Take a cycle.

        Args:
            signals: views of what was recorded, whole or to where the run failed.
            springs: at the end of the cycle, about the centre during it.
            whole: whether the cycle was simulated whole; only then it counts as a cycle.
        """
        cycle, steps = self._done, len(signals["q"])
        time = self._time + np.arange(steps) * self._dt
        more = {"center": springs.center, "time": time, "cycle_of_sample": np.array(cycle + 1)}
        self._samples.take(cycle, signals | more, whole=whole)
        if not whole:
            return
        self._time += steps * self._dt
        robot, found, tau, q = self._robot, self._cycles, signals["tau"], signals["q"]
        by_joint = np.einsum("tj,tj->j", tau, tau) / steps
        found["torque_squared"][cycle] = by_joint.sum()
        self.hardest = robot.joints[int(by_joint.argmax())]
        miss = signals["x"] - signals["x_desired"]
        positions = len(robot.position_axes)
        found["tracking_rms"][cycle] = _rms(miss[:, :positions])
        if robot.rotates:
            found["rotation_rms"][cycle] = _rms(miss[:, positions:])
        if robot.joint_space:
            found["joint_rms"][cycle] = _rms(q - signals["q_desired"])
        self._poses.append(q[:: max(1, steps // POSES)])
        own = signals["stiffness"], signals["offset"]
        material = self._plan.gains.bounds.material
        acting = LinearSprings(*own, springs.center.copy(), springs.others, material)
        self.last[int(self._segment[cycle])] = LastCycle(q, tau, acting, signals["dq"])
        if self._cost is not None:
            found["cost"][cycle] = self._cost.of(tau, signals["dq"])
        for name, value in zip(PER_CYCLE, (*springs, springs.others.parameters), strict=True):
            found[f"{name}_per_cycle"][cycle] = value
        self._done += 1
        if len(self._poses) == TOGETHER:
            self._measure_poses()

    def _measure_poses(self) -> None:
        """Least singular value of J in each cycle of which the poses are not measured yet."""
        if not self._poses:
            return
        J = self._plan.kinematics.jacobians(np.concatenate(self._poses))
        least = np.linalg.svd(J, compute_uv=False)[:, -1]
        begins = np.cumsum([0, *map(len, self._poses)])[:-1]
        first = self._done - len(self._poses)
        self._cycles["singular_value"][first : self._done] = np.minimum.reduceat(least, begins)
        self._poses.clear()

    def optima(
        self, size: np.ndarray, hindered: Mapping[int, Sequence[Hindrance]]
    ) -> tuple[list[Optimum], np.ndarray]:
        """The optimum of each motion, and whether it is of the joint motion made.

        Where the task leaves joints free, it does not determine the joint motion: then that of the
        joint motion that was made in the motion's last whole cycle, if the tool followed its path
        and neither contacts nor the ends of ranges bore on the arm.

        Args:
            size: of the path of each motion [m].
            hindered: as of `dataset`.
        """
        experiment, found = self._plan.experiment, list(self._plan.optima)
        made = np.zeros(len(found), int)
        if self._robot.m < self._robot.n and not self._robot.joint_space:
            for segment, cycle in self.last.items():
                free = not any(one.bears for one in hindered[segment])
                if free and self._follows(segment, size[segment]):
                    made[segment] = 1
                    total = cycle.total
                    # No motion needs what its feedback makes of noise.
                    if experiment.reality.sensed:
                        total = low_pass(total, self._plan.gains.harmonics)
                    found[segment] = best_springs(
                        cycle.q,
                        total,
                        center=cycle.center,
                        period=experiment.motion[segment].period,
                        bounds=self._plan.gains.bounds,
                    )
        return found, made

    def _follows(self, segment: int, size: float) -> bool:
        """Whether the tool followed its path in the last whole cycle of a motion."""
        at = np.flatnonzero(self._segment[: self._done] == segment)[-1]
        rotation = self._cycles["rotation_rms"][at] if self._robot.rotates else None
        return bool(metrics.tracks(self._cycles["tracking_rms"][at], size, rotation))

    def _wide(self, name: str) -> tuple[int, ...]:
        """Sizes of a variable, but for its first."""
        _, *dims = (schema.VARIABLES | schema.COORDINATES)[name].dims
        return tuple(self._width[dim] for dim in dims)

    def dataset(
        self, hindered: Mapping[int, Sequence[Hindrance]], q: np.ndarray, dq: np.ndarray
    ) -> xr.Dataset:
        """The run so far, as labelled arrays with units.

        Args:
            hindered: what hindered the arm in the last whole cycle of each motion, by its number.
            q: joint angles after the last time step (n,) [rad].
            dq: their velocity (n,) [rad/s].
        """
        self._measure_poses()
        plan, robot, size = self._plan, self._robot, extents(self._plan)
        optima, made = self.optima(size, hindered)
        cycles = self._done
        values = self._samples.so_far(cycles)
        values |= {name: kept[:cycles].copy() for name, kept in self._cycles.items()}
        if robot.joint_space:
            values["swing"] = np.array([np.ptp(one.q, axis=0).max() for one in plan.joints])
        segment = self._segment[:cycles]
        values["cycle_of_sample"] = values["cycle_of_sample"].astype(int)
        values["segment_of_sample"] = self._segment[values["cycle_of_sample"] - 1] + 1
        for suffix in ("", "_per_cycle"):
            k, offset, center = (values[f"{name}{suffix}"] for name in SPRINGS)
            values[f"equilibrium{suffix}"] = equilibrium_angles(k, offset, center)
        for name in ("stiffness", "offset", "equilibrium", "torque_squared"):
            values[f"{name}_optimal"] = np.array([getattr(best, name) for best in optima])
        ranges = np.array([best.stiffness_range() for best in optima])
        values["stiffness_least"], values["stiffness_most"] = np.moveaxis(ranges, 2, 0)
        values["parameters_optimal"] = np.array([best.springs.others.parameters for best in optima])
        without = np.array([best.torque_squared_without_springs for best in optima])
        numbers, counts = np.unique(values["cycle_of_sample"], return_counts=True)
        best_torque = [
            optima[self._segment[number - 1]].torque[:count]
            for number, count in zip(numbers, counts, strict=True)
        ]
        optimal = metrics.reduction(values["torque_squared_optimal"], without)
        reduced = metrics.reduction(values["torque_squared"], without[segment])
        values |= of_motors(plan, optima, self.last)
        ends = np.cumsum([motion.duration for motion in plan.experiment.motion])
        units = dict.fromkeys(schema.COST, KINDS[plan.experiment.springs.cost].units)
        if plan.experiment.law.jacobian == "transpose":
            units["y"] = "m^2/s"
        return schema.dataset(
            values
            | {
                "cycle": np.arange(1, cycles + 1),
                "segment": np.arange(1, len(optima) + 1),
                "joint": list(robot.joints),
                "parameter": np.array(names(robot.elements), dtype=str),
                "slides": robot.slides,
                "axis": list(robot.axes),
                "segment_of_cycle": segment + 1,
                "passage": np.array([plan.blending(i) is not None for i in range(cycles)], int),
                "torque_squared_without_springs": without,
                "tau_optimal": np.concatenate([np.empty((0, robot.n)), *best_torque]),
                "torque_reduction": reduced,
                "torque_share": metrics.share(reduced, optimal[segment]),
                "optimum_made": made,
                "q_end": q.copy(),
                "dq_end": dq.copy(),
                "size": size,
                "start": np.concatenate([[0.0], ends[:-1]]),
                "end": ends,
                "period": np.array([motion.period for motion in plan.experiment.motion]),
            },
            units=units,
            thinned=self._samples.thinned,
        )


def _rms(miss: np.ndarray) -> float:
    """Root mean square of the length of a vector over a cycle (N, ·)."""
    return math.sqrt(np.vdot(miss, miss) / len(miss))
