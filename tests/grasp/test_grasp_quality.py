"""The quality of a grasp: growth against all facets of Qhull, round cones between polyhedra, scales and broken sets."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays
from scipy.optimize import minimize, nnls

from mafsil.grasp import Contact, Grasp
from mafsil.grasp.closure import Margin
from mafsil.grasp.enclosure import ConeWrenches
from mafsil.grasp.quality import (
    distance_to_hull,
    point_discs,
    quality_by_facets,
    quality_of_discs,
    quality_of_wrenches,
    symmetries,
)
from tests.sizes import few

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
    assert quality_of_wrenches(W).epsilon == pytest.approx(quality_by_facets(W).epsilon, rel=1e-9, abs=1e-12)


@pytest.mark.capability("03-41", "03-42")
@settings(max_examples=150, deadline=None)
@given(st.sampled_from([3, 6]).flatmap(lambda m: arrays(np.float64, (m, 3 * m), elements=st.integers(-2, 2))))
def test_growth_equals_qhull_where_many_wrenches_share_a_facet(W: np.ndarray) -> None:
    assert quality_of_wrenches(W).epsilon == pytest.approx(quality_by_facets(W).epsilon, rel=1e-9, abs=1e-7)


@pytest.mark.capability("03-26", "03-29", "03-42")
@pytest.mark.parametrize("gamma", [0.0, 0.2])
@pytest.mark.parametrize("seed", SEEDS)
def test_round_cones_lie_between_polyhedral_ones(seed: int, gamma: float) -> None:
    held = grasp(seed, gamma=gamma)
    ball = held.quality()
    inner, outer = (quality_of_wrenches(held.matrix(24, outer=side)).epsilon for side in (False, True))
    assert inner - 1e-8 <= ball.upper
    assert ball.epsilon <= outer + 1e-8
    assert ball.upper - ball.epsilon <= 1e-6 * ball.upper * (1 + 1e-6)
    if ball.epsilon > 0:
        reach, _ = ConeWrenches.of(held.contacts, np.eye(6)).furthest(ball.weakest_direction)
        assert reach == pytest.approx(ball.upper, abs=1e-9)


@pytest.mark.capability("03-2")
@pytest.mark.parametrize("seed", SEEDS)
def test_no_direction_reaches_less_far_than_the_ball(seed: int) -> None:
    held = grasp(seed, contacts=6)
    whole, ball = ConeWrenches.of(held.contacts, np.eye(6)), held.quality()
    for u in np.random.default_rng(seed).normal(size=(500, 6)):
        assert whole.furthest(u / np.linalg.norm(u))[0] >= ball.epsilon - 1e-8


@pytest.mark.capability("03-42")
def test_pushes_together_reach_at_least_as_far_as_pushes_in_turn() -> None:
    for seed in SEEDS:
        held = grasp(seed)
        assert held.quality(together=True).upper >= held.quality().epsilon - 1e-8


@pytest.mark.capability("03-42")
def test_together_is_the_ball_of_all_sums() -> None:
    held = Grasp([Contact(p, n, 0.4) for p, n in (((1, 0), (-1, 0)), ((-1, 0.2), (1, 0)), ((0, -1), (0, 1)))])
    edges = [c.wrenches() for c in held.contacts]
    sums = [np.zeros(3)]
    for E in edges:
        sums = [s + e for s in sums for e in (np.zeros(3), *E.T)]
    assert held.quality(together=True).epsilon == pytest.approx(quality_by_facets(np.array(sums).T).epsilon, abs=1e-7)


@pytest.mark.capability("03-35", "03-41")
def test_flat_sets_have_no_ball() -> None:
    flat = np.vstack([np.random.default_rng(0).normal(size=(5, 20)), np.zeros((1, 20))])
    assert quality_of_wrenches(flat).epsilon == 0.0
    ball = quality_of_discs(point_discs(flat))
    assert ball is not None
    assert ball.epsilon == 0.0


@pytest.mark.capability("03-42")
@pytest.mark.parametrize("scale", [1e-6, 1e6])
def test_the_radius_scales_with_the_wrenches(scale: float) -> None:
    W = np.random.default_rng(3).normal(size=(6, 40))
    assert quality_of_wrenches(scale * W).epsilon == pytest.approx(scale * quality_of_wrenches(W).epsilon, rel=1e-9)


@pytest.mark.capability("03-41")
@pytest.mark.parametrize("seed", few(range(40), 10))
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
        if found.verdict != "no":
            continue
        inner, outer = (distance_to_hull(point_discs(held.matrix(48, outer=side)))[1] for side in (False, True))
        assert outer - 1e-9 <= -found.upper <= -found.margin <= inner + 1e-9
        reach, _ = ConeWrenches.of(held.contacts, np.eye(6)).furthest(-found.certificate)
        # Two contacts that hold each other leave the moment about their line, where the hull touches the origin.
        assert reach < 0 or (reach < 1e-12 and found.margin == 0.0)


def ring(fingers: int, mu: float, phase: float = 0.0, noise: float = 0.0) -> Grasp:
    t = phase + 2 * np.pi * np.arange(fingers) / fingers
    points = np.column_stack([np.cos(t), np.sin(t), np.zeros(fingers)])
    points += noise * np.random.default_rng(fingers).normal(size=points.shape)
    return Grasp([Contact(p, -p, mu) for p in points])


def box(height: float) -> Grasp:
    sides = (((1, 0.2, 0), (-1, 0, 0)), ((-1, -0.2, 0), (1, 0, 0)))
    fronts = (((0.1, 1, height), (0, -1, 0)), ((-0.1, -1, -height), (0, 1, 0)))
    return Grasp([Contact(p, n, 0.5) for p, n in (*sides, *fronts)])


def least_found(held: Grasp, starts: int) -> float:
    """The least that a general minimiser finds on the sphere, in epigraph form, from many starts."""
    whole = ConeWrenches.of(held.contacts, np.eye(6)).discs

    def heights(u: np.ndarray) -> np.ndarray:
        along = whole @ u
        return along[:, 0] + np.sqrt(along[:, 1] ** 2 + along[:, 2] ** 2 + 1e-18) + np.abs(along[:, 3])

    bounds = (
        {"type": "ineq", "fun": lambda x: x[6] - heights(x[:6])},
        {"type": "eq", "fun": lambda x: x[:6] @ x[:6] - 1.0},
    )
    least = np.inf
    for u in np.random.default_rng(0).normal(size=(starts, 6)):
        u = u / np.linalg.norm(u)
        found = minimize(lambda x: x[6], [*u, heights(u).max()], method="SLSQP", constraints=bounds)
        u = found.x[:6] / np.linalg.norm(found.x[:6])
        least = min(least, float(heights(u).max()))
    return least


@pytest.mark.capability("03-42", "03-29")
@pytest.mark.parametrize("mu", [0.5, 0.6])
@pytest.mark.parametrize("fingers", [3, 4, 5, 6])
def test_a_ring_is_known_to_a_millionth_however_it_is_turned_and_rounded(fingers: int, mu: float) -> None:
    held = ring(fingers, mu)
    rounded = Grasp([Contact(np.round(c.point, 12), np.round(c.normal, 12), mu) for c in held.contacts])
    found = [held.quality(), ring(fingers, mu, 0.7).quality(), rounded.quality()]
    for ball in found:
        assert ball.converged
        assert 0 < ball.upper - ball.epsilon <= 1e-6 * ball.upper
        assert ball.upper == pytest.approx(found[0].upper, rel=2e-7)
    reach, _ = ConeWrenches.of(held.contacts, np.eye(6)).furthest(found[0].weakest_direction)
    assert reach == pytest.approx(found[0].upper, rel=1e-9)
    assert least_found(held, 20) >= found[0].epsilon


@pytest.mark.capability("03-42")
@pytest.mark.parametrize("phase", [0.0, 0.3, 0.7])
def test_the_radius_of_a_ring_of_three_is_the_value_in_closed_form(phase: float) -> None:
    ball = ring(3, 0.6, phase).quality()
    assert ball.upper == pytest.approx(0.6 / np.sqrt(3), rel=1e-9)
    assert 0.6 / np.sqrt(3) * (1 - 1e-6) <= ball.epsilon <= 0.6 / np.sqrt(3)


@pytest.mark.capability("03-42")
@pytest.mark.parametrize("fingers", [3, 4, 5])
@pytest.mark.parametrize("noise", [1e-6, 1e-3, 1e-2, 1e-1])
def test_a_ring_with_noise_is_known_to_a_millionth(fingers: int, noise: float) -> None:
    held = ring(fingers, 0.5, noise=noise)
    ball = held.quality()
    assert ball.upper - ball.epsilon <= 1e-6 * ball.upper
    assert least_found(held, 6) >= ball.epsilon


@pytest.mark.capability("03-42")
@pytest.mark.parametrize("height", [0.0, 0.1, 0.3])
def test_a_box_between_four_fingers_is_known_to_a_millionth(height: float) -> None:
    held = box(height)
    ball = held.quality()
    assert ball.upper - ball.epsilon <= 1e-6 * ball.upper
    assert least_found(held, 20) == pytest.approx(ball.upper, rel=1e-5)
    assert least_found(held, 6) >= ball.epsilon


@pytest.mark.capability("03-42")
@pytest.mark.parametrize("gamma", [0.0, 0.2])
@pytest.mark.parametrize("seed", SEEDS)
def test_small_radii_too_are_known_to_a_millionth(seed: int, gamma: float) -> None:
    held = grasp(seed, contacts=4, gamma=gamma)
    ball = held.quality()
    assert ball.converged
    assert ball.upper - ball.epsilon <= 1e-6 * ball.upper * (1 + 1e-6)


@pytest.mark.capability("03-2", "03-42")
def test_the_verdict_has_the_bounds_of_its_margin_and_says_when_they_did_not_meet() -> None:
    found = ring(3, 0.6).closure()
    assert found.converged
    assert found.to_dict()["margin_converged"] is True
    assert "between" not in found.explain()
    apart = replace(found, measured=Margin(0.34, 0.35))
    assert not apart.converged
    assert "between 0.34 and 0.35" in apart.explain()
    assert "0.34" in apart.explain("ar")


def test_a_search_that_is_cut_short_keeps_what_growth_proved(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("mafsil.grasp.quality.CONES", 50)
    ball = ring(3, 0.6).quality()
    assert not ball.converged
    assert ball.epsilon < 0.6 / np.sqrt(3) <= ball.upper * (1 + 1e-9)


@pytest.mark.parametrize(("held", "order"), [(ring(3, 0.5), 12), (ring(5, 0.5, 0.3), 20), (ring(5, 0.5, 0.0, 1e-3), 1)])
def test_a_ring_has_the_symmetries_of_its_polygon(held: Grasp, order: int) -> None:
    discs = ConeWrenches.of(held.contacts, np.eye(6)).discs
    group, miss = symmetries(discs)
    assert len(group) == order
    assert miss < 1e-12
    whole = ConeWrenches(discs)
    for u in np.random.default_rng(0).normal(size=(5, 6)):
        images = [whole.furthest(Q @ u)[0] for Q in group]
        assert images == pytest.approx(np.full(order, images[0]), rel=1e-12)


@pytest.mark.parametrize("gamma", [0.0, 0.2])
def test_a_proven_cone_holds_everywhere_inside(gamma: float) -> None:
    from mafsil.solvers import direction_cover_loops as cover

    discs, rng = ConeWrenches.of(grasp(3, gamma=gamma).contacts, np.eye(6)).discs, np.random.default_rng(1)
    whole, proof, states = ConeWrenches(discs), cover.make_proof(6), set[int]()
    for _ in range(200):
        V = rng.normal(size=6) + 0.4 * rng.normal(size=(6, 6))
        V /= np.linalg.norm(V, axis=1)[:, None]
        inside = rng.dirichlet(np.full(6, 0.5), size=40) @ V
        least = min(whole.furthest(u / np.linalg.norm(u))[0] for u in inside)
        state, _ = cover.examine(discs, V, least * 1.0001, 6, True, proof)
        assert state != cover.PROVEN
        state, _ = cover.examine(discs, V, least * 0.9, 6, True, proof)
        states.add(state)
    assert cover.PROVEN in states
