"""Path points, and what a trajectory must do as data."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.trajectory import (
    KeepsClear,
    MaxDerivativeJump,
    MaxDuration,
    PassThrough,
    Trajectory,
    cubic_through,
    joint_path,
    linear_blends,
    quintic,
    require,
    tip_path,
)
from mafsil.trajectory.paths import PathPoints, PointKind


@pytest.mark.capability("11-4")
def test_each_kind_of_requirement_is_measured():
    plan = linear_blends([[0.0, 0.0], [1.0, 1.0], [2.0, 0.0]], 1.0, acceleration=8.0)
    miss = float(np.linalg.norm(plan.miss[0]))
    motion = plan.trajectory
    answer = require(
        motion,
        PassThrough([1.0, 1.0], miss * 1.001),
        PassThrough([1.0, 1.0], miss * 0.999),
        KeepsClear([1.0, 1.0], miss * 0.999),
        KeepsClear([1.0, 1.0], miss * 1.001),
        KeepsClear([1.0, 1.0], 0.5, end=0.5),
        MaxDuration(most=2.0),
        MaxDuration(least=2.1),
        MaxDerivativeJump(1),
        MaxDerivativeJump(2),
    )
    assert [finding.met for finding in answer] == [True, False, True, False, True, True, False, True, False]
    assert not answer
    nearest = next(iter(answer))
    np.testing.assert_allclose([nearest.measured, nearest.time], [miss, 1.0], rtol=1e-5)
    for language in ("en", "ar"):
        assert len(answer.explain(language).splitlines()) == 9
    assert answer.to_dict()["findings"][0]["kind"] == "PassThrough"
    assert require(quintic([0.0], [1.0], 1.0), MaxDerivativeJump(2), MaxDuration(0.5, 1.5))
    with pytest.raises(InputError, match="distance"):
        PassThrough([0.0, 0.0], 0.0)
    for wrong in (PassThrough([0.0], 1.0), KeepsClear([0, 0], 1.0, begin=5.0)):
        with pytest.raises(InputError):
            require(motion, wrong)


@pytest.mark.capability("11-4")
def test_a_distance_may_be_that_of_the_tip():
    robot = mf.load("puma560")
    q = np.array([0.1, -0.6, 0.4, 0.2, 0.7, 0.3])
    motion = quintic(q, q + 0.3, 1.0)

    def tip(u):
        return robot.forward_kinematics(u)[:, :3, 3]

    middle = tip(motion.at([0.5]).u)[0]
    (finding,) = require(motion, PassThrough(middle, 1e-6, place=tip))
    assert finding.met
    np.testing.assert_allclose(finding.time, 0.5, atol=1e-4)


@pytest.mark.capability("11-2", "11-3")
def test_points_of_a_path_are_initial_via_and_final_and_have_no_time():
    path = joint_path([[0.0, 1.0], [1.0, 2.0], [3.0, 0.0], [1.0, 1.0]])
    assert [point.kind for point in path.points] == [PointKind.INITIAL, PointKind.VIA, PointKind.VIA, PointKind.FINAL]
    assert isinstance(path, PathPoints)
    assert not isinstance(path, Trajectory)
    assert not hasattr(path, "duration")
    motion = cubic_through(path.q, 1.0)
    assert isinstance(motion, Trajectory)
    np.testing.assert_allclose(motion.at([0.0, 1.0, 2.0, 3.0]).u, path.q, atol=1e-12)
    # Intervals are half open: at a knot the right-hand acceleration, outside rest.
    stops = cubic_through(path.q, 1.0, velocities="stop")
    np.testing.assert_allclose(stops.at(1.0).a, 6 * (path.q[2] - path.q[1]), atol=1e-10)
    np.testing.assert_array_equal(stops.at(-0.1).v, 0.0)
    with pytest.raises(InputError):
        joint_path([[0.0, 1.0]])


@pytest.mark.capability("11-1", "11-5")
def test_poses_and_times_in_a_trajectory_out():
    robot = mf.load("puma560")
    q = np.array([0.1, -0.6, 0.4, 0.2, 0.7, 0.3])
    poses = robot.forward_kinematics(q + 0.2 * np.arange(3)[:, None])
    path = tip_path(poses, q, lambda T, near: mf.solve_ik(robot, T, near))
    assert path
    motion = cubic_through(path.q, [1.0, 2.0])
    np.testing.assert_allclose(robot.forward_kinematics(motion.at([0.0, 1.0, 3.0]).u), poses, atol=1e-8)
    poses[1, :3, 3] += 10.0
    far = tip_path(poses, q, lambda T, near: mf.solve_ik(robot, T, near, restarts=2))
    assert not far
    assert 1 in far.unsolved
    assert np.isnan(far.q[1]).all()


@pytest.mark.capability("11-9")
def test_one_scalar_interpolator_serves_every_coordinate():
    joints, places, angles = (
        [0.1, 0.7, 0.3],
        [[0.0, 0, 1], [1, 0, 1], [1, 1, 0]],
        [[0.1, 0.2, 0.3], [0.2, 0, 1], [1, 1, 1]],
    )
    together = cubic_through(np.column_stack([joints, places, angles]), [1.0, 2.0]).at(1.7)
    for columns, alone in ((slice(0, 1), joints), (slice(1, 4), places), (slice(4, 7), angles)):
        for ours, other in zip(together, cubic_through(alone, [1.0, 2.0]).at(1.7), strict=True):
            np.testing.assert_allclose(ours[columns], other, atol=1e-13)
