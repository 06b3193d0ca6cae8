"""Over-constrained mechanisms by construction: mobility, redundant constraints, causes; rounding of drawings."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import mafsil as mf
from mafsil import mobility as mo
from mafsil.mobility import Linkage, joint, library
from mafsil.mobility.redundant_constraints import shortest_loops
from tests.mobility.composed import wrong


@pytest.mark.capability("02-50", "02-78")
@pytest.mark.parametrize("first", range(0, 40, 10))
def test_composed_mechanisms_are_judged_rightly(first):
    assert [text for seed in range(first, first + 10) if (text := wrong(seed))] == []


def test_a_doubled_joint_is_its_own_cause():
    """The loop of the two is the shortest: it says that one of them is implied, not that lengths happen to fit."""
    bars = library.four_bar()
    for each in bars.joints:
        found = mf.mobility(Linkage.of([*bars.joints, replace(each, name="twin")], output=bars.output))
        causes = {(frozenset(cause.joints), cause.implied) for cause in found.redundancy}
        assert (frozenset({each.name, "twin"}), 5) in causes
        assert found.mobility == 1
        assert not found.redundancy.special


def test_shortest_loops_are_independent_and_no_longer_than_those_of_a_walk():
    for make in (library.watt, library.stephenson, library.peaucellier, library.six_ups, library.delta):
        linkage = make()
        loops = shortest_loops(linkage)
        rows = np.array([np.isin(np.arange(len(linkage.joints)), loop) for loop in loops], dtype=float)
        assert len(loops) == linkage.loops == np.linalg.matrix_rank(rows)
        assert rows.sum() <= np.abs(linkage.cycles).sum()
        for row in rows:
            ends = linkage.ends[row > 0].ravel()
            assert (np.bincount(ends)[np.unique(ends)] == 2).all()


@pytest.mark.parametrize("seed", range(8))
def test_axes_through_a_point_that_is_no_round_number_make_a_spherical_linkage(seed):
    """The mean of equal points is off by rounding, which is no size of a linkage."""
    rng = np.random.default_rng(seed)
    point, bodies = 1e3 * rng.normal(size=3), ["ground", "a", "b", "c", "ground"]
    joints = [joint(f"J{k}", "R", bodies[k : k + 2], point, rng.normal(size=3)) for k in range(4)]
    twin = joint("twin", "R", bodies[1:3], point, joints[1].axis)
    found = mf.mobility(Linkage.of([*joints, twin], output="b"))
    assert (found.linkage.size, found.mobility) == (1.0, 1)


def test_digits_that_were_rounded_are_said():
    drawn, R = library.bennett(), Rotation.from_rotvec([0.3, 0.5, -0.2]).as_matrix()
    for digits, mobility, nearly in ((6, 0, 1), (15, 1, 0)):
        joints = [
            replace(each, point=np.round(R @ each.point, digits), axis=np.round(R @ each.axis, digits))
            for each in drawn.joints
        ]
        found = mf.mobility(Linkage.of(joints))
        assert (found.mobility, found.nearly) == (mobility, nearly)
        assert ("the mobility by rank would be 1: give nine digits" in found.explain("en")) == bool(nearly)
    assert not any(mo.mobility(name).nearly for name in ("four_bar", "sarrus", "six_ups", "peaucellier"))
