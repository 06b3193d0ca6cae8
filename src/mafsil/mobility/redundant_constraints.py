"""Constraints that others imply: how many, where they come from, which joints are loaded against each other by them.

Independent loops that are as short as can be: what a loop asks is plainest where it passes few joints.

Reference: J. Horton, A polynomial-time algorithm to find the shortest cycle basis of a graph, SIAM J. Computing 1987.

A linkage in blocks: loops that share no joint and no coupling do not know of each other, so each is judged alone.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats
from mafsil.messages import say
from mafsil.mobility.instantaneous import null_space
from mafsil.mobility.linkages.linkage import Linkage, on_linkage
from mafsil.mobility.linkages.loop_closure import loop_state, reduced_screws
from mafsil.mobility.spaces.motion_group import MotionGroup, motion_group
from mafsil.mobility.tolerances import IN_SUPPORT

MOST_CANDIDATES = 200_000
"""Bodies times joints beyond which the loops of a breadth first walk have to do."""
Joints = frozenset[int]


class RedundancyStatus(Status):
    """Whether constraints imply others; true where they do."""

    REDUNDANT = ("mobility.redundancy_some", True)
    INDEPENDENT = ("mobility.redundancy_none", False)


@dataclass(frozen=True, eq=False)
class LoopCause:
    """What the joints of one loop say about its six conditions.

    Attributes:
        joints: names, of one independent loop.
        group: what they generate; a loop within a group of dimension m asks m conditions, 6 - m hold by themselves.
    """

    joints: tuple[str, ...]
    group: MotionGroup

    @property
    def implied(self) -> int:
        """6 - m."""
        return 6 - self.group.dimension

    def explain(self, language: str | None = None) -> str:
        """The cause in one sentence."""
        return say(
            "mobility.cause_group", language=language, joints=", ".join(self.joints), group=self.group,
            count=self.implied, m=self.group.dimension,
        )  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class RedundantConstraints(Answer, data="count special loaded stresses", entries="causes"):
    """Redundant constraints at a configuration; true if there are some, iterable over the loops that cause them.

    Attributes:
        count: 6 L - rank.
        causes: loops whose joints generate less than all motions.
        special: how many constraints are implied beyond that: by lengths and angles of this very linkage or
            configuration.
        stresses: (6 L + K, count) orthonormal wrenches (moment, force) through the joints that close the loops,
            which balance without any load: what imprecise parts are clamped by.
        loaded: names of the joints that these wrenches go through.
    """

    count: int
    causes: tuple[LoopCause, ...]
    special: int
    stresses: Floats
    loaded: tuple[str, ...]

    @property
    def status(self) -> RedundancyStatus:
        """By their number."""
        return RedundancyStatus.REDUNDANT if self.count else RedundancyStatus.INDEPENDENT

    def __bool__(self) -> bool:
        return self.count > 0

    def explain(self, language: str | None = None) -> str:
        """Number, causes, and which joints may be clamped."""
        lines = [self.status.sentence(language, count=self.count)]
        lines += [cause.explain(language) for cause in self.causes]
        if self.special > 0:
            lines.append(say("mobility.cause_special", language=language, count=self.special))
        if self.count:
            lines.append(say("mobility.stressed", language=language, joints=", ".join(self.loaded)))
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return Answer.to_dict(self) | {
            "causes": [
                {"joints": list(c.joints), "group": c.group.kind.name.lower(), "dimension": c.group.dimension}
                for c in self.causes
            ]
        }


def loop_groups(linkage: Linkage, screws: Floats) -> tuple[tuple[tuple[str, ...], MotionGroup], ...]:
    """Joints of each independent loop, and what they generate; screws (6, F) free of units."""
    found: list[tuple[tuple[str, ...], MotionGroup]] = []
    for inside in shortest_loops(linkage):
        columns = np.isin(linkage.joint_of, inside)
        found.append((tuple(linkage.joints[int(k)].name for k in inside), motion_group(screws[:, columns])))
    return tuple(found)


@on_linkage
def redundant_constraints(linkage: Linkage, theta: ArrayLike | None = None) -> RedundantConstraints:
    """Redundant constraints at a configuration, and why they are.

    Left null vectors of the loop matrix are states of stress without load. Each loop whose joints generate a group of
    dimension m < 6 has 6 - m of them always; the rest comes from special lengths, angles or places.

    Args:
        linkage: as drawn.
        theta: (F,) [rad | m].
    """
    linkage.require_all_joints()
    state = loop_state(linkage, theta)
    screws = reduced_screws(linkage, state.screws)
    causes = tuple(LoopCause(joints, g) for joints, g in loop_groups(linkage, screws) if g.dimension < 6)
    A = state.matrix
    stresses = left_null_space(A)
    always = sum(cause.implied for cause in causes)
    carried = _wrenches_through(linkage, stresses)
    loaded = tuple(each.name for each, on in zip(linkage.joints, carried, strict=True) if on > IN_SUPPORT)
    return RedundantConstraints(stresses.shape[1], causes, stresses.shape[1] - always, stresses, loaded)


def left_null_space(A: Floats) -> Floats:
    """(m, m - rank) orthonormal y with y A = 0."""
    if not A.shape[1]:
        return np.eye(len(A))
    if not len(A):
        return np.zeros((0, 0))
    return null_space(A.T)[1]


def _wrenches_through(linkage: Linkage, stresses: Floats) -> Floats:
    """(J,) largest wrench through each joint: of the loops that pass it, with their senses."""
    if not stresses.shape[1]:
        return np.zeros(len(linkage.joints))
    by_loop = stresses[: 6 * linkage.loops].reshape(linkage.loops, 6, -1)
    through = np.einsum("lj,lik->jik", linkage.cycles, by_loop)
    return np.abs(through).max(axis=(1, 2))


def shortest_loops(linkage: Linkage) -> list[NDArray[np.intp]]:
    """Indices of the joints of each independent loop, the shortest loops that are independent.

    1. Candidates: for each body and each joint the ways of a breadth first walk from the body to both ends of it.
    2. The shortest first, each is kept that is no sum modulo 2 of those before, until there are enough.

    Args:
        linkage: any.
    """
    walked = [np.flatnonzero(row) for row in linkage.cycles]
    if linkage.loops < 2 or len(linkage.bodies) * len(linkage.joints) > MOST_CANDIDATES:
        return walked
    kept, reduced = list[Joints](), dict[int, Joints]()
    for loop in sorted(_candidates(linkage), key=lambda one: (len(one), sorted(one))):
        rest = loop
        while rest and (first := min(rest)) in reduced:
            rest = rest ^ reduced[first]
        if rest:
            reduced[min(rest)] = rest
            kept.append(loop)
        if len(kept) == linkage.loops:
            break
    return [np.array(sorted(loop), dtype=np.intp) for loop in kept]


def _candidates(linkage: Linkage) -> set[Joints]:
    """Step 1."""
    ends: list[tuple[int, int]] = [(int(a), int(b)) for a, b in linkage.ends]
    beside: list[list[tuple[int, int]]] = [[] for _ in linkage.bodies]
    for k, (a, b) in enumerate(ends):
        beside[a].append((k, b))
        beside[b].append((k, a))
    found = set[Joints]()
    for body in range(len(linkage.bodies)):
        ways = _ways(beside, body)
        for k, (a, b) in enumerate(ends):
            if a in ways and b in ways and not ways[a] & ways[b] and k not in ways[a] | ways[b]:
                found.add(ways[a] | ways[b] | {k})
    return found


def _ways(beside: list[list[tuple[int, int]]], start: int) -> dict[int, Joints]:
    """Joints on the way from one body to each that it reaches."""
    ways, waiting = {start: frozenset[int]()}, [start]
    for body in waiting:
        for k, other in beside[body]:
            if other not in ways:
                ways[other] = ways[body] | {k}
                waiting.append(other)
    return ways


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
