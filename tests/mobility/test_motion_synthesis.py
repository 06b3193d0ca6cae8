"""Motion generation: planted linkages are among all solutions, counts are Burmester's, hostile poses are answered."""

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st
from scipy.optimize import fsolve

import mafsil as mf
from mafsil.errors import InputError
from mafsil.mobility import FourBar, SliderCrank
from mafsil.mobility import synthesis as syn
from mafsil.mobility.synthesis.answers import SynthesisStatus
from tests.mobility.planted_bars import planted, wrapped


def pose_error(one, poses):
    met = np.array([one.coupler_poses(t, m) for t, m in zip(one.theta, one.modes, strict=True)])
    size = 1 + np.abs(np.concatenate([one.A, one.D])).max()
    return max(np.abs(met[:, :2] - poses[:, :2]).max() / size, np.abs(wrapped(met[:, 2] - poses[:, 2])).max())


def unlike(one):
    """Longest link over shortest: by so much rounding of the one shows at the other."""
    bar = one.linkage
    links = bar.lengths if isinstance(bar, FourBar) else np.array([bar.crank, bar.rod])
    return links.max() / links.min()


def is_planted(one, plant, tolerance=1e-6):
    pivots, other = np.array([one.A, one.D]), np.array([plant.A, plant.D])
    return min(np.abs(pivots - other).max(), np.abs(pivots[::-1] - other).max()) < tolerance


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_five_poses_of_a_four_bar_give_it_back_and_all_candidates_take_them(seed):
    plant = planted(np.random.default_rng(seed), 5)
    found = syn.synthesise_motion(plant.poses)
    hits = [one for one in found if is_planted(one, plant, 1e-4)]
    assert hits
    assert max(one.residual for one in hits) < 1e-9
    assert len(found.dyads) in (2, 4)
    assert len(found) <= 6
    assert max(pose_error(one, plant.poses) / unlike(one) for one in found) < 1e-11


@pytest.mark.parametrize("seed", range(4))
def test_no_dyad_is_missed_that_newtons_method_finds_from_many_starts(seed):
    """The equations as McCarthy writes them, |A_j w + d_j - G| = |A_1 w + d_1 - G|, by MINPACK from 400 starts."""
    rng = np.random.default_rng(seed)
    poses = np.column_stack([rng.normal(size=(5, 2)), rng.uniform(-2, 2, 5)])
    R = np.array([[[np.cos(a), -np.sin(a)], [np.sin(a), np.cos(a)]] for a in poses[:, 2]])

    def equations(x):
        gaps = R @ x[2:] + poses[:, :2] - x[:2]
        square = (gaps**2).sum(axis=1)
        return square[1:] - square[0]

    found = syn.synthesise_motion(poses)
    known = [np.concatenate([one.pivot, one.point]) for one in found.dyads]
    hits = 0
    for start in rng.normal(scale=3, size=(400, 4)):
        x, _, flag, _ = fsolve(equations, start, xtol=1e-13, full_output=True)
        if flag == 1 and np.abs(equations(x)).max() < 1e-9 and np.abs(x).max() < 1e3:
            hits += 1
            assert min((np.abs(x - one).max() for one in known), default=np.inf) < 1e-5 * (1 + np.abs(x).max())
    assert hits or not known


def test_many_lists_of_poses_at_once_have_the_same_dyads():
    rng = np.random.default_rng(3)
    poses = np.array([planted(rng, 5).poses for _ in range(20)]).reshape(4, 5, 5, 3)
    many = syn.five_pose_dyads(poses)
    assert many.fixed.shape == (4, 5, 4, 2)
    for index in np.ndindex(4, 5):
        alone = syn.synthesise_motion(poses[index]).dyads
        assert many.count[index] == len(alone)
        for k, one in enumerate(alone):
            np.testing.assert_allclose(many.fixed[index][k], one.pivot, rtol=1e-6, atol=1e-6)
            np.testing.assert_allclose(many.moving[index][k], one.point, rtol=1e-6, atol=1e-6)
    assert np.isnan(many.fixed[many.count == 2][:, 2:]).all()
    assert syn.five_pose_dyads(np.zeros((0, 5, 3))).count.shape == (0,)


def test_the_answer_follows_a_motion_and_a_scale_of_the_plane():
    plant = planted(np.random.default_rng(11), 5)
    scale, turn, shift = 250.0, 1.1, np.array([3e3, -2e3])
    R = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    moved = np.column_stack([scale * plant.poses[:, :2] @ R.T + shift, plant.poses[:, 2] + turn])
    first, second = syn.synthesise_motion(plant.poses), syn.synthesise_motion(moved)
    assert len(first) == len(second)
    for one, other in zip(first, second, strict=True):
        np.testing.assert_allclose(other.linkage.lengths, scale * one.linkage.lengths, rtol=1e-8)
        np.testing.assert_allclose(other.A, scale * R @ one.A + shift, rtol=1e-7)
        assert other.defects == one.defects


@pytest.mark.parametrize("seed", range(5))
def test_four_poses_pivots_lie_on_burmesters_curves(seed):
    plant = planted(np.random.default_rng(seed), 4)
    found = syn.synthesise_motion(plant.poses, samples=40)
    assert max(pose_error(one, plant.poses) for one in found) < 1e-9
    curves = syn.burmester_curves(plant.poses, 4001)
    points = curves.centre_points[np.isfinite(curves.centre_points).all(axis=-1)]
    for pivot in (plant.A, plant.D):
        assert np.hypot(*(points - pivot).T).min() < 0.05
    assert found.ranking.count == 0 or found.candidates


@pytest.mark.parametrize("seed", range(5))
def test_three_poses_take_the_pivots_that_are_given(seed):
    plant = planted(np.random.default_rng(seed), 3)
    found = syn.synthesise_motion(plant.poses, fixed=[plant.A, plant.D])
    assert len(found) == 1
    assert is_planted(found[0], plant)
    np.testing.assert_allclose(sorted(found[0].linkage.lengths), sorted(plant.bar.lengths), rtol=1e-8)
    again = syn.synthesise_motion(plant.poses, moving=[one.point for one in found.dyads])
    assert is_planted(again[0], plant)


def test_a_slider_crank_is_found_where_a_pivot_is_at_infinity():
    bar, theta = SliderCrank(1.0, 2.6, 0.4), np.linspace(0.3, 2.2, 5)
    B, x = np.exp(1j * theta), bar.positions(theta).x[:, 0]
    C = x + 0.4j
    u = (C - B) / np.abs(C - B)
    z = B + (0.7 + 0.9j) * u
    poses = np.stack([z.real, z.imag, np.angle(u) + 0.5], axis=1)
    found = syn.synthesise_motion(poses)
    sliders = [one for one in found if isinstance(one.linkage, SliderCrank)]
    best = min(sliders, key=lambda one: abs(one.linkage.rod - 2.6))
    np.testing.assert_allclose([best.linkage.crank, best.linkage.rod, abs(best.linkage.offset)], [1, 2.6, 0.4])
    assert pose_error(best, poses) < 1e-9
    assert best
    assert syn.DyadKind.BLOCK in [one.kind for one in found.dyads]
    assert "slider-crank" in best.explain("en")
    assert best.drawn(2).name == "slider-crank"


def test_a_slot_on_the_coupler_is_named():
    """The inverse motion of a slider-crank: its block's line is a line of the coupler."""
    bar, theta = SliderCrank(1.0, 2.6, 0.4), np.linspace(0.3, 2.2, 5)
    B, x = np.exp(1j * theta), bar.positions(theta).x[:, 0]
    angle = np.angle(x + 0.4j - B)
    z = -B * np.exp(-1j * angle)
    found = syn.synthesise_motion(np.stack([z.real, z.imag, -angle], axis=1))
    assert syn.DyadKind.SLOT in [one.kind for one in found.dyads]
    assert "slot" in found.explain("en")


def test_pure_translations_are_answered_in_words():
    corner = np.array([[0, 0, 0.3], [1, 0, 0.3], [2, 0, 0.3], [3, 0.1, 0.3]])
    found = syn.synthesise_motion(corner)
    assert found.status is SynthesisStatus.TRANSLATION
    assert "no circle" in found.explain("en")
    angle = np.array([0.1, 0.9, 1.7, 2.0, 3.0])
    circle = np.column_stack([np.cos(angle), np.sin(angle), np.zeros(5)])
    assert "parallel cranks" in syn.synthesise_motion(circle).explain("en")
    three = syn.synthesise_motion(circle[:3])
    assert all(one.grashof is mf.mobility.GrashofClass.CHANGE_POINT for one in three)


def test_rotations_about_one_point_need_a_hinge_only():
    angle = np.array([0.0, 0.5, 1.2, 1.9, 2.5])
    arm = 2 * np.exp(1j * angle) + (3 - 1j)
    found = syn.synthesise_motion(np.column_stack([arm.real, arm.imag, angle]))
    assert found.status is SynthesisStatus.ONE_POLE
    assert "(3, -1)" in found.explain("en")
    assert not found
    assert len(found) == 0


def test_collinear_places_are_no_special_case():
    poses = np.column_stack([np.linspace(0, 4, 5), np.zeros(5), [0.0, 0.2, 0.35, 0.9, 1.2]])
    found = syn.synthesise_motion(poses)
    assert len(found.dyads) in (0, 2, 4)
    assert all(pose_error(one, poses) < 1e-9 for one in found)


@pytest.mark.parametrize(
    ("poses", "words"),
    [
        ([[0, 0, 0], [1, 1, 1], [0, 0, 2 * np.pi]], "poses 1 and 3 coincide"),
        ([[0, 0, 0], [1, 1, 1]], "3 to 5"),
        (np.zeros((6, 3)), "3 to 5"),
        ([[0, 0, 0], [1, np.nan, 1], [2, 2, 2]], "nan"),
        ([[0, 0], [1, 1], [2, 2]], "(3, 2)"),
        ("poses", "real numbers"),
    ],
)
def test_wrong_poses_are_refused(poses, words):
    with pytest.raises(InputError) as caught:
        syn.synthesise_motion(poses)
    assert words in caught.value.message("en")
    assert caught.value.message("ar") != caught.value.message("en")


def test_pivots_are_chosen_for_three_poses_only():
    plant = planted(np.random.default_rng(0), 4)
    with pytest.raises(InputError, match="three poses only"):
        syn.synthesise_motion(plant.poses, fixed=[[0, 0], [1, 0]])
    with pytest.raises(InputError, match="two or more points"):
        syn.synthesise_motion(plant.poses[:3], moving=[[0, 0]])
    with pytest.raises(InputError):
        syn.synthesise_motion(plant.poses[:3], fixed=[[0, 0], [1, 0]], moving=[[0, 0], [1, 0]])


def test_two_complex_pairs_of_dyads_are_said():
    rng = np.random.default_rng(5)
    for _ in range(200):
        poses = np.column_stack([rng.normal(size=(5, 2)), rng.uniform(-3, 3, 5)])
        found = syn.synthesise_motion(poses)
        if not found.dyads:
            break
    assert found.status is SynthesisStatus.NONE
    assert "0 of at most four dyads are real" in found.explain("en")


def test_known_linkages_of_the_literature_are_found_again():
    """Chebyshev's and Hoecken's straight-line linkages by their ratios: 5 : 2 : 5 : 4 and 1 : 2.5 : 2.5 : 2.

    A. B. Kempe, How to Draw a Straight Line, 1877 (Tchebicheff); F. Artobolevsky, Mechanisms in Modern Engineering
    Design, vol. 1 (Hoecken).
    """
    for lengths, angles in (((5, 2, 5, 4), np.linspace(0.7, 1.2, 5)), ((1, 2.5, 2.5, 2), np.linspace(2.2, 4.0, 5))):
        bar = FourBar(*map(float, lengths))
        found = bar.positions(angles)
        s = np.cumsum(found.theta[:, 0], axis=-1)
        B = bar.crank * np.exp(1j * s[:, 0])
        again = syn.synthesise_motion(np.stack([B.real, B.imag, s[:, 1]], axis=1))
        gaps = [
            min(np.abs(one.linkage.lengths - lengths).max(), np.abs(one.linkage.lengths[[2, 1, 0, 3]] - lengths).max())
            for one in again
        ]
        assert min(gaps) < 1e-6


@pytest.mark.parametrize("seed", range(10))
def test_five_poses_of_two_angles_have_up_to_two_dyads(seed):
    """Planted: a parallel point of two circles; the moving pivot lies on a circle in all five poses."""
    rng = np.random.default_rng(seed)
    w, m, r = rng.normal(size=2) @ [1, 1j], rng.normal(size=2) @ [1, 1j], rng.uniform(0.5, 2)
    angle = rng.permutation([0.4, 0.4, 0.4, 1.5, 1.5])
    z = m + r * np.exp(1j * rng.uniform(-3, 3, 5)) - np.exp(1j * angle) * w
    poses = np.column_stack([z.real, z.imag, angle])
    found = syn.synthesise_motion(poses)
    assert found.status is not SynthesisStatus.INFINITE
    gaps = [np.abs(np.append(one.pivot, one.point) - [m.real, m.imag, w.real, w.imag]).max() for one in found.dyads]
    assert min(gaps) < 1e-8
    assert len(gaps) <= 2
    assert max(one.residual for one in found.dyads) < 1e-9


def test_five_poses_of_two_angles_that_are_special():
    line = np.column_stack([[0, 1, 3, 2, 2.5], [0, 1, 3, 0.3, 1.1], [0, 0, 0, 1, 1]])
    assert syn.synthesise_motion(line).status is SynthesisStatus.NONE
    line[3, :2] = line[4, :2] - 0.7
    assert syn.synthesise_motion(line).status is SynthesisStatus.INFINITE
    a = np.array([0.1, 0.8, 1.9, 3.0])
    circle = np.column_stack([np.append(np.cos(a), 2), np.append(np.sin(a), 0.3), [0, 0, 0, 0, 1]])
    assert syn.synthesise_motion(circle).status is SynthesisStatus.INFINITE
    circle[0, 0] += 0.3
    assert syn.synthesise_motion(circle).status is SynthesisStatus.NONE


@pytest.mark.parametrize("count", [3, 4])
def test_three_and_four_poses_have_blocks_too(count):
    rng = np.random.default_rng(count)
    for _ in range(10):
        poses = np.column_stack([rng.normal(size=(count, 2)), rng.uniform(-2, 2, count)])
        found = syn.synthesise_motion(poses, samples=16)
        blocks = [one for one in found.dyads if one.kind is syn.DyadKind.BLOCK]
        assert len(blocks) == (12 if count == 3 else 1)
        for one in blocks:
            across = one.places @ one.pivot
            assert np.ptp(across) < 1e-9 * (1 + np.abs(one.places).max())


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(*[st.integers(-2, 2)] * 3), min_size=3, max_size=5, unique=True))
def test_poses_on_a_grid_are_answered_and_taken(rows):
    """Equal angles, equal places, lines and circles abound there."""
    poses = np.array(rows) * [1.0, 1.0, np.pi / 4]
    found = syn.synthesise_motion(poses, samples=9)
    assert found.explain("en") != found.explain("ar")
    assume(found.candidates)
    for one in found:
        step = (one.C - one.B) @ [1, 1j]
        u = step / np.abs(step)
        z = one.B @ [1, 1j] + (one.along + 1j * one.across) * u
        size = 1 + np.abs(one.B).max()
        assert np.abs(z - poses[:, :2] @ [1, 1j]).max() < 1e-7 * size
        assert np.abs(wrapped(np.angle(u) + one.turned - poses[:, 2])).max() < 1e-7
        assert one.residual < 1e-7 * size
