"""Jacobians against finite differences, statics against dynamics, equilibrium link by link, limits by brute force."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil.errors import InputError
from mafsil.geometry import euler, pose, quaternion, rotation, twist, wrench
from mafsil.performance import (
    analytic_jacobian,
    force_polytope,
    in_equilibrium,
    jacobian_by_inspection,
    joint_reactions,
    joint_torque,
    joint_twists,
    largest_force,
    largest_payload,
    point_velocity,
    scaled_jacobian,
    self_motion,
    task_jacobian,
    tip_wrench,
    tool_jacobian,
    velocity_polytope,
    work,
)
from mafsil.performance.statics import structure_wrenches, sum_of_moments, total_wrench, unbalanced_links
from mafsil.performance.statics.tip_wrenches import StaticsStatus
from mafsil.performance.velocity import body_from_space, space_from_body, task_rows

H = 1e-6
ROBOTS = ("puma560", "panda", "stanford_arm", "cobra600", "planar3r")


def states(robot, count, seed=0):
    return np.random.default_rng(seed).uniform(-1.2, 1.2, (count, robot.n))


def slope(function, q, n):
    """(k, m, n) central differences."""
    return np.stack([(function(q + H * e) - function(q - H * e)) / (2 * H) for e in np.eye(n)], axis=-1)


@pytest.mark.capability("05-47", "05-49", "05-55")
@pytest.mark.parametrize("name", ROBOTS)
def test_velocity_of_a_point_of_any_frame(name):
    robot = mf.load(name)
    q, r = states(robot, 6), np.array([0.1, -0.2, 0.3])
    for frame in (None, robot.mechanism.link_names[-2]):

        def place(x, frame=frame):
            T = robot.forward_kinematics(x, frame=frame)
            return T[..., :3, 3] + T[..., :3, :3] @ r

        J = tool_jacobian(robot, q, frame=frame, point=r)
        np.testing.assert_allclose(J[:, 3:], slope(place, q, robot.n), atol=1e-8)
        qd = states(robot, 6, 1)
        np.testing.assert_allclose(
            point_velocity(robot, q, qd, frame=frame, point=r), np.einsum("kij,kj->ki", J[:, 3:], qd), atol=1e-14
        )


@pytest.mark.capability("05-47")
@pytest.mark.parametrize("orientation", [*euler.SEQUENCES, "quaternion", "exponential"])
def test_analytic_jacobian_is_the_derivative_of_the_coordinates(orientation):
    robot = mf.load("puma560")
    q = states(robot, 8, 3)

    def coordinates(x):
        T = robot.forward_kinematics(x)
        R = T[..., :3, :3]
        match orientation:
            case "quaternion":
                angles = quaternion.to_quaternion(R)
            case "exponential":
                angles = rotation.log(R)
            case _:
                angles = euler.to_euler(R, orientation)
        return np.concatenate([angles, T[..., :3, 3]], axis=-1)

    J = analytic_jacobian(robot, q, orientation)
    assert J.shape == (8, 7 if orientation == "quaternion" else 6, 6)
    numeric = slope(coordinates, q, 6)
    jumps = np.abs(numeric).max(axis=(1, 2)) > 1e4  # a branch of the angles was crossed
    assert not jumps.all()
    np.testing.assert_allclose(J[~jumps], numeric[~jumps], rtol=1e-5, atol=2e-7)


@pytest.mark.capability("05-47")
def test_at_a_gimbal_lock_there_are_no_rates():
    robot = mf.load("elbow6r")
    R = robot.forward_kinematics(np.zeros(6))[:3, :3]
    locked = next(
        s
        for s in euler.SEQUENCES
        if abs(np.linalg.det(euler.rates_to_angular_velocity(euler.to_euler(R, s), s))) < 1e-12
    )
    with pytest.raises(InputError, match="gimbal lock"):
        analytic_jacobian(robot, np.zeros(6), locked)
    assert np.isnan(analytic_jacobian(robot, np.zeros((2, 6)), locked)[:, :3]).all()


@pytest.mark.capability("05-50", "05-56")
@pytest.mark.parametrize("name", ROBOTS)
def test_frames_of_jacobians_and_single_joint_twists(name):
    robot = mf.load(name)
    q, qd = states(robot, 5), states(robot, 5, 1)
    T, J_s, J_b = robot.forward_kinematics(q), robot.jacobian_space(q), robot.jacobian_body(q)
    np.testing.assert_allclose(space_from_body(T, J_b), J_s, atol=1e-13)
    np.testing.assert_allclose(body_from_space(T, J_s), J_b, atol=1e-13)
    V_s = np.einsum("kij,kj->ki", J_s, qd)
    np.testing.assert_allclose(joint_twists(robot, q, qd).sum(axis=1), V_s, atol=1e-13)
    np.testing.assert_allclose(twist.transform(T, np.einsum("kij,kj->ki", J_b, qd)), V_s, atol=1e-12)


@pytest.mark.capability("05-51")
@given(st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_a_moved_screw_is_the_same_screw_seen_from_elsewhere(seed):
    rng = np.random.default_rng(seed)
    M, N = pose.exp(rng.normal(size=6)), pose.exp(rng.normal(size=6))
    np.testing.assert_allclose(pose.adjoint(M) @ pose.adjoint(N), pose.adjoint(M @ N), atol=1e-13)
    w, p, h = rng.normal(size=3), rng.normal(size=3), float(rng.normal())
    S = jacobian_by_inspection(w[None], p[None], pitches=[h])[:, 0]
    moved = jacobian_by_inspection((M[:3, :3] @ w)[None], (M[:3, :3] @ p + M[:3, 3])[None], pitches=[h])[:, 0]
    np.testing.assert_allclose(pose.adjoint(M) @ S, moved, atol=1e-12)


@pytest.mark.capability("05-52")
@pytest.mark.parametrize("name", ["puma560", "stanford_arm", "cobra600"])
def test_jacobian_by_inspection(name):
    robot = mf.load(name)
    q = states(robot, 4)
    poses = robot.link_poses(q)[:, 1 : robot.n + 1]
    axes = np.stack([poses[:, k, :3, :3] @ j.axis for k, j in enumerate(robot.mechanism.joints[: robot.n])], axis=1)
    kinds = ["P" if j.kind is mf.model.JointKind.PRISMATIC else "R" for j in robot.mechanism.coordinates]
    J = jacobian_by_inspection(3.0 * axes, poses[..., :3, 3], kinds)
    np.testing.assert_allclose(J, robot.jacobian_space(q), atol=1e-13)


def test_inspection_refuses_what_is_no_axis():
    with pytest.raises(InputError, match="joint 1"):
        jacobian_by_inspection([[0, 0, 1], [0, 0, 0]], np.zeros((2, 3)))
    with pytest.raises(InputError, match="letter R or P"):
        jacobian_by_inspection(np.eye(3), np.zeros((3, 3)), "RX")


@pytest.mark.capability("05-47")
def test_task_rows():
    robot = mf.load("planar3r")
    assert task_jacobian(robot, np.zeros(3), "planar").shape == (3, 3)
    assert task_rows([5, 0]) == (5, 0)
    for wrong in ([1, 1], [6], []):
        with pytest.raises(InputError, match="0 to 5"):
            task_rows(wrong)
    with pytest.raises(InputError, match="planar_position"):
        task_rows("flat")
    with pytest.raises(InputError):
        scaled_jacobian(robot, np.zeros(3), length=0.0)


@pytest.mark.capability("05-65", "05-69")
@pytest.mark.parametrize("name", ROBOTS)
def test_torques_do_the_work_of_the_wrench(name):
    robot = mf.load(name)
    q, qd = states(robot, 4), states(robot, 4, 1)
    F = np.random.default_rng(2).normal(size=(4, 6))
    V_b = np.einsum("kij,kj->ki", robot.jacobian_body(q), qd)
    tau = joint_torque(robot, q, F)
    np.testing.assert_allclose((tau * qd).sum(axis=-1), (F * V_b).sum(axis=-1), atol=1e-12)
    zero = np.zeros_like(q)
    np.testing.assert_allclose(tau, robot.inverse_dynamics(q, zero, zero, F) - robot.gravity_torque(q), atol=1e-11)


@pytest.mark.capability("05-60")
@pytest.mark.parametrize("name", ROBOTS)
def test_every_link_is_in_equilibrium(name):
    robot = mf.load(name)
    q, F = states(robot, 4), np.random.default_rng(2).normal(size=(4, 6))
    found = joint_reactions(robot, q, F)
    zero = np.zeros_like(q)
    np.testing.assert_allclose(found.torque, robot.inverse_dynamics(q, zero, zero, F), atol=1e-11)
    np.testing.assert_allclose(unbalanced_links(robot, q, found.about_origin, F), 0, atol=1e-12)
    wrong = found.about_origin.copy()
    wrong[:, 0, 3] += 1.0
    assert np.abs(unbalanced_links(robot, q, wrong, F)).max() > 0.5


@pytest.mark.capability("05-66", "05-67")
def test_why_torques_do_not_determine_the_wrench():
    arm, q = mf.load("cobra600"), [0.1, 0.5, 0.1, 0.2]
    answer = tip_wrench(arm, q, [1.0, 2.0, 3.0, 0.5])
    assert answer.status is StaticsStatus.CARRIED
    assert answer.carried.shape == (2, 6)
    np.testing.assert_allclose(arm.jacobian_space(q).T @ structure_wrenches(arm, q).T, 0, atol=1e-12)
    panda, q7 = mf.load("panda"), states(mf.load("panda"), 1)[0]
    motion = self_motion(panda, q7)
    np.testing.assert_allclose(panda.jacobian_body(q7) @ motion.T, 0, atol=1e-12)
    loose = tip_wrench(panda, q7, motion[0])
    assert loose.status is StaticsStatus.UNBALANCED
    np.testing.assert_allclose(loose.F, 0, atol=1e-10)
    balanced = tip_wrench(panda, q7, joint_torque(panda, q7, [1, 2, 3, 4, 5, 6]))
    assert balanced.status is StaticsStatus.DETERMINED
    singular = tip_wrench(mf.load("puma560"), np.zeros(6), np.arange(1.0, 7.0))
    assert singular.status is StaticsStatus.UNBALANCED_AND_CARRIED
    for result in (answer, loose, balanced, singular):
        assert result.explain(language="en") != result.explain(language="ar")


@pytest.mark.capability("05-58", "05-59", "05-64")
def test_equilibrium_of_a_body():
    forces, points = [[0, 0, 1.0], [0, 0, 1.0], [0, 0, -2.0]], [[1.0, 0, 0], [-1.0, 0, 0], [0, 0, 0]]
    assert in_equilibrium(total_wrench(forces, points))
    assert in_equilibrium(total_wrench(forces, points, about=[3.0, 1.0, 0.0]))
    assert not in_equilibrium(total_wrench(forces, [[1.0, 0, 0], [1.0, 0, 0], [0, 0, 0]]))
    np.testing.assert_array_equal(total_wrench(forces[:1], points[:1], moments=[[0, 1.0, 0]]), [0, 0, 0, 0, 0, 1])
    np.testing.assert_array_equal(sum_of_moments([[1, 0, 0], [2, 0, 0]], [[0, 0, 1], [0, 0, 1]]), [3, 0, 0])
    with pytest.raises(InputError, match="different points"):
        sum_of_moments([[1, 0, 0], [2, 0, 0]], [[0, 0, 1], [0, 0, 2]])


@pytest.mark.capability("05-63")
def test_work_of_a_weight():
    t = np.linspace(0, 2, 101)
    V = np.zeros((101, 6))
    V[:, 5] = 0.3 * t
    F = np.broadcast_to(wrench.from_force([0.0, 0, 0], [0, 0, -9.81]), (101, 6))
    assert work(F, V, t) == pytest.approx(-9.81 * 0.15 * 4, rel=1e-12)


@pytest.mark.capability("05-66")
def test_largest_force_and_payload_stand_at_a_limit():
    robot = mf.load("ur5e")
    q = np.array([[0, -1, 1.2, -0.5, 1.2, 0], [0.3, -1.4, 1.0, 0.2, -1.0, 0.5]])
    load = largest_payload(robot, q, [0.0, 0.0, 0.1])
    lifted = np.zeros((2, 6))
    lifted[:, 5] = 9.81 * load.largest
    T = robot.forward_kinematics(q)
    lifted[:, :3] = np.cross(T[:, :3, 3] + 0.1 * T[:, :3, 2], lifted[:, 3:])
    tau = robot.gravity_torque(q) + joint_torque(robot, q, lifted, given_in="space")
    share = np.abs(tau) / robot.limits.effort
    np.testing.assert_allclose(share.max(axis=1), 1.0, rtol=1e-10)
    np.testing.assert_array_equal(share.argmax(axis=1), load.limiting_joint)
    shape = force_polytope(robot, q[0])
    for direction in ([0, 0, 1.0], [1.0, 0, 0], [0.6, 0, -0.8]):
        reach = largest_force(robot, q[0], direction).largest
        assert shape.contains(0.9999 * reach * np.array(direction))
        assert not shape.contains(1.0001 * reach * np.array(direction))


@pytest.mark.capability("05-84")
def test_velocity_polytope_holds_all_velocities():
    robot = mf.load("puma560")
    q = states(robot, 1)[0]
    shape = velocity_polytope(robot, q)
    rates = np.random.default_rng(0).uniform(-1, 1, (500, 6)) * robot.limits.velocity
    assert shape.contains(rates @ task_jacobian(robot, q, "position").T).all()
    assert shape.contains(shape.vertices).all()
    assert not shape.contains(1.01 * shape.vertices).any()
    assert shape.volume > 0


def test_limits_that_are_not_there():
    with pytest.raises(InputError, match="no limit of velocity"):
        velocity_polytope(mf.load("planar2r"), [0, 1], "planar_position")
    with pytest.raises(InputError, match="flat or unbounded"):
        force_polytope(mf.load("ur5e"), [0, 0, 0, 0, 0, 0], "pose")
    light = mf.Robot(mf.load("puma560").mechanism.with_gravity(np.zeros(3)))
    with pytest.raises(InputError, match="no gravity"):
        largest_payload(light, np.zeros(6))
    heavy = mf.Robot(mf.load("puma560").mechanism.with_gravity(np.array([0, 0, -98.1])))
    with pytest.raises(InputError, match="weight of the arm"):
        force_polytope(heavy, [0, 0, 0.3, 0, 0.5, 0])
    assert np.isnan(largest_payload(heavy, np.zeros(6)).largest)
    with pytest.raises(InputError, match="not zero"):
        largest_force(heavy, np.zeros(6), [0, 0, 0])
