"""Back inside the limits as soon as possible: what comes before the shortest motion of a coordinate outside them.

Outside are accelerations beyond their limit, speeds beyond theirs, and speeds that an acceleration will inevitably
carry beyond. The coordinate returns with all its jerk, then with its largest acceleration, until the speed is back at
its limit, or until leaving off any later would carry it beyond the other one.
"""

from __future__ import annotations

from math import inf, sqrt

from mafsil.kernels.loops.loop import compiled
from mafsil.trajectory.tolerances import FEW_ROUNDINGS


@compiled
def _slow(
    v: float, a: float, v_lo: float, v_hi: float, am: float, jp: float, jm: float
) -> tuple[float, float, float, float]:
    """Times with jerk -jm and with acceleration -am, and the state at their end: too fast upwards."""
    k = 1.0 / jp + 1.0 / jm
    # 1. Where the speed is back, and the last place to leave off.
    back = sqrt(max(a * a + 2.0 * jm * (v - v_hi), 0.0))
    leave = sqrt(max(2.0 / k * (v - v_lo + 0.5 * a * a / jm), 0.0)) if v_lo > -inf else inf
    low = -min(back, leave)
    if low >= -am:
        low = min(low, a)
        return (a - low) / jm, 0.0, v + 0.5 * (a - low) * (a + low) / jm, low
    # 2. The largest deceleration comes first, and is held.
    first = max((a + am) / jm, 0.0)
    v += 0.5 * (a - am) * first
    held = max(min(v - v_hi, v - v_lo - 0.5 * am * am / jp), 0.0) / am
    return first, held, v - am * held, -am


@compiled
def _from_above(
    v: float, a: float, v_lo: float, v_hi: float, ap: float, am: float, jp: float, jm: float
) -> tuple[float, float, float, float]:
    """As `_slow`, for an acceleration above its limit."""
    if v + 0.5 * a * a / jm > v_hi:
        return _slow(v, a, v_lo, v_hi, am, jp, jm)
    first = (a - ap) / jm
    v += 0.5 * (a + ap) * first
    held = 0.0
    if v < v_lo:
        held = max(min(v_lo - v, v_hi - 0.5 * ap * ap / jm - v), 0.0) / ap
    return first, held, v + ap * held, ap


@compiled
def brake(
    v: float, a: float, v_lo: float, v_hi: float, a_lo: float, a_hi: float, jp: float, jm: float
) -> tuple[float, float, float, float, float]:
    """The way back inside the limits.

    Args:
        v, a: velocity and acceleration at the start.
        v_lo, v_hi, a_lo, a_hi: their limits.
        jp, jm: largest jerk in both directions, as magnitudes.

    Returns:
        t1 with jerk j, t2 with the acceleration reached, and the speed and acceleration at the end: (t1, j, t2, v, a).
    """
    high = v_hi + FEW_ROUNDINGS * abs(v_hi) if v_hi < inf else inf
    low = v_lo - FEW_ROUNDINGS * abs(v_lo) if v_lo > -inf else -inf
    if a > a_hi:
        t1, t2, v, a = _from_above(v, a, v_lo, v_hi, a_hi, -a_lo, jp, jm)
        return t1, -jm, t2, v, a
    if a < a_lo:
        t1, t2, v, a = _from_above(-v, -a, -v_hi, -v_lo, -a_lo, a_hi, jm, jp)
        return t1, jp, t2, -v, -a
    if (v > high and v - 0.5 * min(a, 0.0) ** 2 / jp > v_lo) or (a > 0.0 and v + 0.5 * a * a / jm > high):
        t1, t2, v, a = _slow(v, a, v_lo, v_hi, -a_lo, jp, jm)
        return t1, -jm, t2, v, a
    if (v < low and v + 0.5 * max(a, 0.0) ** 2 / jm < v_hi) or (a < 0.0 and v - 0.5 * a * a / jp < low):
        t1, t2, v, a = _slow(-v, -a, -v_hi, -v_lo, a_hi, jm, jp)
        return t1, jp, t2, -v, -a
    return 0.0, 0.0, 0.0, v, a
