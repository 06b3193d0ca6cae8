"""What is drawn of a robot: its own shapes, surfaces within a budget, else tubes and housings."""

import struct
from dataclasses import replace

import numpy as np
import pytest

from mafsil.model import Box, Capsule, Cylinder, Link, Mesh, Shape, Sphere, library
from mafsil.model.appearance import corners, part_of, pieces, with_skeleton
from mafsil.model.mesh import Surface
from mafsil.model.mesh.surface import triangles


def write_stl(path, surface):
    facets = surface.vertices[surface.faces].astype("<f4")
    body = b"".join(struct.pack("<3f", 0, 0, 0) + facet.tobytes() + b"\0\0" for facet in facets)
    path.write_bytes(b"\0" * 80 + struct.pack("<I", len(facets)) + body)


def dressed(shape):
    arm = library.load("planar3r")
    return replace(arm, links=tuple(replace(link, visuals=(shape,)) for link in arm.links))


def surfaces(mechanism, most=10_000):
    return [p.geometry for link in pieces(mechanism, most) for p in link if isinstance(p.geometry, Surface)]


@pytest.mark.parametrize("name", library.robots())
def test_robots_of_the_library_show_what_they_collide_with(name):
    arm = library.load(name)
    for drawn, link in zip(pieces(arm), arm.links, strict=True):
        assert {id(shape.geometry) for shape in link.collisions} <= {id(piece.geometry) for piece in drawn}


@pytest.mark.parametrize("name", library.robots())
def test_robots_of_numbers_get_the_skeleton(name):
    arm = library.load(name)
    bare = replace(arm, links=tuple(replace(link, collisions=()) for link in arm.links))
    grown = with_skeleton(bare)
    for drawn, link in zip(pieces(bare), grown.links, strict=True):
        assert [piece.geometry for piece in drawn] == [shape.geometry for shape in link.visuals]


def test_surfaces_are_drawn_and_keep_to_the_budget(tmp_path):
    write_stl(tmp_path / "a.stl", triangles(Sphere(0.1)))
    count = len(triangles(Sphere(0.1)).faces)
    mechanism = dressed(Shape(Mesh("a.stl", tmp_path / "a.stl")))
    assert [len(surface.faces) for surface in surfaces(mechanism)] == [count] * 4
    assert sum(len(surface.faces) for surface in surfaces(mechanism, count)) <= count


def test_scale_of_a_surface_is_kept(tmp_path):
    write_stl(tmp_path / "a.stl", triangles(Box((1.0, 1.0, 1.0))))
    found = surfaces(dressed(Shape(Mesh("a.stl", tmp_path / "a.stl", (0.001, 0.002, 0.003)))))[0]
    np.testing.assert_allclose(np.ptp(found.vertices, axis=0), (0.001, 0.002, 0.003), rtol=1e-6)


@pytest.mark.parametrize("content", [None, b"", b"solid nothing", b"\0" * 80 + struct.pack("<I", 10**9), b"v nan"])
def test_surfaces_that_cannot_be_read_are_replaced_by_the_skeleton(tmp_path, content):
    path = tmp_path / "a.stl"
    if content is not None:
        path.write_bytes(content)
    drawn = pieces(dressed(Shape(Mesh("a.stl", path))))
    assert all(drawn)
    assert any(isinstance(piece.geometry, Capsule) for link in drawn for piece in link)


def test_what_collides_is_drawn_when_what_is_seen_is_not_found():
    arm = library.load("planar3r")
    missing, ball = Shape(Mesh("lost.stl")), Shape(Sphere(0.1))
    links = tuple(Link(link.name, link.inertial, (missing,), (ball,)) for link in arm.links)
    assert [link[0].geometry for link in pieces(replace(arm, links=links))] == [Sphere(0.1)] * 4


def test_a_tool_without_a_shape_gets_a_tube():
    arm = dressed(Shape(Sphere(0.05)))
    T = np.eye(4)
    T[2, 3] = 0.4
    tip = pieces(arm.with_tip(arm.tip, T))[-1]
    assert isinstance(tip[-1].geometry, Cylinder)
    assert tip[-1].geometry.length == pytest.approx(0.4)


def test_boxes_hold_their_pieces():
    for link in pieces(library.load("stanford_arm")):
        for piece in link:
            points = triangles(piece.geometry).vertices @ piece.T_lg[:3, :3].T + piece.T_lg[:3, 3]
            box = corners(piece)
            # A box turned with the piece: compare in the piece's own frame.
            local_box, local = ((x - piece.T_lg[:3, 3]) @ piece.T_lg[:3, :3] for x in (box, points))
            assert (local.max(axis=0) <= local_box.max(axis=0) + 1e-9).all()
            assert (local.min(axis=0) >= local_box.min(axis=0) - 1e-9).all()


def test_links_joined_by_fixed_joints_are_one_part():
    panda = library.load("panda")
    heads = part_of(panda)
    assert heads[0] == 0
    assert len(set(heads)) == 1 + sum(joint.moves for joint in panda.joints)
