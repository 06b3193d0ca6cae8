"""Joint accelerations by articulated bodies: cost grows with the number of joints, not with its cube."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.composite_motion import rotate_matrix, turned_symmetric
from mafsil.mechanics.placement import Expression, Placement, constant, joint_values, placements
from mafsil.mechanics.tolerances import SINGULAR_PIVOT

TRAVEL = 1.0
"""Travel [m] of a prismatic joint that counts for the largest inertia."""


@dataclass(frozen=True, slots=True)
class ArticulatedInertia:
    """[[I, H], [H', M]]: the wrench (moment, force) at the origin per acceleration (alpha, a), blocks (3, 3)."""

    I: Expression
    H: Expression
    M: Expression

    def add(self, other: ArticulatedInertia) -> ArticulatedInertia:
        """Both bodies as one."""
        return ArticulatedInertia(self.I + other.I, self.H + other.H, self.M + other.M)

    def release_joint(self, U: tuple[Expression, Expression], give: Expression) -> ArticulatedInertia:
        """I - U U' give: what is left where the joint gives way."""
        m, f = U
        return ArticulatedInertia(
            symmetric(self.I - m @ (m * give).T), self.H - m @ (f * give).T, symmetric(self.M - f @ (f * give).T)
        )

    def in_parent(self, step: Placement) -> ArticulatedInertia:
        """Seen from the parent's frame: turned, then shifted by the offset."""
        inertia, M = symmetric(turned_symmetric(self.I, step)), symmetric(turned_symmetric(self.M, step))
        return ArticulatedInertia(inertia, rotate_matrix(self.H, step), M).shift(step.offset)

    def shift(self, p: Expression) -> ArticulatedInertia:
        """About an origin at -p: H + [p] M, I + [p] H' - H [p] - [p] M [p]."""
        P = ex.skew(p)
        PM = P @ self.M
        PHt = P @ self.H.T
        return ArticulatedInertia(symmetric(self.I + PHt + PHt.T - PM @ P), self.H + PM, self.M)

    def wrench(self, alpha: Expression, a: Expression) -> tuple[Expression, Expression]:
        """(moment, force) that an acceleration (alpha, a) takes."""
        return self.I @ alpha + self.H @ a, self.H.T @ alpha + self.M @ a


def articulated_body(
    tree: BodyTree, q: Expression, qd: Expression, tau: Expression, F_tip: Expression | None = None
) -> Expression:
    """qdd (n,) with M(q) qdd = tau - c(q, qd) - g(q) - J' F_tip, without forming M.

    Inward: each body with all it carries answers like one rigid body of inertia I_A and bias wrench p_A, its joint
    giving way: U = I_A S, D = S' I_A S, u = tau - S' p_A. Outward: qdd = (u - U' a') / D. Where D is no more than
    rounding, the mass matrix is singular and the accelerations are NaN, not huge numbers.

    Args:
        tree: the bodies; no joint may follow another.
        q, qd: (n,) coordinates [rad | m] and rates.
        tau: (n,) joint efforts [N m | N].
        F_tip: (6,) wrench (m, f) the tip exerts on the world, in {tip} [N m, N]; None for none.

    Reference: Featherstone, Rigid Body Dynamics Algorithms, sec. 7.3; here with the accelerations of points fixed in
    the bodies, as in `inverse_dynamics`.
    """
    steps = placements(tree, q)
    rates, efforts = joint_values(tree, steps, qd), joint_values(tree, steps, tau)
    omega = _angular_velocities(tree, steps, rates)
    drift = [_drift(tree, steps, omega, rates, i) for i in range(len(tree.bodies))]
    inertias, bias = _own(tree, omega)
    if F_tip is not None:
        _add_tip_wrench(tree, F_tip, bias)
    hinges = _inward(tree, steps, efforts, drift, inertias, bias)
    return _outward(tree, steps, drift, hinges)


def _angular_velocities(tree: BodyTree, steps: Sequence[Placement], rates: Sequence[Expression]) -> list[Expression]:
    omega: list[Expression] = [ex.zeros(3, 1)]
    for i, body in tree.moving:
        omega.append(steps[i].to_child(omega[body.parent]) + _along_z(steps[i].omega * rates[i]))
    return omega


def _drift(
    tree: BodyTree, steps: Sequence[Placement], omega: Sequence[Expression], rates: Sequence[Expression], i: int
) -> tuple[Expression, Expression]:
    """Angular and linear acceleration of {i} when neither its parent nor its joint accelerates."""
    if i == 0:
        return ex.zeros(3, 1), ex.zeros(3, 1)
    step, parent = steps[i], omega[tree.bodies[i].parent]
    angular = ex.cross(omega[i], _along_z(step.omega * rates[i]))
    linear = step.to_child(ex.cross(parent, ex.cross(parent, step.offset)))
    return angular, linear + 2 * ex.cross(omega[i], _along_z(step.v * rates[i]))


def _own(
    tree: BodyTree, omega: Sequence[Expression]
) -> tuple[list[ArticulatedInertia], list[tuple[Expression, Expression]]]:
    """Each body's own inertia and bias wrench."""
    inertias: list[ArticulatedInertia] = []
    bias: list[tuple[Expression, Expression]] = []
    for body, w in zip(tree.bodies, omega, strict=True):
        h, inertia = constant(body.inertia.h), constant(body.inertia.I)
        inertias.append(ArticulatedInertia(inertia, ex.skew(h), body.inertia.mass * ex.eye(3)))
        bias.append((ex.cross(w, inertia @ w), ex.cross(w, ex.cross(w, h))))
    return inertias, bias


def _add_tip_wrench(tree: BodyTree, F_tip: Expression, bias: list[tuple[Expression, Expression]]) -> None:
    R, p, body = constant(tree.tip.R), constant(tree.tip.p), tree.tip.body
    f = R @ F_tip[3:]
    bias[body] = (bias[body][0] + R @ F_tip[:3] + ex.cross(p, f), bias[body][1] + f)


def _inward(
    tree: BodyTree,
    steps: Sequence[Placement],
    efforts: Sequence[Expression],
    drift: Sequence[tuple[Expression, Expression]],
    inertias: list[ArticulatedInertia],
    bias: list[tuple[Expression, Expression]],
) -> dict[int, tuple[tuple[Expression, Expression], Expression, Expression]]:
    """(U, 1/D, u) of each joint, by body index."""
    hinges: dict[int, tuple[tuple[Expression, Expression], Expression, Expression]] = {}
    least = least_inertias(tree, steps)
    for i, body in reversed(tree.moving):
        step, A = steps[i], inertias[i]
        U = (step.omega * A.I[:, 2] + step.v * A.H[:, 2], step.omega * A.H[2, :].T + step.v * A.M[:, 2])
        D = step.omega * U[0][2] + step.v * U[1][2] + body.armature
        give = ex.if_else(D > least[i], 1 / D, nan)
        moment, force = bias[i]
        u = efforts[i] - step.omega * moment[2] - step.v * force[2]
        hinges[i] = (U, give, u)
        if not body.parent:
            continue
        angular, linear = drift[i]
        kept = A.release_joint(U, give)
        moment = moment + kept.I @ angular + kept.H @ linear + U[0] * (u * give)
        force = force + kept.H.T @ angular + kept.M @ linear + U[1] * (u * give)
        f = step.to_parent(force)
        m = step.to_parent(moment) + ex.cross(step.offset, f)
        bias[body.parent] = (bias[body.parent][0] + m, bias[body.parent][1] + f)
        inertias[body.parent] = inertias[body.parent].add(kept.in_parent(step))
    return hinges


def least_inertias(tree: BodyTree, steps: Sequence[Placement]) -> list[float]:
    """Of each joint, SINGULAR_PIVOT times a bound of the inertia that it moves in any position."""
    bounds = [(abs(b.inertia.mass), _norm(b.inertia.h), _norm(b.inertia.I)) for b in tree.bodies]
    least = [0.0] * len(tree.bodies)
    for i, body in reversed(tree.moving):
        mass, first, second = bounds[i]
        omega, v = abs(float(steps[i].omega)), abs(float(steps[i].v))
        least[i] = SINGULAR_PIVOT * (omega**2 * second + 2 * omega * v * first + v**2 * mass + body.armature)
        way = _norm(body.p) + TRAVEL * v
        m, f, s = bounds[body.parent]
        bounds[body.parent] = (m + mass, f + first + mass * way, s + second + 2 * way * first + mass * way**2)
    return least


def _norm(x: Floats) -> float:
    return float(np.linalg.norm(x))


def _outward(
    tree: BodyTree,
    steps: Sequence[Placement],
    drift: Sequence[tuple[Expression, Expression]],
    hinges: dict[int, tuple[tuple[Expression, Expression], Expression, Expression]],
) -> Expression:
    alpha, a = [ex.zeros(3, 1)], [constant(-tree.gravity)]
    qdd: list[Expression] = [ex.Expression(0)] * tree.n
    for i, body in tree.moving:
        step, p = steps[i], body.parent
        angular = step.to_child(alpha[p]) + drift[i][0]
        linear = step.to_child(a[p] + ex.cross(alpha[p], step.offset)) + drift[i][1]
        U, give, u = hinges[i]
        x = (u - ex.dot(U[0], angular) - ex.dot(U[1], linear)) * give
        qdd[body.coordinate] = x
        alpha.append(angular + _along_z(step.omega * x))
        a.append(linear + _along_z(step.v * x))
    return ex.vertcat(*qdd)


def symmetric(A: Expression) -> Expression:
    """A symmetric matrix (3, 3) made of its lower half alone, so that the upper one is not computed."""
    return ex.vertcat(*(ex.horzcat(*(A[max(i, j), min(i, j)] for j in range(3))) for i in range(3)))


def _along_z(x: Expression) -> Expression:
    return ex.vertcat(0, 0, x)
