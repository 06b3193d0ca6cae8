"""The joints of an arm as arrays: which links each moves, about what, by which coordinate."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, Truth
from mafsil.model import Mechanism
from mafsil.model.joint import require_lines


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
