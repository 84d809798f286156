"""The arms of a model: chains of joints without a gripper's, and what hangs on their ends."""

from dataclasses import dataclass
from pathlib import Path

import mujoco
import numpy as np

from ..errors import RobotError
from ..text import listed, shown
from . import chain
from .names import is_gripper, is_leg, usual, words

FINGER_JOINTS = 5
"""Most joints of a gripper's finger, unless it is as light as that."""

FINGER_MASS = 0.02
"""Share of a robot's mass below which what spreads is a finger, however many joints it has."""


@dataclass(frozen=True)
class Branch:
    """One of the arms of a model.

    Attributes:
        joints: ids of the joints from the world to its end (n).
        ends: ids of the bodies that these joints move, and no other.
        names: of its own joints, which it does not share with all others.
        tools: names of the sites and bodies on its ends.
    """

    joints: tuple[int, ...]
    ends: tuple[int, ...]
    names: tuple[str, ...]
    tools: tuple[str, ...]

    @property
    def rank(self) -> tuple[bool, int, int]:
        """Smaller for what is likelier meant: no leg, with many joints, with a usual tool."""
        found = [place for place in map(usual, self.tools) if place is not None]
        other = len(self.names) < 2 or any(map(is_leg, (*self.names, *self.tools)))
        return other, -len(self.joints), min(found, default=99)


def find(model: mujoco.MjModel) -> list[Branch]:
    """All arms of a model, the one that is likeliest meant first."""
    chains = {body: chain.sprung_to(model, body) for body in range(1, model.nbody)}
    for body in model.flex_vertbodyid[model.flex_vertbodyid >= 0].tolist():
        chains[body] = ()
    spread = _spread(model)
    moved = {body for body, joints in chains.items() if joints}
    tips = moved - {int(model.body_parentid[body]) for body in moved}
    found = sorted({_without_gripper(model, tip, chains[tip], spread) for tip in tips})
    whole = [one for one in found if not any(one == other[: len(one)] != other for other in found)]
    shared = set.intersection(*map(set, whole)) if whole else set()
    branches = []
    for joints in whole:
        ends = tuple(body for body, its in chains.items() if its == joints)
        sites = [model.site(i) for i in range(model.nsite)]
        branches.append(
            Branch(
                joints,
                ends,
                tuple(model.joint(j).name for j in joints if j not in shared),
                tuple(site.name for site in sites if int(site.bodyid[0]) in ends)
                + tuple(model.body(body).name for body in ends),
            )
        )
    return sorted(branches, key=lambda branch: branch.rank)


def choose(branches: list[Branch], word: str, path: Path) -> list[Branch]:
    """Arms with those that have a word in the names of their joints or tools first.

    Raises:
        RobotError: there is none.
    """
    asked = words(word)
    chosen = [
        one
        for one in branches
        if any(
            word == name or (asked and set(asked) <= set(words(name)))
            for name in (*one.names, *one.tools)
        )
    ] or [
        one
        for one in branches
        if any(word.lower() in name.lower() for name in (*one.names, *one.tools))
    ]
    if not chosen:
        raise RobotError(
            f"{path}: robot.arm = {shown(word)}: no arm has it in the names of its joints or "
            f"tools; its arms are: {described(branches)}"
        )
    return chosen + [one for one in branches if one not in chosen]


def described(branches: list[Branch]) -> str:
    """Arms by their last joints, with the number of their joints."""
    return listed(
        f"{(one.names or ('the only one',))[-1]} ({len(one.joints)} joints)" for one in branches
    )


def _spread(model: mujoco.MjModel) -> np.ndarray:
    """Of each body, how many of its children move, or carry something that does (nbody,)."""
    moves, spread = model.body_jntnum > 0, np.zeros(model.nbody, int)
    for body in range(model.nbody - 1, 0, -1):
        parent = model.body_parentid[body]
        spread[parent] += moves[body]
        moves[parent] |= moves[body]
    return spread


def _without_gripper(
    model: mujoco.MjModel, tip: int, joints: tuple[int, ...], spread: np.ndarray
) -> tuple[int, ...]:
    """The joints that move `tip` without a finger's, past a body where several spread, or a jaw's.

    Two arms on a torso spread as well, but with more joints than a finger, or than are before them.
    """
    base = len(chain.mobile_base(model, list(joints)))
    grips = [is_gripper(model.joint(j).name, model.body(model.jnt_bodyid[j]).name) for j in joints]
    mass, child = model.body_subtreemass, tip
    before, body, found = len(joints), tip, len(joints)
    while body > 0:
        fingers = len(joints) - before
        named = before > base and all(grips[before:]) and not all(grips)
        small = fingers <= FINGER_JOINTS or mass[child] < FINGER_MASS * mass[model.body_rootid[tip]]
        if spread[body] > 1 and fingers and (named or (small and before - base >= fingers)):
            found = before
        before -= int(model.body_jntnum[body])
        child, body = body, int(model.body_parentid[body])
    while found > 1 and grips[found - 1] and not all(grips[:found]):
        found -= 1
    return joints[:found]
