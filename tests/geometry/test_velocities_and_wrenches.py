"""Twists from moving frames and back, changes of frame, wrenches, power, and the values Twist and Wrench."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings

from mafsil.errors import InputError
from mafsil.geometry import Pose, Twist, Wrench, pose, rotation, twist, wrench
from tests.geometry.samples import batches, poses, seeds

EPS = 2.0**-52


def motion(t: float) -> np.ndarray:
    """A curve of poses whose axis and rate vary."""
    return pose.exp(np.array([0.3 * t, np.sin(t), 0.5 - t**2, t, -(t**2), 0.2])) @ pose.exp([0.1, 0, t, 0, t, 0])


def slope(t: float, h: float = 1e-5) -> np.ndarray:
    return (motion(t + h) - motion(t - h)) / (2 * h)


@pytest.mark.capability("04-106")
def test_instantaneous_axis_and_rate_as_the_limit_of_two_rotations():
    t = 0.4
    R = motion(t)[:3, :3]
    exact = twist.angular_velocity_space(R, slope(t)[:3, :3])
    errors = []
    for dt in (1e-2, 1e-3, 1e-4):
        mean = twist.mean_angular_velocity(R, motion(t + dt)[:3, :3], dt)
        errors.append(np.linalg.norm(mean - exact))
    assert errors[1] < errors[0] / 5
    assert errors[2] < 1e-3
    mean = twist.mean_space_twist(motion(t), motion(t + 1e-6), 1e-6)
    assert np.abs(mean - twist.space_from_pose_rate(motion(t), slope(t))).max() < 1e-4
    direction, rate = exact / np.linalg.norm(exact), np.linalg.norm(exact)
    assert np.abs(direction * rate - exact).max() <= 4 * EPS * rate


@pytest.mark.capability("04-107", "04-108")
def test_derivatives_of_the_axes_and_both_angular_velocities():
    R, Rdot = motion(0.7)[:3, :3], slope(0.7)[:3, :3]
    w_s, w_b = twist.angular_velocity_space(R, Rdot), twist.angular_velocity_body(R, Rdot)
    for k in range(3):
        assert np.abs(np.cross(w_s, R[:, k]) - Rdot[:, k]).max() < 1e-8
    assert np.abs(R @ w_b - w_s).max() < 1e-8
    assert np.abs(rotation.hat(w_s) @ R - Rdot).max() < 1e-8
    assert np.abs(R @ rotation.hat(w_b) - Rdot).max() < 1e-8
    for read in (twist.angular_velocity_space, twist.angular_velocity_body):
        with pytest.raises(InputError, match="not a velocity of R"):
            read(R, Rdot + 1e-3 * R)
    assert twist.angular_velocity_space(R, np.zeros((3, 3))).tolist() == [0, 0, 0]


@pytest.mark.capability("04-109", "04-110", "04-112")
def test_body_and_space_twist_of_a_moving_pose():
    T, Tdot = motion(0.2), slope(0.2)
    V_b, V_s = twist.body_from_pose_rate(T, Tdot), twist.space_from_pose_rate(T, Tdot)
    R, p, pdot = T[:3, :3], T[:3, 3], Tdot[:3, 3]
    assert np.abs(V_b[3:] - R.T @ pdot).max() <= 8 * EPS
    assert np.abs(V_s[3:] - (pdot - np.cross(V_s[:3], p))).max() <= 8 * EPS
    assert np.abs(pose.hat(V_b) - np.linalg.inv(T) @ Tdot).max() < 1e-8
    assert np.abs(pose.hat(V_s) - Tdot @ np.linalg.inv(T)).max() < 1e-8
    assert np.abs(twist.transform(T, V_b) - V_s).max() < 1e-8
    assert np.abs(twist.transform(pose.inverse(T), V_s) - V_b).max() < 1e-8
    assert np.abs(twist.pose_rate_from_body(T, V_b) - Tdot).max() < 1e-8
    assert np.abs(twist.pose_rate_from_space(T, V_s) - Tdot).max() < 1e-8
    blocks = np.block([[R, np.zeros((3, 3))], [rotation.hat(p) @ R, R]])
    assert np.abs(blocks @ V_b - V_s).max() < 1e-8
    with pytest.raises(InputError, match="Rdot"):
        twist.space_from_pose_rate(T, Tdot + np.eye(4))
    with pytest.raises(InputError, match="Rdot"):
        twist.body_from_pose_rate(np.stack([T, T]), np.stack([Tdot, Tdot + np.eye(4)]))


@pytest.mark.capability("04-111")
def test_meaning_of_the_linear_parts():
    T, Tdot = motion(0.2), slope(0.2)
    V_s, V_b = twist.space_from_pose_rate(T, Tdot), twist.body_from_pose_rate(T, Tdot)
    body_point = np.array([0.4, -0.3, 0.8, 1.0])
    velocity = (Tdot @ body_point)[:3]
    assert np.abs(twist.point_velocity(V_s, (T @ body_point)[:3]) - velocity).max() < 1e-8
    assert np.abs(T[:3, :3] @ twist.point_velocity(V_b, body_point[:3]) - velocity).max() < 1e-8
    # v_s is the velocity of the body point that is at the fixed origin now, v_b that of the moving origin.
    at_origin = np.linalg.inv(T) @ [0, 0, 0, 1]
    assert np.abs((Tdot @ at_origin)[:3] - V_s[3:]).max() < 1e-8
    assert np.abs(T[:3, :3] @ V_b[3:] - Tdot[:3, 3]).max() < 1e-8


@settings(max_examples=60, deadline=None)
@given(seeds, batches)
@pytest.mark.capability("04-100", "04-102", "04-104", "04-113", "04-114", "04-115")
def test_changes_of_frame_keep_the_power(seed: int, shape: tuple[int, ...]):
    rng = np.random.default_rng(seed)
    (T_ab,) = poses(seed, shape)
    V_b, f_a, r_a = rng.standard_normal((*shape, 6)), *rng.standard_normal((2, *shape, 3))
    F_a = wrench.from_force(r_a, f_a)
    assert np.abs(F_a[..., :3] - np.cross(r_a, f_a)).max() <= 16 * EPS
    F_b = wrench.transform(T_ab, F_a)
    V_a = twist.transform(T_ab, V_b)
    assert np.abs(wrench.power(V_a, F_a) - wrench.power(V_b, F_b)).max() <= 1e-13
    r_b = pose.act(pose.inverse(T_ab), r_a)
    f_b = rotation.apply(rotation.inverse(T_ab[..., :3, :3]), f_a)
    assert np.abs(F_b - wrench.from_force(r_b, f_b)).max() <= 1e-13
    Ad = pose.adjoint(T_ab)
    assert np.abs(F_b - np.matmul(np.swapaxes(Ad, -1, -2), F_a[..., None])[..., 0]).max() <= 1e-13
    # Brackets: ad(V) W is the change of W carried along V, ad(V)' its dual.
    W, F = rng.standard_normal((2, *shape, 6))
    assert np.abs(np.matmul(twist.ad(V_b), W[..., None])[..., 0] - twist.bracket(V_b, W)).max() <= 1e-14
    assert np.abs(twist.bracket(V_b, W) + twist.bracket(W, V_b)).max() <= 1e-14
    balance = wrench.power(twist.bracket(V_b, W), F) - wrench.power(W, wrench.dual_bracket(V_b, F))
    assert np.abs(balance).max() <= 1e-13
    left = twist.transform(T_ab, twist.bracket(V_b, W))
    assert np.abs(left - twist.bracket(V_a, twist.transform(T_ab, W))).max() <= 1e-12


@pytest.mark.capability("04-113")
def test_couples_and_sums_are_wrenches_too():
    couple = wrench.from_couple([0, 0, 2.0])
    assert couple.tolist() == [0, 0, 2, 0, 0, 0]
    assert np.isinf(wrench.pitch(couple))
    pair = wrench.from_force([0, 1, 0], [-1, 0, 0]) + wrench.from_force([0, -1, 0], [1, 0, 0])
    assert pair == pytest.approx(couple)
    line = wrench.from_force([1.0, 2.0, 0], [0, 0, 3.0]) + wrench.from_couple([0, 0, 6.0])
    assert wrench.pitch(line) == pytest.approx(2.0)
    assert wrench.axis_point(line) == pytest.approx([1, 2, 0])


@pytest.mark.capability("04-104", "04-115")
def test_values_carry_their_frame():
    T_ab = Pose(poses(1, ())[0], ("a", "b"))
    V_b = Twist.of([0.1, 0.2, 0.3], [1, 2, 3], "b")
    F_b = Wrench.from_force([0.1, 0, 0], [0, 1, 0], "b")
    V_a, F_a = V_b.seen_from(T_ab), F_b.seen_from(T_ab)
    assert (V_a.frame, F_a.frame) == ("a", "a")
    assert V_a.power(F_a) == pytest.approx(V_b.power(F_b))
    assert np.abs(wrench.transform(T_ab.array, F_a.array) - F_b.array).max() <= 8 * EPS
    assert V_a.seen_from(T_ab.inverse()).close_to(V_b, 8 * EPS)
    for refused in (lambda: V_a.power(F_b), lambda: V_a.seen_from(T_ab), lambda: V_a + V_b, lambda: F_a + F_b):
        with pytest.raises(InputError, match="adjacent letters"):
            refused()
    assert (V_b + V_b).close_to(2.0 * V_b, 0)
    assert (F_b + F_b).close_to(2.0 * F_b, 0)
    assert V_b.omega.tolist() == [0.1, 0.2, 0.3]
    assert V_b.v.tolist() == [1, 2, 3]
    assert F_b.force.tolist() == [0, 1, 0]
    assert F_b.moment.tolist() == [0, 0, 0.1]
    assert F_b.pitch == 0
    assert Wrench.from_couple([1, 0, 0]).close_to(Wrench.of([1, 0, 0], [0, 0, 0]), 0)
    assert V_b.point_velocity([0, 0, 0]).tolist() == [1, 2, 3]
    assert V_b.bracket(V_b).close_to(Twist(np.zeros(6)), EPS)
    assert Twist.of(np.zeros((4, 1, 3)), np.ones(3)).batch == (4, 1)
