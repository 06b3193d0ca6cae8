"""A base that is carried along a known motion: the starting values of the outward recursions."""

from __future__ import annotations

from dataclasses import dataclass

import mafsil.expression as ex
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.placement import Expression, constant


@dataclass(frozen=True, slots=True)
class BaseMotion:
    """Motion of the base body's frame {0} at its origin, vectors (3,) in {0}; accelerations are those of the point.

    Attributes:
        omega, v: velocities.
        alpha, a: accelerations, without gravity.
    """

    omega: Expression
    v: Expression
    alpha: Expression
    a: Expression


def base_motion(tree: BodyTree, V: Expression | None = None, dV: Expression | None = None) -> BaseMotion:
    """Motion of {0} from that of the space frame {s}, to which the base is fixed and which moves with it.

    A twist's derivative is no point's acceleration: the point at the origin accelerates by dv + omega x v.

    Args:
        tree: the bodies.
        V, dV: (6,) twist (omega, v) of {s} against an inertial frame, in {s}, and its time derivative; None for rest.

    Reference: Lynch & Park, Modern Robotics, sec. 8.3; Featherstone, Rigid Body Dynamics Algorithms, sec. 2.10.
    """
    twist: Expression = ex.zeros(6, 1) if V is None else V
    rate: Expression = ex.zeros(6, 1) if dV is None else dV
    omega, alpha, p, R = twist[:3], rate[:3], constant(tree.p_s0), constant(tree.R_s0)
    lever = ex.cross(omega, p)
    v = twist[3:] + lever
    a = rate[3:] + ex.cross(omega, twist[3:]) + ex.cross(alpha, p) + ex.cross(omega, lever)
    return BaseMotion(R.T @ omega, R.T @ v, R.T @ alpha, R.T @ a)
