"""Divergence predicted and measured: the tables and the figure of docs/stability.md.

    python benchmarks/stability.py [--cycles N] [--arms N] [--eta SHARE] [--out FOLDER]

Each motion of `paper-centered` alone, as in docs/reproduction.md, and the arms of random_arms.py
with the default law, but another η, all harmonics kept and no lead.
Predictions are those of `resonance-mj run`; measured is what the runs do. The figure is written as
stability.png.
"""

from __future__ import annotations

import argparse
import sys
import tempfile
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from random_arms import arms as random_arms
from readings import Changes, alone

import resonance_mj as rmj
from resonance_mj.laws.stability import sampled_loop
from resonance_mj.laws.stability.divergence import POSES, Divergence, divergences
from resonance_mj.laws.stability.stability import learning_loop
from resonance_mj.pictures.figures.style import styled
from resonance_mj.pictures.palette import MUTED
from resonance_mj.plan.plan import plan_for

BETAS = (1.0, 3.0, 10.0)
LEADS = (0, 1, 2)
KEPT = (None, 20)
LATER = 2.0
"""How far beyond the predicted divergence a motion is simulated."""

OF_LEADS = ("#0072B2", "#D55E00", "#009E73")
OF_BETAS = ("#56B4E9", "#E69F00", "#CC79A7")
"""Of Okabe and Ito's palette."""


@dataclass
class Case:
    """One motion with one law, what is predicted for it and what came out."""

    motion: int
    beta: float
    lead: int
    kept: int | None
    why: Divergence | None
    experiment: rmj.Experiment
    run: rmj.Run | None = None

    @property
    def ratio(self) -> np.ndarray:
        """Torque² of each cycle as a multiple of that without springs."""
        (best,) = self.run.plan.optima
        return self.run.data["torque_squared"].values / best.torque_squared_without_springs

    @property
    def worse(self) -> int | None:
        """The first cycle, counted from 1, from which torque² stays above that without springs."""
        better = np.flatnonzero(self.ratio <= 1)
        cycle = int(better[-1]) + 2 if len(better) else 1
        return cycle if cycle <= len(self.ratio) else None

    @property
    def learned(self) -> np.ndarray:
        """U of each recorded cycle at the harmonic predicted to grow fastest (cycles, joints)."""
        data = self.run.data
        steps = round(self.experiment.motion[0].period / self.experiment.simulation.timestep)
        u = data["u"].values.reshape(-1, steps, data.sizes["joint"])
        return np.fft.rfft(u, axis=1)[:, self.why.onset.fastest] / steps

    @property
    def growth(self) -> float:
        """Growth per cycle of its change from cycle to cycle, in the last third up to `worse`."""
        change = np.linalg.norm(np.diff(self.learned[: self.worse], axis=0), axis=-1)
        last = np.log(change[2 * len(change) // 3 :])
        return float(np.exp(np.polyfit(np.arange(len(last)), last, 1)[0]) - 1)


def predicted(experiment: rmj.Experiment) -> Divergence | None:
    """How the first motion of an experiment is said to diverge."""
    one = plan_for(experiment)
    found = divergences(one.experiment, one.loaded, one.gains, one.joints, one.optima, one.q_c)
    return found[0]


def enough(why: Divergence | None, cycles: int) -> int:
    """As many cycles as it takes to see it, at most `cycles`."""
    return cycles if why is None else int(min(cycles, LATER * why.onset.cycle + 20))


def case(motion: int, changes: Changes, cycles: int) -> Case:
    """A case with its prediction."""
    law = rmj.load("paper-centered").replace(changes).law
    why = predicted(alone(motion, cycles, changes))
    experiment = alone(motion, enough(why, cycles), changes)
    return Case(motion, law.beta, law.lead, law.harmonics, why, experiment)


def arms(count: int, eta: float, cycles: int) -> list[Case]:
    """Random arms without a lead."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for _, experiment in random_arms(count, 0, Path(folder)):
            given = experiment.replace(
                {"law.omega": 60.0, "law.eta": eta, "law.lead": 0, "law.harmonics": 500}
            )
            why = predicted(given)
            motion = {"motion.0.duration": float(enough(why, cycles)), "simulation.samples": 1}
            found.append(Case(0, 0.0, 0, None, why, given.replace(motion)))
        simulate(found)
    return found


def in_all(of: Sequence[Case]) -> Iterator[Sequence[str]]:
    """How near the cycles of arms come to those predicted."""
    yield ("arms", "said to diverge", "did", "measured / predicted: median", "middle half", "all")
    said = [one for one in of if one.why and one.why.onset.cycle < one.experiment.motion[0].cycles]
    ratios = [one.worse / one.why.onset.cycle for one in said if one.worse]
    least, low, middle, high, most = np.quantile(ratios, (0, 0.25, 0.5, 0.75, 1))
    yield (
        *(str(len(each)) for each in (of, said, ratios)),
        f"{middle:.2f}",
        f"{low:.2f} to {high:.2f}",
        f"{least:.2f} to {most:.2f}",
    )


def laws(cycles: int) -> list[Case]:
    """Each motion with each β, lead and number of harmonics."""
    return [
        case(motion, {"law.beta": beta, "law.lead": lead, "law.harmonics": kept}, cycles)
        for beta, lead, kept, motion in product(BETAS, LEADS, KEPT, (0, 1))
    ]


def limits(cycles: int) -> list[Case]:
    """The largest β and number of harmonics that are said not to diverge, and more than those."""
    found = []
    for motion in (0, 1):
        filtered = {"law.lead": 1, "law.harmonics": 20}
        too_high = 20.0
        margin = case(motion, filtered | {"law.beta": too_high}, 2).why.margin
        for share in (0.97, 1.1, 1.2):
            beta = round(share * margin * too_high, 2)
            found.append(case(motion, filtered | {"law.beta": beta}, cycles))
        most = case(motion, {"law.beta": 10.0}, 2).why.harmonics
        for kept in (most, 2 * most, 3 * most):
            found.append(case(motion, {"law.beta": 10.0, "law.harmonics": kept}, cycles))
    return found


def simulate(todo: Sequence[Case]) -> None:
    """Run all cases, with their progress on stderr."""

    def show(done: int, of: int) -> None:
        print(f"\r{done} of {of} rounds of cycles simulated", end="", file=sys.stderr, flush=True)

    shown = show if sys.stderr.isatty() else None
    runs = rmj.simulate_many([case.experiment for case in todo], progress=shown)
    for case, run in zip(todo, runs, strict=True):
        case.run = run


def table(of: Sequence[Case]) -> Iterator[Sequence[str]]:
    """Predicted beside measured."""
    yield (
        "motion",
        "β",
        "lead",
        "harmonics",
        "growing",
        "fastest [Hz]",
        "growth [%]",
        "measured",
        "worse from",
        "measured",
    )
    for one in of:
        law = (str(one.motion + 1), f"{one.beta:g}", str(one.lead), str(one.kept or "all"))
        measured = str(one.worse or f"not in {len(one.ratio)}")
        if one.why is None:
            yield (*law, "none", "", "", "", "never", measured)
            continue
        grows = one.why.onset
        yield (
            *law,
            f"from {grows.first}",
            f"{grows.fastest / one.experiment.motion[0].period:g}",
            f"{100 * grows.growth:.2f}",
            f"{100 * one.growth:.2f}",
            f"{grows.cycle:.0f}",
            measured,
        )


def figure(of: Sequence[Case]) -> Figure:
    """|1 - μ| over frequency, and the harmonic that grows fastest over the cycles."""
    with styled():
        fig = Figure(figsize=(9.2, 3.6), layout="constrained")
        over_frequency, over_cycles = fig.subplots(1, 2)
        _multipliers(over_frequency, motion=0, beta=10.0)
        _amplitudes(over_cycles, [one for one in of if one.lead == 0 and one.kept is None])
        return fig


def _multipliers(axes: Axes, motion: int, beta: float) -> None:
    one = plan_for(alone(motion, 2, {"law.beta": beta}))
    (joints,), (best,) = one.joints, one.optima
    steps = len(joints.q)
    arm = sampled_loop.along(
        one.experiment,
        one.kinematics,
        one.gains,
        joints.q[np.arange(POSES) * steps // POSES],
        stiffness=best.stiffness,
        q_c=one.q_c,
    )
    harmonics = np.arange(1, steps // 2 + 1)
    loop = learning_loop(arm, one.gains.learning, steps, harmonics)
    hertz = harmonics / one.experiment.motion[0].period
    axes.axhline(1, color=MUTED, linewidth=0.8)
    for lead, colour in zip(LEADS, OF_LEADS, strict=True):
        factor = loop.multiplier(lead)
        axes.fill_between(
            hertz, factor.min(axis=0), factor.max(axis=0), color=colour, alpha=0.15, linewidth=0
        )
        axes.semilogx(hertz, factor[0], color=colour, label=f"lead {lead}")
    axes.set(
        xlim=(1, hertz[-1]),
        xlabel="frequency [Hz]",
        ylabel="largest |1 - μ|",
        title=f"Factor per cycle, motion {motion + 1}, β = {beta:g}",
    )
    axes.text(1.15, 1.01, "above 1 a harmonic grows", color=MUTED, va="bottom")
    axes.legend(loc="lower right")


def _amplitudes(axes: Axes, of: Sequence[Case]) -> None:
    for one in of:
        colour = OF_BETAS[BETAS.index(one.beta)]
        amplitude, worse = np.linalg.norm(one.learned, axis=-1), one.worse
        cycle = np.arange(1, len(amplitude) + 1)
        predicted = amplitude[worse - 1] * (1 + one.why.onset.growth) ** (cycle - worse)
        axes.loglog(cycle[1:], amplitude[1:], "-" if one.motion else "--", color=colour)
        late = cycle >= worse / 3
        axes.plot(cycle[late], predicted[late], ":", color="black", linewidth=1.6)
    for beta, colour in zip(BETAS, OF_BETAS, strict=True):
        axes.plot([], [], color=colour, label=f"β = {beta:g}")
    axes.plot([], [], color=MUTED, linestyle="--", label="motion 1")
    axes.plot([], [], color=MUTED, label="motion 2")
    axes.plot([], [], ":", color="black", label="growth as predicted")
    axes.set(
        xlabel="cycle",
        ylabel="|U| at 500 Hz [N m]",
        ylim=(8e-4, 30),
        title="In the runs, as printed (lead 0)",
    )
    axes.legend(loc="upper left", ncols=2)


def main() -> None:
    """Print the tables and write the figure."""
    parser = argparse.ArgumentParser(description="Tables and figure of docs/stability.md.")
    parser.add_argument("--cycles", type=int, default=400, help="most cycles of a run")
    parser.add_argument("--arms", type=int, default=40, help="how many random arms")
    parser.add_argument("--eta", type=float, default=1.0, help="what they learn in a cycle")
    parser.add_argument("--out", type=Path, default=Path("docs"), help="folder of stability.png")
    options = parser.parse_args()
    if options.cycles < 2:
        parser.error(f"--cycles {options.cycles}: at least 2 are needed")
    if not options.out.is_dir():
        parser.error(f"--out {options.out}: is not a folder")
    at, beyond = laws(options.cycles), limits(options.cycles)
    simulate([*at, *beyond])
    tables = {"laws": table(at), "limits": table(beyond)}
    if options.arms:
        tables["random arms"] = in_all(arms(options.arms, options.eta, options.cycles))
    for title, rows in tables.items():
        print(f"{title}\n")
        for index, row in enumerate(rows):
            print(f"| {' | '.join(row)} |")
            if index == 0:
                print("|" + "---|" * len(row))
        print()
    path = options.out / "stability.png"
    figure(at).savefig(path, dpi=130)
    print(f"\n{path}", file=sys.stderr)


if __name__ == "__main__":
    main()
