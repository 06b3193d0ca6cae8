"""Where the bodies stand for given joint coordinates: turns about z and constant poses, kept factored."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi
from typing import TypeAlias

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.mechanics.body_tree import Attachment, Body, BodyTree
from mafsil.mechanics.tolerances import TYPED
from mafsil.model import JointKind
from mafsil.model.joint import differentiate, polynomial

Expression: TypeAlias = ex.Expression
"""A scalar, column vector or matrix."""
Factor: TypeAlias = ex.Expression | float
"""A scalar that is a number wherever no joint follows another along a curve."""


@dataclass(frozen=True, slots=True)
class Placement:
    """Pose of a body's frame {i} in its parent's frame {p}: constant R, p, then the joint.

    A vector goes `to_child` by R(q)' R' x and `to_parent` by R R(q) x: two cheap turns instead of one full product.

    Attributes:
        R: constant rotation (sparse: its zeros are structural).
        cosine, sine: of the joint angle; 1 and 0 for a prismatic joint.
        offset: (3,) origin of {i} in {p} [m].
        omega, v: angular and linear part of the joint's screw along z.
        slopes: first to third derivative of the joint's own value by the coordinate that moves it.
    """

    R: Expression
    cosine: Expression
    sine: Expression
    offset: Expression
    omega: float
    v: float
    slopes: tuple[Factor, Factor, Factor] = (1.0, 0.0, 0.0)

    def to_child(self, x: Expression) -> Expression:
        """A vector given in {p}, in {i}."""
        x = self.R.T @ x
        return ex.vertcat(
            self.cosine * x[0] + self.sine * x[1],
            self.cosine * x[1] - self.sine * x[0],
            x[2],
        )

    def to_parent(self, x: Expression) -> Expression:
        """A vector given in {i}, in {p}."""
        return self.R @ ex.vertcat(
            self.cosine * x[0] - self.sine * x[1],
            self.sine * x[0] + self.cosine * x[1],
            x[2],
        )


def placements(tree: BodyTree, q: Expression) -> list[Placement]:
    """Placements of all bodies, the base's (unused) first.

    Args:
        tree: the bodies.
        q: (n,) joint coordinates [rad | m].
    """
    return [_placement(tree.bodies[0], ex.zeros(1)), *(_placement(body, q[body.coordinate]) for _, body in tree.moving)]


def joint_values(tree: BodyTree, steps: Sequence[Placement], x: Expression) -> list[Expression]:
    """Rates of the joints (base first) from those of the coordinates.

    Args:
        tree: the bodies.
        steps: their placements.
        x: (n,) rates of the coordinates.
    """
    return [ex.zeros(1), *(times(steps[i].slopes[0], x[body.coordinate]) for i, body in tree.moving)]


def joint_accelerations(
    tree: BodyTree, steps: Sequence[Placement], qd: Expression, qdd: Expression
) -> list[Expression]:
    """Accelerations of the joints (base first): p'(x) xdd + p''(x) xd^2 of a joint at p(x).

    Args:
        tree: the bodies.
        steps: their placements.
        qd, qdd: (n,) rates and accelerations of the coordinates.
    """
    values = joint_values(tree, steps, qdd)
    for i, body in tree.moving:
        if body.higher:
            values[i] = values[i] + steps[i].slopes[1] * qd[body.coordinate] ** 2
    return values


def coordinate_efforts(tree: BodyTree, steps: Sequence[Placement], efforts: Sequence[Expression]) -> Expression:
    """(n,) efforts of the coordinates from those of the joints: the dual of `joint_values`.

    Args:
        tree: the bodies.
        steps: their placements.
        efforts: of the joints, base first.
    """
    total: list[Expression] = [ex.Expression(0)] * tree.n
    for i, body in tree.moving:
        total[body.coordinate] = total[body.coordinate] + times(steps[i].slopes[0], efforts[i])
    return ex.vertcat(*total)


def world_placements(tree: BodyTree, steps: Sequence[Placement]) -> tuple[list[Expression], list[Expression]]:
    """Rotations and origins of all bodies in the base frame {0}: R_0i (3, 3), p_0i (3,)."""
    R, p = [ex.eye(3)], [ex.zeros(3, 1)]
    for i, body in tree.moving:
        turned, moved = pose_outward(steps[i], R[body.parent], p[body.parent])
        R.append(turned)
        p.append(moved)
    return R, p


def pose_outward(step: Placement, R: Expression, p: Expression) -> tuple[Expression, Expression]:
    """Rotation and origin of a body in some frame, from those (3, 3), (3,) of its parent there.

    Args:
        step: pose of the body in its parent.
        R, p: of the parent.
    """
    turned = R @ step.R
    around = (
        turned[:, 0] * step.cosine + turned[:, 1] * step.sine,
        turned[:, 1] * step.cosine - turned[:, 0] * step.sine,
        turned[:, 2],
    )
    return ex.horzcat(*around), p + R @ step.offset


def attached_frame(
    frame: Attachment, R: Sequence[Expression], p: Sequence[Expression]
) -> tuple[Expression, Expression]:
    """Rotation and origin of an attached frame in {0}, from the rotations R and origins p of all bodies there."""
    body = frame.body
    return R[body] @ constant(frame.R), p[body] + R[body] @ constant(frame.p)


def poses_inward(
    tree: BodyTree, steps: Sequence[Placement], frame: Attachment
) -> dict[int, tuple[Expression, Expression]]:
    """Rotation and origin of an attached frame in every body on its path, from its own body back to the base {0}.

    Args:
        tree: of the bodies.
        steps: pose of each body in its parent.
    """
    R, p = constant(frame.R), constant(frame.p)
    poses: dict[int, tuple[Expression, Expression]] = {}
    for i in reversed(tree.path(frame.body)):
        poses[i] = R, p
        p = steps[i].offset + steps[i].to_parent(p)
        R = ex.horzcat(*(steps[i].to_parent(R[:, k]) for k in range(3)))
    return poses | {0: (R, p)}


def constant(values: Floats | Expression) -> Expression:
    """A constant matrix or vector whose zeros are structural, so that they cost nothing; an expression stays one."""
    return values if isinstance(values, ex.Expression) else ex.Expression(np.asarray(values, dtype=float))


def _placement(body: Body, q: Expression) -> Placement:
    x, slopes = _followed(body, q)
    along_z = constant(body.R[:, 2])
    origin = ex.Expression(body.p)
    match body.kind:
        case JointKind.PRISMATIC:
            along = origin + along_z * (x + body.offset)
            return Placement(constant(body.R), ex.ones(1), ex.zeros(1), along, 0.0, 1.0, slopes)
        case JointKind.HELICAL:
            cosine, sine = _cosine_sine(x, body.offset)
            advance = along_z * (body.pitch * (x + body.offset))
            return Placement(constant(body.R), cosine, sine, origin + advance, 1.0, body.pitch, slopes)
        case _:
            cosine, sine = _cosine_sine(x, body.offset)
            return Placement(constant(body.R), cosine, sine, origin, 1.0, 0.0, slopes)


def _cosine_sine(x: Expression, offset: float) -> tuple[Expression, Expression]:
    """cos and sin of x + offset; quarter turns in the offset only swap and negate."""
    quarters = round(offset / (pi / 2))
    rest = offset - quarters * pi / 2
    angle = x if abs(rest) < TYPED else x + rest
    cosine, sine = ex.cos(angle), ex.sin(angle)
    return [(cosine, sine), (-sine, cosine), (-cosine, -sine), (sine, -cosine)][quarters % 4]


def _followed(body: Body, q: Expression) -> tuple[Expression, tuple[Factor, Factor, Factor]]:
    """The value of a body's joint less its offset, and its first three derivatives by the coordinate q."""
    if not body.higher:
        return times(body.multiplier, q), (body.multiplier, 0.0, 0.0)
    curve = (0.0, body.multiplier, *body.higher)
    value, *slopes = (ex.Expression(0) + polynomial(differentiate(curve, order), q) for order in range(4))
    return value, (slopes[0], slopes[1], slopes[2])


def times(factor: Factor, x: Expression) -> Expression:
    """The product, or x itself where the factor is one."""
    return x if isinstance(factor, float) and factor == 1.0 else factor * x
