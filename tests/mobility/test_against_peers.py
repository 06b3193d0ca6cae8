"""Ranks of random mechanisms against Pinocchio's constraint Jacobian; over-constrained ones by construction."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import mafsil as mf
from mafsil import mobility as mo
from mafsil.geometry import pose
from tests.mobility.mechanisms import random_linkage
from tests.sizes import few


@pytest.mark.parametrize("seed", few(range(60), 12))
def test_rank_of_random_mechanisms(seed):
    pytest.importorskip("pinocchio")
    from tests.mobility.pinocchio_rank import PinocchioLinkage

    rng = np.random.default_rng(seed)
    linkage = random_linkage(rng, int(rng.integers(0, 4)), int(rng.integers(3, 9)))
    assert mo.instantaneous_mobility(linkage).mobility == PinocchioLinkage(linkage).mobility()


def test_many_configurations_of_one_mechanism():
    linkage = mo.library.stewart_gough("SPS")
    rng = np.random.default_rng(0)
    theta = mo.linkages.close_loops_near(linkage, 0.1 * rng.normal(size=(200, linkage.coordinates)))
    assert theta
    assert set(mo.batch_mobility(linkage, theta.theta).tolist()) == {12}


@settings(max_examples=20, deadline=None)
@given(st.integers(0, 2**31))
def test_displaced_and_scaled_mechanisms_have_the_same_mobility(seed):
    rng = np.random.default_rng(seed)
    linkage = random_linkage(rng, 2, 6)
    T, scale = pose.exp(rng.normal(size=6)), 10.0 ** rng.uniform(-3, 3)
    moved = []
    for each in linkage.joints:
        second = T[:3, :3] @ each.second if each.kind is mo.linkages.Kind.UNIVERSAL else None
        place, axis = scale * (T[:3, :3] @ each.point + T[:3, 3]), T[:3, :3] @ each.axis
        bodies, pitch = [each.parent, each.child], scale * each.pitch
        moved.append(mo.joint(each.name, each.kind, bodies, place, axis, second=second, pitch=pitch))
    other = mo.Linkage.of(moved, ground="b0")
    assert mo.instantaneous_mobility(other).mobility == mo.instantaneous_mobility(linkage).mobility
    assert mo.redundant_constraints(other).count == mo.redundant_constraints(linkage).count


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 2**31), st.integers(2, 5))
def test_over_constrained_by_construction(seed, legs):
    """Equal parallel cranks, however many, at a random place and angle in space: one finite motion."""
    rng = np.random.default_rng(seed)
    T, angle, joints = pose.exp(rng.normal(size=6)), rng.uniform(0.3, 2.8), []
    for k in range(legs):
        foot = np.array([2.0 * k, 0.0]) + rng.uniform(-0.8, 0.8, 2)
        tip = foot + np.array([np.cos(angle), np.sin(angle)])
        for name, bodies, place in ((f"G{k}", ["ground", f"c{k}"], foot), (f"K{k}", [f"c{k}", "coupler"], tip)):
            joints.append(mo.joint(name, "R", bodies, (T @ [*place, 0, 1])[:3], T[:3, 2]))
    found = mf.mobility(mo.Linkage.of(joints, output="coupler"))
    assert found.count.rule == "planar"
    assert found.count.mobility == 3 * (legs + 2 - 1 - 2 * legs) + 2 * legs
    assert found.mobility == 1
    assert found.redundancy.special == legs - 2
    moved = {"K1": 0.1 * T[:3, 0]}
    bent = [mo.joint(j.name, "R", [j.parent, j.child], j.point + moved.get(j.name, 0), T[:3, 2]) for j in joints]
    assert mf.mobility(mo.Linkage.of(bent, output="coupler")).mobility == (1 if legs == 2 else 0)


@settings(max_examples=15, deadline=None)
@given(st.integers(0, 2**31))
def test_two_folding_chains_guide_a_straight_line(seed):
    """Sarrus: chains of three parallel hinges in two planes at any angle give one translation."""
    rng, joints = np.random.default_rng(seed), []
    for k, angle in enumerate((0.0, float(rng.uniform(0.4, 2.7)))):
        along, out = np.array([-np.sin(angle), np.cos(angle), 0]), np.array([np.cos(angle), np.sin(angle), 0])
        reach, heights = rng.uniform([0.5, 2, 0.5], [1.5, 3, 1.5]), [0.0, float(rng.uniform(0.3, 1)), 1.6]
        names = ["ground", f"lower{k}", f"upper{k}", "platform"]
        for i, letter in enumerate("ABC"):
            place = reach[i] * out + np.array([0, 0, heights[i]])
            joints.append(mo.joint(f"{letter}{k}", "R", names[i : i + 2], place, along))
    found = mf.mobility(mo.Linkage.of(joints, output="platform"))
    assert (found.count.mobility, found.mobility, found.instantaneous.output_rotations) == (0, 1, 0)


@pytest.mark.parametrize("seed", few(range(40), 10))
def test_compiled_ranks_are_those_of_singular_values(seed):
    rng = np.random.default_rng(seed)
    linkage = random_linkage(rng, int(rng.integers(1, 4)), int(rng.integers(3, 9)))
    found = mo.linkages.close_loops_near(linkage, rng.normal(size=(6, linkage.coordinates)) * 0.3)
    theta = np.concatenate([np.zeros((1, linkage.coordinates)), found.theta[found.closed]])
    expected = [mo.instantaneous_mobility(linkage, row).mobility for row in theta]
    assert mo.batch_mobility(linkage, theta).tolist() == expected
    assert int(mo.batch_mobility(linkage, theta[0])) == expected[0]
    assert mo.batch_mobility(linkage, theta[:0]).shape == (0,)
