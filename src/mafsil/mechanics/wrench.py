"""Wrenches as expressions: moved between frames, and gathered along a tree from its leaves to the base.

The ground frame as the place where what belongs to different bodies comes together: origin and axes of {0}.

A wrench or a twist taken there once serves every pair that it is part of; carried from body to body it would be turned
and shifted for each. Distances from the ground enter products that later cancel, so that a wrench of a small body far
out loses about the ratio of both sizes in its last digits: tensors of inertia, where it would be the square, stay with
their bodies.

Reference: Featherstone, Rigid Body Dynamics Algorithms, sec. 2.8 and 10.3 (body and ground coordinates).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

import mafsil.expression as ex
from mafsil.mechanics.body_tree import Attachment, Body, BodyTree
from mafsil.mechanics.composite_motion import CompositeInertia
from mafsil.mechanics.placement import Expression, Placement, constant
from mafsil.model import JointKind


@dataclass(frozen=True, slots=True)
class Wrench:
    """A moment about the origin and a force, (3,) each, in the axes of the frame at hand."""

    m: Expression
    f: Expression

    @staticmethod
    def zero() -> Wrench:
        """None at all."""
        return Wrench(ex.zeros(3, 1), ex.zeros(3, 1))

    @staticmethod
    def at(frame: Attachment, F: Expression) -> Wrench:
        """A wrench (6,) given in an attached frame, at the origin and in the axes of the body's frame."""
        R, p = constant(frame.R), constant(frame.p)
        f = R @ F[3:]
        return Wrench(R @ F[:3] + ex.cross(p, f), f)

    @staticmethod
    def of_motion(
        inertia: CompositeInertia, omega: Expression, alpha: Expression, a: Expression, spin: Expression
    ) -> Wrench:
        """What a body's motion needs, by Newton and Euler: I alpha + omega x I omega + h x a and m a + U h.

        Args:
            inertia: about the origin of {i}.
            omega, alpha, a: (3,) angular velocity and acceleration, acceleration of the origin, in {i}.
            spin: (3, 3) U = [alpha] + [omega]^2.
        """
        h, rotational = inertia.h, inertia.I
        moment = rotational @ alpha + ex.cross(omega, rotational @ omega) + ex.cross(h, a)
        return Wrench(moment, inertia.mass * a + spin @ h)

    def __add__(self, other: Wrench) -> Wrench:
        return Wrench(self.m + other.m, self.f + other.f)

    def in_parent(self, step: Placement) -> Wrench:
        """At the origin and in the axes of the parent's frame."""
        f = step.to_parent(self.f)
        return Wrench(step.to_parent(self.m) + ex.cross(step.offset, f), f)

    def along(self, step: Placement) -> Expression:
        """Its effort on the joint."""
        return step.omega * self.m[2] + step.v * self.f[2]

    def seen_from(self, frame: Attachment) -> Expression:
        """(6,) at the origin and in the axes of an attached frame: the inverse of `at`."""
        R, p = constant(frame.R), constant(frame.p)
        return ex.vertcat(R.T @ (self.m - ex.cross(p, self.f)), R.T @ self.f)


def transmitted_wrenches(
    parents: Sequence[int], needs: Sequence[Wrench], passed_on: Callable[[int, Wrench], Wrench]
) -> list[Wrench]:
    """What each part of a tree gets from the one before it: its own need and all that the parts behind it get from it.

    F_k = need_k + sum over the children c of F_c seen from k

    Args:
        parents: index of the part that carries part k; before k. The first part is the root.
        needs: of each part alone.
        passed_on: (k, F_k) to F_k seen from the parent of k.
    """
    total = list(needs)
    for k in reversed(range(1, len(total))):
        total[parents[k]] = total[parents[k]] + passed_on(k, total[k])
    return total


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
