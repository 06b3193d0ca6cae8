"""Shortest times along paths beside TOPP-RA on its own fine grid, and beside a nonlinear program."""

from __future__ import annotations

import numpy as np
import pytest

from mafsil.trajectory import JointPath, MotionLimits, check, time_optimal
from tests.sizes import size
from tests.trajectory.nonlinear_program import shortest_time

toppra = pytest.importorskip("toppra")
PLACES = 2000


def theirs(path, velocity, acceleration):
    """TOPP-RA's duration on a fine grid along the same cubic spline."""
    toppra.setup_logging("ERROR")
    knots = path.breaks()
    spline = toppra.SplineInterpolator(knots, path.at(knots).u, bc_type="natural")
    np.testing.assert_allclose(spline(0.37 * path.end), path.at(0.37 * path.end).u, atol=1e-9)
    constraints = [
        toppra.constraint.JointVelocityConstraint(np.stack([-velocity, velocity], axis=1)),
        toppra.constraint.JointAccelerationConstraint(np.stack([-acceleration, acceleration], axis=1)),
    ]
    solver = toppra.algorithm.TOPPRA(
        constraints, spline, gridpoints=np.linspace(0.0, path.end, PLACES + 1), parametrizer="ParametrizeConstAccel"
    )
    return solver.compute_trajectory().duration


@pytest.mark.parametrize("seed", range(6))
def test_durations_agree_to_a_thousandth_and_limits_are_kept(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 8))
    velocity, acceleration = rng.uniform(1, 3, n), rng.uniform(3, 9, n)
    path = JointPath.through(rng.uniform(-1, 1, (int(rng.integers(4, 8)), n)))
    limits = MotionLimits.of(n, velocity=velocity, acceleration=acceleration)
    found = time_optimal(path, limits, intervals=PLACES)
    assert found
    assert check(found.trajectory, limits, tolerance=1e-6)
    assert found.duration == pytest.approx(theirs(path, velocity, acceleration), rel=1e-3)


@pytest.mark.parametrize("seed", range(size(2, 5)))
@pytest.mark.parametrize("jerk", [np.inf, 10.0])
def test_durations_are_those_of_a_nonlinear_program(seed, jerk):
    """IPOPT keeps limits on its grid only and holds its control over each interval: near from both sides."""
    rng = np.random.default_rng(seed)
    path = JointPath.through(rng.uniform(-1, 1, (4, 3)))
    limits = MotionLimits.of(3, velocity=1.0, acceleration=2.0, jerk=jerk)
    found = time_optimal(path, limits).duration
    reference = shortest_time(path, limits, found, intervals=100)
    assert found == pytest.approx(reference, rel=2e-3 if np.isfinite(jerk) else 5e-3)
    assert np.isfinite(jerk) or found < reference * (1 + 1e-4)
