"""What the last cycles say of the loop: its noise, its delay, and how heavy the arm really is.

Between cycles the total torque changes by Δτ(t) and the error signal by Δy(t). About the motion
the arm is M s y = Δτ - G F y e^(-sD) with G = g ω M̂ the feedback that acts, F its filter and D the
delay of the loop, so that what would be learned of Δy, L Δy = g η ω M̂ Δy, is h Δτ with

    h(jω_k) = g r η ω e^(-jω_k D) / (jω_k + g r ω F e^(-jω_k D)),    r = M̂ / M,

at the harmonics ω_k of the cycle: D and r are those that fit best. Learning with a lead δ leaves
the factor |1 - h e^(jω_k δ)| of the k-th harmonic of the error in each cycle. Noise of the encoders
is what y has in its highest octave, where an arm does not move.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from .tuning import FILTER, HEAVY, Tuning

if TYPE_CHECKING:
    from .gains import Gains
    from .learning import Cycle

NOISY = 0.03
"""Noise in the feedback's torque², of the torque² of the cycle's harmonics, from which on it is
reduced."""

CALM, CALM_AT_FIRST = 0.01, 0.04
"""To what, and as long as a motion grows; it may be half or twice that before it is looked for
anew."""

CONTRACTS = 0.98
"""Factor of what is to be learned from a cycle to the next up to which the loop is let be."""

KEPT = 0.8
"""What is kept, in a cycle, of what is known of the loop from those before."""

GROWS = 1.5
"""Factor of a change from a pair to the next from which on that pair alone tells of the loop."""

ENOUGH = 3
"""Pairs of cycles that tell enough of it; one less where the torque changes more and more."""

MOVED = 1e-2
"""Change of the torque from a cycle to the next, of the torque, that tells something."""

SLOWEST = 2.0
"""Least bandwidth of the feedback, over the weight α of the position error."""

DELAYED, AT_FIRST = 0.3, 0.6
"""Most that the bandwidth of the feedback is of 1 / D, and as a motion begins."""

FITS = 0.3
"""Part of the loop's response that a delay and r may leave over where they explain it."""

CALMER = 0.5
"""Of the pace of learning, what is tried next where they do not."""

FASTER, SOONER = (2.0, 4.0, 8.0), 0.9
"""By how much learning that was calmed goes faster again, and to which share of what is left of the
error after a cycle, by what was measured of the loop, it shall fall by that."""

SAMPLED = 0.5
"""Most that its bandwidth then is of 1/dt."""

STALLS, STALLED = 6, 0.7
"""Cycles after which what is to be learned shall have fallen to this."""

GROWN = 2.0
"""How many times its least what is to be learned is where learning diverges, whatever is found."""

STEPS = 128
"""Time steps of delay that are looked for."""

SHARES = 2.0 ** (-np.arange(0, 24) / 4)
"""Shares of the feedback that are tried."""

RATIOS = 2.0 ** (np.arange(-12, 5) / 4)
"""Values of r that are tried."""


def tuned(
    tuning: Tuning,
    cycle: Cycle,
    gains: Gains,
    *,
    limited: bool = False,
    passing: bool = False,
) -> Tuning:
    """What the law does from the next cycle on, from what a whole cycle has shown.

    Args:
        tuning: as the cycle was made with.
        cycle: that was made.
        gains: of the law.
        limited: whether a motor was at its limit, where it answers to nothing.
        passing: whether the motion still grew, so that there was more to learn in each cycle.
    """
    total = cycle.u + cycle.spring_torque(np.roll(cycle.q, -tuning.delay, axis=0))
    noise = _noise(cycle.y[:: cycle.hold], gains.feedback)
    found = tuning._replace(before=None)
    if not limited:
        found = _delayed(total, tuning, cycle, gains, passing)
    # As long as a motion grows, feedback carries it, and more of its noise is borne.
    calm = CALM_AT_FIRST if passing else CALM
    quiet, filtered = _quiet(min(noise, tuning.noise), tuning, cycle, gains, calm)
    slowest = min(1.0, SLOWEST * gains.alpha / gains.omega)
    most = _most(found, gains, cycle.timestep)
    share = max(min(quiet, most) if filtered else most, slowest)
    now = share, filtered, found.delay, found.ratio, found.pace
    if now == (tuning.share, tuning.filtered, tuning.delay, tuning.ratio, tuning.pace):
        return found._replace(noise=noise, before=(total, cycle.y.copy()))
    # With other gains the loop is another: its next cycle is compared with none before.
    found = _anew(found._replace(share=share, filtered=filtered, noise=noise))
    return found._replace(lead=_lead(found, cycle, gains))


def begun(tuning: Tuning, gains: Gains, timestep: float) -> Tuning:
    """As a motion begins: all the feedback that the delay allows, until learning carries it.

    Args:
        tuning: of the motion before.
        gains: of the law.
        timestep: [s].
    """
    return _anew(tuning._replace(share=_most(tuning, gains, timestep, AT_FIRST), pace=1.0))


def _anew(tuning: Tuning) -> Tuning:
    return tuning._replace(known=None, cycles=0, least=np.inf, last=(), change=np.inf, before=None)


def _most(tuning: Tuning, gains: Gains, timestep: float, delayed: float = DELAYED) -> float:
    """Share of the feedback that the loop's delay allows and the arm's true weight asks for."""
    most = 1.0
    if tuning.ratio < HEAVY:
        most = max(1.0, min(1 / tuning.ratio, SAMPLED / (timestep * gains.omega)))
    if tuning.delay:
        on_time = delayed / (tuning.delay * timestep * gains.omega)
        most = min(most, max(on_time, SLOWEST * gains.alpha / gains.omega))
    return float(most)


def _noise(y: np.ndarray, feedback: np.ndarray) -> float:
    """Torque² that noise of y (N, n) at control steps makes, unfiltered, of the feedback G y."""
    spectrum = np.fft.rfft(y, axis=0)
    top = spectrum[len(y) // 4 :] @ feedback.T
    # Differences of white noise have 0.82 of their variance in the highest octave.
    return float(2 * (np.abs(top) ** 2).sum() / len(y) ** 2 / (0.5 + 1 / np.pi))


def _quiet(
    noise: float, tuning: Tuning, cycle: Cycle, gains: Gains, calm: float
) -> tuple[float, bool]:
    """The largest share of the feedback whose noise is small beside the torque; whether filtered.

    Args:
        noise: as `_noise` has it.
        tuning: as the cycle was made with.
        cycle: that was made.
        gains: of the law.
        calm: most that noise may be of the torque².
    """
    useful = float((_smooth(cycle.tau, gains) ** 2).sum(axis=1).mean())
    if noise <= NOISY * useful and not tuning.filtered:
        return 1.0, False
    if not useful:
        return tuning.share, tuning.filtered
    angle = np.linspace(0.0, np.pi, 513)[1:]

    def heard(share: float) -> float:
        """Noise in the torque² of a filtered share, of what is useful."""
        filtered = Tuning(share=share, filtered=True)
        a = filtered.coefficient(gains.omega, cycle.hold * cycle.timestep)
        passed = np.abs(a / (1 - (1 - a) * np.exp(-1j * angle))) ** 4
        return share**2 * noise * float((passed * (1 - np.cos(angle))).mean()) / useful

    if tuning.filtered and calm / 2 <= heard(tuning.share) <= 2 * calm:
        return tuning.share, True
    quiet = [float(share) for share in SHARES if heard(share) <= calm]
    return (quiet[0] if quiet else float(SHARES[-1])), True


def _delayed(
    total: np.ndarray, tuning: Tuning, cycle: Cycle, gains: Gains, passing: bool
) -> Tuning:
    """With what the cycle adds to what is known, and where learning grows, delay and r from it."""
    if tuning.before is None or gains.harmonics is None:
        return tuning
    before, y_before = tuning.before
    learned = float((_smooth(cycle.y @ gains.learning.T, gains) ** 2).sum(axis=1).mean())
    last = (*tuning.last, learned)[-STALLS:]
    tuning = tuning._replace(least=min(tuning.least, learned), last=last)
    changed, moved = total - before, cycle.y - y_before
    harmonics = slice(1, gains.harmonics + 1)
    tau = np.fft.rfft(changed, axis=0)[harmonics]
    answer = tuning.pace * tuning.share * np.fft.rfft(moved, axis=0)[harmonics] @ gains.learning.T
    weights, cross = (np.abs(tau) ** 2).sum(axis=1), (tau.conj() * answer).sum(axis=1)
    change = float((changed**2).sum())
    if (known := tuning.known) is not None and not change > GROWS**2 * tuning.change:
        weights, cross = weights + KEPT * known[0], cross + KEPT * known[1]
    enough = ENOUGH - (change > GROWS**2 * tuning.change)
    found = tuning._replace(known=(weights, cross), cycles=tuning.cycles + 1, change=change)
    if found.cycles < enough or change <= MOVED**2 * (total**2).sum():
        return found
    measured = cross / np.maximum(weights, np.finfo(float).tiny)
    lead = gains.lead if tuning.lead is None else tuning.lead
    left = np.abs(1 - measured * np.exp(1j * _rates(cycle, gains) * lead * cycle.timestep)) ** 2
    stalls = len(last) == STALLS and sum(last[-2:]) > STALLED * sum(last[:2])
    grown = learned > GROWN**2 * tuning.least and not passing
    grows = left @ weights > CONTRACTS**2 * weights.sum() or grown
    # In a late loop what contracts by its mean may grow in a harmonic that hardly moves yet.
    if not grows and tuning.pace < 1.0 and not tuning.delay:
        factors = np.minimum(FASTER, 1.0 / tuning.pace)
        ahead = np.exp(1j * _rates(cycle, gains) * lead * cycle.timestep)
        then = np.abs(1 - factors[:, None] * measured * ahead) ** 2 @ weights
        if then.min() < SOONER * (left @ weights):
            return found._replace(pace=float(factors[then.argmin()]) * tuning.pace)
    if not (grows or (stalls and not tuning.filtered and not passing)):
        return found
    delays = np.arange(1, min(STEPS, len(cycle.y) // 8))
    miss = np.abs(_loop(delays, RATIOS, tuning, cycle, gains) - measured) ** 2 @ weights
    at, ratio = np.unravel_index(int(miss.argmin()), miss.shape)
    delay, r = int(delays[at]) - 1, float(RATIOS[ratio])
    if miss[at, ratio] <= FITS * (np.abs(measured) ** 2 @ weights):
        # A feedback that is too weak for its arm answers late as well.
        if r < HEAVY and r < tuning.ratio:
            return found._replace(ratio=r)
        if r >= HEAVY and delay != tuning.delay:
            # Noise is correlated with what was learned of it, and hides some of the delay.
            pace = (CALMER if tuning.filtered else 1.0) * tuning.pace
            return found._replace(delay=delay, ratio=r, pace=pace)
    return found._replace(pace=CALMER * tuning.pace) if grows and not passing else found


def _lead(tuning: Tuning, cycle: Cycle, gains: Gains) -> int | None:
    """Time steps of lead with which learning contracts fastest in its slowest harmonic."""
    if gains.harmonics is None:
        return tuning.lead
    leads = np.arange(min(STEPS, len(cycle.y) // 4))
    ahead = np.exp(1j * np.outer(leads, _rates(cycle, gains)) * cycle.timestep)
    delay, ratio = np.array([tuning.delay + 1]), np.array([tuning.ratio])
    h = _loop(delay, ratio, tuning, cycle, gains)[0, 0]
    return int(np.abs(1 - h * ahead).max(axis=1).argmin())


def _loop(
    delays: np.ndarray, ratios: np.ndarray, tuning: Tuning, cycle: Cycle, gains: Gains
) -> np.ndarray:
    """Response h (delays, ratios, harmonics) of what is learned to the torque; see above."""
    rates = _rates(cycle, gains)
    late = np.exp(-1j * np.multiply.outer(delays * cycle.timestep, rates))[:, None, :]
    acting = tuning.share * ratios[:, None] * gains.omega
    cutoff = FILTER * tuning.share * gains.omega if tuning.filtered else np.inf
    passed = 1 / (1 + 1j * rates / cutoff) ** 2
    learned = gains.learning.trace() / gains.feedback.trace() if gains.feedback.any() else 1.0
    return tuning.pace * acting * learned * late / (1j * rates + acting * passed * late)


def _rates(cycle: Cycle, gains: Gains) -> np.ndarray:
    """The harmonics that are learned [rad/s]."""
    assert gains.harmonics is not None
    return 2 * np.pi * np.arange(1, gains.harmonics + 1) / (len(cycle.y) * cycle.timestep)


def _smooth(torque: np.ndarray, gains: Gains) -> np.ndarray:
    """A torque over a cycle (N, n) with the harmonics that are learned alone."""
    spectrum = np.fft.rfft(torque, axis=0)
    spectrum[(gains.harmonics or len(spectrum)) + 1 :] = 0.0
    return np.fft.irfft(spectrum, n=len(torque), axis=0)
