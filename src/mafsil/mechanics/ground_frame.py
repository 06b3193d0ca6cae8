"""The ground frame as the place where what belongs to different bodies comes together: origin and axes of {0}.

A wrench or a twist taken there once serves every pair that it is part of; carried from body to body it would be turned
and shifted for each. Distances from the ground enter products that later cancel, so that a wrench of a small body far
out loses about the ratio of both sizes in its last digits: tensors of inertia, where it would be the square, stay with
their bodies.

Reference: Featherstone, Rigid Body Dynamics Algorithms, sec. 2.8 and 10.3 (body and ground coordinates).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

import mafsil.expression as ex
from mafsil.mechanics.body_tree import Body, BodyTree
from mafsil.mechanics.placement import Expression
from mafsil.mechanics.wrench import Wrench
from mafsil.model import JointKind

CLEARLY = 0.75
"""Share of the products from body to body below which the ground frame is chosen."""


class Screw(NamedTuple):
    """Angular and linear part of a twist or an acceleration, (3,) each, the linear part at the origin."""

    angular: Expression
    linear: Expression


def twist_at_ground(angular: Expression, linear: Expression, o: Expression) -> Screw:
    """A twist (angular, linear) at o, taken to the origin of {0}; all (3,) in the axes of {0}."""
    return Screw(angular, linear + ex.cross(o, angular))


def wrench_at_ground(wrench: Wrench, o: Expression) -> Wrench:
    """A wrench about o, about the origin of {0}; all in the axes of {0}."""
    return Wrench(wrench.m + ex.cross(o, wrench.f), wrench.f)


def along(wrench: Wrench, screw: Screw) -> Expression:
    """Power of the wrench along the twist."""
    return ex.dot(wrench.m, screw.angular) + ex.dot(wrench.f, screw.linear)


def ground_is_shorter(tree: BodyTree, wrenches: int, rows: int) -> bool:
    """Whether pairs of joints take clearly fewer products in the ground frame than from body to body.

    Args:
        tree: the bodies.
        wrenches: how many of each joint take part.
        rows: how many rows of an angular change do.
    """
    steps = [(_turn(body), _shift(body)) for body in tree.bodies]
    walked, ground = 0, 0
    for i, _ in tree.moving:
        turn, shift = steps[i]
        ground += 3 * turn + shift + 6 + 24 * wrenches + 15 * rows
        for j in tree.path(i)[1:]:
            turn, shift = steps[j]
            walked += wrenches * (2 * turn + shift) + rows * (turn + 16)
            ground += 6 * wrenches + 18 * rows
    return ground < CLEARLY * walked


def _turn(body: Body) -> int:
    """Products that turn a vector from the body's frame to its parent's."""
    plain = np.isin(body.R, (-1.0, 0.0, 1.0))
    return int((~plain).sum()) + 4 * (body.kind is not JointKind.PRISMATIC)


def _shift(body: Body) -> int:
    """Products that move a wrench from the body's origin to its parent's."""
    return 2 * int(np.count_nonzero(body.p)) if body.kind is JointKind.REVOLUTE else 6
