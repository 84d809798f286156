"""Experiments through MuJoCo's integrator: one call of `mj_step` per cycle, learning in between."""

import time
import warnings
from collections.abc import Callable, Sequence
from contextlib import nullcontext
from pathlib import Path
from typing import NamedTuple

import mujoco

from ..callback.callback import command_of, installed, not_kept, refuse_foreign
from ..claim import claimed
from ..errors import DivergedWarning, ExperimentError
from ..experiments.experiment import Experiment
from ..laws.memory import Memory
from ..plan.plan import Followed, Plan, plan_for
from ..progress import Asked, Progress, progressing
from ..results.run import Run
from ..robots.warned import heard
from ..status import Status
from . import continuing
from .checkpoint import check as check_resumed
from .continuing import Start
from .member import Member
from .stepper import Alone, Stepper, Together

SELDOM = 150
"""Least time between two checkpoints, as a multiple of what one takes."""


class Keep(NamedTuple):
    """How often and where a run so far is saved."""

    every: int
    """Cycles, or more where these take less time than `SELDOM` allows."""
    folder: str | Path


def simulate(
    experiment: Experiment,
    *,
    interpret: bool = False,
    strict: bool = False,
    after: Run | None = None,
    progress: Asked = None,
    note: Callable[[str], None] | None = None,
    stop: Callable[[], bool] | None = None,
    checkpoint: int = 0,
    folder: str | Path | None = None,
    resume: Run | None = None,
) -> Run:
    """Simulate one experiment.

    Args:
        experiment: what to simulate, from `load`.
        interpret: run the law as plain Python in the callback, for a debugger; the same numbers,
            some thirty times slower.
        strict: refuse what will diverge, where it would be a note else.
        after: a run of the same arm and task that this one goes on from, with its last state, and
            the springs and the torque that its law has learned. Its last motion goes on without a
            passage, and with the same bits as if it had never ended.
        progress: called after each cycle with the cycles done and the cycles in all; a bar in a
            terminal or a notebook if not given, nothing for False.
        note: called before the first step with each thing that was found, changed or is doubtful,
            and after the last with what the run showed; they stand in `Run.notes` too.
        stop: asked after each cycle whether to end there, with status INTERRUPTED.
        checkpoint: cycles after which the run so far is saved in `folder`, again and again, with
            status INTERRUPTED and all that it takes to resume it; 0 for never. It takes at most a
            hundred-and-fiftieth of the time: cycles that are simulated faster are more.
        folder: where it is saved.
        resume: an interrupted run of this experiment, which goes on where it was, and ends with the
            same bits as if nothing had happened; one that has ended is returned as it is.

    Returns:
        The run. One that diverges stops there, with a DivergedWarning, status DIVERGED and what was
        recorded; one whose tool does not follow its path at the end has status NOT_TRACKING, one
        that touches something on its way IN_CONTACT, one whose motors act on noise NOISY.

    Raises:
        RobotError: the robot cannot be loaded.
        MotionError: a motion leaves the arm's reach or passes through a singular pose.
        ExperimentError: `after` is a run of another arm or task, or one that did not end; or
            `resume` is of another experiment, of other files or versions.
        OutputError: a checkpoint cannot be saved, or another run is being saved there.
        StabilityError: the feedback or the learning will diverge, and `strict` is set.
        CallbackError: another program's callback is installed in this process.
    """
    refuse_foreign()
    if checkpoint < 0 or (checkpoint and folder is None):
        raise ExperimentError(
            f"checkpoint = {checkpoint}: a number of cycles and a folder for the run are needed"
        )
    plan = plan_for(experiment, left=None if after is None else continuing.left(after))
    start = None if after is None else continuing.start(after, plan)
    if strict:
        plan.refuse_unstable()
    note = note or (lambda line: None)
    for line in plan.notes:
        note(line)
    if resume is not None:
        check_resumed(resume, plan)
        if resume.status is not Status.INTERRUPTED:
            return resume
    keep = Keep(checkpoint, folder) if checkpoint and folder is not None else None
    with (
        nullcontext() if keep is None else claimed(keep.folder),
        progressing(progress, experiment.name, "cycles") as show,
    ):
        (run,) = simulate_plans(
            [plan],
            Alone,
            interpret=interpret,
            start=start,
            progress=show,
            stop=stop,
            keep=keep,
            resume=resume,
        )
    for line in run.notes[len(plan.notes) :]:
        note(line)
    if not interpret and (reason := not_kept()):
        note(reason)
    if run.status is Status.DIVERGED:
        warnings.warn(f"{experiment.name}: {run.message}", DivergedWarning, stacklevel=2)
    return run


def simulate_many(
    experiments: Sequence[Experiment],
    *,
    threads: int = 0,
    strict: bool = False,
    progress: Asked = None,
) -> list[Run]:
    """Simulate many experiments together, on all cores, through `mujoco.batch`.

    Experiments of one robot whose cycles have the same numbers of time steps step together; others
    follow each other. The results are bit for bit those of `simulate`, one by one.

    Args:
        experiments: what to simulate.
        threads: how many to use; 0 for all cores.
        strict: refuse them all if one will diverge, where it would be a note else.
        progress: called after each cycle with the cycles done and the cycles in all experiments; a
            bar in a terminal or a notebook if not given, nothing for False.

    Returns:
        The runs, in the order of the experiments.

    Raises:
        RobotError: a robot cannot be loaded.
        MotionError: a motion leaves an arm's reach or passes through a singular pose.
        StabilityError: the feedback or the learning of one will diverge, and `strict` is set.
        CallbackError: another program's callback is installed in this process.
    """
    refuse_foreign()
    followed: Followed = {}
    plans = [plan_for(experiment, followed) for experiment in experiments]
    for plan in plans:
        if strict:
            plan.refuse_unstable()
        _ = plan.notes  # what cannot be made is refused before the first step of any
    with progressing(progress, f"{len(plans)} experiments", "cycles") as show:
        return simulate_together(plans, threads=threads, progress=show)


def simulate_together(
    plans: Sequence[Plan], *, threads: int = 0, progress: Progress | None = None
) -> list[Run]:
    """Simulate plans, those that fit together in one `mujoco.batch`; see `simulate_many`."""
    groups: dict[tuple[object, ...], list[int]] = {}
    for index, plan in enumerate(plans):
        groups.setdefault(_fits_with(plan), []).append(index)
    total = sum(len(plan.schedule) for plan in plans)
    done = 0

    def count(cycles: int, _: int) -> None:
        if progress:
            progress(done + cycles * len(members), total)

    runs: dict[int, Run] = {}
    for members in groups.values():
        group = [plans[index] for index in members]
        found = simulate_plans(group, lambda models: Together(models, threads), progress=count)
        runs.update(zip(members, found, strict=True))
        done += len(group[0].schedule) * len(members)
    return [runs[index] for index in range(len(plans))]


def simulate_plans(
    plans: list[Plan],
    stepper_of: Callable[[list[mujoco.MjModel]], Stepper],
    *,
    interpret: bool = False,
    start: Start | None = None,
    progress: Progress | None = None,
    stop: Callable[[], bool] | None = None,
    keep: Keep | None = None,
    resume: Run | None = None,
) -> list[Run]:
    """Simulate plans that fit together, cycle by cycle.

    Args:
        plans: what to simulate.
        stepper_of: makes, of the robots' models, what advances them by the steps of each cycle.
        interpret: run the law as plain Python.
        start: what all of them go on from; rest at home if not given.
        progress: called after each cycle with the cycles done and the cycles in all.
        stop: asked after each cycle whether to end there.
        keep: of a plan alone, how often and where its run so far is saved.
        resume: of a plan alone, the run that it takes up.

    Returns:
        The runs, in the order of the plans.

    Raises:
        MotionError: a law that is told the joint motion is asked for one that cannot be made.
        CallbackError: another program's callback is installed in this process.
    """
    for plan in plans:
        _ = plan.inputs  # as they are now
        if "joints" in plan.law.told:
            _ = plan.passages
    first = plans[0]
    stepper = stepper_of([plan.robot.model for plan in plans])
    memory = Memory(stepper.userdata, first.layout)
    members = [Member(plan, memory, stepper, index, start) for index, plan in enumerate(plans)]
    wall, done, saving, last = 0.0, 0, 0.0, 0.0
    if resume is not None:
        members[0].resume(resume)
        wall, done = resume.simulation_wall_s, resume.data.sizes["cycle"]
    if not interpret:
        for index, plan in enumerate(plans):
            found = command_of(plan.law.command)
            memory.scalar("command")[index], memory.scalar("custom")[index] = found
    started = time.perf_counter()
    with heard(), installed(interpret=interpret, command=first.law.command):
        for cycle, segment in list(enumerate(first.schedule))[done:]:
            going = [i for i, member in enumerate(members) if member.status is Status.OK]
            if not going:
                break
            for i in going:
                members[i].begin_cycle(cycle)
            memory.scalar("step")[:] = 0
            began = time.perf_counter()
            for part, (steps, _) in enumerate(first.parts(segment)):
                for i in going if part else ():
                    members[i].carry(cycle, part)
                stepper.step(going, steps)
            wall += time.perf_counter() - began
            for i in going:
                members[i].end_cycle(cycle)
            if progress:
                progress(cycle + 1, len(first.schedule))
            going = [i for i in going if members[i].status is Status.OK]
            passed = time.perf_counter() - started
            due = keep and going and (cycle + 1) % keep.every == 0
            if keep and due and passed >= SELDOM * (saving + last):
                began = time.perf_counter()
                members[0].checkpoint(cycle, wall).save(keep.folder)
                last = time.perf_counter() - began
                saving += last
            if stop is not None and stop():
                for i in going:
                    members[i].interrupt(cycle)
                break
    return [member.run(wall) for member in members]


def _fits_with(plan: Plan) -> tuple[object, ...]:
    """Equal for experiments that one batch can step together."""
    robot, motion = plan.experiment.robot, plan.experiment.motion
    arm = robot.mjcf, robot.tool, robot.arm, robot.joints, plan.robot.payload
    how = plan.experiment.simulation.integrator, plan.layout
    parts = [tuple(steps for steps, _ in plan.parts(i)) for i in range(len(motion))]
    cycles = tuple((one.blend, *part) for one, part in zip(motion, parts, strict=True))
    of = plan.experiment.springs.element, plan.experiment.task
    return (*arm, *of, *how, cycles, tuple(plan.schedule))
