"""Straight lines with blends: they meet their ends, are what their parts say, and say what they lack."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil.errors import InputError
from mafsil.trajectory import MotionLimits, Trajectory, check, linear_blends
from mafsil.trajectory.motion import BlendStatus
from mafsil.trajectory.splines import BLENDS, first_leg, interior_blend, last_leg, single_leg

values = st.floats(-10.0, 10.0).map(lambda x: round(x, 3))
paths = st.integers(2, 6).flatmap(
    lambda m: st.tuples(
        st.lists(st.tuples(values, values), min_size=m, max_size=m).map(np.array),
        st.lists(st.floats(0.2, 3.0), min_size=m - 1, max_size=m - 1).map(np.array),
    )
)


def by_integration(plan, t):
    """u(t) from the accelerations alone: two sums over the pieces of a parabolic plan."""
    u = np.zeros((len(t), plan.points.shape[-1]))
    for k in range(u.shape[1]):
        T = plan.via_times.copy()
        T[0] += plan.blend[0, k] / 2
        T[-1] -= plan.blend[-1, k] / 2
        for centre, b, a in zip(T, plan.blend[:, k], plan.acceleration[:, k], strict=True):
            x = np.clip(t - (centre - b / 2), 0.0, None)
            y = np.clip(t - (centre + b / 2), 0.0, None)
            u[:, k] += a * (x**2 - y**2) / 2
    return u + plan.points[0]


@pytest.mark.capability("11-14", "11-25", "11-27")
@settings(deadline=None, max_examples=60)
@given(path=paths, A=st.floats(0.5, 200.0))
def test_the_motion_is_its_accelerations_integrated_twice(path, A):
    points, durations = path
    plan = linear_blends(points, durations, acceleration=A)
    assume(plan)
    motion = plan.trajectory
    assert isinstance(motion, Trajectory)
    t = np.linspace(0.0, motion.duration, 301)
    size = 1e-10 * (1.0 + A * motion.duration**2)
    np.testing.assert_allclose(motion.at(t).u, by_integration(plan, t), atol=size)
    begin, end = motion.at([0.0, motion.duration]).u
    np.testing.assert_allclose([begin, end], points[[0, -1]], atol=1e-11)
    assert np.abs(motion.at(t).a).max() <= A * (1 + 1e-12)
    for ours, other in zip(motion.at(t[1:-1]), motion.to_polynomial().at(t[1:-1]), strict=True):
        scale = 1e-9 * (1.0 + A * motion.duration**2)
        assert (np.abs(ours - other) <= scale).mean() > 0.99  # At a jump of acceleration rounding decides the side.


@pytest.mark.capability("11-30", "11-26")
@settings(deadline=None, max_examples=60)
@given(path=paths, A=st.floats(0.2, 50.0))
def test_what_a_plan_says_it_lacks_is_what_makes_it_feasible(path, A):
    points, durations = path
    plan = linear_blends(points[:, :1], durations, acceleration=A)
    assume(not plan)
    assert plan.trajectory is None
    (lack,) = plan.infeasible
    assert plan.status is lack.status
    assert lack.status in (BlendStatus.TOO_SHORT_TO_BLEND, BlendStatus.BLENDS_OVERLAP)
    assert linear_blends(points[:, :1], durations, acceleration=lack.least_acceleration)
    slower = durations * lack.stretch * (1 + 1e-12)
    assert linear_blends(points[:, :1], slower, acceleration=A)
    assert not linear_blends(points[:, :1], durations * lack.stretch * (1 - 1e-6), acceleration=A)
    assert not linear_blends(points[:, :1], durations, acceleration=lack.least_acceleration * (1 - 1e-6))
    longer = durations.copy()
    longer[lack.leg] = lack.duration_needed * (1 + 1e-12)
    again = linear_blends(points[:, :1], longer, acceleration=A)
    if lack.status is BlendStatus.TOO_SHORT_TO_BLEND:
        assert not np.isnan(again.slope[lack.leg]).any()
    else:
        assert again.straight[lack.leg].min() >= -1e-12


@pytest.mark.capability("11-28")
def test_legs_alone_are_those_of_the_whole():
    points, h, A = np.array([10.0, 35.0, 25.0, 10.0]), np.array([2.0, 1.0, 3.0]), np.float64(50.0)
    plan = linear_blends(points, h, acceleration=50.0)
    begin, end = first_leg(points[1] - points[0], h[0], A), last_leg(points[3] - points[2], h[2], A)
    np.testing.assert_allclose([begin.blend, end.blend], plan.blend[[0, -1], 0], rtol=1e-14)
    np.testing.assert_allclose([begin.acceleration, end.acceleration], plan.acceleration[[0, -1], 0])
    middle = interior_blend(begin.slope, (points[2] - points[1]) / h[1], A)
    np.testing.assert_allclose(middle, [plan.acceleration[1, 0], plan.blend[1, 0]], rtol=1e-14)
    alone = single_leg(np.float64(-60.0), np.float64(3.0), np.float64(40.0), np.float64(20.0))
    np.testing.assert_allclose(-alone.slope * (3.0 - sum(alone.blend) / 2), 60.0, rtol=1e-14)


@pytest.mark.capability("11-31")
@settings(deadline=None, max_examples=60)
@given(path=paths, A=st.floats(20.0, 500.0), shape=st.sampled_from(sorted(BLENDS)))
def test_the_miss_is_where_the_motion_is(path, A, shape):
    points, durations = path
    plan = linear_blends(points, durations, acceleration=A, blend=shape)
    assume(plan)
    at = plan.trajectory.at(plan.via_times[1:-1]).u
    np.testing.assert_allclose(at - points[1:-1], plan.miss, atol=1e-10)
    stronger = linear_blends(points, durations, acceleration=10 * A, blend=shape)
    # End slopes change a little, so each miss shrinks, if not by ten.
    assert np.abs(stronger.miss).sum() <= np.abs(plan.miss).sum() + 1e-12


@pytest.mark.capability("11-48")
def test_quintic_blends_have_no_acceleration_at_their_ends():
    plan = linear_blends([0.0, 20.0, 10.0], [2.0, 2.0], acceleration=60.0, blend="quintic")
    motion = plan.trajectory
    edges = motion.breaks()
    for side in (-1e-9, 1e-9):
        assert np.abs(motion.at(edges + side).a).max() < 1e-5
    t = np.linspace(0.0, 4.0, 40_001)
    np.testing.assert_allclose(np.abs(motion.at(t).a).max(), 60.0, rtol=1e-6)
    slope = np.gradient(motion.at(t).v[:, 0], t)
    np.testing.assert_allclose(slope[5:-5], motion.at(t).a[5:-5, 0], atol=0.1)


@pytest.mark.capability("11-47")
@settings(deadline=None, max_examples=60)
@given(path=paths, A=st.floats(5.0, 200.0))
def test_a_common_blend_keeps_to_the_line_and_below_the_acceleration(path, A):
    points, durations = path
    plan = linear_blends(points, durations, acceleration=[A, 2 * A], common_blend=True)
    assert np.array_equal(plan.blend[:, 0], plan.blend[:, 1], equal_nan=True)
    assume(plan)
    assert (np.abs(plan.acceleration) <= np.array([A, 2 * A]) * (1 + 1e-9)).all()
    if len(points) == 2:
        u = plan.trajectory.at(np.linspace(0, plan.trajectory.duration, 50)).u
        D = points[1] - points[0]
        np.testing.assert_allclose(np.cross(np.c_[u - points[0], 0 * u[:, 0]], [*D, 0.0]), 0.0, atol=1e-9)


@pytest.mark.capability("11-32")
def test_points_are_passed_exactly_with_the_velocity_that_was_asked():
    points = np.array([[0.0, 0.0], [20.0, 5.0], [30.0, -5.0], [10.0, 0.0]])
    asked = np.array([7.5, 1.0])
    plan = linear_blends(points, [2.0, 2.0, 3.0], acceleration=50.0, through={1: asked, 2: None})
    assert plan
    assert len(plan.points) == 6
    at = plan.trajectory.at([2.0, 4.0])
    np.testing.assert_allclose(at.u, points[1:3], atol=1e-12)
    mean = ((points[2] - points[1]) / 2 + (points[3] - points[2]) / 3) / 2
    np.testing.assert_allclose(at.v, [asked, mean], atol=1e-12)
    # The shortest delta: the larger blend beside each pseudo via point just ends at the point itself.
    assert plan.straight[[1, 3]].min() >= 0.0
    np.testing.assert_allclose(plan.blend[1:3].max(), plan.durations[1], rtol=1e-6)
    with pytest.raises(InputError):
        linear_blends(points, [2.0, 2.0, 3.0], acceleration=50.0, through={1: asked}, delta=2.5)
    with pytest.raises(InputError):
        linear_blends(points, [2.0, 2.0, 3.0], acceleration=50.0, through={0: asked})


@pytest.mark.capability("11-33")
def test_a_stop_rests_in_its_point_for_as_long_as_asked():
    plan = linear_blends([0.0, 20.0, 30.0], [2.0, 2.0], acceleration=50.0, stops={1: 0.5})
    t = np.linspace(0.0, plan.trajectory.duration, 20_001)
    still = t[(np.abs(plan.trajectory.at(t).v[:, 0]) == 0.0) & (t > 0.5) & (t < 4.0)]
    np.testing.assert_allclose(np.ptp(still), 0.5, atol=5e-4)
    np.testing.assert_array_equal(plan.trajectory.at(still).u[:, 0], 20.0)
    instant = linear_blends([0.0, 20.0, 30.0], [2.0, 2.0], acceleration=50.0, stops={1: 0.0})
    np.testing.assert_allclose(instant.straight[1], 0.0, atol=1e-15)
    by_hand = linear_blends([0.0, 20.0, 20.0, 30.0], [2.0, instant.durations[1], 2.0], acceleration=50.0)
    np.testing.assert_array_equal(by_hand.blend, instant.blend)


@pytest.mark.capability("11-29")
@settings(deadline=None, max_examples=60)
@given(path=paths, seed=st.integers(0, 1000))
def test_durations_from_limits_hold_their_blends_and_keep_the_limits(path, seed):
    points, _ = path
    assume(np.abs(np.diff(points, axis=0)).max() > 0.01)
    rng = np.random.default_rng(seed)
    sides = rng.uniform(0.5, 5.0, (2, 2, 2))
    limits = MotionLimits.of(2, velocity=(-sides[0, 0], sides[0, 1]), acceleration=(-sides[1, 0], sides[1, 1]))
    plan = linear_blends(points, limits=limits)
    assert plan
    motion = plan.trajectory.at(np.linspace(0.0, plan.trajectory.duration, 2001))
    for values, (low, high) in ((motion.v, limits.velocity), (motion.a, limits.acceleration)):
        assert (values >= low - 1e-9).all()
        assert (values <= high + 1e-9).all()


def test_default_limits_are_those_of_a_robot():
    robot = mf.load("puma560")
    q = np.array([[0.0] * 6, [0.3, -0.5, 0.2, 0.0, 0.4, 0.1], [0.6, -0.2, 0.1, 0.3, 0.2, 0.0]])
    plan = linear_blends(q, velocity=0.5, acceleration=4.0)
    assert plan
    assert check(plan.trajectory, robot.limits)


@pytest.mark.capability("11-27")
def test_a_batch_is_its_rows_and_names_the_bad_ones():
    rng = np.random.default_rng(3)
    points = rng.normal(size=(7, 5, 3))
    h = rng.uniform(1.0, 2.0, 4)
    plan = linear_blends(points, h, acceleration=15.0)
    assert plan
    t = np.linspace(0.0, h.sum(), 57)
    together = plan.trajectory.at(t)
    for k in range(7):
        alone = linear_blends(points[k], h, acceleration=15.0)
        for ours, other in zip(together, alone.trajectory.at(t), strict=True):
            np.testing.assert_array_equal(ours[:, k], other)
    points[4, 2] += 40.0
    mixed = linear_blends(points, h, acceleration=15.0)
    assert not mixed
    assert [lack.row for lack in mixed] == [(4,)]
    assert mixed.status[3] is BlendStatus.PLANNED
    assert not mixed.status[4].succeeded
    assert len(mixed) == 7


def test_repeated_points_at_both_ends_and_motions_of_no_length():
    plan = linear_blends([1.0, 1.0, 3.0, 3.0], [1.0, 2.0, 1.0], acceleration=10.0)
    assert plan
    np.testing.assert_array_equal(plan.blend[[0, -1], 0], 0.0)
    np.testing.assert_array_equal(plan.slope[[0, -1], 0], 0.0)
    for still in (
        linear_blends([2.0, 2.0], acceleration=1.0, velocity=1.0),
        linear_blends([2.0, 2.0], 1.0, acceleration=1.0),
    ):
        assert still
        np.testing.assert_array_equal(still.trajectory.at([0.0, 0.5, 1.0]).u, 2.0)
    # Two points at one place and no durations: the stop takes as long as its blends.
    stop = linear_blends([0.0, 1.0, 1.0, 2.0], velocity=1.0, acceleration=4.0)
    assert stop
    assert stop.durations[1] > 0.0


@pytest.mark.parametrize(
    "wrong",
    [
        {"points": [0.0, np.nan]},
        {"points": [0.0]},
        {"points": np.zeros((2, 0))},
        {"durations": [0.0]},
        {"durations": [-1.0]},
        {"durations": [1.0, 1.0]},
        {"durations": [np.inf]},
        {"acceleration": 0.0},
        {"acceleration": -1.0},
        {"acceleration": np.inf},
        {"acceleration": None},
        {"acceleration": [1.0, 2.0, 3.0]},
        {"acceleration": None, "limits": MotionLimits.of(1)},
        {"acceleration": None, "limits": MotionLimits.of(1, acceleration=0.0)},
        {"durations": None},
        {"durations": None, "velocity": 0.0},
        {"durations": None, "velocity": np.inf},
        {"durations": None, "limits": MotionLimits.of(1, velocity=0.0)},
        {"stops": {1: 0.0}},
        {"through": {5: None}},
        {"blend": "cubic"},
    ],
)
def test_what_cannot_be_is_refused_by_name(wrong):
    with pytest.raises(InputError):
        linear_blends(**{"points": [0.0, 1.0], "durations": [1.0], "acceleration": 10.0} | wrong)


def test_answers_speak_both_languages_and_are_data():
    plan = linear_blends([0.0, 20.0, 10.0], [1.0, 2.0], acceleration=30.0)
    for language in ("en", "ar"):
        assert "1.1547" in plan.explain(language)
    assert plan.to_dict()["infeasible"][0]["leg"] == 0
    assert "60" not in repr(plan)


@pytest.mark.capability("11-47")
def test_separate_blends_leave_the_line_and_common_ones_do_not():
    # Numbers of the specification: (0, 0) -> (4, 1) within 2 s, 5 for each.
    apart = linear_blends([[0.0, 0.0], [4.0, 1.0]], 2.0, acceleration=5.0)
    np.testing.assert_allclose(apart.blend[0], [0.552786, 0.105573], atol=1e-6)
    u = apart.trajectory.at(np.linspace(0.0, 2.0, 20_001)).u
    np.testing.assert_allclose(np.abs(u @ [-1.0, 4.0]).max() / 17**0.5, 0.081096, atol=1e-6)
    u = linear_blends([[0.0, 0.0], [4.0, 1.0]], 2.0, acceleration=5.0, common_blend=True).trajectory.at([0.1, 0.5]).u
    np.testing.assert_allclose(u @ [-1.0, 4.0], 0.0, atol=1e-15)


@pytest.mark.capability("11-29")
@pytest.mark.parametrize("speed", [0.8, 3.0])
@pytest.mark.parametrize("points", [[0.0, 1.0, 0.0, 1.0], [0.0, 0.4, -0.7, 0.9, 0.1], [0.0, 1.0, 1.1, -0.5, -0.5, 2.0]])
def test_legs_hold_their_blends_by_the_book_s_formulas(points, speed):
    """Blends by hand: T - sqrt(T^2 - 2 D/A) at the ends, |v' - v| / A at inner points; half of each is in a leg."""
    A, D = 4.0, np.diff(points)
    plan = linear_blends(points, velocity=speed, acceleration=A)
    assert plan
    T = plan.durations
    ends = [T[k] - np.sqrt(T[k] ** 2 - 2.0 * abs(D[k]) / A) for k in (0, -1)]
    v = D / T
    v[0], v[-1] = D[0] / (T[0] - ends[0] / 2.0), D[-1] / (T[-1] - ends[1] / 2.0)
    blends = np.concatenate([[2.0 * ends[0]], np.abs(np.diff(v)) / A, [2.0 * ends[1]]])
    assert (T - (blends[:-1] + blends[1:]) / 2.0).min() > -1e-9
    assert (T > np.abs(D) / speed - 1e-12).all()


@pytest.mark.capability("11-29")
@pytest.mark.parametrize("speed", [5.0, 50.0, 5e3])
def test_speeds_that_no_leg_reaches_do_not_make_legs_long(speed):
    """Three legs of 1 rad without a stop take at least 2 sqrt(3/4) s; blends take some more."""
    plan = linear_blends([0.0, 1.0, 2.0, 3.0], velocity=speed, acceleration=4.0)
    assert plan
    assert 2.0 * np.sqrt(3.0 / 4.0) < plan.durations.sum() < 2.2
    stop = linear_blends([0.0, 1.0, 1.0, 0.5, 3.0], velocity=speed, acceleration=4.0)
    assert stop
    assert stop.durations.sum() < 4.2


def test_a_stop_lasts_as_long_as_the_blends_on_both_sides_of_it():
    """D = v = 1, A = 4: end legs last 1 s and reach 1 / (1 - t0/2), t0 = 1 - sqrt(1/2), which ends within that / A."""
    plan = linear_blends([0.0, 1.0, 1.0, 2.0], velocity=1.0, acceleration=4.0)
    slope = 1.0 / (1.0 - (1.0 - np.sqrt(0.5)) / 2.0)
    np.testing.assert_allclose(plan.durations, [1.0, slope / 4.0, 1.0], rtol=1e-9)
