"""Claims on a run and what was found of them: the results of `certify`."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

ROUNDING = 1e-10
"""Share of a torque that may be left over of an orthogonality."""


class Claim(NamedTuple):
    """What is claimed of a run."""

    equation: str
    """The paper's number."""
    text: str
    """In a few words."""
    needed: str
    """What its value must be."""


NOTHING_LEFT = f"≤ {ROUNDING:g}"

OF_A_CYCLE: dict[str, tuple[Claim, Claim]] = {
    "paper": (
        Claim("(9)", "u(t+T) = u - βy - w q̄", NOTHING_LEFT),
        Claim("(11)", "u(t+T) ⟂ q̄", NOTHING_LEFT),
    ),
    "transfer": (
        Claim("(9)", "motor+spring unchanged", NOTHING_LEFT),
        Claim("(11)", "u(t+T) ⟂ 1, q", NOTHING_LEFT),
    ),
}
"""Of each law with a proof, from a cycle to the next."""

OPTIMAL = Claim("(12)", "τ_dopt ⟂ q̄_d", NOTHING_LEFT)
PASSIVE = Claim("(15)", "c_7", "> 0")
FALLING = Claim("(22)", "N falls: next N / N", "≤ 1")


@dataclass(frozen=True)
class Certificate:
    """One claim, judged on one motion of a run.

    Attributes:
        motion: number of the motion, from 1.
        claim: what is claimed.
        cycles: numbers in the run of the cycles with a value (C,); empty for (12).
        values: share left over (C, n) for (9) and (11), (1, n) for (12); c_7 (C,) for (15); N [J]
            (C,) for (22).
        fails: which of the values make the claim fail, (C,) or (1,).
        worst: the value that is worst; of (22) the largest ratio of N to that of the cycle before.
            None if nothing was judged.
        where: cycle of the worst and joint, as far as it has them.
        note: why nothing was judged; else empty.
    """

    motion: int
    claim: Claim
    cycles: np.ndarray
    values: np.ndarray
    fails: np.ndarray
    worst: float | None = None
    where: str = ""
    note: str = ""

    @property
    def holds(self) -> bool | None:
        """Whether the claim holds wherever it was judged; None if it was not judged."""
        return None if self.worst is None else not self.fails.any()


@dataclass(frozen=True)
class Certificates:
    """The certificates of a run.

    Attributes:
        name: of the run.
        items: the certificates, motion by motion.
        joints: names of the joints (n).
        unit: of c_7.
        enough: c_7 from which on N falls, but for the third term of (23): half the largest
            eigenvalue of the learning gain, β/2.
    """

    name: str
    items: tuple[Certificate, ...]
    joints: tuple[str, ...]
    unit: str
    enough: float

    def of(self, equation: str) -> list[Certificate]:
        """The certificates of one equation, such as "(15)", motion by motion."""
        return [item for item in self.items if item.claim.equation == equation]


def judged(
    motion: int,
    claim: Claim,
    cycles: np.ndarray,
    values: np.ndarray,
    fails: np.ndarray,
    bad: np.ndarray,
    joints: tuple[str, ...] = (),
) -> Certificate:
    """A certificate whose worst value is where `bad`, (C,) or (C, n), is largest."""
    row, *joint = at = np.unravel_index(np.argmax(bad), bad.shape)
    where = [str(number) for number in cycles[row : row + 1]] + [joints[j] for j in joint]
    worst = float(values[at])
    return Certificate(motion, claim, cycles, values, fails, worst, ", ".join(where))


def left_over(
    motion: int, claim: Claim, cycles: np.ndarray, left: np.ndarray, joints: tuple[str, ...]
) -> Certificate:
    """A certificate on what is left over of a torque, (C, n), or (1, n) without cycles."""
    return judged(motion, claim, cycles, left, np.any(~(left <= ROUNDING), axis=1), left, joints)


def unknown(motion: int, claim: Claim, why: str) -> Certificate:
    """A certificate that could not be judged."""
    nothing = np.zeros(0)
    return Certificate(motion, claim, nothing.astype(int), nothing, nothing.astype(bool), note=why)
