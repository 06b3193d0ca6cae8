"""Wrenches as expressions: moved between frames, and gathered along a tree from its leaves to the base."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import mafsil.expression as ex
from mafsil.mechanics.body_tree import Attachment
from mafsil.mechanics.composite_inertia import CompositeInertia
from mafsil.mechanics.placement import Expression, Placement, constant


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
