"""Whether learning from cycle to cycle is stable when it is sampled: predicted before a run.

At a pose that is held, a learned torque of frequency ω is multiplied in each cycle by

    P(ω) = I - β G(e^{jωΔt}) e^{jωδΔt}                                  (9)

where y = G u is the response of the sampled arm under its feedback, and δ the lead. A harmonic
grows if |1 - μ| > 1 for an eigenvalue μ of β G e^{jωδΔt}. Another β multiplies μ by some s, and
|1 - s μ| > 1 from s = 2 Re μ / |μ|² on: the gain margin.

The arm moves while it answers. Far above the motion's own frequencies a packet of waves stays where
it is in the cycle and is multiplied by P of the pose there: the worst pose decides. Low harmonics
last longer than a pose; G_t of the pose at t couples them, Y_h = Σ Ĝ_{h-h'}(h') U_h', and the
eigenvalues of this matrix decide. docs/stability.md derives both, and says what is left out.
"""

from bisect import bisect_left
from typing import NamedTuple

import numpy as np

from .sampled_loop import SampledLoop

LOW = 40
"""Harmonics of 1/T up to which the change of the pose couples them, where the cycle has as many."""

SPACING = 1.1
"""Ratio of neighbouring harmonics that are examined above them."""

GROWTH = 1e-5
"""Growth per cycle below which nothing is said to grow."""

GROWTH_LOW = 2e-3
"""The same for low harmonics, whose coupling is known no better."""


class LearningLoop(NamedTuple):
    """Learning over a cycle of `steps` samples, at P poses equally spaced in the cycle."""

    steps: int
    harmonics: np.ndarray
    """The harmonics of 1/T that are examined, ascending from 0, all low ones among them (H,)."""
    gain: np.ndarray
    """β G at each pose and harmonic (P, H, n, n)."""
    eigenvalues: np.ndarray
    """Of β G (P, H, n): a lead turns those of a harmonic by one angle, another β scales them."""

    @property
    def low(self) -> np.ndarray:
        """Which of the harmonics are low (H,)."""
        return self.harmonics <= low_harmonics(self.steps)

    def multiplier(self, lead: int) -> np.ndarray:
        """The factor per cycle of each harmonic at each pose held, max |1 - μ| (P, H)."""
        return np.abs(1 - self._led(lead)).max(axis=-1)

    def margin(self, lead: int, kept: int | None = None) -> float:
        """Gain margin: the multiple of β up to which no harmonic grows.

        Args:
            lead: δ [control periods].
            kept: harmonics that the learned torque keeps; None for all.

        Returns:
            At least 1 if the loop is stable; else a multiple with which it would be.
        """
        inside = self.harmonics <= (self.steps if kept is None else kept)
        led = self._led(lead)
        above = _gain_margin(led[:, inside & ~self.low])
        held = _gain_margin(led[:, inside & self.low])
        if held >= 1 or above < 1:
            return min(held, above)
        # Poses that are held are too strict with low harmonics, and cheaper.
        coupled = np.linalg.eigvals(self.coupled(lead, kept))
        return min(above, _gain_margin(coupled, GROWTH_LOW))

    def most_harmonics(self, lead: int) -> int:
        """The largest number of harmonics found with which none grows; 0 if none is."""
        grows = self.multiplier(lead).max(axis=0) > 1 + GROWTH
        stable, last = self._before(grows), int(self.harmonics[self.low].max())
        if stable >= last / 2:
            return stable
        if self.margin(lead, last) >= 1:
            return self._before(grows & ~self.low)
        more = range(stable + 1, last)
        return stable + bisect_left(more, True, key=lambda kept: self.margin(lead, kept) < 1)

    def coupled(self, lead: int, kept: int | None = None) -> np.ndarray:
        """β G e^{jωδΔt} of the harmonics from -L to L, the low ones, ((2L + 1) n, (2L + 1) n)."""
        poses, most = len(self.gain), int(self.harmonics[self.low].max())
        most = most if kept is None else min(kept, most)
        h = np.arange(-most, most + 1)
        spectrum = np.fft.fft(two_sided(self.gain[:, : most + 1], axis=1), axis=0) / poses
        apart = h[:, None] - h
        # What so many poses cannot tell is left out.
        seen = (2 * np.abs(apart) < poses)[..., None, None]
        turned = ahead(h, lead, self.steps)[:, None, None, None]
        blocks = np.where(seen, spectrum[apart % poses, h + most], 0) * turned
        return blocks.swapaxes(1, 2).reshape(2 * [len(h) * self.gain.shape[-1]])

    def _before(self, grows: np.ndarray) -> int:
        """The last harmonic before the first that grows, the last of all if none does."""
        return int(self.harmonics[max(int(np.argmax(grows)) - 1, 0) if grows.any() else -1])

    def _led(self, lead: int) -> np.ndarray:
        return self.eigenvalues * ahead(self.harmonics, lead, self.steps)[:, None]


def learning_loop(
    loop: SampledLoop, learning: np.ndarray, steps: int, harmonics: np.ndarray
) -> LearningLoop:
    """The loop of learning with the gain β, a matrix (n, n), over a cycle of `steps` samples."""
    gain = learning @ (loop.C[:, None] @ loop.state(on_circle(harmonics, steps)))
    return LearningLoop(steps, harmonics, gain, np.linalg.eigvals(gain))


def examined(steps: int, kept: int | None) -> np.ndarray:
    """The harmonics to examine: all low ones, some above them, the last that there is.

    Args:
        steps: samples in a cycle.
        kept: harmonics that the learned torque keeps; None for all.
    """
    last = steps // 2 if kept is None else min(kept, steps // 2)
    low = min(low_harmonics(steps), last)
    above = low * SPACING ** np.arange(1, np.ceil(np.log(last / low) / np.log(SPACING)))
    return np.unique([*range(low + 1), *above.astype(int), last])


def low_harmonics(steps: int) -> int:
    """How many of a cycle's harmonics are low."""
    return max(1, min(LOW, steps // 8))


def on_circle(harmonics: np.ndarray, steps: int) -> np.ndarray:
    """Points e^{jωΔt} of harmonics of 1/T; of harmonic 0 the limit, where σ has come to rest."""
    return np.exp(2j * np.pi * np.where(harmonics == 0, 1e-3, harmonics) / steps)


def ahead(harmonics: np.ndarray, lead: int, steps: int) -> np.ndarray:
    """e^{jωδΔt}: what reading `lead` samples ahead multiplies harmonics of 1/T by."""
    return np.exp(2j * np.pi * harmonics * lead / steps)


def two_sided(harmonics: np.ndarray, axis: int = 0) -> np.ndarray:
    """Of a real signal's harmonics from 0 to L along an axis those from -L to L."""
    negative = np.delete(np.flip(harmonics, axis), -1, axis).conj()
    return np.concatenate([negative, harmonics], axis)


def _gain_margin(mu: np.ndarray, growth: float = GROWTH) -> float:
    """The largest s with |1 - s μ| <= 1 + growth for every μ."""
    size = np.abs(mu)
    real = np.divide(mu.real, size, out=np.ones(size.shape), where=size > 0)
    most = real + np.sqrt(real**2 + (1 + growth) ** 2 - 1)
    scale = np.divide(most, size, out=np.full(size.shape, np.inf), where=size > 0)
    return float(scale.min(initial=np.inf))
