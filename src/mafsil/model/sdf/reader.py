"""The SDFormat reader: one model, or the one robot of a world; what it cannot keep it says.

Joints of a graph as a tree and what closes its loops: which joint carries which link, some of them turned round.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace

from mafsil.arrays import frozen
from mafsil.model.asset_path import Assets
from mafsil.model.faults import (
    DUPLICATE_JOINT,
    DUPLICATE_LINK,
    LOOSE_OBJECT,
    NO_LINKS,
    SDF_FLOATING,
    SDF_LOOSE,
    SDF_MODELS,
    SDF_NO_MODEL,
    WRONG_ROOT,
)
from mafsil.model.file_reader import Format
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Link
from mafsil.model.mechanism import STANDARD_GRAVITY, Mechanism
from mafsil.model.mimics import Declared, resolve_mimics
from mafsil.model.placement import inverse
from mafsil.model.reading import Reading
from mafsil.model.sdf.frames import OWN_NAME, WORLD, with_names
from mafsil.model.sdf.joint import (
    GEARBOX,
    IS_BASE,
    IS_TIP,
    Chain,
    couple_gearboxes,
    fixed_joint,
    invert_pose,
    is_identity,
    read_frame,
    read_joint,
    tip_frame,
)
from mafsil.model.sdf.link import read_link
from mafsil.model.sdf.scope import SDF as VOCABULARY
from mafsil.model.sdf.scope import Inclusion, Part, Parts, flag, gather_parts, numbers, version_of
from mafsil.model.tolerances import WRITTEN
from mafsil.model.vocabulary import audit
from mafsil.model.xml_tree import Element, ReadLimits

GRAVITY_OF_WORLDS = (0.0, 0.0, -9.8)
"""What a world has that gives none."""


def _build(reading: Reading, assets: Assets, _source: str, limits: ReadLimits) -> Mechanism | None:
    root = reading.document.root
    if root.tag not in ("sdf", "gazebo"):
        reading.report(WRONG_ROOT, root, found=root.tag, expected="sdf")
        return None
    reading.included.append(("", reading.document))
    for element in root.walk():
        element.file = 1
    inclusion = Inclusion(reading, assets, limits)
    audit(reading, root, VOCABULARY, version_of(root))
    model, gravity = _robot(reading, root, inclusion)
    if model is None:
        return None
    if model.file == 1:  # an included one was held against the vocabulary of its own version
        audit(reading, model, VOCABULARY, version_of(root))
    parts = gather_parts(reading, model, inclusion)
    if not parts.links:
        reading.report(NO_LINKS, model)
    _require_unique(reading, parts)
    if reading.failed:
        return None
    assembly = _assemble(reading, model, parts, assets, version_of(root))
    if reading.failed:
        return None
    joints = resolve_mimics(reading, assembly.joints)
    stands = any(part.name == assembly.base for part in parts.links)
    T_sb = parts.frames.T_ws @ parts.frames.pose(reading, assembly.base, model) if stands else None
    tip, T_lt = tip_frame(reading, parts)
    if reading.failed:
        return None
    name = model.get("name").strip() or "sdf"
    marks = {part.name for part in parts.of("frame")} & {link.name for link in assembly.links}
    mechanism = Mechanism.assemble(
        name, assembly.links, joints, loops=assembly.loops, tip=tip, T_lt=T_lt, T_sb=T_sb, gravity=gravity, marks=marks
    )
    links, own = (_own_names(found) for found in ((*parts.links, *parts.of("frame")), parts.of("joint")))
    return with_names(mechanism, model.get(OWN_NAME) or name, links, own)


def _own_names(parts: Iterable[Part]) -> dict[str, str]:
    """Names of robots of ours that SDFormat does not take, by those that are written."""
    return {part.name: part.element.get(OWN_NAME) for part in parts if part.element.get(OWN_NAME)}


def _robot(reading: Reading, root: Element, inclusion: Inclusion) -> tuple[Element | None, tuple[float, float, float]]:
    """The model to read, and gravity: the one that was asked for, the only one, the only one with joints that move."""
    world = root.first("world")
    holder = root if world is None else world
    gravity = STANDARD_GRAVITY
    if world is not None:
        x, y, z = numbers(reading, world.first("gravity"), 3, GRAVITY_OF_WORLDS)
        gravity = (x, y, z)
    included = [inclusion.model(include, must=world is None) for include in holder.all("include")]
    models = [*holder.all("model"), *(model for model in included if model is not None)]
    moving = [model for model in models if any(_moves(joint) for joint in _joints(model))]
    if reading.model is not None:
        moving = [model for model in models if model.get("name") == reading.model]
        if not moving:
            known = ", ".join(model.get("name") for model in models) or "-"
            reading.report(SDF_NO_MODEL, root, None, None, name=reading.model, names=known)
            return None, gravity
    return _the_only_one(reading, root, moving or models, models), gravity


def _the_only_one(reading: Reading, root: Element, chosen: list[Element], models: list[Element]) -> Element | None:
    """The model to read, if one is left; those that nobody asked for are reported."""
    if len(chosen) != 1:
        names = ", ".join(model.get("name") for model in chosen) or "-"
        reading.report(SDF_MODELS, root, None, None, count=len(chosen), names=names)
        return None
    for other in models:
        if other is not chosen[0] and reading.model is None:
            reading.report(SDF_LOOSE, other, None, None, name=other.get("name"))
    return chosen[0]


def _joints(model: Element) -> list[Element]:
    return [element for element in model.walk() if element.tag == "joint"]


def _moves(joint: Element) -> bool:
    return joint.get("type") not in ("", "fixed")


def _require_unique(reading: Reading, parts: Parts) -> None:
    links, joints = (*parts.links, *parts.of("frame")), parts.of("joint")
    for fault, kind, found in ((DUPLICATE_LINK, "link", links), (DUPLICATE_JOINT, "joint", joints)):
        seen: dict[str, int] = {}
        for part in found:
            if part.name in seen:
                reading.report(fault, part.element, "name", None, **{kind: part.name}, line=seen[part.name])
            seen.setdefault(part.name, part.element.line)


@dataclass(slots=True)
class _Assembly:
    """Links and joints as a mechanism takes them."""

    links: list[Link]
    joints: list[Declared] = field(default_factory=list[Declared])
    loops: list[Joint] = field(default_factory=list[Joint])
    base: str = ""


def _assemble(reading: Reading, model: Element, parts: Parts, assets: Assets, version: tuple[int, int]) -> _Assembly:
    """Joints as links of a tree, and those that close its loops."""
    result = _Assembly([read_link(reading, part, parts.frames, assets) for part in parts.links])
    static = flag(reading, model, "static", default=False)
    gearboxes = [part for part in parts.of("joint") if part.element.get("type") == GEARBOX]
    kept = [part for part in parts.connections if part not in gearboxes and not _is_said(part, static=static)]
    result.links += [Link(part.name) for part in kept if part.element.tag == "frame"]
    chains = _read_chains(reading, kept, parts, version)
    chains = chains if static else couple_gearboxes(reading, gearboxes, parts.frames, version, chains)
    carried: set[str] = set()
    for chain, closes in spanning(chains, [part.name for part in parts.links], WORLD):
        _append(result, chain, closes=closes)
        carried.add(chain.child)
    loose = [part.name for part in parts.links if part.name not in carried]
    _choose_base(reading, model, parts, result, loose, static=static)
    if not static:
        _leave_out_loose(reading, parts, result)
        if result.base in loose and not any(part.element.get(IS_BASE) for part in parts.of("joint")):
            reading.report(SDF_FLOATING, model, None, None, name=model.get("name"), link=result.base)
    return result


def _read_chains(reading: Reading, kept: list[Part], parts: Parts, version: tuple[int, int]) -> list[Chain]:
    read = [
        read_joint(reading, part, parts, version) if part.element.tag == "joint" else read_frame(reading, part, parts)
        for part in kept
    ]
    return [chain for chain in read if chain is not None]


def _choose_base(
    reading: Reading, model: Element, parts: Parts, result: _Assembly, loose: list[str], *, static: bool
) -> None:
    """The world, where the model stands still or a joint hangs on it; else the first link that no joint carries."""
    names = {part.name for part in parts.links}
    on_world = WORLD not in names and any(declared.joint.parent == WORLD for declared in result.joints)
    if static or on_world:
        result.links.insert(0, Link(WORLD if WORLD not in names else f"{WORLD}/space"))
        result.base = result.links[0].name
    if static:
        result.joints += [_on_world(parts, part, result.base, model, reading) for part in parts.links]
    elif not on_world and loose:
        result.base = loose[0]


def _robot_group(group: dict[str, str], joints: list[Joint], base: str) -> str:
    moving = Counter(group[joint.child] for joint in joints if joint.moves)
    return max(sorted(set(group.values())), key=lambda name: (moving[name], name == group.get(base)))


def _leave_out_loose(reading: Reading, parts: Parts, result: _Assembly) -> None:
    """Links that no joint connects to the robot, the part with the most moving joints, go with all they carry."""
    joints = [*(declared.joint for declared in result.joints), *result.loops]
    names = {link.name for link in result.links}
    if not {name for joint in joints for name in (joint.parent, joint.child)} <= names:
        return  # A joint on no link, which is said of the whole.
    group = _connected(names, joints)
    robot = _robot_group(group, joints, result.base)
    for part in {group[part.name]: part for part in reversed(parts.links) if group[part.name] != robot}.values():
        reading.report(LOOSE_OBJECT, part.element, None, None, body=part.name)
    result.links = [link for link in result.links if group[link.name] == robot]
    result.joints = [declared for declared in result.joints if group[declared.joint.child] == robot]
    result.loops = [loop for loop in result.loops if group[loop.child] == robot]
    children = {declared.joint.child for declared in result.joints}
    if group.get(result.base, robot) != robot:
        result.base = next(link.name for link in result.links if link.name not in children)


def _connected(links: Iterable[str], joints: Iterable[Joint]) -> dict[str, str]:
    """For each link one of those that joints connect it to, the same for all of them."""
    group = {link: link for link in links}
    for joint in joints:
        first, second = group[joint.parent], group[joint.child]
        if first != second:
            group = {link: first if one == second else one for link, one in group.items()}
    return group


def _is_said(part: Part, *, static: bool) -> bool:
    """Whether a joint or frame is none of the robot's: the base in the space, the tip; the joints of what stands."""
    is_joint = part.element.tag == "joint"
    return bool(part.element.get(IS_BASE if is_joint else IS_TIP)) or (is_joint and static)


def _on_world(parts: Parts, part: Part, space: str, model: Element, reading: Reading) -> Declared:
    """A link of a static model, fixed where it stands."""
    T = parts.frames.T_ws @ parts.frames.pose(reading, part.name, model)
    return Declared(fixed_joint(f"{space}/{part.name}", space, part.name, frozen(T)), part.element)


def _append(result: _Assembly, chain: Chain, *, closes: bool) -> None:
    """A joint in the tree, or one that closes a loop; the child's own frame hangs fixed on the joint's."""
    if closes:
        chain = _as_one(chain)
    result.links += chain.links
    *first, last = chain.joints
    direct = is_identity(chain.T_jc)
    end = chain.child if direct else last.joint.child
    last = Declared(replace(last.joint, child=end), last.element)
    if not direct:
        result.links.append(Link(end))
        parent, child, T = (chain.child, end, invert_pose(chain.T_jc)) if closes else (end, chain.child, chain.T_jc)
        result.joints.append(
            Declared(fixed_joint(f"{chain.joints[0].joint.name}/to_child", parent, child, T), last.element)
        )
    if closes:
        result.joints += first
        result.loops.append(last.joint)
    else:
        result.joints += [*first, last]


def _as_one(chain: Chain) -> Chain:
    """A ball or universal joint that closes a loop is one joint, not hinges in a row; of two, if they are square."""
    first, last = chain.joints[0], chain.joints[-1].joint
    square = abs(float(first.joint.axis @ last.axis)) <= WRITTEN
    if len(chain.joints) == 1 or (len(chain.joints) == 2 and not square):
        return chain
    kind = JointKind.SPHERICAL if len(chain.joints) == 3 else JointKind.UNIVERSAL
    second = last.axis if kind is JointKind.UNIVERSAL else first.joint.second
    whole = replace(first.joint, kind=kind, child=last.child, second=second)
    return replace(chain, joints=[Declared(whole, first.element)], links=[])


SDF = Format(_build)
read, diagnose, repair, file_reader = SDF.read, SDF.diagnose, SDF.repair, SDF.reader


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
    carrying, reached = _grow_tree(chains, root)
    ordered = [(carrying.get(k, chain), k not in carrying) for k, chain in enumerate(chains)]
    # What hangs on nothing that was reached stays as it is: the mechanism then names it.
    return [(chain, closes and chain.child in reached) for chain, closes in ordered]


def _grow_tree(chains: Sequence[Chain], root: str) -> tuple[dict[int, Chain], set[str]]:
    """The joints that carry a link, by their place, and the links that they reach from the root."""
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
            return carrying, reached


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
