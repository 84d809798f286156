"""The law on an arm that is somewhere else: two processes, a socket, packets that get lost.

    python examples/hardware.py [--cycles N] [--lost SHARE] [--late SECONDS]

One process is the arm: MuJoCo at its own pace, a time step of 1 ms per millisecond of the wall. It
sends what its sensors say and takes torques and springs, each in a packet of its own, and some are
lost: then it holds what it had. The other has no model of it and no clock but its own: it answers
what comes with `rmj.Controller`, and takes a state that was lost as unchanged. Prints torque² and
the tool's error of each cycle.
"""

from __future__ import annotations

import argparse
import multiprocessing
import random
import select
import socket
import struct
import time

import mujoco
import numpy as np

import resonance_mj as rmj
from resonance_mj.plan.plan import plan_for
from resonance_mj.springs.spring import equilibrium_angles


def experiment(cycles: int) -> rmj.Experiment:
    """The paper's arm and first motion with default gains, growing over four cycles."""
    paper = rmj.load("two-link-transfer")
    motion = paper.motion[0].model_copy(update={"duration": float(cycles), "blend": 4})
    return paper.replace(
        {"motion": [motion.model_dump(exclude_none=True)], "law": {}, "law.kind": "transfer"}
    )


def arm(port: int, asked: rmj.Experiment, late: float, lost: float, seed: int) -> None:
    """The arm: a socket, a clock and MuJoCo; it knows no law."""
    robot = plan_for(asked).robot
    model, data = robot.model, mujoco.MjData(robot.model)
    data.qpos[:] = robot.qpos
    jacobian, chance, n = np.zeros((6, model.nv)), random.Random(seed), robot.n
    time.sleep(late)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.connect(("127.0.0.1", port))
        line.setblocking(False)
        began, number, running = time.perf_counter(), 0, True
        while running:
            mujoco.mj_step1(model, data)
            mujoco.mj_jacSite(model, data, jacobian[:3], jacobian[3:], robot.site)
            x = data.site_xpos[robot.site][robot.coordinate]
            J = jacobian[np.ix_(robot.coordinate, robot.dof_address)]
            state = (data.qpos[robot.qpos_address], data.qvel[robot.dof_address], x, J.ravel())
            if chance.random() >= lost:
                line.send(struct.pack("q", number) + np.concatenate(state).tobytes())
            due = began + (number + 1) * model.opt.timestep
            while running and time.perf_counter() < due:
                for packet in waiting(line):
                    running = len(packet) > 1
                    if running and chance.random() >= lost:
                        tau, k, q_e = np.frombuffer(packet).reshape(3, n)
                        data.ctrl[robot.actuator_id] = tau
                        model.jnt_stiffness[robot.joint_id] = k
                        model.qpos_spring[robot.qpos_address] = q_e
            mujoco.mj_step2(model, data)
            number += 1


def waiting(line: socket.socket) -> list[bytes]:
    """Packets that have come, the newest last."""
    found = []
    while select.select([line], [], [], 0)[0]:
        try:
            found.append(line.recv(4096))
        except ConnectionRefusedError:  # nobody listens yet
            break
    return found


def main() -> None:
    """Start the arm and control it."""
    options = argparse.ArgumentParser()
    options.add_argument("--cycles", type=int, default=16)
    options.add_argument("--lost", type=float, default=0.01, help="share of packets that are lost")
    options.add_argument("--late", type=float, default=0.5, help="the arm is switched on so late")
    given = options.parse_args()
    asked = experiment(given.cycles)
    controller = rmj.Controller(asked)
    n, m = len(controller.joints), len(controller.axes)
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as line:
        line.bind(("127.0.0.1", 0))
        line.settimeout(30.0)
        there = multiprocessing.get_context("spawn").Process(
            target=arm, args=(line.getsockname()[1], asked, given.late, given.lost, 1), daemon=True
        )
        there.start()
        first, done = None, 0
        state = np.concatenate([controller.q, np.zeros(n + m + m * n)])
        packet, address = line.recvfrom(4096)
        packets = [packet]
        for _ in range(controller.cycles):
            springs = controller.springs
            now = np.concatenate([springs.stiffness, equilibrium_angles(*springs)])
            step = 0
            while step < controller.steps:
                while packets and step < controller.steps:
                    packet = packets.pop(0)
                    (number,) = struct.unpack("q", packet[:8])
                    first = number if first is None else first
                    # What was lost before it: the law has its steps, with the state as it was.
                    for _ in range(min(number - first - done, controller.steps - step - 1)):
                        _torque(controller, state, n, m)
                        step, done = step + 1, done + 1
                    state = np.frombuffer(packet[8:])
                    tau = _torque(controller, state, n, m)
                    step, done = step + 1, done + 1
                line.sendto(np.concatenate([tau, now]).tobytes(), address)
                packets = packets or [line.recv(4096)]
                packets += waiting(line)
            controller.end_cycle()
        line.sendto(b"0", address)
        there.join(5)
    (motion,) = controller.run().motions
    print("cycle, torque² [N² m²], error [mm]")
    for row in zip(motion.cycles, motion.torque_squared, 1e3 * motion.tracking_rms, strict=True):
        print("{:5d} {:8.3f} {:8.3f}".format(*row))
    print(f"optimum {motion.torque_squared_optimal:.3f}, springs {motion.stiffness[-1].round(3)}")


def _torque(controller: rmj.Controller, state: np.ndarray, n: int, m: int) -> np.ndarray:
    q, dq, x, J = np.split(state, [n, 2 * n, 2 * n + m])
    return controller.step(q, dq, x, J.reshape(m, n))


if __name__ == "__main__":
    main()
