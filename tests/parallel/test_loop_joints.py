"""Loops closed by joints of several freedoms: what they forbid, and the same mechanisms as linkages."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import mafsil as mf
from mafsil import mobility, parallel
from mafsil.errors import ModelError
from mafsil.geometry import pose
from mafsil.mechanics.loop_constraints import forbidden
from mafsil.mobility import linkage_of
from mafsil.model import Joint, JointKind, Limits, Link, Mechanism
from tests.parallel.closed_chains import allowed_motion, four_bar, random_axis, random_chain
from tests.sizes import size

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
    found = chain.close_loops(q + rng.uniform(-0.1, 0.1, (20, chain.n)))
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
@pytest.mark.parametrize("seed", range(size(1, 3)))
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


@pytest.mark.parametrize("kind", [*SEVERAL, JointKind.REVOLUTE, JointKind.PRISMATIC, JointKind.HELICAL])
def test_a_mechanism_as_a_linkage_moves_as_it_did(kind):
    """Bodies of the linkage at small coordinates stand where the mechanism's links go; its loops let pass the same."""
    mechanism, q = random_chain(np.random.default_rng(3), kind)
    linkage, chain = linkage_of(mechanism, q), parallel.ClosedChain(mechanism)
    robot = mf.Robot(mechanism.without_loops())
    tree = [linkage.columns_of([name])[0] for name in mechanism.joint_names]
    step = 0.2 * np.random.default_rng(4).normal(size=mechanism.n)
    theta = np.zeros(linkage.coordinates)
    theta[tree] = step
    # Bodies of joints that close loops are reached through them: only links on the tree of both are compared.
    moved = mobility.linkages.body_poses(linkage, theta)
    compared = 0
    for k, body in enumerate(linkage.bodies):
        on_path = {linkage.joints[j].name for j in np.flatnonzero(linkage.paths[k])}
        if on_path <= set(mechanism.joint_names):
            T = [robot.forward_kinematics(x, frame=body) for x in (q, q + step)]
            np.testing.assert_allclose(moved[k], T[1] @ pose.inverse(T[0]), atol=1e-12)
            compared += 1
    assert compared > 5
    for each in linkage.joints:
        if each.name != "loop":
            np.testing.assert_allclose(each.point, robot.forward_kinematics(q, frame=each.child)[:3, 3], atol=1e-12)
    rates = (
        mobility.instantaneous_mobility(linkage).rates[tree] * mobility.linkages.loop_closure.units(linkage)[tree, None]
    )
    J = chain.terms(q, np.zeros(mechanism.n)).J
    assert np.abs(J @ rates).max() < 1e-9
    assert np.linalg.matrix_rank(rates) == mechanism.n - np.linalg.matrix_rank(J)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("kind", SEVERAL)
def test_a_loop_that_gapes_is_closed_with_the_joint_it_has(kind, seed):
    """Where joints stand on their bodies is the same before and after: angles and distances between axes of a body."""
    mechanism, q = random_chain(np.random.default_rng(20 + seed), kind)
    linkage = linkage_of(mechanism, q + 0.05 * np.random.default_rng(seed).normal(size=mechanism.n))
    (loop,) = mechanism.loops
    assert mobility.linkages.loop_closure.largest_gap(linkage) < 1e-9
    drawn = {each.name: each for each in linkage.joints}
    carries = {each.child: each for each in mechanism.joints}
    on_parent, on_child = carries[loop.parent], carries[loop.child]
    closing = drawn["loop"]
    axes = [drawn[each.name].axis for each in (on_parent, on_child)]
    R = loop.T_pj[:3, :3]
    if kind is not JointKind.SPHERICAL:
        wanted = on_parent.axis @ R @ loop.axis
        assert closing.axis @ axes[0] == pytest.approx(wanted, abs=1e-9)
    if kind is JointKind.UNIVERSAL:
        assert closing.second @ axes[1] == pytest.approx(on_child.axis @ loop.second, abs=1e-9)
        assert closing.second @ closing.axis == pytest.approx(0.0, abs=1e-9)
    if kind in (JointKind.SPHERICAL, JointKind.UNIVERSAL):
        for each, axis, x in ((on_parent, axes[0], loop.T_pj[:3, 3]), (on_child, axes[1], np.zeros(3))):
            if each.kind is JointKind.REVOLUTE:
                arm = closing.point - drawn[each.name].point
                assert axis @ arm == pytest.approx(each.axis @ x, abs=1e-9)
                across = np.linalg.norm(np.cross(axis, arm))
                assert across == pytest.approx(np.linalg.norm(np.cross(each.axis, x)), abs=1e-9)


@pytest.mark.parametrize("angle", [0.0, np.pi])
def test_a_mechanism_is_judged_where_it_is_whatever_the_angle_of_the_joint_that_closes_it(angle):
    """A parallelogram that lies flat on either side is at a branch point: its closing hinge stands at 0 or pi."""
    found = mobility.mobility(four_bar(1.0, 0.5, 1.0, 0.5), [angle, -angle, angle])
    assert (found.instantaneous.mobility, found.finite.mobility) == (2, 1)


def test_limits_of_a_joint_that_closes_a_loop_count_from_where_it_stands():
    bars = four_bar()
    q = parallel.ClosedChain(bars).close_loops([0.5, 0.5, 1.5], hold=["A"]).q
    limited = replace(bars, loops=(replace(bars.loops[0], limits=Limits(-3.0, 3.0)),))
    (pin,) = (each for each in linkage_of(limited, q).joints if each.name == "C")
    at = q[2] - q[0] - q[1]  # angle of the rocker against the coupler
    np.testing.assert_allclose([pin.lower, pin.upper], [-3.0 - at, 3.0 - at], atol=1e-12)


def test_a_linkage_drawn_elsewhere_moves_on_from_there():
    """Coordinates of joints that add up: those beyond the place where it is drawn anew lead to the same bodies."""
    rng = np.random.default_rng(8)
    letters = ("U", "R", "P", "H", "C", "RP", "U", "R")
    joints = []
    for k, kind in enumerate(letters):
        axis = random_axis(rng)
        second = np.cross(axis, random_axis(rng))
        joints.append(
            mobility.joint(
                f"J{k}", kind, [f"b{k - 1}" if k else "ground", f"b{k}"], rng.normal(size=3), axis, second=second,
                pitch=0.3, limits=(-2.0, 1.5) if kind in "RPH" else (-np.inf, np.inf),
            )
        )  # fmt: skip
    linkage = mobility.Linkage.of(joints)
    theta, step = rng.uniform(-1, 1, (2, linkage.coordinates))
    there = mobility.linkages.draw_at(linkage, theta)
    before, after = mobility.linkages.body_poses(linkage, np.stack([theta, theta + step]))
    np.testing.assert_allclose(mobility.linkages.body_poses(there, step), after @ pose.inverse(before), atol=1e-12)
    for old, new in zip(linkage.joints, there.joints, strict=True):
        shift = theta[linkage.columns_of([old.name])[0]] if old.freedoms == 1 else 0.0
        assert (new.lower, new.upper) == (old.lower - shift, old.upper - shift)


def test_a_planar_four_bar_with_a_ball_asks_the_same_once():
    bars = four_bar()
    ball = replace(bars, loops=(replace(bars.loops[0], kind=JointKind.SPHERICAL),))
    hinge, free = parallel.ClosedChain(bars), parallel.ClosedChain(ball)
    q = hinge.close_loops([0.5, 0.5, 1.5], hold=["A"]).q
    first, second = (chain.forward_dynamics(q, np.zeros(3), [1.0]) for chain in (hinge, free))
    assert (second.rank, second.redundant) == (2, 1)
    np.testing.assert_allclose(first.qdd, second.qdd, rtol=1e-12)
    run = parallel.simulate_closed(free, q, duration=2.0, step=2e-3)
    same = parallel.simulate_closed(hinge, q, duration=2.0, step=2e-3)
    np.testing.assert_allclose(run.q, same.q, atol=1e-9)


def test_a_loop_joins_two_links():
    bars = four_bar()
    own = replace(bars.loops[0], child=bars.loops[0].parent)
    with pytest.raises(ModelError, match="loop 'C' joins link 'coupler' to itself"):
        Mechanism.assemble("bars", bars.links, bars.joints, loops=[own], tip="coupler")


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
