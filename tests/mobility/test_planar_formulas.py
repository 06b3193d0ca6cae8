"""Planar joints, four-bars and slider-cranks against formulas and against what can be read off their positions."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil import mobility as mo
from mafsil.messages import say
from mafsil.mobility.four_bar import four_bar_of
from mafsil.mobility.linkages.loop_closure import largest_gap


@pytest.mark.capability("02-43", "02-44", "02-45", "02-79")
@pytest.mark.parametrize(("kind", "freedoms"), [("R", 4), ("P", 4), ("RP", 5), ("PR", 5)])
def test_equations_of_joints_between_two_bodies(kind, freedoms):
    """What the forward map makes satisfies them, what is pulled apart does not, and their rank leaves the freedoms."""
    rng, d_AB, slot, fixed = np.random.default_rng(5), 1.3, 0.4, 0.7
    theta, d = rng.uniform(-2, 2, 20), rng.uniform(0.2, 1.0, 20)
    theta = np.full(20, fixed) if kind == "P" else theta
    A, phi = rng.normal(size=(20, 2)), rng.uniform(-3, 3, 20)
    made = mo.bodies.second_body(kind, A, phi, d_AB, 0.8, theta=theta, d=d, slot=slot)
    x = np.column_stack([A, phi, made.C, phi + theta])
    assert np.abs(mo.bodies.joint_residual(kind, x, d_AB, theta=fixed, slot=slot)).max() < 1e-12
    aside = x + 0.01 * rng.normal(size=x.shape)
    assert (np.abs(mo.bodies.joint_residual(kind, aside, d_AB, theta=fixed, slot=slot)).max(axis=1) > 1e-5).all()
    h = 1e-6
    J = np.stack([
        (mo.bodies.joint_residual(kind, x[0] + h * e, d_AB, theta=fixed, slot=slot)
         - mo.bodies.joint_residual(kind, x[0] - h * e, d_AB, theta=fixed, slot=slot)) / (2 * h) for e in np.eye(6)
    ], axis=-1)  # fmt: skip
    assert 6 - np.linalg.matrix_rank(J, 1e-6) == freedoms
    with pytest.raises(mf.InputError, match="RP"):
        mo.bodies.joint_residual("S", x, d_AB)


@pytest.mark.capability("02-72", "02-65", "02-50", "02-84")
def test_small_directions_straight_ways_and_counts_below_zero():
    angles, pole = mo.spaces.angles_of_direction([[1e-13, 0, 0], [0, 0, -1e-13], [3e5, 4e5, 0]])
    np.testing.assert_allclose(angles, [[np.pi / 2, 0], [np.pi, 0], [np.pi / 2, np.arctan2(4, 3)]], atol=1e-12)
    assert pole.tolist() == [False, True, False]
    straight = mo.bodies.Unicycle().drive([1.0, 2.0, 0.5], 3.0, [0.0, 1e-12], 2.0)
    np.testing.assert_allclose(straight, [[1 + 6 * np.cos(0.5), 2 + 6 * np.sin(0.5), 0.5]] * 2, atol=1e-9)
    statuses = [
        mo.gruebler_count(4, f, rule).status.name
        for f, rule in (([1] * 4, "planar"), ([1] * 5, "planar"), ([1] * 4, "spatial"))
    ]
    assert statuses == ["MOVES", "TOO_MANY", "TOO_MANY"]
    assert mo.gruebler_count(5, [1] * 6, "planar").status.name == "NONE_LEFT"
    cart = mo.bodies.Cart(0.1, 0.4)
    q = cart.drive([0.0, 0.0, 0.2, 1.0, -1.0], [2.0, -0.5], 1.5)
    assert cart.first_integral(q) == pytest.approx(cart.first_integral(np.array([0.0, 0.0, 0.2, 1.0, -1.0])))
    assert q[2] == pytest.approx(0.2 + 0.1 / 0.4 * 2.5 * 1.5)


@pytest.mark.capability("02-58", "02-60")
def test_classes_of_four_bars_and_cranks_by_their_ranges():
    """A crank turns fully if and only if its range is all of 0 .. pi: read off the positions, not the lengths."""
    rng = np.random.default_rng(2)
    theta = np.linspace(-np.pi, np.pi, 361)
    for lengths in rng.uniform(0.5, 3.0, (200, 4)):
        a, b, c, d = lengths
        four, margin = mo.FourBar(*lengths), 2 * (lengths.min() + lengths.max()) - lengths.sum()
        if not four.space or abs(margin) < 1e-3 or abs(four.space.excess) < 1e-3:
            continue
        first = four.positions(theta).reachable.all()
        # The other crank: the same bars read from the other side.
        last = mo.FourBar(c, b, a, d).positions(theta).reachable.all()
        expected = {(True, True): "DOUBLE_CRANK", (True, False): "CRANK_ROCKER", (False, True): "ROCKER_CRANK"}
        name = expected.get((bool(first), bool(last)), "DOUBLE_ROCKER" if margin < 0 else "TRIPLE_ROCKER")
        assert four.grashof.name == name, lengths
    for r, rod in ((1.0, 3.0), (3.0, 1.0)):
        crank = mo.SliderCrank(r, rod)
        assert crank.full_turn == (crank.positions(theta).status is mo.slider_crank.SliderStatus.ALL)


@pytest.mark.capability("02-53", "02-60")
def test_links_in_one_line_and_cranks_beside_their_way():
    for lengths in ([1, 1, 1, 3], [0.1, 0.2, 0.3, 0.6]):
        found = mo.spaces.polygon_space(lengths)
        assert (found.status.name, found.components, found.dimension) == ("ISOLATED", 1, 0)
    assert mo.spaces.polygon_space([1, 1, 1, 3.001]).status.name == "IMPOSSIBLE"
    assert mo.spaces.polygon_space([1, 1, 1, 2.999]).status.name == "SMOOTH"
    assert mo.spaces.polygon_space([2, 2, 2, 2]).status.name == "BRANCHED"
    crank, theta = mo.SliderCrank(1.3, 2.1, 0.4), np.array([0.2, 2.0, -1.9])
    for x, angle in zip(crank.positions(theta).x, theta, strict=True):
        pin = 1.3 * np.array([np.cos(angle), np.sin(angle)])
        for place in x:
            assert np.hypot(place - pin[0], 0.4 - pin[1]) == pytest.approx(2.1)
    # The rod reaches the way where |r sin(theta) - e| <= l.
    short = mo.SliderCrank(1.3, 1.0, 0.4)
    np.testing.assert_allclose(
        short.positions(theta).missing, np.maximum(np.abs(1.3 * np.sin(theta) - 0.4) - 1.0, 0.0), atol=1e-12
    )
    drawn = crank.linkage(0.7)
    assert largest_gap(drawn) < 1e-12
    assert mf.mobility(drawn).mobility == 1
    places = {tuple(np.round(each.point[:2], 9)) for each in drawn.joints}
    assert tuple(np.round(1.3 * np.array([np.cos(0.7), np.sin(0.7)]), 9)) in places


@pytest.mark.capability("02-60", "08-47", "08-48")
@pytest.mark.parametrize("lengths", [(2, 2, 2, 2), (2, 3, 3, 2), (4, 1, 1, 4)])
def test_kites_fold_together_and_swing(lengths):
    """Where crank pin and ground pivot coincide, any direction closes: said, and a curve of its own."""
    four = mo.FourBar(*lengths)
    found = four.positions([0.0, 1e-6, 0.2])
    assert found
    assert found.status is mo.four_bar.PositionStatus.FREE
    assert found.free.tolist() == [True, False, False]
    np.testing.assert_allclose(found.C[0], found.C[1], atol=1e-5)
    both, folded = four.curves()
    for curve in (both, folded):
        assert np.abs(four.closure(curve)).max() < 1e-7
        assert np.abs(mo.torus.difference(curve, np.roll(curve, 1, axis=0))).max() < 0.1
    np.testing.assert_allclose(folded[:, 0], 0.0)
    assert np.ptp(folded[:, 1]) > 0.99 * 2 * np.pi


@pytest.mark.capability("02-82")
def test_chains_that_return_to_their_base():
    for lengths, pieces, dimension in (([1, 1], 1, 1), ([1, 1, 1, 3], 1, 1), ([2, 2, 2], 2, 1), ([1, 1, 1, 1], 1, 2)):
        found = mo.self_motion_manifold(lengths, 0.0)
        assert (found.components, found.dimension) == (pieces, dimension)
    assert "swings" in mo.self_motion_manifold([1, 1], 0.0).explain("en")
    assert (mo.self_motion_manifold([1.5], 1.5).dimension, mo.self_motion_manifold([1.5], 1.0).dimension) == (0, None)


@pytest.mark.capability("02-72")
def test_no_direction_has_no_angles():
    with pytest.raises(mf.InputError, match="length zero"):
        mo.spaces.angles_of_direction([[0, 0, 1], [0, 0, 0]])


@pytest.mark.parametrize("lengths", np.random.default_rng(7).uniform(0.5, 2.0, (12, 4)))
def test_a_drawn_four_bar_is_known_by_its_links(lengths):
    bar = mo.FourBar(*lengths)
    if bar.input_range is None:
        pytest.skip("these links do not close")
    known = four_bar_of(bar.linkage(float(np.mean(bar.input_range))))
    assert known is not None
    np.testing.assert_allclose(known.lengths, bar.lengths)
    assert say(f"mobility.{bar.grashof.value}", language="en") in mf.mobility(bar).explain("en").split("\n")


def test_other_linkages_have_no_class_of_grashof():
    assert four_bar_of(mo.library.watt()) is None
    assert four_bar_of(mo.library.slider_crank()) is None
    assert four_bar_of(mo.library.chain(2)) is None
