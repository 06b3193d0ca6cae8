"""Directions in which solutions of one pose may go on: where the first order leaves several, the second decides.

Along q + t u + t^2 w / 2 + ... the pose stays to second order if J u = 0 and y' (dJ/dt u) = 0 for every y with
y' J = 0, dJ/dt at rates u: quadratic forms on the null space of the Jacobian. Where two continua cross, each has its
own direction there; where the forms have no common zero, the solution is isolated though its Jacobian is singular.

Reference: Lerbet, Analytic geometry and singularities of mechanisms, 1998 (the tangent cone).
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.ik.answers.setting import Setting
from mafsil.ik.tolerances import DIRECTION, TANGENT

STARTS = 64
"""Directions from which common zeros of the forms are sought."""

STEPS = 30
"""Newton steps from each."""


def tangents(setting: Setting, q: JointVector, null: Floats, left: Floats) -> Floats | None:
    """(k, n) unit directions that leave the pose as it is to second order; None where all of the null space do.

    Args:
        setting: the arm.
        q: (n,) a solution.
        null: (m, n) orthonormal rows, the null space of its Jacobian.
        left: (6, l) orthonormal columns y with y' J = 0.
    """
    if len(null) < 2:
        return None
    rates = np.array([setting.scaled_jacobian_rate(q, direction) for direction in null])
    forms = left.T @ rates @ null.T
    forms = (forms + forms.transpose(2, 1, 0)) / 2
    if np.abs(forms).max(initial=0.0) <= DIRECTION:
        return None
    u = np.random.default_rng(0).normal(size=(STARTS, len(null)))
    for _ in range(STEPS):
        u /= np.linalg.norm(u, axis=1, keepdims=True)
        pulled = np.einsum("alb,kb->kla", forms, u)
        # The forms and their slopes, and the length kept: else Newton's method would only shorten u.
        slopes = np.concatenate([2 * pulled, u[:, None]], axis=1)
        values = np.concatenate([pulled @ u[:, :, None], np.zeros((STARTS, 1, 1))], axis=1)
        u = u - (np.linalg.pinv(slopes, rcond=TANGENT) @ values)[:, :, 0]
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    worst = np.abs(np.einsum("ka,alb,kb->kl", u, forms, u)).max(axis=1)
    kept: list[Floats] = []
    for direction in u[worst <= DIRECTION] @ null:
        if all(abs(float(direction @ other)) < 1 - TANGENT for other in kept):
            kept.append(direction)
    return np.reshape(kept, (-1, len(q)))
