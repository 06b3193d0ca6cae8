"""A finite limit of order k needs continuity of order k - 1: jumps are found where they are, and none is invented."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil.trajectory import (
    MotionLimits,
    PathMotion,
    check,
    cubic,
    export,
    linear_blends,
    prove,
    quintic,
    straight_lines,
    trapezoid,
)
from mafsil.trajectory.motion import LimitStatus, ProofStatus
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial
from tests.reliability import planted_jumps
from tests.sizes import size

LIMITS = MotionLimits.of(1, velocity=3.0, acceleration=12.0, jerk=100.0)


@pytest.mark.capability("11-4")
def test_a_jump_of_velocity_exceeds_the_acceleration_at_its_time(tmp_path):
    motion = straight_lines([0.0, 2.0, 1.0], [1.0, 1.0]).value
    limits = MotionLimits.of(1, velocity=3.0, acceleration=5.0)
    (violation,) = check(motion, limits, ("elbow",))
    assert (violation.quantity, violation.jumping, violation.time) == ("acceleration", "velocity", 1.0)
    assert (violation.value, violation.limit) == (-np.inf, -5.0)
    assert violation.jump == pytest.approx(-3.0)
    assert "elbow: the velocity jumps by -3 at t = 1 s" in violation.explain("en")
    assert violation.explain("ar") != violation.explain("en")
    proof = prove(motion, limits)
    assert proof.status is ProofStatus.EXCEEDED
    assert next(iter(proof)).time == 1.0
    file = export(motion, tmp_path / "jump.csv", limits, rate=100)
    assert not file
    assert not (tmp_path / "jump.csv").exists()


@pytest.mark.capability("11-4")
@pytest.mark.parametrize(
    "motion",
    [
        cubic([0.0], [1.0], 5.0),
        trapezoid([0.0], [1.0], acceleration=12.0, velocity=3.0).value,
        linear_blends([[0.0], [1.0], [0.5]], [1.0, 1.0], acceleration=10.0).trajectory,
    ],
    ids=["cubic", "trapezoid", "blends"],
)
def test_a_jump_of_acceleration_exceeds_the_jerk(motion):
    (violation,) = check(motion, LIMITS)
    assert (violation.quantity, violation.jumping) == ("jerk", "acceleration")
    assert not prove(motion if isinstance(motion, PiecewisePolynomial) else motion.to_polynomial(), LIMITS)
    without = MotionLimits.of(1, velocity=3.0, acceleration=12.0)
    assert check(motion, without).status is LimitStatus.KEPT
    assert check(quintic([0.0], [1.0], 5.0), LIMITS)


def test_a_motion_that_continues_another_is_not_accused_at_its_ends():
    moving = quintic([0.0], [1.0], 1.0, start_velocity=2.0, goal_velocity=1.0)
    limits = MotionLimits.of(1, velocity=9.0, acceleration=90.0, jerk=900.0)
    assert check(moving, limits, ends=False)
    assert {v.quantity for v in check(moving, limits)} == {"acceleration", "jerk"}


def test_the_corner_of_a_path_that_the_motion_does_not_name_is_found():
    """Half a metre each way round a corner, the time law is a quintic that knows nothing of it."""
    corner = PiecewisePolynomial.from_pieces([0.5, 0.5], [[[0.0, 0.0], [1.0, 0.0]], [[0.5, 0.0], [0.0, 1.0]]])
    motion = PathMotion(corner, quintic([0.0], [1.0], 1.0))
    found = check(motion, MotionLimits.of(2, acceleration=100.0))
    assert {(v.joint, v.jumping) for v in found} == {("0", "velocity"), ("1", "velocity")}
    assert all(v.time == pytest.approx(0.5, abs=1e-6) for v in found)
    assert {round(v.jump, 6) for v in found} == {-1.875, 1.875}


def test_planted_jumps_are_found_and_clean_motions_are_not_accused():
    """Larger: python -m tests.reliability.planted_jumps --motions 10000."""
    for k in range(size(30, 60)):
        assert not planted_jumps.missed(np.random.default_rng((0, k))), k
    for k in range(size(80, 200)):
        assert not planted_jumps.accused(np.random.default_rng((0, k))), k
