"""The controller's block of mjData.userdata: all that a law's step remembers or is tuned by.

The block is a header, one number per entry of `Header`, followed by arrays, one per entry of
`ARRAYS`. The header holds the sizes and, for each array, where it begins. Nothing about a robot or
a law is compiled in: a saved `userdata` is the whole state of the controller, and each robot of a
batch has its own. What only learning between cycles needs stays in the plan. The last two numbers
of `userdata` say where the block begins and that there is one: numbers which a model's author keeps
in `userdata` stay where they are, and models without a controller are left alone.

The step sees the block as `own.py` has it; between cycles those of all robots are a `Memory`.
"""

from __future__ import annotations

from collections import namedtuple
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..experiments.experiment import Experiment
from ..step_functions import step_function

ARRAYS: dict[str, tuple[str, ...]] = {
    # the robot
    "qpos_address": ("joints",),
    "dof_address": ("joints",),
    "joint_id": ("joints",),
    "actuator_id": ("joints",),
    "coordinate": ("coordinates",),
    "before": ("three",),  # position of the tool a time step ago
    "orientation": ("three", "three"),
    "posture": ("joints",),
    # the law's gains and the springs' bounds
    "k_v": ("coordinates",),
    "k_p": ("coordinates",),
    "gamma_k": ("joints",),
    "gamma_qe": ("joints",),
    "feedback": ("joints", "joints"),
    "feedback_p": ("joints", "joints"),
    "q_c": ("joints",),
    "k_min": ("joints",),
    "k_max": ("joints",),
    "low": ("joints",),
    "high": ("joints",),
    "parameters": ("parameters",),
    # beyond which the run has failed
    "torque_limit": ("joints",),
    # the motors' limits
    "tau_min": ("joints",),
    "tau_max": ("joints",),
    # the springs that act now
    "stiffness": ("joints",),
    "offset": ("joints",),
    # tables over the cycle
    "x_desired": ("steps", "coordinates"),
    "dx_desired": ("steps", "coordinates"),
    "q_desired": ("steps", "joints"),
    "dq_desired": ("steps", "joints"),
    "learned": ("steps", "joints"),
    "record": ("steps", "columns"),
    # scratch of one control step
    "jacobian": ("six", "dofs"),
    "J": ("coordinates", "joints"),
    "error": ("coordinates",),
    "rate": ("coordinates",),
    "s": ("coordinates",),
    "y": ("joints",),
    "tau": ("joints",),
    "drift": ("joints",),
    "q": ("joints",),
    "dq": ("joints",),
    "desired": ("three", "three"),
    "work": ("more", "more"),
}
"""Arrays of the block and their shapes, in the order in which they lie."""

COLUMNS: dict[str, str] = {
    "q": "joints",
    "dq": "joints",
    "x": "coordinates",
    "y": "joints",
    "tau": "joints",
    "u": "joints",
    "stiffness": "joints",
    "offset": "joints",
}
"""What a control step records, in the order of the columns of `record`."""

_SCALARS = (
    "joints",  # n
    "coordinates",  # m
    "dofs",  # of the whole model
    "columns",  # of the record
    "more",  # than the joints and than the coordinates, by one
    "parameters_given",  # of a custom law
    "site",  # the tool's id
    "rotates",  # 1 if the task has rotation, its last three coordinates
    "form",  # of (8): 0 for J^-1, 1 for J^T, 2 for the damped pseudo-inverse
    "difference",  # 1 for the tool's velocity by the difference of its positions
    "inertial",  # 1 for feedback by `feedback` too
    "usual",  # manipulability below which the damping grows
    "alpha",
    "alpha_0",
    "timestep",
    "stages",  # callbacks per time step: 1, or 4 under RK4
    "stage",  # callbacks since the time step began
    "step",  # control steps since the cycle began
    "speed_limit",  # [rad/s]
    "failed_step",  # control step in which the run diverged, counted from 1; 0 if it has not
    "failed_joint",  # its joint
)

_HEADER = [name.upper() for name in (*_SCALARS, *ARRAYS)]
Header: Any = namedtuple("Header", _HEADER)(*range(len(_HEADER)))
"""Index of each number of the header; an array's is where it begins in the block."""

SIGNATURE = 20.14101987
"""The last number of a `userdata` that holds a controller's block."""


@dataclass(frozen=True)
class Layout:
    """Sizes of the block for one robot, task and longest cycle."""

    joints: int
    coordinates: int
    dofs: int
    steps: int
    parameters: int = 0
    three: int = 3
    six: int = 6

    @property
    def more(self) -> int:
        """One more than the joints and than the coordinates."""
        return max(self.joints, self.coordinates) + 1

    @property
    def columns(self) -> int:
        """Numbers that a control step records."""
        return sum(getattr(self, size) for size in COLUMNS.values())

    def shape(self, name: str) -> tuple[int, ...]:
        """Shape of an array of the block."""
        return tuple(getattr(self, size) for size in ARRAYS[name])

    def starts(self) -> Iterator[tuple[str, int]]:
        """Each array and where it begins in the block."""
        start = len(Header)
        for name in ARRAYS:
            yield name, start
            start += int(np.prod(self.shape(name)))

    @property
    def size(self) -> int:
        """Length of the block, and of the two numbers that lead to it."""
        last, start = list(self.starts())[-1]
        return start + int(np.prod(self.shape(last))) + 2


def layout_of(experiment: Experiment, joints: int, coordinates: int, dofs: int) -> Layout:
    """Sizes of the block for an experiment, on an arm with so many joints, coordinates, dofs."""
    dt = experiment.simulation.timestep
    return Layout(
        joints=joints,
        coordinates=coordinates,
        dofs=dofs,
        steps=max(motion.steps(dt) for motion in experiment.motion),
        parameters=len(experiment.law.parameters),
    )


class Memory:
    """Named views of the block in the userdata of one or more robots.

    Args:
        userdata: `mjData.userdata` of each robot (robots, nuserdata); written in place.
        layout: sizes of the block, equal for all robots.
    """

    def __init__(self, userdata: np.ndarray, layout: Layout) -> None:
        self.layout = layout
        begin = userdata.shape[1] - layout.size
        self._block = userdata[:, begin:-2]
        self._starts = dict(layout.starts())
        userdata[:, -2] = begin
        userdata[:, -1] = SIGNATURE
        for name in ("joints", "coordinates", "dofs", "columns", "more"):
            self.scalar(name)[:] = getattr(layout, name)
        self.scalar("parameters_given")[:] = layout.parameters
        self._views: dict[str, np.ndarray] = {}
        for name, start in self._starts.items():
            self.scalar(name)[:] = start
            shape = layout.shape(name)
            flat = self._block[:, start : start + int(np.prod(shape))]
            self._views[name] = flat.reshape(flat.shape[0], *shape)

    def scalar(self, name: str) -> np.ndarray:
        """View of a number of the header (robots,)."""
        return self._block[:, getattr(Header, name.upper())]

    def block(self, robot: int) -> np.ndarray:
        """View of one robot's block, as the control step is handed it."""
        return self._block[robot]

    def __getitem__(self, name: str) -> np.ndarray:
        """View of an array (robots, *shape)."""
        return self._views[name]

    def recorded(self, name: str, steps: int) -> np.ndarray:
        """View of a recorded signal over a cycle of `steps` control steps (robots, steps, size)."""
        start = 0
        for column, size in COLUMNS.items():
            width = getattr(self.layout, size)
            if column == name:
                return self["record"][:, :steps, start : start + width]
            start += width
        raise KeyError(name)


@step_function
def block(userdata: np.ndarray) -> np.ndarray:
    """The controller's block of `userdata`; empty if the model has none.

    The callback is called for every model that the process steps, forwards or compiles.
    """
    end = userdata.size - 2
    if end < 0 or userdata[end + 1] != SIGNATURE:
        return userdata[:0]
    return userdata[int(userdata[end]) : end]


def vector(memory: np.ndarray, start: float, size: int) -> np.ndarray:
    """View of `size` numbers of the block from `start`."""
    return memory[int(start) : int(start) + size]


def matrix(memory: np.ndarray, start: float, rows: int, columns: int) -> np.ndarray:
    """View of numbers of the block from `start`, as (rows, columns)."""
    return memory[int(start) : int(start) + rows * columns].reshape(rows, columns)
