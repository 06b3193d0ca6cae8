"""Curves and their measures against formulas written out a second time."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.interpolate import CubicSpline

import mafsil as mf
from mafsil.trajectory import (
    MaxDerivativeJump,
    MaxDuration,
    PathMotion,
    TrajectoryGenerator,
    cubic_through,
    linear_blends,
    quintic,
    require,
    time_law,
    trapezoid,
    via_rates,
)
from mafsil.trajectory.motion import PlanStatus
from mafsil.trajectory.timing import generator


@pytest.mark.capability("11-22")
def test_near_a_singularity_rates_are_damped_as_much_as_the_bound_asks():
    """Singular values s: s / (s^2 + d^2) with d^2 = (1 - (s_min / e)^2) e^2, e = s_max / bound."""
    arm, v = mf.load("planar2r"), np.array([0.3, 0.1])
    for bend, bound in ((2e-3, 100.0), (1e-5, 1000.0), (0.4, 1000.0)):
        q = np.array([0.3, bend])
        c, s = np.cos([0.3, 0.3 + bend]), np.sin([0.3, 0.3 + bend])
        J = np.array([[-s[0] - s[1], -s[1]], [c[0] + c[1], c[1]]])
        U, sizes, Vt = np.linalg.svd(J)
        least = sizes[0] / bound
        squared = (1 - (sizes[1] / least) ** 2) * least**2 if sizes[1] < least else 0.0
        found = via_rates(arm, q, linear=[*v, 0.0], most_condition=bound)
        np.testing.assert_allclose(found.qd, Vt.T @ (sizes / (sizes**2 + squared) * (U.T @ v)), rtol=1e-6, atol=1e-9)
        assert found.damping == pytest.approx(np.sqrt(squared), abs=1e-12)
        assert bool(found) == (squared == 0.0)


@pytest.mark.capability("11-47")
def test_one_blend_time_for_all_coordinates():
    D, t, A = np.array([4.0, 1.0, -2.0]), 2.0, 5.0
    plan = linear_blends([[0.0, 0.0, 0.0], D], [t], acceleration=A, common_blend=True)
    blend = max(t / 2 - np.sqrt(A * A * t * t - 4 * A * abs(d)) / (2 * A) for d in D)
    np.testing.assert_allclose(plan.blend, blend, rtol=1e-12)
    np.testing.assert_allclose(plan.slope[0], D / (t - blend), rtol=1e-12)
    np.testing.assert_allclose(plan.acceleration, [D / (blend * (t - blend)), -D / (blend * (t - blend))], rtol=1e-12)
    u = plan.trajectory.at(np.linspace(0, t, 101)).u
    np.testing.assert_allclose(np.cross(u, D), 0.0, atol=1e-12)


@pytest.mark.capability("11-3", "11-24")
def test_derivatives_of_pieces_are_those_of_a_spline():
    points, h = [0.3, 1.0, -0.5, 0.8], [1.0, 0.7, 1.3]
    knots = np.r_[0.0, np.cumsum(h)]
    motion, peer = cubic_through(points, h), CubicSpline(knots, points, bc_type="clamped")
    t = np.array([0.2, 0.9, 1.1, 1.6, 2.5])
    for order in range(4):
        np.testing.assert_allclose(motion.derivative(t, order)[:, 0], peer(t, order), atol=1e-11)
    # A piece beyond its end: the second one, read where the third one is.
    local = 2.5 - knots[1]
    beyond = sum(c * local ** (3 - k) for k, c in enumerate(peer.c[:, 1]))
    assert motion.derivative(2.5, 0, within=1.2)[0] == pytest.approx(beyond)


@pytest.mark.capability("11-35", "11-38")
def test_jerk_of_a_path_in_time_is_the_rate_of_its_acceleration():
    path = cubic_through([[0.1, 0.5], [0.9, -0.4], [0.3, 0.2]], [0.6, 0.4])
    motion, h = PathMotion(path, time_law("quintic").unit().scale_time(1.7)), 1e-5
    t = np.array([0.3, 0.7, 1.4])
    np.testing.assert_allclose(motion.jerk(t), (motion.at(t + h).a - motion.at(t - h).a) / (2 * h), rtol=1e-6)


@pytest.mark.capability("11-26", "11-4")
def test_what_is_missing_is_a_number():
    asked = trapezoid([0.0], [2.0], acceleration=4.0, velocity=1.5, duration=1.0)
    assert asked.status is PlanStatus.TOO_SHORT
    assert asked.residual == pytest.approx(2.0 / 1.5 + 1.5 / 4.0 - 1.0)
    smooth = quintic([0.0], [1.0], 1.0)
    assert require(smooth, MaxDerivativeJump(2)).status.name == "MET"
    assert require(smooth, MaxDerivativeJump(2), MaxDuration(most=0.5)).status.name == "NOT_MET"


@pytest.mark.capability("11-49")
def test_ticks_that_take_longer_than_their_period_are_counted(monkeypatch):
    clock = iter(np.cumsum([0, 900_000, 5, 1_100_000, 5, 1_000_000, 5, 400_000]).tolist())
    monkeypatch.setattr(generator, "perf_counter_ns", lambda: next(clock))
    one = TrajectoryGenerator(quintic([0.0], [1.0], 1.0), rate=1000.0)
    for _ in range(4):
        one.tick()
    report = one.report()
    assert report.overruns == 1
    assert report.worst == pytest.approx(1.1e-3)
