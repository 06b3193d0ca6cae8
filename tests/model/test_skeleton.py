"""Shapes made from kinematics."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from mafsil.model import Box, Capsule, Cylinder, Shape, Sphere, library
from mafsil.model.library import planar
from mafsil.model.skeleton import with_skeleton


def ends(shape):
    """Both ends of a capsule, in the link frame."""
    half = shape.T_lg[:3, 2] * shape.geometry.length / 2
    return shape.T_lg[:3, 3] - half, shape.T_lg[:3, 3] + half


@pytest.mark.parametrize("name", library.names())
def test_bones_lead_from_each_joint_to_the_next_and_to_the_tip(name):
    robot = library.load(name)
    for k, link in enumerate(robot.links[1:]):
        target = robot.joints[k + 1].T_pj[:3, 3] if k + 1 < robot.n else robot.T_lt[:3, 3]
        bones = [ends(shape) for shape in link.visuals if isinstance(shape.geometry, Capsule)]
        if np.linalg.norm(target) < 1e-9:
            assert not bones
            continue
        np.testing.assert_allclose(bones[0][0], 0, atol=1e-12)
        np.testing.assert_allclose(bones[-1][1], target, atol=1e-12)
        for before, after in pairwise(bones):
            np.testing.assert_allclose(before[1], after[0], atol=1e-12)


@pytest.mark.parametrize("name", library.names())
def test_every_pose_of_a_shape_is_a_pose(name):
    for link in library.load(name).links:
        for shape in link.visuals:
            R = shape.T_lg[:3, :3]
            np.testing.assert_allclose(R @ R.T, np.eye(3), atol=1e-12)
            assert np.linalg.det(R) == pytest.approx(1)


def test_marks_show_the_kind_of_the_joint_and_the_tip():
    robot = library.load("rrprrr")
    marks = [next(s for s in link.visuals if s.name == "joint").geometry for link in robot.links[1:]]
    assert [isinstance(mark, Box) for mark in marks] == [False, False, True, False, False, False]
    assert all(isinstance(mark, Cylinder | Box) for mark in marks)
    assert isinstance(robot.links[-1].visuals[-1].geometry, Sphere)


def test_links_with_shapes_keep_them():
    arm = planar.planar2r()
    own = (Shape(Sphere(0.3)),)
    drawn = with_skeleton(replace(arm, links=(arm.links[0], replace(arm.links[1], visuals=own), arm.links[2])))
    assert drawn.links[1].visuals is own
    assert drawn.links[2].visuals


def test_the_radius_can_be_chosen_and_scales_with_the_arm():
    def radius(arm):
        return next(s.geometry.radius for s in arm.links[1].visuals if isinstance(s.geometry, Capsule))

    assert radius(with_skeleton(planar.planar2r(), radius=0.01)) == 0.01
    small, large = (with_skeleton(planar.planar2r((length, length))) for length in (0.1, 1.0))
    assert radius(large) == pytest.approx(10 * radius(small))


def test_a_slide_stays_connected_over_its_travel():
    boom = library.load("stanford_arm").links[3]
    rod = next(shape for shape in boom.visuals if shape.name == "rod")
    assert rod.geometry.length == pytest.approx(50 * 0.0254)
    np.testing.assert_allclose(rod.T_lg[:3, 3] + rod.T_lg[:3, 2] * rod.geometry.length / 2, 0, atol=1e-15)
