"""Which closed form solves an arm? Read from its axes: which are parallel, which meet, and how far they miss it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Vector3
from mafsil.ik.chain import Chain, common_point, distance_to_line, meeting_point
from mafsil.mechanics.arm_pattern import ArmPattern, Family, PointRoad

EXACT = 1e-9
"""Defects [rad, and m relative to the arm's size] that are rounding: the closed form is the arm's own."""

NEAR = 0.03
"""Defects up to which the nearest ideal arm's closed form gives seeds that are refined."""


@dataclass(frozen=True, eq=False)
class _Road:
    """How three joints place a point, and by how much they miss the conditions."""

    road: PointRoad
    reversed: bool
    meeting: Vector3
    defect: float


def recognise(chain: Chain, n: int, *, orientation: bool = True) -> ArmPattern | None:
    """The closed form of an arm, exact if there is one, else the nearest within `NEAR`; None without.

    Args:
        chain: of the robot, base first; 1 to 6 joints.
        n: number of coordinates of the robot.
        orientation: whether the tip's orientation is asked for, or only its position.
    """
    candidates = _with_orientation(chain, n) if orientation else _points(chain, n)
    best: ArmPattern | None = None
    for pattern in candidates:
        if pattern.defect <= EXACT:
            return pattern
        if pattern.defect <= NEAR and (best is None or pattern.defect < best.defect):
            best = pattern
    return best


def _with_orientation(chain: Chain, n: int) -> Iterator[ArmPattern]:
    yield from _planar(chain, n)
    for seen in (chain, chain.backwards()):
        for padded in _padded(seen):
            yield from _spherical_wrist(padded, n)
            yield from _three_parallel(padded, n)


def _points(chain: Chain, n: int) -> Iterator[ArmPattern]:
    tip = chain.home[:3, 3]
    for arm in _three_joints(chain):
        for road in _roads(arm, tip):
            yield _pattern(Family.POINT, arm, n, tip, road, road.defect)


def _spherical_wrist(chain: Chain, n: int) -> Iterator[ArmPattern]:
    """The last three axes meet, not all in one plane with nothing between."""
    if any(chain.slides[3:]):
        return
    centre, miss = common_point(chain.axes[3:], chain.points[3:])
    if not np.isfinite(centre).all():
        return
    w4, w5, w6 = chain.axes[3:]
    if min(_sine(w4, w5), _sine(w5, w6)) < 1e-3:
        return
    for road in _roads(_part(chain, 0, 3), centre):
        yield _pattern(Family.SPHERICAL_WRIST, chain, n, centre, road, max(road.defect, miss / chain.size))


def _three_parallel(chain: Chain, n: int) -> Iterator[ArmPattern]:
    """Axes 2, 3, 4 are parallel, 5 and 6 meet."""
    if any(chain.slides[1:]):
        return
    w1, w2, w3, w4, w5, w6 = chain.axes
    if min(_sine(w2, w5), _sine(w5, w6)) < 1e-3:
        return
    centre, gap = meeting_point(w5, chain.points[4], w6, chain.points[5])
    usable = abs(w1 @ w2) > 1e-3 if chain.slides[0] else _sine(w1, w2) > 1e-3
    if usable:
        defect = max(_sine(w2, w3), _sine(w2, w4), gap / chain.size)
        road = _Road(PointRoad.PARALLEL, False, np.zeros(3), 0.0)
        yield _pattern(Family.THREE_PARALLEL, chain, n, centre, road, defect)


def _planar(chain: Chain, n: int) -> Iterator[ArmPattern]:
    """Two or three parallel turning axes, at most one slide along them."""
    turning = [i for i in range(len(chain)) if not chain.slides[i]]
    sliding = [i for i in range(len(chain)) if chain.slides[i]]
    if len(turning) not in (2, 3) or len(sliding) > 1:
        return
    order = [*turning, *sliding]
    arm = Chain(
        chain.axes[order],
        chain.points[order],
        tuple(chain.slides[i] for i in order),
        tuple(chain.joints[i] for i in order),
        chain.home,
    )
    h = arm.axes[0]
    defect = max(_sine(h, w) for w in arm.axes)
    if len(turning) == 2:
        arm = arm.with_joint(arm.axes[1], chain.home[:3, 3], at=2)
    if not sliding:
        arm = arm.with_joint(h, np.zeros(3), slides=True)
    if distance_to_line(arm.axes[1], arm.points[1], arm.points[2]) < 1e-9 * chain.size:
        return
    yield _pattern(Family.PLANAR, arm, n, arm.points[2], _Road(PointRoad.PARALLEL, False, np.zeros(3), 0.0), defect)


def _roads(arm: Chain, start: Vector3) -> Iterator[_Road]:
    """Ways in which three joints place a point, forwards and backwards."""
    if all(arm.slides):
        if abs(np.linalg.det(arm.axes)) > 1e-3:
            yield _Road(PointRoad.LINEAR, False, np.zeros(3), 0.0)
        return
    for backwards in (False, True):
        seen = arm.backwards() if backwards else arm
        yield from _by_height(seen, backwards)
    for backwards in (False, True):
        seen = arm.backwards() if backwards else arm
        yield from _by_distance(seen, backwards)


def _by_height(arm: Chain, backwards: bool) -> Iterator[_Road]:
    """The second joint turns; the third turns about a parallel axis or slides across it."""
    w1, h, w3 = arm.axes
    if arm.slides[1]:
        return
    usable = abs(w1 @ h) > 1e-3 if arm.slides[0] else _sine(w1, h) > 1e-3
    apart = arm.slides[2] or distance_to_line(h, arm.points[1], arm.points[2]) > 1e-6 * arm.size
    if usable and apart:
        yield _Road(PointRoad.PARALLEL, backwards, np.zeros(3), abs(float(h @ w3)) if arm.slides[2] else _sine(h, w3))


def _by_distance(arm: Chain, backwards: bool) -> Iterator[_Road]:
    """The first two axes meet, and the third moves the point nearer to there or away."""
    if arm.slides[0] or arm.slides[1] or _sine(arm.axes[0], arm.axes[1]) < 1e-3:
        return
    place, gap = meeting_point(arm.axes[0], arm.points[0], arm.axes[1], arm.points[1])
    if not arm.slides[2] and distance_to_line(arm.axes[2], arm.points[2], place) < 1e-6 * arm.size:
        return
    yield _Road(PointRoad.MEET, backwards, place, gap / arm.size)


def _padded(chain: Chain) -> Iterator[Chain]:
    """Six joints: the chain itself, or with joints added at its end that must stand still."""
    if len(chain) == 6:
        yield chain
    elif len(chain) == 5:
        yield from _sixth(chain)
    elif len(chain) == 4 and not chain.slides[3]:
        w = chain.axes[3]
        # Anywhere on the axis will do; far from special places.
        place = chain.points[3] + 0.37 * chain.size * w
        yield from _sixth(chain.with_joint(_normal(w), place))
        yield from _sixth(chain.with_joint(_normal(w), _tip(chain)))
    elif len(chain) <= 3:
        for arm in _three_joints(chain):
            place = _tip(chain)
            w = _normal(arm.axes[2] + np.array([0.1, 0.2, 0.3]))
            five = arm.with_joint(w, place).with_joint(_normal(w), place)
            yield five.with_joint(np.cross(w, _normal(w)), place)


def _sixth(chain: Chain) -> Iterator[Chain]:
    """A sixth axis through the meeting point of the last two, or through the fifth."""
    w4, w5 = chain.axes[3], chain.axes[4]
    if chain.slides[4]:
        return
    if not chain.slides[3] and _sine(w4, w5) > 1e-3:
        place, _ = meeting_point(w4, chain.points[3], w5, chain.points[4])
        yield chain.with_joint(np.cross(w4, w5), place)
    if _sine(chain.axes[1], w5) > 1e-3:
        yield chain.with_joint(np.cross(chain.axes[1], w5), chain.points[4] + 0.37 * chain.size * w5)


def _three_joints(chain: Chain) -> Iterator[Chain]:
    """The chain, or with added joints that must stand still."""
    w = chain.axes[-1]
    if len(chain) == 3:
        yield chain
    elif len(chain) == 2:
        yield chain.with_joint(w, np.zeros(3), slides=True)
        yield chain.with_joint(chain.axes[0], np.zeros(3), slides=True, at=0)
        yield chain.with_joint(_normal(w), chain.points[1])
        yield chain.with_joint(np.cross(w, chain.axes[0]) + 0.1 * w, np.zeros(3), slides=True)
    elif chain.slides[0]:
        one = chain.with_joint(_normal(w), np.zeros(3), slides=True)
        yield one.with_joint(np.cross(w, _normal(w)), np.zeros(3), slides=True)
    else:
        across = _tip(chain) - chain.points[0]
        across = across - (across @ w) * w
        across = across if np.linalg.norm(across) > 1e-6 * chain.size else _normal(w)
        yield chain.with_joint(w, np.zeros(3), slides=True, at=0).with_joint(across, np.zeros(3), slides=True)


def _pattern(family: Family, chain: Chain, n: int, centre: Vector3, road: _Road, defect: float) -> ArmPattern:
    return ArmPattern(
        family=family,
        axes=chain.axes,
        points=chain.points,
        slides=chain.slides,
        joints=chain.joints,
        home=chain.home,
        reversed=chain.reversed,
        centre=centre,
        road=road.road,
        road_reversed=road.reversed,
        meeting=road.meeting,
        size=chain.size,
        n=n,
        defect=defect,
    )


def _part(chain: Chain, begin: int, end: int) -> Chain:
    return Chain(
        chain.axes[begin:end],
        chain.points[begin:end],
        chain.slides[begin:end],
        chain.joints[begin:end],
        chain.home,
        chain.reversed,
    )


def _tip(chain: Chain) -> Vector3:
    """The tip's origin; for a chain seen from the tip the origin of the base."""
    return np.zeros(3) if chain.reversed else chain.home[:3, 3]


def _sine(a: Vector3, b: Vector3) -> float:
    return float(np.linalg.norm(np.cross(a, b)))


def _normal(w: Vector3) -> Vector3:
    """A unit vector normal to w."""
    other = np.eye(3)[int(np.abs(w).argmin())]
    normal = np.cross(w, other)
    return normal / np.linalg.norm(normal)
