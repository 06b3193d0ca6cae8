"""One coordinate: the next duration it can have from a given one on, and its motion of that duration.

The theory stands in `extreme_loops`. A motion that takes longer than it must is a mixture of one of the two extreme
motions of its duration and a quiet one, which changes its velocity once and directly; where there is no time for that,
of both extreme ones. Mixtures keep every limit, for limits are intervals, and reach the displacement exactly.
"""

from __future__ import annotations

from math import inf, sqrt
from typing import NamedTuple

from mafsil.arrays import Floats
from mafsil.kernels.loops.loop import compiled
from mafsil.trajectory.jerk.extreme_loops import (
    Curve,
    Shape,
    bent_down,
    brake,
    curve_of,
    distance,
    first_rise,
    last_rise,
    rest_curve,
    shape_at,
    slope,
)
from mafsil.trajectory.tolerances import FEW_ROUNDINGS

PARTS = 7
"""Parts of an extreme motion."""
PIECES = 15
"""Most pieces of a motion: two of braking and the mixture of two motions of seven parts."""


class Task(NamedTuple):
    """What is left of a coordinate's problem once it is inside its limits.

    Attributes:
        t1, j, t2: the way there: jerk j for t1, then none for t2.
        D: displacement that is left.
        v0, a0, vf, af: states at both ends.
        v_lo, v_hi, am, ap, jm, jp: limits, those of acceleration and jerk as magnitudes.
    """

    t1: float
    j: float
    t2: float
    D: float
    v0: float
    a0: float
    vf: float
    af: float
    v_lo: float
    v_hi: float
    am: float
    ap: float
    jm: float
    jp: float


@compiled
def task_of(states: Floats, limits: Floats, i: int) -> Task:
    """A coordinate's task.

    Args:
        states: (n, 6) p0, v0, a0, pf, vf, af.
        limits: (n, 6) lower and upper velocity, acceleration and jerk; acceleration and jerk not zero, jerk finite.
        i: the coordinate.
    """
    v_lo, v_hi, a_lo, a_hi = limits[i, 0], limits[i, 1], limits[i, 2], limits[i, 3]
    jm, jp = -limits[i, 4], limits[i, 5]
    D, v0, a0 = states[i, 3] - states[i, 0], states[i, 1], states[i, 2]
    if v0 == 0.0 and a0 == 0.0:
        return Task(0.0, 0.0, 0.0, D, 0.0, 0.0, states[i, 4], states[i, 5], v_lo, v_hi, -a_lo, a_hi, jm, jp)
    t1, j, t2, v, a = brake(v0, a0, v_lo, v_hi, a_lo, a_hi, jp, jm)
    if t1 > 0.0:
        D -= t1 * (v0 + t1 * (0.5 * a0 + t1 * j * (1.0 / 6.0)))
    if t2 > 0.0:
        D -= t2 * (v - 0.5 * a * t2)
    return Task(t1, j, t2, D, v, a, states[i, 4], states[i, 5], v_lo, v_hi, -a_lo, a_hi, jm, jp)


@compiled
def forwards(w: Task) -> Curve:
    """The farthest motions."""
    return curve_of(w.v0, w.a0, w.vf, w.af, w.v_hi, w.ap, w.am, w.jp, w.jm)


@compiled
def backwards(w: Task) -> Curve:
    """The farthest motions of the mirror image."""
    return curve_of(-w.v0, -w.a0, -w.vf, -w.af, -w.v_lo, w.am, w.ap, w.jm, w.jp)


@compiled
def _rests(w: Task) -> bool:
    """Whether it leads from rest to rest."""
    return w.v0 == 0.0 and w.a0 == 0.0 and w.vf == 0.0 and w.af == 0.0


@compiled
def _rest_curve(w: Task) -> Curve:
    """Of a task from rest to rest, in its direction."""
    if w.D > 0.0:
        return rest_curve(w.v_hi, w.ap, w.am, w.jp, w.jm)
    return rest_curve(-w.v_lo, w.am, w.ap, w.jm, w.jp)


@compiled
def _ahead(w: Task) -> float:
    """Time minus tau of the farthest motions."""
    return (w.af - w.a0) / w.jp


@compiled
def _behind(w: Task) -> float:
    """Time minus tau of those of the mirror image."""
    return (w.a0 - w.af) / w.jm


@compiled
def shortest_change(w: Task) -> float:
    """The shortest duration if the displacement does not matter."""
    return max(forwards(w).start + _ahead(w), 0.0)


@compiled
def beyond_gap(w: Task, T: float) -> float:
    """The least duration of at least T in which the velocity can be changed, T not less than the shortest."""
    c = forwards(w)
    return c.after + _ahead(w) if c.gap < T - _ahead(w) < c.after else T


@compiled
def _slack(w: Task, T: float) -> float:
    """What rounding can make of a displacement: the times of the ends' accelerations count, however short T is."""
    longest = T + (abs(w.a0) + abs(w.af)) * (1.0 / w.jp + 1.0 / w.jm)
    return FEW_ROUNDINGS * (abs(w.D) + (abs(w.v0) + abs(w.vf)) * longest)


@compiled
def next_duration(w: Task, T: float) -> float:
    """The least duration of at least T that the task can have, braking not included; infinite if there is none.

    From the first duration on, the displacements that can be had are an interval: its upper end is D_max, its lower end
    minus the mirror image's. Where the displacement lies outside, that end's curve is followed to where it comes back.

    1. From rest to rest there is no gap: the last rise of one curve.
    2. Else from the direct change of velocity on, which is the shortest; a duration within the gap comes after it.
    3. Inside the interval the duration is had; outside, which end's curve has to come back.
    4. The next rise of that curve: in its concave beginning, its convex part, or after the gap.
    """
    # 1.
    if _rests(w):
        if w.D == 0.0:
            return T
        c = _rest_curve(w)
        if T > 0.0 and distance(c, shape_at(c, T)) >= abs(w.D):
            return T
        rise = last_rise(c, abs(w.D), T, inf)
        return rise if rise >= 0.0 else inf
    up, down = forwards(w), backwards(w)
    # 2.
    T = max(T, up.start + _ahead(w))
    tau = max(T - _ahead(w), up.start)
    if up.gap < tau < up.after:
        return _after_gap(w, up, down)
    # 3.
    mirrored = max(T - _behind(w), down.start)
    s, m = shape_at(up, tau), shape_at(down, mirrored)
    high, low = distance(up, s), -distance(down, m)
    slack = _slack(w, T)
    if low - slack <= w.D <= high + slack:
        return T
    c, D, offset = up, w.D, _ahead(w)
    if w.D < low:
        c, D, offset, tau, s = down, -w.D, _behind(w), mirrored, m
    # 4.
    if bent_down(c, s):
        rise = first_rise(c, D, tau, c.gap)
        if rise >= 0.0:
            return rise + offset
    if tau <= c.gap < inf:
        if distance(c, shape_at(c, c.gap)) < D:
            return _after_gap(w, up, down)
        return last_rise(c, D, tau, c.gap) + offset
    rise = last_rise(c, D, tau, inf)
    return rise + offset if rise >= 0.0 else inf


@compiled
def is_endless(w: Task, T: float) -> bool:
    """Whether every duration from T on can be had: both ends of the interval go outwards, and so on without end."""
    if _rests(w):
        return True
    up, down = forwards(w), backwards(w)
    tau, mirrored = max(T - _ahead(w), up.start), max(T - _behind(w), down.start)
    if up.gap < inf and tau < up.after:
        return False
    return _widens(up, tau) and _widens(down, mirrored)


@compiled
def _widens(c: Curve, tau: float) -> bool:
    """Whether a curve rises from tau on."""
    if tau >= c.tau_top:
        return c.top >= 0.0
    s = shape_at(c, tau)
    return slope(c, s) >= 0.0 and not bent_down(c, s)


@compiled
def _after_gap(w: Task, up: Curve, down: Curve) -> float:
    """After the gap the motion begins anew with one displacement, farther or less far than wanted."""
    c, D, offset = up, w.D, _ahead(w)
    if w.D < distance(up, shape_at(up, up.after)):
        c, D, offset = down, -w.D, _behind(w)
    tau = last_rise(c, D, c.after, inf)
    return tau + offset if tau >= 0.0 else inf


@compiled
def _parts(c: Curve, s: Shape, sign: float, times: Floats, row: int, jerks: Floats, jerk_row: int, first: int) -> None:
    """The seven parts of a farthest motion, or of its mirror image, into rows of times and jerks."""
    times[row, first], jerks[jerk_row, first] = max((s.A - c.a0) * c.ip, 0.0), sign * c.jp
    times[row, first + 1], jerks[jerk_row, first + 1] = s.t2, 0.0
    times[row, first + 3], jerks[jerk_row, first + 3] = s.cruise, 0.0
    jerks[jerk_row, first + 2] = jerks[jerk_row, first + 4] = -sign * c.jm
    if s.cruise > 0.0:
        times[row, first + 2], times[row, first + 4] = s.A * c.im, s.B * c.im
    else:
        times[row, first + 2], times[row, first + 4] = max((s.A + s.B) * c.im, 0.0), 0.0
    times[row, first + 5], jerks[jerk_row, first + 5] = s.t4, 0.0
    times[row, first + 6], jerks[jerk_row, first + 6] = max((c.af + s.B) * c.ip, 0.0), sign * c.jp


@compiled
def _quiet(w: Task, D: float, T: float, scratch: Floats) -> tuple[bool, float]:
    """A motion without haste: acceleration to zero, directly to the last velocity, and to the last acceleration.

    What time is left is spent before or after the change of velocity (parts 1 and 5), so that the displacement comes as
    near to D as it can.

    1. The velocities between which it changes, the change from one to the other, and the time that is left.
    2. Its displacement if all of it is spent before, and what each second after instead of before adds.
    3. Its seven parts.

    Returns:
        Whether T is long enough, and its displacement.
    """
    # 1.
    into, out = abs(w.a0) / (w.jm if w.a0 > 0.0 else w.jp), abs(w.af) / (w.jp if w.af > 0.0 else w.jm)
    v, vf = w.v0 + 0.5 * w.a0 * into, w.vf - 0.5 * w.af * out
    side, most, first, last = 1.0, w.ap, 1.0 / w.jp, 1.0 / w.jm
    if vf < v:
        side, most, first, last = -1.0, w.am, last, first
    k, change = first + last, abs(vf - v)
    A, held = sqrt(2.0 * change / k), 0.0
    if A > most:
        A, held = most, change / most - 0.5 * k * most
    spare = T - into - out - k * A - held
    if spare < 0.0:
        return False, 0.0
    # 2.
    way = into * (w.v0 + w.a0 * into * (1.0 / 3.0)) + v * spare + out * (vf + w.af * out * (1.0 / 6.0))
    if change > 0.0:
        rise = A * first
        mid = v + side * (0.5 * A * rise + A * held)
        way += rise * (v + side * A * rise * (1.0 / 6.0)) + held * (mid - 0.5 * side * A * held)
        fall = A * last
        way += fall * (vf - side * A * fall * (1.0 / 6.0))
        later = min(max((D - way) / (vf - v), 0.0), spare)
    else:
        later = 0.0
    way += later * (vf - v)
    # 3.
    scratch[0, 0], scratch[1, 0] = into, (-w.jm if w.a0 > 0.0 else w.jp)
    scratch[0, 1], scratch[1, 1] = spare - later, 0.0
    scratch[0, 2], scratch[1, 2] = A * first, side / first
    scratch[0, 3], scratch[1, 3] = held, 0.0
    scratch[0, 4], scratch[1, 4] = A * last, -side / last
    scratch[0, 5], scratch[1, 5] = later, 0.0
    scratch[0, 6], scratch[1, 6] = out, (w.jp if w.af > 0.0 else -w.jm)
    return True, way


@compiled
def motion_of(w: Task, T: float, free: bool, sure: bool, scratch: Floats, times: Floats, jerks: Floats, i: int) -> int:
    """The pieces of a task of duration T.

    1. Braking; from rest to rest then the farthest motion, scaled.
    2. With time to spare there is a quiet motion; it may be the one, else one extreme motion is mixed with it.
    3. Else both extreme motions are mixed; at an end of their interval it is one of them.

    Args:
        w: the task.
        T: duration, braking not included.
        free: whether its displacement does not matter.
        sure: whether T is known to be possible, up to rounding.
        scratch: (4, 7) to work in.
        times, jerks: (n, 15) durations and jerks of the pieces, written here.
        i: the coordinate.

    Returns:
        Number of pieces; 0 if there is no such motion.
    """
    # 1.
    times[i, 0], jerks[i, 0] = w.t1, w.j
    times[i, 1], jerks[i, 1] = w.t2, 0.0
    D, slack = w.D, _slack(w, T)
    if _rests(w) and not free:
        return _scaled_parts(w, T, sure, times, jerks, i)
    # 2.
    if free:
        D = 0.5 * (w.v0 + w.vf) * T
    quiet, way = _quiet(w, D, T, scratch)
    if quiet and (free or abs(way - D) <= slack):
        for k in range(PARTS):
            times[i, 2 + k], jerks[i, 2 + k] = scratch[0, k], scratch[1, k]
        return 2 + PARTS
    if quiet:
        return _quiet_mixed(w, T, D, way, slack, sure, scratch, times, jerks, i)
    # 3.
    up, down = forwards(w), backwards(w)
    tau = T - _ahead(w)
    if (up.gap < tau < up.after or tau < up.start - FEW_ROUNDINGS * T) and not sure:
        return 0
    s, m = shape_at(up, max(tau, up.start)), shape_at(down, max(T - _behind(w), down.start))
    high, low = distance(up, s), -distance(down, m)
    if free:
        D = min(max(D, low), high)
    if (D > high + slack or D < low - slack) and not sure:
        return 0
    if high - D <= slack or D - low <= slack:
        if abs(D - high) <= abs(D - low):
            _parts(up, s, 1.0, times, i, jerks, i, 2)
        else:
            _parts(down, m, -1.0, times, i, jerks, i, 2)
        return 2 + PARTS
    _parts(down, m, -1.0, scratch, 0, scratch, 1, 0)
    _parts(up, s, 1.0, scratch, 2, scratch, 3, 0)
    return _mixture(scratch, (D - low) / (high - low), times, jerks, i)


@compiled
def _quiet_mixed(
    w: Task, T: float, D: float, way: float, slack: float, sure: bool, scratch: Floats, times: Floats, jerks: Floats,
    i: int,
) -> int:  # fmt: skip
    """The pieces of the quiet motion in `scratch`, of displacement `way`, mixed with the farthest one towards D."""
    sign = 1.0 if D > way else -1.0
    c = forwards(w) if D > way else backwards(w)
    s = shape_at(c, T - (_ahead(w) if D > way else _behind(w)))
    reach = distance(c, s)
    if sign * D > reach + slack and not sure:
        return 0
    share = min((D - way) / (sign * reach - way), 1.0) if sign * D < reach else 1.0
    if scratch[0, 1] == T or share == 1.0:
        _parts(c, s, sign * share, times, i, jerks, i, 2)
        return 2 + PARTS
    _parts(c, s, sign, scratch, 2, scratch, 3, 0)
    return _mixture(scratch, share, times, jerks, i)


@compiled
def _scaled_parts(w: Task, T: float, sure: bool, times: Floats, jerks: Floats, i: int) -> int:
    """The pieces of a task from rest to rest: the farthest motion of its duration, scaled; none if it is too short."""
    if w.D == 0.0:
        times[i, 2], jerks[i, 2] = T, 0.0
        return 3
    c = _rest_curve(w)
    s = shape_at(c, T)
    reach = distance(c, s)
    if reach < abs(w.D) * (1.0 - FEW_ROUNDINGS) and not sure:
        return 0
    share = min(abs(w.D) / reach, 1.0) if reach > 0.0 else 1.0
    _parts(c, s, share if w.D > 0.0 else -share, times, i, jerks, i, 2)
    return 2 + PARTS


@compiled
def _mixture(scratch: Floats, share: float, times: Floats, jerks: Floats, m: int) -> int:
    """Pieces of (1 - share) times the first motion plus share times the second, from the third piece on."""
    count, i, k = 2, 0, 0
    left, right = scratch[0, 0], scratch[2, 0]
    while i < PARTS and k < PARTS:
        step = min(left, right)
        if step > 0.0:
            times[m, count] = step
            jerks[m, count] = (1.0 - share) * scratch[1, i] + share * scratch[3, k]
            count += 1
        left -= step
        right -= step
        if left <= 0.0:
            i += 1
            if i < PARTS:
                left = scratch[0, i]
        if right <= 0.0:
            k += 1
            if k < PARTS:
                right = scratch[2, k]
    return count
