"""An arm in a scene: verdicts and distances against coal, gradients, pairs that are not checked, explanations."""

from __future__ import annotations

from itertools import product
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil import collision, threads
from mafsil.collision import Box, Checker, Obstacle, Plane, SkipReason, Sphere
from mafsil.collision.pairs import mesh_vertices
from mafsil.collision.status import CheckStatus
from tests.collision.arms import arm, arm_of_many_pieces, scene
from tests.collision.peer import CoalChecker, coal_distance, coal_shape


@pytest.mark.capability("11-39")
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_verdicts_and_distances_are_those_of_coal(tmp_path, seed):
    checker = Checker(arm(tmp_path), scene(seed))
    peer, q = CoalChecker(checker), checker.random_configurations(250)
    coals = np.array([peer.distance(each) for each in q])
    found = checker.distance(q)
    hit = checker.in_collision(q)
    assert 0.1 < hit.mean() < 0.95
    assert (hit == (coals <= 0.0)).all()
    assert (hit == (found.distance <= 0.0)).all()
    assert (checker.free(q) == ~hit).all()
    apart = coals > 0.0
    np.testing.assert_allclose(found.distance[apart], coals[apart], atol=3e-6)
    deep = found.distance[~apart] - coals[~apart]  # coal makes a ball deep in a cylinder too deep
    assert deep.min() > -1e-3
    assert np.quantile(np.abs(deep), 0.9) < 1e-5


@pytest.mark.capability("11-39")
def test_flat_tetrahedra_are_no_contact(tmp_path):
    """One configuration in twenty thousand once had an infinite distance: rounding saw a contact in a flat simplex."""
    checker = Checker(arm(tmp_path))
    q = np.random.default_rng(1).uniform(-2.8, 2.8, (200_000, 12))[:, :6]
    found = checker.distance(q)
    assert np.isfinite(found.distance).all()
    assert (checker.in_collision(q) == (found.distance <= 0.0)).all()


@pytest.mark.capability("11-39")
@pytest.mark.parametrize("clearance", [0.0, 0.02])
def test_bodies_of_many_pieces_meet_in_batches_what_they_meet_alone(tmp_path, clearance):
    """Where few of eight states are near something, eight pieces are asked together instead of eight states."""
    checker = Checker(arm_of_many_pieces(tmp_path), scene(5, 5), clearance=clearance, samples=200)
    q = checker.random_configurations(400)
    hit = checker.in_collision(q)
    assert 0.1 < hit.mean() < 0.9
    assert (hit == ~checker.distance(q).free).all()
    assert (hit == [checker.in_collision(each) for each in q]).all()


@pytest.mark.capability("11-39")
def test_every_kind_of_obstacle_is_seen_by_the_whole_arm(tmp_path):
    """Verdicts with a clearance equal distances within it, for meshes, clouds, maps and hundreds of obstacles."""
    robot, rng = arm(tmp_path), np.random.default_rng(4)
    cloud = collision.PointCloud(rng.uniform([-0.1, -1.0, -1.0], [1.9, 1.0, 1.0], (3000, 3)), 0.01)
    mesh = collision.TriangleMesh(rng.uniform([0.2, -1, -0.5], [2.2, 1, 1.5], (60, 3)), np.arange(60).reshape(20, 3))
    ground = collision.HeightMap(-0.3 + 0.1 * rng.random((8, 8)), (3.0, 3.0), base=-1.0)
    many = [Obstacle(Box((0.02, 0.02, 0.02)), p) for p in rng.uniform(-1.0, 1.0, (300, 3))]
    for obstacles in ([cloud], [mesh], [ground], many):
        checker = Checker(robot, obstacles, clearance=0.02, samples=0, self_collision=False)
        q = checker.random_configurations(150)
        hit = checker.in_collision(q)
        assert hit.any()
        assert (hit == (checker.distance(q).distance <= 0.02)).all()


@pytest.mark.capability("11-39")
def test_gradients_are_those_of_differences(tmp_path):
    """Where the nearest pair does not change and its points are no corners' tie, to the differences' own accuracy."""
    checker = Checker(arm(tmp_path), scene(5))
    q = checker.random_configurations(200)
    found, step = checker.distance(q), 1e-6
    numbers = np.empty_like(q)
    for k in range(q.shape[1]):
        up, down = q.copy(), q.copy()
        up[:, k] += step
        down[:, k] -= step
        numbers[:, k] = (checker.distance(up).distance - checker.distance(down).distance) / (2 * step)
    off = np.abs(found.gradient - numbers).max(axis=1)[found.distance > 0.01]
    assert len(off) > 20
    assert np.quantile(off, 0.9) < 1e-5
    assert np.median(off) < 1e-7


def test_points_names_and_places_agree(tmp_path):
    checker = Checker(arm(tmp_path), scene(6))
    found = checker.distance(checker.random_configurations(50).reshape(5, 10, 6))
    assert found.distance.shape == (5, 10)
    gap = found.point_first - found.point_second
    np.testing.assert_allclose(gap, found.distance[..., None] * found.normal, atol=1e-8)
    names = {body.name for body in checker.bodies}
    assert set(found.first.ravel()) <= names
    assert set(found.second.ravel()) <= names | set(checker.scene.names)


@pytest.mark.capability("11-39")
def test_a_check_names_the_two_bodies_the_depth_and_the_place(tmp_path):
    robot = arm(tmp_path)
    tip = robot.forward_kinematics(np.zeros(6))[:3, 3]
    wall = Obstacle(Box((0.1, 1.0, 1.0)), tip + np.array([0.07, 0.0, 0.0]), "wall")
    answer = Checker(robot, [wall]).check(np.zeros(6))
    assert not answer
    assert answer.status is CheckStatus.COLLIDING
    assert {(each.first, each.second) for each in answer.contacts} >= {("link6", "wall")}
    depths = [each.distance for each in answer.contacts]
    assert depths == sorted(depths)
    assert "link6 hits wall by 10 mm at" in answer.explain("en")
    assert "wall" in answer.explain("ar")
    free = Checker(robot, [Obstacle(Sphere(0.1), (5.0, 0.0, 0.0), "far")]).check(np.zeros(6))
    assert free
    assert free.explain("en").startswith("collision-free")
    alone = Checker(robot, self_collision=False).check(np.zeros(6))
    assert alone.status is CheckStatus.ALONE


def test_the_arm_meets_itself(tmp_path):
    checker = Checker(arm(tmp_path))
    folded = np.array([0.0, 0.0, 2.8, 0.0, 1.5, 0.0])
    answer = checker.check(folded)
    assert not answer
    assert all(each.first.startswith("link") and each.second.startswith("link") for each in answer.contacts)
    pair = (answer.contacts[0].first, answer.contacts[0].second)
    fewer = Checker(checker.robot, skip=[pair])
    assert pair not in {(each.first, each.second) for each in fewer.check(folded).contacts}
    assert any(each.reason is SkipReason.LISTED for each in fewer.skipped)


def test_pairs_that_are_not_checked_have_their_reasons(tmp_path):
    robot = arm(tmp_path)
    srdf = tmp_path / "arm.srdf"
    srdf.write_text('<robot name="a"><disable_collisions link1="link1" link2="link3" reason="Never"/></robot>')
    checker = Checker(robot, srdf=srdf)
    reasons = {frozenset((each.first, each.second)): each.reason for each in checker.skipped}
    assert reasons[frozenset(("link1", "link2"))] is SkipReason.ADJACENT
    assert reasons[frozenset(("link1", "link3"))] is SkipReason.LISTED
    assert len(reasons) + len(checker.arm.pairs) == 21
    dropped = Checker(robot, skip_never_colliding=True)
    unseen = [each for each in dropped.skipped if each.reason is SkipReason.UNSEEN]
    assert len(dropped.arm.pairs) + len(unseen) <= len(Checker(robot).arm.pairs)


def test_pairs_that_always_meet_are_left_out(tmp_path):
    """Two links that a third, without a shape, keeps within each other."""
    text = (
        '<robot name="a"><link name="a"><collision><geometry><sphere radius="0.3"/></geometry></collision></link>'
        '<link name="b"/><link name="c"><collision><geometry><sphere radius="0.3"/></geometry></collision></link>'
        '<joint name="j1" type="revolute"><parent link="a"/><child link="b"/><axis xyz="0 0 1"/>'
        '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint>'
        '<joint name="j2" type="revolute"><parent link="b"/><child link="c"/><origin xyz="0.2 0 0"/><axis xyz="0 1 0"/>'
        '<limit lower="-1" upper="1" velocity="1" effort="1"/></joint></robot>'
    )
    path = tmp_path / "a.urdf"
    path.write_text(text)
    checker = Checker(str(path))
    assert [each.reason for each in checker.skipped] == [SkipReason.ALWAYS]
    assert checker.check(np.zeros(2))
    assert not Checker(str(path), samples=0).check(np.zeros(2))


def test_what_is_fixed_to_the_tip_moves_with_it(tmp_path):
    robot, q = arm(tmp_path), np.array([0.3, 0.4, -0.5, 0.2, 0.6, 0.1])
    stick = Obstacle(collision.Capsule(0.01, 0.3), (0.0, 0.0, 0.3), "stick")
    T = robot.forward_kinematics(q)
    ball = Obstacle(Sphere(0.05), (T @ [0.0, 0.0, 0.4, 1.0])[:3], "ball")
    assert not Checker(robot, [ball], attached=[stick]).check(q)
    first = Checker(robot, [ball], attached=[stick]).check(q).contacts[0]
    assert (first.first, first.second) == ("stick", "ball")
    assert Checker(robot, [ball]).check(q)


def test_an_arm_without_shapes_gets_capsules_or_says_so():
    bare = mf.Robot.from_dh([[0.4, 0.0, 0.1, 0.0], [0.3, 0.0, 0.0, 0.0]], "modified")
    with pytest.raises(mf.InputError, match="radius="):
        Checker(bare)
    checker = Checker(bare, [Obstacle(Plane(), (0.0, 0.0, -0.5))], radius=0.04)
    assert checker.check(np.zeros(2)).contacts


def test_another_scene_for_the_same_arm(tmp_path):
    checker = Checker(arm(tmp_path), scene(7))
    q = checker.random_configurations(100)
    other = checker.with_scene(scene(8))
    assert (other.in_collision(q) == Checker(checker.robot, scene(8)).in_collision(q)).all()
    assert other.arm is checker.arm


def test_wrong_input_is_named(tmp_path):
    checker = Checker(arm(tmp_path))
    with pytest.raises(mf.InputError, match="q"):
        checker.in_collision([0.0, float("nan"), 0.0, 0.0, 0.0, 0.0])
    with pytest.raises(mf.InputError, match="q"):
        checker.distance(np.zeros(5))
    with pytest.raises(mf.InputError, match="q"):
        checker.check(np.zeros((2, 6)))
    with pytest.raises(mf.InputError, match="clearance"):
        Checker(checker.robot, clearance=-1.0)
    with pytest.raises(mf.FileError, match="SRDF"):
        Checker(checker.robot, srdf=tmp_path / "none.srdf")
    assert checker.in_collision(np.zeros((0, 6))).shape == (0,)
    for wrong, words in ((("a", "b"), "no body or link 'a'"), ("ab", "not a pair")):
        with pytest.raises(mf.InputError, match=words):
            Checker(checker.robot, skip=[wrong])
    with pytest.raises(mf.InputError, match="attached: expected a list of obstacles"):
        Checker(checker.robot, attached=Obstacle(Sphere(0.1)))
    with pytest.raises(mf.InputError, match="half space"):
        Checker(checker.robot, attached=[Plane()])
    for within in (-1.0, float("nan"), "far"):
        with pytest.raises(mf.InputError, match="within"):
            checker.distance(np.zeros(6), within=within)


def test_links_that_are_only_drawn_are_named(tmp_path):
    """A maker drew all links and gave a collision shape to one: the others go through everything."""
    shape = "<geometry><sphere radius='0.1'/></geometry>"
    mass = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/></inertial>"
    links = f"<link name='a'><collision>{shape}</collision></link><link name='b'>{mass}<visual>{shape}</visual></link>"
    joint = "<joint name='j' type='continuous'><parent link='a'/><child link='b'/><origin xyz='1 0 0'/></joint>"
    path = tmp_path / "drawn.urdf"
    path.write_text(f"<robot name='r'>{links}{joint}</robot>", encoding="utf-8")
    checker = Checker(mf.load(path), [Obstacle(Sphere(0.2), (1.0, 0.0, 0.0), "ball")])
    assert checker.only_drawn == ("b",)
    assert checker.free([0.0])
    assert Checker(arm(tmp_path)).only_drawn == ()


def test_a_robot_without_joints_is_refused_in_words(tmp_path):
    robot = arm(tmp_path)
    still = Checker(robot.with_locked_joints(dict.fromkeys(robot.joint_names, 0.1)), scene(7))
    for ask in (still.in_collision, still.distance, still.check):
        with pytest.raises(mf.MafsilError, match="no moving joint"):
            ask(np.zeros(0))


def test_hulls_of_meshes_hold_every_vertex():
    """UR5 of example-robot-data: the hull contains the mesh, so what it calls free is free."""
    data = pytest.importorskip("cmeel").__path__[0]
    folder = Path(data).parent / "cmeel.prefix" / "share" / "example-robot-data" / "robots"
    file = folder / "ur_description" / "urdf" / "ur5_robot.urdf"
    if not file.exists():
        pytest.skip("example-robot-data is not installed")
    checker = Checker(str(file))
    assert checker.bodies[1].meshes
    for body in checker.bodies:
        hulls = [geometry for geometry, _ in body.shapes if isinstance(geometry, collision.ConvexHull)]
        for geometry, mesh in zip(hulls, body.meshes, strict=True):
            vertices = mesh_vertices(mesh)
            T = np.tile(np.eye(4), (len(vertices), 1, 1))
            T[:, :3, 3] = vertices
            assert collision.distance(Sphere(1e-9), geometry, T).distance.max() < 1e-9
    assert checker.check(np.zeros(6)).status in (CheckStatus.FREE, CheckStatus.COLLIDING)


def test_what_is_attached_may_come_nearer_than_the_margin(tmp_path):
    """Rounding below zero: the arm keeps the clearance, its box is free as long as it meets nothing by coal."""
    robot, half = arm(tmp_path), np.array([0.1, 0.15, 0.05])
    corners, around = half * np.array(list(product((-1.0, 1.0), repeat=3))), scene(3)
    box = Obstacle(collision.ConvexHull(corners, -0.05 * (1.0 - 1e-9)), name="box")
    settings = {"clearance": 0.05, "self_collision": False, "samples": 0}
    alone, checker = Checker(robot, around, **settings), Checker(robot, around, attached=[box], **settings)
    q = checker.random_configurations(300)
    q = q[alone.free(q)]
    free, tips = checker.free(q), robot.forward_kinematics(q)
    theirs = coal_shape(Box(tuple(2 * half)))
    away = [min(coal_distance(theirs, T, coal_shape(each.geometry), each.T_so) for each in around) for T in tips]
    np.testing.assert_array_equal(free, np.array(away) > 0.0)
    assert 0 < free.sum() < len(free)
    assert not checker.free(q)[np.array(away) < 0.0].any()
    assert (np.array(away)[free] < 0.05).any()
    proved = checker.free_segment(q[:-1], q[1:])
    for a, b in zip(q[:-1][proved][:5], q[1:][proved][:5], strict=True):
        states = robot.forward_kinematics(a + np.linspace(0.0, 1.0, 30)[:, None] * (b - a))
        assert all(
            coal_distance(theirs, T, coal_shape(each.geometry), each.T_so) > 0.0 for T in states for each in around
        )


@pytest.mark.capability("11-39")
@pytest.mark.parametrize("made", [arm, arm_of_many_pieces])
def test_bodies_of_the_arm_keep_a_margin_of_their_own(tmp_path, made):
    around, robot = scene(4), made(tmp_path)
    checker = Checker(robot, around, clearance=0.05, self_clearance=0.004)
    alone, outside = Checker(robot), Checker(robot, around, self_collision=False)
    q = checker.random_configurations(3000)
    far, apart = outside.distance(q).distance, alone.distance(q).distance
    expected = (far > 0.05) & (apart > 0.004)
    assert 0.05 < expected.mean() < 0.95
    assert (expected != ((far > 0.05) & (apart > 0.05))).any()
    assert (checker.free(q) == expected).all()
    assert (checker.distance(q).free == expected).all()
    assert [bool(checker.free(row)) for row in q[:200]] == expected[:200].tolist()
    assert [bool(checker.check(row)) for row in q[:200]] == expected[:200].tolist()
    still = np.array([bool(checker.free_segment(row, row)) for row in q[:200]])
    assert (still == expected[:200]).all()
    assert (checker.with_clearance(0.0).free(q) == ((far > 0.0) & (apart > 0.004))).all()
    assert (checker.with_clearance(own=0.0).free(q) == ((far > 0.05) & (apart > 0.0))).all()
    assert (checker.with_clearance(own=0.05).free(q) == ((far > 0.05) & (apart > 0.05))).all()
    unasked = Checker(robot, around, clearance=0.05)
    assert (unasked.free(q) == ((far > 0.05) & alone.with_clearance(0.05).free(q))).all()
    assert all(0.0 < kept < 0.05 for kept in unasked.always_near.values())


@pytest.mark.capability("11-39")
def test_a_margin_of_bodies_of_the_arm_that_is_none_is_refused(tmp_path):
    for wrong in (-0.1, np.nan, np.inf, "far"):
        with pytest.raises(mf.InputError, match="self_clearance"):
            Checker(arm(tmp_path), self_clearance=wrong)


@pytest.mark.capability("11-40")
def test_tables_of_fewer_pairs_are_those_of_an_arm_that_knows_nothing_yet():
    """Distances in cells that another choice of pairs has found already are used again."""
    ur5, other = (Checker("ur5e", radius=0.06) for _ in range(2))
    assert ur5.laid.clearances.table.max() >= 3
    fewer, fresh = (one.checking(range(len(one.bodies)), range(0, len(one.arm.pairs), 2)).laid for one in (ur5, other))
    for known, new in zip(fewer.clearances, fresh.clearances, strict=True):
        np.testing.assert_array_equal(known, new)
    assert fewer._nearest_in_cells is ur5.laid._nearest_in_cells
    assert 0 < len(fresh._nearest_in_cells) < len(fewer._nearest_in_cells)


@pytest.mark.capability("11-39")
def test_batches_on_two_threads_and_single_states_are_those_of_one_thread(tmp_path, monkeypatch):
    checker = Checker(arm(tmp_path), scene(2))
    q = checker.random_configurations(3000)
    monkeypatch.setenv(threads.THREADS_VARIABLE, "1")
    verdicts, near = checker.in_collision(q), checker.distance(q)
    monkeypatch.setenv(threads.THREADS_VARIABLE, "2")
    np.testing.assert_array_equal(checker.in_collision(q), verdicts)
    np.testing.assert_array_equal(checker.distance(q).gradient, near.gradient)
    for row, verdict in zip(q[:200], verdicts, strict=False):
        assert checker.in_collision(row) == verdict
        assert checker.free(row) != verdict
    for wrong in (np.nan, np.inf):
        with pytest.raises(mf.InputError, match="q"):
            checker.free(np.where(np.arange(q.shape[1]) == 2, wrong, q[0]))
