"""Three rotations about general axes n1, n2, n3: which rotations they reach, and how they name them.

R = Rot(n1, a) Rot(n2, b) Rot(n3, c). The middle turn carries n3 on a cone about n2, the outer ones do not change the
angle between n1 and R n3: what is reached follows from n1 . R n3 alone.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Scalar, Truth, as_batch
from mafsil.errors import InputError
from mafsil.geometry import rotation
from mafsil.geometry.tolerances import ROUNDOFF, SPECIAL


def reached_cosines(axes: ArrayLike) -> tuple[Scalar, Scalar]:
    """Lowest and highest n1 . R n3 that three turns reach: cos(d12 + d23) and cos(d12 - d23).

    Args:
        axes: (*batch, 3, 3) n1, n2, n3 as rows, any lengths but zero; d12, d23 the angles between neighbours.

    Returns:
        low (*batch), high (*batch): R is reached exactly where n1 . R n3 lies between.
    """
    n = _directions(axes)
    d12, d23 = (_angle(n[..., k, :], n[..., k + 1, :]) for k in (0, 1))
    return np.cos(d12 + d23), np.cos(d12 - d23)


def reaches(R: ArrayLike, axes: ArrayLike) -> Truth:
    """(*batch) whether three turns about the axes make the rotation R (*batch, 3, 3)."""
    n = _directions(axes)
    low, high = reached_cosines(axes)
    turned = rotation.apply(R, n[..., 2, :])
    cosine = np.sum(n[..., 0, :] * turned, axis=-1)
    return (cosine >= low - ROUNDOFF) & (cosine <= high + ROUNDOFF)


def reaches_everything(axes: ArrayLike, tolerance: float = SPECIAL) -> Truth:
    """(*batch) whether every rotation is reached: the middle axis is orthogonal to both others.

    Args:
        axes: (*batch, 3, 3) as rows.
        tolerance: of the cosines between neighbours.
    """
    n = _directions(axes)
    return np.abs(np.einsum("...ki,...i->...k", n[..., ::2, :], n[..., 1, :])).max(-1) <= tolerance


def middle_zero(axes: ArrayLike) -> Scalar:
    """(*batch) lambda [rad], the middle angle at which n1 and n3 fall together: cos = n1 . n3, sin = n2 . (n1 x n3).

    The angles of a triple are those of its proper (ZYZ-like) set with the middle angle moved by lambda; the
    middle angle of the principal triple lies in [-lambda, pi - lambda].

    Args:
        axes: (*batch, 3, 3) as rows, the second orthogonal to the others.
    """
    n = _directions(axes)
    first, second, third = (n[..., k, :] for k in range(3))
    sine = np.sum(second * np.cross(first, third), axis=-1)
    return np.arctan2(sine, np.sum(first * third, axis=-1))


def _directions(axes: ArrayLike) -> Floats:
    n = as_batch("axes", axes, (3, 3))
    length = np.linalg.norm(n, axis=-1, keepdims=True)
    if np.any(length == 0.0):
        row = n[tuple(np.argwhere(length[..., 0] == 0.0)[0])]
        raise InputError("geometry.axis", name="axes", value=row.tolist())
    return n / length


def _angle(a: Floats, b: Floats) -> Any:
    """(*batch) angle between unit vectors, accurate near 0 and pi."""
    return 2 * np.arctan2(np.linalg.norm(a - b, axis=-1), np.linalg.norm(a + b, axis=-1))
