"""Which closed form solves an arm? Read from its axes: which are parallel, which meet, and how far they are from it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from mafsil.arrays import Vector3
from mafsil.ik.chain import Chain, common_point, distance_to_line, meeting_point
from mafsil.ik.tolerances import COINCIDENT, CONDITIONED, DEFECT, FLAT_CIRCLE, SNAP, WELL_POSED
from mafsil.mechanics.arm_pattern import ArmPattern, Family, PositioningMethod

ALMOST_IDEAL = 0.03
"""Defects up to which the nearest ideal arm's closed form gives seeds that are refined."""


@dataclass(frozen=True, eq=False)
class _Positioning:
    """How three joints place a point, and how far they are from the conditions."""

    positioning: PositioningMethod
    reversed: bool
    meeting: Vector3
    defect: float
    conditioning: float = 1.0


_NO_POSITIONING = _Positioning(PositioningMethod.PARALLEL, False, np.zeros(3), 0.0)


def recognise(chain: Chain, n: int, *, orientation: bool = True) -> ArmPattern | None:
    """The closed form of an arm, exact if there is one, else the nearest within `ALMOST_IDEAL`; None without.

    A simple family within `SNAP` comes before an exact one of fourth degree.

    Args:
        chain: of the robot, base first; 1 to 6 joints.
        n: number of coordinates of the robot.
        orientation: whether the tip's orientation is asked for, or only its position.
    """
    candidates = patterns_with_orientation(chain, n) if orientation else point_patterns(chain, n)
    best: ArmPattern | None = None
    for pattern in candidates:
        if pattern.defect <= DEFECT:
            snapped = pattern.quartic and best is not None and best.defect <= SNAP and not best.quartic
            return best if snapped else pattern
        if pattern.defect <= ALMOST_IDEAL and (best is None or pattern.defect < best.defect):
            best = pattern
    return best


def patterns_with_orientation(chain: Chain, n: int) -> Iterator[ArmPattern]:
    """Every way to see the arm, the simplest closed forms first."""
    yield from _planar(chain, n)
    padded = [arm for seen in (chain, chain.backwards()) for arm in _pad(seen)]
    for general in (False, True):
        for shifted in (False, True):
            for arm in padded:
                seen = _shift(arm) if shifted else arm
                if not general:
                    yield from _three_parallel(seen, n, shifted=shifted)
                yield from _spherical_wrist(seen, n, general=general, shifted=shifted)
                if general:
                    yield from _link(seen, n, shifted=shifted)


def point_patterns(chain: Chain, n: int) -> Iterator[ArmPattern]:
    """Closed forms for the position of the tip, which three joints move."""
    tip = chain.home[:3, 3]
    for general in (False, True):
        for arm in _three_joints(chain):
            for positioning in _positionings(arm, tip, general=general):
                yield _pattern(Family.POINT, arm, n, tip, positioning, positioning.defect)


def _shift(chain: Chain) -> Chain:
    """The chain with its last joint in front: (P e_m P^-1) e_1 ... e_m-1 = P."""
    order = [len(chain) - 1, *range(len(chain) - 1)]
    return replace(
        chain,
        axes=chain.axes[order],
        points=chain.points[order],
        prismatic=tuple(chain.prismatic[i] for i in order),
        joints=tuple(chain.joints[i] for i in order),
    )


def _spherical_wrist(chain: Chain, n: int, *, general: bool, shifted: bool) -> Iterator[ArmPattern]:
    """The last three axes meet, not all in one plane with nothing between."""
    if any(chain.prismatic[3:]):
        return
    centre, gap = common_point(chain.axes[3:], chain.points[3:])
    if not np.isfinite(centre).all():
        return
    w4, w5, w6 = chain.axes[3:]
    if min(_sine(w4, w5), _sine(w5, w6)) < WELL_POSED:
        return
    if (
        not shifted
        and not chain.prismatic[2]
        and distance_to_line(chain.axes[2], chain.points[2], centre) < COINCIDENT * chain.size
    ):
        # Four axes through one point: the third joint does not move it.
        return
    for positioning in _positionings(_part(chain, 0, 3), centre, general=general, carried=shifted):
        defect = max(positioning.defect, gap / chain.size)
        yield _pattern(Family.SPHERICAL_WRIST, chain, n, centre, positioning, defect, shifted=shifted)


def _three_parallel(chain: Chain, n: int, *, shifted: bool) -> Iterator[ArmPattern]:
    """Axes 2, 3, 4 are parallel, 5 and 6 meet."""
    if any(chain.prismatic[1:]):
        return
    w1, w2, w3, w4, w5, w6 = chain.axes
    if min(_sine(w2, w5), _sine(w5, w6)) < WELL_POSED:
        return
    centre, gap = meeting_point(w5, chain.points[4], w6, chain.points[5])
    usable = abs(w1 @ w2) > WELL_POSED if chain.prismatic[0] else _sine(w1, w2) > WELL_POSED
    if usable or shifted:
        defect = max(_sine(w2, w3), _sine(w2, w4), gap / chain.size)
        yield _pattern(Family.THREE_PARALLEL, chain, n, centre, _NO_POSITIONING, defect, shifted=shifted)


def _link(chain: Chain, n: int, *, shifted: bool) -> Iterator[ArmPattern]:
    """Axes 2, 3, 4 are parallel; 5 and 6 pass each other."""
    if any(chain.prismatic[1:]):
        return
    w1, w2, w3, w4, w5, w6 = chain.axes
    c, r5 = chain.points[5], chain.points[4]
    if min(_sine(w2, w5), _sine(w5, w6)) < WELL_POSED or any(j < 0 for j in chain.joints[1:]):
        return
    usable = abs(w1 @ w2) > WELL_POSED if chain.prismatic[0] else _sine(w1, w2) > WELL_POSED
    # The circle of joint 5 in the two equations must not be flat.
    k = c - r5
    B = np.array([_form(-w5, w6, w2), _form(w5, w2, k) / chain.size])
    if (usable or shifted) and (chain.prismatic[0] or abs(np.linalg.det(B)) > FLAT_CIRCLE):
        defect = max(_sine(w2, w3), _sine(w2, w4))
        yield _pattern(Family.LINKED, chain, n, c, _NO_POSITIONING, defect, shifted=shifted)


def _form(w: Vector3, a: Vector3, x: Vector3) -> Vector3:
    """(2) coefficients of cos q and sin q in a . Rot(w, q) x."""
    return np.array([a @ x - (w @ a) * (w @ x), a @ np.cross(w, x)])


def _planar(chain: Chain, n: int) -> Iterator[ArmPattern]:
    """Two or three parallel revolute axes, at most one prismatic joint along them."""
    revolute = [i for i in range(len(chain)) if not chain.prismatic[i]]
    sliding = [i for i in range(len(chain)) if chain.prismatic[i]]
    if len(revolute) not in (2, 3) or len(sliding) > 1:
        return
    order = [*revolute, *sliding]
    arm = Chain(
        chain.axes[order],
        chain.points[order],
        tuple(chain.prismatic[i] for i in order),
        tuple(chain.joints[i] for i in order),
        chain.home,
    )
    h = arm.axes[0]
    defect = max(_sine(h, w) for w in arm.axes)
    if len(revolute) == 2:
        arm = arm.with_joint(arm.axes[1], chain.home[:3, 3], at=2)
    if not sliding:
        arm = arm.with_joint(h, np.zeros(3), prismatic=True)
    if distance_to_line(arm.axes[1], arm.points[1], arm.points[2]) < DEFECT * chain.size:
        return
    yield _pattern(Family.PLANAR, arm, n, arm.points[2], _NO_POSITIONING, defect)


def _positionings(arm: Chain, start: Vector3, *, general: bool, carried: bool = False) -> Iterator[_Positioning]:
    """Ways in which three joints place a point, forwards and backwards.

    Args:
        arm: the joints.
        start: (3,) the point at q = 0.
        general: the equation of fourth degree, or the simpler ways.
        carried: the first joint is carried by the pose: nothing can be said of it beforehand.
    """
    if general:
        if carried:
            yield from _by_quartic(arm.backwards(), True, start, carried=True)
        else:
            # The better conditioned side first.
            sides = [*_by_quartic(arm, False, start), *_by_quartic(arm.backwards(), True, start)]
            yield from sorted(sides, key=lambda positioning: -positioning.conditioning)
        return
    if carried:
        if not arm.prismatic[0]:
            yield from _by_height(arm, False, carried=True)
        yield from _by_distance(arm.backwards(), True, carried=True)
        return
    if all(arm.prismatic):
        if abs(np.linalg.det(arm.axes)) > WELL_POSED:
            yield _Positioning(PositioningMethod.LINEAR, False, np.zeros(3), 0.0)
        return
    for backwards in (False, True):
        seen = arm.backwards() if backwards else arm
        yield from _by_height(seen, backwards)
    for backwards in (False, True):
        seen = arm.backwards() if backwards else arm
        yield from _by_distance(seen, backwards)
    for backwards in (False, True):
        seen = arm.backwards() if backwards else arm
        yield from _by_perpendicular_prismatic(seen, backwards)


def _by_quartic(arm: Chain, backwards: bool, start: Vector3, *, carried: bool = False) -> Iterator[_Positioning]:
    """The first two joints in general position; the third off the point, if it turns.

    Of a reversed arm nothing is known of the place that the third joint moves, but that it is not always on its axis.
    """
    w1, w2, w3 = arm.axes
    one, two, three = arm.prismatic
    if not backwards and not three and distance_to_line(w3, arm.points[2], start) < COINCIDENT * arm.size:
        return
    sine, cosine = _sine(w1, w2), abs(float(w1 @ w2))
    if one and two:
        normal = np.asarray(np.cross(w1, w2), dtype=np.float64)
        conditioning = sine if carried or three or _sine(normal, w3) > WELL_POSED else 0.0
        conditioning *= 1.0 if carried or not three or abs(np.linalg.det(arm.axes)) > WELL_POSED else 0.0
    elif one or two:
        conditioning = cosine
    else:
        conditioning = 0.0
        if sine > CONDITIONED:
            _, gap = meeting_point(w1, arm.points[0], w2, arm.points[1])
            conditioning = sine * gap / arm.size
    if conditioning > CONDITIONED:
        yield _Positioning(PositioningMethod.QUARTIC, backwards, np.zeros(3), 0.0, conditioning)


def _by_perpendicular_prismatic(arm: Chain, backwards: bool) -> Iterator[_Positioning]:
    """The first joint turns, the second slides across its axis, the third changes the height along it."""
    w1, w2, w3 = arm.axes
    if arm.prismatic[0] or not arm.prismatic[1]:
        return
    if abs(w1 @ w3) > WELL_POSED if arm.prismatic[2] else _sine(w1, w3) > WELL_POSED:
        yield _Positioning(PositioningMethod.ACROSS, backwards, np.zeros(3), abs(float(w1 @ w2)))


def _by_height(arm: Chain, backwards: bool, *, carried: bool = False) -> Iterator[_Positioning]:
    """The second joint turns; the third turns about a parallel axis or is prismatic across it."""
    w1, h, w3 = arm.axes
    if arm.prismatic[1]:
        return
    usable = carried or (abs(w1 @ h) > WELL_POSED if arm.prismatic[0] else _sine(w1, h) > WELL_POSED)
    apart = arm.prismatic[2] or distance_to_line(h, arm.points[1], arm.points[2]) > COINCIDENT * arm.size
    if usable and apart:
        yield _Positioning(
            PositioningMethod.PARALLEL, backwards, np.zeros(3), abs(float(h @ w3)) if arm.prismatic[2] else _sine(h, w3)
        )


def _by_distance(arm: Chain, backwards: bool, *, carried: bool = False) -> Iterator[_Positioning]:
    """The first two axes meet, and the third moves the point nearer to there or away."""
    if arm.prismatic[0] or arm.prismatic[1] or _sine(arm.axes[0], arm.axes[1]) < WELL_POSED:
        return
    place, gap = meeting_point(arm.axes[0], arm.points[0], arm.axes[1], arm.points[1])
    if (
        not (carried or arm.prismatic[2])
        and distance_to_line(arm.axes[2], arm.points[2], place) < COINCIDENT * arm.size
    ):
        return
    yield _Positioning(PositioningMethod.MEET, backwards, place, gap / arm.size)


def _pad(chain: Chain) -> Iterator[Chain]:
    """Six joints: the chain itself, or with joints added at its end that must stand still."""
    if len(chain) == 6:
        yield chain
    elif len(chain) == 5:
        yield from _sixth(chain)
    elif len(chain) == 4 and not chain.prismatic[3]:
        w = chain.axes[3]
        # Anywhere on the axis will do; far from special places.
        place = chain.points[3] + 0.37 * chain.size * w
        yield from _sixth(chain.with_joint(_normal(w), place))
        yield from _sixth(chain.with_joint(_normal(w), _tip(chain)))
    elif len(chain) <= 3:
        w_last = chain.axes[-1]
        for arm in _three_joints(chain):
            place = _tip(chain)
            if not chain.prismatic[-1] and distance_to_line(w_last, chain.points[-1], place) < WELL_POSED * chain.size:
                # A point on the last axis would not see that joint turn; any other of the tip will do.
                place = place + 0.5 * chain.size * _normal(w_last)
            w = _normal(arm.axes[2] + np.array([0.1, 0.2, 0.3]))
            five = arm.with_joint(w, place).with_joint(_normal(w), place)
            yield five.with_joint(_third(w), place)


def _sixth(chain: Chain) -> Iterator[Chain]:
    """A sixth axis through the meeting point of the last two, or through the fifth."""
    w4, w5 = chain.axes[3], chain.axes[4]
    if chain.prismatic[4]:
        return
    if not chain.prismatic[3] and _sine(w4, w5) > WELL_POSED:
        place, _ = meeting_point(w4, chain.points[3], w5, chain.points[4])
        across = np.asarray(np.cross(w4, w5), dtype=np.float64)
        yield chain.with_joint(across, place)
    if _sine(chain.axes[1], w5) > WELL_POSED:
        across = np.asarray(np.cross(chain.axes[1], w5), dtype=np.float64)
        yield chain.with_joint(across, chain.points[4] + 0.37 * chain.size * w5)


def _three_joints(chain: Chain) -> Iterator[Chain]:
    """The chain, or with added joints that must stand still."""
    w = chain.axes[-1]
    if len(chain) == 3:
        yield chain
    elif len(chain) == 2:
        yield chain.with_joint(w, np.zeros(3), prismatic=True)
        yield chain.with_joint(chain.axes[0], np.zeros(3), prismatic=True, at=0)
        yield chain.with_joint(_normal(w), chain.points[1])
        yield chain.with_joint(np.cross(w, chain.axes[0]) + 0.1 * w, np.zeros(3), prismatic=True)
    elif chain.prismatic[0]:
        one = chain.with_joint(_normal(w), np.zeros(3), prismatic=True)
        yield one.with_joint(_third(w), np.zeros(3), prismatic=True)
    else:
        across = _tip(chain) - chain.points[0]
        across = across - (across @ w) * w
        across = across if np.linalg.norm(across) > COINCIDENT * chain.size else _normal(w)
        yield chain.with_joint(w, np.zeros(3), prismatic=True, at=0).with_joint(across, np.zeros(3), prismatic=True)


def _pattern(
    family: Family,
    chain: Chain,
    n: int,
    centre: Vector3,
    positioning: _Positioning,
    defect: float,
    *,
    shifted: bool = False,
) -> ArmPattern:
    return ArmPattern(
        family=family,
        axes=chain.axes,
        points=chain.points,
        prismatic=chain.prismatic,
        joints=chain.joints,
        home=chain.home,
        reversed=chain.reversed,
        centre=centre,
        positioning=positioning.positioning,
        positioning_reversed=positioning.reversed,
        meeting=positioning.meeting,
        size=chain.size,
        n=n,
        defect=defect,
        shifted=shifted,
    )


def _part(chain: Chain, begin: int, end: int) -> Chain:
    return Chain(
        chain.axes[begin:end],
        chain.points[begin:end],
        chain.prismatic[begin:end],
        chain.joints[begin:end],
        chain.home,
        chain.reversed,
    )


def _tip(chain: Chain) -> Vector3:
    """The tip's origin; for a chain seen from the tip the origin of the base."""
    return np.zeros(3) if chain.reversed else chain.home[:3, 3]


def _sine(a: Vector3, b: Vector3) -> float:
    return float(np.linalg.norm(np.cross(a, b)))


def _third(w: Vector3) -> Vector3:
    """A unit vector normal to w and to its `_normal`."""
    return np.asarray(np.cross(w, _normal(w)) / np.linalg.norm(w), dtype=np.float64)


def _normal(w: Vector3) -> Vector3:
    """A unit vector normal to w."""
    other = np.eye(3)[int(np.abs(w).argmin())]
    normal = np.cross(w, other)
    return np.asarray(normal / np.linalg.norm(normal), dtype=np.float64)
