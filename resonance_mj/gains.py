"""Gains for a robot: those given by hand, and those found from its inertia and the time step."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from .experiment import Experiment
from .robot import Robot

BANDWIDTH = 60.0
"""Feedback bandwidth ω [1/s] at time steps that allow it."""

HARMONICS = 20
"""Harmonics of 1/T that the learned torque keeps, where the cycle has as many."""


@dataclass(frozen=True)
class Gains:
    """The law's gains as one robot has them.

    Attributes:
        jacobian: inverse, transpose or damped, in (8).
        k_v: velocity feedback (m,) [N s/m].
        k_p: position feedback (m,) [N/m].
        feedback: G of the feedback -G y (n, n) [N m s/rad].
        omega: its bandwidth ω [1/s].
        learning: what is learned from y (n, n) [N m s/rad].
        lead: control periods that learning reads y ahead.
        harmonics: harmonics that the learned torque keeps; None for all.
    """

    jacobian: str
    k_v: np.ndarray
    k_p: np.ndarray
    feedback: np.ndarray
    omega: float
    learning: np.ndarray
    lead: int
    harmonics: int | None


def gains(experiment: Experiment, robot: Robot) -> Gains:
    """The gains of an experiment on its robot, with what it leaves open filled in.

    Without K_v and K_p the feedback is -ω M̂ y with M̂ = M(q_home), so that one number serves
    every robot; without β the law learns η times the feedback torque itself.
    """
    law, n, m = experiment.law, robot.n, robot.m
    dt = experiment.simulation.timestep
    printed = law.kind == "paper"
    by_hand = law.k_v is not None or law.k_p is not None
    # A sampled first-order loop of bandwidth ω is well damped while ω dt stays far below 2.
    omega = law.omega if law.omega is not None else min(BANDWIDTH, 0.1 / dt)
    feedback = np.zeros((n, n)) if by_hand else omega * robot.inertia
    inertial = law.eta * omega * robot.inertia
    learning = inertial if law.beta is None else law.beta * np.eye(n)
    steps = min(motion.steps(dt) for motion in experiment.motion)
    harmonics = law.harmonics
    if harmonics is None and not printed:
        harmonics = min(HARMONICS, steps // 4)
    square = "inverse" if printed and m == n else "damped"
    return Gains(
        jacobian=law.jacobian or square,
        k_v=np.broadcast_to(np.asarray(law.k_v or 0.0, float), m),
        k_p=np.broadcast_to(np.asarray(law.k_p or 0.0, float), m),
        feedback=feedback,
        omega=omega,
        learning=learning,
        lead=law.lead if law.lead is not None else (0 if printed else 1),
        harmonics=harmonics,
    )
