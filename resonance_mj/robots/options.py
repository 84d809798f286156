"""What an experiment says of the simulation, in an arm's model."""

import mujoco
import numpy as np

from ..experiments.experiment import Experiment
from .mjcf import Arm

INTEGRATORS = {
    "Euler": mujoco.mjtIntegrator.mjINT_EULER,
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "RK4": mujoco.mjtIntegrator.mjINT_RK4,
}


def leaning(gravity: np.ndarray, about_x: float, about_y: float) -> np.ndarray:
    """Gravity (3,) [m/s²] as a base has it that leans by angles about x, and then about y [rad]."""
    (c, s), (k, z) = ((np.cos(a), np.sin(a)) for a in (about_x, about_y))
    first = np.array([[1, 0, 0], [0, c, -s], [0, s, c]])
    second = np.array([[k, 0, z], [0, 1, 0], [-z, 0, k]])
    return np.asarray((second @ first).T @ gravity)


def write(spec: mujoco.MjSpec, experiment: Experiment, arm: Arm) -> None:
    """Write what the experiment says of the simulation into the model.

    What is not MuJoCo's own default in the file, and nobody asked to change, is said.
    """
    given, option, usual = experiment.simulation, spec.option, mujoco.MjSpec().option
    integrator = mujoco.mjtIntegrator(option.integrator)
    of_file = {
        "timestep": (option.timestep, option.timestep == usual.timestep),
        "integrator": (
            {one: name for name, one in INTEGRATORS.items()}.get(integrator, integrator.name),
            integrator == usual.integrator,
        ),
    }
    for key, (value, is_usual) in of_file.items():
        if not (is_usual or value == getattr(given, key) or key in given.model_fields_set):
            arm.notes.append(f"simulation.{key} is {getattr(given, key)}; the file has {value}")
    spec.option.timestep = given.timestep
    spec.option.integrator = INTEGRATORS[given.integrator]
    if experiment.simulation.gravity is not None:
        spec.option.gravity = experiment.simulation.gravity
    if any(experiment.reality.base_tilt):
        spec.option.gravity = leaning(spec.option.gravity, *experiment.reality.base_tilt)
    # A reset would wipe the record of a run that diverges; the controller detects it first.
    disabled = mujoco.mjtDisableBit.mjDSBL_AUTORESET
    if not experiment.robot.contacts:
        disabled |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    if not experiment.robot.limits:
        disabled |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    spec.option.disableflags |= disabled
