"""Bodies that float in the world: the base of a robot is fixed where it is drawn, a loose object is left out."""

from __future__ import annotations

from mafsil.model.faults import BASE_FIXED, LOOSE_OBJECT
from mafsil.model.mjcf.body import WORLD, Tree
from mafsil.model.reading import Reading


def settle(reading: Reading, tree: Tree) -> None:
    """Decide about every floating body; what is left out takes with it what was reported about it.

    A floating body is a robot if it carries a moving joint and none of the parts that are fixed in the world carries
    more of them; without any moving joint in the file everything stays.
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
    for body, (element, remarks) in tree.floating.items():
        if total == 0 or (counts.get(body, 0) and counts[body] >= most):
            reading.report(BASE_FIXED, element, None, None, body=body)
        else:
            reading.withdraw(remarks)
            _leave_out(tree, {link for link, root in roots.items() if root == body})
            reading.report(LOOSE_OBJECT, element, None, None, body=body)


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
    tree.left_out |= links | {joint.name for joint in tree.joints if joint.child in links}
    tree.links = [link for link in tree.links if link.name not in links]
    tree.joints = [joint for joint in tree.joints if joint.child not in links]
