"""Contacts on curved surfaces: the normal and the curvature of a body from its equation."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch
from mafsil.errors import InputError
from mafsil.grasp.contact import Contact, single
from mafsil.grasp.tolerances import ON_OUTLINE


def level_set_curvature(gradient: ArrayLike, hessian: ArrayLike) -> Floats:
    """Curvature of the surface F = const of a body {F <= const}, positive where it bulges [1/m].

    P H P / |g|,  P = I - g g' / |g|^2

    Args:
        gradient: (d,) of F at the point, pointing out of the body.
        hessian: (d, d) of F at the point.

    Returns:
        (d, d) tensor across the normal; in the plane its only eigenvalue that is not zero is the curvature.
    """
    g = as_batch("gradient", gradient, (np.size(gradient),), finite=True)
    H = as_batch("hessian", hessian, (len(g), len(g)), finite=True)
    size = float(np.linalg.norm(g))
    if not size > 0:
        raise InputError("grasp.zero_normal", name="gradient", point=str(g.tolist()))
    P = np.eye(len(g)) - np.outer(g, g) / size**2
    return P @ (0.5 * (H + H.T)) @ P / size


def ellipsoid_contact(
    axes: ArrayLike, point: ArrayLike, mu: float = 0.0, gamma: float = 0.0,
    finger_curvature: float | ArrayLike = float("inf"), name: str = "",
) -> Contact:  # fmt: skip
    """A contact on an ellipsoid (or ellipse) about the origin, with its normal and curvature.

    Args:
        axes: (d,) half axes [m]; all equal for a sphere or circle.
        point: (d,) on the surface [m].
        mu, gamma: coefficients.
        finger_curvature: of the finger [1/m].
        name: for reports.

    Raises:
        InputError: axes not positive, or a point off the surface.
    """
    p = single("point", point, (np.size(point),))
    a = single("axes", axes, p.shape)
    if not (a > 0).all():
        raise InputError("input.positive", name="axes", value=float(a.min()))
    level = float(((p / a) ** 2).sum())
    if abs(level - 1.0) > ON_OUTLINE:
        raise InputError("grasp.off_ellipsoid", level=level)
    gradient, hessian = 2 * p / a**2, np.diag(2 / a**2)
    K = level_set_curvature(gradient, hessian)
    bend = float(np.trace(K)) if len(p) == 2 else K
    return Contact(p, -gradient, mu, gamma, curvature=bend, finger_curvature=finger_curvature, name=name)
