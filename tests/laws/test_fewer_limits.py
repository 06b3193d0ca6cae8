"""Taking a limit away never makes a motion slower or impossible."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import mafsil as mf
from mafsil.trajectory import JointPath, MotionLimits, jerk_limited, time_optimal

NUMBERS = 1e-4
"""Relative difference of two timings that settle by repeated linearisation."""


def with_viscous(name: str, viscous: float) -> mf.Robot:
    mechanism = mf.load(name).mechanism
    friction = mf.Friction(viscous=viscous)
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
