"""Spherical four-bars: planted ones are found for orientations and angles, and their defects are true."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil.errors import InputError
from mafsil.geometry import rotation
from mafsil.mobility import FourBar
from mafsil.mobility import synthesis as syn
from mafsil.mobility.synthesis.answers import SynthesisStatus
from mafsil.mobility.synthesis.candidate import CandidateStatus
from mafsil.mobility.synthesis.crank_chain import Placed, judge_positions


def planted(rng, count, span=1.4):
    """A spherical four-bar that closes in one mode at `count` angles of the crank, and these angles."""
    while True:
        bar = syn.SphericalFourBar.of(*rng.uniform(0.3, 1.5, 4))
        theta, mode = rng.uniform(-3, 3) + np.linspace(0, span, count), int(rng.choice([-1, 1]))
        if np.isfinite(bar.axes(theta, mode)[1]).all() and np.abs(bar.cosines(theta, [1])).max() < 0.98:
            return bar, theta, mode


def arcs(bar):
    return np.array([bar.crank, bar.coupler, bar.rocker, bar.ground])


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_five_orientations_give_the_linkage_back(seed):
    rng = np.random.default_rng(seed)
    bar, theta, mode = planted(rng, 5)
    frame, turn = (np.asarray(rotation.exp(rng.normal(size=3))) for _ in range(2))
    R = frame @ bar.coupler_orientations(theta, mode) @ turn
    found = syn.synthesise_spherical_motion(R)
    assert len(found) <= 15
    axes = np.stack([frame @ bar.A, frame @ bar.D])
    gaps = [min(_apart(one.linkage.pivots, axes), _apart(one.linkage.pivots, axes[::-1])) for one in found]
    assert min(gaps) < 1e-5
    for one in found:
        frames = [one.linkage.coupler_orientations(t, int(m[0])) for t, m in zip(one.theta, one.modes, strict=True)]
        offset = np.array([step.T @ given for step, given in zip(frames, R, strict=True)])
        assert np.abs(offset - offset[0]).max() < 1e-6


def _apart(pivots, axes):
    """Largest distance of axes, each in its nearer sense."""
    return max(min(np.abs(p - a).max(), np.abs(p + a).max()) for p, a in zip(pivots, axes, strict=True))


@pytest.mark.parametrize("count", [3, 4, 5])
@pytest.mark.parametrize("seed", range(8))
def test_angles_of_a_planted_linkage_give_it_back(count, seed):
    bar, theta, mode = planted(np.random.default_rng([count, seed]), count)
    phi = bar.output_angle(theta, [mode])
    found = syn.synthesise_spherical_function(theta, phi, ground=bar.ground)
    assert len(found) <= {3: 1, 4: 2, 5: 5}[count]
    same = [np.abs(np.cos(arcs(one.linkage)) ** 2 - np.cos(arcs(bar)) ** 2).max() for one in found]
    assert min(same) < 1e-6
    for one in found:
        turned = [one.linkage.output_angle(t, m.tolist()) for t, m in zip(one.theta, one.modes, strict=True)]
        step = np.diff(turned) - np.diff(phi)
        assert np.abs(np.angle(np.exp(1j * step))).max() < 1e-6


def test_hookes_joint_is_found_from_its_equation():
    """Published: tan(phi) = cos(beta) tan(theta) of a universal joint, a spherical four-bar of three right arcs."""
    beta, theta = np.radians(30), np.radians([20.0, 50.0, 110.0])
    phi = np.arctan2(np.cos(beta) * np.sin(theta), np.cos(theta))
    # Pins stand across each other: the rocker of right arcs is a right angle behind.
    found = syn.synthesise_spherical_function(theta, phi + np.pi / 2, ground=beta)
    swapped = syn.synthesise_spherical_function(
        theta, np.arctan2(np.sin(theta), np.cos(beta) * np.cos(theta)) + np.pi / 2, ground=beta
    )
    best = min([*found, *swapped], key=lambda one: np.abs(arcs(one.linkage)[:3] - np.pi / 2).max())
    np.testing.assert_allclose(arcs(best.linkage), [np.pi / 2, np.pi / 2, np.pi / 2, beta], atol=1e-9)


def test_small_arcs_are_the_plane():
    """Freudenstein's planar linkage appears as the limit of small arcs."""
    small = 1e-4
    bar = FourBar(1.0, 2.2, 2.0, 2.5)
    theta = np.array([0.4, 0.9, 1.5])
    C = bar.positions(theta).C[:, 0]
    phi = np.arctan2(C[:, 1], C[:, 0] - bar.ground)
    found = syn.synthesise_spherical_function(theta, phi, ground=small * bar.ground)
    np.testing.assert_allclose(arcs(found[0].linkage) / small, bar.lengths, rtol=1e-6)


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("count", [3, 4])
def test_families_take_the_orientations_and_keep_limits(count, seed):
    rng = np.random.default_rng([7, count, seed])
    bar, theta, mode = planted(rng, count)
    R = bar.coupler_orientations(theta, mode)
    limits = syn.LinkageLimits(transmission=np.radians(25), longest=1.4)
    found = syn.synthesise_spherical_motion(R, samples=10, limits=limits)
    assert found.assembled > 3
    for one in found:
        assert one.residual < 1e-9
        assert one.worst >= np.radians(25)
        assert max(one.linkage.lengths.values()) <= 1.4
        assert mf.mobility(one.linkage.drawn(float(one.theta[0]))).mobility == 1


@pytest.mark.parametrize("seed", range(30))
def test_defects_are_those_of_a_walk_along_the_crank(seed):
    """The same verdicts by small steps of the crank: it is stopped at dead points and swings between them."""
    rng = np.random.default_rng(seed)
    while True:
        bar = syn.SphericalFourBar.of(*rng.uniform(0.3, 1.5, 4))
        theta, modes = rng.uniform(-np.pi, np.pi, 3), rng.choice([-1, 1], (3, 1))
        if np.abs(bar.cosines(theta, [1])).max() < 0.97:
            break
    one = judge_positions(Placed(bar, theta, modes, 0.0))
    grid = np.linspace(-np.pi, np.pi, 7200, endpoint=False)
    open_ = np.abs(bar.cosines(grid, [1])[:, 0]) > 1
    if not open_.any():
        circuit = (modes != modes[0]).any()
        branch = False
    else:
        piece = np.cumsum(open_ & ~np.roll(open_, 1))
        piece = np.where(piece == piece[-1], piece[0] if not open_[0] else piece, piece)
        at = piece[np.searchsorted(grid, theta) - 1]
        # Symmetric about the arc from A to D: pieces hold both modes, which meet at their ends.
        circuit = len(set(at.tolist())) > 1
        branch = not circuit and bool((modes != modes[0]).any())
    assert (CandidateStatus.CIRCUIT in one.defects) == circuit
    assert (CandidateStatus.BRANCH in one.defects) == branch


@pytest.mark.parametrize(
    ("orientations", "words"),
    [
        (np.tile(np.eye(3), (3, 1, 1)), "coincide"),
        (np.eye(3)[None], "three to five"),
        (np.stack([np.eye(3), 2 * np.eye(3), np.diag([1.0, -1, -1])]), "no rotation"),
        (np.asarray(rotation.exp(np.array([[0, 0, 0.0], [0, 0, 0.4], [0, 0, 1.0]]))), "one axis"),
    ],
)
def test_wrong_orientations_are_refused(orientations, words):
    with pytest.raises(InputError) as caught:
        syn.synthesise_spherical_motion(orientations)
    assert words in caught.value.message("en")


def test_an_impossible_function_is_said():
    found = syn.synthesise_spherical_function([0.0, 0.4, 0.8, 1.2], [0.0, 2.4, 0.1, 3.0], ground=0.8)
    assert found.status in (SynthesisStatus.NO_LINKAGE, SynthesisStatus.DEFECTIVE, SynthesisStatus.FREE)
    assert found.explain("ar")
    with pytest.raises(InputError):
        syn.synthesise_spherical_function([0.0, 0.4, 0.8], [0.0, 0.4, 0.9], ground=4.0)
