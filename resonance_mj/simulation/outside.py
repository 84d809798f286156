"""The law as an object for a loop of one's own, such as that of a real arm."""

from __future__ import annotations

import numpy as np

from ..callback.callback import stepping
from ..errors import ExperimentError
from ..experiments.experiment import Experiment
from ..laws.memory import Memory
from ..plan.plan import plan_for
from ..results.run import Run
from ..springs.fit import LinearSprings
from ..status import Status
from .member import Member
from .stepper import Alone


class Controller:
    """The controller of an experiment, stepped from outside: the functions that the callback runs.

    Planning takes the robot's file and MuJoCo; a step takes neither. Each cycle is as many steps as
    its motion has, one per `period`, and then `end_cycle`.

    Args:
        experiment: what to do; its time step is the period.
        compiled: whether steps are compiled, which takes a few seconds once on a machine.

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
        alone = Alone([robot.model])  # which MuJoCo does not step
        self._memory = Memory(alone.userdata, plan.layout)
        self._member = Member(plan, self._memory, alone, 0)
        self._cycle, self._step = 0, 0
        self._memory.scalar("outside")[0] = 1
        self._memory.scalar("misjudged")[0] = 0  # x and J are what the caller takes them to be
        model, data = robot.model, alone.data
        self._call = stepping(model, data, interpret=not compiled, command=plan.law.command)
        self._joint_at, self._dof_at = robot.qpos_address, robot.dof_address
        self._position_at = robot.coordinate[: len(robot.position_axes)]
        self._J_at = np.ix_(robot.coordinate, robot.dof_address)
        self._qpos, self._qvel, self._tau = data.qpos, data.qvel, self._memory["tau"][0]
        self._tool, self._orientation = data.site_xpos[robot.site], data.site_xmat[robot.site]
        self._tool[:], self._orientation[:] = robot.position, robot.orientation.ravel()
        self._jacobian = self._memory["jacobian"][0]
        self._member.begin_cycle(0)

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
            self._orientation[:] = np.reshape(orientation, 9)
        self._qpos[self._joint_at], self._qvel[self._dof_at] = q, dq
        self._tool[self._position_at] = x
        self._jacobian[self._J_at] = J
        self._call()
        self._step += 1
        return self._tau

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
