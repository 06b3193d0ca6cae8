"""Rank and singularity do not change when the screws of an arm whose axes all meet are typed with few digits."""

import numpy as np
import pytest

import mafsil as mf
from mafsil.geometry import pose
from mafsil.performance import characteristic_length, singularity


def arm(rng, directions, digits, unit=1.0):
    """Axes through one random point, and a tool there, in a random frame; rounded to digits."""
    G = pose.exp(rng.normal(size=6))
    point = unit * G[:3, 3]
    axes = np.array([G[:3, :3] @ w / np.linalg.norm(w) for w in directions])
    S = np.concatenate([axes, np.cross(point, axes)], axis=1)
    home = np.eye(4)
    home[:3, 3] = point
    return mf.Robot.from_screws(np.round(S, digits), np.round(home, digits), normalise=True)


@pytest.mark.parametrize("unit", [1.0, 1000.0])
@pytest.mark.parametrize("digits", [6, 8, 10, 11, 12, 15])
def test_concurrent_axes_have_rank_three(digits, unit):
    rng = np.random.default_rng(0)
    for _ in range(5):
        robot = arm(rng, rng.normal(size=(4, 3)), digits, unit)
        told = singularity(robot, rng.uniform(-1, 1, 4))
        assert told.rank == 3
        wrist = arm(rng, [[0, 0, 1], [0, 1, 0], [0, 0, 1]], digits, unit)
        straight = singularity(wrist, [0.3, 0.0, 0.4])
        assert straight.rank == 2
        assert straight.singular


def test_small_arms_keep_their_levers():
    S = np.array([[0, 0, 1, 0, 0, 0], [0, 0, 1, 0, -1e-3, 0.0]])
    home = np.eye(4)
    home[0, 3] = 2e-3
    assert 5e-4 < characteristic_length(mf.Robot.from_screws(S, home)) < 2e-3
