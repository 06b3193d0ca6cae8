"""Points, free vectors and their units; frames from points; the frame graph and loops."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil.errors import InputError
from mafsil.geometry import Point, Pose, Vector, points, pose, rotation
from mafsil.geometry.frames import FrameGraph, solve_loop

EPS = 2.0**-52


def random_pose(rng: np.random.Generator, frames: tuple[str, str] | None = None) -> Pose:
    return Pose(pose.from_rotation_translation(rotation.random(rng), rng.uniform(-1, 1, 3)), frames)


@pytest.mark.capability("04-1")
def test_rigid_body_coordinates_and_distances():
    assert points.body_coordinates(3) == 6 == 9 - 3
    assert points.body_coordinates(2) == 3 == 6 - 3
    rng = np.random.default_rng(0)
    marks = rng.standard_normal((3, 3))
    T = random_pose(rng)
    moved = pose.act(T.array, marks)
    assert points.rigidity_residual(marks, moved) <= 16 * EPS
    moved[1] += [0.0, 1e-3, 0.0]
    assert points.rigidity_residual(marks, moved) > 1e-4
    assert points.pairwise_distances(marks).shape == (3, 3)


@pytest.mark.capability("04-2", "04-7", "04-16")
def test_frame_from_three_points():
    rng = np.random.default_rng(1)
    T = random_pose(rng)
    on_body = np.array([[0.0, 0, 0], [2.0, 0, 0], [0.5, 0.7, 0]])
    seen = pose.act(T.array, on_body)
    assert np.abs(points.frame_from_points(*seen) - T.array).max() < 1e-14
    batch = points.frame_from_points(*(np.broadcast_to(p, (4, 2, 3)) for p in seen))
    assert batch.shape == (4, 2, 4, 4)
    x, y, z = batch[0, 0, :3, :3].T
    assert np.abs(np.cross(x, y) - z).max() <= 4 * EPS
    with pytest.raises(InputError, match="on one line"):
        points.frame_from_points([0, 0, 0], [1, 1, 1], [2, 2, 2])
    with pytest.raises(InputError, match="on one line"):
        points.frame_from_points([0, 0, 0], [0, 0, 0], [2, 2, 2])


def test_fit_of_point_sets():
    rng = np.random.default_rng(2)
    T = random_pose(rng)
    b = rng.standard_normal((12, 3))
    a = pose.act(T.array, b)
    assert np.abs(points.fit(b, a) - T.array).max() < 1e-14
    noisy = points.fit(b, a + 1e-4 * rng.standard_normal(a.shape))
    assert np.linalg.norm(pose.error(T.array, noisy)) < 1e-3
    flat = b * [1, 1, 0]
    assert np.abs(points.fit(flat, pose.act(T.array, flat)) - T.array).max() < 1e-13


TETRAHEDRON = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1]])


@pytest.mark.capability("04-122", "04-83")
def test_a_mirror_image_is_no_rigid_motion():
    image = TETRAHEDRON * [1, 1, -1] + [0.3, 0, 0]
    assert points.rigidity_residual(TETRAHEDRON, image) < 1e-15
    found = points.rigid_motion(TETRAHEDRON, image)
    assert not found
    assert found.mirrored
    assert found.residual > 0.5
    assert "mirror" in found.explain("en")
    assert found.explain("ar") != found.explain("en")
    with pytest.raises(InputError, match="mirror"):
        points.fit(TETRAHEDRON, image)
    with pytest.raises(InputError, match=r"points\[1\]: the second set is a mirror"):
        points.fit(np.stack([TETRAHEDRON] * 2), np.stack([TETRAHEDRON, image]))
    flat = TETRAHEDRON[:3]
    assert points.rigid_motion(flat, flat * [1, -1, 1]), "in a plane the image is a half turn away"


@pytest.mark.capability("04-122")
def test_verdicts_of_rigid_motion():
    rng = np.random.default_rng(4)
    T = random_pose(rng)
    moved = pose.act(T.array, TETRAHEDRON)
    found = points.rigid_motion(TETRAHEDRON, moved)
    assert found
    assert not found.mirrored
    np.testing.assert_allclose(found.T, T.array, atol=1e-14)
    bent = moved + np.array([[0, 0, 0], [0, 0, 1e-3], [0, 0, 0], [0, 0, 0]])
    assert not points.rigid_motion(TETRAHEDRON, bent)
    assert not points.rigid_motion(TETRAHEDRON, bent).mirrored
    assert points.rigid_motion(TETRAHEDRON, bent, tolerance=2e-3)
    line = [[0, 0, 0], [1, 0, 0], [3, 0, 0]]
    assert points.rigid_motion(line, line)
    assert points.rigid_motion(line, line).T is None
    assert not points.rigid_motion(line, [[0, 0, 0], [1, 0, 0], [2, 0, 0]])


def test_a_fit_needs_points_that_tell_the_turn():
    for few in ([[0.0, 0, 0], [1, 0, 0]], [[0, 0, 0], [1, 1, 1], [2, 2, 2]], [[1.0, 2, 3]] * 4):
        with pytest.raises(InputError, match="on one line"):
            points.fit(few, few)
    with pytest.raises(InputError, match="shape"):
        points.fit(TETRAHEDRON, TETRAHEDRON[:3])
    rng = np.random.default_rng(0)
    plate = rng.uniform(-1, 1, (300, 6, 3)) * [1, 1, 0]
    noisy = plate + 1e-4 * rng.standard_normal(plate.shape)
    assert np.abs(points.fit(plate + 1e-4 * rng.standard_normal(plate.shape), noisy) - np.eye(4)).max() < 0.01


def test_the_constructor_of_a_graph_refuses_contradictions():
    A, B = Pose.translation([0, 0, 0], ("a", "b")), Pose.translation([1, 0, 0], ("a", "b"))
    for edges in ((A, B), (B, A), (A, B.inverse())):
        with pytest.raises(InputError, match="contradicts"):
            FrameGraph(edges)
    T_cd, T_bc = Pose.translation([0, 1, 0], ("c", "d")), Pose.translation([0, 0, 2], ("b", "c"))
    graph = FrameGraph((A, T_cd, T_bc, Pose.translation([0, 1, 2], ("a", "d"))))
    np.testing.assert_allclose(graph.pose("a", "d").origin, [0, 1, 2])
    with pytest.raises(InputError, match="T_ad contradicts"):
        FrameGraph((A, T_cd, T_bc, Pose.translation([0, 1, 3], ("a", "d"))))
    with pytest.raises(InputError, match="letters"):
        FrameGraph((Pose.identity(),))


@pytest.mark.capability("04-86")
def test_a_loop_that_does_not_close_says_by_how_much():
    slack = Pose.exp([0, 0, 4e-7, 0, 0, 0], ("c", "a"))
    T_ab, T_bc = Pose.identity(("a", "b")), Pose.translation([3e-7, 0, 0], ("b", "c"))
    angle, distance = FrameGraph((T_ab, T_bc, slack)).loop_residual(("a", "b", "c"))
    assert angle == pytest.approx(4e-7, rel=1e-6)
    assert distance == pytest.approx(3e-7, rel=1e-6)


@pytest.mark.capability("04-4", "04-5", "04-6", "04-8")
def test_points_and_free_vectors_with_frame_and_unit():
    rng = np.random.default_rng(3)
    T_ab = random_pose(rng, ("a", "b"))
    p, q = Point([1.0, 2.0, 3.0], "b"), Point([0.0, 1.0, 1.0], "b")
    v = p - q
    assert isinstance(v, Vector)
    assert v.frame == "b"
    moved = (T_ab @ p) - (T_ab @ q)
    assert moved.close_to(T_ab @ v, 8 * EPS)
    assert moved.length() == pytest.approx(v.length())
    assert (T_ab @ p).distance(T_ab @ q) == pytest.approx(p.distance(q))
    assert (q + v).close_to(p, EPS)
    in_mm = p.in_unit("mm")
    assert in_mm.array.tolist() == [1000, 2000, 3000]
    assert (T_ab @ in_mm).unit == "mm"
    assert (T_ab @ in_mm).in_unit("m").close_to(T_ab @ p, 16 * EPS)
    assert v.in_unit("cm").length() == pytest.approx(100 * v.length())
    assert v.in_unit("in").in_unit("m").close_to(v, 4 * EPS)
    assert v.dot(v.in_unit("mm")) == pytest.approx(v.length() ** 2)
    assert repr(in_mm) == "Point([1000.0, 2000.0, 3000.0], frame='b', unit='mm')"
    assert (v + v.in_unit("km")).close_to(2.0 * v, 8 * EPS)
    assert (v - v).close_to(0.0 * v, 0)
    with pytest.raises(InputError, match="adjacent letters"):
        p - Point([0, 0, 0], "a")
    with pytest.raises(InputError, match="unit"):
        p.in_unit("parsec")


@pytest.mark.capability("04-84", "04-86")
def test_frame_graph_finds_any_pose_in_any_direction():
    rng = np.random.default_rng(4)
    T_ab, T_cb, T_cd = (random_pose(rng, f) for f in (("a", "b"), ("c", "b"), ("c", "d")))
    graph = FrameGraph().with_pose(T_ab).with_pose(T_cb).with_pose(T_cd)
    want = T_ab.array @ np.linalg.inv(T_cb.array) @ T_cd.array
    assert np.abs(graph.pose("a", "d").array - want).max() <= 32 * EPS
    assert np.abs(graph.pose("d", "a").array - np.linalg.inv(want)).max() <= 32 * EPS
    assert graph.pose("a", "a").array.tolist() == np.eye(4).tolist()
    assert graph.pose("a", "d").frames == ("a", "d")
    assert graph.frames == ("a", "b", "c", "d")
    T_ad = Pose(want, ("a", "d"))
    closed = graph.with_pose(T_ad)
    angle, distance = closed.loop_residual(("a", "b", "c", "d"))
    assert max(angle, distance) < 1e-14
    with pytest.raises(InputError, match="T_ad contradicts"):
        graph.with_pose(Pose(want @ pose.exp([0, 0, 1e-3, 0, 0, 0]), ("a", "d")))
    with pytest.raises(InputError, match="no frame 'x'"):
        graph.pose("a", "x")
    island = graph.with_pose(random_pose(rng, ("e", "f")))
    with pytest.raises(InputError, match=r"\{a, b, c, d\} \{e, f\}"):
        island.pose("a", "f")
    with pytest.raises(InputError, match="no chain of known poses"):
        graph.loop_residual(("a", "c"))
    with pytest.raises(InputError, match="no frame letters"):
        graph.with_pose(Pose.identity())
    with pytest.raises(InputError, match="one value is needed"):
        graph.with_pose(Pose(np.stack([np.eye(4)] * 2), ("a", "z")))


@pytest.mark.capability("04-86")
@pytest.mark.parametrize("missing", range(5))
def test_any_unknown_of_a_loop_is_found(missing: int):
    rng = np.random.default_rng(5)
    T_ab, T_bc, T_ad, T_de = (random_pose(rng, f) for f in (("a", "b"), ("b", "c"), ("a", "d"), ("d", "e")))
    T_ce = (T_ab @ T_bc).inverse() @ T_ad @ T_de
    chain = [T_ab, T_bc, T_ce, T_ad, T_de]
    links = [T.frames if k == missing else T for k, T in enumerate(chain)]
    found = solve_loop(links[:3], links[3:])
    assert found.frames == chain[missing].frames
    assert found.close_to(chain[missing], 64 * EPS)


def test_loops_need_exactly_one_unknown():
    T_ab = Pose.identity(("a", "b"))
    with pytest.raises(InputError, match="unknown are 0"):
        solve_loop([T_ab], [T_ab])
    with pytest.raises(InputError, match="unknown are 2"):
        solve_loop([("a", "b")], [("a", "b")])
