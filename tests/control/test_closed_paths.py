"""Paths of the tip of mechanisms with loops: deltas, platforms; where they end, and why."""

from __future__ import annotations

import numpy as np
import pytest

import mafsil as mf
from mafsil.control.laws import follow_with_loops
from mafsil.geometry import pose
from mafsil.parallel import ClosedChain
from mafsil.trajectory.motion import PlanStatus
from mafsil.trajectory.paths import arc_path, joined_path
from mafsil.trajectory.paths.cartesian_path import CartesianPath


def chain_of(name):
    chain = ClosedChain(mf.mobility.mechanism_of(getattr(mf.mobility.library, name)()))
    q = chain.close_loops(np.zeros(chain.n)).q
    return chain, q, np.asarray(chain.robot.forward_kinematics(q))


def shifted(T, *xyz, turn=(0.0, 0.0, 0.0)):
    return T @ pose.exp(np.array([*turn, 0.0, 0.0, 0.0])) + np.pad(np.array([xyz]).T, ((0, 1), (3, 0)))


def off(chain, path, joints, task="pose"):
    """Largest deviation of the whole pose or the place, between the knots too."""
    s = np.linspace(0.0, 1.0, 300)
    closed = chain.close_loops(joints.at(s).u, hold=chain.actuated, tries=1)
    assert closed
    T, wanted = np.asarray(chain.robot.forward_kinematics(closed.q)), path.poses(s)
    error = np.abs(T - wanted)
    return float((error if task == "pose" else error[:, :3, 3]).max())


def test_a_platform_on_six_legs_goes_straight_turns_and_rounds_a_corner():
    chain, q, T = chain_of("stewart_gough")
    first = CartesianPath(T, shifted(T, 0.05, 0.02, 0.1, turn=(0.1, 0.0, 0.2)), "straight")
    followed = follow_with_loops(chain, first, q)
    assert followed.status is PlanStatus.FOLLOWED
    assert followed.value is not None
    assert off(chain, first, followed.value) < 1e-6
    np.testing.assert_array_equal(followed.value.at(0.0).u, q)
    corner = first.poses(1.0)
    both = joined_path([first, CartesianPath(corner, shifted(corner, -0.1, 0.0, 0.0), "straight")], blend=[0.02])
    assert off(chain, both, follow_with_loops(chain, both, q).value) < 2e-6
    middle = shifted(T, 0.05, 0.05, 0.0)[:3, 3]
    arc = arc_path(T, middle, shifted(T, 0.1, 0.0, 0.0))
    assert off(chain, arc, follow_with_loops(chain, arc, q).value) < 1e-6


def test_a_delta_keeps_its_orientation():
    chain, q, T = chain_of("delta")
    line = CartesianPath(T, shifted(T, 0.05, 0.02, 0.03), "straight")
    followed = follow_with_loops(chain, line, q)
    assert followed
    assert off(chain, line, followed.value) < 1e-6
    turned = follow_with_loops(chain, CartesianPath(T, shifted(T, 0.0, 0.0, 0.0, turn=(0.0, 0.0, 0.3)), "straight"), q)
    assert turned.status is PlanStatus.NOT_FOUND
    place = follow_with_loops(chain, line, q, task="position")
    assert off(chain, line, place.value, "position") < 1e-6


def test_where_a_path_ends_is_said():
    chain, q, T = chain_of("delta")
    far = follow_with_loops(chain, CartesianPath(T, shifted(T, 5.0, 0.0, 0.0), "straight"), q)
    assert far.status is PlanStatus.NOT_FOUND
    assert far.value is None
    assert 0.0 < far.details["place"] < 0.9
    assert "was found" in far.explain(language="en")


def test_a_joint_at_its_limit_ends_a_path():
    chain, q, T = chain_of("stewart_gough")
    line = CartesianPath(T, shifted(T, 0.0, 0.0, 0.3), "straight")
    free = follow_with_loops(chain, line, q)
    assert free.value is not None
    k = int(chain.actuated[0])
    name, end = chain.robot.joint_names[k], float(free.value.at(1.0).u[k])
    half = (q[k] + end) / 2
    limits = {"lower": {name: min(q[k], half) - 1e-3}, "upper": {name: max(q[k], half)}}
    short = ClosedChain(limited(chain.robot.mechanism, name, limits["lower"][name], limits["upper"][name]))
    stopped = follow_with_loops(short, line, q)
    assert stopped.status is PlanStatus.JOINT_LIMIT
    assert stopped.details["joint"] == name
    assert stopped.details["place"] == pytest.approx(0.5, abs=0.1)


def limited(mechanism, name, lower, upper):
    from dataclasses import replace

    joints = tuple(
        replace(joint, limits=replace(joint.limits, lower=lower, upper=upper)) if joint.name == name else joint
        for joint in mechanism.joints
    )
    return replace(mechanism, joints=joints)
