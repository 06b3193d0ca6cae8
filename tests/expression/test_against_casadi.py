"""Values and derivatives of expressions against CasADi's, and against the same program without any simplification."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import casadi as ca
import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

import mafsil.expression as ex
from tests.oracles.casadi_expression import BINARY, UNARY

SYMBOLS = 3
CONSTANTS = (0.0, 1.0, -1.0, 2.0, 0.5, -2.0, 3.0, 0.25, 1.7, 1.0 / 3.0)
ONE = {
    "neg": lambda x: -x,
    "sq": lambda x: x**2,
    "twice": lambda x: 2.0 * x,
    "inv": lambda x: 1.0 / x,
    "not": ex.logic_not,
    **{name: getattr(ex, name) for name in UNARY if name not in ("neg", "sq", "twice", "inv", "not")},
}
TWO = {
    "add": lambda x, y: x + y,
    "sub": lambda x, y: x - y,
    "mul": lambda x, y: x * y,
    "div": lambda x, y: x / y,
    "pow": ex.power,
    "lt": lambda x, y: x < y,
    "le": lambda x, y: x <= y,
    "eq": ex.equal,
    "ne": ex.unequal,
    "and": ex.logic_and,
    "or": ex.logic_or,
    "if_else_zero": lambda x, y: ex.if_else(x, y, 0.0),
    **{name: getattr(ex, name) for name in ("fmin", "fmax", "atan2", "copysign")},
}
SMOOTH_ONE = ("neg", "sq", "twice", "inv", "sqrt", "exp", "log", "sin", "cos", "tan", "atan", "tanh")
SMOOTH_TWO = ("add", "sub", "mul", "div", "atan2", "add", "sub", "mul")

Step = tuple[str, int, int]
Operations = dict[str, Callable[..., Any]]


def programs(one: tuple[str, ...], two: tuple[str, ...], most: int = 14) -> st.SearchStrategy[list[Step]]:
    """Programs: operation k acts on any two earlier values, symbols first, then constants."""
    step = st.tuples(st.sampled_from((*one, *two, *two)), st.integers(0, 10**6), st.integers(0, 10**6))
    return st.lists(step, min_size=1, max_size=most)


def run(
    program: list[Step], leaves: list[Any], one: dict[str, Callable[..., Any]], two: dict[str, Callable[..., Any]]
) -> list[Any]:
    """All values of the program; operands are drawn from the most recent values rather than old ones."""
    values = list(leaves)
    for op, i, j in program:
        x, y = values[-1 - i % len(values)], values[-1 - j % len(values)]
        values.append(one[op](x) if op in one else two[op](x, y))
    return values


def both(program: list[Step]) -> tuple[ex.Function, ca.Function]:
    """Our function of the program's last value, and CasADi's of all its values, which simplifies nothing."""
    x = ex.symbol("x", SYMBOLS)
    ours = ex.Function("f", [x], [ex.expression(run(program, [*x, *map(ex.Expression, CONSTANTS)], ONE, TWO)[-1])])
    ca.GlobalOptions.setSimplificationOnTheFly(False)
    try:
        y = ca.SX.sym("y", SYMBOLS)
        leaves = [*ca.vertsplit(y), *map(ca.SX, CONSTANTS)]
        theirs = ca.Function("f", [y], [ca.vertcat(*run(program, leaves, UNARY, BINARY))])
    finally:
        ca.GlobalOptions.setSimplificationOnTheFly(True)
    return ours, theirs


def spread(function: ca.Function, point: np.ndarray) -> tuple[float, float]:
    """The last value, and how far it differs near the point: what rounding of operands may do, or a step nearby.

    Infinite where a value of the program has no finite number: rules take values for finite.
    """
    here = np.array(function(point)).ravel()
    near = [np.array(function(point * (1 + shift))).ravel() for shift in (1e-9, -1e-9, 3e-10)]
    doubt = max(abs(x[-1] - here[-1]) for x in near) if np.isfinite([*near, here]).all() else np.inf
    return float(here[-1]), float(doubt)


@settings(max_examples=400, deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
@given(programs(tuple(ONE), tuple(TWO)), st.integers(0, 2**31))
def test_values(program: list[Step], seed: int) -> None:
    ours, theirs = both(program)
    point = np.random.default_rng(seed).uniform(0.2, 1.4, SYMBOLS)
    expected, doubt = spread(theirs, point)
    assume(doubt < 1e-6 * (1 + abs(expected)))
    found = float(ours(point))
    assert abs(found - expected) <= 1e-9 * (1.0 + abs(expected)) + 10.0 * doubt


@settings(max_examples=300, deadline=None, suppress_health_check=[HealthCheck.filter_too_much])
@given(programs(SMOOTH_ONE, SMOOTH_TWO), st.integers(0, 2**31))
def test_derivatives(program: list[Step], seed: int) -> None:
    ours, theirs = both(program)
    (x,), (f,) = ours.inputs, ours.outputs
    point = np.random.default_rng(seed).uniform(0.2, 1.4, SYMBOLS)
    y = ca.SX.sym("y", SYMBOLS)
    slope = ca.Function("g", [y], [ca.densify(ca.jacobian(theirs(y)[-1], y))])
    bend = ca.Function("h", [y], [ca.densify(ca.hessian(theirs(y)[-1], y)[0])])
    expected, second = np.array(slope(point)).ravel(), np.array(bend(point))
    assume(np.isfinite(expected).all() and np.isfinite(second).all() and np.abs(second).max() < 1e6)
    found = ex.Function("g", [x], [ex.gradient(f, x), ex.jacobian(f, x).T, *ex.hessian(f, x)]).call([point])
    size = 1e-8 * (1.0 + np.abs(expected).max() + np.abs(second).max())
    for way in (found[0], found[1], found[3]):
        assert np.abs(way.full().ravel() - expected).max() <= size
    assume(np.abs(second).max() < 1e4)
    assert np.abs(found[2].full() - second).max() <= 1e-6 * (1.0 + np.abs(second).max()) ** 2
    assert np.array_equal(found[2].full(), found[2].full().T)
    direction = ex.symbol("v", SYMBOLS)
    along = ex.Function("j", [x, direction], [ex.jtimes(f, x, direction)]).call([point, np.array([1.0, -2.0, 0.5])])[0]
    assert abs(float(along) - expected @ [1.0, -2.0, 0.5]) <= 10.0 * size


@pytest.mark.parametrize("shape", [(2, 7), (7, 2), (1, 5), (5, 1)])
def test_jacobians_of_many_by_few_and_few_by_many(shape: tuple[int, int]) -> None:
    m, n = shape
    rng = np.random.default_rng(m)
    x, A = ex.symbol("x", n), rng.normal(size=(m, n))
    f = ex.sin(A @ x) * ex.sumsqr(x)
    point = rng.normal(size=n)
    (found,) = ex.Function("J", [x], [ex.jacobian(f, x)]).call([point])
    inner = A @ point
    expected = np.cos(inner)[:, None] * A * (point @ point) + np.sin(inner)[:, None] * (2 * point)
    assert np.abs(found.full() - expected).max() < 1e-12


def test_derivative_of_a_branch_that_is_not_taken_passes_no_nan() -> None:
    x = ex.symbol("x")
    f = ex.if_else(x > 0.0, ex.sqrt(x), 0.0) * x
    (found,) = ex.Function("g", [x], [ex.gradient(f, x)]).call([-1.0])
    assert float(found) == 0.0


@pytest.mark.parametrize("value", [0.0, 1.0, -0.249, 2.0, float("nan")])
def test_twice_not_is_a_truth_value_whatever_it_is_asked_of(value: float) -> None:
    x = ex.symbol("x")
    twice = ex.logic_not(ex.logic_not(x))
    of_a_truth = ex.logic_not(ex.logic_not(x < 1.0))
    chosen = ex.if_else(twice, 3.0, 5.0)
    found = ex.Function("f", [x], [twice, of_a_truth, chosen]).call([value])
    assert [float(y) for y in found] == [float(value != 0.0), float(value < 1.0), 3.0 if value != 0.0 else 5.0]


def test_steps_have_slope_zero() -> None:
    x = ex.symbol("x")
    for f in (ex.floor(x), ex.ceil(x), ex.sign(x), x < 0.5, ex.logic_not(x)):
        assert ex.gradient(f, x).is_zero()
