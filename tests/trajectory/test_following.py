"""Joints led along any path of the tip: on the path everywhere, on the branch of the start, corners at knots."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.ik import track
from mafsil.trajectory import arc_path, circle_path, follow, joined_path, line_path, screw_path, spline_path

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
