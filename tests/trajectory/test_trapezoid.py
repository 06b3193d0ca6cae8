"""Trapezoids keep their limits, are as fast as their bottleneck, and say why a duration is too short."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mafsil.arrays import SMALLEST
from mafsil.errors import InputError
from mafsil.model import JointLimits
from mafsil.trajectory import check, trapezoid
from mafsil.trajectory.motion import PlanStatus

limits = st.lists(st.floats(0.1, 10.0), min_size=3, max_size=3).map(np.array)
# Zero and tiny distances are the seams of the blend formula.
distances = st.lists(st.one_of(st.floats(-5.0, 5.0), st.sampled_from([0.0, 1e-12, -1e-300])), min_size=3, max_size=3)


def bounds(V, A):
    free = np.full(3, np.inf)
    return JointLimits(-free, free, V, A, free, free)


@pytest.mark.capability("11-25", "11-14")
@given(D=distances.map(np.array), V=limits, A=limits, sync=st.sampled_from(["time", "phase"]))
def test_limits_are_kept_and_ends_met(D, V, A, sync):
    start = np.array([0.3, -1.0, 2.0])
    outcome = trapezoid(start, start + D, velocity=V, acceleration=A, synchronise=sync)
    motion = outcome.value
    assert outcome.status is PlanStatus.PLANNED
    assert check(motion, bounds(V, A))
    begin, end = motion.at(0.0), motion.at(motion.duration)
    np.testing.assert_allclose(begin.u, start, atol=1e-12)
    np.testing.assert_allclose(end.u, start + D, atol=1e-12)
    np.testing.assert_allclose([begin.v, end.v], 0.0, atol=1e-12)


@given(D=distances.map(np.array), V=limits, A=limits)
def test_one_joint_is_at_a_limit(D, V, A):
    motion = trapezoid(np.zeros(3), D, velocity=V, acceleration=A).value
    if np.abs(D).max() < 1e-9:
        return
    assert not check(motion.scale_time(0.99), bounds(V, A))


@given(D=distances.map(np.array), V=limits, A=limits, slack=st.floats(1.0, 5.0))
def test_given_duration_is_taken(D, V, A, slack):
    fastest = trapezoid(np.zeros(3), D, velocity=V, acceleration=A).value.duration
    if fastest == 0.0:
        return
    if fastest * slack < SMALLEST:
        with pytest.raises(InputError, match="duration"):
            trapezoid(np.zeros(3), D, velocity=V, acceleration=A, duration=fastest * slack)
        return
    outcome = trapezoid(np.zeros(3), D, velocity=V, acceleration=A, duration=fastest * slack)
    assert outcome.succeeded
    assert outcome.value.duration == pytest.approx(fastest * slack, rel=1e-15)
    assert check(outcome.value, bounds(V, A))


@pytest.mark.capability("11-26")
def test_too_short_duration_names_joint_and_remedy():
    outcome = trapezoid([0.0, 0.0], [1.0, 4.0], acceleration=2.0, duration=1.0)
    assert outcome.status is PlanStatus.TOO_SHORT
    assert not outcome.succeeded
    assert outcome.details["joint"] == 1
    assert outcome.details["shortest"] == pytest.approx(2 * np.sqrt(2.0))
    assert "joint 1" in outcome.explain("en")
    assert "2.82843" in outcome.explain("ar")
    assert outcome.value.duration == pytest.approx(2 * np.sqrt(2.0))


def test_phase_moves_along_the_chord():
    goal = np.array([1.0, -2.0, 0.5])
    motion = trapezoid(np.zeros(3), goal, velocity=[1, 0.7, 2], acceleration=[1, 9, 3], synchronise="phase").value
    u = motion.at(np.linspace(0, motion.duration, 50)).u
    np.testing.assert_allclose(u, np.outer(u[:, 0], goal), atol=1e-13)


def test_time_is_never_slower_than_phase():
    args = {"velocity": [1.0, 0.5], "acceleration": [0.3, 4.0]}
    fast = trapezoid([0.0, 0.0], [2.0, 2.0], **args).value.duration
    straight = trapezoid([0.0, 0.0], [2.0, 2.0], **args, synchronise="phase").value.duration
    assert fast < straight


def test_no_motion_takes_no_time():
    outcome = trapezoid([1.0, 2.0], [1.0, 2.0], acceleration=1.0)
    assert outcome.value.duration == 0.0
    np.testing.assert_array_equal(outcome.value.at(0.0).u, [1.0, 2.0])
    np.testing.assert_array_equal(outcome.value.at([3.0]).u, [[1.0, 2.0]])


@pytest.mark.parametrize(
    ("args", "words"),
    [
        ({"acceleration": 0.0}, "acceleration"),
        ({"acceleration": np.inf}, "acceleration"),
        ({"acceleration": 1.0, "velocity": -1.0}, "velocity"),
        ({"acceleration": [1.0, 2.0, 3.0]}, "acceleration"),
        ({"acceleration": 1.0, "synchronise": "both"}, "both"),
        ({"acceleration": 1.0, "duration": -1.0}, "duration"),
        ({"acceleration": 1.0, "velocity": np.nan}, "velocity"),
    ],
)
def test_wrong_input_is_named(args, words):
    with pytest.raises(InputError, match=words):
        trapezoid([0.0, 0.0], [1.0, 1.0], **args)
    with pytest.raises(InputError, match="start"):
        trapezoid(np.zeros((2, 2)), np.zeros((2, 2)), acceleration=1.0)
