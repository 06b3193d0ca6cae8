"""Points with durations between them, as users give them."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, positive, real_array, require_finite
from mafsil.errors import InputError


def points_and_durations(points: ArrayLike, durations: ArrayLike) -> tuple[Floats, Floats]:
    """(k + 1, *batch, n) points, the points first, and (k,) durations.

    Args:
        points: (*batch, k + 1, n), or (k + 1,) of one coordinate [rad | m].
        durations: (k,), or one number for all [s].

    Raises:
        InputError: a wrong shape, a number that is not finite, a duration that is not positive.
    """
    u = require_finite("points", real_array("points", points))
    u = u[:, None] if u.ndim == 1 else u
    h = require_finite("durations", real_array("durations", durations))
    if u.ndim < 2 or u.shape[-2] < 2 or u.shape[-1] < 1:
        raise InputError("input.shape", name="points", expected="(*batch, k + 1, n), k >= 1", got=u.shape, hint="")
    legs = (u.shape[-2] - 1,)
    if h.shape not in ((), legs):
        raise InputError("input.shape", name="durations", expected=legs, got=h.shape, hint="")
    for leg in np.atleast_1d(h):
        positive("durations", float(leg))
    return np.moveaxis(u, -2, 0), np.broadcast_to(h, legs).astype(np.float64)
