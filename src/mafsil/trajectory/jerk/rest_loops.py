"""From rest to rest, all coordinates of a problem at once: one in each of eight lanes.

What moves from rest to rest has one curve of farthest displacement (`extreme_loops`) that is convex and has no gap, so
every duration from the shortest on is possible, and the common duration is the longest of the shortest.

1. Constants of each coordinate's curve, forwards and backwards: once for all problems of the same limits.
2. The shortest duration of each lane: Newton's steps from below two bounds; the curve is convex, so from the second
   step on they fall.
3. The longest of them, or more if it is asked for.
4. The farthest motion of that duration, scaled to the displacement.
"""

# pyright: reportMissingParameterType=false, reportUnknownVariableType=false, reportUnknownParameterType=false
# pyright: reportUnknownMemberType=false, reportUnknownArgumentType=false
from __future__ import annotations

from math import ceil, inf
from typing import Any, NamedTuple

from mafsil.arrays import Floats
from mafsil.kernels.loops.lanes import (
    any_lane,
    buffer,
    get,
    in_lanes,
    lanes,
    magnitude,
    part,
    put,
    seen,
    square_root,
    where,
)
from mafsil.kernels.loops.loop import compiled

LANES = 8
CONSTANTS = 16
"""Lanes of a curve's constants, in the order of `Curve`."""
STEPS = 60
"""Most steps of an iteration; five are usual."""
FELT = 1e-8
"""Last step of an iteration, as part of the duration: the next would be its square."""
LEAD, PARTS = 2, 7
"""Pieces of braking, which a motion from rest has not, and parts of a farthest motion."""


class Curve(NamedTuple):
    """Constants of farthest motions from rest to rest, in lanes.

    Attributes:
        ap, am, jp, jm, top: largest acceleration, deceleration, jerk, negative jerk and speed, as magnitudes.
        ip, im, k: 1/jp, 1/jm and their sum.
        cubic: displacement of an acceleration of 1 that is not held.
        both: 1/(ap + am), or zero.
        tau_top, D_top: duration and displacement at which the speed limit is reached.
        A, B, t2, t4: accelerations with which it is, and how long they are held.
    """

    ap: Any
    am: Any
    jp: Any
    jm: Any
    top: Any
    ip: Any
    im: Any
    k: Any
    both: Any
    cubic: Any
    tau_top: Any
    D_top: Any
    A: Any
    B: Any
    t2: Any
    t4: Any


class Motion(NamedTuple):
    """Farthest motions: accelerations A and -B, how long each is held, and how long the top speed; in lanes."""

    A: Any
    B: Any
    t2: Any
    cruise: Any
    t4: Any


@compiled
def lesser(a, b):
    """The smaller of each lane."""
    return where(a < b, a, b)


@compiled
def larger(a, b):
    """The larger of each lane."""
    return where(a > b, a, b)


@compiled
def _held(X, k, most):
    """The acceleration with which the speed changes by X, and how long it is held."""
    free = square_root(2.0 * X / k)
    holds = free > most
    return where(holds, most, free), where(holds, X / where(holds, most, 1.0) - 0.5 * k * most, 0.0)


@compiled
def _displacement(c, s):
    """Of a motion: the sum over its parts, as `extreme_loops.distance`."""
    t1, t3, t5 = s.A * c.ip, (s.A + s.B) * c.im, s.B * c.ip
    v1, v4 = 0.5 * t1 * s.A, 0.5 * t5 * s.B
    v2 = v1 + s.A * s.t2
    rise = t1 * t1 * s.A * (1.0 / 6.0) + s.t2 * 0.5 * (v1 + v2)
    fall = t3 * (v2 + t3 * (2.0 * s.A - s.B) * (1.0 / 6.0)) + s.t4 * (v4 + 0.5 * s.B * s.t4)
    cruise = where(s.cruise > 0.0, s.cruise * c.top, 0.0)
    return rise + fall + t5 * t5 * s.B * (1.0 / 6.0) + cruise


@compiled
def _curve(top, ap, am, jp, jm):
    """Step 1: the constants of one direction; limits as magnitudes, in lanes."""
    ip, im = 1.0 / jp, 1.0 / jm
    k, endless = ip + im, top >= inf
    A, t2 = _held(where(endless, 1.0, top), k, ap)
    B, t4 = _held(where(endless, 1.0, top), k, am)
    tau_top = where(endless, inf, k * (A + B) + t2 + t4)
    cubic = ip * ip * (1.0 / 3.0) + ip * im + im * im * (2.0 / 3.0)
    none = lanes(0.0)
    c = Curve(ap, am, jp, jm, top, ip, im, k, 1.0 / (ap + am), cubic, tau_top, none, A, B, t2, t4)
    D_top = where(endless, inf, _displacement(c, Motion(A, B, t2, none, t4)))
    return Curve(ap, am, jp, jm, top, ip, im, k, 1.0 / (ap + am), cubic, tau_top, D_top, A, B, t2, t4)


@compiled
def _store(c, place):
    """A curve's constants into lanes in order."""
    place[0], place[1], place[2], place[3], place[4], place[5] = c.ap, c.am, c.jp, c.jm, c.top, c.ip
    place[6], place[7], place[8], place[9], place[10] = c.im, c.k, c.both, c.cubic, c.tau_top
    place[11], place[12], place[13], place[14], place[15] = c.D_top, c.A, c.B, c.t2, c.t4


@compiled
def _chosen(place, forth):
    """The constants of each lane's direction."""
    back = part(place, CONSTANTS)
    return Curve(
        where(forth, place[0], back[0]),
        where(forth, place[1], back[1]),
        where(forth, place[2], back[2]),
        where(forth, place[3], back[3]),
        where(forth, place[4], back[4]),
        where(forth, place[5], back[5]),
        where(forth, place[6], back[6]),
        where(forth, place[7], back[7]),
        where(forth, place[8], back[8]),
        where(forth, place[9], back[9]),
        where(forth, place[10], back[10]),
        where(forth, place[11], back[11]),
        where(forth, place[12], back[12]),
        where(forth, place[13], back[13]),
        where(forth, place[14], back[14]),
        where(forth, place[15], back[15]),
    )


@compiled
def _motion(c, tau):
    """The farthest motions of durations tau, as `extreme_loops.shape_at`."""
    none = lanes(0.0)
    # 1. Nothing is held.
    A = 0.5 * tau / c.k
    plain = (A <= c.ap) & (A <= c.am)
    # 2. The largest acceleration is held, or the largest deceleration.
    first = square_root(2.0 * c.ap * tau / c.k) - c.ap
    second = square_root(2.0 * c.am * tau / c.k) - c.am
    up = (A > c.ap) & (first <= c.am)
    down = ~(plain | up) & (second <= c.ap)
    # 3. Both.
    full, rest = ~(plain | up | down), tau - c.k * (c.ap + c.am)
    t2 = (c.am * rest + 0.5 * c.k * (c.am - c.ap) * (c.am + c.ap)) * c.both
    t2 = larger(lesser(t2, rest), none)
    held = where(full, t2, where(up, larger(tau - c.k * (c.ap + first), none), none))
    kept = where(full, rest - t2, where(down, larger(tau - c.k * (second + c.am), none), none))
    rise, fall = where(up | full, c.ap, where(down, second, A)), where(down | full, c.am, where(up, first, A))
    # 4. The speed limit is reached.
    fast = tau >= c.tau_top
    return Motion(
        where(fast, c.A, rise),
        where(fast, c.B, fall),
        where(fast, c.t2, held),
        where(fast, tau - c.tau_top, none),
        where(fast, c.t4, kept),
    )


@compiled
def _shortest(c, D):
    """Step 2: the shortest durations of displacements D >= 0.

    1. Beyond the displacement at which the speed limit is reached the rest is passed at that speed.
    2. Else a first guess: as if no acceleration were held, with x^(1/4 + 1/16 + 1/64) for the cube root; or both, for
       then the displacement grows with the square of the duration.
    3. Newton's steps on the convex curve, until the next would not be felt.
    """
    # 1.
    limited, far = c.tau_top < inf, D >= c.D_top
    cruising = c.tau_top + (D - c.D_top) / c.top
    # 2.
    fourth = square_root(square_root(D / c.cubic))
    sixteenth = square_root(square_root(fourth))
    free = 2.0 * c.k * fourth * sixteenth * square_root(square_root(sixteenth))
    share = D / where(limited, c.D_top, 1.0)
    tau = where(limited, lesser(larger(free, c.tau_top * square_root(share)), c.tau_top), free)
    # 3.
    open_lanes = (D > 0.0) & ~far
    for turn in range(STEPS):
        if not any_lane(open_lanes):
            break
        s = _motion(c, tau)
        slope = 0.5 * c.k * s.A * s.A + s.A * s.t2 + 0.5 * c.im * s.A * s.B
        step = (_displacement(c, s) - D) / slope
        if turn > 0:
            open_lanes = open_lanes & (step > 0.0)
        tau = where(open_lanes, where(limited, lesser(tau - step, c.tau_top), tau - step), tau)
        open_lanes = open_lanes & (magnitude(step) > tau * FELT)
    return where(D > 0.0, where(far, cruising, tau), 0.0)


@compiled
def rest_curves(limits: Floats) -> tuple[bool, Floats]:
    """Step 1: constants of n coordinates, forwards and backwards, and whether all can move.

    Args:
        limits: (n, 6) lower and upper velocity, acceleration and jerk.
    """
    n = len(limits)
    groups, able = -(-n // LANES), True
    numbers, given = in_lanes(2 * CONSTANTS * groups), buffer(6)
    curves = seen(numbers)
    for g in range(groups):
        for lane in range(LANES):
            i = min(g * LANES + lane, n - 1)
            for k in range(6):
                put(given, k, lane, abs(limits[i, k]))
                able &= k < 2 or limits[i, k] != 0.0
        forth = _curve(given[1], given[3], given[2], given[5], given[4])
        back = _curve(given[0], given[2], given[3], given[4], given[5])
        _store(forth, part(curves, 2 * CONSTANTS * g))
        _store(back, part(curves, 2 * CONSTANTS * g + CONSTANTS))
    return able, numbers


@compiled
def at_rest(states: Floats) -> bool:
    """Whether a problem leads from rest to rest by finite displacements; states: (n, 6)."""
    for i in range(len(states)):
        if states[i, 1] != 0.0 or states[i, 2] != 0.0 or states[i, 4] != 0.0 or states[i, 5] != 0.0:
            return False
        if not abs(states[i, 3] - states[i, 0]) < inf:
            return False
    return True


@compiled
def plan_rest(
    states: Floats, numbers: Floats, minimum: float, cycle: float, count: Floats, times: Floats, jerks: Floats
) -> tuple[float, int]:
    """One problem from rest to rest.

    Args:
        states: (n, 6).
        numbers: of `rest_curves`.
        minimum, cycle: least duration, and what it is a multiple of [s]; any if zero.
        count, times, jerks: (n,), (n, 15), (n, 15), written here.

    Returns:
        The duration, infinite if a coordinate may not move; the coordinate that it is due to.
    """
    n = len(states)
    groups, curves, given = -(-n // LANES), seen(numbers), buffer(2)
    T, ruling = minimum, 0
    # 2. and 3.
    for g in range(groups):
        D = _displacements(states, g, given)
        c = _chosen(part(curves, 2 * CONSTANTS * g), D > 0.0)
        given[1] = _shortest(c, magnitude(D))
        for lane in range(min(LANES, n - g * LANES)):
            if get(given, 1, lane) > T:
                T, ruling = get(given, 1, lane), g * LANES + lane
    if not T < inf:
        return inf, ruling
    if cycle > 0.0:
        T = ceil(T / cycle * (1.0 - 1e-15)) * cycle
    # 4.
    for g in range(groups):
        D = _displacements(states, g, given)
        c = _chosen(part(curves, 2 * CONSTANTS * g), D > 0.0)
        _written(c, D, T, g * LANES, count, times, jerks)
    return T, ruling


@compiled
def _displacements(states, g, given):
    """Of eight coordinates; those that there are not are at rest."""
    given[0] = lanes(0.0)
    for lane in range(min(LANES, len(states) - g * LANES)):
        put(given, 0, lane, states[g * LANES + lane, 3] - states[g * LANES + lane, 0])
    return given[0]


@compiled
def _written(c, D, T, first, count, times, jerks):
    """The pieces of eight motions of duration T: as `coordinate_loops._parts`."""
    s, size = _motion(c, lanes(T)), magnitude(D)
    reach = _displacement(c, s)
    share = where(reach > 0.0, lesser(size / where(reach > 0.0, reach, 1.0), lanes(1.0)), 0.0)
    factor, cruises = where(D > 0.0, share, -share), s.cruise > 0.0
    pieces = buffer(9)
    pieces[0], pieces[1], pieces[3], pieces[5], pieces[6] = s.A * c.ip, s.t2, s.cruise, s.t4, s.B * c.ip
    pieces[2] = where(cruises, s.A * c.im, (s.A + s.B) * c.im)
    pieces[4] = where(cruises, s.B * c.im, 0.0)
    pieces[7], pieces[8] = factor * c.jp, -factor * c.jm
    for lane in range(min(LANES, len(count) - first)):
        i = first + lane
        for k in range(LEAD):
            times[i, k], jerks[i, k] = 0.0, 0.0
        if get(pieces, 7, lane) == 0.0:
            count[i], times[i, LEAD], jerks[i, LEAD] = LEAD + 1, T, 0.0
            continue
        count[i] = LEAD + PARTS
        for k in range(PARTS):
            times[i, LEAD + k] = get(pieces, k, lane)
        up, down = get(pieces, 7, lane), get(pieces, 8, lane)
        jerks[i, 2], jerks[i, 3], jerks[i, 4], jerks[i, 5] = up, 0.0, down, 0.0
        jerks[i, 6], jerks[i, 7], jerks[i, 8] = down, 0.0, up
