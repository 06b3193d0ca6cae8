"""Derivatives of forward dynamics by articulated bodies: along a deep tree the cost of an entry does not grow with n.

A displacement (or a rate) of joint j changes the motion of all bodies behind it by one rigid twist and demands wrenches
there. What they do to the accelerations follows from four recursions, none of which forms the mass matrix or a product
of n x n matrices:

1. Outward: rates and drift accelerations of all bodies.
2. Inward: the articulated inertia A_i, and with the same reductions the articulated rate tensor P_i, which is the
   wrench behind joint i per angular change of all velocities there (own part 2 B_i). Joint i keeps U_i = A_i S_i,
   D_i = S_i' U_i and s_i = P_i' S_i.
3. Outward: accelerations and the wrench F_i that joint i carries.
4. Columns j by q, by the rate and by the effort, parents first: the wrench w_j handed to the parent of j is what a body
   without acceleration in front of j demands,
       b_j = A_j Psi''_j + P_j Psi'_j + S_j x* F_j  (by q),  2 A_j Psi'_j + P_j S_j  (by the rate),
       w_j = b_j - U_j S_j' b_j / D_j,  and U_j / D_j (by the effort);
   a) joints i before j:  -X_p[i] . w_j, p the parent of j, where X_p[i] is the acceleration of body p per effort of
      joint i: X_j[i] = X_p[i] + (M^-1)_ij S_j;
   b) joint j itself, then outward to the joints k behind it:  -(U_k . a + s_k . Psi'_j) / D_k, a being the acceleration
      of the parent of k and the change of drift together;
   c) joints k beside j, body p being the last that carries both:  Y_p[k] . a_p with the response Y_p[k] of joint k to
      an acceleration of body p, joint by joint where the path to p has fewer than six.

Inertias stay at their own bodies' origins, so that no digits are lost to long arms; what meets in pairs (S, U, w, a) is
taken about the origin of {0}, all of it in the axes of {0}, so that no pair costs a rotation.

Reference: Featherstone, Rigid Body Dynamics Algorithms, sec. 7.3 (articulated bodies); Carpentier & Mansard, Analytical
derivatives of rigid body dynamics algorithms, RSS 2018, sec. IV (d qdd = -M^-1 d tau, M^-1 by articulated bodies);
Singh, Wensing & Echeandia, RA-L 7, 2022, eq. 22 to 30 (Psi', Psi'', B); Lilly & Orin 1990 and Wensing, Featherstone &
Orin, ICRA 2012 (force propagation, X).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import nan

import mafsil.expression as ex
from mafsil.mechanics.articulated_body import ArticulatedInertia, least_inertias, symmetric
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.placement import Expression, Placement, constant, joint_values, placements, world_placements

Screw = tuple[Expression, Expression]
"""Angular and linear part of a twist or acceleration, or moment and force, (3,) each."""

FEW = 6
"""A path with fewer joints than a twist has coordinates carries a motion more cheaply joint by joint."""


@dataclass(frozen=True, slots=True)
class ArticulatedRate:
    """[N; Q]: the wrench (moment, force) at the origin per angular change of all velocities behind, blocks (3, 3)."""

    N: Expression
    Q: Expression

    def add(self, other: ArticulatedRate) -> ArticulatedRate:
        """Both bodies as one."""
        return ArticulatedRate(self.N + other.N, self.Q + other.Q)

    def release_joint(self, U: Screw, row: Expression) -> ArticulatedRate:
        """What is left where the joint gives way: U row' less, row = S' P / D."""
        return ArticulatedRate(self.N - U[0] @ row.T, self.Q - U[1] @ row.T)

    def in_parent(self, r: Expression, inertia: ArticulatedInertia, gain: Expression) -> ArticulatedRate:
        """About the parent's origin at -r, velocities there relative to it: twice of them grow by `gain`.

        Args:
            r: (3,) from the parent's origin to this one.
            inertia: what the joint passes on, about the parent's origin.
            gain: (3,) twice the velocity of this origin less that of the parent's.
        """
        G = ex.skew(gain)
        return ArticulatedRate(self.N + ex.skew(r) @ self.Q - inertia.H @ G, self.Q - inertia.M @ G)


def forward_derivatives(
    tree: BodyTree, q: Expression, qd: Expression, tau: Expression, F_tip: Expression | None = None
) -> tuple[Expression, Expression, Expression]:
    """(n, n) each: d qdd/dq, d qdd/dqd and M^-1.

    Args:
        tree: the bodies; no joint may follow another.
        q, qd: (n,) coordinates [rad | m] and rates.
        tau: (n,) joint efforts [N m | N].
        F_tip: (6,) wrench (m, f) the tip exerts on the world, in {tip}, constant there [N m, N]; None for none.

    Reference: as the module.
    """
    steps = placements(tree, q)
    sweep = _Sweep(tree, steps, joint_values(tree, steps, qd))
    sweep.outward_rates()
    sweep.inward(joint_values(tree, steps, tau), F_tip)
    sweep.outward_accelerations()
    columns = _Columns(tree, sweep)
    for j, _ in tree.moving:
        columns.column(j)
    return columns.matrices()


class _Sweep:
    """Steps 1 to 3, lists by body index, vectors (3,) in the axes of {0}, about each body's own origin.

    Attributes:
        z, o, r: joint axis, origin, and the way there from the parent's origin.
        omega, v: angular velocity and velocity of the origin.
        turn: omega_parent x z, how the parent turns the joint's axis.
        inertias, rates: articulated, whole.
        U, row, give: of every joint, A S, S' P and 1 / D.
        jump: Psi'' for velocities relative to the origin.
        load: S x* F.
    """

    def __init__(self, tree: BodyTree, steps: Sequence[Placement], speeds: Sequence[Expression]) -> None:
        self.tree = tree
        self.steps = steps
        self.speeds = speeds
        self.R, self.o = world_placements(tree, steps)
        self.z = [R[:, 2] for R in self.R]
        zero = ex.zeros(3, 1)
        self.r, self.omega, self.v, self.turn, self.gain = [zero], [zero], [zero], [zero], [zero]
        self.drift: list[Screw] = [(zero, zero)]
        self.jump: list[Screw] = [(zero, zero)]
        self.load: list[Screw] = [(zero, zero)]
        self.inertias: list[ArticulatedInertia] = []
        self.rates: list[ArticulatedRate] = []
        self.bias: list[Screw] = []
        self.hinges: dict[int, tuple[Screw, Expression, Expression, Expression]] = {}
        self.qdd: list[Expression] = []

    def outward_rates(self) -> None:
        """Step 1."""
        for i, body in self.tree.moving:
            p, step, z = body.parent, self.steps[i], self.z[i]
            r = self.R[p] @ step.offset
            carried = self.omega[p]
            turn, spin, along = ex.cross(carried, z), step.omega * self.speeds[i], step.v * self.speeds[i]
            swing = ex.cross(carried, r)
            change = swing + z * along
            self.r.append(r)
            self.turn.append(turn)
            self.drift.append((turn * spin, ex.cross(carried, swing) + 2 * turn * along))
            self.gain.append(2 * change)
            self.omega.append(carried + z * spin)
            self.v.append(self.v[p] + change)

    def inward(self, efforts: Sequence[Expression], F_tip: Expression | None) -> None:
        """Step 2."""
        for i in range(len(self.tree.bodies)):
            self._own(i)
        if F_tip is not None:
            self._add_tip_wrench(F_tip)
        least = least_inertias(self.tree, self.steps)
        for i, body in reversed(self.tree.moving):
            step, z, A, P = self.steps[i], self.z[i], self.inertias[i], self.rates[i]
            U = _sum(step.omega, (A.I @ z, A.H.T @ z), step.v, (A.H @ z, A.M @ z))
            D = step.omega * ex.dot(z, U[0]) + step.v * ex.dot(z, U[1]) + body.armature
            give = ex.if_else(D > least[i], 1 / D, nan)
            row = step.omega * (P.N.T @ z) + step.v * (P.Q.T @ z)
            moment, force = self.bias[i]
            u = efforts[i] - step.omega * ex.dot(z, moment) - step.v * ex.dot(z, force)
            self.hinges[i] = U, give, u * give, row
            if body.parent:
                self._hand_over(i, body.parent)

    def _own(self, i: int) -> None:
        """Each body's own inertia, bias wrench and rate tensor."""
        body, R, w = self.tree.bodies[i].inertia, self.R[i], self.omega[i]
        h, inertia = R @ constant(body.h), symmetric(R @ constant(body.I) @ R.T)
        second = (inertia[0, 0] + inertia[1, 1] + inertia[2, 2]) / 2 * ex.eye(3) - inertia
        spin, flow = ex.cross(w, h), ex.skew(w) @ (2 * second)
        N = (flow[0, 0] + flow[1, 1] + flow[2, 2]) * ex.eye(3) - flow
        self.inertias.append(ArticulatedInertia(inertia, ex.skew(h), body.mass * ex.eye(3)))
        self.bias.append((ex.cross(w, inertia @ w), ex.cross(w, spin)))
        self.rates.append(ArticulatedRate(N, -ex.skew(2 * spin)))

    def _add_tip_wrench(self, F_tip: Expression) -> None:
        tip = self.tree.tip
        turned, p = self.R[tip.body] @ constant(tip.R), self.R[tip.body] @ constant(tip.p)
        f = turned @ F_tip[3:]
        self.bias[tip.body] = _plus(self.bias[tip.body], (turned @ F_tip[:3] + ex.cross(p, f), f))

    def _hand_over(self, i: int, p: int) -> None:
        """What joint i passes on to body p."""
        U, give, pull, row = self.hinges[i]
        r = self.r[i]
        kept = self.inertias[i].release_joint(U, give)
        moment, force = _plus(self.bias[i], kept.wrench(*self.drift[i]), _scale(pull, U))
        passed = kept.shift(r)
        rate = self.rates[i].release_joint(U, row * give).in_parent(r, passed, self.gain[i])
        self.inertias[p] = self.inertias[p].add(passed)
        self.rates[p] = self.rates[p].add(rate)
        self.bias[p] = _plus(self.bias[p], (moment + ex.cross(r, force), force))

    def outward_accelerations(self) -> None:
        """Step 3; a classical acceleration of the origin, gravity as the base's upward acceleration."""
        alpha, a = [ex.zeros(3, 1)], [constant(-self.tree.gravity)]
        for i, body in self.tree.moving:
            p, step, z, r = body.parent, self.steps[i], self.z[i], self.r[i]
            w, v, speed = step.omega, step.v, self.speeds[i]
            U, give, pull, _ = self.hinges[i]
            hinge = a[p] + ex.cross(alpha[p], r) + ex.cross(self.omega[p], ex.cross(self.omega[p], r))
            axis = ex.cross(alpha[p], z) + ex.cross(self.omega[p], self.turn[i])
            angular, linear = alpha[p] + self.drift[i][0], hinge + 2 * self.turn[i] * (v * speed)
            qdd = pull - give * (ex.dot(U[0], angular) + ex.dot(U[1], linear))
            self.qdd.append(qdd)
            alpha.append(angular + z * (w * qdd))
            a.append(linear + z * (v * qdd))
            jump = v * axis + w * ex.cross(hinge, z) + 2 * w * v * speed * ex.cross(self.turn[i], z)
            self.jump.append((w * axis, jump))
            m, f = _plus(self.bias[i], self.inertias[i].wrench(alpha[i], a[i]))
            self.load.append((w * ex.cross(z, m) + v * ex.cross(z, f), w * ex.cross(z, f)))


class _Columns:
    """Step 4; lists by body index of screws about the origin of {0}."""

    def __init__(self, tree: BodyTree, sweep: _Sweep) -> None:
        self.tree = tree
        self.sweep = sweep
        n = len(tree.bodies)
        self.paths = [tree.path(i) for i in range(n)]
        self.S: list[Screw] = [_zero()]
        self.Ug: list[Screw] = [_zero()]
        self.sg: list[Expression] = [ex.zeros(3, 1)]
        for i, _ in tree.moving:
            step, z, o = sweep.steps[i], sweep.z[i], sweep.o[i]
            (m, f), give, _, row = sweep.hinges[i]
            self.S.append((step.omega * z, step.v * z + step.omega * ex.cross(o, z)))
            self.Ug.append(_scale(give, _about_zero((m, f), o)))
            self.sg.append(give * (row + 2 * ex.cross(sweep.v[i], f)))
        self.X: list[dict[int, Screw]] = [{} for _ in range(n)]
        self.found: list[dict[tuple[int, int], Expression]] = [{}, {}, {}]
        self.free: dict[tuple[int, int], Screw] = {}

    def matrices(self) -> tuple[Expression, Expression, Expression]:
        """By q, by the rate, by the effort."""
        n, zero = self.tree.n, ex.Expression(0)
        by_q, by_qd, inverse = (
            ex.vertcat(*(ex.horzcat(*(x.get((i, j), zero) for j in range(1, n + 1))) for i in range(1, n + 1)))
            for x in self.found
        )
        return by_q, by_qd, inverse

    def column(self, j: int) -> None:
        """All entries of column j of the three matrices, of M^-1 the joints before and beside it."""
        sweep, p = self.sweep, self.tree.bodies[j].parent
        demands = self._demands(j)
        (m, f), give, _, _ = sweep.hinges[j]
        step, z, o = sweep.steps[j], sweep.z[j], sweep.o[j]
        own = [-give * (step.omega * ex.dot(z, b[0]) + step.v * ex.dot(z, b[1])) for b in demands]
        passed = [_about_zero(_plus(b, _scale(u, (m, f))), o) for b, u in zip(demands, own, strict=True)]
        for k, (wrench, u) in enumerate(zip([*passed, self.Ug[j]], [*own, give], strict=True)):
            along = [_zero()]
            for i in self.paths[p]:
                x = -_dot(self.X[p][i], wrench)
                self._set(k, i, j, x)
                along.append(_plus(along[-1], _scale(x, self.S[i])))
            x = u - _dot(self.Ug[j], along[-1])
            self._set(k, j, j, x)
            self._beside(k, j, along)
            self._behind(k, j, _plus(along[-1], _scale(x, self.S[j])))
        self._respond(j, p)

    def _demands(self, j: int) -> list[Screw]:
        """b_j by q and by the rate, about the own origin, velocities relative to it."""
        sweep, step = self.sweep, self.sweep.steps[j]
        A, P, z, turn = sweep.inertias[j], sweep.rates[j], sweep.z[j], sweep.turn[j]
        shifted, turned = step.omega * turn, step.omega * z
        by_q = _plus(A.wrench(*sweep.jump[j]), (P.N @ shifted, P.Q @ shifted), sweep.load[j])
        by_rate = _plus(A.wrench(2 * step.omega * turn, 2 * step.v * turn), (P.N @ turned, P.Q @ turned))
        return [by_q, by_rate]

    def _behind(self, k: int, j: int, a: Screw) -> None:
        """4b for column j of matrix k; of M^-1 only what `_respond` needs."""
        if k == 2:
            self.X[j][j] = a
            return
        sweep, step = self.sweep, self.sweep.steps[j]
        turned = step.omega * (sweep.turn[j] if k == 0 else sweep.z[j])
        angular, linear = sweep.jump[j] if k == 0 else (2 * step.omega * sweep.turn[j], 2 * step.v * sweep.turn[j])
        linear = linear - 2 * ex.cross(turned, sweep.v[j])
        a = _plus(a, (angular, linear + ex.cross(sweep.o[j], angular)))
        reached = {j: a}
        for i in range(j + 1, len(self.tree.bodies)):
            before = self.tree.bodies[i].parent
            if before in reached:
                x = -_dot(self.Ug[i], reached[before]) - ex.dot(self.sg[i], turned)
                self._set(k, i, j, x)
                reached[i] = _plus(reached[before], _scale(x, self.S[i]))

    def _beside(self, k: int, j: int, along: Sequence[Screw]) -> None:
        """4c for column j of matrix k; of the symmetric M^-1 only joints before j in the list."""
        for i, _ in self.tree.moving:
            path = self._common(i, j)
            if not path or i in self.paths[j] or j in self.paths[i] or (k == 2 and i > j):
                continue
            p = path[-1]
            if len(path) < FEW:
                x = sum((self._carried(i, c, p) * self.found[k][c, j] for c in path), ex.Expression(0))
            else:
                x = _dot(self._free(i, p), along[len(path)])
            self._set(k, i, j, x)

    def _set(self, k: int, i: int, j: int, x: Expression) -> None:
        self.found[k][i, j] = x
        if k == 2:
            self.found[k][j, i] = x

    def _respond(self, j: int, p: int) -> None:
        """X_j of the joints before j."""
        for i in self.paths[p]:
            self.X[j][i] = _plus(self.X[p][i], _scale(self.found[2][i, j], self.S[j]))

    def _common(self, i: int, j: int) -> tuple[int, ...]:
        """The joints that move both bodies."""
        both = [a for a, b in zip(self.paths[i], self.paths[j], strict=False) if a == b]
        return tuple(both)

    def _free(self, i: int, p: int) -> Screw:
        """Y_p[i]: acceleration of joint i per acceleration of body p before it, the joints between left free."""
        if (i, p) not in self.free:
            path = self.paths[i]
            if self.tree.bodies[i].parent == p:
                found = _scale(ex.Expression(-1), self.Ug[i])
            else:
                c = path[path.index(p) + 1]
                closer = self._free(i, c)
                found = _plus(closer, _scale(-_dot(closer, self.S[c]), self.Ug[c]))
            self.free[i, p] = found
        return self.free[i, p]

    def _carried(self, i: int, c: int, p: int) -> Expression:
        """Acceleration of joint i per acceleration of joint c on the path to body p."""
        return _dot(self._free(i, p), self.S[c])


def _zero() -> Screw:
    return ex.zeros(3, 1), ex.zeros(3, 1)


def _plus(first: Screw, *others: Screw) -> Screw:
    angular, linear = first
    for more, further in others:
        angular, linear = angular + more, linear + further
    return angular, linear


def _scale(factor: Expression, screw: Screw) -> Screw:
    return factor * screw[0], factor * screw[1]


def _sum(w: float, revolute: Screw, v: float, prismatic: Screw) -> Screw:
    return w * revolute[0] + v * prismatic[0], w * revolute[1] + v * prismatic[1]


def _dot(a: Screw, b: Screw) -> Expression:
    return ex.dot(a[0], b[0]) + ex.dot(a[1], b[1])


def _about_zero(wrench: Screw, o: Expression) -> Screw:
    """A wrench about o, about the origin of {0}."""
    return wrench[0] + ex.cross(o, wrench[1]), wrench[1]
