"""Derivatives of inverse and forward dynamics in closed form: a sweep out, one in, few vectors per pair of joints.

The velocities of a body are taken relative to the origin of its own frame. Then the composite body behind joint i is
described by its mass, first moment h, inertia I, p = twice its linear momentum and W = twice the integral of v r' dm,
and the wrench that a change X = (xi, x) of its twist demands on top of G dX/dt is 2 B X = (N xi, xi x p) with
N = tr(W) E - W: it needs the angular part alone.

Reference: Singh, Wensing & Echeandia, Efficient analytical derivatives of rigid-body dynamics using spatial vector
algebra, IEEE RA-L 7, 2022 (the recursion over composite bodies); Carpentier & Mansard, RSS 2018.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import mafsil.expression as ex
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.composite_motion import CompositeMotion, Motion, body_motion, composites
from mafsil.mechanics.forward_dynamics import forward_dynamics, solved
from mafsil.mechanics.placement import Expression, Placement, joint_values, placements
from mafsil.mechanics.wrench import Wrench


def inverse_dynamics_derivatives(
    tree: BodyTree, q: Expression, qd: Expression, qdd: Expression, F_tip: Expression | None = None
) -> Expression:
    """(3 n, n): d tau/dq, d tau/dqd and d tau/dqdd = M, stacked.

    With Psi' = [V_parent, S], Psi'' = [A_parent, S] + [V_parent, Psi'] of each joint, for j before or equal i:
        d tau_i/dq_j  = S_i . (2 B_i Psi'_j + G_i Psi''_j)
        d tau_j/dq_i  = S_j . (2 B_i Psi'_i + G_i Psi''_i + S_i x* F_i)
        d tau_i/dqd_j = 2 S_i . (B_i S_j + G_i Psi'_j),  d tau_j/dqd_i = 2 S_j . (B_i S_i + G_i Psi'_i)

    Args:
        tree: the bodies.
        q, qd, qdd: (n,) coordinates [rad | m] and time derivatives.
        F_tip: (6,) wrench (m, f) the tip exerts on the world, in {tip}, constant there [N m, N]; None for none.

    Reference: as the module.
    """
    return ex.vertcat(*matrices(tree, q, qd, qdd, F_tip))


def forward_dynamics_derivatives(
    tree: BodyTree, q: Expression, qd: Expression, tau: Expression, F_tip: Expression | None = None
) -> Expression:
    """(3 n, n): d qdd/dq, d qdd/dqd and d qdd/dtau = M^-1, stacked.

    From tau = ID(q, qd, qdd): d qdd = M^-1 (d tau - dID/dq dq - dID/dqd dqd).

    Args:
        tree: the bodies.
        q, qd: (n,) coordinates [rad | m] and rates.
        tau: (n,) joint efforts [N m | N].
        F_tip: (6,) wrench (m, f) the tip exerts on the world, in {tip}, constant there [N m, N]; None for none.

    Raises:
        ModelError: some joints move no inertia, so that no acceleration follows from their efforts.

    Reference: Carpentier & Mansard, Analytical derivatives of rigid body dynamics algorithms, RSS 2018.
    """
    n = tree.n
    qdd = forward_dynamics(tree, q, qd, tau, F_tip)
    stacked = inverse_dynamics_derivatives(tree, q, qd, qdd, F_tip)
    inverse = solved(stacked[2 * n :, :], ex.eye(n))
    return ex.vertcat(-inverse @ stacked[:n, :], -inverse @ stacked[n : 2 * n, :], inverse)


def matrices(
    tree: BodyTree, q: Expression, qd: Expression, qdd: Expression, F_tip: Expression | None = None
) -> tuple[Expression, Expression, Expression]:
    """(n, n) each: d tau/dq, d tau/dqd and M.

    Arguments as in `inverse_dynamics_derivatives`. What is not used of the result costs nothing.
    """
    steps = placements(tree, q)
    motion = body_motion(tree, steps, joint_values(tree, qd), joint_values(tree, qdd))
    pairs = _Pairs(tree, steps, motion, composites(tree, steps, motion, F_tip))
    by_q, by_qd, M = (_Matrix(tree) for _ in range(3))
    for i, _ in tree.moving:
        pairs.walk(i, by_q, by_qd, M)
    return by_q.full(), by_qd.full(), M.full()


class _Matrix:
    """(n, n) by coordinates, filled by pairs of joints: followers of one coordinate add up."""

    def __init__(self, tree: BodyTree) -> None:
        self.tree = tree
        self.entries: dict[tuple[int, int], Expression] = {}

    def add(self, i: int, j: int, value: Expression) -> None:
        """Row of joint i, column of joint j."""
        a, b = self.tree.bodies[i], self.tree.bodies[j]
        key, factor = (a.coordinate, b.coordinate), a.multiplier * b.multiplier
        scaled = value if factor == 1.0 else factor * value
        self.entries[key] = self.entries[key] + scaled if key in self.entries else scaled

    def full(self) -> Expression:
        n, zero = self.tree.n, ex.Expression(0)
        return ex.vertcat(*(ex.horzcat(*(self.entries.get((i, j), zero) for j in range(n))) for i in range(n)))


@dataclass(frozen=True, slots=True)
class _Pairs:
    tree: BodyTree
    steps: Sequence[Placement]
    motion: Motion
    composite: Sequence[CompositeMotion]

    def walk(self, i: int, by_q: _Matrix, by_qd: _Matrix, M: _Matrix) -> None:
        """All entries of joint i with itself and the joints before it."""
        step, body = self.steps[i], self.tree.bodies[i]
        own = self.composite[i]
        unit = Wrench(*own.inertia.unit_acceleration(step))
        turning = own.unit_rate_row(step)
        rate = Wrench(*own.rate_wrench(step, self.motion.drift[i]))
        shift = Wrench(*own.shift_wrench(step, self.motion, i))
        j = i
        while j:
            at = self.steps[j]
            drift, jump = self.motion.drift[j], self.motion.jump[j]
            t_z, drifted = at.omega * turning[2], at.omega * unit.m + at.v * unit.f
            by_qd.add(i, j, t_z + ex.dot(drifted, 2 * drift))
            by_q.add(i, j, at.omega * ex.dot(turning, drift) + ex.dot(unit.m, jump[0]) + ex.dot(unit.f, jump[1]))
            effort = unit.along(at)
            M.add(i, j, effort + body.armature if i == j else effort)
            if i != j:
                by_q.add(j, i, shift.along(at))
                by_qd.add(j, i, rate.along(at))
                M.add(j, i, effort)
            unit, rate, shift = unit.in_parent(at), rate.in_parent(at), shift.in_parent(at)
            turning = at.to_parent(turning) + ex.cross(self.motion.gain[j], unit.f)
            j = self.tree.bodies[j].parent
