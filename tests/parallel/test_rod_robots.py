"""Parallel robots as built, by one class of legs: there and back, rates, forces, singular places, indices."""

from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil import InputError, parallel
from mafsil.errors import FileError
from mafsil.geometry import pose, rotation
from mafsil.model import JointKind
from mafsil.parallel.legs import (
    LegDrive,
    PlatformMotion,
    RodDynamics,
    RodLimits,
    RodMasses,
    RodRobot,
    as_rod_robot,
    five_bar_on_rods,
    planar_on_rods,
    rod_indices,
    rod_workspace,
    rotary_delta,
)
from mafsil.parallel.legs.leg_library import mechanism_of_parallel, rod_legs
from mafsil.parallel.legs.leg_statics import reduced_equations
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


LOADED = [name for name in ROBOTS if name not in ("pair of SCARAs", "3-RRR", "H4")]


@pytest.mark.capability("08-2")
@pytest.mark.parametrize("name", LOADED)
def test_robots_on_rods_as_joints_and_loops(name):
    robot, _ = ROBOTS[name]
    legs = rod_legs(robot)
    T = legs.legs[0].home
    A, B = reduced_equations(legs, np.zeros(legs.n))
    V = np.linalg.lstsq(A, B, rcond=None)[0]
    q = np.zeros(robot.m) if robot.drive is not LegDrive.EXTEND else robot.branch(T)
    columns = robot.motion.columns if robot.motion is not PlatformMotion.PLANE_POINT else slice(0)
    np.testing.assert_allclose(V[columns], robot.jacobian(T, q)[: len(V[columns])], atol=1e-9)
    if robot.motion is PlatformMotion.PLANE_POINT:
        velocity = np.cross(V[:3].T, T[:3, 3]) + V[3:].T
        np.testing.assert_allclose(velocity[:, :2].T, robot.jacobian(T, q), atol=1e-9)
    assert len(mechanism_of_parallel(robot, name).loops) == len(legs.legs) - 1


def test_what_rods_do_not_hold_alone_is_refused():
    for name in ("pair of SCARAs", "H4"):
        with pytest.raises(InputError, match="keep it parallel"):
            rod_legs(ROBOTS[name][0])


@pytest.mark.capability("08-2")
def test_files_of_parallel_robots_load_as_robots():
    folder = Path(__file__).parents[2] / "examples" / "parallel"
    for name, motors in {"delta": 3, "linear_delta": 3, "hexapod": 6, "planar_3rpr": 3, "agile_eye": 3}.items():
        robot = mf.load(folder / f"{name}.toml")
        every_joint = [*robot.mechanism.joints, *robot.mechanism.loops]
        assert sum(each.actuated and each.kind is not JointKind.FIXED for each in every_joint) == motors
        assert mf.mobility(robot.mechanism).mobility == motors
    with pytest.raises(FileError, match="hangs in cables"):
        mf.load(folder / "crane.toml")


def with_masses(robot, gravity=(0.0, 0.0, -9.81)):
    """A robot whose every part has a mass."""
    I = np.array([[2e-3, 1e-4, 0], [1e-4, 3e-3, 2e-4], [0, 2e-4, 4e-3]])
    masses = RodMasses(
        1.3, 0.2 + 0.05 * np.arange(robot.m), com=[0.01, -0.02, 0.0 if robot.is_flat else 0.03], inertia=I, arms=0.4,
        motors=0.02, sleeves=0.2,
    )  # fmt: skip
    return RodDynamics(robot, masses, gravity)


def second_order(robot, x, V, Vd, t):
    """Pose and its motion after a time, of a constant Vd, to the third power of it."""
    W = [np.zeros(6) for _ in range(2)]
    for each, value in zip(W, (V, Vd), strict=True):
        each[robot.motion.columns] = value
    # T(t) = exp(V t + Vd t^2 / 2) T: its space twist is V + Vd t up to t^2 [V, Vd] / 12 and beyond.
    return pose.exp(W[0] * t + W[1] * t**2 / 2) @ robot.poses(x)


@every
@pytest.mark.capability("08-44")
def test_power_of_the_motors_is_the_rate_of_energy(name):
    robot, x = ROBOTS[name]
    rng = np.random.default_rng(4)
    dynamics = with_masses(robot, [1.0, -9.0, -3.0])
    V, Vd = 0.3 * rng.normal(size=robot.m), rng.normal(size=robot.m)
    q = chosen(robot, x)
    tau = dynamics.inverse_dynamics(x, q, V, Vd)
    rates, _ = dynamics.motor_accelerations(x, q, V, Vd)
    step = 1e-5
    energy = []
    for t in (-step, step):
        T = second_order(robot, x, V, Vd, t)
        energy.append(sum(dynamics.energy(T, chosen(robot, T), V + Vd * t)))
    assert tau @ rates == pytest.approx((energy[1] - energy[0]) / (2 * step), rel=1e-6, abs=1e-7)


@every
def test_forward_dynamics_is_the_inverse(name):
    robot, x = ROBOTS[name]
    rng, dynamics = np.random.default_rng(5), with_masses(robot)
    T = displaced(robot, x, 0.01 * rng.normal(size=(4, robot.m)))
    q = chosen(robot, T)
    V, Vd, F = (rng.normal(size=(4, robot.m)) for _ in range(3))
    tau = dynamics.inverse_dynamics(T, q, V, Vd, F)
    np.testing.assert_allclose(dynamics.forward_dynamics(T, q, V, tau, F), Vd, rtol=1e-8, atol=1e-8)
    one = dynamics.inverse_dynamics(T[2], q[2], V[2], Vd[2], F[2])
    np.testing.assert_allclose(one, tau[2], rtol=1e-12)
    at_rest = dynamics.inverse_dynamics(T, q, 0 * V, 0 * Vd) - dynamics.inverse_dynamics(T, q, 0 * V, 0 * Vd, F)
    np.testing.assert_allclose(-at_rest, robot.efforts(T, q, F), rtol=1e-9, atol=1e-9)


@pytest.mark.parametrize("name", ["unequal Delta", "PUS hexapod", "UPS hexapod", "3-PRR"])
def test_accelerations_of_motors(name):
    robot, x = ROBOTS[name]
    rng, step = np.random.default_rng(6), 1e-4
    V, Vd = 0.3 * rng.normal(size=robot.m), rng.normal(size=robot.m)
    q = [chosen(robot, second_order(robot, x, V, Vd, t)) for t in (-step, 0.0, step)]
    qd, qdd = with_masses(robot).motor_accelerations(x, q[1], V, Vd)
    np.testing.assert_allclose(qd, (q[2] - q[0]) / (2 * step), atol=1e-6)
    np.testing.assert_allclose(qdd, (q[2] - 2 * q[1] + q[0]) / step**2, atol=2e-4)


@pytest.mark.capability("08-44")
@pytest.mark.parametrize("name", ["Delta", "five-bar", "UPS hexapod"])
def test_energy_of_a_robot_that_nothing_drives_stays(name):
    robot, x = ROBOTS[name]
    dynamics, step = with_masses(robot, [1.0, -9.0, -3.0]), 2e-3
    T, V, second = robot.poses(x), np.zeros(robot.m), np.zeros(robot.m, dtype=bool)

    def energy(T, V):
        return sum(dynamics.energy(T, robot.branch(T, second), V))

    def slope(T, V):
        return dynamics.forward_dynamics(T, robot.branch(T, second), V, np.zeros(robot.m))

    def moved(T, V, t):
        return displaced(robot, T, V * t)

    first = energy(T, V)
    for _ in range(20):  # Runge and Kutta's method, twists as if they were constant within a stage
        a = slope(T, V)
        b = slope(moved(T, V, step / 2), V + a * step / 2)
        c = slope(moved(T, V + a * step / 2, step / 2), V + b * step / 2)
        d = slope(moved(T, V + b * step / 2, step), V + c * step)
        T, V = moved(T, V + (a + b + c) * step / 6, step), V + (a + 2 * b + 2 * c + d) * step / 6
    kinetic = float(dynamics.energy(T, robot.branch(T, second), V)[0])
    assert kinetic > 1e-3
    assert abs(energy(T, V) - first) < 1e-5 * kinetic + 1e-9
