"""Loops closed by joints of several freedoms: what they forbid, and the same mechanisms as linkages."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from mafsil import mobility, parallel
from mafsil.errors import ModelError
from mafsil.geometry import pose
from mafsil.mechanics.loop_constraints import forbidden
from mafsil.mobility import linkage_of
from mafsil.model import Joint, JointKind, Link, Mechanism
from tests.parallel.closed_chains import allowed_motion, four_bar, random_axis, random_chain

SEVERAL = [JointKind.CYLINDRICAL, JointKind.UNIVERSAL, JointKind.SPHERICAL, JointKind.PLANAR]


@pytest.mark.parametrize("kind", SEVERAL)
@given(st.integers(0, 2**32 - 1))
def test_forbidden_directions_are_those_across_the_allowed_ones(kind, seed):
    rng = np.random.default_rng(seed)
    axis = random_axis(rng)
    second = np.linalg.qr(np.column_stack([axis, random_axis(rng)]))[0][:, 1]
    joint = Joint("loop", kind, "a", "b", axis=axis, second=second)
    B = forbidden(joint)
    assert len(B) == 6 - kind.freedoms
    assert np.linalg.matrix_rank(B) == len(B)
    for _ in range(kind.freedoms + 1):
        # Small motions, which the frame of the child sees as its twist.
        h = 1e-6
        T = pose.inverse(motion_of_size(rng, joint, h)) @ motion_of_size(rng, joint, h)
        assert np.abs(B @ pose.log(T)).max() < 10 * h * h


def motion_of_size(rng, joint, h):
    twist = h * pose.log(allowed_motion(rng, joint))
    return pose.exp(twist) if joint.kind is not JointKind.UNIVERSAL else cross_motion(joint, *h * rng.normal(size=2))


def cross_motion(joint, first, second):
    return pose.exp(np.append(first * joint.axis, np.zeros(3))) @ pose.exp(
        np.append(second * joint.second, np.zeros(3))
    )


@pytest.mark.parametrize("kind", SEVERAL)
@pytest.mark.parametrize("seed", range(3))
def test_found_configurations_close_the_joint_and_nothing_else(kind, seed):
    rng = np.random.default_rng(seed)
    mechanism, q = random_chain(rng, kind)
    chain, (loop,) = parallel.ClosedChain(mechanism), mechanism.loops
    found = chain.closed(q + rng.uniform(-0.1, 0.1, (20, chain.n)))
    assert found
    frames = [chain.robot.forward_kinematics(found.q, frame=name) for name in (loop.parent, loop.child)]
    T_pc = pose.inverse(frames[0] @ loop.T_pj) @ frames[1]
    p, R = T_pc[:, :3, 3], T_pc[:, :3, :3]
    along = p @ loop.axis
    parallel_axes = np.abs(R @ loop.axis - loop.axis).max()
    match kind:
        case JointKind.SPHERICAL:
            gap = np.abs(p).max()
        case JointKind.UNIVERSAL:
            gap = max(np.abs(p).max(), np.abs(R @ loop.second @ loop.axis).max())
        case JointKind.CYLINDRICAL:
            gap = max(parallel_axes, np.abs(p - along[:, None] * loop.axis).max())
        case _:
            gap = max(parallel_axes, np.abs(along).max())
    assert gap < 1e-12
    assert np.ptp(R, axis=0).max() > 1e-3, "the joint moves"
    assert found.steps.max() <= 8, "Newton's method converges as it should"


@pytest.mark.capability("08-1", "08-29")
@pytest.mark.parametrize("kind", SEVERAL)
@pytest.mark.parametrize("seed", range(3))
def test_the_linkage_of_the_same_joints_has_the_same_mobility(kind, seed):
    mechanism, q = random_chain(np.random.default_rng(10 + seed), kind)
    answer = mobility.mobility(linkage_of(mechanism, q))
    rank = int(parallel.ClosedChain(mechanism).forward_dynamics(q, np.zeros(9), np.zeros(9)).rank)
    assert rank == 6 - kind.freedoms
    linkage = linkage_of(mechanism, q)
    assert linkage.coordinates == 9 + kind.freedoms
    assert answer.count.mobility == answer.instantaneous.mobility == 9 - rank
    near = linkage_of(mechanism, q + 0.03)
    assert near.coordinates == linkage.coordinates, "loops that gape are closed first"


def test_a_planar_four_bar_with_a_ball_asks_the_same_once():
    bars = four_bar()
    ball = replace(bars, loops=(replace(bars.loops[0], kind=JointKind.SPHERICAL),))
    hinge, free = parallel.ClosedChain(bars), parallel.ClosedChain(ball)
    q = hinge.closed([0.5, 0.5, 1.5], hold=["A"]).q
    first, second = (chain.forward_dynamics(q, np.zeros(3), [1.0]) for chain in (hinge, free))
    assert (second.rank, second.redundant) == (2, 1)
    np.testing.assert_allclose(first.qdd, second.qdd, rtol=1e-12)
    run = parallel.simulate_closed(free, q, duration=2.0, step=2e-3)
    same = parallel.simulate_closed(hinge, q, duration=2.0, step=2e-3)
    np.testing.assert_allclose(run.q, same.q, atol=1e-9)


def test_joints_of_several_freedoms_only_close_loops():
    links = [Link("base"), Link("a")]
    with pytest.raises(ModelError, match="spherical"):
        Mechanism.assemble("ball", links, [Joint("ball", JointKind.SPHERICAL, "base", "a")])
    with pytest.raises(ModelError, match="60 degrees"):
        Joint("cross", JointKind.UNIVERSAL, "base", "a", second=[np.sin(np.pi / 3), 0.0, 0.5])
    with pytest.raises(ModelError, match="length"):
        Joint("cross", JointKind.UNIVERSAL, "base", "a", second=[2.0, 0, 0])
    with pytest.raises(ModelError, match="several freedoms"):
        _ = Joint("ball", JointKind.SPHERICAL, "base", "a").screw
