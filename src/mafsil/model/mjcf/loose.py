"""Bodies that float in the world: a robot's base is fixed where it is drawn, what hangs in its loops moves with it.

The platform of a parallel robot is mostly written so: a body with a free joint, tied to legs by `connect` or `weld`.
"""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, frozen
from mafsil.model.faults import BASE_FIXED, LOOSE_HELD, LOOSE_OBJECT
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Link
from mafsil.model.mjcf.body import WORLD, Tree
from mafsil.model.mjcf.closure import KINDS
from mafsil.model.mjcf.references import References
from mafsil.model.reading import Reading

FREE = ("x", "y", "z", "turn x", "turn y", "turn z")
"""Coordinates of a body that only loops hold: along the axes of the world, then about the body's own in turn."""


def settle(reading: Reading, tree: Tree, references: References) -> None:
    """Decide about every floating body; what is left out takes with it what was reported about it.

    A floating body is a robot if it carries a moving joint and none of the parts that are fixed in the world carries
    more of them; without any moving joint in the file everything stays. One that two constraints or more tie to moving
    parts of the robot, directly or over others, is moved by six joints in a row, which the loops hold. Others are left
    out.
    """
    if not tree.floating:
        return
    roots = _roots(tree)
    counts: dict[str, int] = {}
    for joint in tree.joints:
        root = roots[joint.child]
        counts[root] = counts.get(root, 0) + joint.moves
    most = max((count for root, count in counts.items() if root not in tree.floating), default=0)
    total = sum(counts.values())
    bases = {body for body in tree.floating if total == 0 or (counts.get(body, 0) and counts[body] >= most)}
    moving = {root for root, count in counts.items() if count and (root not in tree.floating or root in bases)}
    held = _held(_ties(references, roots), moving, set(tree.floating) - bases)
    for body, (element, remarks) in tree.floating.items():
        if body in bases:
            reading.report(BASE_FIXED, element, None, None, body=body)
        elif body in held:
            _free(tree, body)
            reading.report(LOOSE_HELD, element, None, None, body=body)
        else:
            reading.withdraw(remarks)
            _leave_out(tree, {link for link, root in roots.items() if root == body})
            reading.report(LOOSE_OBJECT, element, None, None, body=body)


def _ties(references: References, roots: dict[str, str]) -> list[tuple[str, str]]:
    """The parts of the world that active constraints tie to each other, without bodies that are moved by hand."""
    found: list[tuple[str, str]] = []
    for child, scope in references.sections("equality"):
        settings = scope.library.settings
        element = settings.apply_defaults(references.reading, child, "", "equality")
        if element.tag not in KINDS or element.get("active", "true") == "false" or "equality" in settings.off:
            continue
        for first, second in references.tied_pairs(element, scope):
            if not {first, second} & references.tree.guided:
                found.append((roots.get(first, first), roots.get(second, second)))
    return found


def _held(ties: list[tuple[str, str]], moving: set[str], floating: set[str]) -> set[str]:
    """The floating parts that loops hold: tied twice or more, and to a moving part, directly or over others of them.

    What is tied once only hangs on the robot.
    """
    held = set(floating)
    while loose := {one for one in held if sum(_other(one, tie) in moving | held | {WORLD} for tie in ties) < 2}:
        held -= loose
    reached = set(moving)
    while more := {one for one in held - reached if any(_other(one, tie) in reached for tie in ties)}:
        reached |= more
    return held & reached


def _other(one: str, tie: tuple[str, str]) -> str:
    """The other end of a tie; empty where it does not tie this part to another one."""
    first, second = tie
    return "" if first == second else second if first == one else first if second == one else ""


def _free(tree: Tree, body: str) -> None:
    """The body's place in the world becomes three slides and three hinges, which nothing drives."""
    k = next(k for k, joint in enumerate(tree.joints) if joint.child == body)
    parent, T = tree.joints[k].parent, tree.joints[k].T_pj
    row: list[Joint] = []
    for i, way in enumerate(FREE):
        name, last = tree.free(f"{body}/{way}", {*tree.elements, *tree.closing}), i == len(FREE) - 1
        child = body if last else tree.free(f"{body}/{way}", tree.poses)
        if not last:
            tree.links.append(Link(child))
            tree.poses[child] = frozen(np.eye(4))
        kind = JointKind.PRISMATIC if i < 3 else JointKind.REVOLUTE
        # The slides go along the world; the last of them is followed by the body's own axes.
        start = _shift(T) if i == 0 else _turn(T) if i == 3 else np.eye(4)
        tree.closing.add(name)
        row.append(
            Joint(name, kind, parent, child, frozen(start), frozen(np.eye(3)[i % 3]), wraps=i >= 3, actuated=False)
        )
        parent = child
    tree.joints[k : k + 1] = row


def _shift(T: PoseMatrix) -> Floats:
    only = np.eye(4)
    only[:3, 3] = T[:3, 3]
    return only


def _turn(T: PoseMatrix) -> Floats:
    only = np.eye(4)
    only[:3, :3] = T[:3, :3]
    return only


def _roots(tree: Tree) -> dict[str, str]:
    """For each link the body in the world that it belongs to."""
    parents = {joint.child: joint.parent for joint in tree.joints}
    roots: dict[str, str] = {}
    for link in parents:
        way = [link]
        while way[-1] not in roots and parents.get(way[-1], WORLD) != WORLD:
            way.append(parents[way[-1]])
        root = roots.get(way[-1], way[-1])
        roots.update(dict.fromkeys(way, root))
    return roots


def _leave_out(tree: Tree, links: set[str]) -> None:
    tree.left_out |= links
    tree.absent_joints |= {joint.name for joint in tree.joints if joint.child in links}
    tree.links = [link for link in tree.links if link.name not in links]
    tree.joints = [joint for joint in tree.joints if joint.child not in links]
