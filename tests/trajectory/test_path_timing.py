"""Time laws that are slow only where the joints need it, and paths of which only a part counts."""

import numpy as np
import pytest

import mafsil as mf
from mafsil.geometry import pose, rotation
from mafsil.model import JointLimits
from mafsil.trajectory import PathMotion, follow, quintic, trapezoid
from mafsil.trajectory.paths import CartesianPath
from mafsil.trajectory.paths.pose_path import path_equations, path_error, path_rates
from mafsil.trajectory.profiles.polynomial import quintic_coefficients
from mafsil.trajectory.splines import PiecewisePolynomial
from mafsil.trajectory.timing.path_timing import dilate_time, slowest

TICK = 1e-3


def spike(height: float, width: float, pieces: int = 400) -> PiecewisePolynomial:
    """Two coordinates over s: one even, one that runs past a steep place in the middle as near a singularity."""
    s = np.linspace(0.0, 1.0, pieces + 1)
    x = (s - 0.5) / width
    u = np.stack([s, height * np.arctan(x)], axis=1)
    v = np.stack([np.ones_like(s), height / width / (1 + x**2)], axis=1)
    a = np.stack([np.zeros_like(s), -2 * height / width**2 * x / (1 + x**2) ** 2], axis=1)
    h = 1.0 / pieces
    rows = [quintic_coefficients(u[k], u[k + 1], v[k], v[k + 1], a[k], a[k + 1], h) for k in range(pieces)]
    return PiecewisePolynomial.from_pieces([h] * pieces, rows)


def limits(velocity: float = 2.0, acceleration: float = 10.0) -> JointLimits:
    one = np.ones(2)
    return JointLimits(
        lower=-10 * one,
        upper=10 * one,
        velocity=velocity * one,
        acceleration=acceleration * one,
        effort=np.inf * one,
        jerk=np.inf * one,
    )


def longest_ratio(motion: PathMotion, bounds: JointLimits) -> float:
    """The largest share of a limit at every tick."""
    u = motion.at(np.arange(0.0, motion.duration, TICK))
    return float(max((np.abs(u.v) / bounds.velocity).max(), (np.abs(u.a) / bounds.acceleration).max()))


@pytest.mark.parametrize("law", ["quintic", "trapezoid"])
@pytest.mark.parametrize("width", [0.3, 0.03, 0.003])
def test_slow_only_where_needed_within_every_limit(law: str, width: float) -> None:
    growth = 10.0
    time = (
        quintic(0.0, 1.0, max(15 / 8, float(np.sqrt(10 / 3**0.5 / growth))))
        if law == "quintic"
        else trapezoid(0.0, 1.0, velocity=1.0, acceleration=growth).value
    )
    brisk = PathMotion(spike(0.5, width), time)
    bounds = limits()
    motion = dilate_time(brisk, bounds, growth)
    uniform = brisk.duration * max(brisk.stretch_needed(bounds), 1.0)
    assert longest_ratio(motion, bounds) <= 1 + 1e-6
    assert brisk.duration * (1 - 1e-9) <= motion.duration <= uniform * (1 + 1e-6)
    if width <= 0.03:
        # A lower bound: the way of the steep coordinate at its full acceleration, in both directions.
        assert motion.duration < 3.0 * brisk.duration
        assert uniform > 3.0 * motion.duration
    s = motion.law.at(np.linspace(0.0, motion.duration, 5001))
    assert (np.diff(s.u[:, 0]) >= 0.0).all()
    np.testing.assert_allclose([s.u[0, 0], s.u[-1, 0]], [0.0, 1.0], atol=1e-12)
    np.testing.assert_allclose([s.v[0, 0], s.v[-1, 0]], 0.0, atol=1e-9)
    assert np.abs(s.v).max() <= np.abs(time.at(np.linspace(0, time.duration, 5001)).v).max() * (1 + 1e-6)


def test_the_speed_is_the_derivative_of_the_position_and_the_acceleration_is_continuous() -> None:
    brisk = PathMotion(spike(0.5, 0.02), quintic(0.0, 1.0, 2.0))
    motion = dilate_time(brisk, limits(), 10.0)
    t = np.linspace(0.0, motion.duration, 200_001)
    u = motion.at(t)
    h = t[1] - t[0]
    np.testing.assert_allclose((u.u[2:] - u.u[:-2]) / (2 * h), u.v[1:-1], atol=1e-5)
    assert np.abs(np.diff(u.a, axis=0)).max() < 0.05


def test_where_nothing_is_too_fast_nothing_changes() -> None:
    brisk = PathMotion(spike(0.5, 0.3), quintic(0.0, 1.0, 20.0))
    assert dilate_time(brisk, limits(), 10.0).duration == brisk.duration


def test_the_slowest_place_is_the_steep_one() -> None:
    brisk = PathMotion(spike(0.5, 0.003), quintic(0.0, 1.0, 2.0))
    at = slowest(brisk, limits())
    assert at.joint == 1
    assert abs(at.place - 0.5) < 0.01
    assert at.factor == pytest.approx(brisk.stretch_needed(limits()), rel=0.05)


@pytest.mark.parametrize("task", ["pose", "axis", "position"])
def test_a_path_is_kept_as_far_as_it_counts(task: str) -> None:
    robot = mf.load("panda")
    q = np.array([0.1, -0.4, 0.2, -2.0, 0.1, 1.8, 0.6])
    start = robot.forward_kinematics(q)
    goal = start.copy()
    goal[:3, :3] = start[:3, :3] @ rotation.exp(np.array([0.2, -0.1, 0.4]))
    goal[:3, 3] += [0.05, 0.1, -0.05]
    path = CartesianPath(start, goal)
    found = follow(robot, path, q, task=task)
    assert found.value is not None
    s = np.linspace(0.0, 1.0, 101)
    here = robot.forward_kinematics(found.value.at(s).u)
    assert np.abs(path_error(here, path.poses(s), task)).max() <= 1e-6
    left = np.abs(path_error(here, path.poses(s), "pose"))[-1].max()
    assert left <= 1e-6 if task == "pose" else left > 1e-3


def test_path_errors_by_hand() -> None:
    T, target = np.eye(4), np.eye(4)
    target[:3, :3] = rotation.exp(np.array([0.3, 0.0, 0.0]))
    target[:3, 3] = [1.0, 2.0, 3.0]
    np.testing.assert_allclose(path_error(T, target, "axis"), [0.3, 0.0, 1.0, 2.0, 3.0], atol=1e-15)
    np.testing.assert_allclose(path_error(T, target, "position"), [1.0, 2.0, 3.0])
    turned = np.eye(4)
    turned[:3, :3] = rotation.exp(np.array([0.0, 0.0, 2.0]))
    np.testing.assert_allclose(path_error(T, turned, "axis"), 0.0, atol=1e-15)


@pytest.mark.parametrize("task", ["position", "axis"])
def test_equations_of_a_path_are_differences_of_the_frame_and_of_the_path(task):
    """A q' is the rate of what counts, b that of the path, A' and b' their derivatives along q(s); the turn is free."""
    robot, rng = mf.load("puma560"), np.random.default_rng(3)
    q, rate, s, h = rng.uniform(-1.0, 1.0, 6), rng.normal(size=6), 0.4, 1e-5
    start = robot.forward_kinematics(q)
    path = CartesianPath(start, start @ pose.exp([0.5, -0.4, 0.8, 0.2, -0.1, 0.3]))

    def equations(e):
        x = q + e * rate
        T = robot.forward_kinematics(x)
        J, J_rate = robot.jacobian_body(x), robot.jacobian_body_rate(x, rate)
        return path_rates(T, J, J_rate, rate, path, s + e, task)

    A, b, A_rate, b_slope = equations(0.0)
    before, after = equations(-h), equations(h)
    np.testing.assert_allclose(A_rate @ rate, (after[0] - before[0]) @ rate / (2 * h), atol=1e-6)
    np.testing.assert_allclose(b_slope, (after[1] - before[1]) / (2 * h), atol=1e-6)
    ends = [robot.forward_kinematics(q + e * rate) for e in (-h, h)]
    np.testing.assert_allclose((A @ rate)[-3:], (ends[1] - ends[0])[:3, 3] / (2 * h), atol=1e-7)
    places = path.poses(np.array([s - h, s + h]))
    np.testing.assert_allclose(b[-3:], (places[1] - places[0])[:3, 3] / (2 * h), atol=1e-7)
    if task == "axis":
        # Rates of the frame's z axis, by that axis itself and seen in the frame.
        R = robot.forward_kinematics(q)[:3, :3]
        turned = R.T @ (ends[1] - ends[0])[:3, 2] / (2 * h)
        np.testing.assert_allclose((A @ rate)[:2], [-turned[1], turned[0]], atol=1e-7)
    many = path_equations(start[None], robot.jacobian_body(q)[None], path, np.array([s]), task)
    np.testing.assert_allclose(many[0][0], A, atol=1e-12)
    np.testing.assert_allclose(many[1][0], b, atol=1e-12)


def test_what_is_left_of_a_position_does_not_depend_on_the_turn_of_the_frame() -> None:
    T, target = pose.exp([0.4, -0.7, 0.2, 1.0, 2.0, 3.0]), pose.exp([1.0, 0.2, -0.3, 0.5, 0.1, -0.4])
    way = target[:3, 3] - T[:3, 3]
    np.testing.assert_allclose(path_error(T, target, "position"), way, atol=1e-15)
    np.testing.assert_allclose(
        path_error(np.stack([T, T]), np.stack([target, target]), "position"), [way, way], atol=1e-15
    )
