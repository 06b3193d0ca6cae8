"""B-splines: SciPy's, their hulls, refinements, and proofs of limits."""

from __future__ import annotations

import tracemalloc

import numpy as np
import pytest
import scipy.interpolate as si
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.errors import InputError
from mafsil.trajectory import (
    MotionLimits,
    Trajectory,
    bspline,
    bspline_through,
    check,
    continuity,
    cubic_through,
    linear_blends,
    minimum_jerk_through,
    minimum_snap_through,
    prove,
    quintic,
)
from mafsil.trajectory.motion import ProofStatus
from mafsil.trajectory.splines.piecewise import MANY
from tests.sizes import few

RNG = np.random.default_rng(11)


@pytest.mark.capability("11-16")
@pytest.mark.parametrize("kind", ["clamped", "uniform"])
@pytest.mark.parametrize("degree", [1, 2, 3, 5, 7])
def test_values_and_derivatives_are_those_of_scipy(degree, kind):
    control = RNG.normal(size=(12, 3))
    ours = bspline(control, 2.5, degree=degree, knots=kind)
    assert isinstance(ours, Trajectory)
    theirs = si.BSpline(ours.knots, control, degree)
    t = np.linspace(0.0, 2.5, 57)[1:-1]
    for order in range(min(degree, 3) + 1):
        np.testing.assert_allclose(ours.derivative(order).value(t), theirs(t, order), atol=1e-9)
    for order, values in enumerate(ours.at(t)[: degree + 1]):
        np.testing.assert_allclose(values, theirs(t, order), atol=1e-9)
    np.testing.assert_allclose(ours.at([0.0, 2.5]).u, theirs([0.0, 2.5]), atol=1e-12)
    pieces = ours.to_polynomial()
    np.testing.assert_allclose(pieces.at(t).u, ours.at(t).u, atol=1e-11)
    np.testing.assert_allclose(pieces.jerk(t), ours.jerk(t), atol=1e-8)
    assert continuity(ours, ends=False).order >= min(degree - 1, 3)
    if kind == "clamped":
        np.testing.assert_allclose(ours.at([0.0, 2.5]).u, control[[0, -1]], atol=1e-12)
    batch = bspline(np.stack([control, 2 * control]), 2.5, degree=degree, knots=kind)
    np.testing.assert_allclose(batch.at(t).u[:, 1], 2 * ours.at(t).u, atol=1e-12)
    np.testing.assert_allclose(ours.scale_time(2.0).at(2 * t).v, ours.at(t).v / 2, atol=1e-12)


@settings(deadline=None, max_examples=60)
@given(seed=st.integers(0, 10_000), degree=st.integers(1, 6), extra=st.integers(1, 8))
def test_the_motion_stays_in_the_hull_and_new_knots_change_the_hull_alone(seed, degree, extra):
    rng = np.random.default_rng(seed)
    spline = bspline(rng.normal(size=(degree + extra, 2)), 1.5, degree=degree)
    t = np.linspace(0.0, 1.5, 101)
    finer = spline.insert(rng.uniform(0.05, 1.45, 4))
    np.testing.assert_allclose(finer.at(t).u, spline.at(t).u, atol=1e-11)
    for order in range(min(degree, 3)):
        values = spline.derivative(order).value(t)
        for hull in (spline.hull(order), finer.hull(order)):
            scale = 1e-9 * np.abs(hull).max()
            assert (values >= hull[0] - scale).all()
            assert (values <= hull[1] + scale).all()
    assert (finer.hull()[1] <= spline.hull()[1] + 1e-12).all()


@pytest.mark.capability("11-16")
@pytest.mark.parametrize("degree", [1, 3, 5, 7])
@pytest.mark.parametrize("legs", [1, 2, 6])
def test_through_points_as_scipy(degree, legs):
    points, h = RNG.normal(size=(legs + 1, 2)), RNG.uniform(0.5, 1.5, legs)
    each = (degree - 1) // 2
    ends = RNG.normal(size=(2, each, 2))
    ours = bspline_through(points, h, degree=degree, start_derivatives=ends[0], goal_derivatives=ends[1])
    t = np.r_[0.0, np.cumsum(h)]
    kinds = tuple([(k + 1, side[k]) for k in range(each)] for side in ends) if each else None
    theirs = si.make_interp_spline(t, points, degree, t=ours.knots, bc_type=kinds)
    np.testing.assert_allclose(ours.at(t).u, points, atol=1e-10)
    x = np.linspace(0.0, t[-1], 50)[1:-1]
    np.testing.assert_allclose(ours.at(x).u, theirs(x), atol=1e-8)
    if degree == 3:
        clamped = cubic_through(points, h, start_velocity=ends[0, 0], goal_velocity=ends[1, 0])
        np.testing.assert_allclose(ours.at(x).a, clamped.at(x).a, atol=1e-8)


@pytest.mark.parametrize("degree", [2, 4])
def test_even_degrees_pass_their_points(degree):
    points, h = RNG.normal(size=(9, 2)), RNG.uniform(0.5, 1.5, 8)
    ours = bspline_through(points, h, degree=degree)
    np.testing.assert_allclose(ours.at(np.r_[0.0, np.cumsum(h)]).u, points, atol=1e-10)
    with pytest.raises(InputError):
        bspline_through(points[:3], h[:2], degree=4)
    with pytest.raises(InputError):
        bspline_through(points, h, degree=4, start_derivatives=[0.0])


def squared(motion, order):
    """The integral of a squared derivative, by Gauss on each piece."""
    x, w = np.polynomial.legendre.leggauss(12)
    total = 0.0
    for a, b in zip(motion.breaks()[:-1], motion.breaks()[1:], strict=True):
        values = motion.derivative(order).value((a + b) / 2 + (b - a) / 2 * x)
        total += (b - a) / 2 * (w @ values**2).sum()
    return total


@pytest.mark.parametrize(("through", "order"), [(minimum_jerk_through, 3), (minimum_snap_through, 4)])
def test_no_other_motion_through_the_points_has_less(through, order):
    points, h = RNG.normal(size=(5, 1)), np.array([1.0, 0.6, 1.4, 0.8])
    best = through(points, h)
    assert continuity(best).order >= order - 1
    least = squared(best, order)
    # Another one: the same conditions, and a detour that meets none of the points.
    t = np.r_[0.0, np.cumsum(h)]
    for seed in range(5):
        finer = best.insert((t[1:] + t[:-1]) / 2)
        rows = [finer.__class__(finer.knots, np.eye(len(finer.control)), finer.degree)]
        system = np.concatenate([rows[0].value(t), *(rows[0].derivative(k).value(t[[0, -1]]) for k in range(1, order))])
        null = np.linalg.svd(system)[2][np.linalg.matrix_rank(system) :]
        detour = null.T @ np.random.default_rng(seed).normal(size=(len(null), 1))
        other = finer.__class__(finer.knots, finer.control + 0.01 * detour, finer.degree)
        assert squared(other, order) > least


@pytest.mark.capability("11-4")
def test_a_proof_agrees_with_the_extremes_and_convicts_with_a_value():
    decided = 0
    for seed in few(range(40), 10):
        rng = np.random.default_rng(seed)
        spline = bspline_through(rng.normal(size=(6, 2)), rng.uniform(0.5, 1.5, 5))
        t = np.linspace(0.0, spline.duration, 20_001)
        at = spline.at(t)
        peaks = [np.abs(x).max(axis=0) for x in (at.u, at.v, at.a, spline.jerk(t))]
        share = rng.uniform(0.98, 1.02)
        names = ("position", "velocity", "acceleration", "jerk")
        limits = MotionLimits.of(2, **{k: share * p for k, p in zip(names, peaks, strict=True)})
        proof = prove(spline, limits)
        assert bool(proof) is (share > 1.0)
        for violation in proof:
            order = {"upper": 0, "lower": 0, "velocity": 1, "acceleration": 2, "jerk": 3}[violation.quantity]
            value = spline.derivative(order).value(np.array(violation.time))[int(violation.joint)]
            np.testing.assert_allclose(value, violation.value, rtol=1e-9)
            assert abs(violation.value) > abs(violation.limit)
        decided += proof.halvings >= 0
        wide = MotionLimits.of(2, **{k: 100 * p for k, p in zip(names, peaks, strict=True)})
        assert prove(spline, wide).halvings == -1
    assert decided


def test_a_proof_where_the_limit_is_touched_and_where_doubt_is_left():
    motion = quintic([0.0], [1.0], 1.0)
    touched = MotionLimits.of(1, velocity=15 / 8)
    assert prove(motion, touched)
    assert prove(motion, touched, halvings=0).status is ProofStatus.IN_DOUBT
    assert prove(motion, MotionLimits.of(1, velocity=15 / 8 * (1 - 1e-6))).status is ProofStatus.EXCEEDED
    one_sided = MotionLimits.of(1, velocity=(-0.0, 2.0), acceleration=(-5.0, 6.0))
    (violation,) = prove(motion, one_sided, ("lift",)).violations
    assert (violation.joint, violation.quantity, violation.limit) == ("lift", "acceleration", -5.0)
    blends = linear_blends([0.0, 2.0, 1.0], 2.0, acceleration=8.0).trajectory.to_polynomial()
    assert prove(blends, MotionLimits.of(1, acceleration=8.0))
    for language in ("en", "ar"):
        for answer in (prove(motion, touched), prove(motion, touched, halvings=0), prove(motion, one_sided)):
            assert answer.explain(language)
            assert answer.to_dict()["status"]
    with pytest.raises(InputError):
        prove(motion, MotionLimits.of(2))
    assert check is not prove


@pytest.mark.parametrize(
    "wrong",
    [
        {"control_points": [[0.0], [1.0]]},
        {"degree": 0},
        {"degree": 40},
        {"duration": 0.0},
        {"knots": "open"},
        {"knots": [0, 0, 0, 0, 1, 1, 1]},
        {"knots": [0, 0, 0, 0, 2, 1, 1, 1, 1]},
        {"knots": [0, 0, 0, 0, 2, 3, 3, 3, 3]},
        {"control_points": [0.0, np.nan, 1.0, 2.0, 3.0]},
    ],
)
def test_what_is_no_spline_is_refused(wrong):
    with pytest.raises(InputError):
        bspline(**{"control_points": [0.0, 1.0, 3.0, 2.0, 1.0], "duration": 1.0} | wrong)
    fine = bspline([0.0, 1.0, 3.0, 2.0, 1.0], 1.0)
    with pytest.raises(InputError):
        fine.insert(2.0)
    with pytest.raises(InputError):
        fine.insert([0.3] * 4)


@pytest.mark.parametrize("degree", [4, 5, 7])
def test_splines_through_thousands_of_points_pass_them_in_little_memory(degree):
    points, h = np.cumsum(RNG.uniform(-0.2, 0.2, (5001, 2)), axis=0), RNG.uniform(0.1, 1.0, 5000)
    tracemalloc.start()
    try:
        spline = bspline_through(points, h, degree=degree)
        assert tracemalloc.get_traced_memory()[1] < 20e6  # a dense system has 200 MB
    finally:
        tracemalloc.stop()
    np.testing.assert_allclose(spline.at(np.r_[0.0, np.cumsum(h)]).u, points, atol=1e-11)
    if degree % 2:
        np.testing.assert_allclose(spline.at([0.0, spline.duration]).v, 0.0, atol=1e-10)


@pytest.mark.parametrize("batch", [(), (2, 3)])
def test_many_times_at_once_give_the_bits_of_one_at_a_time(batch):
    motion = bspline_through(RNG.normal(size=(*batch, 6, 3)), RNG.uniform(0.2, 2.0, 5)).to_polynomial()
    t = RNG.uniform(-0.3, motion.duration + 0.3, 3000)
    assert t.size * motion.n >= MANY
    for each, ones in zip(motion.at(t), zip(*map(motion.at, t), strict=True), strict=True):
        np.testing.assert_array_equal(each, np.stack(ones))
