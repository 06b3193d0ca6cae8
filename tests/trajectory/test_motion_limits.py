"""Bounds of a motion: from numbers, pairs and robots, and what they refuse."""

from __future__ import annotations

import numpy as np
import pytest
from numpy.testing import assert_array_equal

import mafsil as mf
from mafsil.errors import InputError
from mafsil.trajectory import MotionLimits
from mafsil.trajectory.motion_limits import motion_limits


def test_a_magnitude_holds_in_both_directions_and_a_pair_on_each_side():
    limits = MotionLimits.of(2, velocity=[1.0, 2.0], acceleration=(0.0, [3.0, 4.0]))
    assert_array_equal(limits.velocity, [[-1.0, -2.0], [1.0, 2.0]])
    assert_array_equal(limits.acceleration, [[0.0, 0.0], [3.0, 4.0]])
    assert np.isinf(limits.jerk).all()
    assert limits.n == 2
    again = MotionLimits.of(2, velocity=limits.velocity, acceleration=limits.acceleration)
    assert_array_equal(again.velocity, limits.velocity)
    assert_array_equal(again.acceleration, limits.acceleration)


def test_the_limits_of_a_robot_are_taken_as_they_are():
    robot = mf.load("panda")
    for given in (robot, robot.limits, MotionLimits.of_joints(robot.limits)):
        limits = motion_limits(given, robot.n)
        assert_array_equal(limits.velocity[1], robot.limits.velocity)
        assert_array_equal(limits.position, [robot.limits.lower, robot.limits.upper])


@pytest.mark.parametrize(
    ("given", "says"),
    [
        ({"velocity": np.nan}, "velocity"),
        ({"velocity": -1.0}, "velocity"),
        ({"acceleration": (0.5, 1.0)}, "zero must lie between"),
        ({"position": (1.0, -1.0)}, "position"),
        ({"jerk": [1.0, 2.0, 3.0]}, r"\(2,\)"),
    ],
)
def test_bounds_that_no_motion_keeps_are_refused_by_name(given, says):
    with pytest.raises(InputError, match=says):
        MotionLimits.of(2, **given)


def test_limits_of_another_size_or_kind_are_refused():
    with pytest.raises(InputError, match="limits"):
        motion_limits(MotionLimits.of(3), 2)
    with pytest.raises(InputError, match="MotionLimits, JointLimits or Robot"):
        motion_limits(7.0, 2)
