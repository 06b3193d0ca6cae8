"""Poses of platforms in cables from their lengths."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.optimize import least_squares

from mafsil import parallel
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation

seeds = st.integers(0, 2**32 - 1)


def crane(rng, planar, point=False, m=None):
    k = 2 if planar else 3
    m = m or (4 if planar else 8)
    base = rng.normal(size=(m, k))
    base *= 4 / np.linalg.norm(base, axis=1, keepdims=True)
    return parallel.CableRobot(base, np.zeros((m, k)) if point else 0.4 * rng.normal(size=(m, k)), 1.0, 100.0)


def place(rng, planar):
    return 0.5 * rng.normal(size=3) if planar else pose.exp(0.4 * rng.normal(size=6))


@given(seeds, st.booleans(), st.booleans())
def test_the_pose_comes_back(seed, planar, point):
    rng = np.random.default_rng(seed)
    robot, x = crane(rng, planar, point), place(rng, planar)
    near = np.array(x)
    if planar:
        near += 0.1 * rng.normal(size=3)
    else:
        near = near @ pose.exp(0.1 * rng.normal(size=6))
    found = parallel.cable_poses(robot, robot.lengths(x), near)
    if not found:
        # A random robot may have another minimum nearby; what is said of it is true.
        assert np.allclose(found.error, robot.lengths(x) - robot.lengths(found.x), atol=1e-12)
        return
    assert np.allclose(robot.lengths(found.x), robot.lengths(x), atol=1e-8)


@pytest.mark.parametrize("planar", [True, False])
def test_disagreeing_lengths_give_least_squares(planar):
    rng = np.random.default_rng(4)
    robot, x = crane(rng, planar), place(rng, planar)
    wrong = robot.lengths(x) + 0.01 * rng.normal(size=robot.m)
    found = parallel.cable_poses(robot, wrong, x)
    assert found.status is parallel.cables.cable_robot.CablePoseStatus.DISAGREE

    def residual(step):
        if planar:
            return robot.lengths(x + step) - wrong
        T = np.array(x)
        T[:3, :3], T[:3, 3] = rotation.exp(step[:3]) @ T[:3, :3], T[:3, 3] + step[3:]
        return robot.lengths(T) - wrong

    other = least_squares(residual, np.zeros(3 if planar else 6), xtol=1e-15, ftol=1e-15, gtol=1e-15)
    assert np.linalg.norm(found.error) == pytest.approx(np.linalg.norm(other.fun), rel=1e-9)
    assert "disagree" in found.explain("en")


def test_batches_and_bad_input():
    rng = np.random.default_rng(1)
    robot = crane(rng, planar=False)
    T = pose.exp(0.2 * rng.normal(size=(5, 6)))
    found = parallel.cable_poses(robot, robot.lengths(T), np.eye(4))
    assert found
    assert len(found) == len(list(found)) == 5
    assert np.allclose(found.x, T, atol=1e-8)
    with pytest.raises(InputError, match="lengths"):
        parallel.cable_poses(robot, np.full(8, np.nan), np.eye(4))
    with pytest.raises(InputError, match="lengths"):
        parallel.cable_poses(robot, np.ones(7), np.eye(4))
    with pytest.raises(InputError, match="x_guess"):
        parallel.cable_poses(robot, np.ones(8), np.zeros((4, 4)))
    early = parallel.cable_poses(robot, robot.lengths(T[0]), np.eye(4), max_steps=1)
    assert early.status is parallel.cables.cable_robot.CablePoseStatus.NOT_FOUND
