"""Routh's array against the roots."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mafsil.errors import InputError
from mafsil.one_joint import ErrorDynamics, roots, routh_hurwitz
from mafsil.one_joint.polynomial import StabilityStatus


@pytest.mark.capability("10-23")
@pytest.mark.parametrize("order", range(1, 9))
def test_routh_agrees_with_the_roots_on_random_polynomials(order):
    rng = np.random.default_rng(order)
    a = rng.normal(size=(20000, order + 1))
    a[::2] = np.abs(a[::2])
    answer = routh_hurwitz(a)
    companion = np.zeros((len(a), order, order))
    companion[:, np.arange(1, order), np.arange(order - 1)] = 1.0
    companion[:, 0, :] = -a[:, 1:] / a[:, :1]
    real = np.linalg.eigvals(companion).real
    clear = np.abs(real).min(axis=1) > 1e-9 * np.abs(real).max(axis=1)
    np.testing.assert_array_equal(answer.stable[clear], (real < 0.0).all(axis=1)[clear])
    np.testing.assert_array_equal(answer.right_roots[clear], (real > 0.0).sum(axis=1)[clear])
    assert clear.mean() > 0.99


@pytest.mark.capability("10-23")
@given(
    st.lists(st.floats(-3.0, -0.05), min_size=1, max_size=3),
    st.lists(st.tuples(st.floats(-2.0, 2.0), st.floats(0.2, 4.0)), max_size=2),
)
def test_routh_of_polynomials_with_known_roots(real, pairs):
    p = np.array([1.0])
    for s in real:
        p = np.convolve(p, [1.0, -s])
    for sigma, w in pairs:
        p = np.convolve(p, [1.0, -2.0 * sigma, sigma**2 + w**2])
    answer = routh_hurwitz(p)
    right = 2 * sum(sigma > 1e-3 for sigma, _ in pairs)
    if all(abs(sigma) > 1e-3 for sigma, _ in pairs):
        assert int(answer.right_roots) == right
        assert bool(answer) == (right == 0)
    found = roots(p)
    assert np.abs(np.polyval(p, found)).max() <= 1e-9 * np.abs(p).max() * max(1.0, np.abs(found).max()) ** len(p)


@pytest.mark.capability("10-23")
def test_order_two_and_three_by_their_rules():
    a = np.random.default_rng(0).normal(size=(5000, 4))
    assert (routh_hurwitz(a[:, :3]).stable == ((a[:, :3] * a[:, :1] > 0).all(axis=1))).all()
    a *= np.sign(a[:, :1])
    rule = (a > 0).all(axis=1) & (a[:, 1] * a[:, 2] > a[:, 0] * a[:, 3])
    assert (routh_hurwitz(a).stable == rule).all()


def test_zeros_in_the_array():
    for p, status in (
        ([1, 0, 4], StabilityStatus.MARGINAL),
        ([1, 2, 3, 6], StabilityStatus.MARGINAL),
        ([1, 1, 0], StabilityStatus.MARGINAL),
        ([1, 1, 1, 1, 1], StabilityStatus.UNSTABLE),
        ([1, 0, -4], StabilityStatus.UNSTABLE),
        ([1, 2, 3], StabilityStatus.STABLE),
    ):
        answer = routh_hurwitz(p)
        assert answer.status is status, p
        assert bool(answer) is status.succeeded
        assert answer.explain("ar") != answer.explain("en")


def test_answers_of_batches():
    answer = routh_hurwitz([[[1, 2, 3], [1, -2, 3]]])
    assert answer.verdict.shape == (1, 2)
    assert [bool(each) for each in answer] == [True, False]
    assert not answer
    assert "1 of 2: stable" in repr(answer)
    assert answer.to_dict()["status"] == ["stable", "unstable"]
    empty = routh_hurwitz(np.empty((0, 3)))
    assert not empty
    assert len(empty) == 0
    assert empty.explain()


@pytest.mark.parametrize("wrong", [[0, 1, 2], [1.0], 3.0, [1, np.nan], "ab", [1, np.inf, 2]])
def test_wrong_coefficients(wrong):
    with pytest.raises(InputError):
        routh_hurwitz(wrong)


@pytest.mark.capability("10-23")
@pytest.mark.parametrize("order", [1, 2, 3, 4, 6])
def test_response_obeys_its_equation_and_its_initial_conditions(order):
    rng = np.random.default_rng(order)
    s = -rng.uniform(0.3, 4.0, size=(7, order))
    s[3] = s[3, :1]
    if order > 1:
        s[4, 1] = s[4, 0] * (1 + 1e-9)
    a = np.stack([np.poly(row) for row in s])
    dynamics, x0 = ErrorDynamics.from_row(a), rng.normal(size=(7, order))
    t = np.linspace(0.0, 3.0, 7)
    x = dynamics.derivatives(t, x0, 0.25)
    np.testing.assert_allclose(x[:, 0], x0, atol=1e-9)
    from scipy.integrate import solve_ivp

    for k in range(7):
        A = np.eye(order, k=1)
        A[-1] = -a[k, :0:-1] / a[k, 0]
        start = x0[k].copy()
        start[0] -= 0.25
        peer = solve_ivp(lambda _, y, A=A: A @ y, (0, 3), start, "DOP853", t, rtol=1e-12, atol=1e-13).y.T
        peer[:, 0] += 0.25
        np.testing.assert_allclose(x[k], peer, atol=2e-7)


@pytest.mark.capability("10-26")
def test_time_constants():
    dynamics = ErrorDynamics.from_row(np.poly([-0.5, -2.0, -10.0]))
    np.testing.assert_allclose(dynamics.time_constants, [2.0, 0.5, 0.1])
    assert dynamics.response([2.0], [1.0, -0.5, 0.25])[0] == pytest.approx(np.exp(-1.0))


@pytest.mark.capability("10-23", "10-29")
@pytest.mark.parametrize(
    "wanted",
    [[-1.4] * 3, [-2.0] * 4, [-3.0] * 5, [0.0] * 3, [-1, -1, -2], [2j, -2j] * 2, [-1 + 2j, -1 - 2j] * 2 + [-3.0]],
)
def test_equal_roots_have_all_their_digits(wanted):
    """Eigenvalues part m equal roots by the m-th root of the rounding: 1e-5 for three."""
    found = roots(2.5 * np.poly(wanted).real)
    np.testing.assert_allclose(np.sort_complex(found), np.sort_complex(np.array(wanted, dtype=complex)), atol=1e-13)


@pytest.mark.capability("10-23")
def test_roots_that_are_only_near_stay_apart():
    near = np.array([-1.0, -1.001, -1.003])
    np.testing.assert_allclose(np.sort(roots(np.poly(near)).real), np.sort(near), atol=1e-8)
    np.testing.assert_allclose(roots([1.0, 2.0, 1.0 + 1e-12]).imag, [1e-6, -1e-6], rtol=1e-3)


@pytest.mark.capability("10-25")
def test_inertia_alone_moves_on():
    """e''' = 0: a parabola; no root sets a unit of time."""
    t = np.array([0.0, 1.0, 3.0])
    found = ErrorDynamics.of(2.0, 0.0, 0.0, 0.0).response(t, [1.0, 2.0, 4.0])
    np.testing.assert_allclose(found, 1 + 2 * t + 2 * t**2)
