"""The shortest vector within inequalities: by hand, by a general method, and shared evenly between equal rows."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import minimize

from mafsil.solvers.linear_program import least_distance


def test_by_hand():
    x, p = least_distance(np.eye(2), np.array([1.0, -3.0]))
    np.testing.assert_allclose(x, [1.0, 0.0], atol=1e-15)
    np.testing.assert_allclose(p, [1.0, 0.0], atol=1e-15)
    x, p = least_distance(np.array([[1.0, 1.0], [1.0, -1.0], [1.0, 0.0]]), np.array([2.0, 2.0, 1.0]))
    np.testing.assert_allclose(x, [2.0, 0.0], atol=1e-14)
    np.testing.assert_allclose(p, [1.0, 1.0, 0.0], atol=1e-14)
    for alike in (2, 3):
        x, p = least_distance(np.ones((alike, 1)), np.full(alike, 0.6))
        np.testing.assert_allclose(x, [0.6])
        np.testing.assert_allclose(p, 0.6 / alike, rtol=1e-12)
    x, p = least_distance(np.array([[0.0, 0.0], [0.0, 2.0]]), np.array([0.0, 4.0]))
    np.testing.assert_allclose(x, [0.0, 2.0])
    assert not least_distance(np.eye(2), np.array([-1.0, 0.0]))[0].any()


@pytest.mark.parametrize("seed", range(10))
def test_by_a_general_method(seed):
    rng = np.random.default_rng(seed)
    r, k = int(rng.integers(2, 5)), int(rng.integers(2, 7))
    H, inside = rng.normal(size=(k, r)), rng.normal(size=r)
    need = H @ inside - rng.uniform(0, 1, k)
    x, p = least_distance(H, need)
    known = minimize(
        lambda y: y @ y, inside, jac=lambda y: 2.0 * y, method="SLSQP", tol=1e-15,
        constraints={"type": "ineq", "fun": lambda y: H @ y - need, "jac": lambda y: H},
    )  # fmt: skip
    np.testing.assert_allclose(x, known.x, atol=1e-6)
    np.testing.assert_allclose(x, H.T @ p, atol=1e-10)
    assert (p >= 0.0).all()
    assert np.abs(p * (H @ x - need)).max() < 1e-9
