"""The share of a way that is smooth at both of its ends."""

import numpy as np


def minimum_jerk(r: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """σ = 10 r³ - 15 r⁴ + 6 r⁵, from 0 at r = 0 to 1 at r = 1, and its derivatives by r.

    Both derivatives are zero at both ends.
    """
    return (
        r**3 * (10 - 15 * r + 6 * r**2),
        30 * r**2 * (1 - r) ** 2,
        60 * r * (1 - r) * (1 - 2 * r),
    )
