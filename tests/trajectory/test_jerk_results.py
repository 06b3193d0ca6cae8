"""A jerk-limited motion is called planned only if it ends at its goal: scalar arguments over 600 decades."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil.trajectory import MotionLimits, jerk_limited
from mafsil.trajectory.jerk.problem import JerkStatus

LIMITS = MotionLimits.of(2, velocity=[1.0, 2.0], acceleration=[1.0, 3.0], jerk=[1.0, 9.0])
DECADES = [float(f"1e{k}") for k in range(-320, 309, 4)]


@pytest.mark.parametrize("name", ["cycle", "minimum_duration"])
def test_durations_over_600_decades(name):
    shortest = jerk_limited([0.0, 0.0], [1.0, -1.0], LIMITS).duration
    for value in DECADES:
        motion = jerk_limited([0.0, 0.0], [1.0, -1.0], LIMITS, **{name: value})
        if not motion:
            assert motion.status is JerkStatus.BEYOND_NUMBERS
            continue
        assert motion.duration >= shortest * (1.0 - 1e-12)
        np.testing.assert_allclose(motion.at(motion.duration).u, [1.0, -1.0], rtol=1e-9)
        assert motion.residual() <= 1e-9
        if name == "cycle":
            cycles = motion.duration / value
            assert cycles > 1e15 or cycles == pytest.approx(round(cycles), rel=1e-12)
        both = jerk_limited([[0.0, 0.0]] * 2, [[1.0, -1.0]] * 2, LIMITS, **{name: value})
        np.testing.assert_array_equal(both.duration, motion.duration)


def test_scales_of_place_and_limits_over_600_decades():
    for value in DECADES[::4]:
        for limits in (LIMITS, MotionLimits.of(2, velocity=value, acceleration=value, jerk=value)):
            motion = jerk_limited([0.0, 0.0], [value, -value], limits)
            if motion:
                assert 0.0 <= motion.duration < np.inf
                np.testing.assert_allclose(motion.at(motion.duration).u, [value, -value], rtol=1e-6, atol=1e-320)
            else:
                assert motion.explain("en")


def test_a_cycle_below_the_rounding_of_the_duration_changes_nothing():
    shortest = jerk_limited([0.0, 0.0], [1.0, -1.0], LIMITS).duration
    for cycle in (5e-324, 1e-19, 3e-19, 1e-17):
        assert jerk_limited([0.0, 0.0], [1.0, -1.0], LIMITS, cycle=cycle).duration == pytest.approx(shortest, rel=1e-12)


def test_long_waits_of_moving_states_end_at_their_goals():
    """A rounding of the acceleration before a wait is multiplied by the square of the wait."""
    state = np.random.default_rng(5).uniform(-1.0, 1.0, (200, 2, 6)) * [1.0, 0.4, 0.3, 1.0, 0.4, 0.3]
    p, v, a, goal, v_goal, a_goal = np.moveaxis(state, -1, 0)
    for T in DECADES[75:]:
        motions = jerk_limited(
            p, goal, LIMITS, start_velocity=v, start_acceleration=a, goal_velocity=v_goal, goal_acceleration=a_goal,
            minimum_duration=T,
        )  # fmt: skip
        if T <= 1e5:
            assert motions
        for motion, asked in zip(motions, state, strict=True):
            if not motion:
                assert motion.status is JerkStatus.BEYOND_NUMBERS
                continue
            way = motion.at(motion.breaks())
            assert np.isfinite(way.u).all()
            assert (np.abs(way.u[-1] - asked[:, 3]) <= 2e-9 * np.abs(way.u).max(axis=0)).all()
            assert (np.abs(way.v[-1] - asked[:, 4]) <= 2e-9 * np.abs(way.v).max(axis=0)).all()
