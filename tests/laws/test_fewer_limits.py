"""Taking a limit away never makes a motion slower or impossible."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.trajectory import (
    JointPath,
    MotionLimits,
    cartesian_line,
    compare_routes,
    jerk_limited,
    joint_motion,
    line_path,
    time_optimal,
)
from mafsil.trajectory.motion import PlanStatus
from tests.sizes import size

NUMBERS = 1e-4
"""Relative difference of two timings that settle by repeated linearisation."""


def with_viscous(name: str, viscous: float) -> mf.Robot:
    mechanism = mf.load(name).mechanism
    friction = mf.model.Friction(viscous=viscous)
    return mf.Robot(
        replace(
            mechanism,
            joints=tuple(replace(each, friction=friction) if each.moves else each for each in mechanism.joints),
        )
    )


@pytest.mark.parametrize("viscous", [0.1, 5.0])
def test_efforts_with_viscous_friction_and_ever_looser_velocities(viscous):
    arm, path = with_viscous("planar2r", viscous), JointPath.through([[0.0, 0.0], [1.0, 0.7]])
    durations = [
        time_optimal(path, MotionLimits.of(2, velocity=v, effort=[40.0, 20.0]), robot=arm).duration
        for v in (1.0, 3.0, 30.0, 1e4, np.inf)
    ]
    assert np.isfinite(durations).all()
    assert (np.diff(durations) <= NUMBERS * durations[0]).all()


def test_each_limit_of_random_motions_taken_away():
    rng = np.random.default_rng(5)
    arm = with_viscous("planar2r", 2.0)
    for _ in range(3):
        path = JointPath.through(rng.uniform(-1.0, 1.0, (3, 2)), "spline")
        given = {
            "velocity": rng.uniform(0.5, 5.0, 2),
            "acceleration": rng.uniform(1.0, 30.0, 2),
            "effort": [60.0, 30.0],
        }
        whole = time_optimal(path, MotionLimits.of(2, **given), robot=arm)
        for name in given:
            fewer = {key: value for key, value in given.items() if key != name}
            assert time_optimal(path, MotionLimits.of(2, **fewer), robot=arm).duration <= whole.duration * (1 + NUMBERS)


def test_jerk_limited_without_velocity_or_acceleration_limits():
    rng = np.random.default_rng(6)
    for _ in range(50):
        start, goal = rng.normal(size=(2, 3))
        given = {"velocity": rng.uniform(0.1, 2.0, 3), "acceleration": rng.uniform(0.1, 5.0, 3), "jerk": 10.0}
        whole = jerk_limited(start, goal, MotionLimits.of(3, **given))
        for name in ("velocity", "acceleration"):
            fewer = {key: value for key, value in given.items() if key != name}
            assert jerk_limited(start, goal, MotionLimits.of(3, **fewer)).duration <= whole.duration * (1 + 1e-9)


ARMS = [("planar3r", 3), ("ur5e", 6), ("iiwa7", 7), ("panda", 7)]


@pytest.mark.parametrize(("name", "n"), ARMS)
def test_routes_of_the_tip_that_have_to_keep_to_less(name, n):
    """What is followed as a pose is followed as axis and as position, and as fast; without its limits, too."""
    robot, rng = mf.load(name), np.random.default_rng(7)
    bounded = mf.Robot(
        replace(
            robot.mechanism,
            joints=tuple(
                replace(each, limits=replace(each.limits, velocity=1.0)) if each.moves else each
                for each in robot.mechanism.joints
            ),
        )
    )
    middle = (np.clip(robot.limits.lower, -3.0, 3.0) + np.clip(robot.limits.upper, -3.0, 3.0)) / 2
    followed = 0
    for _ in range(size(2, 4)):
        q = middle + rng.uniform(-0.8, 0.8, n)
        goal = robot.forward_kinematics(q + rng.uniform(-0.3, 0.3, n))
        found = [cartesian_line(bounded, q, goal, task=task) for task in ("pose", "axis", "position")]
        for less, more in zip(found[1:], found[:-1], strict=True):
            assert less or not more
            if more:
                followed += 1
                assert less.value.duration <= more.value.duration * (1 + NUMBERS)
        motions = [
            joint_motion(bounded, line_path(robot.forward_kinematics(q), goal), q, 2.0, rate=20.0, task=task)
            for task in ("pose", "position")
        ]
        assert motions[1] or not motions[0]
        compared = [compare_routes(bounded, q, q + 0.1, 0.5, rate=20.0, task=task) for task in ("pose", "position")]
        assert compared[1] or not compared[0]
    assert followed > 1


def test_position_limits_of_routes_taken_away():
    robot, rng = mf.load("ur5e"), np.random.default_rng(8)
    free = mf.Robot(
        replace(
            robot.mechanism,
            joints=tuple(
                replace(each, limits=replace(each.limits, lower=-np.inf, upper=np.inf)) if each.moves else each
                for each in robot.mechanism.joints
            ),
        )
    )
    for _ in range(5):
        q = rng.uniform(-3.0, 3.0, 6)
        goal = robot.forward_kinematics(q + rng.uniform(-0.4, 0.4, 6))
        for task in ("pose", "position"):
            tight = cartesian_line(robot, q, goal, task=task)
            loose = cartesian_line(free, q, goal, task=task)
            assert loose or not tight
            assert not tight or loose.value.duration <= tight.value.duration * (1 + NUMBERS)


def test_an_arm_of_the_plane_is_led_along_a_line():
    """Its orientation cannot follow; that is said, and the position can."""
    robot, q = mf.load("planar2r"), np.array([0.3, 0.8])
    start = robot.forward_kinematics(q)
    goal = start.copy()
    goal[:3, 3] += [-0.4, 0.2, 0.0]
    refused = cartesian_line(robot, q, goal, duration=2.0)
    assert refused.status is PlanStatus.ORIENTATION_NOT_FOUND
    assert "was found" in refused.explain("en")
    assert refused.explain("ar") != refused.explain("en")
    path = line_path(start, goal)
    motion = cartesian_line(robot, q, goal, duration=2.0, task="position").value
    rates = joint_motion(robot, path, q, 2.0, rate=50.0, law="quintic", task="position")
    assert motion is not None
    assert rates
    np.testing.assert_allclose(rates.q, motion.at(rates.times).u, atol=1e-6)
    np.testing.assert_allclose(rates.qd, motion.at(rates.times).v, atol=1e-4)
    np.testing.assert_allclose(rates.qdd, motion.at(rates.times).a, atol=1e-2)
    places = robot.forward_kinematics(rates.q)[:, :3, 3]
    across = np.cross(places - start[:3, 3], (goal - start)[:3, 3])
    assert np.abs(across).max() < 1e-8
    routes = compare_routes(robot, q, q + np.array([0.2, -0.3]), 1.0, rate=200.0, task="position")
    assert routes
    assert routes.routes[1].off_chord < 1e-6
    assert not compare_routes(robot, q, q + np.array([0.2, -0.3]), 1.0, rate=200.0)
    with pytest.raises(mf.InputError, match="task"):
        cartesian_line(robot, q, goal, duration=2.0, task="place")
    with pytest.raises(mf.InputError, match="task"):
        joint_motion(robot, path, q, 2.0, task="axis")
