"""Batches of arms with held joints, planar arms and partial tasks: pose by pose what the single call says."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.geometry import pose
from mafsil.ik.result import IKStatus

x, y, z = np.eye(3)


def arm(axes, points, tip, slides=()):
    """Axes w through points r; those in `slides` slide along w."""
    rows = [
        np.concatenate([np.zeros(3), w]) if k in slides else np.concatenate([w, np.cross(r, w)])
        for k, (w, r) in enumerate(zip(axes, points, strict=True))
    ]
    home = np.eye(4)
    home[:3, 3] = np.asarray(points[-1]) + np.asarray(tip)
    return mf.Robot.from_screws(np.array(rows), home)


def on_a_rail():
    """Eight coordinates: a rail, then three axes that meet, an elbow and three that meet."""
    points = [0 * x] * 4 + [0.4 * z] + [0.8 * z] * 3
    return arm([x, z, y, z, -y, z, y, z], points, (0.0, 0.0, 0.1), slides=(0,))


ARMS = {
    "panda": lambda: (mf.load("panda"), "pose"),
    "iiwa7": lambda: (mf.load("iiwa7"), "pose"),
    "fr3": lambda: (mf.load("fr3"), "pose"),
    "eight joints": lambda: (on_a_rail(), "pose"),
    "scara, position": lambda: (mf.load("scara_rrrp"), "position"),
    "six joints, position": lambda: (mf.load("ur5e"), "position"),
    "planar two": lambda: (arm([z] * 2, [0 * x, 0.5 * x], (0.4, 0.0, 0.0)), "position"),
    "planar three": lambda: (arm([z] * 3, [0 * x, 0.5 * x, x], (0.3, 0.0, 0.0)), "pose"),
    "scara": lambda: (mf.load("scara_rrrp"), "pose"),
    "three, position": lambda: (arm([z, y, y], [0 * z, 0.3 * z, 0.7 * z], (0.0, 0.0, 0.4)), "position"),
    "planar three, position": lambda: (arm([z] * 3, [0 * x, 0.5 * x, x], (0.3, 0.0, 0.0)), "position"),
    "planar four": lambda: (arm([z] * 4, [0 * x, 0.5 * x, x, 1.3 * x], (0.2, 0.0, 0.0)), "pose"),
    "seven joints, position": lambda: (mf.load("panda"), "position"),
    "six joints, axis": lambda: (mf.load("ur5e"), "axis"),
    "seven joints, axis": lambda: (mf.load("panda"), "axis"),
    "five, axis": lambda: (arm([z, y, y, y, x], [0 * z, 0.3 * z, 0.7 * z, z, z], (0.15, 0.0, 0.0)), "axis"),
}


def configurations(robot, count, seed):
    low, high = np.maximum(robot.limits.lower, -2.8), np.minimum(robot.limits.upper, 2.8)
    return np.random.default_rng(seed).uniform(low, high, (count, robot.n))


def with_lower_limits(robot, lower):
    """The same arm with other lower limits."""
    bounds = iter(lower)
    joints = [
        replace(joint, limits=replace(joint.limits, lower=float(next(bounds)))) if joint.moves else joint
        for joint in robot.mechanism.joints
    ]
    return mf.Robot(replace(robot.mechanism, joints=tuple(joints)))


def rows_of(batch, i):
    """Solutions of a pose of a batch, in the order of their coordinates."""
    rows = np.concatenate([batch.q[i], batch.within[i][:, None], batch.codes[i][:, None]], axis=1)[batch.valid[i]]
    return rows[np.lexsort(np.round(rows, 6).T)]


def rows_of_one(answer):
    rows = np.concatenate([answer.q, answer.within[:, None], answer.codes[:, None]], axis=1)
    return rows[np.lexsort(np.round(rows, 6).T)]


def agree(robot, task, T, tolerance=1e-9, q0=None):
    """Every pose of a batch as the single call answers it."""
    many = mf.inverse_kinematics(robot, T, task=task, tolerance=tolerance, q0=q0)
    for i, one in enumerate(T):
        answer = mf.inverse_kinematics(robot, one, task=task, tolerance=tolerance, q0=q0)
        assert many.status[i] is answer.status, (i, many.status[i], answer.status)
        expected, found = rows_of_one(answer), rows_of(many, i)
        assert expected.shape == found.shape, i
        assert np.abs(expected - found).max(initial=0.0) < 1e-9, i
        again = many[i]
        assert again.status is answer.status
        assert np.abs(rows_of_one(again) - expected).max(initial=0.0) < 1e-7
    return many


@pytest.mark.capability("07-4", "07-45")
@pytest.mark.parametrize("name", ARMS)
def test_a_batch_says_what_the_single_calls_say(name):
    robot, task = ARMS[name]()
    q = configurations(robot, 40, 1)
    many = agree(robot, task, robot.forward_kinematics(q))
    assert many.solved.all()
    assert many.residual[many.valid].max() < 1e-9
    missed = (
        robot.forward_kinematics(many.q[many.valid])[:, :3, 3]
        - robot.forward_kinematics(q)[np.nonzero(many.valid)[0], :3, 3]
    )
    assert np.abs(missed).max() < 1e-9
    inside = robot.limits.within(many.q)
    assert (many.within == (many.valid & inside.all(axis=-1))).all()


@pytest.mark.capability("07-4", "07-45")
@pytest.mark.parametrize("name", ARMS)
def test_singular_unreachable_and_no_poses_of_a_batch(name):
    robot, task = ARMS[name]()
    q = configurations(robot, 6, 2)
    q[:2] = np.where(np.isfinite(robot.limits.lower), np.clip(0.0, robot.limits.lower, robot.limits.upper), 0.0)
    q[1:4, robot.n - 2] = np.clip(0.0, robot.limits.lower[-2], robot.limits.upper[-2])
    T = robot.forward_kinematics(q)
    far = T[4:].copy()
    far[:, :3, 3] += [0.0, 30.0, 0.0] if name != "eight joints" else [0.0, 0.0, 30.0]
    agree(robot, task, np.concatenate([T, far]))
    bad = np.stack([T[5], np.full((4, 4), np.nan), np.diag([1.0, 1.0, -1.0, 1.0]), T[4]])
    many = mf.inverse_kinematics(robot, bad, task=task)
    assert list(many.status[[1, 2]]) == [IKStatus.NOT_A_POSE] * 2
    assert many.solved[[0, 3]].all()
    assert not many.valid[[1, 2]].any()
    for wrong in bad[1:3]:
        with pytest.raises(mf.InputError):
            mf.inverse_kinematics(robot, wrong, task=task)


@pytest.mark.capability("07-4", "07-45")
@pytest.mark.parametrize("name", ["panda", "iiwa7"])
def test_preferred_values_inside_and_outside_the_limits(name):
    robot = mf.load(name)
    T = robot.forward_kinematics(configurations(robot, 12, 3))
    for preferred in (0.3, float(robot.limits.upper[6]), 4.0):
        near = (robot.limits.lower + robot.limits.upper) / 2
        near[6] = preferred
        many = agree(robot, "pose", T, q0=near)
        assert many.solved.all()
    # The preferred value itself wherever it leads to a solution within the limits.
    near[6] = 0.3
    many = mf.inverse_kinematics(robot, T, q0=near)
    kept = [np.abs(many.q[i, many.within[i], 6] - 0.3).max() < 1e-12 for i in range(len(T))]
    found = mf.ik.redundancy(robot, robot.joint_names[6]).solve(T, np.array([0.3])).within.any(axis=(1, 2))
    assert (np.array(kept) == found).all()
    assert found.any()


def seven_axes(span):
    """Seven axes anywhere, each turning as far from zero as `span`: six are found by elimination."""
    rng = np.random.default_rng(6)
    w, r = rng.normal(size=(2, 7, 3))
    w /= np.linalg.norm(w, axis=1, keepdims=True)
    home = pose.exp(rng.normal(size=6))
    robot = mf.Robot.from_screws(np.concatenate([w, np.cross(r, w)], axis=1), home)
    joints = [
        replace(joint, limits=replace(joint.limits, lower=-span, upper=span)) if joint.moves else joint
        for joint in robot.mechanism.joints
    ]
    return mf.Robot(replace(robot.mechanism, joints=tuple(joints)))


@pytest.mark.capability("07-45", "07-4")
def test_a_batch_of_an_arm_of_no_shape_says_what_the_single_calls_say():
    robot = seven_axes(1.0)
    rng = np.random.default_rng(7)
    T = robot.forward_kinematics(np.concatenate([rng.uniform(-1, 1, (5, 7)), rng.uniform(1.5, 3.0, (2, 7))]))
    far = T[:2].copy()
    far[:, :3, 3] *= 30.0
    T = np.concatenate([T, far])
    many = agree(robot, "pose", T)
    assert many.solved[:5].all()
    assert list(many.status[7:]) == [IKStatus.OUT_OF_REACH] * 2
    assert np.abs(robot.forward_kinematics(many.q[many.valid]) - T[np.nonzero(many.valid)[0]]).max() < 1e-8


@pytest.mark.capability("07-45", "07-4")
def test_planar_arms_with_a_joint_more_than_the_task_needs_have_a_closed_form():
    for count, task, held in ((3, "position", 1), (4, "position", 2), (4, "pose", 1)):
        robot = arm([z] * count, [0.5 * k * x for k in range(count)], (0.4, 0.0, 0.0))
        q = configurations(robot, 1, 8)[0]
        answer = mf.inverse_kinematics(robot, robot.forward_kinematics(q), task=task, q0=q)
        assert answer.method == "closed form"
        assert answer.status is IKStatus.CONTINUUM
        assert len(answer.q) == 2
        assert np.abs(answer.q - q).max(axis=1).min() < 1e-9
        assert len({family.joint for family in answer.families}) == held


@pytest.mark.capability("07-4")
@pytest.mark.parametrize("free", [None, 0.3])
def test_an_answer_keeps_its_pose_and_its_tolerance(free):
    robot = mf.load("panda")
    q = np.array([0.1, 0.4, 0.2, -1.5, 0.3, 1.2, 0.3])
    T = robot.forward_kinematics(q)
    kept = T.copy()
    answer = mf.inverse_kinematics(robot, T, free=free)
    T[:3, 3] += 1.0
    assert np.abs(robot.forward_kinematics(answer.families[0].at(0.4)) - kept).max() < 1e-9
    strict = mf.inverse_kinematics(robot, kept, free=free, tolerance=1e-14)
    assert (strict.residual <= 1e-14).all()
    if free is None:
        agree(robot, "pose", np.repeat(kept[None], 2, axis=0), tolerance=1e-14)


@pytest.mark.capability("07-4", "07-3")
def test_what_a_planar_arm_cannot_do_is_said_alike():
    robot = arm([z] * 4, [0 * x, x, 1.8 * x, 2.3 * x], (0.3, 0.0, 0.0))
    T = np.repeat(np.eye(4)[None], 3, axis=0)
    T[:, 0, 3] = [2.59, 5.0, 1.0]
    T[0, :3, :3] = T[0, :3, :3] @ np.diag([-1.0, -1.0, 1.0])
    T[2, 2, 3] = 0.1
    many = agree(robot, "pose", T)
    assert list(many.status) == [IKStatus.NOT_OF_THIS_ARM, IKStatus.OUT_OF_REACH, IKStatus.NOT_OF_THIS_ARM]


@pytest.mark.capability("07-4", "07-3")
def test_beyond_the_limits_is_proven_pose_by_pose():
    whole = mf.load("fr3")
    lower = whole.limits.lower.copy()
    lower[3] = -0.6
    robot = with_lower_limits(whole, lower)
    q = configurations(whole, 3, 4)
    q[:, 3] = [-0.3, -1.5, -2.0]
    T = whole.forward_kinematics(q)
    many = agree(robot, "pose", T)
    assert set(many.status) <= {IKStatus.BEYOND_LIMITS, IKStatus.CONTINUUM}
    assert IKStatus.BEYOND_LIMITS in set(many.status)
    proven = many.status_codes == list(IKStatus).index(IKStatus.BEYOND_LIMITS)
    assert many.valid[proven].any()
    assert not many.within[proven].any()


@pytest.mark.capability("07-4")
def test_free_coordinates_of_a_batch_are_the_held_ones():
    robot = on_a_rail()
    T = robot.forward_kinematics(configurations(robot, 20, 5))
    many = mf.inverse_kinematics(robot, T)
    assert (many.free[many.valid] > 0).all()
    answer = mf.inverse_kinematics(robot, T[0])
    named = {robot.joint_names[k] for k in range(robot.n) if many.free[0][many.valid[0]][0] >> k & 1}
    assert named == {family.joint for family in answer.families if family.solution == 0}
    assert np.isfinite(pose.error(robot.forward_kinematics(answer.families[0].at(0.3)), T[0])).all()
