"""A linkage in blocks: loops that share no joint and no coupling do not know of each other, so each is judged alone."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mafsil.mobility.linkages.linkage import Linkage


@dataclass(frozen=True, eq=False)
class Block:
    """Joints whose loops hang together.

    Attributes:
        linkage: of these joints alone.
        columns: (f,) of the whole linkage's coordinates, in the order of those of the block.
    """

    linkage: Linkage
    columns: NDArray[np.intp]


def blocks(linkage: Linkage) -> tuple[tuple[Block, ...], NDArray[np.intp]]:
    """The blocks, and the coordinates that are in none: those of joints in no loop and no coupling."""
    sets: list[set[int]] = [{int(k) for k in np.flatnonzero(row)} for row in linkage.cycles]
    sets += [set(linkage.index_of([each.follower, each.leader])) for each in linkage.couplings]
    merged: list[set[int]] = []
    for one in sets:
        apart = [other for other in merged if not other & one]
        merged = [*apart, one.union(*(other for other in merged if other & one))]
    inside = np.isin(linkage.joint_of, sorted(k for one in merged for k in one))
    if len(merged) == 1 and inside.all():
        return (Block(linkage, np.arange(linkage.coordinates)),), np.flatnonzero(~inside)
    found = tuple(Block(_alone(linkage, one), np.flatnonzero(np.isin(linkage.joint_of, sorted(one)))) for one in merged)
    return found, np.flatnonzero(~inside)


def _alone(linkage: Linkage, kept: set[int]) -> Linkage:
    """The linkage of some of its joints, on the first of their bodies."""
    joints = tuple(linkage.joints[k] for k in sorted(kept))
    names = {each.name for each in joints}
    bodies = tuple(b for b in linkage.bodies if any(b in (each.parent, each.child) for each in joints))
    return replace(
        linkage, bodies=bodies, joints=joints, output=bodies[-1],
        apart={name: X for name, X in linkage.apart.items() if name in names},
        couplings=tuple(each for each in linkage.couplings if {each.follower, each.leader} <= names),
    )  # fmt: skip
