"""Cubics and quintics meet their boundary conditions, for any numbers; derivatives are derivatives."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.interpolate import CubicSpline

from mafsil.errors import InputError
from mafsil.trajectory import Trajectory, cubic, cubic_through, quintic
from mafsil.trajectory.profiles import rest

values = st.floats(-10.0, 10.0)
vectors = st.lists(values, min_size=3, max_size=3).map(np.array)
durations = st.floats(0.05, 20.0)


@pytest.mark.capability("11-18", "11-19", "11-3")
@given(u0=vectors, uf=vectors, v0=vectors, vf=vectors, T=durations)
def test_cubic_meets_its_ends(u0, uf, v0, vf, T):
    motion = cubic(u0, uf, T, start_velocity=v0, goal_velocity=vf)
    assert isinstance(motion, Trajectory)
    begin, end = motion.at(0.0), motion.at(T)
    np.testing.assert_allclose([begin.u, begin.v], [u0, v0], atol=1e-12)
    np.testing.assert_allclose(end.u, uf, atol=1e-11 * (1 + T))
    np.testing.assert_allclose(end.v, vf, atol=1e-11 * (1 + 1 / T))


@pytest.mark.capability("11-34")
@given(ends=st.tuples(*[vectors] * 6), T=durations)
def test_quintic_meets_its_ends(ends, T):
    u0, uf, v0, vf, a0, af = ends
    motion = quintic(u0, uf, T, start_velocity=v0, goal_velocity=vf, start_acceleration=a0, goal_acceleration=af)
    begin, end = motion.at(0.0), motion.at(T)
    np.testing.assert_allclose([begin.u, begin.v, begin.a], [u0, v0, a0], atol=1e-12)
    np.testing.assert_allclose(end.u, uf, atol=1e-10 * (1 + T) ** 2)
    np.testing.assert_allclose(end.v, vf, atol=1e-10 * (1 + T + 1 / T))
    np.testing.assert_allclose(end.a, af, atol=1e-10 * (1 + T + 1 / T**2))


@given(ends=st.tuples(*[vectors] * 6), T=st.floats(0.5, 5.0), s=st.floats(0.05, 0.95))
def test_derivatives_are_derivatives(ends, T, s):
    u0, uf, v0, vf, a0, af = ends
    motion = quintic(u0, uf, T, start_velocity=v0, goal_velocity=vf, start_acceleration=a0, goal_acceleration=af)
    h = 1e-3 * T
    # The five-point difference is exact for polynomials up to degree four, so the quintic leaves O(h^4).
    t = s * T + h * np.array([-2.0, -1.0, 1.0, 2.0])
    weights = np.array([1.0, -8.0, 8.0, -1.0]) / (12 * h)
    near, here = motion.at(t), motion.at(s * T)
    scale = 1e-7 * np.abs(motion.coefficients).max() * (1 + T) ** 5 + 1e-300
    np.testing.assert_allclose(weights @ near.u, here.v, atol=scale)
    np.testing.assert_allclose(weights @ near.v, here.a, atol=scale)
    np.testing.assert_allclose(weights @ near.a, motion.jerk(s * T), atol=scale)


def test_shapes_of_times_and_batches():
    rng = np.random.default_rng(1)
    motion = quintic(rng.normal(size=(4, 3)), rng.normal(size=(4, 3)), 2.0)
    assert motion.n == 3
    many = motion.at(np.linspace(0, 2, 10).reshape(2, 5))
    assert many.u.shape == (2, 5, 4, 3)
    np.testing.assert_array_equal(many.a[1, 2], motion.at(np.linspace(0, 2, 10)[7]).a)
    assert motion.at(np.zeros(0)).u.shape == (0, 4, 3)
    assert motion.jerk(np.zeros((2, 0))).shape == (2, 0, 4, 3)


def test_rests_outside():
    motion = quintic([0.0], [1.0], 2.0, start_velocity=3.0, goal_velocity=-3.0)
    early, late = motion.at(-1.0), motion.at(5.0)
    assert (early.u, early.v, early.a) == (0.0, 0.0, 0.0)
    np.testing.assert_allclose(late.u, 1.0)
    assert (late.v, late.a, motion.jerk(5.0)) == (0.0, 0.0, 0.0)


@pytest.mark.capability("11-24")
def test_spline_equals_scipy():
    rng = np.random.default_rng(2)
    for legs in (1, 2, 3, 7):
        points, h = rng.normal(size=(legs + 1, 4)), rng.uniform(0.3, 2.0, legs)
        v0, vf = rng.normal(size=(2, 4))
        motion = cubic_through(points, h, start_velocity=v0, goal_velocity=vf)
        oracle = CubicSpline(np.concatenate([[0], np.cumsum(h)]), points, bc_type=((1, v0), (1, vf)))
        t = np.linspace(0, motion.duration, 57)
        np.testing.assert_allclose(motion.at(t).u, oracle(t), atol=1e-12)
        np.testing.assert_allclose(motion.at(t).a, oracle(t, 2), atol=1e-10)


@pytest.mark.capability("11-20")
def test_stopping_at_every_point():
    points = np.array([[0.0, 1.0], [2.0, -1.0], [3.0, 4.0]])
    motion = cubic_through(points, [1.0, 2.0], velocities="stop")
    at = motion.at([0.0, 1.0, 3.0])
    np.testing.assert_allclose(at.u, points, atol=1e-14)
    np.testing.assert_allclose(at.v, 0.0, atol=1e-14)


def test_stretched_scales_every_derivative():
    motion = cubic([0.0, 1.0], [2.0, -3.0], 1.5, start_velocity=[1.0, 0.0])
    slow = motion.scale_time(3.0)
    t = np.linspace(0, 1.5, 20, endpoint=False)
    for order, (fast_part, slow_part) in enumerate(zip(motion.at(t), slow.at(3 * t), strict=True)):
        np.testing.assert_allclose(slow_part, fast_part / 3.0**order, atol=1e-13)


def test_rest_stands_still():
    motion = rest([1.0, 2.0], 0.5)
    at = motion.at(np.linspace(0, 0.5, 5))
    np.testing.assert_array_equal(at.u, np.tile([1.0, 2.0], (5, 1)))
    assert not at.v.any()
    assert not at.a.any()


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: cubic([0.0], [1.0], 0.0), "duration"),
        (lambda: cubic([0.0], [1.0], np.nan), "duration"),
        (lambda: quintic([0.0, 1.0], [1.0, 2.0, 3.0], 1.0), "goal"),
        (lambda: quintic([0.0, np.nan], [1.0, 2.0], 1.0), "start"),
        (lambda: cubic_through([[0.0]], [], velocities="stop"), "points"),
        (lambda: cubic_through([0.0, 1.0], [1.0, 1.0]), "durations"),
        (lambda: cubic_through([0.0, 1.0, 2.0], [1.0, -1.0]), "durations"),
        (lambda: cubic_through([0.0, 1.0, 2.0], [1.0, 1.0], velocities="fast"), "fast"),
        (lambda: cubic_through([0.0, 1.0, 2.0], [1.0, 1.0], velocities=[[1.0], [2.0]]), "velocities"),
        (lambda: cubic([0.0], [1.0], 1.0).at(np.nan), "t"),
    ],
)
def test_wrong_input_is_named(call, words):
    with pytest.raises(InputError, match=words):
        call()
