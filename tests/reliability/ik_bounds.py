"""How far a planted configuration may be from the one found.

Both reach the pose but for delta: the residual that forward kinematics shows, and the rounding of the pose, some units
of 2^-52. Where the Jacobian (lengths in units of the arm) has the least singular value s, that is a distance of
delta / s at most, to first order. Where s is small two solutions merge, and near there the distance is that of the
roots of x^2 = delta: sqrt(delta) times a factor of the curvature. The bound is the smaller of both, with 2^-52 x 256
for the rounding and 64 for the second factor. Where shoulder and elbow merge at once four solutions are one, and the
distance is that of the roots of x^4 = delta.
"""

from __future__ import annotations

import numpy as np

DELTA = 256 * 2.0**-52
RESIDUAL = 1e-9
TURN = 2 * np.pi


def bound(J: np.ndarray, n: int, residual: np.ndarray, merged: bool = False) -> np.ndarray:
    """(k,) how far a solution with a residual may be from the planted one; see above."""
    least = np.linalg.svd(J, compute_uv=False)[..., min(6, n) - 1]
    delta = DELTA + residual
    folded = np.maximum(64 * np.sqrt(delta), merged * delta**0.25)
    return np.minimum(delta / np.maximum(least, 1e-300), folded)


def apart(q: np.ndarray, other: np.ndarray, slides: tuple[bool, ...]) -> np.ndarray:
    """(...) largest difference of coordinates, angles up to whole turns."""
    d = q - other
    return np.abs(np.where(np.array(slides), d, (d + np.pi) % TURN - np.pi)).max(axis=-1)
