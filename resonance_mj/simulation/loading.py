"""An experiment written into the controller's memory: its law once, its motion cycle by cycle."""

from dataclasses import replace

import mujoco
import numpy as np

from ..errors import ExperimentError
from ..laws.memory import Memory
from ..laws.tuning import Tuning
from ..motions.forward_kinematics import path_to_tool
from ..plan.plan import Plan
from ..robots.reach import reach as arm_reach
from ..springs.bounds import Bounds
from ..springs.fit import LinearSprings, nearest_to_nothing, reach
from ..text import shown


def load_law(memory: Memory, index: int, plan: Plan) -> None:
    """Write the robot's indices, the gains, the bounds and the first springs into the memory."""
    experiment, robot, chosen = plan.experiment, plan.robot, plan.gains
    law, bounds, reality = experiment.law, chosen.bounds, experiment.reality
    for name in ("qpos_address", "dof_address", "joint_id", "actuator_id", "coordinate"):
        memory[name][index] = getattr(robot, name)
    rotors = robot.followers.rotors
    turned = np.array([rotors.get(int(joint), int(joint)) for joint in robot.joint_id])
    memory["encoder_address"][index] = robot.model.jnt_qposadr[turned]
    memory["encoder_dof"][index] = robot.model.jnt_dofadr[turned]
    memory["leader"][index] = -1
    for j, joint in enumerate(robot.joint_id):
        for follower, speed in robot.followers.moved_by(joint)[1:]:
            dof = robot.model.jnt_dofadr[follower]
            memory["leader"][index, dof], memory["ratio"][index, dof] = j, speed
    memory["tool_offset"][index] = reality.tool_offset
    memory["chain"][index] = memory["chain_slide"][index] = -1
    errors = np.broadcast_to(np.asarray(reality.link_error, float), robot.n)
    for at, (joint, j, _) in enumerate(path_to_tool(robot)):
        memory["chain"][index, at] = joint
        memory["chain_dof"][index, at] = robot.model.jnt_dofadr[joint]
        memory["link_error"][index, at] = errors[j]
        if robot.model.jnt_type[joint] == int(mujoco.mjtJoint.mjJNT_SLIDE):
            place = robot.model.jnt_qposadr[joint]
            memory["chain_slide"][index, at] = place
            memory["chain_zero"][index, at] = robot.model.qpos0[place]
    memory["orientation"][index] = robot.orientation
    memory["posture"][index] = robot.home
    memory["k_v"][index] = chosen.k_v
    memory["k_p"][index] = chosen.k_p
    memory["feedback"][index] = chosen.feedback
    memory["feedback_p"][index] = chosen.feedback_p
    for name in ("gamma_k", "gamma_qe"):
        memory[name][index] = getattr(law, name) if name in plan.law.adapts else 0.0
    memory["parameters"][index] = law.parameters
    memory["k_min"][index], memory["k_max"][index] = bounds.stiffness
    memory["tau_min"][index], memory["tau_max"][index] = robot.torque_limit.T
    load_springs(memory, index, first_springs(plan), bounds)
    dt = experiment.simulation.timestep
    memory["torque_step"][index] = np.inf
    if reality.torque_rate is not None:
        memory["torque_step"][index] = np.asarray(reality.torque_rate) * dt
    memory["no_load"][index] = np.inf if reality.motor_speed is None else reality.motor_speed
    if bounds.material is not None:
        for name, value in bounds.material._asdict().items():
            memory["spring_error" if name == "error" else name][index] = value
        memory["viscous"][index] = robot.model.dof_damping[robot.dof_address]
    memory["before"][index] = robot.position
    # A joint that turns by a radian in a time step is beyond any sampled control.
    memory["torque_limit"][index] = np.diag(robot.inertia) / dt**2
    for name, value in (
        ("site", robot.site),
        ("rotates", robot.rotates),
        ("form", {"inverse": 0, "transpose": 1, "damped": 2}[chosen.jacobian]),
        ("difference", chosen.velocity == "difference"),
        ("inertial", bool(chosen.feedback.any())),
        ("usual", 0.1 * robot.usual),
        # The sine of (5) is of metres, and turns back at π/2 of them: on larger arms, of reaches.
        ("length", 1.0 if law.printed else max(1.0, arm_reach(robot))),
        ("by_torque", law.kind == "motor-torque"),
        ("alpha", chosen.alpha),
        ("alpha_0", chosen.alpha_0),
        ("timestep", dt),
        ("delay", reality.steps("measurement_delay", dt)),
        ("torque_delay", reality.steps("torque_delay", dt)),
        ("hold", reality.steps("control_period", dt)),
        ("resolution", reality.encoder_resolution),
        ("differs", reality.velocity == "difference"),
        ("driven", reality.torque_rate is not None or reality.motor_speed is not None),
        ("material", bounds.material is not None),
        ("misjudged", reality.misjudged),
        ("ease", np.exp(-dt / reality.stiffness_lag) if reality.stiffness_lag else 1.0),
        ("stages", 4 if experiment.simulation.integrator == "RK4" else 1),
        ("speed_limit", 1.0 / dt),
    ):
        memory.scalar(name)[index] = value


def load_springs(memory: Memory, index: int, springs: LinearSprings, bounds: Bounds) -> None:
    """Write the springs that act, and how far from their centre they may go, into the memory."""
    for name, value in zip(("stiffness", "offset", "q_c"), springs, strict=True):
        memory[name][index] = value
    memory["low"][index], memory["high"][index] = reach(bounds, springs.center)


def load_way(
    memory: Memory, index: int, begin: LinearSprings, end: LinearSprings, steps: int
) -> np.ndarray:
    """Let springs begin a cycle as they were and go on their way to what they shall be.

    Args:
        memory: of the robots.
        index: of the robot.
        begin: the springs as they are.
        end: as they shall be, at the end of the cycle or, where they lag, at the end of time.
        steps: of the cycle.

    Returns:
        Share of the way that is left at each step (steps,).
    """
    ease = float(memory.scalar("ease")[index])
    share = 1.0 / steps if ease == 1.0 else 1.0 - ease
    for name, first, last in zip(("stiffness", "offset"), begin, end, strict=False):
        memory[name][index] = first
        memory[f"{name}_step"][index] = share * (last - first)
    passed = np.arange(steps)
    return 1.0 - passed / steps if ease == 1.0 else ease**passed


def first_springs(plan: Plan) -> LinearSprings:
    """The springs at the start, about q_c; 0 stands for what is nearest to it and allowed."""
    own = _first_of_joints(plan)
    return replace(own, others=nearest_to_nothing(plan.gains.bounds, plan.robot.n))


def _first_of_joints(plan: Plan) -> LinearSprings:
    springs, bounds, adapts = plan.experiment.springs, plan.gains.bounds, plan.law.adapts
    k = np.broadcast_to(np.asarray(springs.initial_stiffness, float), plan.robot.n)
    k = np.where(bool(adapts) | (k != 0.0), np.clip(k, *bounds.stiffness), k)
    if plan.holding is not None:
        k = np.where(plan.holding.stiffness > 0, plan.holding.stiffness, k)
        return LinearSprings(k, plan.holding.offset, plan.q_c)
    q_c, (low, high) = plan.q_c, reach(bounds, plan.q_c)
    # Springs whose stiffness alone is adapted have their equilibrium at q_c, where q̄_e is 0.
    if adapts == ("gamma_k",):
        return LinearSprings(k, k * np.clip(0.0, low, high), q_c)
    given = springs.initial_equilibrium
    angle = np.asarray(given, float)
    away = angle - q_c
    inside = np.clip(away, low, high)
    outside = (k != 0.0) & (angle != 0.0) & (away != inside)
    if outside.any() and "springs" not in plan.law.told:
        j = int(outside.argmax())
        about = " about law.q_c" if springs.equilibrium_about == "center" else ""
        raise ExperimentError(
            f"experiment {plan.experiment.name!r}: springs.initial_equilibrium = {shown(given)} is "
            f"outside the bounds of {plan.robot.joints[j]}, springs.equilibrium{about}: "
            f"{low[j] + q_c[j]:.4g} to {high[j] + q_c[j]:.4g}"
        )
    return LinearSprings(k, k * np.where(angle == 0.0, inside, away), q_c)


def load_tuning(memory: Memory, index: int, plan: Plan, tuning: Tuning) -> None:
    """Write the gains that act into the memory, with what the law has found of its loop."""
    chosen, reality = plan.gains, plan.experiment.reality
    for name in ("k_v", "k_p", "feedback"):
        memory[name][index] = tuning.share * getattr(chosen, name)
    dt = plan.experiment.simulation.timestep
    period = reality.steps("control_period", dt) * dt
    memory.scalar("filtered")[index] = tuning.coefficient(chosen.omega, period)


def load_noise(memory: Memory, index: int, plan: Plan, cycle: int) -> None:
    """Write what the encoders will be off by in a cycle of the run into the memory."""
    reality, noise = plan.experiment.reality, memory["noise"]
    if noise.size and reality.encoder_noise:
        generator = np.random.default_rng([reality.seed, cycle])
        noise[index] = reality.encoder_noise * generator.standard_normal(noise[index].shape)


def load_motion(memory: Memory, index: int, plan: Plan, cycle: int) -> None:
    """Write the tables of a cycle of the run into the memory, and what its law is told of it."""
    samples = plan.desired(cycle)
    steps = len(samples.x)
    memory["x_desired"][index, :steps] = samples.x
    memory["dx_desired"][index, :steps] = samples.dx
    if plan.gains.velocity == "difference":
        positions, dt = len(plan.robot.position_axes), plan.experiment.simulation.timestep
        hold = plan.experiment.reality.steps("control_period", dt)
        before = samples.x[-hold:]
        if plan.blending(cycle) is not None:  # it does not begin where it ends
            before = samples.x[0] - np.arange(hold, 0, -1)[:, None] * samples.dx[0] * dt
        moved = samples.x - np.concatenate([before, samples.x[:-hold]])
        velocity = moved / (hold * dt)
        memory["dx_desired"][index, :steps, :positions] = velocity[:, :positions]
    told, segment = plan.law.told, plan.schedule[cycle]
    if "joints" in told:
        q, dq, ddq = plan.joint_motion(cycle)
        if plan.experiment.simulation.integrator != "RK4":
            # After a semi-implicit step q is that of its end, and q̇ that of its middle.
            dq = dq - 0.5 * plan.experiment.simulation.timestep * ddq
        memory["q_desired"][index, : len(q)] = q
        memory["dq_desired"][index, : len(q)] = dq
    if "springs" in told:
        load_springs(memory, index, plan.optima[segment].springs, plan.gains.bounds)
    if "torque" in told:  # of the motors that makes the desired motion with the best springs
        joints = plan.joint_motion(cycle)
        needed = (1 + plan.experiment.law.overestimate) * plan.loaded[segment].torque(joints)
        springs = plan.optima[segment].springs
        memory["learned"][index, : len(needed)] = needed - springs.torque(joints.q, joints.dq)
