"""Laws of poses, Jacobians and their rates for any robot and any batch."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from mafsil.arrays import Floats
from mafsil.model.placement import pose_from_xyz_rpy
from mafsil.robot import Robot
from tests.laws.test_dynamics_laws import ROBOTS, SHAPES, agree, derivative, robot, states, times

OFFSET = pose_from_xyz_rpy((0.3, -0.2, 0.5), (0.4, -1.1, 2.0))


@pytest.fixture(params=ROBOTS)
def name(request: pytest.FixtureRequest) -> str:
    return request.param


@pytest.fixture(params=SHAPES, ids=str)
def shape(request: pytest.FixtureRequest) -> tuple[int, ...]:
    return request.param


def skew(w: Floats) -> Floats:
    zero = np.zeros_like(w[..., 0])
    rows = [[zero, -w[..., 2], w[..., 1]], [w[..., 2], zero, -w[..., 0]], [-w[..., 1], w[..., 0], zero]]
    return np.stack([np.stack(row, -1) for row in rows], -2)


def adjoint(T: Floats) -> Floats:
    """Ad(T) over batches."""
    R, p = T[..., :3, :3], T[..., :3, 3]
    Ad = np.zeros((*T.shape[:-2], 6, 6))
    Ad[..., :3, :3] = Ad[..., 3:, 3:] = R
    Ad[..., 3:, :3] = skew(p) @ R
    return Ad


def inverse(T: Floats) -> Floats:
    result = np.zeros_like(T)
    Rt = np.swapaxes(T[..., :3, :3], -1, -2)
    result[..., :3, :3], result[..., :3, 3], result[..., 3, 3] = Rt, -times(Rt, T[..., :3, 3]), 1.0
    return result


def twist(dT_T: Floats) -> Floats:
    """(omega, v) of a 4x4 twist matrix."""
    w = np.stack([dT_T[..., 2, 1], dT_T[..., 0, 2], dT_T[..., 1, 0]], -1)
    return np.concatenate([w, dT_T[..., :3, 3]], -1)


def test_poses_are_poses(name: str, shape: tuple[int, ...]) -> None:
    r, s = robot(name), states(name, shape)
    for T in (r.forward_kinematics(s.q), r.link_poses(s.q)):
        R = T[..., :3, :3]
        np.testing.assert_allclose(np.swapaxes(R, -1, -2) @ R, np.broadcast_to(np.eye(3), R.shape), atol=2e-14)
        assert (np.linalg.det(R) > 0).all()
        assert (T[..., 3, :] == [0, 0, 0, 1]).all()


@pytest.mark.capability("05-47", "05-49", "05-55")
def test_jacobians_are_the_derivatives_of_the_pose(name: str, shape: tuple[int, ...]) -> None:
    r, s = robot(name), states(name, shape)
    T, dT = r.forward_kinematics(s.q), derivative(name, "forward_kinematics", s, s.qd)
    V_s, V_b = times(r.jacobian_space(s.q), s.qd), times(r.jacobian_body(s.q), s.qd)
    np.testing.assert_allclose(V_s, twist(dT @ inverse(T)), atol=1e-11)
    np.testing.assert_allclose(V_b, twist(inverse(T) @ dT), atol=1e-11)


@pytest.mark.capability("05-56", "05-72")
def test_body_and_space_jacobian_are_one_screw_seen_from_two_frames(name: str, shape: tuple[int, ...]) -> None:
    r, s = robot(name), states(name, shape)
    T = r.forward_kinematics(s.q)
    agree(name, "jacobian_body", adjoint(inverse(T)) @ r.jacobian_space(s.q), r.jacobian_body(s.q))
    agree(name, "jacobian_space", adjoint(T) @ r.jacobian_body(s.q), r.jacobian_space(s.q))


@pytest.mark.capability("09-67")
def test_rates_of_the_jacobians_are_their_derivatives(name: str, shape: tuple[int, ...]) -> None:
    r, s = robot(name), states(name, shape)
    for quantity in ("jacobian_space", "jacobian_body"):
        rate = getattr(r, f"{quantity}_rate")(s.q, s.qd)
        agree(name, f"{quantity}_rate", derivative(name, quantity, s, s.qd), rate)


@pytest.mark.capability("05-50")
def test_a_twist_is_the_sum_of_the_joints_twists(name: str) -> None:
    r, s = robot(name), states(name, (4,))
    columns = np.eye(r.n) * s.qd[:, None]
    each = times(r.jacobian_space(s.q)[:, None], columns)
    np.testing.assert_allclose(each.sum(1), times(r.jacobian_space(s.q), s.qd), atol=1e-12)


@pytest.mark.capability("05-73")
def test_moving_the_base_keeps_the_body_jacobian_and_moving_the_tip_the_space_jacobian(name: str) -> None:
    r, s = robot(name), states(name, (3,))
    T = r.forward_kinematics(s.q)
    carried = Robot(replace(r.mechanism, T_sb=OFFSET @ r.mechanism.T_sb))
    agree(name, "forward_kinematics", carried.forward_kinematics(s.q), OFFSET @ T)
    agree(name, "jacobian_body", carried.jacobian_body(s.q), r.jacobian_body(s.q))
    agree(name, "jacobian_space", carried.jacobian_space(s.q), adjoint(OFFSET) @ r.jacobian_space(s.q))
    tool = Robot(r.mechanism.with_tip(r.mechanism.tip, r.mechanism.T_lt @ OFFSET))
    agree(name, "forward_kinematics", tool.forward_kinematics(s.q), T @ OFFSET)
    agree(name, "jacobian_space", tool.jacobian_space(s.q), r.jacobian_space(s.q))
    agree(name, "jacobian_body", tool.jacobian_body(s.q), adjoint(inverse(OFFSET)) @ r.jacobian_body(s.q))
    agree(name, "inverse_dynamics", tool.inverse_dynamics(s.q, s.qd, s.qdd), r.inverse_dynamics(s.q, s.qd, s.qdd))


@pytest.mark.capability("05-62", "05-65", "09-64")
def test_a_wrench_has_one_effect_in_any_frame(name: str) -> None:
    r, s = robot(name), states(name, (3,))
    T = r.forward_kinematics(s.q)
    F_s = times(np.swapaxes(adjoint(inverse(T)), -1, -2), s.tip_wrench)
    by_space = times(np.swapaxes(r.jacobian_space(s.q), -1, -2), F_s)
    by_body = times(np.swapaxes(r.jacobian_body(s.q), -1, -2), s.tip_wrench)
    np.testing.assert_allclose(by_space, by_body, atol=1e-11)
    zero = np.zeros(r.n)
    pushed = r.inverse_dynamics(s.q, zero, zero, s.tip_wrench) - r.gravity_torque(s.q)
    agree(name, "inverse_dynamics", pushed, by_body)


@pytest.mark.capability("05-40", "05-43")
def test_frames_by_name_are_the_tips_of_robots_with_that_tip() -> None:
    r, s = robot("tree"), states("tree", (2,))
    for link in r.mechanism.link_names[::3]:
        other = Robot(r.mechanism.with_tip(link))
        for quantity in ("forward_kinematics", "jacobian_space", "jacobian_body"):
            agree("tree", quantity, getattr(r, quantity)(s.q, frame=link), getattr(other, quantity)(s.q))
