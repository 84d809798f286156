"""Curves as tubes: the vertices and faces of the skins that the overlays of a picture are."""

import numpy as np

SIDES = 8
"""Corners of a tube's cross-section."""

_AROUND = 2 * np.pi * np.arange(SIDES)[:, None] / SIDES


def faces(rings: int) -> np.ndarray:
    """Triangles (·, 3) between the vertices of a tube of so many rings."""
    a = np.arange((rings - 1) * SIDES)
    b = a - a % SIDES + (a + 1) % SIDES
    corners = (a, b, b + SIDES), (a, b + SIDES, a + SIDES)
    return np.concatenate([np.stack(three, axis=1) for three in corners])


def tube(points: np.ndarray, radius: np.ndarray, normal: np.ndarray | None = None) -> np.ndarray:
    """Vertices (M · SIDES, 3) of a tube around a curve.

    Args:
        points: of the curve (M, 3) [m].
        radius: of the tube at each (M,) [m]; 0 leaves the curve out there.
        normal: a direction that the curve nowhere runs along (3,); that in which it is flattest.
    """
    if normal is None:
        normal = np.linalg.svd(points - points.mean(axis=0), full_matrices=False)[2][-1]
    along = np.gradient(points, axis=0)
    u = _unit(np.cross(along, normal))
    v = _unit(np.cross(along, u))
    ring = np.cos(_AROUND) * u[:, None, :] + np.sin(_AROUND) * v[:, None, :]
    return (points[:, None, :] + radius[:, None, None] * ring).reshape(-1, 3)


def rounded(radius: float, rings: int) -> np.ndarray:
    """Radius (rings,) of a tube that is closed at both ends."""
    profile = np.full(rings, radius)
    profile[0] = profile[-1] = 0.0
    return profile


def dashed(radius: float, rings: int, dash: int = 4) -> np.ndarray:
    """Radius (rings,) of a tube that is there and not there in turn."""
    return np.where(np.arange(rings) // dash % 2 == 0, radius, 0.0)


def arrow(radius: float, rings: int, head: int) -> np.ndarray:
    """Radius (rings,) of a tube that ends in an arrow's head of so many rings."""
    profile = rounded(radius, rings)
    profile[-head:] = np.linspace(2.8 * radius, 0.0, head)
    return profile


def turned(vector: np.ndarray, axis: np.ndarray, angle: np.ndarray) -> np.ndarray:
    """A vector perpendicular to a unit axis, turned about it by each angle (·, 3)."""
    angle = np.asarray(angle)[..., None]
    return np.cos(angle) * vector + np.sin(angle) * np.cross(axis, vector)


def perpendicular(axis: np.ndarray) -> np.ndarray:
    """Some unit vector perpendicular to a unit axis."""
    return _unit(np.cross(axis, np.eye(3)[int(np.argmin(np.abs(axis)))]))


def _unit(vectors: np.ndarray) -> np.ndarray:
    return vectors / np.maximum(np.linalg.norm(vectors, axis=-1, keepdims=True), 1e-12)
