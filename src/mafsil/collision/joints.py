"""The joints of an arm as arrays, and what checks ask of a configuration, compiled for eight configurations at once.

Of `link_poses` the rows that change, for the links that carry a body; with them the centres of the balls around the
bodies, and for motions the twists of the links that joints carry.
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

import mafsil.expression as ex
from mafsil.arrays import Floats, Truth
from mafsil.expression import Expression, Function
from mafsil.kernels import Kernel, Port, Signature, compile
from mafsil.kernels.identity import meaning
from mafsil.mechanics.catalogue import quantity
from mafsil.model import Mechanism
from mafsil.model.fingerprint import fingerprint
from mafsil.model.joint import require_lines
from mafsil.robot.trace import trace


@dataclass(frozen=True, eq=False, slots=True)
class Joints:
    """The moving joints of the tree, mimics among them.

    Attributes:
        link: (j,) index of the link that each carries: the axis goes through that link's origin.
        column: (j,) coordinate that drives it.
        factor: (j,) its motion per unit of that coordinate.
        screw: (j, 6) (omega, v) in the frame of its link.
        moves: (j, L) whether it moves a link.
        before: (j,) the joint that carries each; -1 for none.
    """

    link: NDArray[np.int64]
    column: NDArray[np.int64]
    factor: Floats
    screw: Floats
    moves: NDArray[np.bool_]
    before: NDArray[np.int64]


class Kinship(NamedTuple):
    """Which coordinates belong to a motion in which others change.

    Attributes:
        limb: (n, n) whether two are of one limb: a run of joints from one to the next, until something branches off. So
            do a head and the arms from a torso, fingers from a hand. What comes behind the tip is a limb of its own.
        carries: (n, n) whether coordinate i moves the joint of coordinate j.
    """

    limb: Truth
    carries: Truth


def kinship_of(joints: Joints, n: int, moves_tip: Truth) -> Kinship:
    """Which coordinates belong together.

    Args:
        joints: of a mechanism.
        n: how many coordinates it has.
        moves_tip: (n,) whether a coordinate moves the tip.
    """
    first = _limbs(joints, moves_tip)
    limb, carries = np.eye(n, dtype=np.bool_), np.zeros((n, n), np.bool_)
    for k, column in enumerate(joints.column):
        limb[column, joints.column[first == first[k]]] = True
        carries[column, joints.column[joints.moves[k, joints.link]]] = True
    return Kinship(limb, carries & ~np.eye(n, dtype=np.bool_))


def _limbs(joints: Joints, moves_tip: Truth) -> NDArray[np.int64]:
    """(j,) for each joint the first one of its limb, see `Kinship`."""
    before: list[int] = joints.before.tolist()
    limb = np.arange(len(before))
    for k, parent in enumerate(before):
        if parent >= 0 and before.count(parent) == 1:
            if moves_tip[joints.column[parent]] == moves_tip[joints.column[k]]:
                limb[k] = limb[parent]
    return limb


def joints_of(mechanism: Mechanism) -> Joints:
    """The moving joints of an arm.

    Raises:
        ModelError: one follows another along a curve.
    """
    require_lines(mechanism.joints)
    columns = {joint.name: i for i, joint in enumerate(mechanism.coordinates)}
    kept = [k for k, joint in enumerate(mechanism.joints) if joint.moves]
    above = np.zeros((len(mechanism.links), len(mechanism.joints)), bool)
    for k, parent in enumerate(mechanism.parents):
        above[k + 1] = above[parent]
        above[k + 1, k] = True
    joints = [mechanism.joints[k] for k in kept]
    moves = np.ascontiguousarray(above[:, kept].T)
    carries = moves[:, np.array(kept, np.int64) + 1] & ~np.eye(len(kept), dtype=np.bool_)
    leaders = [joint.name if joint.mimic is None else joint.mimic.leader for joint in joints]
    return Joints(
        np.array(kept, np.int64) + 1,
        np.array([columns[leader] for leader in leaders], np.int64),
        np.array([1.0 if joint.mimic is None else joint.mimic.multiplier for joint in joints]),
        np.array([joint.screw for joint in joints]).reshape(-1, 6),
        moves,
        last_of(carries),
    )


def last_of(moves: NDArray[np.bool_]) -> NDArray[np.int64]:
    """For each column the last row that is set, joints standing before those that they carry; -1 for none."""
    rows = np.arange(len(moves))[:, None]
    return np.where(moves, rows, -1).max(axis=0, initial=-1)


POSE, CENTRE, TWIST = 12, 3, 6
"""Numbers of a pose (three rows of four), of a ball's centre, and of a twist (omega, v about the origin of {s})."""
SOURCES = ("mafsil.algebra", "mafsil.mechanics", "mafsil.robot")
"""Packages whose code shapes the expressions, beside this module."""


class ArmKernels(NamedTuple):
    """The kernels of an arm.

    Attributes:
        at_rest: q (n,) -> the pose of each of `links`, then the centre of each body.
        in_motion: q (n,), rates of the joints (j,) -> the twist of each joint's link, then as `at_rest`.
        links: those that carry a body, in rising order.
    """

    at_rest: Kernel
    in_motion: Kernel
    links: NDArray[np.int64]


def arm_kernels(mechanism: Mechanism, joints: Joints, bodies: Floats) -> ArmKernels:
    """The kernels of an arm; machine code is made or loaded at their first use.

    Args:
        mechanism: of the arm.
        joints: of the mechanism.
        bodies: as in `Arm`.
    """
    links, centres = bodies[:, 0].astype(np.int64), np.ascontiguousarray(bodies[:, 4:7])
    at_rest, in_motion = (_kernel(mechanism, joints, links, centres, moving) for moving in (False, True))
    return ArmKernels(at_rest, in_motion, np.unique(links))


def _kernel(
    mechanism: Mechanism, joints: Joints, links: NDArray[np.int64], centres: Floats, moving: bool
) -> Kernel:  # fmt: skip
    rates = len(joints.link) if moving else 0
    inputs = (Port("q", (mechanism.n,)), Port("rates", (rates,)))
    size = TWIST * rates + POSE * len(np.unique(links)) + CENTRE * len(links)
    arguments = (mechanism, joints, links, centres, moving)
    content = hashlib.blake2b(digest_size=16)
    for array in (joints.link, joints.screw, joints.before, links, centres):
        content.update(array.tobytes())
    return compile(
        Signature("bodies_in_motion" if moving else "bodies_at_rest", inputs[: 1 + moving], (Port("placed", (size,)),)),
        partial(_function, *arguments),
        key=f"{fingerprint(mechanism)} {content.hexdigest()} {moving}",
        fingerprints=(meaning((__name__,), SOURCES),),
        recipe=(_kernel, arguments),
    )


def _function(
    mechanism: Mechanism, joints: Joints, links: NDArray[np.int64], centres: Floats, moving: bool
) -> Function:  # fmt: skip
    """The expression of a kernel.

    1. Poses of all links, three rows each.
    2. For motions the twists of what the joints carry.
    3. Poses of the links that carry a body, row by row; the centres of the bodies.
    """
    q, rates = ex.symbol("q", mechanism.n), ex.symbol("rates", len(joints.link))
    numbers: Expression = trace(mechanism, quantity("link_poses"), None)(q)  # 1
    poses = [ex.reshape(numbers[16 * k : 16 * k + POSE], 4, 3).T for k in range(len(mechanism.links))]
    columns = _twists(joints, poses, rates) if moving else []  # 2
    columns += [ex.vec(poses[int(k)].T) for k in np.unique(links)]  # 3
    columns += [_move(poses[int(k)], centre) for k, centre in zip(links, centres, strict=True)]
    inputs = [q, rates] if moving else [q]
    return Function("bodies", inputs, [ex.vertcat(*columns)], cse=True)


def _move(pose: Expression, point: Floats) -> Expression:
    return pose[:, :3] @ ex.Expression(point) + pose[:, 3]


def _twists(joints: Joints, poses: list[Expression], rates: Expression) -> list[Expression]:
    """Twist of the link of each joint, from those of the joints before it on."""
    twists: list[Expression] = []
    for j, screw in enumerate(joints.screw):
        pose, before = poses[int(joints.link[j])], int(joints.before[j])
        R, p = pose[:, :3], pose[:, 3]
        omega, v = R @ ex.Expression(screw[:3]) * rates[j], R @ ex.Expression(screw[3:]) * rates[j]
        own = ex.vertcat(omega, v + ex.cross(p, omega))
        twists.append(own if before < 0 else twists[before] + own)
    return twists
