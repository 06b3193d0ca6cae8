"""Arms with an offset wrist: the polynomial of the last joint loses nothing and proves no wrong list."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.geometry import pose
from mafsil.ik import inverse_kinematics
from mafsil.ik.chain import chain_of
from mafsil.ik.general import GeneralSix
from mafsil.ik.general.findings import Findings
from mafsil.ik.general.offset_wrist import offset_wrist
from mafsil.ik.general.solver import _product
from mafsil.ik.result import IKStatus

X, Y, Z = np.eye(3)
ARMS = {
    # Axes and points [m] at q = 0, of published tables.
    "crx10ia": ([Z, Y, -Y, -X, -Y, -X], [0 * X, 0.245 * Z, 0.785 * Z, 0.785 * Z, (0.54, 0, 0.785), (0, -0.15, 0.785)]),
    "hc10": ([Z, Y, -Y, Z, -Y, Z], [0 * X, 0.275 * Z, 0.975 * Z, 0 * X, 0.475 * Z, 0.162 * Y]),
    "xarm6": ([Z, Y, Y, -Z, Y, -Z], [0 * X, 0.267 * Z, (0.0535, 0, 0.5515), 0.131 * X, (0.131, 0, 0.209), 0.207 * X]),
    "gofa5": ([Z, Y, Y, X, Y, X], [0 * X, 0.265 * Z, 0.709 * Z, 0.819 * Z, (0.47, 0, 0.819), 0.899 * Z]),
    "jaco2": ([-Z, -Y, Y, -Z, (0, -(0.75**0.5), -0.5), -Z],
              [0 * X, 0.2755 * Z, -0.1345 * Z, -0.0098 * Y, (0, -0.0098, 0.11561), 0.0643 * Y]),
}  # fmt: skip


def robot_from_axes(axes, points):
    w = np.array([np.asarray(axis) / np.linalg.norm(axis) for axis in axes])
    return mf.Robot.from_screws(np.concatenate([w, np.cross(np.array(points, dtype=float), w)], axis=1), np.eye(4))


def random_arm(rng):
    """Nothing but what makes an offset wrist: axes 2 and 3 parallel, axes 4 and 5 through one point."""
    axes, points = rng.normal(size=(6, 3)), rng.normal(size=(6, 3))
    axes[2], points[4] = axes[1] * rng.choice([-1, 1]), points[3]
    if rng.integers(2):
        axes, points = axes[::-1], points[::-1]
    return robot_from_axes(axes, points)


def arms():
    rng = np.random.default_rng(8)
    return {
        **{name: robot_from_axes(*arm) for name, arm in ARMS.items()},
        **{f"random {k}": random_arm(rng) for k in range(4)},
    }


CASES = arms()


def proven(machine, P):
    found = Findings(machine.frames, machine.prismatic, P)
    machine.offset.take(found)
    return found


def eliminated(machine, P):
    return machine._eliminate(Findings(machine.frames, machine.prismatic, P), machine.ranking[0])


def apart(q, others):
    d = q[:, None] - others[None]
    return np.abs((d + np.pi) % (2 * np.pi) - np.pi).max(axis=-1)


def machine_of(robot):
    return GeneralSix(chain_of(robot.mechanism))._machine


def on_folds(machine, rng, count):
    """Configurations at which two solutions are one: the Jacobian's determinant, bisected between two signs."""

    def determinant(q):
        return np.linalg.det(Findings(machine.frames, machine.prismatic, _product(machine.filled, q[:1]))._jacobians(q))

    a, b = rng.uniform(-np.pi, np.pi, (2, 5 * count, 6))
    start = determinant(a)
    change = start * determinant(b) < 0
    a, b, start = a[change][:count], b[change][:count], start[change][:count]
    for _ in range(55):
        middle = 0.5 * (a + b)
        before = (start * determinant(middle) > 0)[:, None]
        a, b = np.where(before, middle, a), np.where(before, b, middle)
    return a


@pytest.mark.parametrize("name", CASES)
@pytest.mark.capability("07-44", "07-2")
def test_lists_are_those_of_elimination(name):
    machine, rng = machine_of(CASES[name]), np.random.default_rng(1)
    q = rng.uniform(-np.pi, np.pi, (300, 6))
    P = _product(machine.filled, q)
    found, other = proven(machine, P), eliminated(machine, P)
    assert found.proof.mean() > 0.9
    both = found.proof & other.proof
    assert both.mean() > 0.9
    assert (found.count == other.count)[both].all()
    for i in np.flatnonzero(found.proof):
        own = found.q[i, : found.count[i]]
        assert apart(q[i : i + 1], own).min() < 1e-7
        assert (apart(other.q[i, : other.count[i]], own).min(axis=1) < 1e-6).all()
    assert np.nanmax(found.size) < 1e-12


@pytest.mark.parametrize("name", CASES)
@pytest.mark.capability("07-44")
def test_a_list_is_never_proven_without_the_solution_that_made_the_pose(name):
    """Beside folds, at any distance from them, and at angles that makers like: where rounding hides zeros."""
    machine, rng = machine_of(CASES[name]), np.random.default_rng(2)
    fold = on_folds(machine, rng, 60)
    steps = 10.0 ** rng.uniform(-13, -2, (len(fold), 1)) * rng.normal(size=fold.shape)
    grid = np.round(rng.uniform(-6, 6, (300, 6))) * np.pi / 6
    q = np.concatenate([fold, fold + steps, grid, grid + 1e-9 * rng.normal(size=grid.shape)])
    found = proven(machine, _product(machine.filled, q))
    assert found.proof.any()
    for i in np.flatnonzero(found.proof):
        assert found.count[i]
        assert apart(q[i : i + 1], found.q[i, : found.count[i]]).min() < 1e-4


@pytest.mark.parametrize("beside", [0.0, 1e-12, 1e-9, 1e-6, 1e-3])
@pytest.mark.parametrize("name", ["crx10ia", "hc10"])
@pytest.mark.capability("07-44")
def test_a_wrist_on_the_first_axis_loses_nothing(name, beside):
    """There the polynomial has a zero that belongs to no solution, and those of solutions are close to it."""
    robot = CASES[name]
    machine = machine_of(robot)
    q = np.random.default_rng(3).uniform(-np.pi, np.pi, (200, 6))
    for _ in range(60):
        w = wrist_points(robot, q)
        q[:, 1] -= 0.3 * np.hypot(w[:, 0], w[:, 1]) * np.sign(slope(robot, q))
    q = q[np.hypot(*wrist_points(robot, q)[:, :2].T) < 1e-9] + beside * np.eye(6)[1]
    assert len(q) > 20
    P = _product(machine.filled, q)
    found, other = proven(machine, P), eliminated(machine, P)
    for i in np.flatnonzero(found.proof):
        own = found.q[i, : found.count[i]]
        assert apart(q[i : i + 1], own).min() < 1e-6
        assert (apart(other.q[i, : other.count[i]], own).min(axis=1) < 1e-4).all()


def wrist_points(robot, q):
    chain = chain_of(robot.mechanism)
    P = _product(chain, np.where(np.arange(6) < 3, q, 0.0))
    at = chain.points[4] + chain.axes[4] * ((chain.points[3] - chain.points[4]) @ chain.axes[4])
    return P[:, :3, :3] @ at + P[:, :3, 3]


def slope(robot, q):
    step = q + 1e-6 * np.eye(6)[1]
    return np.hypot(*wrist_points(robot, step)[:, :2].T) - np.hypot(*wrist_points(robot, q)[:, :2].T)


@pytest.mark.parametrize("name", ["crx10ia", "xarm6", "jaco2"])
@pytest.mark.capability("07-44", "07-1")
def test_one_pose_and_many_give_the_same_answer(name):
    robot, rng = CASES[name], np.random.default_rng(4)
    q = rng.uniform(-np.pi, np.pi, (50, 6))
    T, q0 = robot.forward_kinematics(q), rng.uniform(-3, 3, 6)
    many = inverse_kinematics(robot, T, q0=q0)
    for i in range(len(q)):
        one = inverse_kinematics(robot, T[i], q0=q0)
        assert one.complete
        assert one.status == many[i].status
        assert len(one) == many.valid[i].sum()
        np.testing.assert_allclose(np.sort(one.q[:, 0]), np.sort(many.q[i][many.valid[i]][:, 0]), atol=1e-9)
        np.testing.assert_allclose(robot.forward_kinematics(one.q), np.broadcast_to(T[i], (len(one), 4, 4)), atol=1e-12)
        assert np.abs(one.q - q0).max() <= np.pi + 1e-12


@pytest.mark.parametrize("name", ["crx10ia", "xarm6", "jaco2"])
@pytest.mark.capability("07-44", "07-1")
def test_out_of_reach_is_proven_and_said(name):
    robot = CASES[name]
    T = robot.forward_kinematics(np.random.default_rng(6).uniform(-np.pi, np.pi, (20, 6)))
    T[:, :3, 3] += 9.0
    many = inverse_kinematics(robot, T)
    for i in range(len(T)):
        one = inverse_kinematics(robot, T[i])
        assert not one
        assert len(one) == 0
        assert one.complete
        assert one.status is many[i].status is IKStatus.OUT_OF_REACH
        assert one.explain() == many[i].explain()


def test_a_pose_that_is_rounded_is_not_taken_as_it_is():
    robot = CASES["crx10ia"]
    T = robot.forward_kinematics(np.array([0.3, -0.4, 0.6, 1.0, 0.8, -0.5]))
    rounded = np.round(T, 9)
    lists = machine_of(robot).offset.solve_poses(np.stack([T, rounded, np.full((4, 4), np.nan), 2 * T]))
    assert lists.counts[0] > 0
    assert (lists.counts[1:] == -1).all()
    answer = inverse_kinematics(robot, rounded)
    assert len(answer) == lists.counts[0]
    assert answer.residual.max() < 1e-8


def test_the_family_is_read_from_the_axes():
    """Exact ones only: an arm that misses it by a ten-thousandth is another arm."""
    rng = np.random.default_rng(5)
    assert all(machine_of(robot).offset is not None for robot in CASES.values())
    axes, points = rng.normal(size=(6, 3)), rng.normal(size=(6, 3))
    for e, meets in ((0.0, True), (1e-4, False)):
        axes[2], points[4] = axes[1] + e * axes[0], points[3]
        assert (machine_of(robot_from_axes(axes, points)).offset is not None) == meets
    loop = chain_of(mf.load("ur5e").mechanism)
    assert offset_wrist(loop, (np.eye(4), np.zeros(3), 1.0)) is None
    tilted = pose.exp([0.3, -0.2, 0.5, 1.0, 2.0, 3.0])
    moved = CASES["crx10ia"].with_base(tilted) if hasattr(mf.Robot, "with_base") else CASES["crx10ia"]
    assert machine_of(moved).offset is not None
