"""One integration step of a plant as an expression: of a tree of bodies, or of a closed chain with its loops closed.

The numbers of a plant may vary from run to run: its inertial parameters by body, friction of its joints. Parameters are
regrouped as `regrouping` does it with numbers: what a joint cannot feel moves to its parent, and seven numbers of a
body on a revolute joint are left. Which ones is known beforehand, so expressions get short.

The step of a closed chain, whose driven joints alone get efforts:

1. Newton's method with the shortest steps takes the coordinates that the step before left back to closed loops; the
   matrix of its first step serves the others, which correct far less.
2. Rates lose what would open the loops, with the least kinetic energy.
3. A step of the integrator with the accelerations of the closed chain: mass matrix and rows of the loops are those of
   the second step, so that the whole is shorter than with closed loops at its end.

Reference: Hairer, Lubich and Wanner, Geometric Numerical Integration, sec. IV.4 (standard projection).
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

import mafsil.expression as ex
from mafsil.arrays import Floats
from mafsil.mechanics.body_tree import BodyTree, lump_bodies
from mafsil.mechanics.composite_motion import CompositeInertia
from mafsil.mechanics.frame_choice import in_chosen_frames, regroup
from mafsil.mechanics.friction import FrictionLaw, friction_law
from mafsil.mechanics.inertial_parameters import moved_parameters
from mafsil.mechanics.loop_constraints import gaps, loops
from mafsil.mechanics.loop_dynamics import HeldTree, error_of, spread
from mafsil.mechanics.loop_terms import Holding, Loop
from mafsil.mechanics.placement import Expression, constant
from mafsil.mechanics.quantities.forward_dynamics import forward_dynamics, mass_matrix, solve_mass_matrix
from mafsil.mechanics.quantities.inverse_dynamics import inverse_dynamics
from mafsil.mechanics.tolerances import NEGLIGIBLE_RATE
from mafsil.model import Joint, JointKind, Mechanism

M, HX, HY, HZ, XX, YY, ZZ, XY, XZ, YZ = range(10)
FELT = {
    JointKind.REVOLUTE: (HX, HY, XX, ZZ, XY, XZ, YZ),
    JointKind.PRISMATIC: (M, HX, HY, HZ),
}
"""Parameters that a joint feels after regrouping; of other kinds all ten."""
Row: TypeAlias = tuple[float, ...]


class TreePlant:
    """Steps of the plant under an effort that is constant.

    Args:
        loop: whose plant it is.
        tree: of its bodies.
        effort: (n,) of the motors.
        x: inputs of the loop by name.

    Attributes:
        doubt: of what was solved for closed chains: zero of a tree.
    """

    def __init__(self, loop: Loop, tree: BodyTree, effort: Expression, x: dict[str, Expression]) -> None:
        self.loop, self.tree, self.effort = loop, tree, effort
        self.doubt = ex.Expression(0)
        self.friction = None
        if loop.friction is not None:
            self.friction = Friction(friction_law(loop.plant), loop.friction, x.get("friction"))
        self.F_tip = -x["push"] if loop.pushed else None
        self.inertias = body_inertias(tree, x["bodies"]) if loop.varied else None

    def step(self, q: Expression, v: Expression, h: Expression) -> tuple[Expression, Expression, Expression]:
        """State after one step, and the acceleration at its beginning.

        Args:
            q, v: (n,) coordinates and rates.
            h: length of the step.
        """
        scheme: tuple[Any, ...] = self.loop.scheme
        if scheme[0] == "runge_kutta":
            return self._runge_kutta(scheme[1], scheme[2], q, v, h)
        if scheme[0] == "splitting":
            return self._splitting(scheme[1], scheme[2], q, v, h)
        acceleration = self._damp(scheme[1], q, v, h)
        v = v + h * acceleration
        return q + h * v, v, acceleration

    def _runge_kutta(
        self, a: Sequence[Row], b: Row, q: Expression, v: Expression, h: Expression
    ) -> tuple[Expression, Expression, Expression]:
        rates: list[Expression] = []
        slopes: list[Expression] = []
        for row in a:
            here, rate = weighted_step(q, h, row, rates), weighted_step(v, h, row, slopes)
            rates.append(rate)
            slopes.append(self._acceleration(here, rate))
        return weighted_step(q, h, b, rates), weighted_step(v, h, b, slopes), slopes[0]

    def _splitting(
        self, kicks: Row, drifts: Row, q: Expression, v: Expression, h: Expression
    ) -> tuple[Expression, Expression, Expression]:
        slopes: list[Expression] = []
        for kick, drift in zip(kicks, drifts, strict=True):
            slopes.append(self._acceleration(q, v))
            v = v + (kick * h) * slopes[-1]
            q = q + (drift * h) * v
        return q, v, slopes[0]

    def _acceleration(self, q: Expression, v: Expression) -> Expression:
        load = self.effort
        if self.friction is not None:
            load = load - self.friction.slope(v) @ v - self.friction.offset
        return self._free(q, v, load)

    def _free(self, q: Expression, v: Expression, load: Expression) -> Expression:
        """Accelerations under efforts of motors and friction."""
        if self.inertias is None:
            return forward_dynamics(self.tree, q, v, load, self.F_tip)
        M, bias = self._terms(q, v)
        return solve_mass_matrix(M, load - bias)

    def _solve(self, M: Expression, load: Expression, q: Expression, v: Expression) -> Expression:
        """Accelerations with M as the inertia, bias forces taken away already; a tree needs no state for that."""
        return solve_mass_matrix(M, load)

    def _terms(self, q: Expression, v: Expression) -> tuple[Expression, Expression]:
        """M, and c + g + J' F_tip."""
        M = mass_matrix(self.tree, q, self.inertias)
        bias = inverse_dynamics(self.tree, q, v, ex.zeros(self.tree.n, 1), self.F_tip, inertias=self.inertias)
        return M, bias

    def _damp(self, iterations: int, q: Expression, v: Expression, h: Expression) -> Expression:
        """Acceleration with friction at the end of the step, by the secant of its curve."""
        M, bias = self._terms(q, v)
        load = self.effort - bias
        after, acceleration = v, ex.zeros(self.tree.n, 1)
        if self.friction is None:
            return self._solve(M, load, q, v)
        load = load - self.friction.offset
        for _ in range(iterations):
            slope = self.friction.slope(after)
            acceleration = self._solve(M + h * slope, load - slope @ v, q, v)
            after = v + h * acceleration
        return acceleration


class Friction:
    """Friction as the secants of its curves.

    Args:
        law: of the joints.
        width: of the smoothed Coulomb part.
        rows: viscous, positive, negative and offset of joint after joint instead of the law's numbers, or None.
    """

    def __init__(self, law: FrictionLaw, width: float, rows: Expression | None) -> None:
        self.width, self.gain = width, constant(law.gain)
        count = len(law.viscous)
        numbers = ex.Expression(np.stack([law.viscous, law.positive, law.negative, law.offset], axis=1).ravel())
        given = numbers if rows is None else rows
        self.viscous, self.positive, self.negative, offset = (
            [given[4 * i + k] for i in range(count)] for k in range(4)
        )
        self.offset = self.gain.T @ ex.vertcat(ex.zeros(0, 1), *offset)

    def slope(self, v: Expression) -> Expression:
        """D (n, n): D v + offset is the friction at given rates.

        Args:
            v: (n,) rates.
        """
        slopes: list[Expression] = []
        w = self.gain @ v
        for i in range(len(self.viscous)):
            coulomb = ex.if_else(w[i] >= 0, self.positive[i], self.negative[i])
            moving = ex.fabs(w[i]) > NEGLIGIBLE_RATE * self.width
            share = ex.if_else(moving, ex.tanh(w[i] / self.width) / ex.if_else(moving, w[i], 1.0), 1.0 / self.width)
            slopes.append(self.viscous[i] + coulomb * share)
        return self.gain.T @ ex.diag(ex.vertcat(*slopes)) @ self.gain


def weighted_step(y: Expression, h: Expression, weights: Row, slopes: list[Expression]) -> Expression:
    """The sum y + h sum_i w_i k_i.

    Args:
        y, slopes: (n,) each.
        h: length of the step.
        weights: w_i.
    """
    for weight, slope in zip(weights, slopes, strict=True):
        if weight:
            y = y + (h * weight) * slope
    return y


def body_parameters(mechanism: Mechanism, parameters: Floats, payload: Floats | None = None) -> Floats:
    """(*batch, bodies, 10) regrouped parameters of the moving bodies, from those of the links that they carry.

    Args:
        mechanism: whose links they are.
        parameters: (*batch, L, 10) of the links, each in its own frame, as `inertial_parameters` orders them.
        payload: (*batch, 10) of a body fixed to the tip, in the tip frame; None for none.
    """
    tree = in_chosen_frames(lump_bodies(mechanism))
    batch = parameters.shape[:-2] if payload is None else np.broadcast_shapes(parameters.shape[:-2], payload.shape[:-1])
    bodies = np.zeros((*batch, len(tree.bodies), 10))
    for k, frame in enumerate(tree.frames.values()):
        bodies[..., frame.body, :] += moved_parameters(parameters[..., k, :], frame.R, frame.p)
    if payload is not None:
        bodies[..., tree.tip.body, :] += moved_parameters(payload, tree.tip.R, tree.tip.p)
    for i, body in reversed(tree.moving):
        passed = _pass(body.kind, bodies[..., i, :])
        bodies[..., i, :] -= passed
        bodies[..., body.parent, :] += moved_parameters(passed, body.R, body.p)
    return bodies[..., 1:, :]


def body_inertias(tree: BodyTree, parameters: Expression) -> list[CompositeInertia]:
    """Inertias of all bodies, base first, from regrouped parameters (10 (bodies - 1),) as expressions."""
    inertias = [CompositeInertia.of_parameters([ex.Expression(0.0)] * 10)]
    for i, body in tree.moving:
        felt = FELT.get(body.kind, range(10))
        at = 10 * (i - 1)
        inertias.append(
            CompositeInertia.of_parameters([parameters[at + k] if k in felt else ex.Expression(0.0) for k in range(10)])
        )
    return inertias


def friction_rows(mechanism: Mechanism) -> Floats:
    """(k, 4) viscous, Coulomb in either sense and offset of all joints that have friction."""
    law = friction_law(mechanism)
    return np.stack([law.viscous, law.positive, law.negative, law.offset], axis=1)


def _pass(kind: JointKind, parameters: Floats) -> Floats:
    """What of a body its joint does not feel."""
    passed = np.zeros_like(parameters)
    if kind is JointKind.REVOLUTE:
        passed[..., [M, HZ]] = parameters[..., [M, HZ]]
        passed[..., [XX, YY]] = parameters[..., YY, None]
    elif kind is JointKind.PRISMATIC:
        passed[..., XX:] = parameters[..., XX:]
    return passed


CORRECTIONS = 2
"""Steps of Newton's method after the first, each some thousand times as short as the one before."""


class HeldPlant(TreePlant):
    """Steps of a closed chain under an effort that is constant.

    Args:
        loop: whose plant it is.
        holding: how its loops hold it.
        tree: of its bodies.
        effort: (n,) of the motors; that of joints that are not driven does nothing.
        x: inputs of the loop by name.

    Attributes:
        doubt: sum over all that was solved so far; see `HeldTree`.
    """

    def __init__(
        self, loop: Loop, holding: Holding, tree: BodyTree, effort: Expression, x: dict[str, Expression]
    ) -> None:
        driven = ex.vertcat(ex.zeros(0, 1), *(effort[k] for k in holding.driven))
        super().__init__(loop, tree, spread(driven, holding.driven, tree.n), x)
        self.holding, self.joints = holding, loop.plant.loops

    def _free(self, q: Expression, v: Expression, load: Expression) -> Expression:
        M, bias = self._terms(q, v)
        return self._solve(M, load - bias, q, v)

    def _solve(self, M: Expression, load: Expression, q: Expression, v: Expression) -> Expression:
        asked = loops(self.tree, self.joints, q, v)
        held = HeldTree(M, asked.rows, self.holding.rows)
        qdd, _ = held.accelerations(load, asked.bias)
        self.doubt = self.doubt + held.distrust(qdd, asked.bias)
        return qdd


def closed_state(
    tree: BodyTree,
    joints: Sequence[Joint],
    holding: Holding,
    q: Expression,
    v: Expression,
    inertias: Sequence[CompositeInertia] | None = None,
) -> tuple[Expression, Expression, Expression, Expression]:
    """Coordinates (n,) that close the loops, rates (n,) that keep them closed, the largest gap left, and the doubt.

    Args:
        tree: the bodies.
        joints: that close the loops.
        holding: their independent rows.
        q, v: (n,) coordinates near closed loops, and rates.
        inertias: of the bodies, where they are not the tree's own numbers.
    """
    rest = ex.zeros(tree.n, 1)
    asked = loops(tree, joints, q, rest)
    flat = HeldTree(ex.eye(tree.n), asked.rows, holding.rows)
    q = q + flat.accelerations(rest, asked.gap)[0]
    for _ in range(CORRECTIONS):
        q = q + flat.accelerations(rest, gaps(tree, joints, q)[0])[0]
    after = loops(tree, joints, q, rest)
    held = HeldTree(mass_matrix(tree, q, inertias), after.rows, holding.rows)
    error = error_of(after.gap, after.facing)
    v = held.closing(v)
    doubt = flat.doubt + held.doubt + error / holding.tolerance + held.finite(ex.vertcat(q, v))
    return q, v, error, doubt


def closing_function(mechanism: Mechanism, holding: Holding) -> ex.Function:
    """Coordinates and rates taken back to closed loops: q, v (n,) to both (n,), the largest gap left, and the doubt.

    Args:
        mechanism: with loops.
        holding: their independent rows.
    """
    tree = regroup(in_chosen_frames(lump_bodies(mechanism)))
    q, v = ex.symbol("q", tree.n), ex.symbol("qd", tree.n)
    return ex.Function("closed_state", [q, v], ex.cse([*closed_state(tree, mechanism.loops, holding, q, v)]))


def step_function(loop: Loop, holding: Holding) -> ex.Function:
    """A step and what takes its end back to closed loops: q, qd, tau (n,) and the length to q, qd (n,), gap and doubt.

    Args:
        loop: whose plant it is; a push is an input behind the length.
        holding: how its loops hold it.
    """
    tree = regroup(in_chosen_frames(lump_bodies(loop.plant)))
    q, v, tau, h = ex.symbol("q", tree.n), ex.symbol("qd", tree.n), ex.symbol("tau", tree.n), ex.symbol("step", 1)
    x = {"push": ex.symbol("push", 6)} if loop.pushed else {}
    plant = HeldPlant(loop, holding, tree, tau, x)
    here, rate, _ = plant.step(q, v, h)
    here, rate, error, doubt = closed_state(tree, loop.plant.loops, holding, here, rate)
    outputs = [here, rate, error, doubt + plant.doubt]
    return ex.Function("closed_step", [q, v, tau, h, *x.values()], ex.cse(outputs))
