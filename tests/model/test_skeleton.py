"""A body made from kinematics."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from mafsil.model import Box, Capsule, Cylinder, Shape, Sphere, library
from mafsil.model.appearance import SHORTEST, reach, stand, with_skeleton
from mafsil.model.library import textbook


def drawn(name):
    return with_skeleton(library.load(name))


def ends(shape):
    """Both ends of a capsule, in the link frame."""
    half = shape.T_lg[:3, 2] * shape.geometry.length / 2
    return shape.T_lg[:3, 3] - half, shape.T_lg[:3, 3] + half


@pytest.mark.parametrize("name", library.robots())
def test_tubes_lead_from_each_joint_to_the_next_and_to_the_tip(name):
    robot = drawn(name)
    for k, link in enumerate(robot.links[1:]):
        target = robot.joints[k + 1].T_pj[:3, 3] if k + 1 < robot.n else robot.T_lt[:3, 3]
        bones = [shape for shape in link.visuals if isinstance(shape.geometry, Capsule)]
        points = [np.zeros(3), *(end for bone in bones for end in ends(bone)), target]
        gap = 3 * SHORTEST * max((bone.geometry.radius for bone in bones), default=reach(robot))
        assert all(np.linalg.norm(end - start) <= gap for start, end in list(pairwise(points))[::2])


@pytest.mark.parametrize("name", library.robots())
def test_every_pose_of_a_shape_is_a_pose(name):
    for link in drawn(name).links:
        for shape in link.visuals:
            R = shape.T_lg[:3, :3]
            np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
            assert np.linalg.det(R) == pytest.approx(1)


def test_marks_show_the_kind_of_the_joint_and_the_tip():
    robot = drawn("rrprrr")
    marks = [shape.geometry for link in robot.links for shape in link.visuals if shape.name == "joint"]
    assert [isinstance(mark, Box) for mark in marks] == [False, False, True, False, False, False]
    assert all(isinstance(mark, Cylinder | Box) for mark in marks)
    assert isinstance(robot.links[-1].visuals[-1].geometry, Sphere)


def test_links_with_shapes_keep_them():
    arm = textbook.planar2r()
    own = (Shape(Sphere(0.3)),)
    grown = with_skeleton(replace(arm, links=(arm.links[0], replace(arm.links[1], visuals=own), arm.links[2])))
    assert grown.links[1].visuals is own
    assert grown.links[2].visuals


def test_the_thickness_scales_with_the_arm():
    def radius(arm):
        return next(s.geometry.radius for s in arm.links[1].visuals if isinstance(s.geometry, Capsule))

    small, large = (with_skeleton(textbook.planar2r((length, length))) for length in (0.1, 1.0))
    assert radius(large) == pytest.approx(10 * radius(small))


def test_a_slide_stays_connected_over_its_travel():
    boom = drawn("stanford_arm").links[3]
    rod = next(shape for shape in boom.visuals if shape.name == "rod")
    assert rod.geometry.length == pytest.approx(50 * 0.0254)
    np.testing.assert_allclose(rod.T_lg[:3, 3] + rod.T_lg[:3, 2] * rod.geometry.length / 2, 0, atol=1e-15)


def test_a_base_above_the_floor_stands_on_a_column():
    arm = library.load("ur5e")
    assert stand(arm, 0.0, 0.0) == ()
    column, foot = stand(arm, 0.0, -0.7)
    assert column.geometry.length == pytest.approx(0.7)
    assert column.T_lg[2, 3] == pytest.approx(-0.35)
    assert foot.T_lg[2, 3] - foot.geometry.length / 2 == pytest.approx(-0.7)
