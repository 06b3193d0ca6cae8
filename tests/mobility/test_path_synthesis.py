"""Path generation: planted linkages are found with their timing, all candidates pass the points, fits reach zero."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from mafsil.errors import InputError
from mafsil.mobility import synthesis as syn
from mafsil.mobility.synthesis.answers import SynthesisStatus
from mafsil.mobility.synthesis.fitting import CouplerFit
from tests.mobility.planted_bars import planted, wrapped


def path_error(one, points, timing=None):
    """Largest distance from the points over the size of the linkage, and error of the crank's angles."""
    met = np.array([one.coupler_poses(t, m) for t, m in zip(one.theta, one.modes, strict=True)])[:, :2]
    size = 1 + np.abs(np.concatenate([one.A, one.D])).max()
    late = 0.0 if timing is None else np.abs(wrapped((one.theta - one.theta[0]) - (timing - timing[0]))).max()
    return max(np.abs(met - points).max() / size, late)


def has(found, plant, tolerance=1e-5):
    return [one for one in found if np.abs(one.A - plant.A).max() + np.abs(one.D - plant.D).max() < tolerance]


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_five_points_with_timing_give_the_linkage_back(seed):
    plant = planted(np.random.default_rng(seed), 5)
    points = plant.poses[:, :2]
    found = syn.synthesise_path(points, plant.theta)
    hits = has(found, plant, 1e-3)
    assert min(np.abs(one.linkage.lengths - plant.bar.lengths).max() for one in hits) < 1e-5
    assert len(found) <= 12
    assert max(path_error(one, points, plant.theta) for one in found) < 1e-8
    assert max(one.residual for one in hits) < 1e-9


@pytest.mark.parametrize("count", [3, 4])
@pytest.mark.parametrize("seed", range(3))
def test_fewer_points_give_a_family_that_passes_them(count, seed):
    plant = planted(np.random.default_rng(seed), count)
    found = syn.synthesise_path(plant.poses[:, :2], plant.theta, samples=16)
    assert found
    assert found.ranking.count > 50
    assert max(path_error(one, plant.poses[:, :2], plant.theta) for one in found) < 1e-8


def test_its_cognates_draw_the_same_curve():
    """Roberts: another four-bar with a crank that turns as the coupler does draws the same coupler curve."""
    plant = planted(np.random.default_rng(4), 5)
    points, coupler = plant.poses[:, :2], plant.poses[:, 2]
    found = syn.synthesise_path(points, coupler)
    sides = [np.abs(found_at(one, plant)).max() for one in found]
    assert min(sides) < 1e-5
    one = found[int(np.argmin(sides))]
    more = planted_points(plant, 9)
    curve = np.concatenate(one.coupler_curves(20001))
    curve = curve[np.isfinite(curve).all(axis=1)]
    for point in more:
        assert np.hypot(*(curve - point).T).min() < 5e-3


def found_at(one, plant):
    """Distance of A from the planted A, and of the crank pin from the fourth corner of its parallelogram."""
    base = plant.bar.crank * np.exp(1j * (plant.crank[0])) + complex(*plant.A)
    corner = complex(*plant.A) + complex(*plant.poses[0, :2]) - base
    return np.concatenate([one.A - plant.A, one.B[0] - [corner.real, corner.imag]])


def planted_points(plant, count):
    """More points of the planted coupler between its positions."""
    bar, theta = plant.bar, np.linspace(plant.theta[0], plant.theta[-1], count)
    start = bar.positions(plant.theta[0])
    s = np.cumsum(start.theta, axis=-1)
    direction = plant.crank[0] - plant.theta[0]
    mode = int(np.argmin(np.abs(wrapped(np.arctan2(start.C[:, 1], start.C[:, 0] - bar.ground) - plant.rocker[0]))))
    u = np.exp(1j * (s[mode, 1] + direction))
    B = complex(*plant.A) + bar.crank * np.exp(1j * plant.crank[0])
    arm = (complex(*plant.poses[0, :2]) - B) * np.conj(u)
    turns = np.cumsum(bar.positions(theta).theta[:, mode], axis=-1)[:, 1] + direction
    z = complex(*plant.A) + bar.crank * np.exp(1j * (theta + direction)) + arm * np.exp(1j * turns)
    return np.stack([z.real, z.imag], axis=1)


@pytest.mark.parametrize("seed", range(3))
def test_many_points_with_timing_are_fitted(seed):
    plant = planted(np.random.default_rng(seed), 9, span=2.5)
    points = plant.poses[:, :2]
    found = syn.synthesise_path(points, plant.theta)
    assert min(one.miss for one in found) < 1e-9
    nearest = min(found, key=lambda one: one.miss)
    assert path_error(nearest, points, plant.theta) < 1e-8
    noisy = points + 1e-3 * np.random.default_rng(seed).normal(size=points.shape)
    fitted = syn.synthesise_path(noisy, plant.theta)
    assert 0 < min(one.miss for one in fitted) < 5e-3
    assert "least squares" in fitted.explain("en")


def test_many_points_at_any_angles_of_the_crank():
    angle = np.linspace(0, 2 * np.pi, 12, endpoint=False)
    ellipse = np.stack([1.5 * np.cos(angle), 0.6 * np.sin(angle)], axis=1)
    found = syn.synthesise_path(ellipse)
    nearest = min(found, key=lambda one: one.miss)
    assert nearest.miss < 0.05
    met = np.array([nearest.coupler_poses(t, m) for t, m in zip(nearest.theta, nearest.modes, strict=True)])[:, :2]
    np.testing.assert_allclose(np.hypot(*(met - ellipse).T).max(), nearest.miss, rtol=1e-6, atol=1e-9)


@pytest.mark.parametrize("timed", [True, False])
def test_derivatives_of_the_fit_are_those_of_differences(timed):
    rng = np.random.default_rng(1)
    plant = planted(rng, 6)
    z = plant.poses[:, 0] + 1j * plant.poses[:, 1]
    fit = CouplerFit(z, plant.crank if timed else None, 1.0)
    base = [*plant.A, *(plant.D - plant.A), plant.bar.crank, plant.bar.coupler, plant.bar.rocker, 0.3, -0.4]
    x = np.array([*base, 0.05]) if timed else np.array([*base, *plant.crank])
    r, J = fit(x)
    for k in range(len(x)):
        step = np.zeros(len(x))
        step[k] = 1e-6
        np.testing.assert_allclose((fit(x + step)[0] - fit(x - step)[0]) / 2e-6, J[:, k], atol=1e-6)
    assert r.shape == (12,)


def test_a_crank_alone_is_enough_where_the_points_keep_its_pace():
    angle = np.array([0.0, 0.4, 0.9, 1.7])
    circle = np.stack([2 * np.cos(angle), 1 + 2 * np.sin(angle)], axis=1)
    found = syn.synthesise_path(circle, angle)
    assert found.status is SynthesisStatus.ONE_POLE
    assert "(0, 1)" in found.explain("en")


@pytest.mark.parametrize(
    ("points", "timing", "words"),
    [
        ([[0, 0], [1, 0], [2, 0]], None, "need timing"),
        ([[0, 0], [1, 0]], [0, 1], "3 to 400"),
        ([[0, 0], [1, 0], [0, 0]], [0, 1, 2], "points 1 and 3 coincide"),
        ([[0, 0], [1, 0], [2, 1]], [0, 1, 2 * np.pi], "positions 1 and 3"),
        ([[0, 0], [1, 0], [2, 1]], [0, 1], "timing"),
        ([[0, 0], [1, np.inf], [2, 1]], [0, 1, 2], "inf"),
    ],
)
def test_wrong_paths_are_refused(points, timing, words):
    with pytest.raises(InputError) as caught:
        syn.synthesise_path(points, timing)
    assert words in caught.value.message("en")


def test_collinear_points_have_linkages():
    points = np.stack([np.linspace(0, 3, 5), np.linspace(0, 1.5, 5)], axis=1)
    found = syn.synthesise_path(points, [0.0, 0.5, 1.0, 1.6, 2.1])
    assert found.status in (SynthesisStatus.FREE, SynthesisStatus.DEFECTIVE, SynthesisStatus.NONE)
    assert all(path_error(one, points) < 1e-8 for one in found)


def test_points_that_no_linkage_passes_are_said():
    zigzag = np.array([[0, 0], [1, 1], [2, 0], [3, 1], [4, 0], [5, 1], [6, 0], [7, 1]], float)
    found = syn.synthesise_path(zigzag, np.linspace(0, 2, 8), tolerance=1e-3)
    assert found.status is SynthesisStatus.FAR
    assert not found
    assert len(found)
    assert f"{found.details['miss']:.3g} m" in found.explain("en")
    assert "largest distance from its points" in found[0].explain("en")
