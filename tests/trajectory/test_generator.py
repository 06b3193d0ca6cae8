"""The generator gives the trajectory tick by tick, allocates nothing, and measures itself; both routes side by side."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.trajectory import (
    TrajectoryGenerator,
    bspline_through,
    compare_routes,
    cubic_through,
    linear_blends,
    quintic,
)
from mafsil.trajectory.motion import TickStatus
from mafsil.trajectory.paths import CartesianPath
from mafsil.trajectory.paths.routes import TipMotion
from mafsil.trajectory.profiles import LAWS

POINTS, H = np.random.default_rng(2).normal(size=(5, 3)), [1.0, 0.5, 0.7, 1.1]


@pytest.mark.capability("11-35", "11-36", "11-37")
@pytest.mark.parametrize(
    "motion",
    [
        cubic_through(POINTS, H),
        quintic(POINTS[0], POINTS[1], 1.234),
        linear_blends(POINTS, H, acceleration=60.0).trajectory,
        bspline_through(POINTS, H),
        LAWS["cycloid"].between(POINTS[0], POINTS[1], 0.9),
    ],
    ids=["cubic", "quintic", "blends", "bspline", "cycloid"],
)
def test_ticks_are_the_motion_at_their_times(motion):
    generator = TrajectoryGenerator(motion, 317.0)
    t = np.arange(generator.ticks) / 317.0
    assert t[-1] <= motion.duration < t[-1] + 1 / 317.0 + 1e-12
    ticks = [tuple(x.copy() for x in each) for each in generator]
    for ours, expected in zip(zip(*ticks, strict=True), motion.at(t), strict=True):
        np.testing.assert_allclose(ours, expected, atol=1e-9 * (1 + np.abs(expected).max()))
    after = generator.tick()
    np.testing.assert_allclose(after.u, motion.at(motion.duration).u, atol=1e-12)
    np.testing.assert_array_equal([after.v, after.a], 0.0)
    report = generator.report()
    assert report.ticks == generator.ticks + 1
    steps = np.abs(np.diff([tick[0] for tick in ticks], axis=0)).max()
    np.testing.assert_allclose(report.largest_step, max(steps, np.abs(after.u - ticks[-1][0]).max()), rtol=1e-9)
    generator.restart()
    np.testing.assert_allclose(generator.tick().u, motion.at(0.0).u, atol=1e-12)


@pytest.mark.capability("11-37")
def test_every_tick_knows_whether_it_is_in_a_blend():
    plan = linear_blends(POINTS, H, acceleration=60.0)
    generator = TrajectoryGenerator(plan.trajectory, 1000.0)
    for k, _ in enumerate(generator):
        np.testing.assert_array_equal(generator.blending, plan.trajectory.blending(k / 1000.0))
    generator.tick()
    assert generator.piece == -1
    assert not generator.blending.any()


@pytest.mark.capability("11-35")
def test_a_tick_makes_no_array():
    generator = TrajectoryGenerator(cubic_through(POINTS, H), 1000.0)
    first = generator.tick()
    for _ in range(100):
        generator.tick()
    tracemalloc.start()
    before = tracemalloc.get_traced_memory()[0]
    for _ in range(500):
        last = generator.tick()
    grown, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert last.u is first.u
    assert grown - before < 2000
    assert peak - before < 4000


@pytest.mark.capability("11-49")
def test_overruns_are_measured_and_said():
    motion = cubic_through(POINTS, H)
    slow = TrajectoryGenerator(motion, 1e9)
    for _ in range(50):
        slow.tick()
    assert slow.report().status is TickStatus.OVERRUN
    assert slow.report().overruns == 50
    assert not slow.report()
    fast = TrajectoryGenerator(motion, 10.0)
    for _ in fast:
        pass
    assert fast.report()
    assert 0.0 < fast.report().mean <= fast.report().worst < 0.1
    for language in ("en", "ar"):
        assert slow.report().explain(language) != fast.report().explain(language)
    for wrong in ((motion, 0.0), (motion, np.nan), (3.0, 100.0), (cubic_through(np.zeros((4, 3, 2)), 1.0), 100.0)):
        with pytest.raises(InputError):
            TrajectoryGenerator(*wrong)


@pytest.mark.capability("11-6", "11-8", "11-49")
def test_both_routes_side_by_side():
    robot = mf.load("puma560")
    q = np.array([0.1, -0.6, 0.4, 0.2, 0.7, 0.3])
    both = compare_routes(robot, q, q + np.array([0.4, 0.2, -0.1, 0.3, 0.1, 0.2]), 0.5, rate=200.0)
    assert both
    joints, line = both.routes
    assert line.off_chord < 1e-9 < joints.off_chord
    assert line.ticks.mean > joints.ticks.mean
    assert line.ticks.largest_step > 0.0
    for language in ("en", "ar"):
        assert len(both.explain(language).splitlines()) == 4
    # To the other side of a singularity there is no straight line in reach, but a way in joints.
    far = compare_routes(robot, q, [2.9, -0.6, 0.4, 0.2, 0.7, 0.3], 0.5, rate=50.0)
    assert len(far) == (2 if far else 1)


@pytest.mark.capability("11-6")
def test_the_tip_leaves_the_chord_as_the_specification_says():
    # Planar 2R, lengths 1 and 0.8, from (0.3, 0.8) to the point (0.6, 1.2): 0.070646 off a chord of 0.74331.
    home = np.eye(4)
    home[0, 3] = 1.8
    robot = mf.Robot.from_screws([[0, 0, 1, 0, 0, 0], [0, 0, 1, 0, -1, 0]], home)
    target = np.array([0.6, 1.2])
    elbow = np.arccos((target @ target - 1.64) / 1.6)
    goal = [np.arctan2(*target[::-1]) - np.arctan2(0.8 * np.sin(elbow), 1 + 0.8 * np.cos(elbow)), elbow]
    both = compare_routes(robot, [0.3, 0.8], goal, 1.0, rate=5000.0)
    np.testing.assert_allclose(both.routes[0].off_chord, 0.070646, atol=2e-6)


@pytest.mark.capability("11-8")
def test_rates_along_the_line_are_derivatives_of_the_configuration():
    robot = mf.load("ur5e")
    q = np.array([0.1, -1.2, 1.4, 0.2, 0.7, 0.3])
    path = CartesianPath(robot.forward_kinematics(q), robot.forward_kinematics(q + 0.1))
    motion = TipMotion(robot, path, quintic([0.0], [1.0], 1.0), q)
    for t in np.linspace(0.0, 0.3, 200):
        motion.at(t)
    h = 1e-4
    u, v, a = motion.at(0.3 + h * np.arange(5))
    np.testing.assert_allclose((u[3] - u[1]) / (2 * h), v[2], atol=1e-7)
    np.testing.assert_allclose((v[3] - v[1]) / (2 * h), a[2], atol=1e-5)
