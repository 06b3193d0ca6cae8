"""One step of a closed loop as one expression: measured state and reference in, next state and what is recorded out."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, TypeAlias

import numpy as np

import mafsil.expression as ex
from mafsil.algebra import so3
from mafsil.mechanics.body_tree import BodyTree, lumped
from mafsil.mechanics.frame_choice import in_chosen_frames
from mafsil.mechanics.friction import FrictionLaw, friction_law
from mafsil.mechanics.loop_terms import Loop, input_sizes, output_sizes
from mafsil.mechanics.placement import Expression, constant
from mafsil.mechanics.quantities.forward_dynamics import by_mass_matrix_shorter, forward_dynamics, solved
from mafsil.mechanics.quantities.forward_kinematics import forward_kinematics
from mafsil.mechanics.quantities.inverse_dynamics import inverse_dynamics
from mafsil.mechanics.quantities.mass_matrix import mass_matrix
from mafsil.mechanics.regrouping import regrouped
from mafsil.mechanics.tolerances import NEGLIGIBLE_RATE
from mafsil.mechanics.varied_bodies import body_inertias
from mafsil.model import Mechanism

Row: TypeAlias = tuple[float, ...]


def function(loop: Loop) -> ex.Function:
    """The step as a function, inputs and outputs as `input_sizes` and `output_sizes` say, columns in C order.

    Args:
        loop: what is built.
    """
    sizes = input_sizes(loop)
    x = {name: symbol_of(name, shape) for name, shape in sizes.items()}
    n, trees = loop.plant.n, Trees()
    q, qd = x["state"][:n], x["state"][n:]
    measured_q, measured_qd = (q + x["noise"][:n], qd + x["noise"][n:]) if loop.noisy else (q, qd)
    command, integral = commanded(loop, trees, measured_q, measured_qd, x)
    effort = clipped(command, x["limit"]) if loop.saturated else command
    plant = _Plant(loop, trees.true(loop.plant) if loop.varied else trees.of(loop.plant), effort, x)
    here, rate, first = q, qd, ex.zeros(n, 1)
    for count in range(loop.substeps):
        here, rate, slope = plant.stepped(here, rate, x["step"])
        first = first if count else slope
    T = forward_kinematics(trees.true(loop.shown), q, trees.true(loop.shown).tip)
    desired = ex.reshape(x["T_desired"], 4, 4).T
    distance = ex.sqrt(ex.sumsqr(desired[:3, 3] - T[:3, 3]))
    angle = so3.angle_between(T[:3, :3], desired[:3, :3])
    results = {
        "next_state": ex.vertcat(here, rate), "next_integral": integral, "command": command, "effort": effort,
        "acceleration": first, "tip_errors": ex.vertcat(distance, angle),
    }  # fmt: skip
    return ex.Function("closed_loop", list(x.values()), ex.cse([results[name] for name in output_sizes(loop)]))


class Trees:
    """Trees of mechanisms: equal mechanisms share one, so that their expressions share what they have in common."""

    def __init__(self) -> None:
        self._full: list[tuple[Mechanism, BodyTree, BodyTree]] = []

    def _both(self, mechanism: Mechanism) -> tuple[BodyTree, BodyTree]:
        for known, full, short in self._full:
            if known is mechanism:
                return full, short
        full = in_chosen_frames(lumped(mechanism))
        self._full.append((mechanism, full, regrouped(full)))
        return self._full[-1][1:]

    def of(self, mechanism: Mechanism) -> BodyTree:
        """The shortest tree with the same dynamics."""
        return self._both(mechanism)[1]

    def true(self, mechanism: Mechanism) -> BodyTree:
        """The tree with true frames."""
        return self._both(mechanism)[0]


def symbol_of(name: str, shape: tuple[int, ...]) -> Expression:
    """A column of symbols, the shape's entries in C order."""
    size = 1
    for length in shape:
        size *= length
    return ex.symbol(name, size)


def commanded(
    loop: Loop, trees: Trees, q: Expression, qd: Expression, x: dict[str, Expression]
) -> tuple[Expression, Expression]:
    """Commanded efforts (n,) and the next integrals.

    Args:
        loop: whose law it is.
        trees: of its mechanisms.
        q, qd: (n,) measured.
        x: inputs by name, as `input_sizes` says.
    """
    n = loop.plant.n
    u, v, a = x["reference"][:n], x["reference"][n : 2 * n], x["reference"][2 * n :]
    integrals: list[Expression] = []
    total, row = ex.zeros(n, 1), 0
    for term in loop.terms:
        if term.kind in ("computed_torque", "feedback"):
            kp, kd, ki = (x["gains"][(3 * row + part) * n : (3 * row + part + 1) * n] for part in range(3))
            feedback = kp * (u - q) + kd * (v - qd)
            if loop.integrates:
                integrals.append(x["integral"][row * n : (row + 1) * n] + ki * (u - q))
                feedback = feedback + integrals[-1]
            row += 1
            effort = feedback if term.model is None else _efforts(loop, trees, term.model, q, qd, a + feedback)
        elif term.kind == "given":
            effort = x["given"]
        elif term.kind == "gravity":
            assert term.model is not None
            effort = inverse_dynamics(trees.of(term.model), q, ex.zeros(n, 1), ex.zeros(n, 1))
        else:
            assert term.model is not None
            effort = inverse_dynamics(trees.of(term.model), u, v, a)
        total = total + effort
    return total, ex.vertcat(ex.zeros(0, 1), *integrals)


def _efforts(loop: Loop, trees: Trees, model: Mechanism, q: Expression, qd: Expression, qdd: Expression) -> Expression:
    """Inverse dynamics of the law's model.

    A law that knows the plant and its state shares M and h = c + g with the plant's own step: M qdd + h is shorter.
    """
    tree = trees.of(model)
    if model is not loop.plant or loop.noisy or loop.varied or not by_mass_matrix_shorter(tree):
        return inverse_dynamics(tree, q, qd, qdd)
    return mass_matrix(tree, q) @ qdd + inverse_dynamics(tree, q, qd, ex.zeros(tree.n, 1))


def clipped(command: Expression, limit: Expression) -> Expression:
    """Clipped elementwise; NaN passes through."""
    return ex.vertcat(
        *(
            ex.if_else(command[i] > limit[i], limit[i], ex.if_else(command[i] < -limit[i], -limit[i], command[i]))
            for i in range(command.shape[0])
        )
    )


class _Plant:
    """Steps of the plant under an effort that is constant."""

    def __init__(self, loop: Loop, tree: BodyTree, effort: Expression, x: dict[str, Expression]) -> None:
        self.loop, self.tree, self.effort = loop, tree, effort
        self.friction = None
        if loop.friction is not None:
            self.friction = _Friction(friction_law(loop.plant), loop.friction, x.get("friction"))
        self.F_tip = -x["push"] if loop.pushed else None
        self.inertias = body_inertias(tree, x["bodies"]) if loop.varied else None

    def stepped(self, q: Expression, v: Expression, h: Expression) -> tuple[Expression, Expression, Expression]:
        """State after one step, and the acceleration at its beginning."""
        scheme: tuple[Any, ...] = self.loop.scheme
        if scheme[0] == "runge_kutta":
            return self._runge_kutta(scheme[1], scheme[2], q, v, h)
        if scheme[0] == "splitting":
            return self._splitting(scheme[1], scheme[2], q, v, h)
        acceleration = self._damped(scheme[1], q, v, h)
        v = v + h * acceleration
        return q + h * v, v, acceleration

    def _runge_kutta(
        self, a: Sequence[Row], b: Row, q: Expression, v: Expression, h: Expression
    ) -> tuple[Expression, Expression, Expression]:
        rates: list[Expression] = []
        slopes: list[Expression] = []
        for row in a:
            here, rate = _advanced(q, h, row, rates), _advanced(v, h, row, slopes)
            rates.append(rate)
            slopes.append(self._acceleration(here, rate))
        return _advanced(q, h, b, rates), _advanced(v, h, b, slopes), slopes[0]

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
        if self.inertias is None:
            return forward_dynamics(self.tree, q, v, load, self.F_tip)
        M, bias = self._terms(q, v)
        return solved(M, load - bias)

    def _terms(self, q: Expression, v: Expression) -> tuple[Expression, Expression]:
        """M, and c + g + J' F_tip."""
        M = mass_matrix(self.tree, q, self.inertias)
        bias = inverse_dynamics(self.tree, q, v, ex.zeros(self.tree.n, 1), self.F_tip, inertias=self.inertias)
        return M, bias

    def _damped(self, iterations: int, q: Expression, v: Expression, h: Expression) -> Expression:
        """Acceleration with friction at the end of the step, by the secant of its curve."""
        M, bias = self._terms(q, v)
        load = self.effort - bias
        after, acceleration = v, ex.zeros(self.tree.n, 1)
        if self.friction is None:
            return solved(M, load)
        load = load - self.friction.offset
        for _ in range(iterations):
            slope = self.friction.slope(after)
            acceleration = solved(M + h * slope, load - slope @ v)
            after = v + h * acceleration
        return acceleration


class _Friction:
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
        """D (n, n): D v + offset is the friction at the rates v (n,)."""
        slopes: list[Expression] = []
        w = self.gain @ v
        for i in range(len(self.viscous)):
            coulomb = ex.if_else(w[i] >= 0, self.positive[i], self.negative[i])
            moving = ex.fabs(w[i]) > NEGLIGIBLE_RATE * self.width
            share = ex.if_else(moving, ex.tanh(w[i] / self.width) / ex.if_else(moving, w[i], 1.0), 1.0 / self.width)
            slopes.append(self.viscous[i] + coulomb * share)
        return self.gain.T @ ex.diag(ex.vertcat(*slopes)) @ self.gain


def _advanced(y: Expression, h: Expression, weights: Row, slopes: list[Expression]) -> Expression:
    """The sum y + h sum_i w_i k_i."""
    for weight, slope in zip(weights, slopes, strict=True):
        if weight:
            y = y + (h * weight) * slope
    return y
