"""The shortest time along paths: laws of scale, limits between the places, by hand, and what has no timing."""

from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil.errors import InputError
from mafsil.trajectory import JointPath, MotionLimits, quintic, sequence, time_optimal, trapezoid
from mafsil.trajectory.profiles import rest
from mafsil.trajectory.splines import PiecewisePolynomial
from mafsil.trajectory.timing import TimeOptimal
from mafsil.trajectory.timing.timing_answer import TimingStatus
from tests.budget import within

ALLOWED = 1e-6


def drawn(seed: int, n: int = 7, kind: Any = "spline", size: float = 1.0) -> tuple[JointPath, MotionLimits]:
    """A random path, and limits with sides of their own."""
    rng = np.random.default_rng(seed)
    points = size * rng.uniform(-2.0, 2.0, size=(int(rng.integers(2, 9)), n))
    bounds = [(-scale * rng.uniform(0.5, 2, n), scale * rng.uniform(0.5, 2, n)) for scale in (2.0, 6.0)]
    return JointPath.through(points, kind), MotionLimits.of(n, velocity=bounds[0], acceleration=bounds[1])


def excess(answer: TimeOptimal, samples: int = 20_001) -> float:
    """The largest excess at many times, as share of the limit."""
    assert answer.trajectory is not None
    motion = answer.trajectory.at(np.linspace(0.0, answer.duration, samples))
    pairs = ((motion.v, answer.limits.velocity), (motion.a, answer.limits.acceleration))
    return max(float((np.maximum(value / high, value / low) - 1.0).max()) for value, (low, high) in pairs)


@settings(max_examples=40, deadline=None)
@given(seed=st.integers(0, 10**6), n=st.integers(1, 8), exponent=st.floats(-6.0, 1.0))
def test_limits_hold_between_the_places(seed: int, n: int, exponent: float) -> None:
    path, limits = drawn(seed, n, size=10.0**exponent)
    answer = time_optimal(path, limits, intervals=60)
    assert answer, answer.explain()
    assert answer.excess <= ALLOWED
    assert excess(answer) <= ALLOWED
    assert answer.trajectory is not None
    np.testing.assert_allclose(answer.trajectory.at(answer.duration).u, path.at(path.end).u, atol=1e-9)
    np.testing.assert_allclose(answer.trajectory.at([0.0, answer.duration]).v, 0.0, atol=1e-9)


def test_long_paths_are_timed_in_stretches_as_in_one() -> None:
    """Beside a long path a short one is timed in stretches: to the bit as alone."""
    walk = np.cumsum(np.random.default_rng(2).uniform(-0.2, 0.2, (600, 3)), axis=0)
    limits = MotionLimits.of(3, velocity=1.5, acceleration=3.0)
    short, long = JointPath.through(walk[:300]), JointPath.through(walk)
    alone, beside = time_optimal(short, limits), time_optimal([short, long], limits)
    assert alone.duration == beside[0].duration
    for name in ("caps", "low", "high", "x"):
        np.testing.assert_array_equal(getattr(alone.timing, name), getattr(beside[0].timing, name))
    assert beside[1].excess <= ALLOWED
    assert excess(beside[1]) <= ALLOWED


def test_a_long_polygon_takes_the_sum_of_its_sides() -> None:
    points = np.cumsum(np.random.default_rng(4).uniform(-0.2, 0.2, (501, 2)), axis=0)
    limits = MotionLimits.of(2, velocity=1.5, acceleration=3.0)
    whole = time_optimal(JointPath.through(points, "lines"), limits, intervals=2)
    sides = [JointPath.through(points[k : k + 2], "lines") for k in range(500)]
    assert whole.duration == pytest.approx(time_optimal(sides, limits, intervals=2).durations.sum(), rel=1e-12)


def test_a_path_of_many_points_costs_what_its_points_cost() -> None:
    limits = MotionLimits.of(7, velocity=1.5, acceleration=3.0)
    points = np.cumsum(np.random.default_rng(1).uniform(-0.2, 0.2, (10_000, 7)), axis=0)
    time_optimal(JointPath.through(points[:10]), limits)
    assert within(0.2, lambda: time_optimal(JointPath.through(points), limits)).excess <= ALLOWED


def test_a_straight_line_is_the_trapezoid_and_the_triangle() -> None:
    path = JointPath.through([[0.0, 0.0], [3.0, -1.0]])
    for velocity in (1.0, 100.0):
        limits = MotionLimits.of(2, velocity=velocity, acceleration=2.0)
        by_hand = trapezoid(0.0, 3.0, velocity=velocity, acceleration=2.0).value.duration
        assert time_optimal(path, limits).duration == pytest.approx(by_hand, rel=1e-3)
        assert time_optimal(path, limits).duration >= by_hand * (1 - 1e-12)


def test_one_sided_limits_of_a_line() -> None:
    limits = MotionLimits.of(1, velocity=100.0, acceleration=(-1.0, 4.0))
    path = JointPath.through([[0.0], [2.0]])
    # t1 = v/4, t2 = v, v^2/8 + v^2/2 = 2.
    v = np.sqrt(2.0 / (1 / 8 + 1 / 2))
    assert time_optimal(path, limits, intervals=2000).duration == pytest.approx(v / 4 + v, rel=1e-3)
    back = MotionLimits.of(1, velocity=100.0, acceleration=(-4.0, 1.0))
    assert time_optimal(path, back, intervals=2000).duration == pytest.approx(v / 4 + v, rel=1e-3)


def test_a_circle_at_its_centripetal_limit() -> None:
    s = np.linspace(0.0, 2 * np.pi, 200)
    circle = JointPath.through(np.stack([np.cos(s), np.sin(s)], axis=1))
    limits = MotionLimits.of(2, velocity=10.0, acceleration=1.0)
    answer = time_optimal(circle, limits)
    # On a circle of radius 1 no speed above sqrt(sqrt(2)) keeps both components, and none above 1 everywhere.
    assert 0.99 < answer.velocities[len(answer.velocities) // 2, 1] <= 2.0**0.25 + 1e-3
    assert {binding.quantity for binding in answer.bindings} == {"acceleration"}


@pytest.mark.parametrize("seed", range(4))
def test_the_duration_is_near_that_on_a_much_finer_grid(seed: int) -> None:
    path, limits = drawn(seed)
    fine = time_optimal(path, limits, intervals=10_000).duration
    assert fine <= time_optimal(path, limits).duration * (1 + 1e-9)
    assert time_optimal(path, limits).duration <= fine * 1.001


@pytest.mark.parametrize("seed", range(4))
def test_scale_and_reversal(seed: int) -> None:
    path, limits = drawn(seed)
    duration = time_optimal(path, limits, intervals=200).duration
    twice = MotionLimits.of(7, velocity=tuple(2 * limits.velocity), acceleration=tuple(4 * limits.acceleration))
    assert time_optimal(path, twice, intervals=200).duration == pytest.approx(duration / 2, rel=1e-9)
    swapped = MotionLimits.of(7, velocity=tuple(-limits.velocity[::-1]), acceleration=tuple(limits.acceleration))
    assert time_optimal(path.reverse(), swapped, intervals=2000).duration == pytest.approx(
        time_optimal(path, limits, intervals=2000).duration, rel=1e-3
    )


def test_more_of_a_limit_never_costs_time() -> None:
    path, limits = drawn(5)
    duration = time_optimal(path, limits, intervals=300).duration
    for factor in (1.01, 1.5):
        more = MotionLimits.of(7, velocity=tuple(factor * limits.velocity), acceleration=tuple(limits.acceleration))
        assert time_optimal(path, more, intervals=300).duration <= duration * (1 + 1e-9)


@pytest.mark.parametrize("size", [1e-6, 1e-9, 1e3])
def test_paths_of_any_size(size: float) -> None:
    path, limits = drawn(7)
    answer = time_optimal(JointPath.through(size * path.at(path.breaks()).u), limits)
    assert answer
    assert excess(answer) <= ALLOWED


def test_short_legs_between_stops_take_their_time() -> None:
    """A leg of a thousandth of the path speeds up and slows down, too: each leg takes 2 sqrt(d / a)."""
    limits = MotionLimits.of(1, velocity=100.0, acceleration=5.0)
    points = np.array([[0.0], [1e-3], [-1.0], [-0.9999], [-1.5]])
    found = time_optimal(JointPath.through(points, "lines"), limits)
    legs = np.abs(np.diff(points[:, 0]))
    assert found.duration == pytest.approx(float(2.0 * np.sqrt(legs / 5.0).sum()), rel=1e-3)


def test_corners_are_stops() -> None:
    path, limits = drawn(3, kind="lines")
    answer = time_optimal(path, limits)
    assert answer.trajectory is not None
    corners = path.corners()
    assert len(corners)
    at = np.searchsorted(answer.timing.s, corners)
    np.testing.assert_allclose(answer.velocities[at, 1], 0.0)
    assert excess(answer) <= ALLOWED
    legs = [
        JointPath.through(path.at(pair).u, "lines") for pair in np.stack([path.breaks()[:-1], path.breaks()[1:]], 1)
    ]
    assert answer.duration == pytest.approx(float(time_optimal(legs, limits).durations.sum()), rel=3e-3)


def test_a_batch_is_its_paths_one_by_one() -> None:
    limits = drawn(0)[1]
    paths = [drawn(seed)[0] for seed in range(9)] + [drawn(2, kind="lines")[0], JointPath.through([[1.0] * 7] * 2)]
    batch = time_optimal(paths, limits)
    assert batch
    assert len(batch) == len(paths)
    for path, answer in zip(paths[:9], batch, strict=False):
        np.testing.assert_array_equal(time_optimal(path, limits).velocities, answer.velocities)
    # Lines among splines are cubics: the same motion on a slightly different grid.
    assert time_optimal(paths[9], limits).duration == pytest.approx(batch[9].duration, rel=1e-3)
    assert "11" in batch.explain()
    assert len(time_optimal([], limits)) == 0


def test_what_stands_beside_a_path_does_not_change_a_bit_of_it() -> None:
    """Paths of other lengths in the lanes beside, and lanes without a path of their own."""
    rng = np.random.default_rng(3)
    limits = MotionLimits.of(3, velocity=[1.0, 2.0, 0.7], acceleration=(-2.0, 3.0))
    paths = [JointPath.through(rng.uniform(-1.0, 1.0, (count, 3))) for count in (2, 9, 4, 3, 12, 2, 5, 7, 3, 6, 2)]
    for intervals in (None, 7):
        batch = time_optimal(paths, limits, intervals=intervals)
        for path, answer, duration in zip(paths, batch, batch.durations, strict=True):
            alone = time_optimal(path, limits, intervals=intervals)
            assert alone.duration == answer.duration == duration
            assert np.array_equal(alone.velocities, answer.velocities)
            assert np.array_equal(alone.limit_curve, answer.limit_curve)


def test_velocities_at_the_ends() -> None:
    path, limits = drawn(1)
    answer = time_optimal(path, limits, start_path_velocity=0.1, end_path_velocity=0.05)
    np.testing.assert_allclose(answer.velocities[[0, -1], 1], [0.1, 0.05], rtol=1e-9)
    assert answer.duration < time_optimal(path, limits).duration
    fast = time_optimal(path, limits, start_path_velocity=50.0)
    assert fast.status is TimingStatus.START_VELOCITY
    assert not fast
    highest = float(str(fast.details["highest"]))
    assert time_optimal(path, limits, start_path_velocity=highest * 0.999)
    assert not time_optimal(path, limits, start_path_velocity=highest * 1.01)
    assert time_optimal(path, limits, end_path_velocity=50.0).status is TimingStatus.END_VELOCITY


def test_the_path_of_a_trajectory_that_rests_at_its_ends() -> None:
    limits = MotionLimits.of(2, velocity=1.0, acceleration=2.0)
    slow = quintic([0.0, 0.0], [1.0, 0.5], 10.0)
    answer = time_optimal(slow, limits)
    assert excess(answer) <= ALLOWED
    assert answer.duration == pytest.approx(1.5, rel=0.01)
    twice = time_optimal(
        JointPath.of(sequence(slow, rest([1.0, 0.5], 1.0), slow_back := quintic([1.0, 0.5], [0, 0], 5.0))), limits
    )
    assert slow_back.duration == 5.0
    assert twice.duration == pytest.approx(3.0, rel=0.01)


def test_what_does_not_move_takes_no_time() -> None:
    limits = MotionLimits.of(2, velocity=1.0, acceleration=2.0)
    for path in (
        JointPath.through([[1.0, 2.0]]),
        JointPath.through([[1.0, 2.0]] * 4, "lines"),
        JointPath.of(rest([1.0, 2.0], 3.0)),
    ):
        answer = time_optimal(path, limits)
        assert answer
        assert answer.duration == 0.0
        assert answer.trajectory is not None
        np.testing.assert_allclose(answer.trajectory.at([0.0, 1.0]).u, [[1.0, 2.0]] * 2)


def test_why_there_is_no_timing() -> None:
    path, _ = drawn(2)
    one = np.ones(7)
    still = MotionLimits.of(7, velocity=np.where(np.arange(7) == 3, 0.0, one), acceleration=one)
    answer = time_optimal(path, still)
    assert answer.status is TimingStatus.NO_MOTION
    assert answer.details["joint"] == 3
    assert answer.trajectory is None
    assert answer.duration == np.inf
    assert time_optimal(path, MotionLimits.of(7, velocity=one, acceleration=0.0)).status is TimingStatus.NO_MOTION
    narrow = time_optimal(path, MotionLimits.of(7, velocity=one, acceleration=one, position=0.5))
    assert narrow.status is TimingStatus.POSITION
    place, joint = float(str(narrow.details["place"])), int(str(narrow.details["joint"]))
    assert abs(path.at(place).u[joint]) == pytest.approx(
        np.abs(path.at(np.linspace(0, path.end, 4001)).u).max(), rel=1e-4
    )
    for language in ("en", "ar"):
        assert answer.explain(language)
        assert narrow.explain(language)


def test_what_limits_is_said() -> None:
    path, limits = drawn(4)
    answer = time_optimal(path, limits)
    ends = np.array([(binding.begin, binding.end) for binding in answer.bindings])
    np.testing.assert_allclose(ends[1:, 0], ends[:-1, 1])
    assert ends[-1, 1] == pytest.approx(answer.duration)
    assert min(binding.share for binding in answer.bindings) > 0.9
    assert len(repr(answer).splitlines()) <= 25
    assert answer.to_dict()["status"] == "timed"


def test_what_a_greater_limit_would_save() -> None:
    limits = MotionLimits.of(2, velocity=[1.0, 100.0], acceleration=[2.0, 100.0])
    answer = time_optimal(JointPath.through([[0.0, 0.0], [3.0, 1.0]]), limits, intervals=1000)
    # d/v + v/a: one per cent of v saves (d/v - v/a)/100, one of a saves v/a/100.
    saved = {(gain.joint, gain.quantity): gain.seconds for gain in answer.gains()}
    assert set(saved) == {(0, "velocity"), (0, "acceleration")}
    assert saved[0, "velocity"] == pytest.approx(0.025, rel=0.02)
    assert saved[0, "acceleration"] == pytest.approx(0.005, rel=0.02)
    fit = time_optimal(JointPath.through([[0.0, 0.0], [3.0, 1.0]]), limits, start_path_velocity=0.1).gains()
    assert fit[0].quantity == "velocity"


@pytest.mark.parametrize(
    ("change", "name"),
    [
        ({"start_path_velocity": -1.0}, "start_path_velocity"),
        ({"end_path_velocity": np.nan}, "end_path_velocity"),
        ({"end_path_velocity": [1.0, 2.0]}, "end_path_velocity"),
        ({"intervals": 0}, "intervals"),
        ({"tip_speed": 1.0}, "robot"),
        ({"limits": MotionLimits.of(7, velocity=1.0)}, "acceleration"),
        ({"limits": MotionLimits.of(7, velocity=1.0, effort=3.0)}, "robot"),
        ({"limits": MotionLimits.of(6, acceleration=1.0)}, "limits"),
        ({"path": 3.0}, "path"),
        ({"path": PiecewisePolynomial.from_pieces([1.0], np.zeros((1, 2, 4, 7)))}, "curve"),
    ],
)
def test_what_is_no_question_is_refused(change: dict[str, Any], name: str) -> None:
    path, limits = drawn(2)
    question: dict[str, Any] = {"path": path, "limits": limits, **change}
    with pytest.raises(InputError, match=name):
        time_optimal(**question)


@pytest.mark.parametrize("name", ["panda", "ur5e", "puma560"])
def test_efforts_hold_on_a_dense_grid(name: str) -> None:
    robot = mf.load(name)
    rng = np.random.default_rng(1)
    low, high = np.maximum(robot.limits.lower, -2.5), np.minimum(robot.limits.upper, 2.5)
    points = (low + high) / 2 + 0.25 * (high - low) * rng.uniform(-1, 1, size=(5, robot.n))
    limits = MotionLimits.of(robot.n, velocity=3.0, effort=robot.limits.effort)
    answer = time_optimal(JointPath.through(points), limits, robot=robot)
    assert answer, answer.explain()
    assert answer.trajectory is not None
    motion = answer.trajectory.at(np.linspace(0, answer.duration, 40_001))
    tau = robot.inverse_dynamics(motion.u, motion.v, motion.a) + robot.friction_torque(motion.v)
    assert (np.abs(tau) / robot.limits.effort).max() <= 1 + ALLOWED
    assert (np.abs(motion.v) / 3.0).max() <= 1 + ALLOWED
    assert "effort" in {binding.quantity for binding in answer.bindings}
    assert any(gain.quantity == "effort" and gain.seconds > 0.0 for gain in answer.gains())
    loose = time_optimal(
        JointPath.through(points), MotionLimits.of(robot.n, velocity=3.0, effort=4 * robot.limits.effort), robot=robot
    )
    assert loose.duration < answer.duration


def test_an_arm_too_weak_for_its_own_weight() -> None:
    robot = mf.load("ur5e")
    path = JointPath.through([[0.0, 0.0, 0.0, 0.0, 0.0, 0.0], [0.5, 0.0, 0.0, 0.0, 0.0, 0.0]])
    answer = time_optimal(path, MotionLimits.of(6, velocity=1.0, acceleration=1.0, effort=20.0), robot=robot)
    assert answer.status is TimingStatus.NO_REST
    assert answer.details["joint"] == 1
    assert float(str(answer.details["value"])) == pytest.approx(robot.gravity_torque(np.zeros(6))[1], rel=1e-9)


def test_speed_and_acceleration_of_the_tip() -> None:
    robot = mf.load("panda")
    q = np.array(
        [
            [0.0, -0.4, 0.0, -2.0, 0.0, 1.8, 0.5],
            [0.6, 0.1, 0.3, -1.5, 0.2, 1.6, 0.1],
            [1.0, -0.3, 0.2, -2.2, 0.1, 2.0, 0.5],
        ]
    )
    limits = MotionLimits.of(7, velocity=3.0, acceleration=20.0)
    answer = time_optimal(JointPath.through(q), limits, robot=robot, tip_speed=0.4, tip_acceleration=1.5)
    assert answer.trajectory is not None
    motion = answer.trajectory.at(np.linspace(0, answer.duration, 4001))
    twist = np.einsum("tij,tj->ti", robot.jacobian_space(motion.u), motion.v)
    tip = robot.forward_kinematics(motion.u)[:, :3, 3]
    velocity = twist[:, 3:] + np.cross(twist[:, :3], tip)
    speed = np.linalg.norm(velocity, axis=1)
    assert speed.max() <= 0.4 * (1 + ALLOWED)
    assert speed.max() >= 0.4 * 0.999
    growth = np.linalg.norm(np.diff(velocity, axis=0), axis=1) / (answer.duration / 4000)
    assert growth.max() <= 1.5 * (1 + 1e-5)
    assert growth.max() >= 1.5 * 0.98
    assert {binding.quantity for binding in answer.bindings} >= {"tip_speed", "tip_acceleration"}
