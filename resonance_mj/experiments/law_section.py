"""The section [law] of an experiment file."""

from typing import Annotated, Literal

from pydantic import Field, field_validator

from ..text import listed, nearest
from .sections import Alone, Angles, Gain, Gains, Name, Section

KINDS = (
    "feedback",
    "learning",
    "fixed",
    "joint-space",
    "motor-torque",
    "paper",
    "transfer",
    "computed-torque",
)
"""The laws that an experiment can name, from the one that knows least to the one that knows all."""


class Law(Section):
    """The controller and its gains, by the paper's symbols."""

    kind: Name = "transfer"
    """transfer: the spring takes over what it can of the learned torque; paper: (4)-(10); feedback:
    (4) without learning; learning: all torque is learned, the springs stay as they begin; fixed:
    the same with the optimal springs; joint-space: stiffness alone adapted to desired joint angles;
    motor-torque: springs adapted to what the motors give along them (Nasiri et al., IEEE/ASME
    Transactions on Mechatronics 2016);
    computed-torque: optimal springs and the torque that the model asks for; or the path of a Python
    file with a law of your own."""
    parameters: Annotated[tuple[float, ...], Alone] = ()
    """Numbers for a law of your own."""
    jacobian: Literal["damped", "inverse", "transpose"] | None = None
    """In (8): J^-1, J^T, or the damped pseudo-inverse with the posture in its null space."""
    velocity: Literal["jacobian", "difference"] | None = None
    """The tool's velocity in (4) and (8): jacobian: J q̇, or difference: of its positions over the
    last time step, which is what Euler and implicitfast mean by it; jacobian for laws as printed
    and under RK4 and difference else if not given."""
    k_v: Gains | None = None
    """Velocity feedback K_v [N s/m], one for all coordinates or one each; if neither k_v nor k_p is
    given, it is -(omega M + D) y with the inertia M in the middle of the motion and the joints'
    damping D."""
    k_p: Gains | None = None
    """Position feedback K_p [N/m], one for all coordinates or one each."""
    omega: Gain | None = None
    """Bandwidth of the inertial feedback [1/s]; 100 (the laws as printed: 60), or more on an arm
    that falls or swings fast, and at most 0.3 (0.1) of 1/timestep, if not given."""
    alpha: Gain | None = None
    """Weight of the position error in (8) [1/s]; 10, or the rate at which the arm falls or swings
    about its home if that is higher, if not given."""
    alpha_0: Gain | None = None
    """Weight of the posture's error in the null space [1/s]; as alpha if not given."""
    beta: Gain | None = None
    """Learning gain of (9) [N m s/rad]; if not given, eta times the feedback's own torque."""
    eta: Gain | None = None
    """Share of the feedback's torque that is learned in a cycle, where beta is not given; 0.5 for
    the law as printed and 0.8 else if not given."""
    gamma_k: Gains = 0.0
    """Adaptation gain of the stiffness, (6) [N m/rad^3], one for all joints or one each; for the
    printed laws 200 times the joints' inertia at home if neither gain is given; of motor-torque, 10
    if neither is given [1/(rad^2 s)]."""
    gamma_qe: Gains = 0.0
    """Adaptation gain of the offset torque, (7) [N m/rad], one for all joints or one each; for the
    printed law 500 times the joints' inertia at home if neither gain is given; of motor-torque, 1
    if neither is given [1/s]."""
    q_c: Literal["mean", "running"] | Angles = "mean"
    """Centre of the spring's regressor [rad]; "mean" is the mean angle of the first motion;
    "running", for the paper's law, the mean of each cycle as it ends, and home before."""
    q_s: Literal["mean", "running"] | Angles = "mean"
    """Centre of the learning's regressor (9), (10) [rad]; "mean" as for q_c; "running", for the
    paper's laws, the mean of the cycle that is learned from."""
    lead: Annotated[int, Field(ge=0, le=100_000)] | None = None
    """How far ahead in the stored cycle learning reads y [control periods]; 0 for the law as
    printed and 1 else if not given."""
    harmonics: Annotated[int, Field(ge=1, le=50_000)] | None = None
    """Harmonics of 1/T that the learned torque keeps; all for the law as printed and 20 else if not
    given."""

    overestimate: Annotated[float, Field(ge=-1, le=10, allow_inf_nan=False)] = 0.0
    """Share by which the model of computed-torque asks for more torque than the arm needs."""
    listens: bool | None = None
    """Whether the transfer law looks for noise and delay in its loop and for the weight of its arm,
    and tunes itself to them; where it is given no gain by hand, if not given."""
    doubts: bool | None = None
    """Whether the transfer law doubts that springs are linear, and finds what they exert from its
    own cycles; where a key of reality.spring_* is set, if not given."""

    @field_validator("kind")
    @classmethod
    def _known_or_a_file(cls, value: str) -> str:
        if value in KINDS or value.endswith(".py"):
            return value
        raise ValueError(
            f"valid are {listed(KINDS)}, or the path of a Python file, NAME.py"
            + nearest(value, KINDS)
        )

    @property
    def printed(self) -> bool:
        """Whether the law is one of the authors', with (9), (10) and without lead if not given."""
        return self.kind in ("paper", "joint-space")

    @property
    def learned_share(self) -> float:
        """`eta`, or what it is if not given."""
        return self.eta if self.eta is not None else 0.5 if self.printed else 0.8

    @property
    def follows_joints(self) -> bool:
        """Whether the law is told the desired joint angles, and its gains act on theirs."""
        return self.kind in ("joint-space", "motor-torque", "computed-torque")
