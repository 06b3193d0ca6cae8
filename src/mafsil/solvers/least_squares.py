"""Damped least squares: the Levenberg-Marquardt step for whole batches, and the iteration for one problem."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mafsil.arrays import Floats, frozen
from mafsil.solvers.outcome import Outcome, SolverStatus
from mafsil.solvers.tolerances import FEW_ROUNDINGS, LEAST_DAMPING

LANES = 512
"""Rows that are factorised together: their matrices fit the second-level cache."""


def damped_step(jacobian: Floats, residual: Floats, damping: Floats) -> Floats:
    """The step dx that minimises |J dx - r|^2 + damping |dx|^2.

    dx = J' (J J' + damping I)^-1 r = (J' J + damping I)^-1 J' r; the smaller of the two matrices is factorised.

    Rows are worked on lane by lane with the same operations whatever their number, so a row's result never depends on
    the others.

    Args:
        jacobian: (k, m, n).
        residual: (k, m).
        damping: (k,) > 0, or >= 0 where the smaller matrix is regular.

    Returns:
        (k, n). Rows whose matrix is not positive definite to working precision are NaN.
    """
    k, m, n = jacobian.shape
    if k == 1:
        # With one lane NumPy would fold the lane axis away and sum in another order.
        return damped_step(*(np.repeat(part, 2, axis=0) for part in (jacobian, residual, damping)))[:1]
    step = np.empty((k, n))
    for begin in range(0, k, LANES):
        rows = slice(begin, begin + LANES)
        J, r = np.ascontiguousarray(jacobian[rows].transpose(1, 2, 0)), residual[rows].T
        if m <= n:
            y = cholesky_solve(_gram(J, damping[rows]), r)
            step[rows] = (J * y[:, None]).sum(axis=0).T
        else:
            J = J.transpose(1, 0, 2)
            step[rows] = cholesky_solve(_gram(J, damping[rows]), (J * r).sum(axis=1)).T
    return step


def _gram(J: Floats, damping: Floats) -> Floats:
    """(m, m, lanes) lower triangle of J J' + damping I, J being (m, n, lanes)."""
    m = len(J)
    gram = np.empty((m, m, J.shape[2]))
    for j in range(m):
        gram[j:, j] = np.einsum("ikl,kl->il", J[j:], J[j])
        gram[j, j] += damping
    return gram


def cholesky_solve(A: Floats, b: Floats) -> Floats:
    """Solve A x = b for symmetric positive definite matrices, one in each lane.

    Args:
        A: (m, m, lanes), lower triangles; overwritten by the factors.
        b: (m, lanes).

    Returns:
        (m, lanes); NaN in lanes whose matrix is not positive definite.
    """
    m = len(A)
    x = b.copy()
    with np.errstate(invalid="ignore", divide="ignore"):
        for j in range(m):
            if j:
                A[j:, j] -= np.einsum("ikl,kl->il", A[j:, :j], A[j, :j])
            pivot = np.where(A[j, j] > 0.0, A[j, j], np.nan)
            A[j:, j] /= np.sqrt(pivot)
        for j in range(m):
            x[j] /= A[j, j]
            x[j + 1 :] -= A[j + 1 :, j] * x[j]
        for j in reversed(range(m)):
            x[j] /= A[j, j]
            x[:j] -= A[j, :j] * x[j]
    return x


def levenberg_marquardt(
    function: Callable[[Floats], tuple[Floats, Floats]],
    start: Floats,
    *,
    tolerance: float = 1e-12,
    iterations: int = 100,
    damping: float = 1e-3,
) -> Outcome[Floats]:
    """Minimise |r(x)|^2 from one start, with Nielsen's rule for the damping.

    Args:
        function: x (n,) to r (m,) and dr/dx (m, n).
        start: (n,).
        tolerance: the residual norm |r| at which the answer is accepted.
        iterations: most evaluations.
        damping: initial value, relative to the largest diagonal element of J' J.

    Returns:
        The best x. STALLED means a minimum whose residual is above the tolerance: the equations have no solution near.

    Reference: Madsen, Nielsen and Tingleff, Methods for Non-Linear Least Squares Problems, algorithm 3.16.
    """
    x = np.array(start, dtype=np.float64)
    r, J = function(x)
    mu, growth = damping * max(float((J * J).sum(axis=0).max(initial=0.0)), LEAST_DAMPING), 2.0
    history = [float(np.linalg.norm(r))]
    status = SolverStatus.BUDGET_SPENT
    for _ in range(iterations):
        if history[-1] <= tolerance:
            status = SolverStatus.CONVERGED
            break
        if not np.isfinite(history[-1]):
            status = SolverStatus.NOT_FINITE
            break
        step = -damped_step(J[None], r[None], np.array([mu]))[0]
        if not np.linalg.norm(step) > FEW_ROUNDINGS * (1.0 + np.linalg.norm(x)):
            status = SolverStatus.STALLED
            break
        r_new, J_new = function(x + step)
        gain = float(r @ r - r_new @ r_new)
        predicted = float(step @ (mu * step - J.T @ r))
        if gain > 0.0:
            x, r, J = x + step, r_new, J_new
            mu *= max(1 / 3, 1 - (2 * gain / predicted - 1) ** 3)
            growth = 2.0
        else:
            mu, growth = mu * growth, 2 * growth
        history.append(float(np.linalg.norm(r)))
    return Outcome(x, status, history[-1], len(history) - 1, frozen(history))
