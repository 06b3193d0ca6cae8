"""What kind of chain a linkage is: serial, tree, one loop, several loops, with branches."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.on_linkage import on_linkage


class StructureStatus(Status):
    """Kinds of chains; true for all of them."""

    SERIAL = ("mobility.serial", True)
    TREE = ("mobility.tree", True)
    SINGLE_LOOP = ("mobility.single_loop", True)
    MANY_LOOPS = ("mobility.many_loops", True)
    HYBRID = ("mobility.hybrid", True)


@dataclass(frozen=True, eq=False, repr=False)
class Structure(Answer, data="links joints loops degrees"):
    """Links, joints and loops of a linkage.

    Attributes:
        links: N, with the ground.
        joints: J.
        loops: L = J - N + 1, independent ones.
        degrees: number of joints at each body, in order.
        status: serial; tree (branched, no loop); one loop; several; loops with open branches.
    """

    links: int
    joints: int
    loops: int
    degrees: tuple[int, ...]
    status: StructureStatus


@on_linkage
def structure(linkage: Linkage) -> Structure:
    """The kind of chain: a tree has no loop, a serial chain no body with more than two joints besides."""
    linkage.require_all_joints()
    degrees = np.bincount(linkage.ends.ravel(), minlength=len(linkage.bodies))
    if not linkage.loops:
        serial = int(degrees.max()) <= 2 and degrees[0] == 1
        status = StructureStatus.SERIAL if serial else StructureStatus.TREE
    elif bool((np.abs(linkage.cycles).sum(axis=0) == 0).any()):
        status = StructureStatus.HYBRID
    else:
        status = StructureStatus.SINGLE_LOOP if linkage.loops == 1 else StructureStatus.MANY_LOOPS
    return Structure(len(linkage.bodies), len(linkage.joints), linkage.loops, tuple(int(d) for d in degrees), status)
