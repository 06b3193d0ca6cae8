"""Cubics through via points, any polynomial from conditions, and rates of joints from those of the tip."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.interpolate import BPoly, CubicSpline

import mafsil as mf
from mafsil.errors import InputError
from mafsil.trajectory import continuity, cubic, cubic_through, polynomial, quintic, septic, via_rates
from mafsil.trajectory.motion import ViaRateStatus

RNG = np.random.default_rng(7)


@pytest.mark.capability("11-15", "11-24")
@pytest.mark.parametrize("ends", ["clamped", "natural", "periodic"])
@pytest.mark.parametrize("legs", [1, 2, 3, 4, 9])
def test_splines_equal_scipy(ends, legs):
    points, h = RNG.normal(size=(legs + 1, 3)), RNG.uniform(0.3, 2.0, legs)
    v = RNG.normal(size=(2, 3))
    if ends == "periodic":
        points[-1] = points[0]
    ours = cubic_through(points, h, ends=ends, start_velocity=v[0], goal_velocity=v[1])
    kind = {"clamped": ((1, v[0]), (1, v[1])), "natural": "natural", "periodic": "periodic"}[ends]
    theirs = CubicSpline(ours.knots, points, bc_type=kind)
    t = np.linspace(0.0, ours.duration, 100)[1:-1]
    for order, values in enumerate(ours.at(t)):
        np.testing.assert_allclose(values, theirs(t, order), atol=1e-10)


@pytest.mark.capability("11-20", "11-21", "11-23")
def test_rules_of_via_velocities():
    points, h = np.array([0.0, 10.0, 30.0, 20.0]), np.array([1.0, 4.0, 2.0])
    slopes = np.diff(points) / h
    inner = {
        rule: cubic_through(points, h, velocities=rule).at([1.0, 5.0]).v[:, 0]
        for rule in ("stop", "mean", "weighted_mean", "heuristic")
    }
    np.testing.assert_array_equal(inner["stop"], 0.0)
    np.testing.assert_allclose(inner["mean"], (slopes[1:] + slopes[:-1]) / 2)
    np.testing.assert_allclose(inner["heuristic"], [(slopes[0] + slopes[1]) / 2, 0.0])
    for k in range(2):
        parabola = np.polynomial.Polynomial.fit(np.cumsum(np.r_[0, h])[k : k + 3], points[k : k + 3], 2)
        np.testing.assert_allclose(inner["weighted_mean"][k], parabola.deriv()(np.cumsum(h)[k]))
    given = cubic_through(points, h, velocities=[[1.0], [2.0]])
    np.testing.assert_allclose(given.at([1.0, 5.0]).v[:, 0], [1.0, 2.0])


@settings(deadline=None, max_examples=40)
@given(st.integers(0, 10_000), st.integers(1, 6))
def test_a_spline_backwards_is_the_spline_of_the_points_backwards(seed, legs):
    rng = np.random.default_rng(seed)
    points, h = rng.normal(size=(legs + 1, 2)), rng.uniform(0.2, 3.0, legs)
    ours, back = cubic_through(points, h), cubic_through(points[::-1], h[::-1])
    t = np.linspace(0.0, ours.duration, 31)[1:-1]
    np.testing.assert_allclose(ours.at(t).u, back.at(ours.duration - t).u, atol=1e-9)
    np.testing.assert_allclose(ours.at(t).v, -back.at(ours.duration - t).v, atol=1e-8)


def test_a_batch_of_splines_is_its_rows():
    points, h = RNG.normal(size=(5, 4, 2)), [1.0, 0.5, 2.0]
    for options in ({}, {"ends": "natural"}, {"velocities": "heuristic"}, {"velocities": RNG.normal(size=(2, 2))}):
        whole = cubic_through(points, h, **options)
        assert whole.at(0.7).u.shape == (5, 2)
        for k in range(5):
            np.testing.assert_allclose(whole.at(0.7).u[k], cubic_through(points[k], h, **options).at(0.7).u, atol=1e-13)


@pytest.mark.parametrize(
    "wrong",
    [
        {"durations": [1.0, 0.0]},
        {"durations": [1.0, np.nan]},
        {"ends": "open"},
        {"ends": "periodic"},
        {"ends": "natural", "velocities": "stop"},
        {"velocities": "fast"},
        {"velocities": [1.0, 2.0]},
        {"start_velocity": [1.0, 2.0]},
        {"points": [1.0]},
        {"points": [0.0, np.inf, 1.0]},
    ],
)
def test_what_no_spline_can_be_is_refused(wrong):
    with pytest.raises(InputError):
        cubic_through(**{"points": [0.0, 1.0, 3.0], "durations": [1.0, 1.0]} | wrong)


@pytest.mark.capability("11-16", "11-34")
@settings(deadline=None, max_examples=60)
@given(st.integers(0, 10_000), st.floats(0.05, 20.0), st.integers(1, 5), st.integers(1, 5))
def test_a_polynomial_meets_its_conditions(seed, T, begin, end):
    rng = np.random.default_rng(seed)
    conditions = [(0.0, k, rng.normal(size=2)) for k in range(begin)] + [(T, k, rng.normal(size=2)) for k in range(end)]
    motion = polynomial(conditions)
    assert motion.degree == begin + end - 1
    for t, order, value in conditions:
        np.testing.assert_allclose(motion.derivative(t, order), value, atol=1e-8 * (1 + T**-order) * (1 + T**5))


@pytest.mark.capability("11-16")
def test_polynomials_known_from_elsewhere():
    u0, uf, v0, vf, a0, af, T = 1.0, 4.0, 0.5, -0.3, 0.2, 0.1, 2.5
    both = [(0, 0, u0), (0, 1, v0), (0, 2, a0), (T, 0, uf), (T, 1, vf), (T, 2, af)]
    ends = {"start_velocity": v0, "goal_velocity": vf}
    five = quintic(u0, uf, T, **ends, start_acceleration=a0, goal_acceleration=af)
    np.testing.assert_allclose(polynomial(both).coefficients, five.coefficients, atol=1e-13)
    third = polynomial([row for row in both if row[1] < 2])
    np.testing.assert_allclose(third.coefficients, cubic(u0, uf, T, **ends).coefficients, atol=1e-13)
    seven = septic([0.0], [1.0], 2.0)
    np.testing.assert_allclose(
        2.0 ** np.arange(8) * seven.coefficients[0, :, 0], [0, 0, 0, 0, 35, -84, 70, -20], atol=1e-11
    )
    assert continuity(seven).order == 3
    rows = RNG.normal(size=(2, 4))
    theirs = BPoly.from_derivatives([0.0, 1.5], [rows[0], rows[1]])
    ours = septic(rows[0, 0], rows[1, 0], 1.5, start_derivatives=rows[0, 1:], goal_derivatives=rows[1, 1:])
    t = np.linspace(0, 1.5, 9)
    np.testing.assert_allclose(ours.at(t).u[:, 0], theirs(t), atol=1e-12)
    through = polynomial([(0, 0, 0.0), (0, 1, 0.0), (0.7, 0, 2.0), (2.0, 0, 1.0), (2.0, 1, 0.0)])
    np.testing.assert_allclose(through.at(0.7).u, 2.0, atol=1e-13)


@pytest.mark.parametrize(
    "wrong",
    [
        [(0, 0, 1.0)],
        [(0, 0, 1.0), (0, 0, 1.0), (1, 0, 2.0)],
        [(0, 1, 1.0), (1, 1, 2.0)],
        [(0, 0, 1.0), (-1, 0, 1.0), (1, 0, 1.0)],
        [(0, 0, 1.0), (0, 1, 1.0)],
        [(0, 0, 1.0), (np.nan, 0, 1.0)],
        [(0, 0, 1.0), (1, -1, 1.0)],
        [(0, 0, [1.0, 2.0]), (1, 0, [1.0, 2.0, 3.0])],
        [(0.1 * k, 0, 1.0) for k in range(30)],
    ],
)
def test_conditions_that_determine_nothing_are_refused(wrong):
    with pytest.raises(InputError):
        polynomial(wrong)


@pytest.mark.capability("11-22")
def test_rates_at_via_points_make_the_velocity_of_the_tip():
    robot = mf.load("puma560")
    q = np.array([[0.1, -0.6, 0.4, 0.2, 0.7, 0.3], [0.4, -0.2, 0.1, 0.1, 0.9, 0.1]])
    linear, angular = RNG.normal(size=(2, 3)), RNG.normal(size=(2, 3))
    rates = via_rates(robot, q, linear=linear, angular=angular)
    assert rates
    h = 1e-6
    ahead, behind = (robot.forward_kinematics(q + k * h * rates.qd) for k in (1, -1))
    np.testing.assert_allclose((ahead - behind)[:, :3, 3] / (2 * h), linear, atol=1e-7)
    motion = cubic_through(np.stack([0 * q[0], *q, q[0]]), 1.0, velocities=rates.qd)
    np.testing.assert_allclose(motion.at([1.0, 2.0]).v, rates.qd, atol=1e-12)
    np.testing.assert_allclose(rates.condition, np.linalg.cond(robot.jacobian_body(q)), rtol=1e-9)
    assert via_rates(robot, q[0], linear=linear[0]).status is ViaRateStatus.EXACT


@pytest.mark.capability("11-22")
def test_near_a_singularity_the_inverse_is_damped_and_says_so():
    robot = mf.load("puma560")
    q = np.array([0.1, -0.6, 0.4, 0.2, 0.0, 0.3])
    angles = np.array([0.0, 1e-6, 1e-3, 0.05, 0.5])
    Q = np.tile(q, (5, 1))
    Q[:, 4] = angles
    rates = via_rates(robot, Q, linear=[0.1, 0.0, 0.0], angular=[1.0, 0.5, 0.0], most_condition=200.0)
    assert not rates
    assert np.isfinite(rates.qd).all()
    assert (np.diff(rates.condition) < 0).all()
    assert rates.damping[0] > 0.0 == rates.damping[-1]
    assert list(rates.exact) == [False, False, False, False, True] or list(rates.exact) == [False] * 3 + [True] * 2
    exact = np.linalg.norm(rates.qd[-1])
    assert np.abs(rates.qd).max() < 100 * exact
    for language in ("en", "ar"):
        assert len(rates.explain(language).splitlines()) == 2
    heavy = via_rates(mf.load("panda"), np.full(7, 0.3), linear=[0.1, 0, 0], weights=[100.0, 1, 1, 1, 1, 1, 1])
    plain = via_rates(mf.load("panda"), np.full(7, 0.3), linear=[0.1, 0, 0])
    assert abs(heavy.qd[0]) < abs(plain.qd[0])
    assert heavy
    assert plain
    for wrong in ({}, {"linear": [1, 2]}, {"linear": [1, 2, np.nan]}, {"linear": [1, 2, 3], "weights": [1.0]}):
        with pytest.raises(InputError):
            via_rates(robot, q, **wrong)
