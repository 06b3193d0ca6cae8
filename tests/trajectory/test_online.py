"""Motions planned anew in every cycle: limits kept, goals reached, nothing allocated."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest

from mafsil.errors import InputError
from mafsil.trajectory import MotionLimits, jerk_limited, online
from mafsil.trajectory.jerk.problem import JerkStatus

LIMITS = MotionLimits.of(3, velocity=1.0, acceleration=([-2.0] * 3, [1.5] * 3), jerk=10.0)
CYCLE = 0.004


def test_steps_are_the_motion():
    goal = np.array([1.0, -0.5, 0.3])
    whole = jerk_limited(np.zeros(3), goal, LIMITS)
    motion = online(np.zeros(3), LIMITS, CYCLE)
    for k in range(1, 400):
        assert motion.step(goal) is JerkStatus.PLANNED
        expected = whole.at(min(k * CYCLE, whole.duration))
        np.testing.assert_allclose(motion.position, expected.u, atol=1e-12)
        np.testing.assert_allclose(motion.velocity, expected.v, atol=1e-11)
    assert motion.plans == 1
    assert motion.remaining == max(whole.duration - 399 * CYCLE, 0.0) or motion.remaining > 0


def test_a_goal_that_changes_in_every_cycle():
    rng = np.random.default_rng(4)
    motion = online(np.zeros(3), LIMITS, CYCLE)
    goal, before = np.zeros(3), np.zeros(3)
    for k in range(3000):
        if k % 7 == 0:
            goal = rng.uniform(-1, 1, 3)
        assert motion.step(goal)
        assert (np.abs(motion.velocity) <= 1.0 + 1e-9).all()
        assert (motion.acceleration <= 1.5 + 1e-9).all()
        assert (motion.acceleration >= -2.0 - 1e-9).all()
        assert (np.abs(motion.acceleration - before) <= 10.0 * CYCLE * (1 + 1e-9)).all()
        before = motion.acceleration.copy()
    for _ in range(2000):
        motion.step(goal)
    np.testing.assert_allclose(motion.position, goal, atol=1e-9)
    np.testing.assert_allclose(motion.velocity, 0.0, atol=1e-9)
    assert motion.remaining == 0.0


def test_velocity_control_and_back():
    motion = online([0.0, 0.0, 0.0], LIMITS, CYCLE)
    for _ in range(500):
        motion.step_velocity(np.array([0.5, -0.5, 0.0]))
    np.testing.assert_allclose(motion.velocity, [0.5, -0.5, 0.0], atol=1e-12)
    assert motion.position[2] == 0.0
    assert motion.plans == 1
    for _ in range(2000):
        motion.step(np.zeros(3))
    np.testing.assert_allclose(motion.position, 0.0, atol=1e-9)


def test_a_goal_passed_with_velocity():
    motion = online([0.0], MotionLimits.of(1, velocity=1.0, acceleration=2.0, jerk=10.0), 0.01)
    for _ in range(300):
        motion.step(np.array([1.0]), 0.5)
    beyond = motion.position[0] - 1.0
    motion.step(np.array([1.0]), 0.5)
    assert motion.position[0] - 1.0 - beyond == pytest.approx(0.005)


def test_a_measured_state_is_taken_up():
    motion = online(np.zeros(3), LIMITS, CYCLE)
    goal = np.array([1.0, 1.0, 1.0])
    motion.step(goal)
    motion.position[0] = 0.2
    motion.step(goal)
    assert motion.plans == 2
    assert motion.position[0] == pytest.approx(0.2, abs=1e-3)


def test_a_goal_that_is_refused_changes_nothing():
    motion = online(np.zeros(3), LIMITS, CYCLE)
    goal = np.array([1.0, 1.0, 1.0])
    for _ in range(50):
        motion.step(goal)
    status = motion.step(goal, np.array([0.0, 3.0, 0.0]))
    assert status is JerkStatus.TARGET_OUTSIDE
    assert "coordinate 1" in motion.explain()
    for _ in range(1000):
        motion.step(goal, np.array([0.0, 3.0, 0.0]))
    np.testing.assert_allclose(motion.position, goal, atol=1e-9)
    with pytest.raises(InputError, match="goal"):
        motion.step([1.0, 2.0])  # pyright: ignore
    with pytest.raises(InputError):
        motion.step(np.array([np.nan, 0.0, 0.0]))
    with pytest.raises(InputError, match="cycle"):
        online(np.zeros(3), LIMITS, 0.0)


def test_steps_allocate_nothing():
    rng = np.random.default_rng(1)
    motion = online(np.zeros(3), LIMITS, CYCLE)
    goals = [rng.uniform(-1, 1, 3) for _ in range(50)]
    for goal in goals:
        motion.step(goal)
    tracemalloc.start()
    try:
        for goal in goals:
            motion.step(goal)
        tracemalloc.clear_traces()
        for goal in goals:
            motion.step(goal)
        kept, peak = tracemalloc.get_traced_memory()
    finally:
        tracemalloc.stop()
    # What a call of Python itself takes: its arguments, and the numbers of the clock.
    assert kept < 200
    assert peak < 2000
    assert 0.0 < motion.worst_time
