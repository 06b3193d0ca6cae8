"""The shortest time along a path with limited jerk: against exact motions, dense measurement and scaling."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil.errors import InputError
from mafsil.trajectory import JointPath, MotionLimits, check, jerk_limited, time_optimal
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from mafsil.trajectory.timing.timing_answer import TimingStatus
from tests.sizes import size


def excess(answer, limits, count=60_001):
    """The largest excess over a limit at even times, as share of it."""
    motion = answer.trajectory
    t = np.linspace(0.0, motion.duration, count)
    here = motion.at(t)
    pairs = ((here.v, limits.velocity), (here.a, limits.acceleration), (motion.jerk(t), limits.jerk))
    return max(float(np.maximum(x / side[1], x / side[0]).max()) - 1.0 for x, side in pairs)


@pytest.mark.parametrize("jerk", [0.3, 1.0, 10.0, 100.0, 1e4])
def test_straight_lines_take_the_time_of_the_exact_motion(jerk):
    limits = MotionLimits.of(2, velocity=1.0, acceleration=2.0, jerk=jerk)
    exact = jerk_limited([0.0, 0.0], [1.0, 0.5], limits).duration
    answer = time_optimal(JointPath.through([[0.0, 0.0], [1.0, 0.5]]), limits)
    assert exact * (1 - 1e-9) <= answer.duration <= exact * 1.004
    assert check(answer.trajectory, limits)


@settings(deadline=None, max_examples=size(8, 25))
@example(7, 4, 1.7406580821107376, True, 383)  # the spline of the dilation was below zero between its places
@example(7, 4, 1.625, True, 383)  # and here so near it that pieces were too sharp
@given(st.integers(1, 7), st.integers(2, 12), st.floats(-3, 2), st.booleans(), st.integers(0, 2**32 - 1))
def test_limits_hold_everywhere_and_the_path_is_kept(n, count, size, lines, seed):
    rng = np.random.default_rng(seed)
    limits = MotionLimits.of(
        n,
        velocity=(-rng.uniform(0.1, 3.0, n), rng.uniform(0.1, 3.0, n)),
        acceleration=(-rng.uniform(0.1, 5.0, n), rng.uniform(0.1, 5.0, n)),
        jerk=10 ** rng.uniform(-1, 3, n),
    )
    path = JointPath.through(rng.uniform(-1, 1, (count, n)) * 10**size, kind="lines" if lines else "spline")
    answer = time_optimal(path, limits)
    assert answer, answer.explain()
    assert excess(answer, limits) <= 1e-6
    motion = answer.trajectory
    ends = motion.at([0.0, motion.duration])
    np.testing.assert_allclose(ends.u, path.at([0.0, path.end]).u, atol=1e-9 * 10**size)
    np.testing.assert_allclose(ends.v, 0.0, atol=1e-12)
    np.testing.assert_allclose(ends.a, 0.0, atol=1e-9)
    t = np.linspace(0.0, motion.duration, 60_001)
    jump = np.abs(np.diff(motion.at(t).a, axis=0)) / (t[1] * np.maximum(-limits.jerk[0], limits.jerk[1]))
    assert jump.max() <= 1.0 + 1e-4, "accelerations do not jump"
    within = time_optimal(
        path, MotionLimits.of(n, velocity=tuple(limits.velocity), acceleration=tuple(limits.acceleration))
    )
    # Without limits of jerk the grid itself costs up to a thousandth.
    assert answer.duration >= within.duration * (1 - 1e-3)


def test_gains_scale_as_time_does():
    """With velocities times k, accelerations times k^2 and jerks times k^3 the duration is divided by k."""
    rng = np.random.default_rng(3)
    powers = {"velocity": 1, "acceleration": 2, "jerk": 3}
    limits = MotionLimits.of(4, velocity=1.0, acceleration=2.0, jerk=[10.0, 3.0, 30.0, 10.0])
    answer = time_optimal(JointPath.through(rng.uniform(-1, 1, (5, 4))), limits)
    gains = answer.gains()
    assert {gain.quantity for gain in gains} == set(powers)
    saved = sum(powers[gain.quantity] * gain.seconds for gain in gains)
    assert saved == pytest.approx(0.01 * answer.duration, rel=0.03)
    doubled = MotionLimits.of(4, velocity=2.0, acceleration=8.0, jerk=8.0 * limits.jerk[1])
    assert time_optimal(answer.path, doubled).duration == pytest.approx(answer.duration / 2, rel=1e-6)


def test_what_decides_is_said_at_every_time():
    limits = MotionLimits.of(1, velocity=1.0, acceleration=2.0, jerk=10.0)
    answer = time_optimal(JointPath.through([[0.0], [2.0]]), limits)
    ends = [binding.end for binding in answer.bindings]
    assert [binding.quantity for binding in answer.bindings if binding.end - binding.begin > 0.05] == [
        "jerk", "acceleration", "jerk", "velocity", "jerk", "acceleration", "jerk"
    ]  # fmt: skip
    assert ends[-1] == pytest.approx(answer.duration)
    assert "jerk" in answer.explain("en")
    np.testing.assert_allclose(answer.velocities[[0, -1], 0], [0.0, 2.0], atol=1e-12)


def test_directions_and_curvatures_that_jump_are_passed_at_rest():
    limits = MotionLimits.of(2, velocity=1.0, acceleration=2.0, jerk=10.0)
    corner = JointPath.through([[0.0, 0.0], [1.0, 0.0], [1.0, 0.5]], kind="lines")
    assert corner.stops().tolist() == [1.0]
    legs = [time_optimal(JointPath.through([[0.0, 0.0], [d, 0.0]]), limits).duration for d in (1.0, 0.5)]
    assert time_optimal(corner, limits).duration == pytest.approx(sum(legs), rel=1e-9)
    # A line that goes over into a parabola: its direction is continuous, its curvature is not.
    rows = np.array([[[0.0, 0.0], [1.0, 0.0], [0.0, 0.0]], [[1.0, 0.0], [1.0, 0.0], [0.0, 0.5]]])
    bend = JointPath(PiecewisePolynomial.from_pieces([1.0, 1.0], rows))
    assert bend.corners().tolist() == []
    assert bend.stops().tolist() == [1.0]
    answer = time_optimal(bend, limits)
    moment = answer.trajectory.law.breaks()[np.searchsorted(answer.trajectory.places, 1.0)]
    assert np.abs(answer.trajectory.at(moment).v).max() < 1e-9
    assert excess(answer, limits) <= 1e-6


def test_efforts_and_the_tip_are_kept_too():
    arm = mf.load("puma560")
    turn = JointPath.through(
        [[0.0, -0.5, 0.3, 0.0, 0.2, 0.0], [0.8, 0.0, 0.8, 0.5, -0.3, 0.4], [1.2, -0.6, 0.2, 0.1, 0.4, 0.0]]
    )
    limits = MotionLimits.of(6, velocity=3.0, effort=arm.limits.effort, jerk=300.0)
    answer = time_optimal(turn, limits, robot=arm, tip_speed=1.2)
    assert answer
    motion = answer.trajectory.at(np.linspace(0.0, answer.duration, 20_001))
    tau = arm.inverse_dynamics(motion.u, motion.v, motion.a) + arm.friction_torque(motion.v)
    assert (np.abs(tau) / arm.limits.effort).max() <= 1.0 + 1e-6
    twist = np.einsum("tij,tj->ti", arm.jacobian_body(motion.u), motion.v)
    assert 1.2 * 0.999 <= np.linalg.norm(twist[:, 3:], axis=1).max() <= 1.2 * (1 + 1e-6)
    assert np.abs(answer.trajectory.jerk(np.linspace(0.0, answer.duration, 20_001))).max() <= 300.0 * (1 + 1e-6)
    assert {"effort", "jerk", "tip_speed"} <= {binding.quantity for binding in answer.bindings}


def test_many_paths_are_each_as_alone():
    rng = np.random.default_rng(8)
    limits = MotionLimits.of(3, velocity=1.0, acceleration=2.0, jerk=10.0)
    paths = [JointPath.through(rng.uniform(-1, 1, (4, 3))) for _ in range(3)]
    batch = time_optimal(paths, limits)
    assert batch.durations.tolist() == [time_optimal(path, limits).duration for path in paths]


def test_questions_without_an_answer():
    limits = MotionLimits.of(2, velocity=1.0, acceleration=2.0, jerk=10.0)
    path = JointPath.through([[0.0, 0.0], [1.0, 0.5]])
    with pytest.raises(InputError, match="rest"):
        time_optimal(path, limits, start_path_velocity=0.1)
    still = time_optimal(path, MotionLimits.of(2, velocity=1.0, acceleration=2.0, jerk=[10.0, 0.0]))
    assert still.status is TimingStatus.NO_MOTION
    assert still.details["joint"] == 1
    assert time_optimal(JointPath.through([[0.5, 0.5]]), limits).duration == 0.0
