"""Jerk-limited motions between states: limits, ends, shortest durations (Ruckig as oracle), and honest refusals."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.errors import InputError
from mafsil.trajectory import MotionLimits, Trajectory, jerk_limited
from mafsil.trajectory.jerk import JerkLimitedBatch, JerkLimitedMotion
from mafsil.trajectory.jerk.problem import JerkStatus
from tests.reliability.jerk_limited import compared, random_problems, violation

unit = st.floats(-1.0, 1.0)


def single(*args: Any, **named: Any) -> JerkLimitedMotion:
    motion = jerk_limited(*args, **named)
    assert isinstance(motion, JerkLimitedMotion)
    return motion


def coordinate(D: float, v0: float, a0: float, vf: float, af: float, limits: MotionLimits) -> JerkLimitedMotion:
    given = {"start_velocity": [v0], "start_acceleration": [a0], "goal_velocity": [vf], "goal_acceleration": [af]}
    return single([0.0], [D], limits, **given)


def states(rest: tuple[float, float, float, float], v: float = 1.0, a: float = 1.0, j: float = 1.0):
    """Velocities and accelerations from which, and before which, limits are kept."""
    v0, a0, vf, af = rest
    a0, af = a * a0, a * af
    room = v - 0.5 * a * a / j
    assert room >= 0.0
    return room * v0, a0, room * vf, af


def test_from_rest_to_rest_by_hand():
    limits = MotionLimits.of(1, velocity=1.0, acceleration=2.0, jerk=10.0)
    motion = single([0.0], [2.0], limits)
    # D / V + V / A + A / J
    assert motion.duration == pytest.approx(2.0 + 0.5 + 0.2, rel=1e-15)
    assert isinstance(motion, Trajectory)
    assert motion.residual() < 1e-14
    short = single([0.0], [1e-3], limits)
    assert short.duration == pytest.approx((32.0 * 1e-3 / 10.0) ** (1 / 3), rel=1e-14)


@given(st.floats(-3.0, 3.0), st.tuples(unit, unit, unit, unit))
@settings(max_examples=300, deadline=None)
def test_limits_are_kept_and_the_end_is_reached(D: float, rest: tuple[float, float, float, float]):
    limits = MotionLimits.of(1, velocity=1.0, acceleration=1.0, jerk=1.0)
    motion = coordinate(D, *states(rest), limits)
    assert motion
    assert motion.residual() < 1e-9
    assert violation(motion) < 1e-9


@given(st.floats(-3.0, 3.0), st.tuples(unit, unit, unit, unit))
@settings(max_examples=200, deadline=None)
def test_a_motion_backwards_in_time_takes_as_long(D: float, rest: tuple[float, float, float, float]):
    limits = MotionLimits.of(1, velocity=([-1.0], [2.0]), acceleration=([-1.0], [0.9]), jerk=1.0)
    back = MotionLimits.of(1, velocity=([-2.0], [1.0]), acceleration=([-1.0], [0.9]), jerk=1.0)
    v0, a0, vf, af = (x * 0.9 for x in states(rest))
    one, other = coordinate(D, v0, a0, vf, af, limits), coordinate(-D, -vf, af, -v0, a0, back)
    # Where two ways are equally long up to rounding the two may take different ones, but not for different times.
    assert one.duration == pytest.approx(other.duration, rel=1e-7, abs=1e-7)


@given(st.floats(0.01, 3.0), st.tuples(unit, unit, unit, unit), st.floats(1e-6, 1e6), st.floats(1e-3, 1e3))
@settings(max_examples=200, deadline=None)
def test_scales(D: float, rest: tuple[float, float, float, float], size: float, time: float):
    v0, a0, vf, af = states(rest)
    one = coordinate(D, v0, a0, vf, af, MotionLimits.of(1, velocity=1.0, acceleration=1.0, jerk=1.0))
    v, a, j = size / time, size / time**2, size / time**3
    other = MotionLimits.of(1, velocity=v, acceleration=a, jerk=j)
    scaled = coordinate(D * size, v0 * v, a0 * a, vf * v, af * a, other)
    if one.duration and abs(scaled.duration / one.duration / time - 1.0) > 1e-6:
        # At the edge of what one way reaches the last bit decides which way is taken.
        nearby = [
            coordinate(D * f, v0, a0, vf, af, MotionLimits.of(1, velocity=1, acceleration=1, jerk=1))
            for f in (1 - 1e-9, 1 + 1e-9)
        ]
        assert min(abs(x.duration * time / scaled.duration - 1.0) for x in nearby) < 1e-4
    assert scaled.residual() < 1e-9 * max(size, v, a)


def test_mirror_image():
    rng = np.random.default_rng(0)
    problems, limits = random_problems(rng, 200, 1, "arbitrary")
    for x in problems:
        one = jerk_of(x, limits)
        bounds = (limits.velocity[::-1], limits.acceleration[::-1], limits.jerk[::-1])
        v, a, j = ((-b[0], -b[1]) for b in bounds)
        other = jerk_of(-x, MotionLimits.of(1, velocity=v, acceleration=a, jerk=j))
        assert other.duration == pytest.approx(one.duration, rel=1e-12)


def jerk_of(x: np.ndarray, limits: MotionLimits, **named: Any) -> JerkLimitedMotion:
    return single(
        x[:, 0],
        x[:, 3],
        limits,
        start_velocity=x[:, 1],
        start_acceleration=x[:, 2],
        goal_velocity=x[:, 4],
        goal_acceleration=x[:, 5],
        **named,
    )


@pytest.mark.parametrize("kind", ["rest", "arbitrary", "outside"])
@pytest.mark.parametrize("n", [1, 7])
def test_never_longer_than_ruckig(kind: str, n: int):
    pytest.importorskip("ruckig")
    found = compared(np.random.default_rng(n), 400, n, kind)
    assert found["bad_longer"] == found["bad_limits"] == found["bad_ends"] == found["bad_failed"] == 0
    assert found["compared"] == 400


@settings(deadline=None)
@given(st.integers(0, 10_000), st.integers(1, 19))
def test_from_rest_together_is_the_longest_of_each_alone(seed: int, n: int):
    """The lanes of coordinates beside the search that takes one after the other (`synchronise="none"`)."""
    rng = np.random.default_rng(seed)

    def bound(share: float):
        size = 10.0 ** rng.uniform(-2.0, 2.0, (2, n))
        size[rng.random((2, n)) < share] = np.inf
        return -size[0], size[1]

    limits = MotionLimits.of(n, velocity=bound(0.2), acceleration=bound(0.2), jerk=bound(0.0))
    start, goal = rng.uniform(-1.0, 1.0, (2, 5, n)) * 10.0 ** rng.uniform(-6.0, 2.0, (2, 5, n))
    goal[rng.random((5, n)) < 0.2] = 0.0
    start[goal == 0.0] = 0.0
    together, alone = jerk_limited(start, goal, limits), jerk_limited(start, goal, limits, synchronise="none")
    np.testing.assert_allclose(together.duration, alone.duration, rtol=1e-12)
    for row in range(5):
        motion = together[row]
        assert violation(motion) <= 1e-9
        end = motion.at(motion.duration)
        np.testing.assert_allclose(end.u, goal[row], atol=1e-11 * np.abs(np.array([start[row], goal[row]])).max())
    assert single(start[0], goal[0], limits, cycle=0.01).duration % 0.01 == pytest.approx(0.0, abs=0.01 + 1e-9)
    assert single(start[0], goal[0], limits, minimum_duration=1e4).duration == 1e4


def test_batch_is_its_rows():
    rng = np.random.default_rng(3)
    problems, limits = random_problems(rng, 600, 4, "arbitrary")
    x = problems.reshape(2, 300, 4, 6)
    batch = jerk_limited(
        x[..., 0],
        x[..., 3],
        limits,
        start_velocity=x[..., 1],
        start_acceleration=x[..., 2],
        goal_velocity=x[..., 4],
        goal_acceleration=x[..., 5],
    )
    assert isinstance(batch, JerkLimitedBatch)
    assert batch
    assert batch.duration.shape == (2, 300)
    for place in ((0, 0), (1, 17), (1, 299)):
        alone = jerk_of(x[place], limits)
        assert batch[place].duration == alone.duration == batch.duration[place]
        t = np.linspace(0.0, alone.duration, 7)
        for ours, theirs in zip(batch.at(t), alone.at(t), strict=True):
            np.testing.assert_array_equal(ours[(slice(None), *place)], theirs)
    ends = batch.at(batch.duration.max() + 1.0)
    np.testing.assert_allclose(ends.u, x[..., 3], atol=1e-9)


@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_small_and_large_numbers(scale: float):
    problems, limits = random_problems(np.random.default_rng(8), 100, 3, "arbitrary")
    wide = MotionLimits.of(
        3, velocity=limits.velocity[1] * scale, acceleration=limits.acceleration[1] * scale, jerk=limits.jerk[1] * scale
    )
    for x in problems:
        one, other = jerk_of(x, limits), jerk_of(x * scale, wide)
        assert other.duration == pytest.approx(one.duration, rel=1e-9)
        assert other.residual() < 1e-9 * max(scale, 1e-3)


def test_no_way_at_all():
    limits = MotionLimits.of(2, velocity=1.0, acceleration=1.0, jerk=1.0)
    still = single([1.0, 2.0], [1.0, 2.0], limits)
    assert still.duration == 0.0
    np.testing.assert_array_equal(still.at([0.0, 1.0]).u, [[1.0, 2.0]] * 2)
    one = single([1.0, 2.0], [1.5, 2.0], limits)
    np.testing.assert_array_equal(one.at(np.linspace(0, one.duration, 9)).u[:, 1], 2.0)


def test_without_limits_of_velocity_and_acceleration():
    motion = single([0.0], [1.0], MotionLimits.of(1, jerk=2.0))
    assert motion.duration == pytest.approx((32.0 / 2.0) ** (1 / 3), rel=1e-14)


def test_one_sided_limits():
    forwards = MotionLimits.of(1, velocity=([0.0], [1.0]), acceleration=1.0, jerk=5.0)
    assert single([0.0], [1.0], forwards)
    backwards = single([0.0], [-1.0], forwards)
    assert not backwards
    assert backwards.status is JerkStatus.UNREACHABLE
    assert "coordinate 0" in backwards.explain()
    with pytest.raises(InputError, match="never arrives"):
        backwards.at(0.0)


def test_refusals_name_numbers_and_remedies():
    limits = MotionLimits.of(2, velocity=1.0, acceleration=1.0, jerk=1.0)
    fast = single([0.0, 0.0], [1.0, 1.0], limits, goal_velocity=[0.0, 2.0])
    assert fast.status is JerkStatus.TARGET_OUTSIDE
    assert "coordinate 1" in fast.explain()
    late = single([0.0, 0.0], [1.0, 1.0], limits, goal_velocity=[0.9, 0.0], goal_acceleration=[-1.0, 0.0])
    assert late.status is JerkStatus.TARGET_OUTSIDE
    assert "1.4" in late.explain()
    frozen = single([0.0, 0.0], [1.0, 1.0], MotionLimits.of(2, velocity=1.0, acceleration=[1.0, 0.0], jerk=1.0))
    assert frozen.status is JerkStatus.FROZEN
    assert frozen.ruling == 1
    steady = single(
        [0.0],
        [1.0],
        MotionLimits.of(1, velocity=1.0, acceleration=0.0, jerk=1.0),
        start_velocity=0.5,
        goal_velocity=0.5,
    )
    assert steady.duration == 2.0
    for status in JerkStatus:
        assert status.key.startswith("jerk.")


def test_gate():
    limits = MotionLimits.of(2, velocity=1.0, acceleration=1.0, jerk=1.0)
    with pytest.raises(InputError, match="goal"):
        jerk_limited([0.0, 0.0], [np.nan, 1.0], limits)
    with pytest.raises(InputError, match="start_velocity"):
        jerk_limited([0.0, 0.0], [1.0, 1.0], limits, start_velocity=[np.inf, 0.0])
    with pytest.raises(InputError, match="jerk"):
        jerk_limited([0.0, 0.0], [1.0, 1.0], MotionLimits.of(2, velocity=1.0, acceleration=1.0))
    with pytest.raises(InputError, match="synchronise"):
        jerk_limited([0.0, 0.0], [1.0, 1.0], limits, synchronise="together")  # pyright: ignore
    with pytest.raises(InputError, match="cycle"):
        jerk_limited([0.0, 0.0], [1.0, 1.0], limits, cycle=-1.0)
    with pytest.raises(InputError):
        jerk_limited([0.0, 0.0, 0.0], [1.0, 1.0], limits)
    with pytest.raises(InputError):
        jerk_limited([], [], MotionLimits.of(0, jerk=1.0))


def test_common_duration_passes_over_what_one_coordinate_cannot_have():
    """Two coordinates that must keep moving: some longer durations are impossible for the first."""
    limits = MotionLimits.of(2, velocity=1.0, acceleration=1.0, jerk=1.0)
    quick = {"start_velocity": [0.5, 0.0], "goal_velocity": [0.5, 0.0]}
    moved = single([0.0, 0.0], [0.05, 0.1], limits, **quick)
    alone = moved.durations()
    assert moved.residual() < 1e-12
    assert violation(moved) < 1e-9
    assert moved.duration > alone.max() + 0.1
    assert moved.ruling == 0


def test_modes():
    limits = MotionLimits.of(3, velocity=[1.0, 2.0, 1.0], acceleration=2.0, jerk=10.0)
    start, goal = np.zeros(3), np.array([1.0, -0.5, 2.0])
    straight = single(start, goal, limits, synchronise="phase")
    assert straight.synchronised == "phase"
    u = straight.at(np.linspace(0.0, straight.duration, 50)).u
    np.testing.assert_allclose(u, u[:, :1] * goal, atol=1e-14)
    bent = single(start, goal, limits, synchronise="phase", start_velocity=[0.1, 0.1, 0.1])
    assert bent.synchronised == "time"
    apart = single(start, goal, limits, synchronise="none")
    own = apart.durations()
    for i in range(3):
        assert apart.at(own[i]).u[i] == pytest.approx(goal[i], abs=1e-12)
    assert apart.duration == own.max()
    cycled = single(start, goal, limits, cycle=0.04)
    assert cycled.duration / 0.04 == pytest.approx(round(cycled.duration / 0.04), abs=1e-9)
    assert cycled.residual() < 1e-12
    assert single(start, goal, limits, minimum_duration=9.0).duration == 9.0
    steady = single(start, None, limits, goal_velocity=[0.5, -0.2, 0.0])
    assert steady.duration == pytest.approx(0.5 / 2.0 + 2.0 / 10.0)
    assert steady.residual() < 1e-12
    assert violation(steady) < 1e-9


def test_binding_limits():
    motion = single([0.0], [2.0], MotionLimits.of(1, velocity=1.0, acceleration=2.0, jerk=10.0))
    rows = motion.binding()
    assert [row.quantity for row in rows] == [
        "jerk",
        "acceleration",
        "jerk",
        "velocity",
        "jerk",
        "acceleration",
        "jerk",
    ]
    assert rows.at(1.0)[0].quantity == "velocity"
    assert sum(row.end - row.begin for row in rows) == pytest.approx(motion.duration)
    assert "velocity" in str(rows)


def test_polynomial_is_the_same_motion():
    problems, limits = random_problems(np.random.default_rng(2), 20, 3, "arbitrary")
    for x in problems:
        motion = jerk_of(x, limits)
        t = np.linspace(0.0, motion.duration, 101)
        for ours, theirs in zip(motion.at(t), motion.polynomial().at(t), strict=True):
            np.testing.assert_allclose(ours, theirs, atol=1e-11)


def test_a_start_outside_comes_back_first():
    limits = MotionLimits.of(1, velocity=1.0, acceleration=1.0, jerk=1.0)
    motion = coordinate(5.0, 2.0, 1.5, 0.0, 0.0, limits)
    assert motion
    assert motion.residual() < 1e-12
    v = motion.at(np.linspace(0.0, motion.duration, 2001)).v[:, 0]
    back = np.argmax(v <= 1.0)
    assert (v[back:] <= 1.0 + 1e-9).all()
