"""Vectors in turning frames, wrenches on inner links, the free body of a link."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError, ModelError
from mafsil.geometry import rotation, wrench
from mafsil.geometry.relative_motion import point_acceleration, vector_rate
from mafsil.performance import free_body_diagram, joint_torque

RNG = np.random.default_rng(9)


def orientation(t):
    """R_sb(t), and its body angular velocity by the derivative of its exponential."""
    return rotation.exp(np.array([0.3, -0.5, 0.2]) * t) @ rotation.exp(np.array([0.1, 0.7, -0.4]) * t * t)


def slope(f, t, h=1e-5):
    return (f(t - 2 * h) - 8 * f(t - h) + 8 * f(t + h) - f(t + 2 * h)) / (12 * h)


@pytest.mark.capability("09-25")
def test_vectors_given_in_a_frame_that_turns():
    """The derivative in {s} of R x(t) is R (dx + omega x x); of the unit vectors omega x e_i; [omega] = R' dR/dt."""
    t = 0.8
    R = orientation(t)
    omega = rotation.vee(R.T @ slope(orientation, t))

    def x(t):
        return np.array([np.sin(t), t**3, 2.0 - t])

    truth = slope(lambda t: orientation(t) @ x(t), t)
    np.testing.assert_allclose(R @ vector_rate(omega, x(t), slope(x, t)), truth, atol=1e-9)
    axes = slope(orientation, t).T  # rows: derivatives of x_b, y_b, z_b in {s}
    np.testing.assert_allclose(vector_rate(omega, np.eye(3)) @ R.T, axes, atol=1e-9)
    assert vector_rate(RNG.normal(size=(4, 1, 3)), RNG.normal(size=(5, 3))).shape == (4, 5, 3)
    with pytest.raises(InputError, match="dx"):
        vector_rate(omega, np.eye(3), [1.0, 2.0])


@pytest.mark.capability("09-26")
def test_acceleration_of_a_point_of_a_moving_arm():
    robot = mf.load("puma560")
    q, qd, qdd = RNG.normal(size=(3, 6))
    point = np.array([0.1, -0.2, 0.3])

    def place(t):
        T = robot.forward_kinematics(q + t * qd + t * t / 2 * qdd)
        return T[:3, :3] @ point + T[:3, 3]

    h = 1e-3
    truth = (place(h) - 2 * place(0) + place(-h)) / h**2
    J, dJ = robot.jacobian_body(q), robot.jacobian_body_rate(q, qd)
    found = point_acceleration(J @ qd, J @ qdd + dJ @ qd, point)
    R = robot.forward_kinematics(q)[:3, :3]
    np.testing.assert_allclose(R @ found, truth, atol=2e-4)
    assert np.abs(R @ (J @ qdd + dJ @ qd)[3:] - truth).max() > 0.1, "not the derivative of the twist alone"


@pytest.mark.capability("09-34")
def test_commutator_of_rotations():
    w_1, w_2 = RNG.normal(size=(2, 7, 3))
    np.testing.assert_allclose(rotation.bracket(w_1, w_2), np.cross(w_1, w_2), atol=1e-14)
    A, B = rotation.hat(w_1), rotation.hat(w_2)
    np.testing.assert_allclose(rotation.hat(rotation.bracket(w_1, w_2)), A @ B - B @ A, atol=1e-14)


@pytest.mark.capability("09-76", "09-47")
def test_a_force_at_a_point_of_any_link():
    """As a wrench in {s} or in the link: the efforts do the power of the force at that point."""
    robot = mf.load("ur5e")
    q, qd = RNG.normal(size=(2, 6))
    for link in robot.mechanism.link_names[1:]:
        T = robot.forward_kinematics(q, frame=link)
        r, f, n = RNG.normal(size=(3, 3))
        F_body = mf.Wrench.from_force(r, f).array + np.concatenate([n, np.zeros(3)])
        tau = joint_torque(robot, q, F_body, frame=link)
        V = robot.jacobian_body(q, frame=link) @ qd
        velocity = V[3:] + np.cross(V[:3], r)
        assert tau @ qd == pytest.approx(f @ velocity + n @ V[:3])
        at = T[:3, :3] @ r + T[:3, 3]
        F_space = np.concatenate([T[:3, :3] @ n + np.cross(at, T[:3, :3] @ f), T[:3, :3] @ f])
        np.testing.assert_allclose(joint_torque(robot, q, F_space, given_in="space", frame=link), tau, atol=1e-12)
        np.testing.assert_allclose(wrench.transform(T, F_space), F_body, atol=1e-12)


@pytest.mark.capability("09-75")
def test_a_force_that_is_constant_in_space_turns_in_the_tip_frame():
    robot, q = mf.load("planar2r_point_masses"), np.array([0.3, 0.4])
    f = np.array([3.0, -2.0, 0.0])

    def exerted(t, q, qd):
        return np.concatenate([np.zeros(3), robot.forward_kinematics(q)[:3, :3].T @ f])

    moved = mf.simulation.forward_dynamics_trajectory(robot, q, tip_wrench=exerted, duration=0.5, tolerance=1e-11)
    by_joints = mf.simulation.forward_dynamics_trajectory(
        robot,
        q,
        tau=lambda t, q, qd: -robot.jacobian_body(q).T @ exerted(t, q, qd),
        duration=0.5,
        tolerance=1e-11,
    )
    np.testing.assert_allclose(moved.q[-1], by_joints.q[-1], atol=1e-8)
    still = mf.simulation.forward_dynamics_trajectory(robot, q, tip_wrench=exerted(0, q, q), duration=0.5)
    assert np.abs(still.q[-1] - moved.q[-1]).max() > 1e-3


@pytest.mark.capability("09-77")
def test_an_accelerating_base_is_gravity():
    robot, a = mf.load("puma560"), np.array([0.7, -1.1, 2.3])
    q, qd, qdd = RNG.normal(size=(3, 6))
    accelerated = robot.inverse_dynamics(q, qd, qdd, base_acceleration=[0, 0, 0, *a])
    other = mf.Robot(robot.mechanism.with_gravity(robot.mechanism.gravity - a))
    np.testing.assert_allclose(accelerated, other.inverse_dynamics(q, qd, qdd), atol=1e-11)
    falling = robot.inverse_dynamics(q, qd, qdd, base_acceleration=[0, 0, 0, *robot.mechanism.gravity])
    np.testing.assert_allclose(falling, robot.mass_matrix(q) @ qdd + robot.velocity_torque(q, qd), atol=1e-11)


@pytest.mark.capability("09-74")
def test_articulated_bodies_equal_the_linear_solve_and_flag_massless_motions():
    robot = mf.load("puma560")
    q, qd, tau = RNG.normal(size=(3, 50, 6))
    load = tau - robot.velocity_torque(q, qd) - robot.gravity_torque(q)
    solved = np.linalg.solve(robot.mass_matrix(q), load[..., None])[..., 0]
    np.testing.assert_allclose(robot.forward_dynamics(q, qd, tau), solved, rtol=1e-9, atol=1e-9)
    massless = mf.Robot(mf.model.library.textbook.planar2r_point_masses((1.0, 1.0), (1.0, 0.0)))
    with pytest.raises(ModelError, match="not determined"):
        massless.forward_dynamics([0.3, 0.4], [0, 0], [1, 1])


@pytest.mark.capability("09-43", "09-44")
def test_free_body_of_every_link():
    """The wrenches on each link change its momentum; action and reaction at a joint cancel; the joint's own effort."""
    robot = mf.load("panda")
    q, qd, qdd = RNG.normal(size=(3, 7))
    F_tip = RNG.normal(size=6)
    tau = robot.inverse_dynamics(q, qd, qdd, F_tip)
    for k, joint in enumerate(robot.mechanism.joints):
        found = free_body_diagram(robot, joint.child, q, qd, qdd, F_tip)
        assert found.residual < 1e-10
        assert np.abs(found.wrenches).max() > 1e-3
        own = found.wrenches[found.names.index(joint.name)]
        if joint.moves:
            assert joint.screw @ own == pytest.approx(tau[robot.joint_names.index(joint.name)], abs=1e-9)
        if k and joint.parent != robot.mechanism.links[0].name:
            parent = free_body_diagram(robot, joint.parent, q, qd, qdd, F_tip)
            T = np.linalg.inv(robot.link_poses(q)[robot.mechanism.parents[k]]) @ robot.link_poses(q)[k + 1]
            reaction = parent.wrenches[parent.names.index(joint.name)]
            np.testing.assert_allclose(wrench.transform(T, reaction), -own, atol=1e-9)
    text = free_body_diagram(robot, robot.mechanism.tip, q, tip_wrench=F_tip).explain("en")
    assert "weight" in text
    assert "world at the tip" in text
    assert free_body_diagram("panda", robot.mechanism.tip, q).explain("ar")
    with pytest.raises(ModelError, match="nowhere"):
        free_body_diagram(robot, "nowhere", q)
