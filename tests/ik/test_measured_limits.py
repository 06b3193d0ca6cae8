"""Poses of measured configurations: joints beyond their limits by rounding count as on them, and it is said."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.ik import inverse_kinematics, solve_ik
from mafsil.ik.result import IKStatus
from mafsil.model.limits import MEASURED

ARMS = ["puma560", "ur5e", "panda", "scara_rrrp", "planar3r"]


def at_a_limit(robot: mf.Robot, k: int, beyond: float) -> np.ndarray:
    """A configuration with coordinate k beyond its upper limit."""
    limits = robot.limits
    middle = (np.clip(limits.lower, -2.0, 2.0) + np.clip(limits.upper, -2.0, 2.0)) / 2
    q = middle + 0.2 + 0.1 * np.arange(robot.n)
    q[k] = limits.upper[k] + beyond
    return q


@pytest.mark.parametrize("name", ARMS)
@pytest.mark.parametrize("beyond", [0.0, 1e-7, 0.9 * MEASURED, 1e-3])
def test_inverse_kinematics_of_measured_configurations(name, beyond):
    robot = mf.load(name)
    for k in range(robot.n):
        limits = robot.limits
        turns = robot.mechanism.coordinates[k].kind.value == "revolute"
        if not np.isfinite(limits.upper[k]) or (turns and limits.upper[k] - limits.lower[k] > 2 * np.pi - 0.01):
            continue  # another turn is within
        q = at_a_limit(robot, k, beyond)
        T = robot.forward_kinematics(q)
        found = inverse_kinematics(robot, T, q0=q)
        distance = np.abs(np.asarray(found.q) - q).max(axis=1) if len(found) else np.array([np.inf])
        mine = int(distance.argmin())
        if distance[mine] < 1e-7:
            assert found.within[mine] == (beyond <= MEASURED)
            said = "counts as on it" in found.explain("en")
            assert said == (0.0 < beyond <= MEASURED)
            assert bool(found.violations(mine)) == (beyond > MEASURED)
        batch = inverse_kinematics(robot, T[None])
        assert bool(batch.within.any()) == bool(found.within.any())


@pytest.mark.parametrize("name", ARMS)
def test_searches_take_what_was_measured(name):
    robot = mf.load(name)
    for k in range(robot.n):
        if not np.isfinite(robot.limits.upper[k]):
            continue
        q = at_a_limit(robot, k, 1e-7)
        T = robot.forward_kinematics(q)
        start = robot.limits.snap_to_limits(q)
        for found in (solve_ik(robot, T, start, restarts=0), solve_ik(robot, T[None], start[None], restarts=0)):
            assert found.all_solved
            reached = robot.forward_kinematics(found.q.reshape(-1, robot.n))[0]
            np.testing.assert_allclose(reached, T, atol=1e-8)
            excess = np.maximum(robot.limits.lower - found.q, found.q - robot.limits.upper).max()
            assert excess <= MEASURED
            if excess > 1e-12:
                assert str(np.ravel(found.worst_joint)[0]) == robot.joint_names[k]
        far = robot.forward_kinematics(at_a_limit(robot, k, 1e-3))
        near = solve_ik(robot, far, at_a_limit(robot, k, 0.0), restarts=0)
        assert near.status is not IKStatus.SOLVED or (near.q <= robot.limits.upper + MEASURED).all()
