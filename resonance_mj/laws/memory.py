"""The controller's block of mjData.userdata: all that a law's step remembers or is tuned by.

The block is a header, one number per entry of `Header`, followed by arrays, one per entry of
`ARRAYS`. The header holds the sizes and, for each array, where it begins. Nothing about a robot or
a law is compiled in: a saved `userdata` is the whole state of the controller, and each robot of a
batch has its own. What only learning between cycles needs stays in the plan. The last two numbers
of `userdata` say where the block begins and that there is one: numbers which a model's author keeps
in `userdata` stay where they are, and models without a controller are left alone.

Between cycles the blocks of all robots are a `Memory`; how a control step sees its robot's is in
`views`.
"""

import math
from collections import namedtuple
from dataclasses import dataclass
from itertools import accumulate, pairwise
from typing import Any

import numpy as np

from ..experiments.experiment import Experiment
from ..step_functions import keep_source

keep_source(__file__)

_SHAPES: dict[tuple[str, ...], str] = {
    # of robot, law and springs: `before` is the position of the tool a time step ago
    ("three",): "before tool_seen tool_offset tool_taken link_end",
    ("three", "three"): "orientation desired orientation_seen",
    ("joints",): "qpos_address dof_address joint_id actuator_id posture torque_limit tau_min "
    "tau_max gamma_k gamma_qe q_c k_min k_max low high stiffness offset y tau drift q dq "
    "angle speed angle_before seen commanded slow slower "
    "stiffness_step offset_step spring_error stiffening hysteresis damping viscous "
    "encoder_address encoder_dof torque_step no_load",
    ("coordinates",): "coordinate k_v k_p error rate s",
    ("joints", "joints"): "feedback feedback_p",
    ("coordinates", "joints"): "J",
    ("six", "dofs"): "jacobian",
    # leader: of a dof that follows the arm's; else -1, 0. chain: joints to the tool; then -1
    ("dofs",): "leader ratio qvel_seen chain chain_dof chain_slide chain_zero link_error",
    ("slots", "wide"): "ring",  # of what was measured a delay ago
    ("slots", "joints"): "torques",
    ("given",): "parameters",
    ("more", "more"): "work",
    # tables over the cycle
    ("steps", "coordinates"): "x_desired dx_desired",
    ("steps", "joints"): "q_desired dq_desired learned",
    ("steps", "columns"): "record",
    ("noisy", "joints"): "noise",
}

ARRAYS = {name: shape for shape, names in _SHAPES.items() for name in names.split()}
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
    "wide",  # of a row of the ring
    "more",  # than the joints and than the coordinates, by one
    "given",  # parameters of a custom law
    "site",  # the tool's id
    "rotates",  # 1 if the task has rotation, its last three coordinates
    "form",  # of (8): 0 for J^-1, 1 for J^T, 2 for the damped pseudo-inverse
    "difference",  # 1 for the tool's velocity by the difference of its positions
    "inertial",  # 1 for feedback by `feedback` too
    "usual",  # manipulability below which the damping grows
    "length",  # in which s measures position errors [m]
    "alpha",
    "alpha_0",
    "by_torque",
    "filtered",  # what the feedback's filters take over of y in a control period; 0 for none
    "slots",  # of the rings; 0 where the law sees what is and acts at once
    "delay",  # of measurement [time steps]
    "torque_delay",  # [time steps]
    "hold",  # time steps of a control period
    "resolution",  # of the encoders [rad]
    "differs",  # 1 for joint velocities as differences of angles
    "driven",  # 1 for motors with a rate or a speed
    "material",  # 1 for springs that do not follow Hooke's law
    "misjudged",  # 1 where the controller takes the arm's dimensions for others
    "command",  # number of the part of the control step that sets y and τ, where it is compiled
    "custom",  # address of that of a law's file, in this process
    "ease",  # what is left in a time step of the speed at which springs go on their way
    "outside",  # 1 where the Jacobian is handed in and not MuJoCo's
    "clock",  # time steps since the run began
    "timestep",
    "stages",  # callbacks per time step: 1, or 4 under RK4
    "stage",  # callbacks since the time step began
    "step",  # control steps since the cycle began
    "speed_limit",  # [rad/s]
    "failed_step",  # control step in which the run diverged, counted from 1; 0 if it has not
    "failed_joint",  # its joint; -1 where a custom law raised an exception
)

NUMBERS = (*_SCALARS, *ARRAYS)
"""Names of the header's numbers, in their order."""

Header: Any = namedtuple("Header", [name.upper() for name in NUMBERS])(*range(len(NUMBERS)))
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
    given: int = 0
    noisy: int = 0
    slots: int = 0
    three: int = 3
    six: int = 6

    @property
    def more(self) -> int:
        """One more than the joints and than the coordinates."""
        return max(self.joints, self.coordinates) + 1

    @property
    def wide(self) -> int:
        """Numbers of a state: angles, velocities, the tool's place, its Jacobian, the encoders."""
        return 2 * self.joints + 7 * self.dofs + 12

    @property
    def columns(self) -> int:
        """Numbers that a control step records."""
        return sum(getattr(self, size) for size in COLUMNS.values())

    def shape(self, name: str) -> tuple[int, ...]:
        """Shape of an array of the block."""
        return tuple(getattr(self, size) for size in ARRAYS[name])

    def starts(self) -> list[int]:
        """Where each array begins in the block, and where the last ends."""
        sizes = (math.prod(self.shape(name)) for name in ARRAYS)
        return list(accumulate(sizes, initial=len(Header)))

    @property
    def size(self) -> int:
        """Length of the block, and of the two numbers that lead to it."""
        return self.starts()[-1] + 2


def layout_of(experiment: Experiment, joints: int, coordinates: int, dofs: int) -> Layout:
    """Sizes of the block for an experiment, on an arm with so many joints, coordinates, dofs."""
    steps = max(motion.steps(experiment.simulation.timestep) for motion in experiment.motion)
    reality, dt = experiment.reality, experiment.simulation.timestep
    noisy = slots = 0
    if reality.sensed:
        delays = (reality.steps(key, dt) for key in ("measurement_delay", "torque_delay"))
        noisy, slots = steps, 1 + max(delays)
    parameters = len(experiment.law.parameters)
    return Layout(joints, coordinates, dofs, steps, parameters, noisy=noisy, slots=slots)


class Memory:
    """Named views of the block in the userdata of one or more robots.

    Args:
        userdata: `mjData.userdata` of each robot (robots, nuserdata); written in place.
        layout: sizes of the block, equal for all robots.
    """

    def __init__(self, userdata: np.ndarray, layout: Layout) -> None:
        self.layout = layout
        begin = userdata.shape[1] - layout.size
        self._block, self._userdata = userdata[:, begin:-2], userdata
        userdata[:, -2] = begin
        userdata[:, -1] = SIGNATURE
        for name in ("joints", "coordinates", "dofs", "columns", "wide", "more", "given", "slots"):
            self.scalar(name)[:] = getattr(layout, name)
        self._views: dict[str, np.ndarray] = {}
        for name, (start, end) in zip(ARRAYS, pairwise(layout.starts()), strict=True):
            self.scalar(name)[:] = start
            self._views[name] = self._block[:, start:end].reshape(
                len(userdata), *layout.shape(name)
            )

    def scalar(self, name: str) -> np.ndarray:
        """View of a number of the header (robots,)."""
        return self._block[:, getattr(Header, name.upper())]

    def block(self, robot: int) -> np.ndarray:
        """View of one robot's block, as the control step is handed it."""
        return self._block[robot]

    def fixed(self, robot: int) -> np.ndarray:
        """What no step of a robot changes: sizes, places and addresses, by which steps find all."""
        changes = ("stage", "step", "clock", "filtered", "command", "custom")
        header = [self.scalar(name)[robot] for name in NUMBERS if name not in changes]
        addresses = ["qpos_address", "dof_address", "joint_id", "actuator_id"]
        addresses += ["coordinate", "leader", "encoder_address", "encoder_dof"]
        addresses += ["chain", "chain_dof", "chain_slide"]
        counts = [self.scalar(name)[robot] for name in ("stage", "clock")]
        whole = [float(0 <= count < 2**53 and count == count // 1) for count in counts]
        ends = self._userdata[robot, -2:]
        return np.concatenate([header, whole, ends, *(self[name][robot] for name in addresses)])

    def __getitem__(self, name: str) -> np.ndarray:
        """View of an array (robots, *shape)."""
        return self._views[name]

    def recorded(self, name: str, steps: int) -> np.ndarray:
        """View of a recorded signal over a cycle of `steps` control steps (robots, steps, size)."""
        return self.columns(self["record"][:, :steps])[name]

    def columns(self, record: np.ndarray) -> dict[str, np.ndarray]:
        """Views of the signals in a record (..., columns)."""
        widths = [getattr(self.layout, size) for size in COLUMNS.values()]
        ends = accumulate(widths)
        return {
            name: record[..., end - width : end]
            for name, width, end in zip(COLUMNS, widths, ends, strict=True)
        }
