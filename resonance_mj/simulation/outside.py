"""The law as an object for a loop of one's own, such as that of a real arm."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

import numpy as np

from ..errors import ExperimentError
from ..experiments.experiment import Experiment
from ..laws.controller import act, end_stage
from ..laws.memory import Memory
from ..laws.sensing import given
from ..plan.plan import plan_for
from ..results.run import Run
from ..springs.fit import LinearSprings
from ..status import Status
from .member import Member


class Controller:
    """The controller of an experiment, stepped from outside: the functions that the callback runs.

    Planning takes the robot's file and MuJoCo; a step takes neither. Each cycle is as many steps as
    its motion has, one per `period`, and then `end_cycle`.

    Args:
        experiment: what to do; its time step is the period.
        compiled: whether steps are compiled, which takes a few seconds once.

    Attributes:
        period: between two steps [s].
        joints: names of the joints, in the order of q and τ (n).
        axes: names of the task's coordinates, in the order of x (m).
        q: joint angles at which the arm begins, at rest (n,) [rad].
        cycles: cycles in all.

    Raises:
        RobotError: the robot cannot be loaded.
        MotionError: a motion leaves the arm's reach.
        ExperimentError: it has RK4, of which a loop outside has no stages.
    """

    def __init__(self, experiment: Experiment, *, compiled: bool = True) -> None:
        if experiment.simulation.integrator == "RK4":
            raise ExperimentError(
                f"experiment {experiment.name!r}: simulation.integrator = 'RK4' has four stages in "
                "a time step; a controller outside takes Euler or implicitfast"
            )
        self._plan = plan = plan_for(experiment)
        robot = plan.robot
        self.period = plan.experiment.simulation.timestep
        self.joints, self.axes, self.q = robot.joints, robot.axes, robot.home.copy()
        self.cycles = len(plan.schedule)
        self._outside = _Outside(plan.robot.model, plan.layout.size)
        self._memory = Memory(self._outside.userdata, plan.layout)
        self._member = Member(plan, self._memory, self._outside, 0)
        self._cycle, self._step = 0, 0
        self._block, self._tau = self._memory.block(0), self._memory["tau"][0]
        self._tool, self._orientation = robot.position.copy(), robot.orientation.copy()
        model = robot.model
        self._spring = np.zeros(model.njnt), np.zeros(model.nq), np.zeros(model.nv)
        self._do = _compiled(plan.law.command) if compiled else _plain(plan.law.command)
        self._member.begin_cycle(0)
        shapes = (robot.n,), (robot.n,), (len(robot.position_axes),), (robot.m, robot.n)
        self._measured = [np.zeros(shape) for shape in shapes]
        if compiled:  # now, on a copy, and not in the first step of an arm that waits
            self._call(self._block.copy())

    @property
    def steps(self) -> int:
        """Steps of the cycle that is under way."""
        return self._plan.steps(self._plan.schedule[self._cycle])

    @property
    def springs(self) -> LinearSprings:
        """The springs that act now; unpacked, stiffness, offset and centre of each joint (n,)."""
        return self._member.springs

    def step(
        self,
        q: np.ndarray,
        dq: np.ndarray,
        x: np.ndarray,
        J: np.ndarray,
        orientation: np.ndarray | None = None,
    ) -> np.ndarray:
        """Torque of the motors for what was measured.

        Args:
            q: joint angles (n,) [rad].
            dq: joint velocities (n,) [rad/s].
            x: position of the tool in the task's coordinates without rotation [m].
            J: Jacobian of the task's coordinates (m, n) [m/rad].
            orientation: of the tool (3, 3), for a task with rotation.

        Returns:
            τ (n,) [N m], a view that the next step overwrites.

        Raises:
            ExperimentError: the cycle has had all of its steps, or the run has diverged.
        """
        if self._step == self.steps or self._member.status is not Status.OK:
            raise ExperimentError(
                f"cycle {self._cycle + 1} of {self.cycles} has had its {self.steps} steps: call "
                "end_cycle"
                if self._member.status is Status.OK
                else f"the run has ended: {self._member.status}"
            )
        if orientation is not None:
            self._orientation[:] = orientation
        for mine, given_one in zip(self._measured, (q, dq, x, J), strict=True):
            mine[:] = given_one
        self._call(self._block)
        self._step += 1
        return self._tau

    def _call(self, block: np.ndarray) -> None:
        outside = self._outside
        place = self._tool, self._orientation
        arrays = (outside.qpos, outside.qvel, *place, outside.ctrl, *self._spring)
        self._do(block, *self._measured, *arrays)

    def end_cycle(self) -> LinearSprings:
        """Learn from the cycle that is done, and begin the next.

        Returns:
            The springs of the next cycle, to be set before its first step.

        Raises:
            ExperimentError: the cycle is not done, or was the last.
        """
        if self._step < self.steps and not self._memory.scalar("failed_step")[0]:
            raise ExperimentError(
                f"cycle {self._cycle + 1} has had {self._step} of its {self.steps} steps"
            )
        self._member.end_cycle(self._cycle)
        if self._cycle + 1 < self.cycles and self._member.status is Status.OK:
            self._cycle += 1
            self._step = 0
            self._memory.scalar("step")[:] = 0
            self._member.begin_cycle(self._cycle)
        return self.springs

    def run(self) -> Run:
        """What was done so far, judged and recorded as a simulated run is."""
        return self._member.run(0.0)


class _Outside:
    """Arrays in place of a stepped MuJoCo model: a `Stepper` that is stepped from outside."""

    def __init__(self, model: Any, size: int) -> None:
        self.models = [model]
        self.userdata = np.zeros((1, size))
        self.qpos, self.qvel, self.ctrl = model.qpos0.copy(), np.zeros(model.nv), np.zeros(model.nu)

    def start(self, robot: int, qpos: np.ndarray) -> None:
        """Place the robot at rest at `qpos` (nq,)."""
        self.qpos[:] = qpos

    def state(self, robot: int) -> tuple[np.ndarray, np.ndarray]:
        """Position (nq,) and velocity (nv,) of the robot."""
        return self.qpos, self.qvel

    def step(self, robots: list[int], steps: int) -> None:
        """Nothing: the loop is outside."""

    def warnings(self, robot: int) -> list[str]:
        """None."""
        return []


def _plain(command: Callable[..., None]) -> Callable[..., None]:
    def step(
        memory: np.ndarray,
        q: np.ndarray,
        dq: np.ndarray,
        x: np.ndarray,
        J: np.ndarray,
        qpos: np.ndarray,
        qvel: np.ndarray,
        tool: np.ndarray,
        orientation: np.ndarray,
        ctrl: np.ndarray,
        stiffness: np.ndarray,
        spring: np.ndarray,
        damping: np.ndarray,
    ) -> None:
        given(memory, q, dq, x, J, qpos, qvel, tool)
        act(memory, qpos, qvel, tool, orientation, ctrl, command)
        end_stage(memory, stiffness, spring, damping)

    return step


@cache
def _compiled(command: Callable[..., None]) -> Callable[..., None]:
    from ..callback import compilation  # imports the compiler

    return compilation.stepping(_plain, command)
