"""The ball of a grasp: growth against all facets of Qhull, round cones between polyhedra, scales and broken sets."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import nnls

from mafsil.grasp import Contact, Grasp, Verdict
from mafsil.grasp.ball import distance_to_hull, finite_ball, hull_ball, inscribed_ball, point_discs
from mafsil.grasp.cone import RoundSet

SEEDS = range(12)


def grasp(seed: int, contacts: int = 5, gamma: float = 0.0) -> Grasp:
    rng = np.random.default_rng(seed)
    u = rng.normal(size=(contacts, 3))
    u /= np.linalg.norm(u, axis=1)[:, None]
    axes = np.array([1.0, 0.7, 0.5])
    return Grasp([Contact(p, n, 0.5, gamma) for p, n in zip(u * axes, -u / axes, strict=True)])


@pytest.mark.capability("03-42")
@pytest.mark.parametrize("m", [2, 3, 6])
@pytest.mark.parametrize("seed", SEEDS)
def test_growth_equals_the_nearest_of_all_facets(m: int, seed: int) -> None:
    rng = np.random.default_rng(seed)
    W = rng.normal(size=(m, 5 * m)) - 0.2
    assert finite_ball(W).radius == pytest.approx(hull_ball(W).radius, rel=1e-9, abs=1e-12)


@pytest.mark.capability("03-41", "03-42")
@settings(max_examples=150, deadline=None)
@given(st.sampled_from([3, 6]).flatmap(lambda m: arrays(np.float64, (m, 3 * m), elements=st.integers(-2, 2))))
def test_growth_equals_qhull_where_many_wrenches_share_a_facet(W: np.ndarray) -> None:
    assert finite_ball(W).radius == pytest.approx(hull_ball(W).radius, rel=1e-9, abs=1e-7)


@pytest.mark.capability("03-26", "03-29", "03-42")
@pytest.mark.parametrize("gamma", [0.0, 0.2])
@pytest.mark.parametrize("seed", SEEDS)
def test_round_cones_lie_between_polyhedral_ones(seed: int, gamma: float) -> None:
    held = grasp(seed, gamma=gamma)
    ball = held.quality()
    inner, outer = (finite_ball(held.matrix(24, outer=side)).radius for side in (False, True))
    assert inner - 1e-8 <= ball.upper
    assert ball.radius <= outer + 1e-8
    assert ball.upper - ball.radius <= 1.1e-6 * ball.upper + 1e-7
    if ball.radius > 0:
        reach, _ = RoundSet.of(held.contacts, np.eye(6)).furthest(ball.weakest)
        assert reach == pytest.approx(ball.upper, abs=1e-9)


@pytest.mark.capability("03-2")
@pytest.mark.parametrize("seed", SEEDS)
def test_no_direction_reaches_less_far_than_the_ball(seed: int) -> None:
    held = grasp(seed, contacts=6)
    whole, ball = RoundSet.of(held.contacts, np.eye(6)), held.quality()
    for u in np.random.default_rng(seed).normal(size=(500, 6)):
        assert whole.furthest(u / np.linalg.norm(u))[0] >= ball.radius - 1e-8


@pytest.mark.capability("03-42")
def test_pushes_together_reach_at_least_as_far_as_pushes_in_turn() -> None:
    for seed in SEEDS:
        held = grasp(seed)
        assert held.quality(together=True).upper >= held.quality().radius - 1e-8


@pytest.mark.capability("03-42")
def test_together_is_the_ball_of_all_sums() -> None:
    held = Grasp([Contact(p, n, 0.4) for p, n in (((1, 0), (-1, 0)), ((-1, 0.2), (1, 0)), ((0, -1), (0, 1)))])
    edges = [c.wrenches() for c in held.contacts]
    sums = [np.zeros(3)]
    for E in edges:
        sums = [s + e for s in sums for e in (np.zeros(3), *E.T)]
    assert held.quality(together=True).radius == pytest.approx(hull_ball(np.array(sums).T).radius, abs=1e-7)


@pytest.mark.capability("03-35", "03-41")
def test_flat_sets_have_no_ball() -> None:
    flat = np.vstack([np.random.default_rng(0).normal(size=(5, 20)), np.zeros((1, 20))])
    assert finite_ball(flat).radius == 0.0
    ball = inscribed_ball(point_discs(flat))
    assert ball is not None
    assert ball.radius == 0.0


@pytest.mark.capability("03-42")
@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_the_radius_scales_with_the_wrenches(scale: float) -> None:
    W = np.random.default_rng(3).normal(size=(6, 40))
    assert finite_ball(scale * W).radius == pytest.approx(scale * finite_ball(W).radius, rel=1e-9)


@pytest.mark.capability("03-41")
@pytest.mark.parametrize("seed", range(40))
def test_distances_equal_those_of_least_squares(seed: int) -> None:
    rng = np.random.default_rng(seed)
    m, n = int(rng.choice([3, 6])), int(rng.integers(1, 40))
    W = rng.normal(size=(m, n)) if seed % 2 else rng.integers(-2, 3, (m, n)).astype(float)
    W += rng.uniform(0, 1.5)
    x, _ = nnls(np.vstack([W, np.ones(n)]), np.append(np.zeros(m), 1.0))
    lower, upper, nearest = distance_to_hull(point_discs(W))
    assert upper == pytest.approx(np.linalg.norm(W @ x / x.sum()), abs=1e-9)
    assert upper - 1e-9 <= lower <= upper == pytest.approx(np.linalg.norm(nearest))


@pytest.mark.capability("03-29", "03-41")
def test_the_margin_of_a_no_is_that_of_the_round_cones() -> None:
    for seed in range(30):
        held = grasp(seed, contacts=3)
        found = held.closure()
        if found.verdict is not Verdict.NO:
            continue
        inner, outer = (distance_to_hull(point_discs(held.matrix(48, outer=side)))[1] for side in (False, True))
        assert outer - 1e-9 <= -found.upper <= -found.margin <= inner + 1e-9
        reach, _ = RoundSet.of(held.contacts, np.eye(6)).furthest(-found.certificate)
        assert reach < 0


def ring(fingers: int, mu: float, phase: float = 0.0) -> Grasp:
    t = phase + 2 * np.pi * np.arange(fingers) / fingers
    points = np.column_stack([np.cos(t), np.sin(t), np.zeros(fingers)])
    return Grasp([Contact(p, -p, mu) for p in points])


@pytest.mark.capability("03-42", "03-29")
@pytest.mark.parametrize("mu", [0.5, 0.6])
def test_a_ring_of_four_is_found_to_a_millionth_however_it_is_turned(mu: float) -> None:
    found = [ring(4, mu, phase).quality() for phase in (0.0, 0.7)]
    for ball in found:
        assert ball.met
        assert ball.upper - ball.radius <= 1e-6 * ball.upper
    assert found[0].upper == pytest.approx(found[1].upper, rel=1e-9)
    reach, _ = RoundSet.of(ring(4, mu).contacts, np.eye(6)).furthest(found[0].weakest)
    assert reach == pytest.approx(found[0].upper, rel=1e-9)


@pytest.mark.capability("03-42")
@pytest.mark.parametrize("phase", [0.0, 0.7])
def test_a_ring_of_three_has_its_true_radius_between_the_bounds_and_says_that_they_did_not_meet(phase: float) -> None:
    ball = ring(3, 0.6, phase).quality()
    assert ball.upper == pytest.approx(0.6 / np.sqrt(3), rel=1e-9)
    assert ball.radius <= 0.6 / np.sqrt(3)
    assert not ball.met


def test_a_proven_cap_holds_everywhere_inside() -> None:
    from mafsil.grasp.caps import cap, minimum

    whole = RoundSet.of(ring(4, 0.6).contacts, np.eye(6))
    rng = np.random.default_rng(0)
    found = None
    while found is None:
        found = minimum(whole.discs, rng.normal(size=6))
    width = cap(whole.discs, found)
    assert width > 0.01
    for _ in range(400):
        aside = rng.normal(size=6)
        aside -= found.u * (found.u @ aside)
        u = found.u + width * rng.uniform() * aside / np.linalg.norm(aside)
        assert whole.furthest(u / np.linalg.norm(u))[0] >= found.value * (1 - 1e-7)
