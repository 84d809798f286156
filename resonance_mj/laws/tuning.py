"""What a law has found of its loop: noise, delay, the true weight of its arm; and how it acts."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..text import percent
from .doubting import Belief

HEAVY = 0.5
"""r below which the feedback is made stronger: the arm is twice as heavy as it was taken to be."""

FILTER = 5.0
"""Cutoff of the feedback's two filters where there is noise, over its bandwidth."""

BY_HAND = ("k_v", "k_p", "omega", "beta", "eta", "lead", "harmonics")
"""Gains of a law that is left as it is if one of them is given."""


class Tuning(NamedTuple):
    """What a law has found of its loop, and how it acts on it."""

    share: float = 1.0
    """g: how much of the feedback's gain, and of what is learned of it, acts."""
    lead: int | None = None
    """Time steps that learning reads y ahead; None as the gains have it."""
    filtered: bool = False
    """Whether the feedback acts on filtered y."""
    delay: int = 0
    """Time steps of delay of the loop that were found, beyond its own of one."""
    ratio: float = 1.0
    """r = M̂ / M."""
    pace: float = 1.0
    """Of what is learned, where learning grew and no delay explained it."""
    least: float = np.inf
    """Least that was to be learned in a cycle with these gains, as a mean square [N² m²]."""
    last: tuple[float, ...] = ()
    """The same of the last few cycles."""
    noise: float = 0.0
    """Torque² that noise of y makes of the whole feedback, in the cycle before [N² m²]."""
    known: tuple[np.ndarray, np.ndarray] | None = None
    """Of each harmonic, mean |Δτ|² and Δτ* L Δy in the cycles with these gains."""
    cycles: int = 0
    """How many pairs of them there were."""
    change: float = np.inf
    """Sum of |Δτ|² over the last pair."""
    before: tuple[np.ndarray, np.ndarray] | None = None
    """Total torque and y of the cycle before (N, n), with the same gains."""
    springs: Belief | None = None
    """What springs are taken to be; None for linear ones."""

    def fits(self, shape: tuple[int, int]) -> bool:
        """Whether it is of cycles of so many samples and joints."""
        signals = [*(self.before or ())]
        if self.springs is not None:
            signals += [self.springs.before, self.springs.known and self.springs.known[1]]
        return all(one is None or one.shape == shape for one in signals)

    def coefficient(self, omega: float, period: float) -> float:
        """What the filters take over of y in a control period [s]; 0 for no filter."""
        return 1.0 - float(np.exp(-FILTER * self.share * omega * period)) if self.filtered else 0.0

    def said(self, timestep: float) -> list[str]:
        """What was found, and how the law acts on it, in words."""
        found, acts = [], f"the feedback acts with {percent(self.share, 0)} of its gain"
        if self.filtered:
            # By its ear a motor that goes from limit to limit is noise too.
            found.append(f"the error is noisy, by encoders or motors at limits: {acts}, filtered")
        elif self.ratio < HEAVY:
            found.append(
                f"the arm is heavier than its file, about {1 / self.ratio:.1f} times: {acts}"
            )
        if self.delay:
            found.append(
                f"the loop answers {self.delay * timestep:.3g} s late: {acts}, and learning reads "
                f"the error {self.lead} time steps ahead"
            )
        if self.pace < 1.0:
            found.append(
                f"learning grew, and no delay explained it: it goes at {percent(self.pace, 0)} of "
                "its pace"
            )
        if self.springs is not None:
            found += self.springs.said()
        return found
