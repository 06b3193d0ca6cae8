"""Eight complex systems side by side, against NumPy's; and paths that share lanes with others."""

import numpy as np
import pytest

from mafsil.parallel.platforms import path_lane_loops
from mafsil.parallel.platforms.platform_sets import CORRECTIONS, random_platform, start_platform
from tests.parallel.complex_lanes_probe_loops import solve_eight


def in_lanes(A, b):
    """Systems (8, 6, 6), (8, 6, 2) as the loop wants them."""
    whole = np.concatenate([A, b], axis=2)
    return np.ascontiguousarray(np.moveaxis(np.stack([whole.real, whole.imag], axis=3), 0, 3))


def test_each_lane_solves_its_own_system_and_a_singular_one_disturbs_no_other():
    rng = np.random.default_rng(0)
    A, b = (rng.normal(size=(8, 6, n)) + 1j * rng.normal(size=(8, 6, n)) for n in (6, 2))
    A[1, np.arange(6), np.arange(6)] = 0.0  # no pivot on the diagonal
    A[2] = np.eye(6)[::-1]  # one row exchanged after the other
    A[3, 0] *= 1e12  # rows of very different sizes
    A[4, 5] = A[4, 0]
    numbers = in_lanes(A, b)
    solve_eight(numbers)
    x = np.moveaxis(numbers[:, 6:, 0] + 1j * numbers[:, 6:, 1], 2, 0)
    regular = [0, 1, 2, 3, 5, 6, 7]
    expected = np.linalg.solve(A[regular], b[regular])
    size = np.linalg.cond(A[regular] / np.abs(A[regular]).max(axis=2, keepdims=True)) * 1e-15
    assert (np.abs(x[regular] - expected).max(axis=(1, 2)) < 10 * size * np.abs(expected).max(axis=(1, 2))).all()
    assert not (np.abs(x[4]) < 1e10).all()


@pytest.mark.parametrize("count", [0, 1, 7, 8, 9])
def test_a_path_ends_the_same_whatever_stands_beside_it(count):
    geometry, poses = start_platform(0)
    ends = np.stack([random_platform(np.random.default_rng(seed)) for seed in (5, 6)])
    out, how = np.empty((2, 40, 7), complex), np.zeros((2, 40), np.int8)
    path_lane_loops.follow_all(geometry, ends, poses, CORRECTIONS[0], out, how)
    few, ended = np.empty((2, count, 7), complex), np.full((2, count), -1, np.int8)
    path_lane_loops.follow_all(geometry, ends, poses[:count].copy(), CORRECTIONS[0], few, ended)
    np.testing.assert_array_equal(few, out[:, :count])
    np.testing.assert_array_equal(ended, how[:, :count])
