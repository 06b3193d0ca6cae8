"""Tasks said in minimal coordinates: three angles and a place, whose errors obey their equation exactly."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.control import TaskCoordinates, TaskTarget, hold_pose, task_computed_torque, task_dynamics
from mafsil.control.laws import TipMotion
from mafsil.errors import InputError
from mafsil.geometry import euler, pose
from mafsil.trajectory import Motion, line_path, time_law

UR5E = mf.load("ur5e")
Q = np.array([0.3, -1.2, 1.2, 0.4, 1.0, 0.2])


@pytest.mark.capability("10-58")
@pytest.mark.parametrize("sequence", ["ZYX", "xyz", "ZYZ", "xzx"])
def test_rates_of_angles_are_derivatives_of_angles(sequence):
    task, h = TaskCoordinates(sequence), 1e-6
    q, qd = Q + 0.1 * np.arange(6), np.linspace(0.5, -0.7, 6)

    def coordinates(q):
        P = UR5E.forward_kinematics(q)
        return np.concatenate([euler.to_euler(P[:3, :3], sequence), P[:3, 3]])

    J = task.jacobian(UR5E, q)
    np.testing.assert_allclose(J @ qd, (coordinates(q + h * qd) - coordinates(q - h * qd)) / (2 * h), atol=1e-7)
    rate = (task.jacobian(UR5E, q + h * qd) - task.jacobian(UR5E, q - h * qd)) / (2 * h)
    np.testing.assert_allclose(task.jacobian_rate(UR5E, q, qd), rate, atol=1e-6)


@pytest.mark.capability("10-58", "10-57")
def test_far_away_the_error_of_angles_still_obeys_its_equation():
    """X_e'' + Kd X_e' + Kp X_e = 0 with an error of a radian: by the second derivative of the angles themselves."""
    task, w = TaskCoordinates("ZYX"), 5.0
    goal = UR5E.forward_kinematics(Q) @ pose.exp([0.7, -0.5, 0.8, 0.1, 0.05, -0.1])
    law = task_computed_torque(UR5E, hold_pose(goal), coordinates=task, natural_frequency=w, damping_ratio=0.6)
    qd, h = np.array([0.3, -0.2, 0.4, 0.1, -0.5, 0.2]), 1e-4
    qdd = UR5E.forward_dynamics(Q, qd, law(0.0, Q, qd, Motion(Q, qd, qd)))

    def coordinates(q):
        P = UR5E.forward_kinematics(q)
        return np.concatenate([euler.to_euler(P[:3, :3], "ZYX"), P[:3, 3]])

    X = [coordinates(Q + s * h * qd + 0.5 * (s * h) ** 2 * qdd) for s in (-1, 0, 1)]
    wanted = np.concatenate([euler.to_euler(goal[:3, :3], "ZYX"), goal[:3, 3]])
    second = (X[2] - 2 * X[1] + X[0]) / h**2
    first = (X[2] - X[0]) / (2 * h)
    np.testing.assert_allclose(second, w**2 * (wanted - X[1]) - 1.2 * w * first, atol=1e-4)


@pytest.mark.capability("10-58")
def test_motions_of_a_tip_in_angles():
    goal = UR5E.forward_kinematics(Q) @ pose.exp([0.3, -0.2, 0.4, 0.1, 0.05, -0.1])
    path, h = line_path(UR5E.forward_kinematics(Q), goal), 1e-5
    motion = TipMotion(path, time_law("quintic").unit(), "ZYX")

    def coordinates(t):
        P = motion(t).pose
        return np.concatenate([euler.to_euler(P[:3, :3], "ZYX"), P[:3, 3]])

    target = motion(0.4)
    X = [coordinates(0.4 + s * h) for s in (-1, 0, 1)]
    np.testing.assert_allclose(target.velocity, (X[2] - X[0]) / (2 * h), atol=1e-7)
    np.testing.assert_allclose(target.acceleration, (X[2] - 2 * X[1] + X[0]) / h**2, atol=1e-4)
    task = TaskCoordinates("ZYX", rows=(0, 3))
    moved = task.integrate(target.pose, np.array([0.01, 0.02]))
    np.testing.assert_allclose(euler.to_euler(moved[:3, :3], "ZYX") - X[1][:3], [0.01, 0, 0], atol=1e-12)
    np.testing.assert_allclose(moved[:3, 3] - X[1][3:], [0.02, 0, 0], atol=1e-12)
    assert task.error(target.pose, TaskTarget(moved, np.zeros(6), np.zeros(6)), np.zeros(2))[0] == pytest.approx(
        [0.01, 0.02]
    )


@pytest.mark.capability("10-58")
def test_an_angle_goes_the_short_way_round_and_a_lock_is_said():
    turned = pose.exp([0, 0, 3.1, 0, 0, 0]), pose.exp([0, 0, -3.1, 0, 0, 0])
    X_e = TaskCoordinates("ZYX").error(turned[0], TaskTarget(turned[1], np.zeros(6), np.zeros(6)), np.zeros(6))[0]
    np.testing.assert_allclose(X_e, [2 * np.pi - 6.2, 0, 0, 0, 0, 0], atol=1e-12)
    up = pose.exp([0, np.pi / 2, 0, 0, 0, 0])
    with pytest.raises(InputError, match="ZYX"):
        TipMotion(line_path(up, up @ pose.exp([0, 0, 0, 0.1, 0, 0])), time_law("quintic").unit(), "ZYX")(0.5)
    with pytest.raises(InputError, match="XXZ"):
        TaskCoordinates("XXZ")
    at_lock = mf.inverse_kinematics(UR5E, pose.from_rotation_translation(up[:3, :3], [0.4, 0.2, 0.3])).q[0]
    with pytest.raises(InputError, match="ZYX"):
        task_dynamics(UR5E, at_lock, coordinates=TaskCoordinates("ZYX"))
