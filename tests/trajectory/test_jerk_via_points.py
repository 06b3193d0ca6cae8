"""Jerk-limited motions through via points: all passed, limits kept, never longer than with stops, nearly shortest."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import differential_evolution

from mafsil.errors import InputError
from mafsil.trajectory import MotionLimits, Trajectory, jerk_limited, jerk_limited_through
from mafsil.trajectory.jerk import ViaMotion
from mafsil.trajectory.jerk.plan_loops import next_of, shortest_of
from mafsil.trajectory.jerk.problem import JerkStatus, packed_limits
from tests.budget import within
from tests.reliability.jerk_limited import random_problems
from tests.reliability.jerk_via_points import excess_through, random_vias


def single(points, limits, **named) -> ViaMotion:
    motion = jerk_limited_through(points, limits, **named)
    assert isinstance(motion, ViaMotion)
    return motion


@pytest.mark.parametrize(("m", "n"), [(3, 1), (4, 2), (6, 3)])
def test_all_points_are_passed_within_the_limits(m: int, n: int):
    points, limits = random_vias(np.random.default_rng(m), 5, m, n)
    for row in points:
        motion = single(row, limits)
        assert isinstance(motion, Trajectory)
        assert motion
        assert motion.duration <= motion.stops
        passed = motion.at(motion.passing)
        np.testing.assert_allclose(passed.u, row, atol=1e-9)
        np.testing.assert_allclose(passed.v[1:-1], motion.velocities[1:-1], atol=1e-9)
        assert excess_through(motion) < 1e-9
        assert motion.motion.residual() < 1e-9


def test_nearly_the_shortest_of_all():
    """Differential evolution over the states at the via point finds nothing that is much shorter."""
    points, limits = random_vias(np.random.default_rng(12), 3, 3, 1)
    v, a = limits.velocity[1, 0], limits.acceleration[1, 0]
    for row in points:
        motion = single(row, limits)

        def total(state: np.ndarray, row: np.ndarray = row) -> float:
            one = jerk_limited(row[0], row[1], limits, goal_velocity=state[:1], goal_acceleration=state[1:])
            two = jerk_limited(row[1], row[2], limits, start_velocity=state[:1], start_acceleration=state[1:])
            if abs(state[0]) + 0.5 * state[1] ** 2 / limits.jerk[1, 0] > v or not one or not two:
                return 1e3
            return float(one.duration + two.duration)

        best = differential_evolution(total, [(-v, v), (-a, a)], seed=0, maxiter=40, popsize=10)
        assert motion.duration <= best.fun * 1.01


def test_a_straight_way_is_not_slowed_by_its_points():
    limits = MotionLimits.of(1, velocity=1.0, acceleration=2.0, jerk=10.0)
    motion = single([[0.0], [0.8], [1.3], [2.0]], limits)
    whole = jerk_limited([0.0], [2.0], limits)
    assert motion.duration == pytest.approx(whole.duration, rel=1e-4)
    assert motion.duration >= whole.duration - 1e-12


def test_a_long_way_takes_time_in_proportion_and_no_longer_motion():
    """Searched in stretches whose joints are searched again: as short as what its parts give one by one."""
    limits = MotionLimits.of(7, velocity=1.5, acceleration=3.0, jerk=30.0)
    points = np.cumsum(np.random.default_rng(1).uniform(-0.2, 0.2, (161, 7)), axis=0)
    single(points[:4], limits)
    motion = within(1.0, lambda: single(points, limits))
    assert excess_through(motion) < 1e-9
    np.testing.assert_allclose(motion.at(motion.passing).u, points, atol=1e-9)
    assert motion.duration < 0.7 * motion.stops
    joint = 53
    assert np.any(motion.velocities[joint] != 0.0)
    before, after = single(points[: joint + 1], limits), single(points[joint:], limits)
    assert motion.duration < before.duration + after.duration


@pytest.mark.parametrize("kind", ["arbitrary", "rest"])
def test_durations_without_end_are_all_possible(kind: str):
    """Where all longer durations are said to be possible, the next of each is itself; most states are of this kind."""
    states, limits = random_problems(np.random.default_rng(3), 400, 5, kind)
    packed, endless = packed_limits(limits, 5), 0
    for row in states:
        for i in range(5):
            least, free = shortest_of(row, packed, i)
            assert least == next_of(row, packed, i, False, 0.0)
            endless += int(free)
            for factor in (1.0 + 1e-9, 1.01, 1.1, 1.5, 3.0, 20.0) if free else ():
                assert next_of(row, packed, i, False, factor * least) == pytest.approx(factor * least, rel=1e-12)
    assert endless > 0.5 * states.shape[0] * 5


def test_given_velocities_are_kept():
    limits = MotionLimits.of(2, velocity=1.0, acceleration=2.0, jerk=10.0)
    points = np.array([[0.0, 0.0], [1.0, 0.5], [2.0, 0.0]])
    motion = single(points, limits, velocities=[[0.3, np.nan]])
    assert motion.velocities[1, 0] == 0.3
    assert motion.at(motion.passing[1]).v[0] == pytest.approx(0.3, abs=1e-12)


def test_degenerate_points_and_refusals():
    limits = MotionLimits.of(2, velocity=1.0, acceleration=2.0, jerk=10.0)
    still = single(np.ones((4, 2)), limits)
    assert still.duration == 0.0
    doubled = single([[0.0, 0.0], [1.0, 1.0], [1.0, 1.0], [0.0, 0.0]], limits)
    assert doubled
    assert doubled.duration <= doubled.stops
    forwards = MotionLimits.of(1, velocity=([0.0], [1.0]), acceleration=1.0, jerk=5.0)
    back = single([[0.0], [1.0], [0.5]], forwards)
    assert back.status is JerkStatus.UNREACHABLE
    assert "points[1]" in back.explain()
    with pytest.raises(InputError, match="points"):
        jerk_limited_through([[0.0, 0.0]], limits)
    with pytest.raises(InputError, match="points"):
        jerk_limited_through([[0.0, np.nan], [1.0, 1.0]], limits)
    with pytest.raises(InputError, match="velocities"):
        jerk_limited_through([[0.0, 0.0], [1.0, 1.0]], limits, velocities=[[0.0, 0.0]])


def test_batches_are_their_rows():
    points, limits = random_vias(np.random.default_rng(5), 20, 3, 2)
    batch = jerk_limited_through(points, limits)
    assert isinstance(batch, tuple)
    for row, motion in zip(points[:3], batch, strict=False):
        assert motion.duration == single(row, limits).duration
