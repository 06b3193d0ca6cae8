"""The tree of a robot's joints: links that nothing connects, that two joints carry, or that form a loop have none."""

from __future__ import annotations

from collections.abc import Iterable, Sequence

from mafsil.errors import ModelError
from mafsil.model.joint import Joint

MOST_NAMES = 8
"""Links that a sentence lists."""


def sorted_tree(robot: str, links: Sequence[str], joints: Sequence[Joint]) -> tuple[str, tuple[Joint, ...]]:
    """The base link, and the joints depth first, siblings in order of declaration.

    Connection is asked first: of parts that hang on nothing the other faults are no cause.

    Args:
        robot: its name.
        links: names.
        joints: between these links.

    Raises:
        ModelError: no links; links not connected to the others; a link that two joints carry; a loop.
    """
    if not links:
        raise ModelError("model.no_links", robot=robot)
    most, *others = connected_groups(links, joints)
    if others:
        apart = [name for group in others for name in group]
        more = f", +{len(apart) - MOST_NAMES}" if len(apart) > MOST_NAMES else ""
        raise ModelError("model.unconnected", link=most[0], links=", ".join(apart[:MOST_NAMES]) + more)
    carriers: dict[str, Joint] = {}
    for joint in joints:
        first = carriers.setdefault(joint.child, joint)
        if first is not joint:
            raise ModelError("model.two_parents", link=joint.child, first=first.name, second=joint.name)
    if loop := joint_of_loop(joints):
        raise ModelError("model.cycle", joint=loop.name)
    base = next(name for name in links if name not in carriers)
    outgoing: dict[str, list[Joint]] = {}
    for joint in joints:
        outgoing.setdefault(joint.parent, []).append(joint)
    ordered: list[Joint] = []
    waiting = outgoing.get(base, [])[::-1]
    while waiting:
        joint = waiting.pop()
        ordered.append(joint)
        waiting.extend(reversed(outgoing.get(joint.child, [])))
    return base, tuple(ordered)


def connected_groups(links: Iterable[str], joints: Iterable[Joint]) -> list[list[str]]:
    """Links that joints connect, in either direction; the largest group first, equal ones in order of declaration."""
    neighbours: dict[str, list[str]] = {name: [] for name in links}
    for joint in joints:
        neighbours[joint.parent].append(joint.child)
        neighbours[joint.child].append(joint.parent)
    group_of: dict[str, int] = {}
    groups: list[list[str]] = []
    for first in neighbours:
        if first not in group_of:
            groups.append([])
            waiting = [first]
            while waiting:
                name = waiting.pop()
                if name not in group_of:
                    group_of[name] = len(groups) - 1
                    waiting.extend(neighbours[name])
    for name in neighbours:
        groups[group_of[name]].append(name)
    return sorted(groups, key=len, reverse=True)


def joint_of_loop(joints: Iterable[Joint]) -> Joint | None:
    """A joint whose parent hangs on its own child, or None; of links that two joints carry, the last joint counts."""
    carriers = {joint.child: joint for joint in joints}
    walks: dict[str, str] = {}
    for start in carriers:
        name = start
        while name in carriers and name not in walks:
            walks[name] = start
            name = carriers[name].parent
        if walks.get(name) == start:
            return carriers[name]
    return None
