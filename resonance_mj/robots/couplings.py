"""Joints that a file couples to the arm's in proportion: they follow, without spring or motor."""

from collections.abc import Iterator, Mapping, Sequence

import mujoco
import numpy as np

from ..text import listed
from . import chain


class Followers:
    """The joints of a model that follow an arm's, q = constant + ratio q_leader each.

    Args:
        model: of the file, or the arm's.
        joints: ids of the joints that lead.

    Attributes:
        constraint: which of the model's equality constraints couples each.
        joint: its id, after that of its leader where that follows too.
        leader: id of the joint that it follows.
        rotors: ids of joints that are rotors behind gears, by those of the arm's.
    """

    def __init__(self, model: mujoco.MjModel, joints: Sequence[int]) -> None:
        self.constraint: list[int] = []
        self.joint: list[int] = []
        self.leader: list[int] = []
        self._terms: list[tuple[float, float]] = []
        known, found = set(map(int, joints)), True
        while found:
            found = False
            for i, one, other, a, b in _linear(model):
                if (one in known) == (other in known):
                    continue
                if one in known:
                    one, other, a, b = other, one, -a / b, 1.0 / b
                self.constraint.append(i)
                self.joint.append(one)
                self.leader.append(other)
                self._terms.append((a, b))
                known.add(one)
                found = True
        self.rotors: dict[int, int] = {}
        self._model = model

    def turn(self, rotors: Mapping[int, int]) -> None:
        """Let rotors follow too, ids of their joints by those of the arm's."""
        self.rotors = dict(rotors)
        for leader, rotor in rotors.items():
            self.joint.append(rotor)
            self.leader.append(leader)
            self._terms.append((0.0, 1.0))

    def __bool__(self) -> bool:
        return bool(self.joint)

    def said(self) -> list[str]:
        """Which joints follow which, a line if any does."""
        name = [self._model.joint(j).name for j in range(self._model.njnt)]
        pairs = [f"{name[j]} follows {name[of]} ({b:+.4g})" for j, of, (_, b) in self._each()]
        return [f"coupled in the file, one spring and motor for both: {listed(pairs)}"] * bool(
            pairs
        )

    def place(self, qpos: np.ndarray) -> None:
        """Write where they are into qpos (..., nq), in which the arm's joints are set."""
        address = self._model.jnt_qposadr
        for j, leader, (a, b) in self._each():
            qpos[..., address[j]] = a + b * qpos[..., address[leader]]

    def move(self, rate: np.ndarray) -> None:
        """Write how they move into qvel or qacc (nv,), in which the arm's joints are set."""
        address = self._model.jnt_dofadr
        for j, leader, (_, b) in self._each():
            rate[address[j]] = b * rate[address[leader]]

    def borne(self, columns: np.ndarray) -> np.ndarray:
        """What the arm's joints bear of each dof (..., nv): its own, and of its followers.

        Args:
            columns: torques, or the columns of a Jacobian.
        """
        if not self.joint:
            return columns
        address, result = self._model.jnt_dofadr, columns.copy()
        for j, leader, (_, b) in reversed(list(self._each())):
            result[..., address[leader]] += b * result[..., address[j]]
        return result

    def moved_by(self, joint: int) -> list[tuple[int, float]]:
        """Ids of the joints that a joint of the arm moves, itself first, and how fast."""
        speeds = {int(joint): 1.0}
        for j, leader, (_, b) in self._each():
            if leader in speeds:
                speeds[j] = b * speeds[leader]
        return list(speeds.items())

    def narrow(self, model: mujoco.MjModel) -> None:
        """Let the leaders' ranges in a model end where those of their followers do."""
        for j, leader, (a, b) in reversed(list(self._each())):
            if model.jnt_limited[j]:
                low, high = sorted((model.jnt_range[j] - a) / b)
                if model.jnt_limited[leader]:
                    low = max(low, model.jnt_range[leader, 0])
                    high = min(high, model.jnt_range[leader, 1])
                model.jnt_limited[leader], model.jnt_range[leader] = True, (low, high)

    def _each(self) -> Iterator[tuple[int, int, tuple[float, float]]]:
        return zip(self.joint, self.leader, self._terms, strict=True)


def dependent(model: mujoco.MjModel, joints: list[int], driven: set[int]) -> set[int]:
    """Of some joints those that a constraint makes follow others of them.

    It is the first that a constraint names, unless that alone is driven by an actuator.
    """
    return {
        other if one in driven and other not in driven else one
        for _, one, other, _, _ in _linear(model)
        if one in joints and other in joints
    }


def _linear(model: mujoco.MjModel) -> Iterator[tuple[int, int, int, float, float]]:
    """Constraints of the form q_one = a + b q_other: their ids, one, other, a and b."""
    for i in range(model.neq):
        one, other = int(model.eq_obj1id[i]), int(model.eq_obj2id[i])
        a, b, *more = model.eq_data[i, :5].tolist()
        of_joints = model.eq_type[i] == int(mujoco.mjtEq.mjEQ_JOINT) and model.eq_active0[i]
        if not of_joints or other < 0 or b == 0.0 or any(more):
            continue
        if chain.carries_spring(model, one) and chain.carries_spring(model, other):
            at, its = model.qpos0[model.jnt_qposadr[[one, other]]].tolist()
            yield i, one, other, at + a - b * its, b
