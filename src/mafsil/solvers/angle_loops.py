"""Angles of eight points side by side, compiled."""

from __future__ import annotations

from mafsil.kernels.loops.lanes import Lanes, magnitude, where
from mafsil.kernels.loops.loop import reordered


@reordered
def angle_of(cosine: Lanes, sine: Lanes) -> Lanes:
    """The angle in (-pi, pi] of cosine and sine up to a factor, in each lane, within 2 ulp.

    1. Of the larger over the smaller component only tan x <= 1 is left, and beyond tan (pi / 8) it is turned by pi / 4.
    2. atan x = x + x^3 P(x^2) / Q(x^2) (Moshier, Cephes, 1995).
    3. The turns of step 1 are undone, and the signs put back.
    """
    # 1.
    a, b = magnitude(cosine), magnitude(sine)
    steep = b > a
    low, high = where(steep, a, b), where(steep, b, a)
    turned = low > 0.41421356237309503 * high
    x = where(turned, low - high, low) / where(turned, low + high, where(high > 0.0, high, 1.0))
    # 2.
    z = x * x
    p = (((-8.750608600031904122785e-1 * z - 1.615753718733365076637e1) * z - 7.500855792314704667340e1) * z
         - 1.228866684490136173410e2) * z - 6.485021904942025371773e1  # fmt: skip
    q = ((((z + 2.485846490142306297962e1) * z + 1.650270098316988542046e2) * z + 4.328810604912902668951e2) * z
         + 4.853903996359136964868e2) * z + 1.945506571482613964425e2  # fmt: skip
    angle = x + x * z * (p / q)
    # 3.
    angle = where(turned, 0.78539816339744830962 + (angle + 3.061616997868383e-17), angle)
    angle = where(steep, 1.57079632679489661923 - (angle - 6.123233995736766e-17), angle)
    angle = where(cosine < 0.0, 3.14159265358979323846 - (angle - 1.2246467991473532e-16), angle)
    return where((sine < 0.0) & (angle < 3.14159265358979323846), -angle, angle)
