"""Polytopes that grow in a difference stay in the memory that they are given, and bound the depth."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from mafsil.collision.depth_loops import WORKSPACE, grown_depth
from mafsil.collision.piece_loops import corner
from tests.sizes import size

NO_VERTICES = np.zeros((0, 3))
SEGMENT, CYLINDER = 1, 3
UNTOUCHED = 7.5


def depth(kind_a, size_a, kind_b, size_b, M, S, count):
    """Bounds of the depth, and whether memory beyond the workspace was written to."""
    W, n = np.full((WORKSPACE + 400, 10), UNTOUCHED), np.zeros((2, 6))
    bounds = grown_depth(kind_a, size_a, NO_VERTICES, kind_b, size_b, NO_VERTICES, M, S, count, n, W)
    return bounds, bool((W[WORKSPACE:] != UNTOUCHED).any())


def test_a_capsule_in_a_cylinder_whose_polytope_has_more_open_edges_than_room():
    """Seen in a run of random jobs: 130 rows behind the workspace were overwritten."""
    M = np.array([
        [-0.8659797686219405, 0.342358350528556, -0.3645131001224202, -0.03772710586267049],
        [0.3676535547297961, 0.9299628292004714, 0.0, -4.683753385137379e-17],
        [0.3389836338704805, -0.13401453700558577, -0.9311982602212823, 0.04362098006709729],
    ])  # fmt: skip
    S = np.array([
        [0.004024728905467234, 1.0408340855860843e-17, 0.02373407029339046, 0.0, 0.0, 0.03],
        [-0.012378360600041674, 5.377642775528102e-17, -0.07816985141656724, 0.0, 0.0, -0.03],
        [-0.012378360600041681, -4.631711680858075e-15, -0.018169851416567233, 0.0, 0.0, 0.03],
        [-0.004946333078730596, 3.929602210917316e-08, -0.02148132749024558, 0.0, 0.0, 0.03],
    ])  # fmt: skip
    segment, cylinder = np.array([0.0, 0, 0.03]), np.array([0.045, 0, 0.0225])
    (lower, upper), beyond = depth(SEGMENT, segment, CYLINDER, cylinder, M, S, 3)
    assert not beyond
    assert lower == pytest.approx(upper, abs=1e-8)
    # Moved out along the way of least depth, found by random directions, the capsule's core touches.
    ways = np.random.default_rng(0).normal(size=(20_000, 3))
    ways /= np.linalg.norm(ways, axis=1, keepdims=True)
    local = ways @ M[:, :3]
    reach = 0.03 * np.abs(ways[:, 2]) + 0.045 * np.hypot(local[:, 0], local[:, 1]) + 0.0225 * np.abs(local[:, 2])
    assert lower <= (reach - ways @ M[:, 3]).min() <= 1.05 * upper


@pytest.mark.parametrize("kinds", [(1, 3), (3, 3), (3, 4), (4, 4), (1, 4)])
def test_no_pair_of_round_bodies_leaves_the_workspace(kinds):
    rng = np.random.default_rng(sum(kinds))
    for _ in range(size(300, 20_000)):
        sizes = [np.array([0.0 if kind == 1 else r, 0.0, h]) for kind, r, h in zip(
            kinds, 10.0 ** rng.uniform(-2, 0, 2), 10.0 ** rng.uniform(-2, 0, 2), strict=True)]  # fmt: skip
        tilt = Rotation.random(random_state=int(rng.integers(1 << 31))).as_matrix()
        if rng.random() < 0.5:  # As in robots: axes in one plane, or along each other.
            tilt = Rotation.from_rotvec([0.0, float(rng.uniform(-2, 2)), 0.0]).as_matrix()
        M = np.column_stack([tilt, rng.normal(size=3) * min(*sizes[0][[2]], *sizes[1][[2]])])
        S = np.zeros((5, 6))
        corner(kinds[0], sizes[0], NO_VERTICES, kinds[1], sizes[1], NO_VERTICES, M, *rng.normal(size=3).tolist(), S[0])
        (lower, upper), beyond = depth(kinds[0], sizes[0], kinds[1], sizes[1], np.ascontiguousarray(M), S, 1)
        assert not beyond
        assert lower <= upper
