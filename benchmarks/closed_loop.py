"""What the control law costs: time per step of the closed loop beside that of a bare `mj_step`.

    python benchmarks/closed_loop.py [EXPERIMENT] [--rounds N] [--steps N]

Four loops step the same model, with the same time step, integrator and `userdata`, from the same
state, in one process and in turn:

- bare: `mj_step(model, data, steps)` without a callback, the springs and motor torques constant;
- compiled: the same call with the compiled law in `mjcb_control`;
- interpreted: the same call with the law as plain Python in `mjcb_control`;
- NumPy: a Python loop of one `mj_step` per step, with (4)-(8) on small NumPy arrays.

The state is that of the closed loop after `WARM_UP` cycles, so that the arm moves in all of them.
Times are CPU time of the one thread that steps: other programs on the machine do not count.
"""

from __future__ import annotations

import argparse
import contextlib
import random
import time
from collections.abc import Callable

import mujoco
import numpy as np

import resonance_mj as rmj
from resonance_mj.callback.callback import installed
from resonance_mj.laws import adjusting
from resonance_mj.laws.memory import Memory
from resonance_mj.plan.plan import Plan, plan_for
from resonance_mj.simulation.member import Member
from resonance_mj.simulation.stepper import Alone

COMPILED_TARGET = 1.25
"""Most that the compiled law may cost, as a multiple of the bare loop."""

NUMPY_TARGET = 20.0
"""Least number of times that the compiled law is faster than the NumPy loop."""

TOLERANCE = 1e-6
"""Largest relative difference of torque over a cycle at which two loops run the same law."""

WARM_UP = 3
"""Cycles of the closed loop, learning included, before the state that all loops start from."""


class Arm:
    """The closed loop of one experiment, stepped by hand, that can return to a saved state."""

    def __init__(self, plan: Plan) -> None:
        self.plan = plan
        self.model = plan.robot.model
        stepper = Alone([self.model])
        self.data, self.cycle = stepper.data, plan.steps(0)
        self.memory = Memory(stepper.userdata, plan.layout)
        self.member = Member(plan, self.memory, stepper, 0)
        self.member.begin_cycle(0)

    def write_springs(self) -> None:
        """Put the springs of the memory into the model, as at the start of a cycle."""
        model = self.model
        springs = model.jnt_stiffness, model.qpos_spring, model.dof_damping
        adjusting.write_springs(self.memory.block(0), *springs)

    def warm_up(self, cycles: int) -> None:
        """Run whole cycles with learning, and keep the state at the end of the last."""
        for cycle in range(cycles):
            mujoco.mj_step(self.model, self.data, self.cycle)
            self.member.end_cycle(cycle)
            self.member.begin_cycle(cycle + 1)
            self.memory.scalar("step")[:] = 0
        self._state = np.empty(mujoco.mj_stateSize(self.model, mujoco.mjtState.mjSTATE_INTEGRATION))
        mujoco.mj_getState(self.model, self.data, self._state, mujoco.mjtState.mjSTATE_INTEGRATION)

    def reset(self) -> None:
        """Return to the kept state; the springs lie in the memory and go to the model from it."""
        mujoco.mj_setState(self.model, self.data, self._state, mujoco.mjtState.mjSTATE_INTEGRATION)
        self.write_springs()


def numpy_loop(arm: Arm, steps: int) -> np.ndarray:
    """(4)-(8) as a loop in Python, one `mj_step` at a time, without bounds on the springs.

    Returns:
        The torque of each step (steps, n) [N m].
    """
    model, data, robot = arm.model, arm.data, arm.plan.robot
    law = arm.plan.experiment.law
    gamma_k, gamma_qe = np.array(law.gamma_k), np.array(law.gamma_qe)
    k_v, k_p, alpha, q_c = np.array(law.k_v), np.array(law.k_p), law.alpha, arm.plan.q_c
    dt, inverse = model.opt.timestep, law.jacobian == "inverse"
    x_desired, dx_desired = arm.memory["x_desired"][0], arm.memory["dx_desired"][0]
    learned = arm.memory["learned"][0]
    k, offset = arm.memory["stiffness"][0].copy(), arm.memory["offset"][0].copy()
    site, axes, dofs = robot.site, robot.coordinate, robot.dof_address
    joints, angles, motors = robot.joint_id, robot.qpos_address, robot.actuator_id
    jacobian = np.zeros((3, model.nv))
    log = {
        name: np.empty((steps, size))
        for size, names in ((robot.n, "q dq y tau stiffness offset"), (robot.m, "x"))
        for name in names.split()
    }
    for i in range(steps):
        # After mj_step, positions of the site are those of the state before it.
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_jacSite(model, data, jacobian, None, site)
        J = jacobian[axes][:, dofs]
        q, dq, x = data.qpos[angles], data.qvel[dofs], data.site_xpos[site][axes]
        error, rate = x - x_desired[i], J @ dq - dx_desired[i]
        s = np.sin(np.clip(error, -np.pi / 2, np.pi / 2))
        filtered = rate + alpha * s
        y = np.linalg.solve(J, filtered) if inverse else J.T @ filtered
        tau = learned[i] - J.T @ (k_v * rate + k_p * s)
        for name, value in zip(
            ("q", "dq", "x", "y", "tau", "stiffness", "offset"),
            (q, dq, x, y, tau, k, offset),
            strict=True,
        ):
            log[name][i] = value
        data.ctrl[motors] = tau
        mujoco.mj_step(model, data)
        k = k + dt * gamma_k * (q - q_c) * y
        offset = offset - dt * gamma_qe * y
        # A spring of stiffness 0 exerts nothing, whatever its angle.
        stiffness = np.where((k == 0) & (offset != 0), 1e-12, k)
        model.jnt_stiffness[joints] = stiffness
        model.qpos_spring[angles] = q_c + np.divide(
            offset, stiffness, out=np.zeros_like(k), where=stiffness != 0
        )
    return log["tau"]


def stepped(arm: Arm, steps: int) -> None:
    """`mj_step` in its own loop, with whatever callback is installed."""
    mujoco.mj_step(arm.model, arm.data, steps)


Loop = tuple[Callable[[Arm, int], object], Callable[[], contextlib.AbstractContextManager[None]]]


def loops(experiment: rmj.Experiment) -> dict[str, Loop]:
    """What is measured: how it steps, and what is installed meanwhile."""
    found: dict[str, Loop] = {
        "bare": (stepped, contextlib.nullcontext),
        "compiled": (stepped, installed),
        "interpreted": (stepped, lambda: installed(interpret=True)),
    }
    if not np.isfinite([*experiment.springs.stiffness, *experiment.springs.equilibrium]).any():
        found["NumPy"] = (numpy_loop, contextlib.nullcontext)
    return found


def torque_of_a_cycle(arm: Arm, loop: Loop) -> np.ndarray:
    """Torque of the cycle after the kept state (steps, n) [N m]."""
    step, install = loop
    arm.reset()
    with install():
        returned = step(arm, arm.cycle)
    if isinstance(returned, np.ndarray):
        return returned
    return arm.memory.recorded("tau", arm.cycle)[0].copy()


def measure(arm: Arm, contenders: dict[str, Loop], rounds: int, steps: int) -> dict[str, list]:
    """CPU time per step [µs] of each loop and round; the order within a round is shuffled."""
    times: dict[str, list] = {name: [] for name in contenders}
    order, shuffled = list(contenders), random.Random(0)
    for _ in range(rounds):
        shuffled.shuffle(order)
        for name in order:
            step, install = contenders[name]
            with install():
                # Untimed steps first: the loop before has left its own data in the caches.
                arm.reset()
                step(arm, max(1, steps // 10))
                arm.reset()
                began = time.thread_time_ns()
                step(arm, steps)
                took = time.thread_time_ns() - began
            times[name].append(took / 1e3 / steps)
    return times


def main() -> None:
    """Measure and print."""
    parser = argparse.ArgumentParser(description="Cost of the control law per time step.")
    parser.add_argument("experiment", nargs="?", default="paper", help="name or TOML file")
    parser.add_argument("--rounds", type=int, default=60, help="measurements of each loop")
    parser.add_argument(
        "--steps", type=int, help="time steps per measurement, at most and by default a cycle"
    )
    options = parser.parse_args()
    if options.rounds < 1:
        parser.error(f"--rounds {options.rounds}: at least 1 is needed")
    try:
        experiment = rmj.load(options.experiment)
        arm = Arm(plan_for(experiment))
    except rmj.ResonanceError as error:
        parser.error(str(error))
    steps = arm.cycle if options.steps is None else options.steps
    if not 1 <= steps <= arm.cycle:
        parser.error(f"--steps {steps}: 1 to {arm.cycle}, the steps of a cycle, are valid")
    with installed():
        arm.warm_up(WARM_UP)
    contenders = loops(experiment)

    model = arm.model
    integrator = mujoco.mjtIntegrator(model.opt.integrator).name.removeprefix("mjINT_").lower()
    print(f"{experiment.name}: {model.nv} joints, time step {model.opt.timestep:g} s, {integrator}")
    print(f"MuJoCo {mujoco.__version__}; {options.rounds} rounds of {steps} steps each, in turn\n")

    reference = torque_of_a_cycle(arm, contenders["compiled"])
    scale = np.abs(reference).max()
    print(f"largest torque of the cycle, compiled: {scale:.6g} N m; others relative to it:")
    for name in contenders:
        if name in ("bare", "compiled"):
            continue
        away = np.abs(torque_of_a_cycle(arm, contenders[name]) - reference).max() / scale
        # Written so that what is not a number fails too.
        if not away <= TOLERANCE:
            parser.exit(1, f"{name} differs by {away:.1e}: not the same law, nothing to compare\n")
        print(f"  {name:12} differs by at most {away:.1e} (tolerance {TOLERANCE:g}): same law")
    arm.reset()
    began = np.abs(arm.data.qvel).max()
    mujoco.mj_step(model, arm.data, steps)
    print(f"bare arm: {began:.3g} rad/s at the start, {np.abs(arm.data.qvel).max():.3g} at the end")
    if "NumPy" not in contenders:
        print("NumPy loop left out: it has no bounds on the springs, and this experiment has")

    times = measure(arm, contenders, options.rounds, steps)
    bare = np.array(times["bare"])
    print(f"\n{'loop':12} {'us/step':>9} {'quartiles':>17} {'x bare':>8} {'quartiles':>15}")
    for name, values in times.items():
        low, middle, high = np.percentile(values, (25, 50, 75))
        r_low, ratio, r_high = np.percentile(np.array(values) / bare, (25, 50, 75))
        print(
            f"{name:12} {middle:9.2f} {low:8.2f}-{high:8.2f} {ratio:8.2f} "
            f"{r_low:7.2f}-{r_high:7.2f}"
        )
    # Of two loops in the same round: what disturbs one disturbs the other.
    ratio = np.median(np.array(times["compiled"]) / bare)
    print(f"\ncompiled / bare   {ratio:7.2f}   target at most {COMPILED_TARGET:g}: ", end="")
    print("met" if ratio <= COMPILED_TARGET else "MISSED")
    if "NumPy" in times:
        ratio = np.median(np.array(times["NumPy"]) / np.array(times["compiled"]))
        print(f"NumPy / compiled  {ratio:7.2f}   target at least {NUMPY_TARGET:g}: ", end="")
        print("met" if ratio >= NUMPY_TARGET else "MISSED")


if __name__ == "__main__":
    main()
