"""An experiment: frozen, validated, with defaults and dotted overrides."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any

import tomlkit
from pydantic import Field, model_validator

from ..errors import ExperimentError
from ..text import listed, nearest, shown
from .expectations import Expect
from .law_section import Law
from .motion_section import Motion
from .section import Section, Vector
from .sections import Robot, Simulation, Springs, Task
from .validation import validated


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
                f"springs.initial_equilibrium = {shown(springs.initial_equilibrium)}: "
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
        return validated(Experiment, values, f"experiment {self.name!r}")

    def to_toml(self) -> str:
        """The experiment as a TOML text that `load` reads back to an equal experiment."""
        values = _without_none(_as_lists(self.model_dump()))
        if self.expect == Expect():
            del values["expect"]
        return tomlkit.dumps(values)


def _child(node: Any, key: str, whole: str) -> Any:
    if isinstance(node, dict):
        if key in node:
            return node[key]
        raise ExperimentError(
            f"{whole}: unknown key{nearest(key, node)}; valid keys here are {listed(node)}"
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
