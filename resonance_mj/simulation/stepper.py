"""Robots that step together: one in its mjData, or many of one layout in a `mujoco.batch`."""

from typing import Protocol

import mujoco
import numpy as np

from ..errors import ExperimentError
from ..robots.warned import counted
from .checkpoint import DAMAGED


class Stepper(Protocol):
    """Robots that step together. `userdata` is that of each (robots, nuserdata)."""

    userdata: np.ndarray
    models: list[mujoco.MjModel]

    def start(self, robot: int, qpos: np.ndarray) -> None:
        """Place a robot at rest at `qpos` (nq,)."""

    def state(self, robot: int) -> tuple[np.ndarray, np.ndarray]:
        """Position (nq,) and velocity (nv,) of a robot, to read and to write."""

    def step(self, robots: list[int], steps: int) -> None:
        """Advance some of the robots by a number of time steps."""

    def warnings(self, robot: int) -> list[str]:
        """What MuJoCo has warned of in a robot's steps."""


WHOLE = int(mujoco.mjtState.mjSTATE_INTEGRATION)
"""All of mjData that its next step depends on, `userdata` included."""


class Alone:
    """One robot in one mjData, `data`."""

    def __init__(self, models: list[mujoco.MjModel]) -> None:
        self.models = models
        self.data = mujoco.MjData(models[0])
        self.userdata = self.data.userdata[None]

    def start(self, robot: int, qpos: np.ndarray) -> None:
        """Place a robot at rest at `qpos` (nq,)."""
        self.data.qpos[:] = qpos

    def state(self, robot: int) -> tuple[np.ndarray, np.ndarray]:
        """Position (nq,) and velocity (nv,) of the robot, to read and to write."""
        return self.data.qpos, self.data.qvel

    def step(self, robots: list[int], steps: int) -> None:
        """Advance the robot by a number of time steps."""
        mujoco.mj_step(self.models[0], self.data, steps)

    def whole(self) -> np.ndarray:
        """The whole state of the robot (S,)."""
        state = np.empty(mujoco.mj_stateSize(self.models[0], WHOLE))
        mujoco.mj_getState(self.models[0], self.data, state, WHOLE)
        return state

    def restore(self, state: np.ndarray) -> None:
        """Bring the robot to a whole state (S,)."""
        if len(state) != mujoco.mj_stateSize(self.models[0], WHOLE):
            raise ExperimentError(DAMAGED)
        mujoco.mj_setState(self.models[0], self.data, state, WHOLE)

    def warnings(self, robot: int) -> list[str]:
        """What MuJoCo has warned of in the robot's steps."""
        return counted((one.lastinfo, one.number) for one in self.data.warning)


class Together:
    """Robots of one layout in a `mujoco.batch`, each with its own model."""

    def __init__(self, models: list[mujoco.MjModel], threads: int) -> None:
        from mujoco.batch import Batch  # probes every field when imported, which takes a while

        self.models = models
        self._batch = Batch(models[0], nsim=len(models), nthread=threads)
        self._batch.set_models(models)
        self.userdata = self._batch.bind("userdata")
        self._qpos, self._qvel = self._batch.bind("qpos"), self._batch.bind("qvel")

    def start(self, robot: int, qpos: np.ndarray) -> None:
        """Place a robot at rest at `qpos` (nq,)."""
        self._qpos[robot] = qpos

    def state(self, robot: int) -> tuple[np.ndarray, np.ndarray]:
        """Position (nq,) and velocity (nv,) of a robot, to read and to write."""
        return self._qpos[robot], self._qvel[robot]

    def step(self, robots: list[int], steps: int) -> None:
        """Advance some of the robots by a number of time steps."""
        # The springs that were written into the models: what set_models copies, it copies here.
        self._batch.set_models(self.models)
        self._batch.step(ids=np.array(robots), nstep=steps)

    def warnings(self, robot: int) -> list[str]:
        """What MuJoCo has warned of in a robot's steps."""
        return counted(self._batch.warning[robot])
