"""Screws: axis, point and pitch, displacements along them, the theorem of Chasles and Mozzi."""

from __future__ import annotations

from math import pi

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.errors import InputError
from mafsil.geometry import Pose, ScrewAxis, Twist, matrix_exponential, pose, rotation, screw, twist
from tests.geometry.samples import batches, poses, seeds

EPS = 2.0**-52


@settings(max_examples=60, deadline=None)
@given(seeds, st.floats(0.01, pi - 0.01), st.floats(-2, 2), batches)
@pytest.mark.capability("04-90", "04-91", "04-92", "04-96")
def test_closed_form_and_way_back(seed: int, theta: float, pitch: float, shape: tuple[int, ...]):
    rng = np.random.default_rng(seed)
    w = rng.standard_normal((*shape, 3))
    w /= np.linalg.norm(w, axis=-1, keepdims=True)
    q = rng.standard_normal((*shape, 3))
    S = screw.from_axis(3 * w, q, pitch)
    T = screw.displacement(S, theta)
    R = rotation.from_axis_angle(w, theta)
    p = q - rotation.apply(R, q) + pitch * theta * w
    assert np.abs(T[..., :3, :3] - R).max() <= 8 * EPS
    assert np.abs(T[..., :3, 3] - p).max() <= 1e-13
    turn = pose.from_rotation_translation(R, q - rotation.apply(R, q))
    slide = pose.from_translation(pitch * theta * w)
    assert np.abs(turn @ slide - slide @ turn).max() <= 1e-13
    assert np.abs(turn @ slide - T).max() <= 1e-13
    found, amount = screw.chasles(T)
    assert np.abs(amount - theta).max() <= 1e-13
    assert np.abs(found - S).max() <= 1e-11
    assert np.abs(screw.pitch(found) - pitch).max() <= 1e-11
    foot = screw.nearest_point(S)
    assert np.abs(np.cross(foot - q, w)).max() <= 1e-13
    assert np.abs(np.sum(foot * w, -1)).max() <= 1e-13


@pytest.mark.capability("04-91", "04-95")
def test_pure_rotation_and_pure_translation():
    S = screw.from_axis([0, 0, 1], [1, 2, 0])
    assert S.tolist() == [0, 0, 1, 2, -1, 0]
    assert screw.pitch(S) == 0
    slide = screw.from_direction([[0, 3.0, 4.0]])
    assert slide == pytest.approx(np.array([[0, 0, 0, 0, 0.6, 0.8]]))
    assert np.isinf(screw.pitch(slide)).all()
    T = screw.displacement(slide, 2.0)
    assert np.abs(T[0] - pose.from_translation([0, 1.2, 1.6])).max() <= 4 * EPS
    found, amount = screw.chasles(T)
    assert found == pytest.approx(slide)
    assert amount == pytest.approx([2.0])
    identity, nothing = screw.chasles(np.eye(4))
    assert identity.tolist() == [0] * 6
    assert nothing == 0
    dusty = pose.exp([1e-15, 0, 0, 0.3, 0, 0])
    assert screw.chasles(dusty)[0].tolist() == [0, 0, 0, 1, 0, 0]


@settings(max_examples=60, deadline=None)
@given(seeds, st.floats(-7, 7))
@pytest.mark.capability("04-93", "04-94", "04-95")
def test_displacement_is_the_exponential_of_the_matrix(seed: int, amount: float):
    S = screw.normalise(np.random.default_rng(seed).standard_normal(6))
    T = screw.displacement(S, amount)
    assert np.abs(T - matrix_exponential.exponential(pose.hat(S), amount)).max() < 3e-13 * (1 + abs(amount)) ** 2


@pytest.mark.capability("04-94", "04-97")
@pytest.mark.parametrize("theta", [1e-6, 0.1, 1.0, 3.0, pi, 5.0])
def test_integral_of_the_rotation(theta: float):
    w = np.array([2.0, -1, 2]) / 3
    W = rotation.hat(w)
    G = screw.integral(w, theta)
    closed = np.eye(3) * theta + (1 - np.cos(theta)) * W + (theta - np.sin(theta)) * W @ W
    assert np.abs(G - closed).max() <= 8 * EPS * max(1, theta)
    terms = sum(np.linalg.matrix_power(W, k) * theta ** (k + 1) / np.prod(np.arange(1.0, k + 2)) for k in range(40))
    assert np.abs(G - terms).max() <= 1e-13
    assert np.abs(screw.integral_inverse(w, theta) @ G - np.eye(3)).max() <= 1e-13
    assert np.linalg.det(W) == pytest.approx(0, abs=1e-16)
    if theta == pi:
        at_pi = np.eye(3) / pi - W / 2 + W @ W / pi
        assert np.abs(screw.integral_inverse(w, theta) - at_pi).max() <= 4 * EPS


@settings(max_examples=40, deadline=None)
@given(seeds, batches)
@pytest.mark.capability("04-100", "04-104", "04-105")
def test_change_of_frame_and_both_forms(seed: int, shape: tuple[int, ...]):
    T_01, T_ba = poses(seed, shape, 2)
    S = screw.normalise(np.random.default_rng(seed).standard_normal((*shape, 6)))
    S_b = twist.transform(T_ba, S)
    R, p = T_ba[..., :3, :3], T_ba[..., :3, 3]
    omega = rotation.apply(R, S[..., :3])
    size = 1 + np.abs(S_b).max()  # a random twist that hardly turns has a far axis: its moment is rounded at its size
    moved = np.concatenate([omega, rotation.apply(R, S[..., 3:]) + np.cross(p, omega)], -1)
    assert np.abs(S_b - moved).max() <= 1e-14 * size
    assert np.abs(screw.pitch(S_b) - screw.pitch(S)).max() <= 1e-13 * (1 + np.abs(screw.pitch(S)).max())
    assert np.abs(twist.transform(pose.inverse(T_ba), S_b) - S).max() <= 1e-14 * size
    # The moved axis passes through the moved point.
    moved_point = pose.act(T_ba, screw.nearest_point(S))
    assert np.abs(np.cross(moved_point - screw.nearest_point(S_b), omega)).max() <= 1e-12 * (
        1 + np.abs(moved_point).max()
    )
    theta = 1.3
    T_02 = screw.displacement(S, theta) @ T_01
    body = twist.transform(pose.inverse(T_01), S)
    assert np.abs(T_01 @ screw.displacement(body, theta) - T_02).max() <= 1e-13 * size
    assert np.abs(pose.inverse(T_01) @ T_02 - screw.displacement(body, theta)).max() <= 1e-13 * size


def test_normalisation_of_extreme_twists():
    for scale in (1e-300, 1e-160, 1.0, 1e160, 1e300):
        V = np.array([0, 3, 4, 1, 0, 0]) * scale
        assert screw.magnitude(V) == pytest.approx(5 * scale, rel=4 * EPS)
        assert screw.normalise(V) == pytest.approx([0, 0.6, 0.8, 0.2, 0, 0], rel=4 * EPS)
    assert screw.normalise(np.zeros(6)).tolist() == [0] * 6
    assert screw.magnitude(np.zeros(6)) == 0


def test_reciprocal_screws():
    force_line = screw.from_axis([1, 0, 0], [0, 0, 0])
    crossing = screw.from_axis([0, 1, 0], [0.7, 0, 0])
    apart = screw.from_axis([0, 1, 0], [0, 0, 2.0])
    assert screw.reciprocal_product(force_line, crossing) == 0
    assert abs(screw.reciprocal_product(force_line, apart)) == pytest.approx(2.0)
    helix = screw.from_axis([1, 2, 2], [0.3, -0.4, 0.9], 0.7)
    assert screw.reciprocal_product(helix, helix) == pytest.approx(2 * 0.7)


@pytest.mark.capability("04-90", "04-91")
def test_screw_axis_value():
    S = ScrewAxis.of([0, 0, 2], [1, 2, 0], 0.5, "a")
    assert S.array.tolist() == [0, 0, 1, 2, -1, 0.5]
    assert (S.pitch, S.point.tolist(), S.direction.tolist()) == (0.5, [1, 2, 0], [0, 0, 1])
    T = S.displacement(1.2)
    back, amount = ScrewAxis.of_displacement(Pose(T.array, ("a", "a")))
    assert back.close_to(S, 1e-14)
    assert back.frame == "a"
    assert amount == pytest.approx(1.2)
    slide = ScrewAxis.translation([0, 3, 0])
    assert np.isinf(slide.pitch)
    assert slide.direction.tolist() == [0, 1, 0]
    V = 3.0 * S
    assert isinstance(V, Twist)
    again, rate = ScrewAxis.of_twist(V)
    assert again.close_to(S, 4 * EPS)
    assert rate == pytest.approx(3.0)
    T_ba = Pose(poses(1, ())[0], ("b", "a"))
    assert S.seen_from(T_ba).frame == "b"
    assert S.seen_from(T_ba).pitch == pytest.approx(0.5)
    with pytest.raises(InputError, match="not a unit screw"):
        ScrewAxis([0, 0, 2, 0, 0, 0])
    with pytest.raises(InputError, match="not a unit screw"):
        screw.displacement(np.zeros(6), 1.0)
    with pytest.raises(InputError, match="identity has no screw axis"):
        ScrewAxis.of_displacement(Pose.identity())
    with pytest.raises(InputError, match="identity has no screw axis"):
        ScrewAxis.of_twist(Twist(np.zeros(6)))
    with pytest.raises(InputError, match="no direction"):
        screw.from_axis([0, 0, 0], [1, 0, 0])
