"""Exponential coordinates of rotations: Rodrigues' formula, all logarithms, the solid ball."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.errors import InputError
from mafsil.geometry import matrix_exponential, planar, pose, quaternion, rotation, screw, twist
from mafsil.geometry.logarithms import AxisAngle, ball_points, logarithms

EPS = 2.0**-52
AXIS = np.array([1.0, 2.0, 2.0]) / 3


@pytest.mark.capability("04-63", "04-71")
@settings(max_examples=100, deadline=None)
@given(st.tuples(*[st.floats(-3, 3)] * 3))
def test_exp_is_the_matrix_exponential_of_the_skew_matrix(r: tuple[float, float, float]):
    assert np.abs(rotation.exp(r) - matrix_exponential.exponential(rotation.hat(r))).max() <= 1e-13


@pytest.mark.capability("04-63")
def test_entries_of_rodrigues_formula():
    w, theta = AXIS, 0.9
    c, s, k = np.cos(theta), np.sin(theta), 1 - np.cos(theta)
    entries = [
        [c + w[0] ** 2 * k, w[0] * w[1] * k - w[2] * s, w[0] * w[2] * k + w[1] * s],
        [w[0] * w[1] * k + w[2] * s, c + w[1] ** 2 * k, w[1] * w[2] * k - w[0] * s],
        [w[0] * w[2] * k - w[1] * s, w[1] * w[2] * k + w[0] * s, c + w[2] ** 2 * k],
    ]
    assert np.abs(rotation.from_axis_angle(w, theta) - entries).max() <= 4 * EPS
    assert np.abs(rotation.from_axis_angle(5 * w, theta) - entries).max() <= 4 * EPS


@pytest.mark.capability("04-58")
def test_a_point_on_a_rotating_body_runs_on_a_circle():
    p, w = np.array([0.3, -1.0, 2.0]), AXIS
    radius = np.linalg.norm(np.cross(w, p))
    x, h = p.copy(), 1e-3
    for k in range(1000):
        k1 = np.cross(w, x)
        k2 = np.cross(w, x + h / 2 * k1)
        k3 = np.cross(w, x + h / 2 * k2)
        k4 = np.cross(w, x + h * k3)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + k4)
        if k % 250 == 0:
            foot = (x @ w) * w
            assert np.linalg.norm(x - foot) == pytest.approx(radius, abs=1e-10)
            assert np.linalg.norm(np.cross(w, x)) == pytest.approx(radius, abs=1e-10)
    assert np.abs(rotation.apply(rotation.exp(w * 1.0), p) - x).max() < 1e-10


@pytest.mark.capability("04-65", "04-66", "04-67")
@pytest.mark.parametrize("theta", [0.0, 1e-300, 1e-12, 1e-8, 1e-3, 1.0, 3.0, pi - 1e-6, pi - 1e-8, pi])
def test_axis_and_angle_at_both_ends(theta: float):
    axis, angle = rotation.to_axis_angle(rotation.exp(AXIS * theta))
    assert angle == pytest.approx(theta, rel=4 * EPS, abs=0)
    if theta:
        assert np.abs(axis - AXIS).max() <= 4 * EPS
    else:
        assert axis.tolist() == [1, 0, 0]


@pytest.mark.capability("04-67")
@pytest.mark.parametrize("largest", range(3))
def test_half_turn_axis_by_any_feasible_column(largest: int):
    w = np.roll([0.8, 0.36, 0.48], largest)
    R = 2 * np.outer(w, w) - np.eye(3)
    r = rotation.log(R)
    assert np.abs(r / pi - w).max() <= 4 * EPS
    for k in range(3):
        column = R[:, k] + np.eye(3)[k]
        assert np.abs(column / np.sqrt(2 * (1 + R[k, k])) - w).max() <= 1e-15


@pytest.mark.capability("04-68")
def test_odd_and_even_multiples_of_pi():
    half = rotation.exp(AXIS * pi)
    for k in (-3, -1, 1, 3, 5):
        assert np.abs(rotation.exp(AXIS * k * pi) - half).max() <= 8 * abs(k) * EPS
    for k in (-2, 0, 2, 4):
        assert np.abs(rotation.exp(AXIS * k * pi) - np.eye(3)).max() <= 8 * max(1, abs(k)) * EPS


@pytest.mark.capability("04-69")
def test_all_logarithms_on_an_interval():
    R = rotation.exp(AXIS * 1.0)
    found = logarithms(R, 0, 4 * pi)
    assert [v.angle for v in found] == pytest.approx([1, 2 * pi - 1, 2 * pi + 1, 4 * pi - 1])
    for value in found:
        assert np.abs(rotation.exp(value.coordinates) - R).max() <= 1e-14
    assert len(logarithms(R, 0, pi)) == 1
    half = logarithms(rotation.exp(AXIS * pi), 0, 2 * pi)
    assert [v.angle for v in half] == pytest.approx([pi, pi])
    assert np.abs(half[0].coordinates + half[1].coordinates).max() <= 1e-14
    whole = logarithms(np.eye(3), -2 * pi, 2 * pi)
    assert [v.angle for v in whole] == pytest.approx([-2 * pi, 0, 2 * pi])
    assert all(v.axis is None for v in whole)
    assert AxisAngle(None, 0.0).coordinates.tolist() == [0, 0, 0]
    with pytest.raises(InputError, match="one value is needed"):
        logarithms(np.stack([R, R]))


@pytest.mark.capability("04-70")
def test_solid_ball():
    assert ball_points(rotation.exp(AXIS * 2.0)) == pytest.approx(AXIS[None] * 2)
    rim = ball_points(rotation.exp(AXIS * pi))
    assert rim.shape == (2, 3)
    assert np.abs(rim[0] + rim[1]).max() == 0
    assert np.abs(rotation.exp(rim[0]) - rotation.exp(rim[1])).max() <= 4 * EPS


@pytest.mark.capability("04-71", "04-77")
@settings(max_examples=100, deadline=None)
@given(st.integers(0, 2**32 - 1), st.floats(0, pi - 1e-6), st.sampled_from([(), (1,), (3, 1, 2)]))
def test_log_undoes_exp(seed: int, theta: float, shape: tuple[int, ...]):
    w = np.random.default_rng(seed).standard_normal((*shape, 3))
    r = theta * w / np.linalg.norm(w, axis=-1, keepdims=True)
    assert np.abs(rotation.log(rotation.exp(r)) - r).max() <= 8 * EPS * theta + 5e-324


@pytest.mark.parametrize(
    ("function", "arguments", "words"),
    [
        (rotation.exp, ([1e155, 0, 0],), "too long"),
        (rotation.left_jacobian, ([0, 1e155, 0],), "too long"),
        (pose.exp, ([1e155, 0, 0, 0, 0, 0],), "too long"),
        (planar.exp, ([1e155, 0, 0],), "too large"),
        (quaternion.exp, ([0, 0, 1e200],), "too long"),
        (screw.displacement, ([0, 0, 1, 0, 0, 0], 1e155), "too large"),
        (screw.integral_inverse, ([0, 0, 1], 0.0), "whole number of turns"),
        (screw.integral_inverse, ([0, 0, 1], 4 * np.pi), "whole number of turns"),
        (twist.mean_angular_velocity, (np.eye(3), np.eye(3), 0.0), "duration is zero"),
        (twist.mean_space_twist, (np.eye(4), np.eye(4), [1.0, 0.0]), r"duration\[1\]: the duration is zero"),
    ],
)
def test_finite_numbers_never_become_infinite_in_silence(function, arguments, words):
    with pytest.raises(InputError, match=words):
        function(*arguments)


def test_rows_of_nan_stay_in_their_rows():
    R = rotation.exp([[0.1, 0, 0], [np.nan] * 3, [0, 1e149, 0]])
    assert np.isnan(R[1]).all()
    assert np.isfinite(R[[0, 2]]).all()
