"""Matrix entries of pairs of joints, one of which carries the other: derivatives of inverse dynamics and M.

Joint i and the composite body behind it give three wrenches and a row; an entry is what one of them does along the
screw, or along the change of the screw, of a joint j before i. There are two ways to bring both together:

- in the frames of the bodies: the wrenches of i are carried from frame to frame through all joints before it; each step
  turns and shifts them, which costs little where the frames stand at right angles and few joints are in a row;
- in the ground frame: every wrench and every screw is taken once about the origin of {0}, in the axes of {0}; then a
  pair costs its scalar products alone (`ground_frame`).

Reference: Singh, Wensing & Echeandia, Efficient analytical derivatives of rigid-body dynamics using spatial vector
algebra, IEEE RA-L 7, 2022, algorithm 1 (in ground coordinates).
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Sequence

import mafsil.expression as ex
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.composite_motion import CompositeMotion, Motion
from mafsil.mechanics.placement import Expression, Factor, Placement, times, world_placements
from mafsil.mechanics.wrench import Screw, Wrench, along, twist_at_ground, wrench_at_ground


class JointMatrix:
    """A matrix of pairs of joints; by coordinates (n, n), followers of one coordinate add up."""

    def __init__(self, tree: BodyTree, steps: Sequence[Placement]) -> None:
        self.tree = tree
        self.rates = [step.slopes[0] for step in steps]
        self.pairs: dict[tuple[int, int], Expression] = {}

    def add(self, i: int, j: int, value: Expression) -> None:
        """Row of joint i, column of joint j."""
        self.pairs[i, j] = value

    def full(self, columns: Sequence[Factor] | None = None) -> Expression:
        """(n, n) by coordinates, zero where no pair has an entry.

        Args:
            columns: factor of every joint's column, base first; its rate per rate of its coordinate if None.
        """
        n, zero = self.tree.n, ex.Expression(0)
        entries: dict[tuple[int, int], Expression] = {}
        for (i, j), value in self.pairs.items():
            key = self.tree.bodies[i].coordinate, self.tree.bodies[j].coordinate
            scaled = times(self.rates[i] * (self.rates if columns is None else columns)[j], value)
            entries[key] = entries[key] + scaled if key in entries else scaled
        return ex.vertcat(*(ex.horzcat(*(entries.get((i, j), zero) for j in range(n))) for i in range(n)))


class JointPairs(ABC):
    """Fills d tau/dq, d tau/dqd and M by pairs of joints.

    Args:
        tree: the bodies.
        steps: their placements.
        motion: of the bodies.
        composite: the composite body behind every joint.
    """

    def __init__(
        self, tree: BodyTree, steps: Sequence[Placement], motion: Motion, composite: Sequence[CompositeMotion]
    ) -> None:
        self.tree = tree
        self.steps = steps
        self.motion = motion
        self.composite = composite
        self.by_q, self.by_qd, self.M = (JointMatrix(tree, steps) for _ in range(3))

    def matrices(self, qd: Expression, qdd: Expression) -> tuple[Expression, Expression, Expression]:
        """(n, n) each: d tau/dq, d tau/dqd, M; rates and accelerations (n,) of the coordinates."""
        for i, _ in self.tree.moving:
            self.own(i)
            self.before(i)
        by_q, by_qd, M = self.by_q.full(), self.by_qd.full(), self.M.full()
        if any(body.higher for _, body in self.tree.moving):
            more_by_q, more_by_qd = self._bent(qd, qdd)
            return by_q + more_by_q, by_qd + more_by_qd, M
        return by_q, by_qd, M

    def _bent(self, qd: Expression, qdd: Expression) -> tuple[Expression, Expression]:
        """(n, n) each: what d tau/dq and d tau/dqd have from joints that follow along a curve p(x).

        Their rates p' xd and accelerations p' xdd + p'' xd^2 change with x and xd, and so does p' before their efforts.
        """
        zero = ex.Expression(0)
        rates, gains, drag, own = [zero], [zero], [zero], ex.zeros(self.tree.n, self.tree.n)
        for i, body in self.tree.moving:
            k, (first, second, third) = body.coordinate, self.steps[i].slopes
            rates.append(second * qd[k])
            gains.append(second * qdd[k] + third * qd[k] ** 2)
            drag.append(2 * second * qd[k])
            effort = Wrench(self.composite[i].moment, self.composite[i].force).along(self.steps[i])
            rotor = body.armature * (first * qdd[k] + second * qd[k] ** 2)
            own[k, k] = own[k, k] + second * (effort + rotor)
        return own + self.by_qd.full(rates) + self.M.full(gains), self.M.full(drag)

    def own(self, i: int) -> None:
        """Entries of joint i with itself, in its own frame."""
        step, body, own = self.steps[i], self.tree.bodies[i], self.composite[i]
        drift, jump = self.motion.drift[i], self.motion.jump[i]
        unit, row = Wrench(*own.inertia.unit_acceleration(step)), own.unit_rate_row(step)
        drifted = step.omega * unit.m + step.v * unit.f
        self.by_qd.add(i, i, step.omega * row[2] + ex.dot(drifted, 2 * drift))
        self.by_q.add(i, i, step.omega * ex.dot(row, drift) + ex.dot(unit.m, jump[0]) + ex.dot(unit.f, jump[1]))
        self.M.add(i, i, unit.along(step) + body.armature)

    @abstractmethod
    def before(self, i: int) -> None:
        """Entries of joint i with the joints before it, both ways."""

    def wrenches(self, i: int) -> tuple[Wrench, Wrench, Wrench, Expression]:
        """G S, 2 (B S + G Psi'), 2 B Psi' + G Psi'' + S x* F of joint i, and the row 2 B' S (3,), in {i}."""
        step, own = self.steps[i], self.composite[i]
        unit = Wrench(*own.inertia.unit_acceleration(step))
        rate = Wrench(*own.rate_wrench(step, self.motion.drift[i]))
        return unit, rate, Wrench(*own.shift_wrench(step, self.motion, i)), own.unit_rate_row(step)


class BodyFramePairs(JointPairs):
    """Wrenches carried from joint to joint."""

    def before(self, i: int) -> None:
        """Entries of joint i with the joints before it, the nearest first."""
        unit, rate, shift, row = self.wrenches(i)
        j = i
        while self.tree.bodies[j].parent:
            at = self.steps[j]
            unit, rate, shift = unit.in_parent(at), rate.in_parent(at), shift.in_parent(at)
            row = at.to_parent(row) + ex.cross(self.motion.gain[j], unit.f)
            j = self.tree.bodies[j].parent
            self._pair(i, j, unit, rate, shift, row)

    def _pair(self, i: int, j: int, unit: Wrench, rate: Wrench, shift: Wrench, row: Expression) -> None:
        at, drift, jump = self.steps[j], self.motion.drift[j], self.motion.jump[j]
        drifted, effort = at.omega * unit.m + at.v * unit.f, unit.along(at)
        self.by_qd.add(i, j, at.omega * row[2] + ex.dot(drifted, 2 * drift))
        self.by_q.add(i, j, at.omega * ex.dot(row, drift) + ex.dot(unit.m, jump[0]) + ex.dot(unit.f, jump[1]))
        self.M.add(i, j, effort)
        self.M.add(j, i, effort)
        self.by_q.add(j, i, shift.along(at))
        self.by_qd.add(j, i, rate.along(at))


class GroundFramePairs(JointPairs):
    """All wrenches and screws about the origin of {0}, in its axes, velocities relative to {0}.

    Of a frame that moves with the velocity v of its origin, the row 2 B' S grows by 2 v x f, f the force of G S, and
    Psi'' loses 2 xi x v, xi the angular part of Psi'.
    """

    def __init__(
        self, tree: BodyTree, steps: Sequence[Placement], motion: Motion, composite: Sequence[CompositeMotion]
    ) -> None:
        super().__init__(tree, steps, motion, composite)
        self.R, self.o = world_placements(tree, steps)
        self.v = [ex.zeros(3, 1)]
        for i, body in tree.moving:
            self.v.append(self.v[body.parent] + self.R[body.parent] @ (motion.gain[i] / 2))
        self.screws = [self._screws(i) for i in range(len(tree.bodies))]

    def _screws(self, j: int) -> tuple[Screw, Screw, Screw, Expression, Expression]:
        """S, 2 Psi', Psi'' as (angular, linear), and the angular parts of S and Psi'."""
        step, R, o, v = self.steps[j], self.R[j], self.o[j], self.v[j]
        z, drift = R[:, 2], R @ self.motion.drift[j]
        jump = R @ self.motion.jump[j][0], R @ self.motion.jump[j][1]
        axis, turned = step.omega * z, step.omega * drift
        screw = twist_at_ground(axis, step.v * z, o)
        rate = twist_at_ground(2 * turned, 2 * step.v * drift - 2 * ex.cross(axis, v), o)
        return screw, rate, twist_at_ground(jump[0], jump[1] - 2 * ex.cross(turned, v), o), axis, turned

    def before(self, i: int) -> None:
        """Entries of joint i with the joints before it."""
        R, o, (*wrenches, row) = self.R[i], self.o[i], self.wrenches(i)
        turned = [Wrench(R @ wrench.m, R @ wrench.f) for wrench in wrenches]
        row = R @ row + 2 * ex.cross(self.v[i], turned[0].f)
        unit, rate, shift = (wrench_at_ground(wrench, o) for wrench in turned)
        for j in self.tree.path(self.tree.bodies[i].parent):
            screw, twice_drift, jump, axis, drift = self.screws[j]
            effort = along(unit, screw)
            self.by_qd.add(i, j, along(unit, twice_drift) + ex.dot(row, axis))
            self.by_q.add(i, j, along(unit, jump) + ex.dot(row, drift))
            self.M.add(i, j, effort)
            self.M.add(j, i, effort)
            self.by_q.add(j, i, along(shift, screw))
            self.by_qd.add(j, i, along(rate, screw))
