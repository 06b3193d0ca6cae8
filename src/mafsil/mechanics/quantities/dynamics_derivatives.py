"""Derivatives of inverse and forward dynamics in closed form: a sweep out, one in, few vectors per pair of joints.

The velocities of a body are taken relative to the origin of its own frame. Then the composite body behind joint i is
described by its mass, first moment h, inertia I, p = twice its linear momentum and W = twice the integral of v r' dm,
and the wrench that a change X = (xi, x) of its twist demands on top of G dX/dt is 2 B X = (N xi, xi x p) with
N = tr(W) E - W: it needs the angular part alone.

Joint i and the composite body behind it give three wrenches and a row; an entry is what one of them does along the
screw, or along the change of the screw, of a joint j before i. There are two ways to bring both together:

- in the frames of the bodies: the wrenches of i are carried from frame to frame through all joints before it; each step
  turns and shifts them, which costs little where the frames stand at right angles and few joints are in a row;
- in the ground frame: every wrench and every screw is taken once about the origin of {0}, in the axes of {0}; then a
  pair costs its scalar products alone (`ground_frame`).

Reference: Singh, Wensing & Echeandia, Efficient analytical derivatives of rigid-body dynamics using spatial vector
algebra, IEEE RA-L 7, 2022 (the recursion over composite bodies; algorithm 1 in ground coordinates); Carpentier &
Mansard, RSS 2018.
"""

from __future__ import annotations

from abc import ABC, abstractmethod
from collections.abc import Callable, Sequence

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.mechanics.arm_size import ArmSize
from mafsil.mechanics.articulated_derivatives import forward_derivatives
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.branch_factor import BranchFactor
from mafsil.mechanics.composite_motion import CompositeMotion, Motion, body_motion, composites
from mafsil.mechanics.placement import (
    Expression,
    Factor,
    Placement,
    joint_accelerations,
    joint_values,
    placements,
    times,
    world_placements,
)
from mafsil.mechanics.quantities.forward_dynamics import forward_dynamics, mass_matrix, require_accelerations
from mafsil.mechanics.quantity import Quantity, SecondMethod, States
from mafsil.mechanics.textbook import Numbers, Textbook, gradient, repeat_states
from mafsil.mechanics.wrench import Screw, Wrench, along, ground_is_shorter, twist_at_ground, wrench_at_ground


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


DEEP = 14
"""From this many joints in a row on, derivatives of forward dynamics need fewer operations by articulated bodies."""


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

    From tau = ID(q, qd, qdd): d qdd = M^-1 (d tau - dID/dq dq - dID/dqd dqd). Of two exact methods the one with fewer
    operations for this tree: articulated bodies where paths are long (`articulated_derivatives`), else M factored along
    the tree (`BranchFactor`); the latter always where joints follow each other.

    Args:
        tree: the bodies.
        q, qd: (n,) coordinates [rad | m] and rates.
        tau: (n,) joint efforts [N m | N].
        F_tip: (6,) wrench (m, f) the tip exerts on the world, in {tip}, constant there [N m, N]; None for none.

    Raises:
        ModelError: some joints move no inertia, so that no acceleration follows from their efforts.

    Reference: Carpentier & Mansard, Analytical derivatives of rigid body dynamics algorithms, RSS 2018.
    """
    if tree.depth >= DEEP and not tree.follows:
        require_accelerations(tree, q)
        return ex.vertcat(*forward_derivatives(tree, q, qd, tau, F_tip))
    qdd = forward_dynamics(tree, q, qd, tau, F_tip)
    by_q, by_qd, _ = matrices(tree, q, qd, qdd, F_tip)
    factor = BranchFactor(mass_matrix(tree, q))
    blocks = (_solved_columns(factor, by_q), _solved_columns(factor, by_qd), _matrix(factor.inverse()))
    return ex.vertcat(*blocks)


def _solved_columns(factor: BranchFactor, matrix: Expression) -> Expression:
    """-M^-1 matrix (n, n), column by column."""
    n = factor.n
    columns = [factor.solve([-matrix[i, j] for i in range(n)]) for j in range(n)]
    return _matrix([[columns[j][i] for j in range(n)] for i in range(n)])


def _matrix(rows: Sequence[Sequence[Expression]]) -> Expression:
    return ex.vertcat(*(ex.horzcat(*row) for row in rows))


def matrices(
    tree: BodyTree, q: Expression, qd: Expression, qdd: Expression, F_tip: Expression | None = None
) -> tuple[Expression, Expression, Expression]:
    """(n, n) each: d tau/dq, d tau/dqd and M.

    Arguments as in `inverse_dynamics_derivatives`. What is not used of the result costs nothing.
    """
    steps = placements(tree, q)
    motion = body_motion(tree, steps, joint_values(tree, steps, qd), joint_accelerations(tree, steps, qd, qdd))
    pairs = GroundFramePairs if ground_is_shorter(tree, wrenches=3, rows=1) else BodyFramePairs
    return pairs(tree, steps, motion, composites(tree, steps, motion, F_tip)).matrices(qd, qdd)


def _size_of_efforts(arm: ArmSize) -> Floats:
    return np.stack([arm.moment / arm.units, arm.inertia / arm.units, arm.inertia / arm.units])


def _size_of_motion(arm: ArmSize) -> Floats:
    by_position = arm.unit[:, None] / arm.unit
    return np.stack([by_position, by_position, arm.units / arm.inertia])


def _of_efforts(book: Textbook, s: States) -> Floats:
    """The recursion of Newton and Euler, differentiated by the complex step."""

    def efforts(q: Numbers, qd: Numbers, qdd: Numbers) -> Numbers:
        F = None if s.tip_wrench is None else repeat_states(s.tip_wrench, len(q))
        return book.newton_euler(_complex(q), _complex(qd), _complex(qdd), F).tau

    return _blocks(efforts, s.q, s.qd, s.qdd)


def _of_accelerations(book: Textbook, s: States) -> Floats:
    """The equation M qdd = tau - bias, solved in complex numbers."""

    def motion(q: Numbers, qd: Numbers, tau: Numbers) -> Numbers:
        F = None if s.tip_wrench is None else repeat_states(s.tip_wrench, len(q))
        return book.accelerations_of(_complex(q), _complex(qd), _complex(tau), F)

    return _blocks(motion, s.q, s.qd, s.tau)


def _blocks(function: Callable[[Numbers, Numbers, Numbers], Numbers], *inputs: Floats) -> Floats:
    """(b, 3, n, n): derivatives by each of three inputs (b, n)."""
    found: list[Floats] = []
    for k in range(3):

        def varied(x: Numbers, k: int = k) -> Numbers:
            others = [repeat_states(value, len(x)) for value in inputs]
            return function(*(x if j == k else other for j, other in enumerate(others)))

        found.append(gradient(varied, inputs[k]))
    return np.stack(found, axis=1)


def _complex(x: Numbers) -> Numbers:
    return x.astype(np.complex128)


INVERSE_DYNAMICS_DERIVATIVES = Quantity(
    name="inverse_dynamics_derivatives",
    symbol="dtau/d(q, qd, qdd)",
    title="Derivatives of inverse dynamics, in closed form: [0] by q, [1] by qd, [2] by qdd, the mass matrix.",
    builder=inverse_dynamics_derivatives,
    inputs=("q", "qd", "qdd"),
    optional=("tip_wrench",),
    shape=(3, "n", "n"),
    unit="N m | N per rad | m, and per s, s^2",
    reference="Singh, Wensing, Echeandia 2022",
    size=_size_of_efforts,
    second=SecondMethod("verification.complex_recursion", _of_efforts),
    needs_mass=True,
)
FORWARD_DYNAMICS_DERIVATIVES = Quantity(
    name="forward_dynamics_derivatives",
    symbol="dqdd/d(q, qd, tau)",
    title="Derivatives of forward dynamics, in closed form: [0] by q, [1] by qd, [2] by tau, the inverse mass matrix.",
    builder=forward_dynamics_derivatives,
    inputs=("q", "qd", "tau"),
    optional=("tip_wrench",),
    shape=(3, "n", "n"),
    unit="rad/s^2 | m/s^2 per rad | m, per their rates, per N m | N",
    reference="Carpentier & Mansard 2018",
    size=_size_of_motion,
    second=SecondMethod("verification.complex_solution", _of_accelerations),
    needs_mass=True,
    solves_mass_matrix=True,
)
