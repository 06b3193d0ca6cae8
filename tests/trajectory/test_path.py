"""Geometric paths: derivatives, corners, repeated points, no length, reversal."""

from typing import Any

import numpy as np
import pytest

from mafsil.errors import InputError
from mafsil.trajectory import JointPath, MotionLimits, PathMotion, cubic_through, quintic, sequence, trapezoid
from mafsil.trajectory.splines import PiecewisePolynomial


def points(seed: int = 0, k: int = 6, n: int = 3) -> np.ndarray:
    return np.random.default_rng(seed).normal(size=(k, n))


def test_a_spline_passes_its_points_with_continuous_curvature() -> None:
    u = points()
    path = JointPath.through(u)
    np.testing.assert_allclose(path.at(path.breaks()).u, u, atol=1e-12)
    inner = path.breaks()[1:-1]
    before, after = path.at(np.nextafter(inner, 0.0)), path.at(inner)
    np.testing.assert_allclose(before.slope, after.slope, atol=1e-9)
    np.testing.assert_allclose(before.curvature, after.curvature, atol=1e-9)
    np.testing.assert_allclose(path.at([0.0, path.end]).curvature, 0.0, atol=1e-9)
    assert not len(path.corners())
    way = np.linalg.norm(np.diff(path.at(np.linspace(0.0, path.end, 50_001)).u, axis=0), axis=1).sum()
    assert path.length == pytest.approx(way, rel=1e-7)
    assert path.length > path.end == pytest.approx(JointPath.through(u, "lines").length)


def test_derivatives_are_those_of_the_position() -> None:
    path = JointPath.through(points(1))
    s, step = np.linspace(0.1, path.end - 0.1, 57), 1e-4
    low, here, high = path.at(s - step), path.at(s), path.at(s + step)
    np.testing.assert_allclose((high.u - low.u) / (2 * step), here.slope, atol=1e-6)
    np.testing.assert_allclose((high.slope - low.slope) / (2 * step), here.curvature, atol=1e-5)
    away = np.abs(s[:, None] - path.breaks()).min(axis=1) > 2 * step
    np.testing.assert_allclose(((high.curvature - low.curvature) / (2 * step))[away], path.third(s)[away], rtol=1e-6)


def test_lines_have_corners_where_they_turn_and_only_there() -> None:
    path = JointPath.through([[0, 0], [1, 0], [2, 0], [2, 3.0]], "lines")
    np.testing.assert_allclose(path.breaks(), [0, 1, 2, 5])
    np.testing.assert_allclose(path.corners(), [2.0])


def test_repeated_points_are_merged_and_named() -> None:
    path = JointPath.through([[0, 0], [0, 0], [1, 2], [1, 2], [1, 2], [3.0, 1]])
    assert path.merged == (1, 3, 4)
    assert len(path.breaks()) == 3


@pytest.mark.parametrize("kind", ["spline", "lines"])
def test_a_path_without_length_is_a_path(kind: Any) -> None:
    path = JointPath.through([[1.0, 2.0]] * 3, kind)
    assert path.end == 0.0
    assert path.merged == (1, 2)
    np.testing.assert_allclose(path.at(0.0).u, [1.0, 2.0])
    np.testing.assert_allclose(path.at([0.0, 5.0]).slope, 0.0)
    assert not len(path.corners())


def test_tiny_paths_keep_their_shape() -> None:
    u = points(2)
    large, tiny = JointPath.through(u), JointPath.through(1e-6 * u)
    f = np.linspace(0, 1, 31)
    np.testing.assert_allclose(tiny.at(f * tiny.end).u * 1e6, large.at(f * large.end).u, atol=1e-9)
    np.testing.assert_allclose(tiny.at(f * tiny.end).slope, large.at(f * large.end).slope, atol=1e-8)


def test_the_path_of_a_trajectory() -> None:
    motion = quintic([0.0, 1.0], [1.0, -1.0], 2.0)
    assert JointPath.of(motion).curve is motion
    joined = sequence(motion, trapezoid([1.0, -1.0], [0.0, 0.0], velocity=1.0, acceleration=2.0).value, rests=0.5)
    path = JointPath.of(joined)
    t = np.linspace(0, joined.duration, 400)
    np.testing.assert_allclose(path.at(t).u, joined.at(t).u, atol=1e-9)
    np.testing.assert_allclose(path.at(t).slope, joined.at(t).v, atol=1e-8)


def test_reversed_twice_is_the_same() -> None:
    path = JointPath.through(points(3))
    back = path.reverse()
    s = np.linspace(0, path.end, 91)
    np.testing.assert_allclose(back.at(path.end - s).u, path.at(s).u, atol=1e-10)
    np.testing.assert_allclose(back.at(path.end - s).slope, -path.at(s).slope, atol=1e-9)
    np.testing.assert_allclose(back.reverse().at(s).curvature, path.at(s).curvature, atol=1e-8)


@pytest.mark.parametrize(
    ("given", "kind"), [([[np.nan, 1.0], [0.0, 1.0]], "spline"), ([1.0, 2.0], "spline"), (np.zeros((0, 3)), "lines")]
)
def test_what_is_no_path_is_refused(given: Any, kind: Any) -> None:
    with pytest.raises(InputError, match="points"):
        JointPath.through(given, kind)
    with pytest.raises(InputError, match="kind"):
        JointPath.through([[0.0], [1.0]], kind="arc")  # pyright: ignore[reportArgumentType]
    with pytest.raises(InputError, match="curve"):
        JointPath(PiecewisePolynomial.from_pieces([1.0], np.zeros((1, 2, 4, 3))))


def test_only_the_parts_that_a_time_falls_into_are_evaluated():
    """A loop of a controller asks for one time after the other: the other parts cost nothing."""
    asked: list[int] = []

    class Counted:
        def __init__(self, k: int) -> None:
            self.k, self.own = k, quintic([float(k)], [k + 1.0], 1.0)
            self.duration, self.n = self.own.duration, 1

        def at(self, t):
            asked.append(self.k)
            return self.own.at(t)

    whole = sequence(*(Counted(k) for k in range(5)))
    asked.clear()
    assert whole.at(3.5).u == pytest.approx([3.5])
    assert asked == [3]
    plain = sequence(*(quintic([float(k)], [k + 1.0], 1.0) for k in range(5)))
    t = np.linspace(-0.5, 5.5, 241)
    for many, one in zip(plain.at(t), zip(*(plain.at(x) for x in t), strict=True), strict=True):
        np.testing.assert_array_equal(many, np.stack(one))


def test_bounds_of_derivatives_are_never_too_small_and_decide_as_the_motion_does():
    rng = np.random.default_rng(4)
    for _ in range(20):
        curve = cubic_through(rng.normal(size=(5, 3)), rng.uniform(0.2, 1.0, 4))
        t = np.linspace(0.0, curve.duration, 4001)
        for order in (1, 2, 3):
            assert (np.abs(curve.derivative(t, order)).max(axis=0) <= curve.bound(order) * (1 + 1e-12)).all()
        law = trapezoid([0.0], [curve.duration], velocity=[1.0], acceleration=[2.0]).value
        motion = PathMotion(curve, law)
        for most in rng.uniform(1.0, 200.0, 5):
            limits = MotionLimits.of(3, velocity=most, acceleration=3.0 * most)
            assert motion.is_within(limits) == (motion.stretch_needed(limits) <= 1.0)
