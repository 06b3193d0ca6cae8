"""Samples of a polynomial on a circle, or on an image of it that makes them alike, compiled.

Imported only where poses are solved: numba is loaded with it. Arrays named `w_...` are room to work in.
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false
from __future__ import annotations

from math import atan2, cos, hypot, sin, sqrt

import numpy as np

from mafsil.solvers.loops import compiled


@compiled
def fitted_circle(f, degree, angles):
    """(centre, squeeze) of the projective image of the circle on which samples of a polynomial are most alike.

    On the image f(t) is multiplied by r^(2 degree), r^2 = |(m c, s / m)|^2 with the half angle (c, s) of the image
    and the squeeze m: the first harmonic of log r^(2 degree) is made opposite to that of log |f|.

    Arguments as the attributes of `Arm` and `Room` in `solution_loops`.
    """
    most = x = y = 0.0
    for l in range(len(angles)):
        most = max(most, abs(f[l]))
    for l in range(len(angles)):
        level = np.log(abs(f[l]) / most + 1e-16)
        x += level * cos(angles[l])
        y += level * sin(angles[l])
    depth = min(0.85, hypot(x, y) / (len(angles) * degree))
    return atan2(-y, -x), sqrt((1 + depth) / (1 - depth))


@compiled
def turned_circle(centre, squeeze, degree, angles, w_cosines, w_sines, w_weights):
    """Nodes of an image of the circle, and their weights.

    Arguments as the attributes of `Arm` and `Room` in `solution_loops`.
    """
    for l in range(len(angles)):
        c, s = squeeze * cos(0.5 * angles[l]), sin(0.5 * angles[l]) / squeeze
        theta = centre + 2 * atan2(s, c)
        w_cosines[l], w_sines[l] = cos(theta), sin(theta)
        w_weights[l] = (c * c + s * s) ** degree


@compiled
def coefficients_of(f, fourier, degree, out):
    """Coefficients (2, degree + 1) of cos and sin; the largest of those that must be zero.

    Arguments as the attributes of `Arm` and `Room` in `solution_loops`.
    """
    dust = 0.0
    for i in range(len(f)):
        total = 0.0
        for l in range(len(f)):
            total += fourier[i, l] * f[l]
        if i <= 2 * degree:
            out[i & 1, (i + 1) >> 1] = total
        else:
            dust = max(dust, abs(total))
    out[1, 0] = 0.0
    return dust
