"""The sections [robot], [task], [simulation] and [springs], and the types that all share."""

from __future__ import annotations

import hashlib
import math
import tempfile
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    field_validator,
)

from ..turns import compiling


def _one_alone(given: Any) -> Any:
    """A list of one number or name may be written without brackets."""
    return (given,) if isinstance(given, int | float | str) else given


def _bound(given: float) -> float:
    if not (abs(given) <= 1e9 or math.isinf(given)):
        raise ValueError("valid are numbers from -1e9 to 1e9, and -inf or inf for no bound")
    return given


Name = Annotated[str, Field(max_length=4096, pattern=r"^[^\x00]*$")]
"""Of a file, or of an element of the robot."""
Finite = Annotated[float, Field(ge=-1e6, le=1e6, allow_inf_nan=False, strict=True)]
"""Lengths, angles and accelerations: beyond, sums of squares have no digits left."""
Positive = Annotated[float, Field(gt=0, le=1e12, allow_inf_nan=False, strict=True)]
Gain = Annotated[float, Field(ge=0, le=1e9, allow_inf_nan=False, strict=True)]
Stiffness = Annotated[float, Field(ge=-1e9, le=1e9, allow_inf_nan=False, strict=True)]
Bound = Annotated[float, AfterValidator(_bound)]
Alone = BeforeValidator(_one_alone)
"""Lets a list take one value alone."""
Numbers = Annotated[tuple[Finite, ...], Field(min_length=1), Alone]
Rows = Annotated[tuple[Annotated[tuple[Finite, ...], Alone], ...], Alone]
Gains = Gain | Annotated[tuple[Gain, ...], Field(min_length=1)]
Angles = Finite | Annotated[tuple[Finite, ...], Field(min_length=1)]


class Section(BaseModel):
    """A table of the file: frozen, without unknown keys; each key's docstring says what it is."""

    model_config = ConfigDict(
        defer_build=True, frozen=True, extra="forbid", use_attribute_docstrings=True
    )


FOLDER = "models"
"""Folder in the user's cache for models that were given from memory."""


def as_file(given: Any) -> Any:
    """The path of a file that holds an MjSpec or MjModel, the same for the same model.

    Anything else is returned as it is.

    Raises:
        ValueError: MuJoCo cannot compile the MjSpec.
    """
    if not type(given).__module__.startswith("mujoco"):
        return given
    import mujoco
    import numpy as np
    from platformdirs import user_cache_path

    with compiling:
        model = given.compile() if isinstance(given, mujoco.MjSpec) else given
    if not isinstance(model, mujoco.MjModel):
        return given
    buffer = np.empty(mujoco.mj_sizeModel(model), np.uint8)
    mujoco.mj_saveModel(model, None, buffer)
    content = buffer.tobytes()
    name = model.names.partition(b"\0")[0].decode(errors="replace")
    safe = "".join(letter for letter in name if letter.isalnum() or letter in "-_") or "model"
    folder = user_cache_path("resonance-mj") / FOLDER
    folder.mkdir(parents=True, exist_ok=True)
    path = folder / f"{safe[:60]}-{hashlib.sha256(content).hexdigest()[:8]}.mjb"
    if not path.is_file() or path.read_bytes() != content:
        with tempfile.NamedTemporaryFile(dir=folder, delete=False) as file:
            file.write(content)
        Path(file.name).replace(path)
    return str(path)


class Robot(Section):
    """Which arm, which of its points follows the motion, and where it starts."""

    mjcf: Annotated[Name, BeforeValidator(as_file)]
    """A path, or the name of a file in mjcf/; in Python an MjSpec or MjModel as well."""
    tool: Name | None = None
    """The site or body that follows the motion, or com:BODY for its center of mass; found if not
    given."""
    arm: Name | None = None
    """Of several arms the one that has this word in the names of its joints or tool, such as left;
    the one with the most joints if not given."""
    joints: Annotated[tuple[Name, ...], Field(min_length=1), Alone] | None = None
    """The joints that move, of those between the world and the tool; the others are held. All that
    the file drives if not given, but for a mobile base's."""
    base: Literal["hold"] = "hold"
    """A base that floats freely in the file is held where the home pose has it."""
    home: Name | Numbers | None = None
    """Joint angles at the start, at rest [rad], or a keyframe's name; found if not given."""
    contacts: bool = True
    """Whether bodies collide."""
    limits: bool = True
    """Whether joints stop at the ends of their range."""
    packages: Annotated[tuple[Name, ...], Alone] = ()
    """Folders that hold the packages of a URDF's package:// names, besides its own and those of
    ROS_PACKAGE_PATH."""


class Task(Section):
    """What is controlled: of the tool's pose, or the joints."""

    space: Literal["tool", "joint"] = "tool"
    """tool: motions are the tool's, and the law knows no inverse kinematics; joint: motions are the
    joints', in radians, a number or column per joint where the tool's have one per coordinate."""
    coordinates: Annotated[tuple[Literal["x", "y", "z", "rotation"], ...], Alone] | None = None
    """Of the tool in the world frame, or what is recorded of it in a task of the joints: any of x,
    y, z, and rotation; the positions that the arm controls if not given."""

    @field_validator("coordinates")
    @classmethod
    def _distinct(cls, value: tuple[str, ...] | None) -> tuple[str, ...] | None:
        if value is None:
            return value
        if len(set(value)) != len(value):
            raise ValueError("each coordinate may be named once")
        if not value or value == ("rotation",):
            raise ValueError("at least one of x, y and z is needed")
        # Rotation is always the last, so that a motion's position comes first.
        return tuple(sorted(value, key=lambda name: name == "rotation"))


class Simulation(Section):
    """How MuJoCo integrates the robot."""

    timestep: Positive = 1e-3
    """Time step and control period [s]."""
    integrator: str = "implicitfast"
    """Euler, implicitfast or RK4."""
    gravity: tuple[Finite, Finite, Finite] | None = None
    """[m/s^2]; the model's own if not given."""
    samples: Annotated[int, Field(gt=0, le=10_000_000)] = 200_000
    """About how many time samples are kept in the run; beyond it whole cycles are left out, and
    pairs of cycles in a row are kept, the first two and the last two of a motion among them."""

    @field_validator("integrator")
    @classmethod
    def _explicit_in_position(cls, value: str) -> str:
        if value in ("Euler", "implicitfast", "RK4"):
            return value
        reasons = {
            "discrete": "it treats joint springs implicitly and dissipates their energy, "
            "which biases every torque measured here",
            "implicit": "it adds nothing for an arm that implicitfast lacks, and costs "
            "a full LU factorisation at each step",
        }
        reason = f" ({reasons[value]})" if value in reasons else ""
        raise ValueError(f"valid integrators are Euler, implicitfast and RK4{reason}")
