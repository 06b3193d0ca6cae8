"""Distances of two bodies: against coal, by closed forms written out here, and by what every distance obeys.

Polytopes that grow in a difference stay in the memory that they are given, and bound the depth.
"""

from __future__ import annotations

from itertools import combinations_with_replacement

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import mafsil as mf
from mafsil import collision
from mafsil.collision import Box, Capsule, Cone, Cylinder, Obstacle, Plane, PointCloud, Sphere, TriangleMesh
from mafsil.collision.depth_loops import WORKSPACE, grown_depth
from mafsil.collision.piece_loops import corner
from tests.collision.peer import BODIES, ROUND, coal_distance, random_poses
from tests.sizes import size

PAIRS = [pair for pair in combinations_with_replacement(BODIES, 2) if pair != ("plane", "plane")]


@pytest.mark.capability("11-39")
@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_distances_are_those_of_coal(first, second):
    """To coal's tolerance of 1e-6; of two bodies that meet the verdict, and a depth that is no longer than coal's."""
    count = 400
    T_a, T_b = random_poses(count, 0.6, 1), random_poses(count, 0.6, 2)
    ours = collision.distance(BODIES[first][0], BODIES[second][0], T_a, T_b)
    pairs = zip(T_a, T_b, strict=True)
    coals = np.array([coal_distance(BODIES[first][1], a, BODIES[second][1], b) for a, b in pairs])
    apart = ours.distance > 0.0
    assert ((coals > 0.0) == apart).all()
    np.testing.assert_allclose(ours.distance[apart], coals[apart], atol=3e-6)
    round_pair = first in ROUND or second in ROUND
    assert (ours.distance[~apart] > coals[~apart] - (1e-4 if round_pair else 1e-9)).all()
    if not round_pair:
        np.testing.assert_allclose(ours.distance[~apart], coals[~apart], atol=1e-9)


@pytest.mark.capability("11-39")
@pytest.mark.parametrize(("first", "second"), PAIRS)
def test_points_lie_on_both_bodies_and_the_normal_joins_them(first, second):
    T_a, T_b = random_poses(300, 0.6, 3), random_poses(300, 0.6, 4)
    a, b = BODIES[first][0], BODIES[second][0]
    found = collision.distance(a, b, T_a, T_b)
    gap = found.point_a - found.point_b
    np.testing.assert_allclose(gap, found.distance[:, None] * found.normal, atol=1e-9)
    np.testing.assert_allclose(np.linalg.norm(found.normal, axis=1), 1.0, atol=1e-12)
    for body, T, points in ((a, T_a, found.point_a), (b, T_b, found.point_b)):
        at = np.tile(np.eye(4), (len(points), 1, 1))
        at[:, :3, 3] = points
        off = np.abs(collision.distance(Sphere(1e-9), body, at, T).distance)
        assert off[found.distance > 0.0].max() < 1e-6
        assert off.max() < (2e-4 if {first, second} & set(ROUND) else 1e-6)
    parted = T_a.copy()
    parted[:, :3, 3] -= np.minimum(found.distance, 0.0)[:, None] * found.normal
    assert collision.distance(a, b, parted, T_b).distance.min() > -1e-8


def test_closed_forms_by_hand():
    at = lambda *p: np.block([[np.eye(3), np.reshape(p, (3, 1))], [np.zeros((1, 3)), np.ones((1, 1))]])  # noqa: E731
    d = lambda a, b, *p: float(collision.distance(a, b, T_sb=at(*p)).distance)  # noqa: E731
    box = Box((2.0, 2.0, 2.0))
    assert d(box, Box((1.0, 1.0, 1.0)), 3.0, 3.0, 0.0) == pytest.approx(1.5 * np.sqrt(2), abs=1e-12)
    assert d(box, Box((1.0, 1.0, 1.0)), 1.4, 0.0, 0.0) == pytest.approx(-0.1, abs=1e-12)
    assert d(box, Sphere(0.5), 0.2, 0.0, 0.0) == pytest.approx(-0.8 - 0.5, abs=1e-12)
    assert d(Capsule(0.1, 2.0), Capsule(0.2, 2.0), 1.0, 0.0, 3.0) == pytest.approx(np.sqrt(2) - 0.3, abs=1e-12)
    assert d(Cylinder(1.0, 2.0), Sphere(0.5), 0.0, 0.0, 1.2) == pytest.approx(-0.3, abs=1e-12)
    assert d(Cone(1.0, 2.0), Sphere(0.5), 0.0, 0.0, 2.0) == pytest.approx(0.5, abs=1e-12)
    assert d(Plane(), Cylinder(1.0, 2.0), 0.0, 0.0, 0.7) == pytest.approx(-0.3, abs=1e-12)


def test_many_pieces_have_the_distance_of_the_nearest():
    """A cloud, a mesh and a height map against the least over their parts, one by one."""
    rng = np.random.default_rng(6)
    points = rng.uniform(-1.0, 1.0, (80, 3))
    cloud, box = PointCloud(points, 0.02), Box((0.3, 0.2, 0.4))
    T = random_poses(8, 1.5, 7)
    one_by_one = [[collision.distance(box, Obstacle(Sphere(0.02), p), t).distance for p in points] for t in T]
    found = collision.distance(box, cloud, T)
    np.testing.assert_allclose(found.distance, np.min(one_by_one, axis=1), atol=1e-12)
    mesh = TriangleMesh(rng.uniform(-1.0, 1.0, (45, 3)), np.arange(45).reshape(15, 3))
    triangles = [collision.ConvexHull(mesh.vertices[f]) for f in mesh.faces]
    one_by_one = [[collision.distance(box, each, t).distance for each in triangles] for t in T]
    np.testing.assert_allclose(collision.distance(box, mesh, T).distance, np.min(one_by_one, axis=1), atol=1e-9)


def test_a_height_map_is_solid_below_its_surface():
    x = np.linspace(-1.0, 1.0, 41)
    ground = collision.HeightMap(0.1 * np.sin(3 * x)[None, :] + np.zeros((5, 1)), (2.0, 1.0), base=-0.5)
    for place in (0.0, 0.33, -0.71):
        surface = 0.1 * np.sin(3 * place)
        above = collision.distance(Obstacle(Sphere(0.05), (place, 0.1, surface + 0.2)), ground)
        assert above
        assert 0.13 < float(above.distance) < 0.151
        assert not collision.distance(Obstacle(Sphere(0.01), (place, 0.1, surface - 0.2)), ground)


poses = st.integers(0, 10**6).map(lambda seed: random_poses(3, 0.7, seed))


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(PAIRS), poses)
def test_a_distance_is_symmetric_moves_with_the_world_and_changes_no_faster_than_the_body(pair, T):
    a, b = (BODIES[name][0] for name in pair)
    d = float(collision.distance(a, b, T[0], T[1]).distance)
    tolerance = 1e-4 if d < 0.0 else 1e-9
    assert float(collision.distance(b, a, T[1], T[0]).distance) == pytest.approx(d, abs=tolerance)
    assert float(collision.distance(a, b, T[2] @ T[0], T[2] @ T[1]).distance) == pytest.approx(d, abs=tolerance)
    moved = T[0].copy()
    moved[:3, 3] += [0.03, -0.04, 0.0]
    assert abs(float(collision.distance(a, b, moved, T[1]).distance) - d) <= 0.05 + tolerance


def test_answers_say_where():
    found = collision.distance(Obstacle(Sphere(0.1), (0.0, 0.0, 0.3), "ball"), Obstacle(Box((1, 1, 0.2)), name="table"))
    assert found
    assert found.explain("en") == "ball and table: 100 mm apart, nearest at (0.000, 0.000, 0.150) m"
    assert "ball" in found.explain("ar")
    assert not collision.distance(Sphere(1.0), Sphere(1.0))
    assert len(collision.distance(Sphere(1.0), Sphere(1.0), random_poses(3, 1.0, 0))) == 3


def test_wrong_input_is_named():
    with pytest.raises(mf.InputError, match="not a geometry"):
        Obstacle("box")
    with pytest.raises(mf.InputError, match="name: ndarray is not a name of an obstacle"):
        Obstacle(Sphere(1.0), np.zeros(3), np.eye(4))
    with pytest.raises(mf.InputError, match="not a length"):
        Obstacle(Sphere(-1.0))
    with pytest.raises(mf.InputError, match="size: nan"):
        Box((1.0, float("nan"), 1.0))
    with pytest.raises(mf.InputError, match="T_so"):
        Obstacle(Sphere(1.0), (0.0, float("inf"), 0.0))
    with pytest.raises(mf.InputError, match="triangles"):
        TriangleMesh(np.zeros((3, 3)), [[0, 1, 3]])
    with pytest.raises(mf.InputError, match="half spaces"):
        collision.distance(Plane(), Plane())
    with pytest.raises(mf.InputError, match="below the lowest"):
        collision.HeightMap(np.zeros((3, 3)), (1.0, 1.0), base=0.0)
    with pytest.raises(mf.InputError, match="own name"):
        mf.Scene([Obstacle(Sphere(1.0), name="a"), Obstacle(Sphere(1.0), name="a")])


@pytest.mark.parametrize(
    ("call", "words"),
    [
        (lambda: Obstacle(Box(0.5)), "size: expected shape"),
        (lambda: Obstacle(Sphere(1e16)), "not a length.*at most 1e\\+06"),
        (lambda: Obstacle(Sphere(0.1), (1e12, 0.0, 0.0)), "farther than 1e\\+06 m"),
        (lambda: collision.ConvexHull(np.eye(3) * 1e200), "points: .*farther"),
        (lambda: collision.HeightMap(np.zeros((3, 3)), 1.0, base=-1.0), "size: expected shape"),
        (lambda: collision.HeightMap(np.zeros((3, 3)), (1.0, 1.0, 1.0), base=-1.0), "size: expected shape"),
        (lambda: collision.HeightMap(np.zeros((3, 3)), (1.0, 1.0), base=-np.inf), "base"),
        (lambda: mf.Scene(Obstacle(Sphere(0.1))), "list of obstacles, got a Obstacle"),
        (lambda: mf.Scene(None), "list of obstacles"),
    ],
)
def test_what_is_no_scene_is_said(call, words):
    with pytest.raises(mf.InputError, match=words):
        call()


def test_poses_that_are_none_are_refused_in_batches_too():
    """A matrix that stretches gave a distance of stretched bodies."""
    T = random_poses(3, 1.0, 0)
    T[1, :3, :3] *= 2.0
    with pytest.raises(mf.MafsilError, match=r"T_sa\[1\]: the axes of its rotation have the length 2"):
        collision.distance(Sphere(0.1), Sphere(0.1), T)


def test_a_scene_names_its_obstacles():
    scene = mf.Scene([Sphere(0.1), Obstacle(Box((1, 1, 1)), (0, 0, 2), "table"), Sphere(0.2)])
    assert scene.names == ("sphere 1", "table", "sphere 2")
    assert scene.without("table").names == ("sphere 1", "sphere 2")
    assert len(scene.with_obstacle(Cone(0.1, 0.2), (1, 0, 0))) == 4
    with pytest.raises(mf.InputError, match="table"):
        scene.without("chair")


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
