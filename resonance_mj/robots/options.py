"""What an experiment says of the simulation, in an arm's model."""

import mujoco

from ..experiments.experiment import Experiment
from .mjcf import Arm

INTEGRATORS = {
    "Euler": mujoco.mjtIntegrator.mjINT_EULER,
    "implicitfast": mujoco.mjtIntegrator.mjINT_IMPLICITFAST,
    "RK4": mujoco.mjtIntegrator.mjINT_RK4,
}


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
    # A reset would wipe the record of a run that diverges; the controller detects it first.
    disabled = mujoco.mjtDisableBit.mjDSBL_AUTORESET
    if not experiment.robot.contacts:
        disabled |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    if not experiment.robot.limits:
        disabled |= mujoco.mjtDisableBit.mjDSBL_LIMIT
    spec.option.disableflags |= disabled
