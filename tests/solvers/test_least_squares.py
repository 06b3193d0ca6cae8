"""The damped step solves its normal equations; the iteration converges, or says why not."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil.solvers import damped_step, levenberg_marquardt
from mafsil.solvers.outcome import SolverStatus


@pytest.mark.parametrize("shape", [(6, 7), (6, 6), (6, 2), (3, 1), (1, 3)])
@pytest.mark.parametrize("rows", [0, 1, 47, 48, 511, 513, 1025])
def test_step_solves_the_normal_equations(shape, rows):
    rng = np.random.default_rng(rows)
    J = rng.normal(size=(rows, *shape))
    r = rng.normal(size=(rows, shape[0]))
    damping = rng.uniform(0.01, 2.0, rows)
    dx = damped_step(J, r, damping)
    left = (np.einsum("kmi,kmj->kij", J, J) @ dx[..., None])[..., 0] + damping[:, None] * dx
    np.testing.assert_allclose(left, np.einsum("kmi,km->ki", J, r), atol=1e-11)


@pytest.mark.parametrize("rows", [3, 60])
def test_singular_rows_are_nan_and_alone(rows):
    rng = np.random.default_rng(0)
    J, r = rng.normal(size=(rows, 2, 2)), rng.normal(size=(rows, 2))
    clean = damped_step(J, r, np.zeros(rows))
    J[1] = 0.0
    spoilt = damped_step(J, r, np.zeros(rows))
    assert np.isnan(spoilt[1]).all()
    np.testing.assert_allclose(np.delete(spoilt, 1, 0), np.delete(clean, 1, 0), rtol=1e-12)


def rosenbrock(x):
    return np.array([10 * (x[1] - x[0] ** 2), 1 - x[0]]), np.array([[-20 * x[0], 10.0], [-1.0, 0.0]])


def test_rosenbrock():
    outcome = levenberg_marquardt(rosenbrock, np.array([-1.2, 1.0]))
    assert outcome.status is SolverStatus.CONVERGED
    np.testing.assert_allclose(outcome.value, 1.0, atol=1e-10)
    assert len(outcome.history) == outcome.iterations + 1
    assert "converged" in outcome.explain("en")


def test_no_solution_is_a_stall():
    outcome = levenberg_marquardt(lambda x: (np.array([x[0] ** 2 + 1.0]), np.array([[2 * x[0]]])), np.array([3.0]))
    assert outcome.status is SolverStatus.STALLED
    assert not outcome.succeeded
    assert outcome.residual == pytest.approx(1.0, abs=1e-6)


def test_budget_and_nan_are_told_apart():
    assert levenberg_marquardt(rosenbrock, np.array([-1.2, 1.0]), iterations=3).status is SolverStatus.BUDGET_SPENT
    bad = levenberg_marquardt(lambda x: (np.array([np.nan]), np.ones((1, 1))), np.array([1.0]))
    assert bad.status is SolverStatus.NOT_FINITE
    for outcome in (bad, levenberg_marquardt(rosenbrock, np.zeros(2), iterations=1)):
        assert outcome.explain("en")
        assert outcome.explain("ar")
