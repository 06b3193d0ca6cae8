"""One integration step of a plant as an expression: a tree of bodies under constant efforts."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

import mafsil.expression as ex
from mafsil.mechanics.body_tree import BodyTree
from mafsil.mechanics.friction import FrictionLaw, friction_law
from mafsil.mechanics.loop_terms import Loop
from mafsil.mechanics.placement import Expression, constant
from mafsil.mechanics.quantities.forward_dynamics import forward_dynamics, solve_mass_matrix
from mafsil.mechanics.quantities.inverse_dynamics import inverse_dynamics
from mafsil.mechanics.quantities.mass_matrix import mass_matrix
from mafsil.mechanics.tolerances import NEGLIGIBLE_RATE
from mafsil.mechanics.varied_bodies import body_inertias

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
