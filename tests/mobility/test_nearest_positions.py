"""Inputs that cranks do not reach: the dead point nearest to them, how far it is, and rates that are never NaN."""

import numpy as np
import pytest

import mafsil.mobility as mo
import mafsil.parallel as pa
from mafsil.errors import InputWarning


@pytest.mark.capability("02-53", "08-47")
def test_the_nearest_position_of_a_four_bar_is_its_dead_point():
    """Against a search over all angles of the crank, without the formula of the dead points."""
    angles = np.linspace(-np.pi, np.pi, 20001)
    for lengths in ([2, 3, 2.5, 4], [2, 1.5, 1.9, 3], [1.5, 1, 3, 2.2]):
        four, asked = mo.FourBar(*lengths), np.random.default_rng(0).uniform(-np.pi, np.pi, 60)
        found, reached = four.positions(asked), angles[four.positions(angles).reachable]
        off = ~found.reachable
        assert found.status is mo.four_bar.PositionStatus.SOME
        np.testing.assert_allclose(four.closure(found.theta), 0.0, atol=1e-12)
        away = np.abs(np.angle(np.exp(1j * (asked[:, None] - reached)))).min(axis=1)
        np.testing.assert_allclose(found.beyond, np.where(off, away, 0.0), atol=4e-4)
        dead = found.theta[off, 0]
        np.testing.assert_allclose(np.sin(four.transmission_angle(dead)), 0.0, atol=1e-7)
        rates = four.rates(dead)
        np.testing.assert_array_equal(np.abs(rates), np.tile([1.0, np.inf, np.inf, np.inf], (len(dead), 1)))
        np.testing.assert_array_equal(np.sign(rates[:, 1:]), np.sign(four.tangents(dead)[:, 0, 1:]))
        assert f"{found.beyond[off].min():.4g} rad" in found.explain("en")
        pins = lengths[0] * np.stack([np.cos(asked), np.sin(asked)], axis=-1)
        way = np.linalg.norm(pins - [lengths[3], 0], axis=-1)
        lack = np.maximum(way - lengths[1] - lengths[2], abs(lengths[1] - lengths[2]) - way)
        np.testing.assert_allclose(found.missing, np.where(off, lack, 0.0), atol=1e-12)


@pytest.mark.capability("02-53", "02-61")
def test_lengths_that_never_close_and_blocks_out_of_reach():
    never = mo.FourBar(1, 1, 1, 3.5).positions([0.3, 2.0])
    assert never.status is mo.four_bar.PositionStatus.NEVER
    gap = np.linalg.norm(mo.FourBar(1, 1, 1, 3.5).closure(never.theta)[..., :2], axis=-1)
    np.testing.assert_allclose(gap, mo.spaces.polygon_space([1, 1, 1, 3.5]).excess)
    crank, asked = mo.SliderCrank(1.0, 0.5, 0.2), np.linspace(-4, 4, 41)
    found, angles = crank.positions(asked), np.linspace(-7, 7, 20001)
    reached = angles[crank.positions(angles).reachable]
    np.testing.assert_allclose(found.beyond, np.abs(asked[:, None] - reached).min(axis=1) * ~found.reachable, atol=1e-3)
    pins = np.stack([np.cos(found.theta), np.sin(found.theta) - 0.2], axis=-1)
    for mode in (0, 1):
        np.testing.assert_allclose(np.hypot(found.x[:, mode] - pins[:, 0], pins[:, 1]), 0.5, atol=1e-9)
    # The sign of an infinite rate is that of the finite ones beside it, where the rod still reaches.
    off = ~found.reachable
    inward = found.theta + 1e-6 * np.sign(found.theta - asked)
    beside = crank.rates(inward[off])
    assert np.isinf(crank.rates(asked)[off]).all()
    np.testing.assert_array_equal(np.sign(crank.rates(asked)[off]), np.sign(beside))
    assert mo.SliderCrank(1, 3, 5).positions(0.1).status is mo.slider_crank.SliderStatus.NEVER
    np.testing.assert_allclose(mo.SliderCrank(1, 1).rates(np.pi / 2), [0.0, -2.0], atol=1e-12)


@pytest.mark.capability("02-61", "08-49")
def test_rates_where_branches_cross_are_the_slopes_of_the_curve():
    for lengths in ([4, 3, 3, 4], [2, 2, 2, 2], [1, 2, 3, 2], [2, 4, 3, 3], [1, 1, 1, 3], [3, 4, 3, 4]):
        four = mo.FourBar(*lengths)
        for point in pa.planar.singular_points(four):
            coupler = 0.0 if lengths[3] + lengths[2] * np.cos(point.phi) > lengths[0] * np.cos(point.theta) else np.pi
            absolute = np.array([point.theta, coupler, point.phi + np.pi, np.pi])
            theta = np.diff(absolute, prepend=0.0)
            both = four.branch_rates(theta)
            np.testing.assert_allclose(-both[:, 3], [0.0, 0.0] if point.isolated else point.slopes, atol=1e-9)
            assert not np.isnan(both).any()
            if not point.isolated:
                with pytest.warns(InputWarning, match="two branches"):
                    np.testing.assert_array_equal(four.rates(theta), both[0])


@pytest.mark.capability("02-58")
def test_circles_that_do_not_meet_have_a_gap_and_the_point_in_its_middle():
    rng = np.random.default_rng(3)
    A, B, a, b = rng.normal(size=(200, 2)), rng.normal(size=(200, 2)), rng.uniform(0, 2, 200), rng.uniform(0, 2, 200)
    gap, points = mo.spaces.circle_gap(A, a, B, b), mo.spaces.circle_crossings(A, a, B, b)
    off = np.stack([np.linalg.norm(points - C[:, None], axis=-1) - r[:, None] for C, r in ((A, a), (B, b))])
    assert 0.2 < (gap > 0).mean() < 0.8
    np.testing.assert_allclose(np.abs(off), np.tile(gap[:, None] / 2, (2, 1, 2)), atol=1e-9)
    np.testing.assert_allclose(mo.spaces.circle_crossings([0, 0], 2.0, [0, 0], 1.0), [[1.5, 0.0], [1.5, 0.0]])
