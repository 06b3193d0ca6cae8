"""Factors of symmetric matrices: the same after rows came and went as factored anew."""

from __future__ import annotations

import numpy as np

from mafsil.solvers import cholesky_loops


def test_rows_come_and_go():
    rng = np.random.default_rng(3)
    for _ in range(20):
        A = rng.normal(size=(8, 8))
        S = A @ A.T + 0.1 * np.eye(8)
        L, kept = np.zeros((8, 8)), list(range(5))
        L[:5, :5] = S[:5, :5]
        assert cholesky_loops.factor(L, 5)
        for new in (5, 6, 7):
            gone = int(rng.integers(len(kept)))
            cholesky_loops.drop_row(L, len(kept), gone, np.empty(8))
            kept.pop(gone)
            row = np.zeros(8)
            row[: len(kept) + 1] = S[new, [*kept, new]]
            assert cholesky_loops.append_row(L, len(kept), row)
            kept.append(new)
        m = len(kept)
        expected = np.linalg.cholesky(S[np.ix_(kept, kept)])
        assert np.abs(np.tril(L[:m, :m]) - expected).max() < 1e-10
        b = rng.normal(size=8)
        x = b.copy()
        cholesky_loops.solve(L, m, x)
        assert np.abs(S[np.ix_(kept, kept)] @ x[:m] - b[:m]).max() < 1e-8


def test_what_is_not_positive_definite_is_said():
    L = np.array([[1.0, 0.0], [2.0, 1.0]])
    assert not cholesky_loops.factor(L.copy(), 2)
    assert cholesky_loops.factor(L, 1)
    assert not cholesky_loops.append_row(L, 1, np.array([2.0, 1.0]))
