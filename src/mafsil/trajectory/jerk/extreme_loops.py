"""The farthest motion of a coordinate in a given time with bounded jerk, and the way back inside its limits before it.

For a time T the motions that keep the limits form a convex set (linear equations, intervals as limits), so the
displacements they reach form an interval [D_min(T), D_max(T)]. Everything else follows from its two ends:

- the shortest motion over a distance D has the first T with D_min(T) <= D <= D_max(T);
- a motion of any longer duration T is the mixture of the two extreme ones that gives D; if D lies outside the
  interval, there is none.

By Pontryagin's principle the farthest motion has jerk + 0 - 0 +: the acceleration rises from a0 to A, stays there only
if A is the largest, falls to -B, stays there only if B is the largest, and rises to af; where the speed reaches its
limit in between, it stays there with no acceleration. With jerks jp, -jm, accelerations ap, -am,

    k = 1/jp + 1/jm       X = k A^2/2 + ap t2        Y = k B^2/2 + am t4        (t2, t4: how long A and -B are held)
    X = Y + C             C = vf - v0 + (a0^2 - af^2)/(2 jp)                    (velocity)
    tau = k (A + B) + t2 + t4 = T - (af - a0)/jp                                (time)

so that A and B for a given tau are closed: A + B = tau/k, A - B = (2 C/k)/(A + B) with nothing held. A may be negative
(down to a0) and B too (down to -af): the speed then has no peak inside. Its slope is the Hamiltonian,

    dD_max/dT = H = v0 - a0^2/(2 jp) + X + A B/(2 jm).

H grows with tau where A, B > 0: D_max is convex there, up to the time tau_top at which the speed reaches its limit and
from which H is that limit. Where B < 0 or A < 0 it is concave at first, then convex. The least motion is the farthest
one of the mirrored coordinate.

Reference: Pontryagin et al., The Mathematical Theory of Optimal Processes, ch. 1; Berscheid and Kroeger, Jerk-limited
Real-time Trajectory Generation with Arbitrary Target States, RSS 2021 (the problem; its solution there is another).

Outside are accelerations beyond their limit, speeds beyond theirs, and speeds that an acceleration will inevitably
carry beyond. The coordinate returns with all its jerk, then with its largest acceleration, until the speed is back at
its limit, or until leaving off any later would carry it beyond the other one.
"""

from __future__ import annotations

from math import inf, sqrt
from typing import NamedTuple

from mafsil.kernels.loops.loop import compiled
from mafsil.trajectory.tolerances import FEW_ROUNDINGS

STEPS = 100
"""Most steps of an iteration; ten are usual."""
EPS = 2.2e-16


class Curve(NamedTuple):
    """One coordinate's farthest displacement as a function of tau: its constants.

    Attributes:
        v0, a0, vf, af: the states at both ends.
        ap, am, jp, jm, top: largest acceleration, deceleration, jerk, negative jerk and speed, as magnitudes.
        ip, im, k, C: 1/jp, 1/jm and the constants above.
        Xtop: X with which the speed limit is reached.
        start: tau of the direct change of velocity, the shortest there is.
        gap, after: between these tau the end velocity cannot be reached: too late for one way, too early for another.
        tau_top: tau from which the speed limit is reached.
    """

    v0: float
    a0: float
    vf: float
    af: float
    ap: float
    am: float
    jp: float
    jm: float
    top: float
    ip: float
    im: float
    k: float
    C: float
    Xtop: float
    start: float
    gap: float
    after: float
    tau_top: float


class Shape(NamedTuple):
    """One farthest motion: accelerations A and -B, how long each is held, and how long the top speed."""

    A: float
    B: float
    t2: float
    cruise: float
    t4: float


@compiled
def _time_of(X: float, k: float, most: float) -> float:
    """k A + t2 for a change of velocity X."""
    corner = 0.5 * k * most * most
    return sqrt(2.0 * k * max(X, 0.0)) if X <= corner else 0.5 * k * most + X / most


@compiled
def curve_of(
    v0: float, a0: float, vf: float, af: float, top: float, ap: float, am: float, jp: float, jm: float
) -> Curve:
    """The constants of a curve; arguments as its attributes.

    1. The direct change: acceleration up and down again if monotone acceleration gains too little, else down and up.
       Where both accelerations have one sign there may be a gap after it.
    2. The speed limit: reached from either end with what its acceleration makes necessary, or more.
    """
    ip, im = 1.0 / jp, 1.0 / jm
    k = ip + im
    C = vf - v0 + 0.5 * ip * (a0 * a0 - af * af)
    c = 2.0 * C / k
    gap = after = inf
    # 1.
    monotone = 0.5 * (af - a0) * (af + a0) * (ip if a0 <= af else -im)
    # Where both accelerations have one sign, rounding must not send a monotone change the long way round.
    rounding = 16.0 * EPS * (abs(v0) + abs(vf) + k * (a0 * a0 + af * af))
    edge = -rounding if a0 > 0.0 and af > 0.0 else (rounding if a0 < 0.0 and af < 0.0 else 0.0)
    if vf - v0 - monotone > edge or (edge <= 0.0 and vf - v0 - monotone == edge):
        start = _time_of(0.5 * k * af * af + C, k, ap) - k * af
        if a0 > 0.0 and af > 0.0 and C < 0.5 * k * a0 * a0:
            root = sqrt(max(a0 * a0 - c, 0.0))
            gap = max(k * (a0 - root), start) + 8.0 * EPS * k * a0
            after = max(_time_of(0.5 * k * root * root, k, am) + k * a0, gap)
    else:
        start = _time_of(0.5 * k * a0 * a0 - C, k, am) + k * a0
        if a0 < 0.0 and af < 0.0 and -C < 0.5 * k * af * af:
            root = sqrt(max(af * af + c, 0.0))
            gap = max(k * (-root - af), start) - 8.0 * EPS * k * af
            after = max(_time_of(0.5 * k * root * root, k, ap) - k * af, gap)
    # 2.
    X = max(top - v0 + 0.5 * ip * a0 * a0, 0.5 * k * max(a0, 0.0) ** 2)
    Y = max(top - vf + 0.5 * ip * af * af, 0.5 * k * min(af, 0.0) ** 2)
    tau_top = inf if top == inf else max(_time_of(X, k, ap) + _time_of(Y, k, am), start)
    return Curve(v0, a0, vf, af, ap, am, jp, jm, top, ip, im, k, C, X, start, gap, after, tau_top)


@compiled
def rest_curve(top: float, ap: float, am: float, jp: float, jm: float) -> Curve:
    """The constants of a curve from rest to rest; arguments as its attributes."""
    ip, im = 1.0 / jp, 1.0 / jm
    k = ip + im
    tau_top = inf if top == inf else _time_of(top, k, ap) + _time_of(top, k, am)
    return Curve(0.0, 0.0, 0.0, 0.0, ap, am, jp, jm, top, ip, im, k, 0.0, top, 0.0, inf, inf, tau_top)


@compiled
def shape_at(c: Curve, tau: float) -> Shape:
    """The farthest motion of a time tau.

    1. Where the speed limit is reached both changes of velocity are known; the rest is cruising.
    2. Else A and B from their sum and difference, if neither is beyond its limit.
    3. Else the largest acceleration is held, or the largest deceleration, or both.

    Args:
        c: the curve.
        tau: at least `c.start`, not between `c.gap` and `c.after`.
    """
    k, ap, am = c.k, c.ap, c.am
    # 1.
    if tau >= c.tau_top:
        A = min(sqrt(2.0 * max(c.Xtop, 0.0) / k), ap)
        Y = max(c.top - c.vf + 0.5 * c.ip * c.af * c.af, 0.5 * k * min(c.af, 0.0) ** 2)
        B = min(sqrt(2.0 * Y / k), am)
        t2 = max(c.Xtop / ap - 0.5 * k * ap, 0.0) if A == ap else 0.0
        t4 = max(Y / am - 0.5 * k * am, 0.0) if B == am else 0.0
        return Shape(A, B, t2, tau - c.tau_top, t4)
    # 2.
    u = tau / k
    w = 2.0 * c.C / (k * u) if u > 0.0 else 0.0
    A = max(0.5 * (u + w), c.a0)  # for short times w is little more than rounding
    B = u - A
    if B < -c.af:
        A, B = u + c.af, -c.af
    if A <= ap and B <= am:
        return Shape(A, B, 0.0, 0.0, 0.0)
    # 3.
    if A > ap:
        B = sqrt(max(2.0 * (ap * tau - c.C) / k, 0.0)) - ap
        if B <= am:
            return Shape(ap, B, max(tau - k * (ap + B), 0.0), 0.0, 0.0)
    A = sqrt(max(2.0 * (am * tau + c.C) / k, 0.0)) - am
    if A <= ap:
        return Shape(A, am, 0.0, 0.0, max(tau - k * (A + am), 0.0))
    rest = tau - k * (ap + am)
    t2 = (am * rest + 0.5 * k * (am - ap) * (am + ap) + c.C) / (ap + am)
    t2 = min(max(t2, 0.0), rest)
    return Shape(ap, am, t2, 0.0, rest - t2)


@compiled
def distance(c: Curve, s: Shape) -> float:
    """Displacement of a motion: the sum over its parts."""
    t1 = (s.A - c.a0) * c.ip
    t3 = (s.A + s.B) * c.im
    t5 = (c.af + s.B) * c.ip
    v1 = c.v0 + 0.5 * t1 * (c.a0 + s.A)
    v2 = v1 + s.A * s.t2
    v4 = c.vf - 0.5 * t5 * (c.af - s.B)
    rise = t1 * (c.v0 + t1 * (2.0 * c.a0 + s.A) * (1.0 / 6.0)) + s.t2 * 0.5 * (v1 + v2)
    fall = t3 * (v2 + t3 * (2.0 * s.A - s.B) * (1.0 / 6.0)) + s.t4 * (v4 + 0.5 * s.B * s.t4)
    last = t5 * (c.vf - t5 * (2.0 * c.af - s.B) * (1.0 / 6.0))
    cruise = s.cruise * c.top if s.cruise > 0.0 else 0.0
    return rise + fall + last + cruise


@compiled
def slope(c: Curve, s: Shape) -> float:
    """H, the derivative of the displacement with respect to time, below the speed limit."""
    X = 0.5 * c.k * s.A * s.A + s.A * s.t2
    return c.v0 - 0.5 * c.ip * c.a0 * c.a0 + X + 0.5 * c.im * s.A * s.B


@compiled
def bent_down(c: Curve, s: Shape) -> bool:
    """Whether the curve is concave at this motion: its H falls."""
    if s.B < 0.0:
        if s.t2 > 0.0:
            return -s.B * c.k > 0.5 * s.A * c.im
        return -2.0 * c.k * s.A * s.B > (s.A * s.A + s.B * s.B) * c.im
    if s.A < 0.0:
        if s.t4 > 0.0:
            return -s.A * c.k > 0.5 * s.B * c.im
        return -2.0 * c.k * s.A * s.B > (s.A * s.A + s.B * s.B) * c.im
    return False


@compiled
def first_rise(c: Curve, D: float, tau: float, end: float) -> float:
    """Where the curve first reaches D in its concave beginning, or -1: Newton's steps from the left, never too far.

    Args:
        c: the curve.
        D: displacement, above the curve at tau.
        tau: where the search begins.
        end: last tau that counts.
    """
    for _ in range(STEPS):
        s = shape_at(c, tau)
        H, missing = slope(c, s), D - distance(c, s)
        if not bent_down(c, s) or H <= 0.0:
            return -1.0
        step = missing / H
        if step <= 4.0 * EPS * tau:  # negative only by rounding: a concave curve lies below its tangents
            return tau
        tau += step
        if tau > end:
            return -1.0
    return -1.0


@compiled
def last_rise(c: Curve, D: float, low: float, high: float) -> float:
    """Where the curve reaches D in its convex part: Newton's steps from the right, never too far.

    1. At the speed limit the curve is a straight line; before, a power of the time is a good first guess.
    2. Newton's steps: from the second on they fall, until rounding stops them or the next would not be felt.

    Args:
        c: the curve.
        D: displacement, above the curve at low and wherever it is concave from there on.
        low: a tau before the rise.
        high: a tau after it at which the curve is at least D, or infinity.

    Returns:
        tau; -1 if D is never reached.
    """
    # 1.
    if c.tau_top < inf and c.tau_top <= high:
        s = shape_at(c, c.tau_top)
        beyond = D - distance(c, s)
        if beyond >= 0.0:
            return c.tau_top + beyond / c.top if c.top > 0.0 else (-1.0 if beyond > 0.0 else c.tau_top)
        high = c.tau_top
        below = D - distance(c, shape_at(c, low))
        tau = high
        if below > 0.0:
            width, rise = high - low, below - beyond
            power = slope(c, s) * width / rise
            tau = low + width * (below / rise) ** (1.0 / max(power, 1.0))
    elif high == inf:
        tau = 2.0 * low + (16.0 * c.k * abs(D)) ** (1.0 / 3.0) + sqrt(abs(c.C) * c.k)
        while distance(c, shape_at(c, tau)) < D:
            tau *= 2.0
            if not tau < inf:
                return -1.0
    else:
        tau = high
    # 2.
    last = inf
    for turn in range(STEPS):
        s = shape_at(c, tau)
        H, excess = slope(c, s), distance(c, s) - D
        if H <= 0.0:
            if turn > 0 or not high < inf:
                break
            tau = high
            continue
        step = excess / H
        if step < 0.0 and turn > 0:
            break
        tau = min(max(tau - step, low), high)
        if abs(step) <= 4.0 * EPS * tau or (turn > 1 and step * step * step <= EPS * tau * last * last):
            break
        last = step
    return tau


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
