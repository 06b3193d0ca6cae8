"""Balls and free bodies without angles: conditions on points instead, so that nothing locks and rods do not spin.

A ball that closes a loop asks that a point of one body is at a point of another: three conditions, where its angles
would be three coordinates in six. A body that two balls hold, and nothing else, asks that two points keep their
distance: how it spins about its own line is nobody's business. Three balls hold a body as three distances do, for a
triangle with these sides can stand in one way only where its corners are. What hangs on other balls, or floats, has the
places of three of its points as coordinates.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import combinations

import numpy as np

from mafsil.arrays import Floats, frozen
from mafsil.errors import ModelError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import pose
from mafsil.mobility.bodies.three_points import triangle
from mafsil.mobility.linkages.linkage import Linkage, PointPair
from mafsil.mobility.linkages.linkage_joint import Kind, LinkageJoint
from mafsil.mobility.linkages.loop_closure import body_poses
from mafsil.mobility.tolerances import IN_SUPPORT

Balls = tuple[LinkageJoint, ...]
LOCKING = (Kind.SPHERICAL, Kind.FLOATING)
"""Kinds whose angles lock somewhere."""


def without_balls(linkage: Linkage) -> Linkage:
    """A linkage with conditions on points instead of balls, and places of points for what hangs on balls or floats.

    1. Bodies on two or three balls become pairs of points that keep their distance, other balls pairs that meet.
    2. Floating joints ask nothing.
    3. Of what then hangs together without the ground, one body stands where three of its points are.

    Args:
        linkage: as drawn.

    Raises:
        ModelError: a rod between two balls that holds on to another such rod; the sentence names the joint.
    """
    if not any(each.kind in LOCKING for each in linkage.joints):
        return linkage
    balls = [each for each in linkage.joints if each.kind is Kind.SPHERICAL]
    held = _held_by_balls(linkage)  # 1
    pairs = [pair for body, ends in held.items() for pair in _distances(body, ends)]
    single = [each for each in balls if not {each.parent, each.child} & held.keys()]
    pairs += [PointPair((b.parent, b.child), _points(b, b.parent), 0.0, (b.name,)) for b in single]
    bodies = tuple(body for body in linkage.bodies if body not in held)
    joints = tuple(each for each in linkage.joints if each.kind not in LOCKING)  # 2
    output = linkage.output if linkage.output in bodies else bodies[-1]
    apart = {name: X for name, X in linkage.apart.items() if name in {each.name for each in joints}}
    moving = tuple(pair for pair in pairs if pair.bodies[0] != pair.bodies[1])
    found = replace(linkage, bodies=bodies, joints=joints, output=output, apart=apart, pairs=moving)
    while loose := [body for body, reached in zip(bodies, found.reached, strict=True) if not reached]:  # 3
        found = replace(found, joints=(*found.joints, _by_points(linkage, loose[0])))
    return found


def without_balls_at(linkage: Linkage, theta: Floats) -> Floats:
    """Coordinates of `without_balls(linkage)`, of coordinates (F,) of the linkage."""
    simple, poses = without_balls(linkage), body_poses(linkage, theta)
    own = list[Floats]()
    for each in simple.joints:
        if each.corners is None:
            own.append(theta[linkage.columns_of([each.name])])
        else:
            moved = np.asarray(pose.act(poses[linkage.bodies.index(each.child)], each.corners))
            own.append((moved - each.corners).reshape(-1))
    return np.concatenate(own)


def _by_points(linkage: Linkage, body: str) -> LinkageJoint:
    """What holds a free body on the ground without asking anything: three points of it as its coordinates.

    Raises:
        ModelError: a rod, which has no more than two points that matter.
    """
    ends = [each for each in linkage.joints if body in (each.parent, each.child)]
    if len(ends) == 2 and all(each.kind is Kind.SPHERICAL for each in ends):
        raise ModelError("mobility.surface_rods", body=body, joint=ends[0].name)
    floating = [each.name for each in ends if each.kind is Kind.FLOATING and each.child == body]
    names = {each.name for each in linkage.joints}
    name = floating[0] if floating else f"{body} *" if body in names else body
    held = [each for each in ends if each.kind is not Kind.FLOATING]
    places = [_points(each, body)[0] if each.kind is Kind.SPHERICAL else each.point for each in held]
    corners = triangle(np.mean(places or [linkage.middle], axis=0), linkage.size)
    return LinkageJoint(name, Kind.FLOATING, linkage.ground, body, corners=corners)


def _held_by_balls(linkage: Linkage) -> dict[str, Balls]:
    """Bodies that two or three balls hold and nothing else, not on one line; no two of them beside each other."""
    found: dict[str, Balls] = {}
    for body in linkage.bodies[1:]:
        ends = tuple(each for each in linkage.joints if body in (each.parent, each.child))
        others = {end for each in ends for end in (each.parent, each.child)} - {body}
        if all(each.kind is Kind.SPHERICAL for each in ends) and not others & found.keys() and _spread(body, ends):
            found[body] = ends
    return found


def _spread(body: str, ends: Balls) -> bool:
    """Whether balls are two apart, or three corners of a triangle."""
    if len(ends) not in (2, 3):
        return False
    places = np.array([_points(ball, body)[0] for ball in ends])
    lengths = np.linalg.svd(places[1:] - places[0], compute_uv=False)
    return bool(lengths[-1] > IN_SUPPORT * max(float(lengths[0]), LEAST_DIVISOR))


def _points(ball: LinkageJoint, first: str) -> Floats:
    """(2, 3) the ball's place on a body that it holds, then on the other [m], where they are drawn."""
    on_child = ball.point if ball.child_point is None else ball.child_point
    return frozen(np.stack([ball.point, on_child] if first == ball.parent else [on_child, ball.point]))


def _distances(body: str, ends: Balls) -> list[PointPair]:
    """What a body asks of those that its balls hold: each two of their points keep their distance on it."""
    found: list[PointPair] = []
    for pair in combinations(ends, 2):
        (own, other), (own_too, other_too) = (_points(ball, body) for ball in pair)
        a, b = (ball.child if ball.parent == body else ball.parent for ball in pair)
        length = float(np.linalg.norm(own - own_too))
        found.append(PointPair((a, b), frozen(np.stack([other, other_too])), length, tuple(x.name for x in pair)))
    return found
