"""Cubic splines through points, by SciPy: twice continuously differentiable."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from mafsil.arrays import Floats


class Spline:
    """A cubic spline through values (k, ...) at increasing places (k,).

    Args:
        x, y: places and values.
        periodic: the last value is the first, and so are slope and curvature; else the third derivative is continuous
            at the places beside the ends.
    """

    def __init__(self, x: Floats, y: Floats, *, periodic: bool = False) -> None:
        self._spline = CubicSpline(x, y, bc_type="periodic" if periodic else "not-a-knot")

    def __call__(self, x: Floats | float, derivative: int = 0) -> Floats:
        """(*batch, ...) the value or a derivative at places (*batch)."""
        return np.asarray(self._spline(x, derivative), dtype=np.float64)
