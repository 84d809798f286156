"""Experiments through MuJoCo's integrator: one call of `mj_step` per cycle, learning in between."""

from __future__ import annotations

import time
from collections.abc import Callable, Sequence

import mujoco

from ..callback.callback import installed, refuse_another
from ..experiments.experiment import Experiment
from ..laws import controller, learning
from ..laws.memory import Memory
from ..plan.plan import Followed, Prepared, prepare, refuse_unstable
from ..results.run import Run, Status
from .loading import load_law, load_motion
from .recording import Recording
from .stepper import Alone, Stepper, Together

Progress = Callable[[int, int], None]
"""Called after each cycle with the number of cycles done and the number of all."""


def simulate(
    experiment: Experiment,
    *,
    interpret: bool = False,
    strict: bool = False,
    progress: Progress | None = None,
    note: Callable[[str], None] | None = None,
) -> Run:
    """Simulate one experiment.

    Args:
        experiment: what to simulate, from `load`.
        interpret: run the law as plain Python in the callback, for a debugger; the same numbers,
            some thirty times slower.
        strict: refuse what will diverge, where it would be a note else.
        progress: called after each cycle with the cycles done and the cycles in all.
        note: called before the first step with each thing that was found, changed or is doubtful;
            they stand in `Run.notes` too.

    Returns:
        The run. One that diverges stops there, with status DIVERGED and what was recorded.

    Raises:
        RobotError: the robot cannot be loaded.
        MotionError: a motion leaves the arm's reach or passes through a singular pose.
        StabilityError: the feedback or the learning will diverge, and `strict` is set.
        CallbackError: another simulation is running in this process.
    """
    refuse_another()
    prepared = prepare(experiment)
    if strict:
        refuse_unstable(prepared)
    if note is not None:
        for line in prepared.notes:
            note(line)
    return simulate_prepared([prepared], Alone, interpret=interpret, progress=progress)[0]


def simulate_many(
    experiments: Sequence[Experiment],
    *,
    threads: int = 0,
    strict: bool = False,
    progress: Progress | None = None,
) -> list[Run]:
    """Simulate many experiments together, on all cores, through `mujoco.batch`.

    Experiments of one robot whose cycles have the same numbers of time steps step together; others
    follow each other. The results are bit for bit those of `simulate`, one by one.

    Args:
        experiments: what to simulate.
        threads: how many to use; 0 for all cores.
        strict: refuse them all if one will diverge, where it would be a note else.
        progress: called after each cycle with the cycles done and the cycles in all experiments.

    Returns:
        The runs, in the order of the experiments.

    Raises:
        RobotError: a robot cannot be loaded.
        MotionError: a motion leaves an arm's reach or passes through a singular pose.
        StabilityError: the feedback or the learning of one will diverge, and `strict` is set.
        CallbackError: another simulation is running in this process.
    """
    refuse_another()
    followed: Followed = {}
    prepared = [prepare(experiment, followed) for experiment in experiments]
    if strict:
        for one in prepared:
            refuse_unstable(one)
    groups: dict[tuple[object, ...], list[int]] = {}
    for index, one in enumerate(prepared):
        groups.setdefault(one.fits_with, []).append(index)
    total = sum(len(one.schedule) for one in prepared)
    done = 0

    def count(cycles: int, _: int) -> None:
        if progress:
            progress(done + cycles * len(members), total)

    runs: dict[int, Run] = {}
    for members in groups.values():
        group = [prepared[index] for index in members]
        found = simulate_prepared(group, lambda models: Together(models, threads), progress=count)
        runs.update(zip(members, found, strict=True))
        done += len(group[0].schedule) * len(members)
    return [runs[index] for index in range(len(prepared))]


def simulate_prepared(
    group: list[Prepared],
    stepper_of: Callable[[list[mujoco.MjModel]], Stepper],
    *,
    interpret: bool = False,
    progress: Progress | None = None,
) -> list[Run]:
    """Simulate prepared experiments that fit together, cycle by cycle.

    Args:
        group: what to simulate.
        stepper_of: makes, of the robots' models, what advances them by the steps of each cycle.
        interpret: run the law as plain Python.
        progress: called after each cycle with the cycles done and the cycles in all.

    Returns:
        The runs, in the order of the group.

    Raises:
        CallbackError: another simulation is running in this process.
    """
    stepper = stepper_of([one.robot.model for one in group])
    memory = Memory(stepper.userdata, group[0].robot.layout)
    for index, one in enumerate(group):
        stepper.start(index, one.robot.qpos)
        load_law(memory, index, one)
    recordings = [Recording(one.experiment, one.robot, one.optima) for one in group]
    endings = [(Status.OK, "")] * len(group)
    steps_done = [0] * len(group)
    going = list(range(len(group)))
    schedule = group[0].schedule
    wall = 0.0
    passed = False
    with installed(interpret=interpret, command=group[0].law.command):
        for cycle, segment in enumerate(schedule):
            steps = group[0].steps(segment)
            passing = group[0].blending(cycle) is not None
            begins = cycle == 0 or segment != schedule[cycle - 1]
            for index in going:
                if begins:
                    stepper.models[index] = group[index].loaded[segment].model
                if begins or passing or passed:
                    load_motion(memory, index, group[index], cycle)
            began = time.perf_counter()
            memory.scalar("step")[:] = 0
            for index in going:
                controller.write_springs(
                    memory.block(index),
                    stepper.models[index].jnt_stiffness,
                    stepper.models[index].qpos_spring,
                )
            stepper.step(going, steps)
            wall += time.perf_counter() - began
            for index in list(going):
                failed = int(memory.scalar("failed_step")[index])
                recorded = failed - 1 if failed else steps
                recordings[index].add(memory, index, recorded, steps)
                steps_done[index] += recorded
                why = _what_diverged(memory, index, group[index], recordings[index], cycle)
                if why:
                    endings[index] = (Status.DIVERGED, why)
                    going.remove(index)
            if progress:
                progress(cycle + 1, len(schedule))
            if not going:
                break
            if cycle + 1 < len(schedule):
                between_cycles(memory, going, group, cycle)
            passed = passing
    return [
        Run(
            experiment=one.experiment,
            status=endings[index][0],
            message=endings[index][1],
            notes=(*one.notes, *recordings[index].notes()),
            data=recordings[index].dataset(),
            steps=steps_done[index],
            simulation_wall_s=wall,
        )
        for index, one in enumerate(group)
    ]


def between_cycles(memory: Memory, going: list[int], group: list[Prepared], cycle: int) -> None:
    """Replace the learned torque of a cycle by that of the next; a passage teaches nothing."""
    for index in going:
        one = group[index]
        now = one.steps(one.schedule[cycle])
        following = one.steps(one.schedule[cycle + 1])
        learned = memory.recorded("u", now)[index]
        if one.blending(cycle) is None:
            done = learning.Cycle(
                u=learned,
                y=memory.recorded("y", now)[index],
                q=memory.recorded("q", now)[index],
                q_desired=memory["q_desired"][index, :now],
                stiffness=memory["stiffness"][index],
                offset=memory["offset"][index],
                center=memory["q_c"][index],
                q_s=memory["q_s"][index],
            )
            learned, stiffness, offset, center = one.law.between(done, one.gains, one.experiment)
            memory["stiffness"][index] = stiffness
            memory["offset"][index] = offset
            memory["q_c"][index] = center
        memory["learned"][index, :following] = learning.resample(learned, following)


def _what_diverged(
    memory: Memory, index: int, one: Prepared, recording: Recording, cycle: int
) -> str:
    """Which joint failed, when, why, and what to try; empty if none did."""
    dt = one.experiment.simulation.timestep
    where = f"motion {one.schedule[cycle] + 1} diverged in cycle {cycle + 1} of the run"
    failed = int(memory.scalar("failed_step")[index])
    if failed:
        joint = one.robot.joints[int(memory.scalar("failed_joint")[index])]
        why = f"{joint} would turn by more than one radian in a time step"
        where += f", {(failed - 1) * dt:.3f} s into it"
    else:
        why = recording.diverges()
        if not why:
            return ""
    tries = f"a shorter simulation.timestep (now {dt:g} s)"
    if cycle == 0:
        tries = f"smaller law.k_v and law.k_p or {tries}"
        if one.experiment.law.k_v is None and one.experiment.law.k_p is None:
            tries = f"a smaller law.omega (now {one.gains.omega:g} 1/s) or {tries}"
    else:
        law = one.experiment.law
        key, now = ("eta", law.eta) if law.beta is None else ("beta", law.beta)
        tries = f"a smaller law.{key} (now {now:g}) or {tries}"
        if one.gains.lead == 0:
            tries = f"law.lead = 1, {tries}"
    return f"{where}: {why}; try {tries}"
