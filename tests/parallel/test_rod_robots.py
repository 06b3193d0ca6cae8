"""Parallel robots as built, by one class of legs: there and back, rates, forces, singular places, indices."""

import numpy as np
import pytest

from mafsil import InputError, parallel
from mafsil.geometry import pose, rotation
from mafsil.parallel.legs import (
    LegDrive,
    PlatformMotion,
    RodLimits,
    RodRobot,
    as_rod_robot,
    five_bar_on_rods,
    planar_on_rods,
    rod_indices,
    rod_workspace,
    rotary_delta,
)
from tests.parallel.rod_robots import ROBOTS, THIRDS, ring

every = pytest.mark.parametrize("name", ROBOTS)


def chosen(robot, x):
    """Motors of one branch, for batches too."""
    found = robot.inverse_kinematics(x)
    assert (found.misfit == 0).all()
    return found.q[..., 0]


def displaced(robot, x, V):
    """Poses after a motion V of the platform in {s}."""
    twist = np.zeros((*np.shape(V)[:-1], 6))
    twist[..., robot.motion.columns] = V
    return pose.exp(twist) @ robot.poses(x)


@every
def test_there_and_back(name):
    robot, x = ROBOTS[name]
    rng = np.random.default_rng(2)
    T = displaced(robot, x, 0.02 * rng.normal(size=(5, robot.m)))
    found = robot.inverse_kinematics(T)
    assert found.q.shape == (5, robot.m, 2)
    for branch in (0, 1):
        q = found.q[..., branch]
        miss = np.linalg.norm(robot.ends(T) - robot.carriers(q), axis=-1) - robot.lengths(q)
        assert np.abs(miss).max() < 1e-12
    near = robot.forward_near(found.q[..., 0], x)
    assert near
    np.testing.assert_allclose(near.T[:, 0], T, atol=1e-9)
    modes = robot.forward_kinematics(found.q[:2, :, 0])
    assert modes
    assert modes.complete == (name != "H4")
    for k in range(2):
        assert np.abs(modes.T[k, : modes.count[k]] - T[k]).max(axis=(1, 2)).min() < 1e-8


@every
def test_rates_and_forces(name):
    robot, x = ROBOTS[name]
    q, step = chosen(robot, x), 1e-6
    J = robot.jacobian(x, q)
    V = np.eye(robot.m)
    slope = (chosen(robot, displaced(robot, x, step * V)) - chosen(robot, displaced(robot, x, -step * V))) / (2 * step)
    np.testing.assert_allclose(np.linalg.inv(J), slope.T, rtol=1e-5, atol=1e-6)
    F = np.random.default_rng(3).normal(size=robot.m)
    np.testing.assert_allclose(robot.efforts(x, q, F), J.T @ F)
    assert robot.singularity(x, q)
    assert robot.jacobian(np.stack([robot.poses(x)] * 3), np.stack([q] * 3)).shape == (3, robot.m, robot.m)


def test_agrees_with_the_classes_of_one_robot():
    old, new = parallel.DeltaRobot(0.2, 0.05, 0.3, 0.8), rotary_delta(0.2, 0.05, 0.3, 0.8)
    p = np.array([[0.1, -0.05, -0.7], [0.0, 0.1, -0.6]])
    one, two = np.sort(old.inverse_kinematics(p).q), np.sort(new.inverse_kinematics(p).q)
    np.testing.assert_allclose(one, two, atol=1e-12)
    np.testing.assert_allclose(old.forward_kinematics(one[..., 0]).x, new.forward_kinematics(one[..., 0]).x, atol=1e-12)
    np.testing.assert_allclose(old.jacobian(one[..., 0], p), new.jacobian(p, one[..., 0]), atol=1e-12)
    hexapod, T = ROBOTS["UPS hexapod"]
    stewart = parallel.StewartPlatform(hexapod.base, hexapod.rotating)
    np.testing.assert_allclose(hexapod.jacobian(T, stewart.lengths(T)), np.linalg.inv(stewart.jacobian(T)), atol=1e-9)
    rrr, x = ROBOTS["3-RRR"]
    legs = parallel.PlanarThreeRRR(rrr.base[:, :2], rrr.rotating[:, :2], rrr.arms, rrr.rods)
    q = chosen(rrr, x)
    np.testing.assert_allclose(legs.jacobian(x, q), rrr.jacobian(x, q), atol=1e-12)


def test_out_of_reach_and_singular():
    robot, _ = ROBOTS["linear Delta"]
    far = robot.inverse_kinematics([[0.0, 0.0, 0.1], [0.5, 0.0, 0.1]])
    assert far.reached.tolist() == [True, False]
    assert not robot.forward_kinematics([0.0, 0.0, 9.0])
    flat = rotary_delta(0.2, 0.05, 0.3, 0.8)
    q = np.full(3, 0.5)
    C = flat.carriers(q) - flat.fixed
    level = np.sqrt(0.8**2 - np.linalg.norm(C[0, :2]) ** 2)
    assert level > 0
    bar = five_bar_on_rods([[0, 0], [2, 0]], 1.0, 1.0)
    assert bar.singularity([1.0, 1.0], [np.pi / 2, np.pi / 2]).status is parallel.SingularKind.SECOND
    with pytest.raises(InputError, match="rod"):
        bar.jacobian([1.0, 1.2], [np.pi / 2, np.pi / 2])
    with pytest.raises(InputError, match="arms"):
        planar_on_rods(ring(1, THIRDS), ring(0.1, THIRDS), 1.0)
    with pytest.raises(InputError):
        RodRobot(PlatformMotion.POINT, LegDrive.LINEAR, ring(1, THIRDS), [1.0, -1.0, 1.0], np.zeros(3), np.zeros(3))


@every
def test_indices(name):
    robot, x = ROBOTS[name]
    q, step = chosen(robot, x), 1e-6
    found = rod_indices(robot, x, motor_stiffness=1e4, rod_stiffness=1e6, motor_error=1e-4, rod_error=2e-5)
    assert found
    assert found.condition >= 1.0
    # Stiffness is the inverse of what the platform gives way when motors and rods do, loaded by forces at its point.
    J = found.jacobian
    A = np.linalg.inv(J) * np.diag(robot.motor_matrices(x, q)[1])[:, None]
    gives = J @ J.T / 1e4 + np.linalg.inv(A) @ np.linalg.inv(A).T / 1e6
    np.testing.assert_allclose(found.stiffness @ gives, np.eye(robot.m), atol=1e-7)
    rng = np.random.default_rng(4)
    moved = robot.forward_near(q + 1e-4 * np.sign(rng.normal(size=(50, robot.m))), x).T[:, 0]
    p = robot.poses(x)[:3, 3]
    gone = np.abs(moved[:, :3, 3] - p).max(axis=0)[: robot.m - robot.motion.angles]
    assert (gone <= found.worst_error[robot.motion.angles :] * 1.01).all()
    assert (found.deviation <= found.worst_error + 1e-15).all()
    # Output transmission against the motion of the rod's end while one motor moves.
    for k in range(robot.m):
        q_ = q + step * np.eye(robot.m)[k]
        T = robot.forward_near(q_, x).T[0]
        moves = (robot.ends(T) - robot.ends(x))[k]
        u = (robot.ends(x) - robot.carriers(q))[k] / robot.lengths(q)[k]
        sine = abs(moves @ u) / np.linalg.norm(moves)
        assert np.sin(found.transmission[k, 1]) == pytest.approx(sine, abs=1e-4)


def test_a_singular_configuration_has_no_stiffness():
    bar = five_bar_on_rods([[0, 0], [2, 0]], 1.0, 1.0)
    found = rod_indices(bar, [1.0, 1.0], [np.pi / 2, np.pi / 2], motor_stiffness=1.0, motor_error=1e-3)
    assert not found
    assert found.dexterity == 0.0
    assert np.isinf(found.worst_error).all()
    assert found.transmission[:, 1].max() == 0.0


def test_workspace_of_a_five_bar_is_where_two_rings_meet():
    bar = five_bar_on_rods([[-0.2, 0], [0.2, 0]], 0.5, 0.3)
    found = rod_workspace(bar, [-1, -1], [1, 1], cells=160)
    x, y = np.meshgrid(found.axes[0], found.axes[1], indexing="ij")
    far = np.stack([np.hypot(x + 0.2, y), np.hypot(x - 0.2, y)])
    inside = ((far >= 0.2) & (far <= 0.8)).all(axis=0)
    assert (found.everywhere[..., 0] == inside).all()
    count, area = found.voids(found.everywhere)
    assert count == 1
    apart = np.pi * 0.2**2
    assert area == pytest.approx(2 * apart, rel=0.03)
    held = rod_workspace(bar, [-1, -1], [1, 1], cells=60, limits=RodLimits(least_transmission=0.5, largest_condition=4))
    assert held.volume(held.everywhere)[0] < 0.7 * found.volume(found.everywhere)[0]
    assert held.reasons["transmission"] > 0
    names = ["Delta", "linear Delta", "RUS hexapod"]
    for name in names:
        robot, pose_ = ROBOTS[name]
        p = robot.poses(pose_)[:3, 3]
        box = rod_workspace(robot, p - 0.05, p + 0.05, cells=5, limits=RodLimits(lower=-9.0, upper=9.0))
        assert box.everywhere[2, 2, 2]


def test_robots_of_other_classes_become_robots_on_rods():
    bar = parallel.FiveBar(0.3, 0.45, 0.4, 0.35, 0.3)
    q = bar.inverse_kinematics([0.15, 0.5]).q[:, 0]
    rods = as_rod_robot(bar)
    np.testing.assert_allclose(rods.jacobian([0.15, 0.5], q), bar.jacobian(q, [0.15, 0.5]), atol=1e-12)
    rpr = parallel.PlanarThreeRPR(ring(0.5, THIRDS)[:, :2], ring(0.1, THIRDS)[:, :2])
    x = [0.03, 0.05, 0.2]
    A = as_rod_robot(rpr).motor_matrices(x, rpr.lengths(x))[0]
    np.testing.assert_allclose(A, rpr.jacobian(x), atol=1e-12)
    for robot in (parallel.DeltaRobot(0.2, 0.05, 0.3, 0.8), ROBOTS["Delta"][0]):
        assert rod_indices(as_rod_robot(robot), [0.0, 0.0, -0.7])


def test_the_agile_eye():
    eye = parallel.SphericalPlatform.agile_eye()
    np.testing.assert_allclose(np.abs(np.linalg.svd(eye.jacobian(np.eye(3), np.zeros(3)))[1]), 1.0)
    rng = np.random.default_rng(1)
    q = rng.uniform(-1.0, 1.0, (6, 3))
    found = eye.forward_kinematics(q)
    assert found.complete
    assert (found.count == 8).all()
    angles = eye.inverse_kinematics(found.x)
    # Four of the eight are the trivial ones, whose motors may stand anywhere.
    assert angles.free.all(axis=-1).sum(axis=-1).tolist() == [4] * 6
    off = np.abs(np.angle(np.exp(1j * (angles.q - q[:, None, :, None])))).min(axis=-1)
    assert off[~angles.free].max() < 1e-7
    general = parallel.SphericalPlatform(
        ring(1.0, THIRDS, 0.8), ring(-1.0, THIRDS, 1.0), ring(1.0, THIRDS, -0.4), 0.9, 1.2
    )
    R = rotation.exp([0.1, -0.1, 0.2])
    both = general.inverse_kinematics(R)
    assert both
    q, step = both.q[:, 0], 1e-6
    J = general.jacobian(R, q)
    slope = [
        (general.inverse_kinematics(rotation.exp(step * w) @ R).q[:, 0] - q) / step for w in np.eye(3)
    ]  # fmt: skip
    np.testing.assert_allclose(np.linalg.inv(J), np.array(slope).T, atol=1e-4)
    np.testing.assert_allclose(general.torques(R, q, [1.0, 2.0, 3.0]), J.T @ [1.0, 2.0, 3.0])
    assert general.singularity(R, q)
    modes = general.forward_kinematics(q)
    assert np.abs(modes.x - R).max(axis=(1, 2)).min() < 1e-8
    with pytest.raises(InputError, match="second link"):
        general.jacobian(R, q + 0.1)
    away = parallel.SphericalPlatform(ring(1.0, THIRDS, 0.8), ring(-1, THIRDS, 1), ring(1, THIRDS, -0.4), 0.1, 0.2)
    assert not away.inverse_kinematics(R)
