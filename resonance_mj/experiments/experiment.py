"""An experiment: the TOML file as frozen, validated models, with defaults and dotted overrides."""

from __future__ import annotations

import difflib
import math
import os
import tomllib
from collections.abc import Mapping
from enum import StrEnum
from pathlib import Path
from typing import Annotated, Any, Literal, get_args

import tomlkit
from pydantic import BaseModel, Field, ValidationError, field_validator, model_validator

from .. import library
from ..errors import ExperimentError
from .expectations import Expect, Expected
from .section import Finite, Gain, Positive, Section

Vector = tuple[float, ...]
Gains = Gain | Annotated[tuple[Gain, ...], Field(min_length=1)]
Angles = Literal["mean"] | Finite | Annotated[tuple[Finite, ...], Field(min_length=1)]


class Robot(Section):
    """Which arm, which of its points follows the motion, and where it starts."""

    mjcf: str
    """A path, or the name of a file in mjcf/."""
    tool: str | None = None
    """The site or body that follows the motion; found if not given."""
    home: str | tuple[Finite, ...] | None = None
    """Joint angles at the start, at rest [rad], or a keyframe's name; found if not given."""
    contacts: bool = True
    """Whether bodies collide."""
    limits: bool = True
    """Whether joints stop at the ends of their range."""


class Task(Section):
    """What of the tool's pose is controlled."""

    coordinates: tuple[Literal["x", "y", "z", "rotation"], ...] | None = None
    """Of the tool in the world frame: any of x, y, z, and rotation; the positions that the arm
    controls if not given."""

    @field_validator("coordinates", mode="before")
    @classmethod
    def _one_alone(cls, value: Any) -> Any:
        return (value,) if isinstance(value, str) else value

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
    samples: Annotated[int, Field(gt=0)] = 200_000
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


class Motion(Section):
    """A periodic motion of the tool."""

    duration: Positive = 20.0
    """How long the motion is repeated [s]: a whole number of periods."""
    period: Positive = 1.0
    """Cycle time T [s]: a whole number of time steps."""
    shape: Literal["ellipse", "line", "eight", "polygon", "fourier", "csv"] = "ellipse"
    """ellipse, line, eight, polygon: with rounded corners, fourier: an offset plus harmonics, or
    csv: a smooth closed curve through waypoints."""
    frame: Literal["world", "base", "tool"] = "world"
    """Whose axes and origin the motion's positions are given in: world, base: of the body that
    carries the first joint, or tool: of the tool at home. Rotations are about the world's axes."""
    payload: Annotated[float, Field(ge=0, allow_inf_nan=False)] = 0.0
    """Mass that the tool carries during this motion, as a point at the tool [kg]; laws are not told
    of it, and computed-torque knows it."""
    blend: Annotated[int, Field(ge=0)] = 1
    """Cycles in which the arm passes over into this motion, without learning; 0 for a jump."""
    center: Annotated[tuple[Finite, ...], Field(min_length=1)] | None = None
    """Middle of an ellipse, line, eight or polygon [m], one per position coordinate; where the tool
    is at home if not given."""
    size: tuple[Finite, Finite] | None = None
    """Half of the shape's two sizes in its plane [m], for a polygon the half axes of the ellipse
    through its corners; the largest that the arm follows with margin if not given."""
    plane: tuple[Literal["x", "y", "z"], Literal["x", "y", "z"]] | None = None
    """The two coordinates in which an ellipse, line, eight or polygon lies; the first and the last
    of the task's positions if not given."""
    corners: Annotated[int, Field(ge=3)] | None = None
    """Number of corners of a polygon, the first on the plane's first coordinate; 4 if not given."""
    rounding: Annotated[float, Field(gt=0, le=1)] | None = None
    """Share of a polygon's sides that its rounded corners take, up to 1; 0.5 if not given."""
    offset: Annotated[tuple[Finite, ...], Field(min_length=1)] | None = None
    """Mean of a fourier motion [m], one per coordinate."""
    sin: tuple[tuple[Finite, ...], ...] = ()
    """Amplitudes of the sines [m]: a row per coordinate, a column per harmonic."""
    cos: tuple[tuple[Finite, ...], ...] = ()
    """Amplitudes of the cosines [m]: a row per coordinate, a column per harmonic."""
    file: str | None = None
    """Path of a csv motion's waypoints, absolute or from the experiment's folder: a column per
    coordinate [m, rad], in order or named in a header; t [s] or phase [cycles] if not equally
    spaced."""
    rotation_sin: tuple[tuple[Finite, ...], ...] = ()
    """Amplitudes of the sines of the tool's rotation vector from its orientation at home [rad]: a
    row each for rx, ry and rz, a column per harmonic; with any shape."""
    rotation_cos: tuple[tuple[Finite, ...], ...] = ()
    """Amplitudes of the cosines of the rotation vector [rad], as rotation_sin."""

    @model_validator(mode="after")
    def _fits_its_shape(self) -> Motion:
        own = _KEYS_OF_SHAPE[self.shape]
        every = dict.fromkeys(key for keys in _KEYS_OF_SHAPE.values() for key in keys)
        wrong = [key for key in every if key not in own and getattr(self, key) not in (None, ())]
        if wrong:
            shapes = [shape for shape, keys in _KEYS_OF_SHAPE.items() if wrong[0] in keys]
            raise ValueError(
                f"a motion of shape {self.shape!r} takes {_listed(own)}, not {_listed(wrong)}; "
                f"{wrong[0]} belongs to shape {' or '.join(map(repr, shapes))}"
            )
        if self.shape == "fourier" and self.offset is None:
            raise ValueError(
                "a motion of shape 'fourier' needs offset: its mean [m], a number per coordinate"
            )
        if self.shape == "csv" and not self.file:
            raise ValueError(
                "a motion of shape 'csv' needs file: the path of a CSV of waypoints, a row each"
            )
        for name, rows in (
            ("rotation_sin", self.rotation_sin),
            ("rotation_cos", self.rotation_cos),
        ):
            if rows and len(rows) != 3:
                raise ValueError(
                    f"{name} has {len(rows)} rows; 3 are needed, one each for rx, ry and rz"
                )
        for name, rows in (("sin", self.sin), ("cos", self.cos)):
            if rows and len(rows) != len(self.offset or ()):
                raise ValueError(
                    f"{name} has {len(rows)} rows and offset has {len(self.offset or ())} numbers: "
                    "both need one per coordinate"
                )
        if self.blend >= self.cycles:
            raise ValueError(
                f"blend = {self.blend} leaves no cycle of the {self.cycles} that the motion has"
            )
        cycles = self.duration / self.period
        if abs(cycles - round(cycles)) > 1e-9 * cycles:
            whole = max(1, round(cycles))
            raise ValueError(
                f"duration {self.duration:g} s is {cycles:.6g} periods of {self.period:g} s; "
                f"a whole number of periods is needed, for example {whole * self.period:g} s"
            )
        return self

    @property
    def cycles(self) -> int:
        """Number of cycles in the duration."""
        return max(1, round(self.duration / self.period))

    def steps(self, timestep: float) -> int:
        """Number of time steps of `timestep` [s] in a cycle."""
        return round(self.period / timestep)


_IN_PLANE = ("center", "size", "plane")
_KEYS_OF_SHAPE: dict[str, tuple[str, ...]] = {
    "ellipse": _IN_PLANE,
    "line": _IN_PLANE,
    "eight": _IN_PLANE,
    "polygon": (*_IN_PLANE, "corners", "rounding"),
    "fourier": ("offset", "sin", "cos"),
    "csv": ("file",),
}
"""What each shape is described by, besides the keys that every motion has."""


KINDS = (
    "feedback",
    "learning",
    "fixed",
    "joint-space",
    "paper",
    "transfer",
    "computed-torque",
)
"""The laws that an experiment can name, from the one that knows least to the one that knows all."""


class Law(Section):
    """The controller and its gains, by the paper's symbols."""

    kind: str = "transfer"
    """transfer: the spring takes over what it can of the learned torque; paper: (4)-(10); feedback:
    (4) without learning; learning: all torque is learned, the springs stay as they begin; fixed:
    the same with the optimal springs; joint-space: stiffness alone adapted to desired joint angles;
    computed-torque: optimal springs and the torque that the model asks for; or the path of a Python
    file with a law of your own."""
    parameters: Vector = ()
    """Numbers for a law of your own."""
    jacobian: Literal["damped", "inverse", "transpose"] | None = None
    """In (8): J^-1, J^T, or the damped pseudo-inverse with the posture in its null space."""
    velocity: Literal["jacobian", "difference"] | None = None
    """The tool's velocity in (4) and (8): jacobian: J q̇, or difference: of its positions over the
    last time step, which is what Euler and implicitfast mean by it; jacobian for laws as printed
    and under RK4 and difference else if not given."""
    k_v: Gains | None = None
    """Velocity feedback K_v [N s/m], one for all coordinates or one each; if neither k_v nor k_p is
    given, the feedback is -omega M y with the inertia M at home."""
    k_p: Gains | None = None
    """Position feedback K_p [N/m], one for all coordinates or one each."""
    omega: Gain | None = None
    """Bandwidth of the inertial feedback [1/s]; found from the time step if not given."""
    alpha: Gain = 10.0
    """Weight of the position error in (8) [1/s]."""
    alpha_0: Gain = 10.0
    """Weight of the posture's error in the null space [1/s]."""
    beta: Gain | None = None
    """Learning gain of (9) [N m s/rad]; if not given, eta times the feedback's own torque."""
    eta: Gain = 0.5
    """Share of the feedback's torque that is learned in a cycle, where beta is not given."""
    gamma_k: Gains = 0.0
    """Adaptation gain of the stiffness, (6) [N m/rad^3], one for all joints or one each."""
    gamma_qe: Gains = 0.0
    """Adaptation gain of the offset torque, (7) [N m/rad], one for all joints or one each."""
    q_c: Angles = "mean"
    """Centre of the spring's regressor [rad]; "mean" is the mean angle of the first motion."""
    q_s: Angles = "mean"
    """Centre of the learning's regressor (9), (10) [rad]; "mean" as for q_c."""
    lead: Annotated[int, Field(ge=0)] | None = None
    """How far ahead in the stored cycle learning reads y [control periods]; 0 for the law as
    printed and 1 else if not given."""
    harmonics: Annotated[int, Field(ge=1)] | None = None
    """Harmonics of 1/T that the learned torque keeps; all for the law as printed and 20 else if not
    given."""

    @field_validator("kind")
    @classmethod
    def _known_or_a_file(cls, value: str) -> str:
        if value in KINDS or value.endswith(".py"):
            return value
        raise ValueError(
            f"valid are {_listed(KINDS)}, or the path of a Python file, NAME.py"
            + _nearest(value, KINDS)
        )

    @property
    def printed(self) -> bool:
        """Whether the law is one of the authors', with (9), (10) and without lead if not given."""
        return self.kind in ("paper", "joint-space")

    @property
    def follows_joints(self) -> bool:
        """Whether the law is told the desired joint angles, and its gains act on theirs."""
        return self.kind in ("joint-space", "computed-torque")


class Springs(Section):
    """What the springs can do, and how they start."""

    stiffness: tuple[float, float] = (0.0, math.inf)
    """Bounds of the stiffness [N m/rad]."""
    equilibrium: tuple[float, float] = (-math.pi, math.pi)
    """Bounds of the equilibrium angle q_e - q_c [rad]."""
    initial_stiffness: Finite | tuple[Finite, ...] = 0.0
    """k(0) [N m/rad], one for all joints or one each."""
    initial_equilibrium: Finite | tuple[Finite, ...] = 0.0
    """q_e(0) [rad], one for all joints or one each."""

    @field_validator("stiffness", "equilibrium")
    @classmethod
    def _interval(cls, value: tuple[float, float]) -> tuple[float, float]:
        lower, upper = value
        if not lower < upper or lower == math.inf or upper == -math.inf:
            raise ValueError("[lower, upper] with lower < upper is needed, inf for no bound")
        return value

    @model_validator(mode="after")
    def _convex(self) -> Springs:
        if any(map(math.isfinite, self.equilibrium)):
            if self.stiffness[0] < 0:
                raise ValueError(
                    f"equilibrium = {list(self.equilibrium)} needs stiffness >= 0, and the lower "
                    f"bound of stiffness is {self.stiffness[0]:g}: with both signs the springs' "
                    "feasible set is not convex"
                )
            if not all(map(math.isfinite, self.equilibrium)):
                raise ValueError(
                    f"equilibrium = {list(self.equilibrium)}: give two finite bounds, or none "
                    "as [-inf, inf]"
                )
        return self


class Experiment(Section):
    """One experiment: a robot, a task, motions in a row, a law and springs."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$")]
    """Name of the run, and of its folder in runs/."""
    robot: Robot
    task: Task = Task()
    simulation: Simulation = Simulation()
    motion: Annotated[tuple[Motion, ...], Field(min_length=1)] = (Motion(),)
    law: Law = Law()
    springs: Springs = Springs()
    expect: Expect = Expect()

    @model_validator(mode="after")
    def _whole_time_steps(self) -> Experiment:
        for index, motion in enumerate(self.motion):
            dt = self.simulation.timestep
            steps = motion.period / dt
            if round(steps) < 2 or abs(steps - round(steps)) > 1e-9 * steps:
                whole = max(2, round(steps))
                raise ValueError(
                    f"motion.{index}.period = {motion.period:g} s is {steps:.6g} time steps of "
                    f"{dt:g} s; a whole number of at least 2 is needed, for example a period of "
                    f"{whole * dt:.9g} s or a time step of {motion.period / whole:.9g} s"
                )
            if self.law.lead is not None and self.law.lead >= round(steps):
                raise ValueError(
                    f"law.lead = {self.law.lead} is not shorter than the {round(steps)} time "
                    f"steps of a cycle of motion.{index}"
                )
            nyquist = round(steps) // 2
            if self.law.harmonics is not None and self.law.harmonics > nyquist:
                raise ValueError(
                    f"law.harmonics = {self.law.harmonics} is above the Nyquist limit of "
                    f"motion.{index}, period / (2 timestep) = {nyquist}; valid are 1 to {nyquist}"
                )
        return self

    @model_validator(mode="after")
    def _equilibrium_at_q_c(self) -> Experiment:
        springs = self.springs
        if (
            self.law.kind == "joint-space"
            and _not_zero(springs.initial_stiffness)
            and _not_zero(springs.initial_equilibrium)
        ):
            raise ValueError(
                f"springs.initial_equilibrium = {_shown(springs.initial_equilibrium)}: "
                "law.kind = 'joint-space' keeps the equilibrium at law.q_c: leave it out"
            )
        return self

    def replace(self, changes: Mapping[str, Any]) -> Experiment:
        """A copy with some values changed, validated as a file would be.

        Args:
            changes: dotted keys and their new values, such as `{"law.beta": 3.0}` or
                `{"motion.0.period": 0.5}`.

        Raises:
            ExperimentError: a key does not exist or a value is not valid.
        """
        values = _as_lists(self.model_dump())
        for key, value in changes.items():
            *parents, last = key.split(".")
            node: Any = values
            for parent in parents:
                node = _child(node, parent, key)
            _child(node, last, key)
            node[int(last) if isinstance(node, list) else last] = value
        return _validate(values, f"experiment {self.name!r}")

    def to_toml(self) -> str:
        """The experiment as a TOML text that `load` reads back to an equal experiment."""
        values = _without_none(_as_lists(self.model_dump()))
        if self.expect == Expect():
            del values["expect"]
        return tomlkit.dumps(values)


def load(name: str | os.PathLike[str]) -> Experiment:
    """Read an experiment.

    Args:
        name: name of a built-in experiment, or path of a TOML file.

    Raises:
        ExperimentError: there is no such experiment, the file is not TOML, or a value in it is
            not valid.
    """
    path = find(name)
    try:
        text = path.read_text(encoding="utf-8")
        values = tomllib.loads(text)
    except (OSError, UnicodeDecodeError) as error:
        raise ExperimentError(f"{path}: cannot be read: {error}") from None
    except tomllib.TOMLDecodeError as error:
        raise ExperimentError(f"{path}: not valid TOML: {error}") from None
    tables = [(values.get("robot"), "mjcf"), (values.get("law"), "kind")]
    motions = values.get("motion")
    tables += [(motion, "file") for motion in (motions if isinstance(motions, list) else ())]
    for table, key in tables:
        # A file that is named in an experiment is looked for beside it first.
        if isinstance(table, dict) and isinstance(table.get(key), str):
            beside = path.parent / table[key]
            if beside.is_file():
                table[key] = str(beside.resolve())
    values.setdefault("name", path.stem)
    return _validate(values, str(path))


def for_robot(mjcf: str) -> Experiment:
    """An experiment for an arm, with everything else found.

    Args:
        mjcf: path, or name in mjcf/; the experiment takes its name from it.
    """
    path = Path(mjcf)
    stem = path.parent.name if path.stem in ("robot", "scene", "model") else path.stem
    name = "".join(
        letter if (letter.isascii() and letter.isalnum()) or letter in "._-" else "-"
        for letter in stem
    )
    return _validate({"name": name.strip("._-") or "arm", "robot": {"mjcf": mjcf}}, mjcf)


def describe() -> list[tuple[str, str, str]]:
    """Every key of an experiment file, its default as TOML and its meaning."""
    rows: list[tuple[str, str, str]] = []
    sections: dict[str, type[BaseModel]] = {"": Experiment, **_SECTIONS}
    for section, model in sections.items():
        for name, field in model.model_fields.items():
            if section == "" and name in _SECTIONS:
                continue
            key = ".".join(filter(None, ("motion.0" if section == "motion" else section, name)))
            default = "(none)" if field.is_required() else _shown(field.default)
            rows.append((key, default, field.description or ""))
    return rows


def find(name: str | os.PathLike[str]) -> Path:
    """The file of a built-in experiment's name, or of a path.

    Raises:
        ExperimentError: there is no such experiment.
    """
    built_in = library.experiments()
    if isinstance(name, str) and name in built_in:
        return built_in[name]
    path = Path(name)
    if path.is_file():
        return path
    if path.suffix == ".toml" or len(path.parts) > 1:
        kind = "is a folder" if path.is_dir() else "does not exist"
        raise ExperimentError(f"{path}: {kind}; give a TOML file or one of {_listed(built_in)}")
    raise ExperimentError(
        f"no experiment is called {str(name)!r}{_nearest(str(name), built_in)}; "
        f"there are {_listed(built_in)}, or give the path of a TOML file"
    )


def _validate(values: dict[str, Any], source: str) -> Experiment:
    try:
        return Experiment.model_validate(values)
    except ValidationError as error:
        raise ExperimentError(_one_line(error, source)) from None


def _one_line(error: ValidationError, source: str) -> str:
    """The first problem of a validation as one line, and how many more there are."""
    problems = error.errors(include_url=False)
    # Of a union's branches pydantic reports each; the one that looked deepest fits the input best.
    first = max(problems, key=lambda p: (p["type"] == "extra_forbidden", len(p["loc"])))
    words = [str(part) for part in first["loc"]]
    key = ".".join(word for word in words if word.isdigit() or word in _NAMES)
    if first["type"] == "extra_forbidden":
        key = ".".join(words)
        section = _section(words[:-1])
        return (
            f"{source}: {key}: unknown key{_nearest(words[-1], section)}; "
            f"valid keys here are {_listed(section)}"
        )
    if first["type"] == "missing":
        return f"{source}: {key}: missing; it has no default"
    message = _PLAIN.get(first["type"], first["msg"].removeprefix("Value error, "))
    message = message[0].lower() + message[1:]
    where = f"{source}: {key}" if key else source
    if not isinstance(first["input"], (dict, BaseModel)):
        where += f" = {_shown(first['input'])}"
    return f"{where}: {message}"


_PLAIN = {"model_type": "a table of keys is needed", "tuple_type": "a list is needed"}
"""What pydantic says in words of Python."""


def _field_names(model: type[BaseModel]) -> set[str]:
    return set(model.model_fields)


_SECTIONS: dict[str, type[BaseModel]] = {
    "robot": Robot,
    "task": Task,
    "simulation": Simulation,
    "motion": Motion,
    "law": Law,
    "springs": Springs,
    "expect": Expect,
    "expect.stiffness": Expected,
}
_NAMES = set().union(_field_names(Experiment), *map(_field_names, _SECTIONS.values()))


def _section(path: list[str]) -> list[str]:
    """Keys of the section at a path of keys and indices."""
    model: type[BaseModel] = Experiment
    for key in path:
        if key in model.model_fields:
            model = _inside(model.model_fields[key].annotation) or model
    return list(model.model_fields)


def _inside(annotation: Any) -> type[BaseModel] | None:
    """The section that a field holds, alone, as an option or in a tuple."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next(filter(None, map(_inside, get_args(annotation))), None)


def _child(node: Any, key: str, whole: str) -> Any:
    if isinstance(node, dict):
        if key in node:
            return node[key]
        raise ExperimentError(
            f"{whole}: unknown key{_nearest(key, node)}; valid keys here are {_listed(node)}"
        )
    if isinstance(node, list) and key.isdigit() and int(key) < len(node):
        return node[int(key)]
    if isinstance(node, list):
        raise ExperimentError(f"{whole}: no element {key}; valid are 0 to {len(node) - 1}")
    raise ExperimentError(f"{whole}: {key} is inside a value, not a section")


def _as_lists(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _as_lists(item) for key, item in value.items()}
    return [_as_lists(item) for item in value] if isinstance(value, tuple) else value


def _without_none(value: Any) -> Any:
    if isinstance(value, dict):
        return {key: _without_none(item) for key, item in value.items() if item is not None}
    return [_without_none(item) for item in value] if isinstance(value, list) else value


def _not_zero(value: float | Vector) -> bool:
    return any(value) if isinstance(value, tuple) else bool(value)


def _shown(value: Any) -> str:
    if isinstance(value, StrEnum):
        value = str(value)
    text = repr(list(value) if isinstance(value, tuple) else value)
    return text if len(text) <= 80 else text[:77] + "..."


def _listed(names: Any) -> str:
    return ", ".join(names)


def _nearest(name: str, names: Any) -> str:
    close = difflib.get_close_matches(name, list(names), n=1)
    return f" (did you mean {close[0]!r}?)" if close else ""
