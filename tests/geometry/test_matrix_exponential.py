"""Linear differential equations with constant coefficients: three methods for the exponential, and its laws."""

from __future__ import annotations

import mpmath
import numpy as np
import pytest

from mafsil.errors import InputError
from mafsil.geometry import matrix_exponential as me


@pytest.mark.capability("04-51")
def test_scalar_equation():
    assert me.solution([[-0.7]], [2.0], 1.5)[0] == pytest.approx(2 * np.exp(-0.7 * 1.5), rel=1e-15)
    for terms in (1, 3, 6, 12):
        partial = sum((-0.7 * 1.5) ** k / np.prod(np.arange(1.0, k + 1)) for k in range(terms))
        short = me.series([[-0.7]], 1.5, terms=terms)
        assert short.terms == terms
        assert short.value[0, 0] == pytest.approx(partial, rel=1e-15)
        assert abs(partial - np.exp(-1.05)) <= short.bound
    assert me.series([[-3.0]], terms=2).rest == np.inf
    with pytest.raises(InputError, match="terms"):
        me.series([[1.0]], terms=0)


@pytest.mark.capability("04-52", "04-53", "04-54", "04-57")
def test_methods_agree_on_random_matrices():
    rng = np.random.default_rng(0)
    for n in (1, 2, 3, 5):
        A = rng.standard_normal((n, n))
        exact = me.exponential(A, 0.8)
        summed = me.series(A, 0.8)
        assert summed.rest <= 1e-15
        assert np.linalg.norm(summed.value - exact, 2) <= summed.bound + 1e-14
        assert np.abs(summed.value - exact).max() < 1e-13
        assert np.abs(me.by_characteristic_polynomial(A, 0.8) - exact).max() < 1e-11
        value, condition = me.by_similarity(A, 0.8)
        assert np.abs(value - exact).max() < 1e-14 * condition * 10
    assert me.by_similarity([[2, 1], [0, 2]])[1] > 1e12


@pytest.mark.capability("04-53")
def test_truncation_bound_holds():
    A = np.random.default_rng(1).standard_normal((4, 4))
    for tolerance in (1e-2, 1e-5, 1e-9):
        summed = me.series(A, 1.0, tolerance)
        assert np.linalg.norm(summed.value - me.exponential(A), 2) <= summed.bound
        assert summed.rest <= tolerance
    with pytest.raises(InputError, match="4 terms of the series reach only"):
        me.series(A, 10.0, most=4)


@pytest.mark.capability("04-53")
@pytest.mark.parametrize("a", [-30.0, -20.0, -3.0, 5.0, 30.0])
def test_the_bound_counts_rounding_too(a):
    """At -30 the largest term is 1e12 and the sum 1e-13: what is left is rounding, and the bound must say so."""
    mpmath.mp.dps = 50
    for A in ([[a]], [[a, 1.0], [0.0, a / 2]], np.diag([a, -a])):
        for t in (1.0, 0.7):
            summed = me.series(A, t)
            true = mpmath.expm(mpmath.matrix(np.asarray(A).tolist()) * mpmath.mpf(t), method="taylor")
            wrong = np.array((mpmath.matrix(summed.value.tolist()) - true).tolist(), dtype=float)
            assert np.linalg.norm(wrong, 2) <= summed.bound
    assert me.series([[1.0]]).bound < 1e-14, "where nothing cancels the bound is small"


@pytest.mark.capability("04-55", "04-56")
def test_laws_of_the_exponential():
    rng = np.random.default_rng(2)
    A, h = rng.standard_normal((3, 3)), 1e-6
    slope = (me.exponential(A, 0.5 + h) - me.exponential(A, 0.5 - h)) / (2 * h)
    E = me.exponential(A, 0.5)
    assert np.abs(slope - A @ E).max() < 1e-8
    assert np.abs(A @ E - E @ A).max() < 1e-13
    assert np.abs(me.exponential(-A) @ me.exponential(A) - np.eye(3)).max() < 1e-13
    B = A @ A + 2 * A
    assert me.commute(A, B)
    assert np.abs(me.exponential(0.1 * A) @ me.exponential(0.1 * B) - me.exponential(0.1 * (A + B))).max() < 1e-12
    X, Y = np.array([[0.0, 1], [0, 0]]), np.array([[0.0, 0], [1, 0]])
    assert not me.commute(X, Y)
    assert np.abs(me.exponential(X) @ me.exponential(Y) - me.exponential(X + Y)).max() > 0.5


@pytest.mark.capability("04-57")
def test_cayley_hamilton():
    A = np.random.default_rng(3).standard_normal((6, 6))
    p = me.characteristic_polynomial(A)
    assert np.abs(p - np.poly(A)).max() < 1e-12
    assert np.abs(me.polynomial_of(p, A)).max() < 1e-11


def test_refuses_what_is_not_square():
    with pytest.raises(InputError, match=r"\(\*batch, n, n\)"):
        me.exponential([[1.0, 2.0]])


def test_batches():
    A = np.random.default_rng(4).standard_normal((3, 1, 2, 2))
    assert me.exponential(A).shape == A.shape
