"""Six-bars through five positions: planted and published ones are found, answers meet their task, defects are true."""

import numpy as np
import pytest

import mafsil as mf
from mafsil.errors import InputError
from mafsil.mobility import FourBar
from mafsil.mobility import synthesis as syn
from mafsil.mobility.synthesis.crank_chain import Placed, judge_positions
from mafsil.mobility.synthesis.six_bar import DyadArm
from tests.mobility.mechanisms import klann_places


def planted(rng, form, traced=True):
    """A six-bar that closes in one pair of modes at five angles of the crank: linkage, angles, modes."""
    while True:
        first = (
            DyadArm(1, complex(1.0), rng.uniform(1.5, 3)),
            DyadArm(0, complex(*rng.uniform(1, 3, 2)), rng.uniform(1, 3)),
        )
        body, base = (2, 0 if form == "stephenson" else 1) if traced else (2 if form == "stephenson" else 3, 0)
        point, pivot = complex(*rng.uniform(0.3, 2, 2)), complex(*rng.uniform(-2, 4, 2))
        second = DyadArm(body, point, rng.uniform(1, 3)), DyadArm(base, pivot, rng.uniform(1, 3))
        bar = syn.SixBar(
            np.array([0.0, 0.0]), 1.0, (first, second), form, complex(*rng.normal(size=2)) if traced else None
        )
        theta, modes = rng.uniform(-3, 3) + np.linspace(0, 1.6, 5), rng.choice([-1, 1], 2)
        if np.abs(bar.cosines(theta, modes)).max() < 0.95:
            return bar, theta, modes


def links(bar):
    return np.array([*bar.lengths.values()])


@pytest.mark.parametrize("form", ["watt", "stephenson"])
@pytest.mark.parametrize("seed", range(10))
def test_the_path_of_a_planted_six_bar_gives_it_back(form, seed):
    bar, theta, modes = planted(np.random.default_rng([seed, len(form)]), form)
    points = bar.path_points(theta, modes)
    places = bar.bodies(theta, modes)[0]
    B, P = places[2], places[4]
    T = points[:, 0] + 1j * points[:, 1]
    side = 1 if np.imag(np.conj(T - B) * (P - B))[0] >= 0 else -1
    lengths = (1.0, float(np.abs(P - B)[0]), float(np.abs(T - P)[0]))
    if (np.sign(np.imag(np.conj(T - B) * (P - B))) != side).any():
        pytest.skip("the elbow of the chain passes its line")
    chain = syn.ThreeLinkChain((0.0, 0.0), lengths, 0.3, side)
    found = syn.synthesise_six_bar_path(points, theta - 0.3, form=form, chains=[chain])
    assert len(found) <= {"watt": 9, "stephenson": 12}[form]
    same = [np.abs(links(one.linkage) - links(bar)).max() for one in found]
    assert min(same) < 1e-6
    for one in found:
        met = np.array([one.linkage.path_points(t, m) for t, m in zip(one.theta, one.modes, strict=True)])
        assert np.abs(met - points).max() < 1e-7 * links(one.linkage).max()


@pytest.mark.parametrize("form", ["watt", "stephenson"])
@pytest.mark.parametrize("seed", range(10))
def test_the_function_of_a_planted_six_bar_gives_it_back(form, seed):
    rng = np.random.default_rng([3, seed, len(form)])
    bar, theta, modes = planted(rng, form, traced=False)
    phi = bar.output_angle(theta, modes)
    left, right = bar.arms[0]
    turn = right.point / abs(right.point)
    driver = FourBar(1.0, left.length, right.length, abs(right.point))
    pivot = bar.arms[1][1].point / turn
    drivers = [(driver, mode, [pivot.real, pivot.imag]) for mode in (0, 1)]
    found = syn.synthesise_six_bar_function(theta - np.angle(turn), phi + 0.7, form=form, drivers=drivers)
    assert min(np.abs(links(one.linkage) - links(bar)).max() for one in found) < 1e-6
    for one in found:
        out = np.array([one.linkage.output_angle(t, m) for t, m in zip(one.theta, one.modes, strict=True)])
        assert np.abs(np.exp(1j * (np.diff(out) - np.diff(phi))) - 1).max() < 1e-6


def test_klanns_published_leg_is_found_from_five_points_of_its_foot():
    """A Stephenson III linkage: U.S. patent 6,260,862; lengths as published for models of it."""
    angles = np.radians([10.0, 45.0, 90.0, 140.0, 200.0])
    places = klann_places(angles)
    T, C, F = (places[name] @ [1, 1j] for name in ("foot", "C", "F"))
    side = 1 if np.imag(np.conj(T - C) * (F - C))[0] >= 0 else -1
    chain = syn.ThreeLinkChain((0.0, 0.0), (17.5, 73.4, 59.0), elbow=side)
    found = syn.synthesise_six_bar_path(places["foot"], angles, chains=[chain])
    published = {"AB": 17.5, "BC": 38.8, "CD": 23.7, "PQ": 57.7, "QE": 34.1, "PT": 59.0}
    gaps = [max(abs(one.linkage.lengths[name] - length) for name, length in published.items()) for one in found]
    best = found[int(np.argmin(gaps))]
    assert min(gaps) < 1e-6
    assert best, best.explain("en")
    np.testing.assert_allclose(best.linkage.pivots[1:], [[-38.8, -12.5], [-14.6, 41.9]], atol=1e-6)
    drawn = best.linkage.drawn(float(best.theta[0]), best.modes[0].tolist())
    assert mf.mobility(drawn).mobility == 1
    more = klann_places(np.linspace(0, 6, 50))["foot"]
    np.testing.assert_allclose(best.linkage.path_points(np.linspace(0, 6, 50), best.modes[0].tolist()), more, atol=1e-5)


@pytest.mark.parametrize("form", ["watt", "stephenson"])
def test_a_sample_has_good_linkages_and_its_limits_hold(form):
    angle = np.linspace(0, 2.2, 5)
    outputs = 0.4 + 0.5 * np.sin(angle)
    limits = syn.LinkageLimits(transmission=np.radians(20), longest=4.0, pivots=[[-2, -2], [3, 2]])
    found = syn.synthesise_six_bar_function(angle, outputs, form=form, limits=limits)
    assert found, found.explain("en")
    for one in found:
        assert one.worst >= np.radians(20)
        assert links(one.linkage).max() <= 4.0
        assert ((one.linkage.pivots >= [-2, -2]) & (one.linkage.pivots <= [3, 2])).all()
        out = np.array([one.linkage.output_angle(t, m)[()] for t, m in zip(one.theta, one.modes, strict=True)])
        assert np.abs(np.exp(1j * (out - out[0] - outputs + outputs[0])) - 1).max() < 1e-7
    assert "the list of links is complete" in found.explain("en")
    assert found.explain("ar")


@pytest.mark.parametrize("seed", range(60))
def test_free_of_defects_means_that_the_crank_walks_through_all_positions(seed):
    """By small steps of the crank in either sense, with the modes of the first position."""
    rng = np.random.default_rng([11, seed])
    bar, theta, modes = planted(rng, ("watt", "stephenson")[seed % 2])
    theta = np.sort(theta + rng.uniform(-0.4, 0.4, 5) * (seed % 3))[:: rng.choice([-1, 1])] * rng.uniform(0.5, 2)
    every = np.tile(modes, (5, 1))
    every[rng.integers(5)] *= np.array([1, rng.choice([-1, 1])])
    if np.abs([bar.cosines(theta[k : k + 1], m)[0] for k, m in enumerate(every)]).max() > 0.99:
        pytest.skip("a position that does not close")
    one = judge_positions(Placed(bar, theta, every, 0.0))
    walks = []
    for sense in (1, -1):
        steps = np.mod(sense * np.diff(theta), 2 * np.pi)
        path = theta[0] + sense * np.linspace(0, steps.sum(), 20_000)
        closes = np.abs(bar.cosines(path, every[0])).max() < 1
        if steps.sum() < 2 * np.pi and closes and (every == every[0]).all():
            walks.append(np.arccos(np.abs(bar.cosines(path, every[0]))).min())
    assert bool(one) == bool(walks)
    if walks:
        assert min(abs(one.worst - least) for least in walks) < 1e-2


def test_wrong_tasks_are_refused():
    points, angles = [[0, 0], [1, 0], [2, 1], [2, 2], [1, 3]], np.linspace(0, 2, 5)
    for call, words in (
        (lambda: syn.synthesise_six_bar_path(points[:4], angles[:4]), "5 to 5"),
        (lambda: syn.synthesise_six_bar_path(points, angles, form="klann"), "watt"),
        (lambda: syn.synthesise_six_bar_function(angles[:3], angles[:3]), "5"),
        (lambda: syn.ThreeLinkChain((0, 0), (1, 1, -1)), "lengths"),
    ):
        with pytest.raises(InputError) as caught:
            call()
        assert words in caught.value.message("en")
