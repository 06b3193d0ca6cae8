"""Time laws as rows: peaks, smoothness, derivatives; double-S within its limits; lines whose velocity jumps."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.errors import InputError
from mafsil.model import JointLimits
from mafsil.trajectory import (
    Trajectory,
    check,
    continuity,
    cubic_through,
    double_s,
    linear_blends,
    quintic,
    straight_lines,
    synchronise_axes,
    time_law,
)
from mafsil.trajectory.motion import PlanStatus
from mafsil.trajectory.profiles import LAWS, SideBySide, profiles
from mafsil.trajectory.profiles.laws import rest_law
from mafsil.trajectory.profiles.shaped_law import ExponentialApproach

ORDERS = {
    "cubic": 1,
    "quintic": 2,
    "septic": 3,
    "cosine": 1,
    "cycloid": 2,
    "exponential": 0,
    "trapezoid": 1,
    "double_s": 2,
    "bang_bang": 1,
}
ways = st.floats(-5.0, 5.0).map(lambda x: round(x, 6))
bounds = st.floats(0.05, 20.0)


@pytest.mark.capability("11-17")
@pytest.mark.parametrize("name", LAWS)
def test_a_law_leads_from_start_to_goal_and_its_derivatives_are_derivatives(name):
    law = time_law(name)
    motion = law.between(np.array([[1.0, -2.0]]), np.array([[3.0, 5.0]]), 2.5)
    assert isinstance(motion, Trajectory)
    np.testing.assert_allclose(motion.at([0.0, 2.5]).u[:, 0], [[1.0, -2.0], [3.0, 5.0]], atol=1e-12)
    h = 1e-5
    breaks = motion.breaks()
    t = np.array([x for x in np.linspace(0.05, 2.45, 49) if np.abs(breaks - x).min() > 3 * h])
    near = [motion.at(t + k * h) for k in (-1, 1)]
    here = motion.at(t)
    np.testing.assert_allclose((near[1].u - near[0].u) / (2 * h), here.v, atol=1e-6)
    np.testing.assert_allclose((near[1].v - near[0].v) / (2 * h), here.a, atol=1e-5)
    np.testing.assert_allclose((near[1].a - near[0].a) / (2 * h), motion.jerk(t), atol=1e-4)
    slower = motion.scale_time(2.0)
    np.testing.assert_allclose(slower.at(2 * t).v, here.v / 2, atol=1e-12)
    np.testing.assert_allclose(slower.jerk(2 * t), motion.jerk(t) / 8, atol=1e-11)


@pytest.mark.parametrize("name", [name for name in LAWS if name != "exponential"])
def test_a_law_backwards_is_the_law(name):
    unit = time_law(name).unit()
    x = np.linspace(0.0, 1.0, 101)[1:-1]
    np.testing.assert_allclose(unit.at(x).u + unit.at(1.0 - x).u, 1.0, atol=1e-14)
    np.testing.assert_allclose(unit.at(x).v, unit.at(1.0 - x).v, atol=1e-13)


@pytest.mark.capability("11-17")
def test_the_table_says_what_the_motions_do():
    table = profiles()
    assert {row.name: row.order for row in table} == ORDERS
    assert len(table) == len(LAWS)
    for row in table:
        motion = time_law(row.name).unit()
        t = np.unique(np.r_[np.linspace(0, 1, 100_001), np.nextafter(motion.breaks()[1:], 0)])
        here = motion.at(t)
        found = [np.abs(here.v).max(), np.abs(here.a).max(), np.abs(motion.jerk(t)).max()]
        np.testing.assert_allclose([row.velocity, row.acceleration, row.jerk], found, rtol=1e-7)
    assert table["cycloid"].velocity == 2.0
    for language in ("en", "ar"):
        assert len(table.explain(language).splitlines()) == len(LAWS) + 2


def test_the_exponential_says_what_it_truncates_and_moves_nothing_that_cannot_jump():
    shape = ExponentialApproach(5.0)
    np.testing.assert_allclose(shape.truncated, np.exp(-5.0))
    true = 1.0 - np.exp(-5.0 * np.array([0.3, 1.0]))
    np.testing.assert_allclose(shape.value(np.array([0.3, 1.0]), 0) * (1.0 - shape.truncated), true, rtol=1e-14)
    with pytest.raises(InputError):
        rest_law("exponential")
    jumps = continuity(LAWS["exponential"].unit()).jumps
    np.testing.assert_allclose([jump.size for jump in jumps], [5 / (1 - np.exp(-5)), -5 / np.expm1(5)], rtol=1e-5)


@pytest.mark.capability("11-13", "11-4")
def test_lines_in_time_name_their_jumps():
    lines = straight_lines([[0.0, 1.0], [2.0, 1.0], [3.0, 0.0]], [1.0, 2.0])
    assert lines.status is PlanStatus.VELOCITY_JUMPS
    np.testing.assert_allclose(lines.details["jumps"], [[2.0, 0.0], [-1.5, -0.5], [-0.5, 0.5]])
    assert lines.residual == 2.0
    measured = continuity(lines.value)
    assert not measured
    assert measured.order == 0
    assert {(jump.time, jump.coordinate): round(jump.size, 9) for jump in measured} == {
        (0.0, 0): 2.0,
        (1.0, 0): -1.5,
        (1.0, 1): -0.5,
        (3.0, 0): -0.5,
        (3.0, 1): 0.5,
    }
    assert straight_lines([1.0, 1.0], 2.0)
    for wrong in ([0.0], [1.0, -1.0], [np.nan, 1.0]):
        with pytest.raises(InputError):
            straight_lines([0.0, 1.0, 2.0], wrong)


@pytest.mark.capability("11-4")
def test_smoothness_is_measured_not_believed():
    points, h = np.random.default_rng(0).normal(size=(6, 2)), [1.0, 0.5, 2.0, 1.0, 0.3]
    assert continuity(cubic_through(points, h), ends=False).order == 2
    assert continuity(cubic_through(points, h)).order == 1
    assert continuity(cubic_through(points, h, velocities="heuristic"), ends=False).order == 1
    assert continuity(linear_blends(points, h, acceleration=60.0).trajectory).order == 1
    assert continuity(quintic(points[0], points[1], 1.0)).order == 2
    assert continuity(quintic(points[0], points[1], 1.0), ends=False).order == 3


@settings(deadline=None, max_examples=100)
@given(D=st.tuples(ways, ways), V=bounds, A=bounds, J=st.floats(0.1, 200.0), both=st.sampled_from(["time", "phase"]))
def test_double_s_keeps_its_limits_and_touches_one(D, V, A, J, both):
    outcome = double_s([0.0, 1.0], [D[0], 1.0 + D[1]], velocity=V, acceleration=A, jerk=J, synchronise=both)
    motion = outcome.value
    assert outcome.succeeded
    if motion.duration == 0.0:
        assert D == (0.0, 0.0)
        return
    at = motion.at(np.unique(np.r_[motion.knots, np.nextafter(motion.knots[1:], 0)]))
    jerk = motion.derivative(motion.knots[:-1], 3)
    shares = [np.abs(at.v).max() / V, np.abs(at.a).max() / A, np.abs(jerk).max() / J]
    assert max(shares) <= 1 + 1e-9
    assert max(shares) > 1 - 1e-9
    np.testing.assert_allclose(motion.at([0.0, motion.duration]).u, [[0.0, 1.0], [D[0], 1 + D[1]]], atol=1e-9)
    np.testing.assert_allclose(motion.at(motion.duration * (1 - 1e-12)).v, 0.0, atol=1e-6)
    if both == "phase":
        u = motion.at(np.linspace(0, motion.duration, 20)).u - [0.0, 1.0]
        np.testing.assert_allclose(u[:, 0] * D[1] - u[:, 1] * D[0], 0.0, atol=1e-9)


def test_double_s_is_as_short_as_ruckig_says():
    ruckig = pytest.importorskip("ruckig")
    rng = np.random.default_rng(5)
    for _ in range(300):
        D, V, A, J = rng.uniform(-4, 4), *np.exp(rng.uniform(-2, 3, 3))
        given = ruckig.InputParameter(1)
        given.current_position, given.target_position = [0.0], [D]
        given.max_velocity, given.max_acceleration, given.max_jerk = [V], [A], [J]
        theirs = ruckig.Trajectory(1)
        ruckig.Ruckig(1).calculate(given, theirs)
        ours = double_s(0.0, D, velocity=V, acceleration=A, jerk=J).value.duration
        np.testing.assert_allclose(ours, theirs.duration, rtol=1e-9)


def test_double_s_of_a_given_duration():
    shortest = double_s(0.0, 1.0, velocity=1.0, acceleration=2.0, jerk=10.0).value.duration
    late = double_s(0.0, 1.0, velocity=1.0, acceleration=2.0, jerk=10.0, duration=2 * shortest)
    assert late.succeeded
    assert late.value.duration == pytest.approx(2 * shortest)
    early = double_s(0.0, 1.0, velocity=1.0, acceleration=2.0, jerk=10.0, duration=0.5 * shortest)
    assert early.status is PlanStatus.TOO_SHORT
    assert early.value.duration == shortest
    assert double_s(0.0, 1.0, jerk=10.0).succeeded
    assert double_s(1.0, 1.0, jerk=10.0).value.duration == 0.0
    for wrong in ({"jerk": np.inf}, {"jerk": 0.0}, {"jerk": 1.0, "velocity": 0.0}, {"jerk": np.nan}, {"jerk": [1, 2]}):
        with pytest.raises(InputError):
            double_s(0.0, 1.0, **wrong)


def test_axes_of_different_kinds_arrive_together():
    arm = quintic([0.0, 1.0], [1.0, 3.0], 2.0)
    slide = double_s(0.0, 5.0, velocity=1.0, acceleration=2.0, jerk=10.0).value
    both = synchronise_axes(arm, slide, LAWS["cosine"].unit())
    assert isinstance(both, SideBySide)
    assert isinstance(both, Trajectory)
    assert both.n == 4
    end = both.at(both.duration)
    np.testing.assert_allclose(end.u, [1.0, 3.0, 5.0, 1.0], atol=1e-12)
    before = both.at(both.duration * (1 - 1e-6)).v
    assert (np.abs(before) > 0.0).all()
    assert both.scale_time(2.0).duration == 2 * both.duration
    assert len(both.breaks()) >= 8
    with pytest.raises(InputError):
        synchronise_axes()
    tight = JointLimits(*(np.full(4, x) for x in (-1e-3, 1e-3, 1e-3, 1e-3, 1e-3, 1e-3)))
    assert not check(both, tight)
