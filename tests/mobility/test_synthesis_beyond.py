"""Synthesis beyond one four-bar: cognates with one curve, limits that candidates keep, nine points."""

import numpy as np
import pytest

from mafsil.errors import InputError
from mafsil.mobility import FourBar
from mafsil.mobility import synthesis as syn
from mafsil.mobility.synthesis.answers import SynthesisStatus
from tests.mobility.planted_bars import planted


def curve_of(one, samples=2001):
    """All points of the coupler curve, both modes together."""
    return np.concatenate(one.coupler_curves(samples))


def farthest(points, curve):
    return max(np.hypot(*(curve - point).T).min() for point in points)


@pytest.mark.parametrize("seed", range(12))
def test_three_cognates_draw_one_curve(seed):
    plant = planted(np.random.default_rng(seed), 5)
    one = max(syn.synthesise_motion(plant.poses), key=lambda each: each.worst)
    found = syn.cognates(one)
    assert found
    assert len(found) == 3
    assert found.difference < 1e-9 * found.size
    assert "same coupler curve" in found.explain("en")
    corners = {tuple(np.round(pivot, 6)) for each in found for pivot in (each.A, each.D)}
    assert len(corners) == 3
    places = plant.poses[:, :2]
    for each in found:
        met = np.array([each.coupler_poses(t, m) for t, m in zip(each.theta, each.modes, strict=True)])[:, :2]
        np.testing.assert_allclose(met, places, atol=1e-8 * found.size)


def test_the_triangle_of_fixed_pivots_is_similar_to_the_coupler():
    bar, along, across = FourBar(1.0, 2.2, 2.0, 2.5), 1.4, 0.9
    found = syn.cognates(bar, along, across)
    ratio = complex(along, across) / bar.coupler
    np.testing.assert_allclose(complex(*found.pivot), ratio * bar.ground)
    lengths = sorted(found[1].linkage.lengths / abs(ratio))
    np.testing.assert_allclose(lengths, sorted(bar.lengths))
    np.testing.assert_allclose(sorted(found[2].linkage.lengths / abs(1 - ratio)), sorted(bar.lengths))


def test_chebyshevs_lambda_linkage_is_a_cognate_of_his_crossed_linkage():
    """Chebyshev's straight-line linkage (2, 5, 5, 4; middle of the coupler) and his lambda one (1, 2.5, 2.5, 2)."""
    found = syn.cognates(FourBar(5.0, 2.0, 5.0, 4.0), 1.0, 0.0)
    assert found
    for each in found.candidates[1:]:
        crank, coupler, rocker, ground = each.linkage.lengths
        np.testing.assert_allclose([coupler, ground, *sorted([crank, rocker])], [2.5, 2.0, 1.0, 2.5])
        pin = each.B if crank < 2.0 else each.C
        point = each.coupler_poses(each.theta[0], each.modes[0])[:2]
        np.testing.assert_allclose(np.hypot(*(point - pin[0])), 5.0)
    curves = [curve_of(each, 100_001) for each in found]
    assert farthest(curves[0][::997], curves[1]) < 1e-2
    assert farthest(curves[1][::997], curves[0]) < 1e-2


def test_points_without_cognates_are_refused():
    for along in (0.0, 2.0):
        with pytest.raises(InputError) as caught:
            syn.cognates(FourBar(1.0, 2.0, 2.0, 2.5), along, 0.0)
        assert "circle" in caught.value.message("en")
    with pytest.raises(InputError):
        syn.cognates(FourBar(1.0, 1.0, 1.0, 9.0), 0.5, 0.5)


def test_limits_are_kept_and_what_breaks_them_is_counted():
    poses = planted(np.random.default_rng(2), 4).poses
    free = syn.synthesise_motion(poses, samples=40)
    box = np.array([[-4.0, -4.0], [4.0, 4.0]])
    limits = syn.LinkageLimits(box, np.radians(35), 6.0)
    found = syn.synthesise_motion(poses, samples=40, limits=limits)
    assert found
    assert found.ranking.count + sum(found.ranking.beyond) == free.ranking.count
    for one in found:
        assert one.worst >= np.radians(35)
        assert one.linkage.lengths.max() <= 6.0
        assert (np.abs([one.A, one.D]) <= 4.0).all()
    assert f"{sum(found.ranking.beyond)} more break the limits" in found.explain("en")
    never = syn.synthesise_motion(poses, samples=40, limits=syn.LinkageLimits(longest=1e-3))
    assert never.status is SynthesisStatus.LIMITED
    assert "too long a link" in never.explain("en")


def test_limits_hold_for_paths_and_functions():
    plant = planted(np.random.default_rng(3), 5)
    path = syn.synthesise_path(plant.poses[:, :2], plant.theta)
    longest = float(np.median([one.linkage.lengths.max() for one in path]))
    short = syn.synthesise_path(plant.poses[:, :2], plant.theta, limits=syn.LinkageLimits(longest=longest))
    assert 0 < len(short) < len(path)
    task = syn.FunctionTask(np.log10, (1, 2), np.radians((30, 90)), np.radians((240, 330)))
    dial = task.synthesise(4)
    steep = syn.LinkageLimits(transmission=min(1.5, dial[0].worst + 0.01))
    assert task.synthesise(4, limits=steep).status is SynthesisStatus.LIMITED


@pytest.mark.parametrize(
    ("limits", "words"),
    [({"transmission": 40.0}, "radians"), ({"pivots": [1, 2]}, "corners"), ({"longest": -1.0}, "longest")],
)
def test_wrong_limits_are_refused(limits, words):
    with pytest.raises(InputError) as caught:
        syn.LinkageLimits(**limits)
    assert words in caught.value.message("en")


def test_nine_points_are_answered_with_whole_triples():
    plant = planted(np.random.default_rng(5), 9, span=2.5)
    found = syn.synthesise_path(plant.poses[:, :2], samples=4)
    assert found.method == "by_nine"
    exact = [one for one in found if one.miss < 1e-9]
    assert len(exact) == 3 * found.details["triples"]
    assert "1,442" in found.explain("en")
    assert "not exhaustive" in found.explain("en")
