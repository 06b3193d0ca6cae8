"""Joints led along any path of the tip: on the path everywhere, on the branch of the start, corners at knots."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.ik import track
from mafsil.trajectory import (
    arc_path,
    circle_path,
    follow,
    joined_path,
    joint_motion,
    line_path,
    screw_path,
    spline_path,
)

START = np.array([0.3, -1.2, 1.2, 0.4, 1.0, 0.2])


def shifted(T, x, y, z):
    moved = T.copy()
    moved[:3, 3] += [x, y, z]
    return moved


def paths(T):
    a, b = shifted(T, 0.1, 0.1, -0.05), shifted(T, 0.05, 0.2, 0.05)
    turned = b @ np.array([[0.0, -1.0, 0.0, 0.0], [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0], [0.0, 0.0, 0.0, 1.0]])
    return {
        "line": line_path(T, turned),
        "arc": arc_path(T, a[:3, 3], turned),
        "circle": circle_path(T, T[:3, 3] + [0.05, 0.0, 0.0], [0.0, 0.0, 1.0]),
        "screw": screw_path(T, turned),
        "spline": spline_path([T, a, turned]),
        "corners": joined_path([line_path(T, a), line_path(a, b)]),
        "blends": joined_path([line_path(T, a), line_path(a, b)], blend=0.01),
    }


@pytest.mark.capability("11-38")
@pytest.mark.parametrize("name", ["line", "arc", "circle", "screw", "spline", "corners", "blends"])
def test_the_tip_keeps_to_the_path_on_the_branch_of_the_start(name):
    robot = mf.load("ur5e")
    path = paths(robot.forward_kinematics(START))[name]
    outcome = follow(robot, path, START)
    assert outcome, outcome.explain()
    s = np.linspace(0.0, 1.0, 733)
    np.testing.assert_allclose(robot.forward_kinematics(outcome.value.at(s).u), path.poses(s), atol=1.1e-6)
    tracked = track(robot, path.poses(s), START, times=s)
    assert tracked.continuous
    np.testing.assert_allclose(outcome.value.at(s).u, tracked.q, atol=1e-5)
    # Rates and their slopes at the knots are those of the inverse Jacobian, on both sides of corners.
    assert set(np.round(path.breaks, 12)) <= set(np.round(outcome.value.knots, 12))
    k = np.sort(np.concatenate([outcome.value.knots[:-1] + 1e-9, outcome.value.knots[1:] - 1e-9]))
    motion = outcome.value.at(k)
    V, slope = path.twists(k)
    J, J_rate = robot.jacobian_body(motion.u), robot.jacobian_body_rate(motion.u, motion.v)
    np.testing.assert_allclose((J @ motion.v[..., None])[..., 0], V, atol=1e-4)
    acceleration = (J @ motion.a[..., None] + J_rate @ motion.v[..., None])[..., 0]
    np.testing.assert_allclose(acceleration, slope, atol=2e-3 * max(1.0, np.abs(slope).max()))


@pytest.mark.capability("11-38")
@pytest.mark.parametrize("name", ["line", "arc", "screw", "spline"])
def test_both_ways_to_rates_and_accelerations_agree(name):
    robot = mf.load("ur5e")
    path = paths(robot.forward_kinematics(START))[name]
    exact = joint_motion(robot, path, START, 2.0, by="jacobian")
    measured = joint_motion(robot, path, START, 2.0, by="differences")
    assert exact
    assert measured
    np.testing.assert_array_equal(exact.q, measured.q)
    np.testing.assert_allclose(measured.qd, exact.qd, atol=1e-6)
    # Where the path's third derivative jumps, the polynomial through seven positions is worse by one order.
    smooth = np.ones(len(exact.times), dtype=bool) if name != "spline" else slice(5, -5)
    np.testing.assert_allclose(measured.qdd[smooth], exact.qdd[smooth], atol=3e-3)
    np.testing.assert_allclose(exact.qd[[0, -1]], 0.0, atol=1e-9)


@pytest.mark.capability("11-38", "10-54")
def test_rates_are_those_of_the_followed_joint_path():
    """A third way: the joint path of `follow` with the law along it."""
    robot = mf.load("ur5e")
    path = paths(robot.forward_kinematics(START))["corners"]
    motion = joint_motion(robot, path, START, 1.5, law="cubic", rate=400.0)
    law = mf.trajectory.time_law("cubic").unit().scale_time(1.5).at(motion.times)
    joints = follow(robot, path, START, tolerance=1e-8).value.at(law.u[:, 0])
    apart = np.abs(law.u[:, 0] - path.breaks[1]) > 1e-9
    np.testing.assert_allclose(motion.q, joints.u, atol=1e-7)
    np.testing.assert_allclose(motion.qd[apart], (joints.v * law.v)[apart], atol=1e-5)
    np.testing.assert_allclose(motion.qdd[apart], (joints.a * law.v**2 + joints.v * law.a)[apart], atol=2e-3)


def test_what_cannot_be_reached_has_no_rates():
    robot = mf.load("ur5e")
    T = robot.forward_kinematics(START)
    for by in ("jacobian", "differences"):
        motion = joint_motion(robot, line_path(T, shifted(T, -1.5, 0.0, 0.0)), START, 1.0, rate=100.0, by=by)
        assert not motion
        lost = np.isnan(motion.q[:, 0])
        assert 0 < lost.sum() < len(lost)
        assert np.isnan(motion.qd[lost]).all()
        assert motion.explain("en")
    with pytest.raises(InputError, match="by"):
        joint_motion(robot, line_path(T, T), START, 1.0, by="guess")
