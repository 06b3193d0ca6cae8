"""Defects of candidates against the linkage's own curves, followed step by step."""

import numpy as np
import pytest

from mafsil.mobility import FourBar, SliderCrank
from mafsil.mobility import synthesis as syn
from mafsil.mobility.synthesis.assessment import assess_four_bars, assess_slider_cranks
from mafsil.mobility.synthesis.candidate import CandidateStatus
from tests.mobility.planted_bars import wrapped
from tests.sizes import few


def random_positions(rng, count):
    while True:
        bar = FourBar(*rng.uniform(0.3, 3, 4))
        theta = rng.uniform(-np.pi, np.pi, count)
        found = bar.positions(theta)
        if found.reachable.all():
            modes = rng.integers(0, 2, count) if rng.random() < 0.5 else np.full(count, rng.integers(2))
            return bar, found.theta[np.arange(count), modes]


def assessed(bar, theta):
    s = np.cumsum(theta, axis=-1)
    B = bar.crank * np.exp(1j * s[:, 0])
    C = B + bar.coupler * np.exp(1j * s[:, 1])
    return assess_four_bars(np.zeros(1, complex), B[None], C[None], np.full(1, bar.ground, complex))


@pytest.mark.parametrize("seed", few(range(60), 12))
def test_circuits_are_the_closed_curves_of_the_configurations(seed):
    bar, theta = random_positions(np.random.default_rng(seed), 4)
    found = assessed(bar, theta)
    curves = bar.curves(2001)
    nearest = [int(np.argmin([np.abs(wrapped(curve - one)).max(axis=1).min() for curve in curves])) for one in theta]
    same = np.array(nearest) == nearest[0]
    np.testing.assert_array_equal(found.circuits[0] == found.circuits[0, 0], same)
    assert bool(found.circuit_defect[0]) == (not same.all())


@pytest.mark.parametrize("seed", few(range(60), 12))
def test_a_good_linkage_is_driven_through_its_positions_and_the_worst_angle_is_met(seed):
    """The crank is moved in small steps in the mode of the first position: it passes all positions, in order."""
    rng = np.random.default_rng(1000 + seed)
    bar, theta = random_positions(rng, 3)
    found = assessed(bar, theta)
    mode = int(found.branches[0, 0] > 0)
    met = False
    least = np.inf
    for sense in (1, -1):
        steps = np.mod(sense * np.diff(theta[:, 0]), 2 * np.pi)
        if steps.sum() >= 2 * np.pi:
            continue
        path = theta[0, 0] + sense * np.linspace(0, steps.sum(), 4001)
        places = bar.positions(path)
        if not places.reachable.all():
            continue
        at = [int(np.argmin(np.abs(np.linspace(0, steps.sum(), 4001) - step))) for step in (0, steps[0], steps.sum())]
        if np.abs(wrapped(places.theta[at, mode] - theta)).max() < 5e-2:
            met = True
            angle = bar.transmission_angle(places.theta[:, mode])
            least = min(least, float(np.minimum(angle, np.pi - angle).min()), *found.transmission[0])
            assert found.worst[0] <= np.minimum(angle, np.pi - angle).min() + 1e-2 or not found.full[0]
    assert met == (found.severity[0] == 0)
    if met and not found.full[0]:
        assert abs(found.worst[0] - least) < 1e-2


def test_a_dead_point_between_positions_is_a_branch_defect():
    bar = FourBar(2.0, 1.5, 1.9, 3.0)
    places = bar.positions([0.4, 0.5])
    same, other = assessed(bar, places.theta[:, 0]), assessed(bar, places.theta[[0, 1], [0, 1]])
    assert same.severity[0] == 0
    assert other.branch_defect[0]
    assert other.worst[0] == 0.0


def test_order_is_the_order_of_a_crank_that_goes_round_or_swings():
    bar = FourBar(1.0, 2.5, 2.5, 2.0)
    for angles, good in (([0, 1, 2, 3], True), ([0, -1, -2, -3], True), ([3, -3, -2, -1], True), ([0, 2, 1, 3], False)):
        assert bool(assessed(bar, bar.positions(angles).theta[:, 0]).ordered[0]) is good
    swinging = FourBar(3.0, 1.0, 2.0, 3.5)
    low, high = swinging.input_range
    angles = low + (high - low) * np.array([0.2, 0.5, 0.8])
    assert assessed(swinging, swinging.positions(angles).theta[:, 0]).ordered[0]
    assert not assessed(swinging, swinging.positions(angles[[1, 0, 2]]).theta[:, 0]).ordered[0]


@pytest.mark.parametrize(("crank", "rod", "offset"), [(1.0, 3.0, 0.5), (2.0, 1.5, 1.0), (2.0, 0.8, 0.3)])
def test_circuits_of_slider_cranks(crank, rod, offset):
    """Configurations are joined where they are neighbours: as many circuits as connected pieces."""
    bar = SliderCrank(crank, rod, offset)
    theta = np.linspace(-np.pi, np.pi, 6001)[:-1]
    places = bar.positions(theta)
    index, mode = np.nonzero(np.stack([places.reachable, places.reachable], axis=-1))
    B, C = crank * np.exp(1j * theta[index]), places.x[index, mode] + 1j * offset
    found = assess_slider_cranks(np.zeros(1, complex), B[None], C[None], np.ones(1, complex))
    points = np.stack([B.real, B.imag, C.real], axis=1)
    pieces = _pieces(points, 0.12)
    assert len(set(pieces)) == len(set(found.circuits[0].tolist()))
    for piece in set(pieces):
        assert len(set(found.circuits[0][np.array(pieces) == piece].tolist())) == 1


def _pieces(points, reach):
    from scipy.sparse import coo_array
    from scipy.sparse.csgraph import connected_components
    from scipy.spatial import cKDTree

    pairs = cKDTree(points).query_pairs(reach, output_type="ndarray")
    graph = coo_array((np.ones(len(pairs)), pairs.T), (len(points), len(points)))
    return connected_components(graph, directed=False)[1].tolist()


def test_what_a_candidate_says_is_computed_from_its_numbers():
    rng = np.random.default_rng(7)
    seen = set()
    for _ in range(40):
        poses = np.column_stack([rng.normal(size=(5, 2)), rng.uniform(-3, 3, 5)])
        for one in syn.synthesise_motion(poses):
            seen.add(one.status)
            for language in ("en", "ar"):
                assert len(one.explain(language).split("\n")) == 1 + max(1, len(one.defects))
            assert bool(one) == (not one.defects)
            assert one.to_dict()["defects"] == [each.name.lower() for each in one.defects]
    assert seen >= {CandidateStatus.CIRCUIT, CandidateStatus.BRANCH, CandidateStatus.ORDER}


def test_good_candidates_stand_first_and_are_counted():
    rng = np.random.default_rng(2)
    poses = np.column_stack([rng.normal(size=(3, 2)), rng.uniform(-1, 1, 3)])
    found = syn.synthesise_motion(poses)
    weights = [4 * (CandidateStatus.CIRCUIT in one.defects) + 2 * (CandidateStatus.BRANCH in one.defects)
               + (CandidateStatus.ORDER in one.defects) for one in found]  # fmt: skip
    assert weights == sorted(weights)
    assert f"{found.ranking.free} of {found.ranking.count}" in found.explain("en")
    assert len(repr(found).split("\n")) <= 25
