"""Every arm of the library has shapes: free at rest, flat at the flange, replaced by a radius, near to real meshes."""

from __future__ import annotations

import sysconfig
from pathlib import Path

import numpy as np
import pytest

import mafsil as mf
from mafsil.collision import Box, Checker, Obstacle
from mafsil.job.planning.resting import resting_place, starting_place
from mafsil.model import Capsule, Cylinder, Mesh, library, mesh
from mafsil.model.link import OUTLINE
from tests.sizes import few

DATA = Path(sysconfig.get_paths()["purelib"]) / "cmeel.prefix/share/example-robot-data/robots"
BOX = Obstacle(Box((0.05, 0.05, 0.05)), (0.0, 0.0, 5.0), "box")


@pytest.mark.parametrize("name", few(library.robots(), 8))
def test_every_arm_has_shapes_with_a_source_and_is_free_at_rest(name):
    robot = mf.load(name)
    shapes = [shape for link in robot.mechanism.links for shape in link.collisions]
    assert shapes
    assert {shape.name for shape in shapes} == {OUTLINE}
    assert sum(note.startswith("collision shapes: ") for note in robot.mechanism.provenance.notes) == 1
    for clearance in (0.0, 0.02):
        checker = Checker(robot, clearance=clearance)
        assert checker.free(checker.zero)
        assert checker.free(resting_place(robot.limits))
        assert checker.free(starting_place(robot))
        assert checker.free(checker.random_configurations(500)).mean() > 0.6


@pytest.mark.parametrize("name", few(library.robots(), 8))
def test_the_last_link_ends_flat_at_the_tip(name):
    """Nothing of it is beyond the plane across its last piece through the tip, so that a tip may touch something."""
    mechanism = library.load(name)
    pieces = mechanism.links[-1].collisions
    if name == "rrrp":
        assert not pieces  # A rod that slides in nothing.
        return
    tip = mechanism.T_lt[:3, 3]
    (drum,) = (one for one in pieces if isinstance(one.geometry, Cylinder))
    ends = [drum.T_lg[:3, 3] + side * drum.geometry.length / 2.0 * drum.T_lg[:3, 2] for side in (-1.0, 1.0)]
    assert min(np.linalg.norm(end - tip) for end in ends) < 1e-9
    outward = tip - drum.T_lg[:3, 3]
    outward /= np.linalg.norm(outward)
    for one in pieces:
        if isinstance(one.geometry, Capsule):
            reach = abs(outward @ one.T_lg[:3, 2]) * one.geometry.length / 2.0 + one.geometry.radius
            assert outward @ (one.T_lg[:3, 3] - tip) + reach <= 0.0


@pytest.mark.parametrize("name", ["ur10e", "panda", "cobra600", "planar3r", "elbow6r"])
def test_an_arm_plans_without_a_radius(name):
    robot = mf.load(name)
    start = starting_place(robot)
    goal = np.minimum(start + 0.1, robot.limits.upper)
    plan = mf.plan(robot, [BOX], start, goal)
    assert plan
    assert plan.to_dict()["unchecked"] == []


def test_a_radius_replaces_the_shapes():
    thin, own = Checker("ur5e", radius=0.01), Checker("ur5e")
    assert {shape.radius for body in thin.bodies for shape, _ in body.shapes} == {0.01}
    assert {shape.radius for body in own.bodies for shape, _ in body.shapes} > {0.06}
    q = own.random_configurations(500)
    assert thin.in_collision(q).mean() < own.in_collision(q).mean()


def test_dimensions_carry_the_shapes_along():
    small, large = (library.load("planar2r", lengths=(a, a)) for a in (0.3, 1.5))
    for arm, length in ((small, 0.3), (large, 1.5)):
        assert arm.links[1].collisions[0].geometry.length == pytest.approx(length)
        assert arm.links[1].collisions[0].geometry.radius == pytest.approx(0.02 * length)


UR = ("base_link", "shoulder_link", "upper_arm_link", "forearm_link", "wrist_1_link", "wrist_2_link", "wrist_3_link")
FILES = {
    "ur5": ("ur_description/urdf/ur5_robot.urdf", UR, np.diag([-1.0, -1.0, 1.0, 1.0])),
    "panda": ("panda_description/urdf/panda.urdf", tuple(f"panda_link{k}" for k in range(8)), np.eye(4)),
}
"""File, links in our order, pose of its base in ours."""


@pytest.mark.filterwarnings("ignore::mafsil.errors.ModelWarning")
@pytest.mark.parametrize(("name", "missed", "alarms"), [("ur5", 0.05, 0.05), ("panda", 0.12, 0.01)])
def test_meetings_are_those_of_the_makers_meshes(name, missed, alarms):
    """Of what meets by the meshes that the maker draws few are missed, and few of the free ones are alarms."""
    coal = pytest.importorskip("coal")
    if not DATA.is_dir():
        pytest.skip("example-robot-data is not installed")
    ours, surfaces = mf.load(name), _surfaces(name)
    low, high = np.maximum(ours.limits.lower, -np.pi), np.minimum(ours.limits.upper, np.pi)
    q = np.random.default_rng(78).uniform(low, high, (1500, ours.n))
    poses = np.asarray(ours.link_poses(q))
    bodies = [_tree(coal, one) for one in surfaces]
    pairs = [(a, b) for a in range(len(bodies)) for b in range(a + 2, len(bodies))]
    truth = np.array([_meets(coal, bodies, pairs, row) for row in poses])
    found = Checker(ours).in_collision(q)
    assert 0.01 < truth.mean() < 0.5
    assert (truth & ~found).sum() <= missed * truth.sum()
    assert (~truth & found).sum() <= alarms * (~truth).sum()


def _surfaces(name):
    """For each link vertices in our link frame, and triangles."""
    path, links, base = FILES[name]
    ours, theirs = mf.load(name), mf.load(DATA / path)
    q = np.full(ours.n, 0.3)
    own = np.asarray(ours.link_poses(q))
    other = np.asarray(theirs.link_poses(np.concatenate([q, np.zeros(theirs.n - ours.n)])))
    found = []
    for k, link in enumerate(links):
        index = theirs.mechanism.link_names.index(link)
        T = np.linalg.inv(own[k]) @ base @ other[index]
        parts = []
        for one in theirs.mechanism.links[index].visuals:
            assert isinstance(one.geometry, Mesh)
            surface, X = mesh.read(one.geometry.path).scale(one.geometry.scale), T @ one.T_lg
            parts.append((surface.vertices @ X[:3, :3].T + X[:3, 3], surface.faces))
        found.append(parts)
    return found


def _tree(coal, parts):
    tree = coal.BVHModelOBBRSS()
    tree.beginModel(sum(len(faces) for _, faces in parts), sum(len(vertices) for vertices, _ in parts))
    for vertices, faces in parts:
        points, triangles = coal.StdVec_Vec3s(), coal.StdVec_Triangle()
        points.extend(list(vertices))
        triangles.extend([coal.Triangle(*map(int, face)) for face in faces])
        tree.addSubModel(points, triangles)
    tree.endModel()
    return tree


def _meets(coal, bodies, pairs, poses):
    places = [coal.Transform3s(np.array(T[:3, :3]), np.array(T[:3, 3])) for T in poses]
    request = coal.CollisionRequest()
    return any(
        coal.collide(bodies[a], places[a], bodies[b], places[b], request, coal.CollisionResult()) for a, b in pairs
    )


def test_an_exported_arm_fills_the_same_space(tmp_path):
    """Readers of URDF know cylinders and balls, not capsules: a tube is written as both."""
    file = tmp_path / "ur5.urdf"
    file.write_text(mf.model.urdf.write(mf.load("ur5"), without=["limits"]))
    assert "<capsule" not in file.read_text()
    q = Checker("ur5").random_configurations(300)
    assert (Checker(file, [BOX]).in_collision(q) == Checker("ur5", [BOX]).in_collision(q)).all()
