"""An experiment: frozen, validated, with defaults and dotted overrides; and what its keys mean."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import BaseModel, Field, model_validator

from ..errors import ExperimentError
from ..text import cut, shown
from . import toml
from .expectations import Expect, Expected
from .law_section import Law
from .motion_section import MOST_CYCLES, Motion
from .motors_section import Motors
from .reality_section import Reality
from .sections import Robot, Section, Simulation, Task
from .springs_section import Element, JointSpring, Springs
from .validation import plain, validated

FEWEST_STEPS, MOST_STEPS = 8, 100_000
"""Time steps that a cycle may have."""

MOST_STEPS_IN_ALL = 2_000_000_000
"""Time steps that an experiment may have: hours of computing."""


class Experiment(Section):
    """One experiment: a robot, a task, motions in a row, a law and springs."""

    name: Annotated[str, Field(pattern=r"^[A-Za-z0-9][A-Za-z0-9._-]*$", max_length=100)]
    """Name of the run, and of its folder in runs/."""
    robot: Robot
    task: Task = Task()
    simulation: Simulation = Simulation()
    motion: Annotated[tuple[Motion, ...], Field(min_length=1, max_length=1000)] = (Motion(),)
    law: Law = Law()
    springs: Springs = Springs()
    motors: Motors = Motors()
    reality: Reality = Reality()
    expect: Expect = Expect()

    @model_validator(mode="after")
    def _whole_time_steps(self) -> Experiment:
        dt = self.simulation.timestep
        for index, motion in enumerate(self.motion):
            steps = motion.period / dt
            whole = round(min(max(steps, FEWEST_STEPS), MOST_STEPS))
            if not abs(steps - whole) <= 1e-9 * whole:
                raise ValueError(
                    f"motion.{index}.period = {motion.period:g} s is {steps:.6g} time steps of "
                    f"{dt:g} s; a whole number from {FEWEST_STEPS} to {MOST_STEPS} is needed, for "
                    f"example a period of {whole * dt:.9g} s or a time step of "
                    f"{motion.period / whole:.9g} s"
                )
            if (part := motion.shortest_part) and round(part[1] / dt) == round(part[0] / dt):
                raise ValueError(
                    f"motion.{index}.payload: from {part[0]:g} to {part[1]:g} s there is no time "
                    f"step of {dt:g} s"
                )
            hold = self.reality.steps("control_period", dt)
            if whole % hold:
                raise ValueError(
                    f"reality.control_period = {self.reality.control_period:g} s is {hold} time "
                    f"steps, and a cycle of motion.{index} has {whole}: a cycle must have a whole "
                    "number of control periods"
                )
            if self.law.lead is not None and self.law.lead >= whole:
                raise ValueError(
                    f"law.lead = {self.law.lead} is not shorter than the {whole} time steps of a "
                    f"cycle of motion.{index}"
                )
            nyquist = whole // 2
            if self.law.harmonics is not None and self.law.harmonics > nyquist:
                raise ValueError(
                    f"law.harmonics = {self.law.harmonics} is above the Nyquist limit of "
                    f"motion.{index}, period / (2 timestep) = {nyquist}; valid are 1 to {nyquist}"
                )
        return self

    @model_validator(mode="after")
    def _ends_in_a_lifetime(self) -> Experiment:
        dt = self.simulation.timestep
        cycles = sum(motion.cycles for motion in self.motion)
        steps = sum(motion.cycles * motion.steps(dt) for motion in self.motion)
        if cycles > MOST_CYCLES or steps > MOST_STEPS_IN_ALL:
            last = max(range(len(self.motion)), key=lambda index: self.motion[index].duration)
            raise ValueError(
                f"motion.{last}.duration = {self.motion[last].duration:g} s: all motions have "
                f"{cycles} cycles and {steps:.4g} time steps; at most {MOST_CYCLES} cycles and "
                f"{MOST_STEPS_IN_ALL:.0e} time steps are valid, {MOST_STEPS_IN_ALL * dt:g} s"
            )
        return self

    @model_validator(mode="after")
    def _springs_of_a_material(self) -> Experiment:
        springs = self.springs
        if not self.reality.hookean:
            what = "reality.spring_*"
        elif self.reality.stiffness_resolution is not None:
            what = "reality.stiffness_resolution"
        elif self.law.doubts:
            what = "law.doubts"
        else:
            return self
        for key, plain_ in (("cost", "torque-squared"), ("element", ()), ("weights", None)):
            if (given := getattr(springs, key)) != plain_:
                raise ValueError(
                    f"springs.{key} = {shown(given)} and {what} together: springs that are "
                    "not linear, or set in steps, are for the joints' own springs and torque², "
                    "leave one out"
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
                f"springs.initial_equilibrium = {shown(springs.initial_equilibrium)}: "
                "law.kind = 'joint-space' keeps the equilibrium at law.q_c: leave it out"
            )
        if self.law.kind == "joint-space" and self.law.q_c == "running":
            raise ValueError(
                "law.q_c = 'running': law.kind = 'joint-space' keeps the equilibrium at law.q_c, "
                'and would move it: give "mean" or angles'
            )
        return self

    def replace(self, changes: Mapping[str, Any]) -> Experiment:
        """A copy with some values changed, validated as a file would be.

        Args:
            changes: dotted keys and their new values, such as `{"law.beta": 3.0}` or
                `{"motion.0.period": 0.5}`. A section that is given as a dict, such as
                `{"law": {"kind": "transfer"}}`, changes those of its keys; an empty one takes
                all of them back to their defaults.

        Raises:
            ExperimentError: a key does not exist or a value is not valid.
        """
        values = plain(self.model_dump(exclude_unset=True))
        values.setdefault("motion", [{} for _ in self.motion])
        for key, value in changes.items():
            if key == "reality" and isinstance(value, str):
                value = {"preset": value}
            *parents, last = str(key).split(".")
            node: Any = values
            for parent in parents:
                node = (
                    node.setdefault(parent, {})
                    if isinstance(node, dict)
                    else node[_at(node, parent, key)]
                )
            if isinstance(value, Mapping):  # a copy: keys that follow may be of its section
                value = {**(node.get(last, {}) if value and not parents else {}), **value}
            node[last if isinstance(node, dict) else _at(node, last, key)] = value
        return validated(Experiment, values, f"experiment {self.name!r}")

    def to_toml(self) -> str:
        """The experiment as a TOML text that `load` reads back to an equal experiment."""
        values = self.model_dump()
        if self.expect == Expect():
            del values["expect"]
        return toml.document(values)


def _at(node: Any, index: str, key: str) -> int:
    """The index into a list that a part of a dotted key means."""
    if not isinstance(node, list):
        raise ExperimentError(f"{cut(key, 100)}: {cut(index)} is inside a value, not a section")
    if not (index.isdecimal() and len(index) < 9 and int(index) < len(node)):
        raise ExperimentError(
            f"{cut(key, 100)}: no element {cut(index)}; "
            + (f"valid are 0 to {len(node) - 1}" if node else "there is none")
        )
    return int(index)


def _not_zero(value: float | tuple[float, ...]) -> bool:
    return any(value) if isinstance(value, tuple) else bool(value)


_SECTIONS: dict[str, type[BaseModel]] = {
    "robot": Robot,
    "task": Task,
    "simulation": Simulation,
    "motion": Motion,
    "law": Law,
    "springs": Springs,
    "springs.joint.NAME": JointSpring,
    "springs.element": Element,
    "motors": Motors,
    "reality": Reality,
    "expect": Expect,
    "expect.stiffness": Expected,
}


def describe() -> list[tuple[str, str, str]]:
    """Every key of an experiment file, its default as TOML and its meaning."""
    rows: list[tuple[str, str, str]] = []
    sections: dict[str, type[BaseModel]] = {"": Experiment, **_SECTIONS}
    for section, model in sections.items():
        for name, field in model.model_fields.items():
            if section == "" and name in _SECTIONS:
                continue
            listed = section in ("motion", "springs.element")
            key = ".".join(filter(None, (f"{section}.0" if listed else section, name)))
            default = "(none)" if field.is_required() else shown(field.default)
            # A docstring's lines are not those of a table.
            rows.append((key, default, " ".join((field.description or "").split())))
    return rows
