"""Matrices of expressions: shapes, indices, products; what is simplified; substitution; functions."""

from __future__ import annotations

import gc
import pickle
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil.expression as ex
from mafsil.errors import OperandError
from mafsil.expression.node import Node

A = np.arange(12.0).reshape(3, 4) + 1.0
B = np.sin(np.arange(12.0)).reshape(4, 3)


def value(x: ex.Expression) -> np.ndarray:
    return ex.evalf(x).full()


@pytest.mark.parametrize(
    "index",
    [(1, 2), (-1, -1), (slice(None), 0), (0, slice(None)), (slice(1, 3), slice(0, 4, 2)), (slice(None, None, -1), 1)],
)
def test_indices_are_those_of_numpy(index: Any) -> None:
    rows, columns = (i if isinstance(i, slice) else slice(i, i + 1 or None) for i in index)
    assert np.array_equal(value(ex.Expression(A)[index]), A[rows, columns])


def test_one_index_counts_column_by_column() -> None:
    x = ex.Expression(A)
    assert [float(x[k]) for k in (0, 3, 11, -1)] == [1.0, 2.0, 12.0, 12.0]
    column = ex.Expression([1.0, 2.0, 3.0])
    assert value(column[1:]).ravel().tolist() == [2.0, 3.0]
    assert column.T[:2].shape == (1, 2)
    with pytest.raises(OperandError, match="slice"):
        x[1:2]
    with pytest.raises(IndexError):
        x[12]


def test_elements_and_blocks_are_replaced() -> None:
    x, copy = ex.Expression(A), A.copy()
    kept = ex.Expression(x)
    x[1, 2], copy[1, 2] = 7.0, 7.0
    x[:2, :2], copy[:2, :2] = np.eye(2), np.eye(2)
    x[2, :], copy[2, :] = 0.0, 0.0
    assert np.array_equal(value(x), copy)
    assert np.array_equal(value(kept), A)
    with pytest.raises(OperandError, match="fit"):
        x[:2, :2] = np.eye(3)


def test_numpy_leaves_operators_to_expressions() -> None:
    x = ex.symbol("x", 3)
    for mixed in (
        A[:, :3] @ x,
        A[0, :3] * x,
        np.float64(2.0) * x,
        A[0, :3] + x,
        A[0, :3] - x,
        A[0, :3] / x,
        x * A[0, 0],
    ):
        assert isinstance(mixed, ex.Expression)
        assert mixed.shape == (3, 1)
    assert (A[:, :3].T @ A[:, :3] @ x).shape == (3, 1)


@pytest.mark.parametrize(
    ("found", "expected"),
    [
        (lambda: ex.Expression(A) @ B, A @ B),
        (lambda: 2.0 * ex.Expression(A) / 4.0 - 1.0, 2.0 * A / 4.0 - 1.0),
        (lambda: ex.Expression(A).T, A.T),
        (lambda: ex.vertcat(A, B.T), np.vstack([A, B.T])),
        (lambda: ex.horzcat(A, B.T), np.hstack([A, B.T])),
        (lambda: ex.vertcat(ex.Expression(0, 1), 1.0, 2.0), [[1.0], [2.0]]),
        (lambda: ex.blockcat([[A, B.T], [B.T, A]]), np.block([[A, B.T], [B.T, A]])),
        (lambda: ex.diagcat([[1.0, 2.0]], 3.0), [[1.0, 2.0, 0.0], [0.0, 0.0, 3.0]]),
        (lambda: ex.reshape(ex.Expression(A), 2, 6), A.reshape(2, 6, order="F")),
        (lambda: ex.vec(ex.Expression(A)), A.reshape(12, 1, order="F")),
        (lambda: ex.repmat(ex.Expression(A), 2, 3), np.tile(A, (2, 3))),
        (lambda: ex.diag([1.0, 2.0]), np.diag([1.0, 2.0])),
        (lambda: ex.diag(A[:, :3]), np.diag(A[:, :3])[:, None]),
        (lambda: ex.trace(ex.Expression(A[:, :3])), [[np.trace(A[:, :3])]]),
        (lambda: ex.cross(A[:, 0], B[0]), np.cross(A[:, 0], B[0])[:, None]),
        (lambda: ex.skew(A[:, 0]) @ B[0], np.cross(A[:, 0], B[0])[:, None]),
        (lambda: ex.eye(3) + ex.ones(3, 3) - ex.zeros(3, 3), np.eye(3) + 1.0),
        (lambda: abs(-ex.Expression(A)), A),
        (lambda: ex.vertsplit(ex.Expression(A))[1], A[1:2]),
    ],
)  # fmt: skip
def test_matrices_against_numpy(found: Callable[[], ex.Expression], expected: Any) -> None:
    assert np.allclose(value(found()), expected, rtol=1e-15, atol=1e-15)


@settings(max_examples=60, deadline=None)
@given(st.integers(1, 4), st.integers(0, 2**31))
def test_determinant_and_solution(n: int, seed: int) -> None:
    M, b = np.random.default_rng(seed).normal(size=(n, n)), np.arange(1.0, n + 1)
    assert float(ex.det(ex.Expression(M))) == pytest.approx(np.linalg.det(M), rel=1e-9, abs=1e-12)
    if n <= 3:
        x = value(ex.solve(ex.Expression(M), ex.Expression(b))).ravel()
        assert np.abs(M @ x - b).max() <= 1e-11 * np.linalg.cond(M) * max(1.0, np.abs(x).max())


def only(x: ex.Expression) -> Node:
    (node,) = x.entries
    return node


def test_what_is_simplified() -> None:
    x, y = ex.symbol("x"), ex.symbol("y")
    for same in (x + 0, 0 + x, x * 1, x / 1, -(0 - x), x - 0, (x + y) - y, (x * y) / y, 2 * (0.5 * x), ex.sqrt(x) ** 2):
        assert only(same) is only(x)
    for zero in (x * 0, 0 * x, x - x, 0 / x, (x + y) - (x + y)):
        assert zero.is_zero()
    for one in (x / x, ex.cos(x) ** 2 + ex.sin(x) ** 2, x**0):
        assert float(one) == 1.0
    assert only(x + x).op == "twice"
    assert only(x * x).op == "sq"
    assert only(x + (-y)).op == "sub"
    assert only((-x) * (-y)).op == "mul"
    assert only(ex.fabs(x**2)).op == "sq"
    assert float(ex.Expression(2.0) * 3.0 + 1.0) == 7.0


def test_comparisons_of_numbers_are_decided_and_of_symbols_refused() -> None:
    x = ex.symbol("x")
    assert ex.Expression(1.0) < 2.0
    assert not ex.Expression(3.0) <= 2.0
    with pytest.raises(OperandError, match="not a number"):
        bool(x < 1.0)
    with pytest.raises(OperandError, match="equal"):
        x == 1.0  # noqa: B015
    with pytest.raises(OperandError, match="not a number"):
        x.full()


def test_wrong_shapes_are_refused_by_their_numbers() -> None:
    x = ex.symbol("x", 3)
    calls: list[Callable[[], object]] = [
        lambda: x + ex.symbol("y", 4),
        lambda: x @ x,
        lambda: ex.vertcat(ex.eye(2), ex.eye(3)),
        lambda: ex.horzcat(ex.eye(2), ex.eye(3)),
        lambda: ex.dot(x, ex.eye(2)),
        lambda: ex.cross(x, ex.symbol("y", 2)),
        lambda: ex.reshape(x, 2, 2),
        lambda: ex.det(x),
        lambda: ex.solve(ex.eye(4), ex.symbol("b", 4)),
        lambda: ex.gradient(x, x),
        lambda: ex.gradient(x[0], x + 1.0),
        lambda: ex.jtimes(x, x, x[:2]),
        lambda: ex.substitute(x, x, x[:2]),
        lambda: ex.Expression([[1.0], [1.0, 2.0]]),
        lambda: ex.Expression(np.zeros((2, 2, 2))),
        lambda: ex.Function("f", [x], [x]).call([1.0]),
        lambda: ex.Function("f", [x[:2]], [x]),
        lambda: ex.Function("f", [x + 1.0], [x]),
        lambda: ex.evalf(x),
    ]
    for call in calls:
        with pytest.raises(OperandError):
            call()


def test_substitution_is_simultaneous() -> None:
    x, y = ex.symbol("x"), ex.symbol("y")
    f, g = ex.substitute([x - 2 * y, x * y], [x, y], [y, x])
    swapped = ex.Function("f", [x, y], [f, g]).call([3.0, 5.0])
    assert [float(each) for each in swapped] == [5.0 - 6.0, 15.0]
    assert float(ex.substitute(ex.sin(x) * y, ex.vertcat(x, y), ex.Expression([0.5, 2.0]))) == 2.0 * np.sin(0.5)


def test_common_subexpressions_are_built_once() -> None:
    x, y = ex.symbol("x"), ex.symbol("y")
    f = ex.vertcat(ex.sin(x * y) + 1.5, ex.cos(ex.sin(y * x + 0.0)), ex.sin(x * y))
    before, after = ex.Function("f", [x, y], [f]), ex.Function("f", [x, y], [f], cse=True)
    assert len(after.order) < len(before.order)
    assert np.array_equal(*(f.call([0.3, 0.7])[0].full() for f in (before, after)))


def test_a_function_takes_numbers_and_expressions() -> None:
    x = ex.symbol("x", 2)
    f = ex.Function("f", [x], [ex.vertcat(x[0] * x[1], ex.atan2(x[0], x[1]))])
    assert value(f([2.0, 3.0])).ravel().tolist() == [6.0, np.arctan2(2.0, 3.0)]
    y = ex.symbol("y")
    again = ex.Function("g", [y], [f(ex.vertcat(y, y + 1.0))])
    assert np.array_equal(value(again(2.0)), value(f([2.0, 3.0])))


def test_free_symbols_are_listed_in_order() -> None:
    x = ex.symbol("x", 3)
    f = ex.sin(x[2]) * x[0]
    assert [only(s) for s in ex.symvar(f)] == [only(x[2]), only(x[0])]


def alive() -> int:
    gc.collect()
    return sum(isinstance(each, Node) for each in gc.get_objects())


def test_deep_expressions_need_no_stack_and_are_freed() -> None:
    x = ex.symbol("x")
    known, f = alive(), x
    for k in range(30_000):
        f = ex.sin(f) + 0.001 * (k % 7)
    (slope,) = ex.Function("g", [x], [ex.gradient(f, x)]).call([0.5])
    assert np.isfinite(float(slope))
    total = 0.5
    for k in range(30_000):
        total = np.sin(total) + 0.001 * (k % 7)
    assert float(ex.substitute(f, x, ex.Expression(0.5))) == pytest.approx(total, rel=1e-12)
    del f, slope
    assert alive() == known


def test_what_numbers_do_beyond_their_range() -> None:
    x = ex.symbol("x")
    f = ex.vertcat(
        1 / x, ex.log(x), ex.sqrt(x - 1), ex.exp(1000 * (x + 1)), ex.floor(1 / x), ex.fmax(x, ex.sqrt(x - 1))
    )
    found = value(ex.Function("f", [x], [f])(0.0)).ravel()
    assert found[0] == np.inf
    assert found[1] == -np.inf
    assert np.isnan(found[2])
    assert found[3] == np.inf
    assert found[4] == np.inf
    assert found[5] == 0.0


def test_constants_travel_as_arrays() -> None:
    x = ex.Expression(A)
    assert np.array_equal(np.asarray(x), A)
    assert np.array_equal(pickle.loads(pickle.dumps(x.full())), A)
    assert repr(x) == "Expression(3x4)"
