"""Joints of a graph as a tree and what closes its loops: which joint carries which link, some of them turned round."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from mafsil.arrays import frozen
from mafsil.model.mimics import Declared
from mafsil.model.placement import inverse
from mafsil.model.sdf.joint import Chain


def spanning(chains: Sequence[Chain], names: Sequence[str], world: str) -> list[tuple[Chain, bool]]:
    """The joints in their order, each with whether it closes a loop; those against the tree are turned round.

    1. The first joint that leads to a link carries it. If every link hangs so on one, this is the tree.
    2. Else the tree grows from the world, or from the link that no joint leads to, or from the first link: joints
       that lead on from it first, in their order; where there are none, the first that leads to it, turned round.

    Args:
        chains: joints in the order of the file.
        names: of the links, in their order.
        world: name of the world.
    """
    # 1.
    carriers: dict[str, Chain] = {}
    for chain in chains:
        carriers.setdefault(chain.child, chain)
    roots = [name for name in (world, *names) if name not in carriers and (name in names or _touches(chains, name))]
    if len(roots) == 1 and all(_hangs(name, carriers) for name in carriers):
        return [(chain, carriers[chain.child] is not chain) for chain in chains]
    # 2.
    root = world if _touches(chains, world) else (roots or list(names))[0]
    reached, carrying = {root}, dict[int, Chain]()
    while True:
        waiting = [k for k in range(len(chains)) if k not in carrying]
        onward = [k for k in waiting if chains[k].parent in reached and chains[k].child not in reached]
        back = [k for k in waiting if chains[k].child in reached and chains[k].parent not in reached]
        if onward:
            carrying[onward[0]] = chains[onward[0]]
            reached.add(chains[onward[0]].child)
        elif back:
            carrying[back[0]] = turned_round(chains[back[0]])
            reached.add(chains[back[0]].parent)
        else:
            break
    ordered = [(carrying.get(k, chain), k not in carrying) for k, chain in enumerate(chains)]
    # What hangs on nothing that was reached stays as it is: the mechanism then names it.
    return [(chain, closes and chain.child in reached) for chain, closes in ordered]


def _touches(chains: Sequence[Chain], name: str) -> bool:
    return any(name in (chain.parent, chain.child) for chain in chains)


def _hangs(name: str, carriers: dict[str, Chain]) -> bool:
    """Whether the carriers of a link lead to one that nothing carries."""
    passed: set[str] = set()
    while name in carriers and name not in passed:
        passed.add(name)
        name = carriers[name].parent
    return name not in passed


def turned_round(chain: Chain) -> Chain:
    """The same joint seen from its child: axes against each other, coordinates, limits and names as before.

    T_pc = T_1 exp(S_1 q_1) ... T_k exp(S_k q_k) T_jc, so T_cp = T_jc^-1 exp(-S_k q_k) T_k^-1 ... exp(-S_1 q_1) T_1^-1.
    """
    joints: list[Declared] = []
    parent, T = chain.child, frozen(inverse(chain.T_jc))
    between = [each.joint.parent for each in chain.joints[1:]][::-1]
    for k, declared in enumerate(reversed(chain.joints)):
        own = declared.joint
        child = between[k] if k < len(between) else f"{chain.joints[0].joint.name}/frame"
        turned = replace(own, parent=parent, child=child, T_pj=T, axis=frozen(-own.axis))
        joints.append(Declared(turned, declared.element))
        parent, T = child, frozen(inverse(own.T_pj))
    return Chain(joints, chain.links, chain.child, chain.parent, T)
