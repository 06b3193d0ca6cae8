"""Inverses and null spaces without singular vectors, beside NumPy's that have them."""

import numpy as np
import pytest

from mafsil.solvers.decompositions import damped_inverse, null_basis


@pytest.mark.parametrize("shape", [(4, 7), (7, 4), (5, 5), (1, 3)])
def test_a_damped_inverse_is_the_pseudoinverse_of_what_is_far_from_singular(shape):
    A = np.random.default_rng(0).normal(size=(3, 2, *shape))
    assert np.abs(damped_inverse(A, 1e-14) - np.linalg.pinv(A)).max() < 1e-9 * np.abs(np.linalg.pinv(A)).max()
    square = 1e-3 * np.einsum("...ij,...ij->...", A, A)[..., None, None] / shape[0]
    exact = np.linalg.solve(np.swapaxes(A, -1, -2) @ A + square * np.eye(shape[1]), np.swapaxes(A, -1, -2))
    assert np.abs(damped_inverse(A, 1e-3) - exact).max() < 1e-11


def test_a_damped_inverse_stays_finite_and_spoils_no_other():
    A = np.random.default_rng(1).normal(size=(4, 3, 5))
    A[1], A[2, 0, 0], A[3, 2] = 0.0, np.nan, A[3, 0]
    back = damped_inverse(A, 1e-9)
    assert np.abs(back[0] - np.linalg.pinv(A[0])).max() < 1e-6
    assert (back[1] == 0.0).all()
    assert np.isnan(back[2]).all()
    assert np.abs(back[3] - np.linalg.pinv(A[3])).max() < 1e-6


@pytest.mark.parametrize("rank", range(5))
def test_a_null_basis_is_orthonormal_and_complete(rank):
    rng = np.random.default_rng(rank)
    A = rng.normal(size=(6, rank)) @ rng.normal(size=(rank, 4))
    N = null_basis(A, rank)
    assert N.shape == (4, 4 - rank)
    assert np.abs(N.T @ N - np.eye(4 - rank)).max(initial=0.0) < 1e-14
    assert np.abs(A @ N).max(initial=0.0) < 1e-13
