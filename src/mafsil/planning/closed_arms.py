"""Planning of mechanisms with loops: what their loops ask of a path, and configurations for poses."""

from __future__ import annotations

from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from mafsil import parallel
from mafsil.arrays import Floats, JointVector, positive
from mafsil.errors import InputError
from mafsil.model import Joint, JointKind, Mechanism
from mafsil.planning.arm_limits import bounds_of
from mafsil.planning.kept_planning import Kept
from mafsil.planning.path_constraints import LoopClosed, kept_of

if TYPE_CHECKING:
    from mafsil.collision import Checker
    from mafsil.parallel import ClosedChain
    from mafsil.robot import Robot

TOLERANCE = 1e-3
"""How far the points of a loop may part between two points of a path [m]."""
AIM = 1e-7
"""Share of it to which points of a path close their loops."""
ROUNDED = 1e-6
"""How far the tip may be from a pose that is not met exactly [m, rad]: typed digits, where freedoms are few."""
KINDS = (JointKind.SPHERICAL, JointKind.REVOLUTE, JointKind.FIXED)
"""Joints that keep points of two links together, which is what a path can keep."""


def loop_constraints(mechanism: Mechanism, tolerance: float = TOLERANCE) -> tuple[LoopClosed, ...]:
    """Path constraints that keep the loops of a mechanism closed: coincident points of two links.

    A ball joint keeps one point, a hinge two on its axis, a fixed joint three. Between two configurations of a path
    they may part by the tolerance; at them they are closed to a ten-millionth of it.

    Args:
        mechanism: with loops, or without: then nothing.
        tolerance: [m].

    Raises:
        InputError: a loop is closed by another kind of joint.
    """
    tolerance = positive("tolerance", tolerance)
    lever = _lever(mechanism)
    kept: list[LoopClosed] = []
    for joint in mechanism.loops:
        if joint.kind not in KINDS:
            known = ", ".join(kind.value for kind in KINDS)
            raise InputError("planning.loop_kind", joint=joint.name, kind=joint.kind.value, known=known)
        kept += [_point(joint, lever * way, tolerance) for way in _ways(joint)]
    return tuple(kept)


def _ways(joint: Joint) -> Floats:
    """(k, 3) the joint's own place, and directions in which it keeps further points together."""
    if joint.kind is JointKind.FIXED:
        return np.eye(3) - np.eye(3)[2]
    return np.array([np.zeros(3), joint.axis])[: 1 if joint.kind is JointKind.SPHERICAL else 2]


def _point(joint: Joint, x: Floats, tolerance: float) -> LoopClosed:
    """A point given in the frame of a joint, on both of its links."""
    on_parent = joint.T_pj[:3, :3] @ x + joint.T_pj[:3, 3]
    return LoopClosed(joint.parent, joint.child, on_parent, x, tolerance, AIM)


def _lever(mechanism: Mechanism) -> float:
    """Distance of the second point of a hinge [m]: half the longest step from joint to joint."""
    lengths = [float(np.linalg.norm(joint.T_pj[:3, 3])) for joint in (*mechanism.joints, *mechanism.loops)]
    return 0.5 * max(lengths, default=0.0) or 1.0


def kept_loops_of(checker: Checker, q: JointVector) -> Kept | None:
    """What a path of an arm, or of several, keeps so that loops stay closed; None where there are none.

    Args:
        checker: the arm.
        q: (n,) a configuration of the path.
    """
    loops = loop_constraints(checker.robot.mechanism)
    return Kept(*kept_of(checker, loops, q, bounds_of(checker, q[None]))) if loops else None


def closed_near(robot: Robot, q: JointVector) -> JointVector:
    """(k, n) of configurations (m, n) those near them with closed loops and within the limits, found by a search."""
    if not robot.mechanism.loops:
        return q
    found = _chain_of(robot).close_loops(q)
    limits = robot.limits
    within = limits.within(found.q).all(axis=1)
    return np.asarray(found.q[found.found & within])


def require_tree(robot: Robot) -> None:
    """Refuse a robot with loops where straight motions would leave them open.

    Raises:
        InputError: it has loops.
    """
    if robot.mechanism.loops:
        raise InputError("planning.loops_left_open", robot=robot.name)


def closed_configurations(robot: Robot, poses: Floats, start: JointVector) -> JointVector:
    """(k, n) configurations with closed loops and the tip at one of some poses (m, 4, 4), within the limits.

    Args:
        robot: with loops.
        poses: of the tip in {s}.
        start: (n,) near which they should be.
    """
    chain = _chain_of(robot)
    rows = [np.zeros((0, chain.n))]
    for T in poses:
        found = parallel.closed_inverse_kinematics(chain, T, start)
        if not len(found):
            found = parallel.closed_inverse_kinematics(chain, T, start, tolerance=ROUNDED, rotation_tolerance=ROUNDED)
        rows.append(found.q[found.within])
    return np.concatenate(rows)


@lru_cache(maxsize=16)
def _chain_of(robot: Robot) -> ClosedChain:
    return parallel.ClosedChain(robot)
