"""The MJCF reader: bodies, hinges, slides, geometry, inertia, couplings; what it cannot keep it says.

Files that an MJCF file includes are put in place of the `include`, if they lie where the model may read. Bodies that
float in the world: a robot's base is fixed where it is drawn, what hangs in its loops moves with it. The platform of a
parallel robot is mostly written so: a body with a free joint, tied to legs by `connect` or `weld`.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath

import numpy as np

from mafsil.arrays import Floats, PoseMatrix, frozen
from mafsil.model.asset_path import Assets
from mafsil.model.diagnostics import Diagnostic, shown
from mafsil.model.faults import (
    BASE_FIXED,
    EMPTY_ATTRIBUTE,
    INCLUDE_REFUSED,
    INCLUDE_TWICE,
    LOOSE_HELD,
    LOOSE_OBJECT,
    NO_LINKS,
    WRONG_ROOT,
)
from mafsil.model.file_reader import Format
from mafsil.model.joint import Joint, JointKind
from mafsil.model.link import Link
from mafsil.model.mechanism import Mechanism, Provenance
from mafsil.model.mimics import resolve_mimics
from mafsil.model.mjcf.body import WORLD, Tree, TreeReader, hung_frames
from mafsil.model.mjcf.closure import KINDS, References, read_couplings
from mafsil.model.mjcf.driving import Driving
from mafsil.model.mjcf.geom import Library
from mafsil.model.mjcf.mesh_asset import MeshAssets
from mafsil.model.mjcf.scope import Model, Scope, Unfolding
from mafsil.model.mjcf.settings import MJCF as VOCABULARY
from mafsil.model.mjcf.settings import NUMBERS, read_settings
from mafsil.model.reading import Reading
from mafsil.model.source import load
from mafsil.model.vocabulary import audit
from mafsil.model.xml_tree import Element, ReadLimits, Refusal, parse

FREE = ("x", "y", "z", "turn x", "turn y", "turn z")
"""Coordinates of a body that only loops hold: along the axes of the world, then about the body's own in turn."""
MOST_FILES = 100


def _build(reading: Reading, assets: Assets, _source: str, limits: ReadLimits) -> Mechanism | None:
    root = reading.document.root
    if root.tag != "mujoco":
        reading.report(WRONG_ROOT, root, found=root.tag, expected="mujoco")
        return None
    inclusion = Inclusion(reading, assets, limits)
    inclusion.expand(root)
    model = _model(reading, root, inclusion)
    if not any(section.children for section in model.bodies()):
        reading.report(NO_LINKS, root)
        return None
    scope = Scope(model)
    unfolding = Unfolding(reading, [scope])
    tree = TreeReader(reading, unfolding, limits).read(scope)
    references = References(reading, unfolding, tree)
    settle(reading, tree, references)
    declared, loops = read_couplings(references, root)
    joints = Driving(references, resolve_mimics(reading, declared)).finish()
    if reading.failed:
        return None
    name = root.get("model").strip() or "mujoco"
    settings = model.library.settings
    frames = hung_frames(tree)
    links, marks = _scale(tree.links, settings.total_mass), {joint.child for joint in frames}
    origin = Provenance(postures=tuple(_postures(references)))
    return Mechanism.assemble(
        name, links, (*joints, *frames), loops=loops, gravity=settings.gravity, marks=marks, provenance=origin
    )


def _postures(references: References) -> Iterator[tuple[str, dict[str, float]]]:
    """Postures that keyframes name: places of all joints in the order of the file, and of nothing else."""
    names = [joint.name for joint in references.tree.joints if joint.moves]
    for k, (key, _) in enumerate(references.sections("keyframe")):
        if len(key.get("qpos", "").split()) == len(names):
            values = references.reading.vector(key, "qpos", len(names))
            if values is not None:
                yield key.get("name") or f"key {k}", dict(zip(names, values, strict=True))


def _model(reading: Reading, root: Element, inclusion: Inclusion) -> Model:
    """A model whose includes are in place, with the models among its assets.

    1. Report what the reader leaves out or refuses; take out what is empty.
    2. Read the settings that all parts share.
    3. Collect meshes, materials and whole models by name, each with the defaults of its class.
    """
    # 1.
    audit(reading, root, VOCABULARY)
    _take_out_empty(reading, root)
    # 2.
    settings = read_settings(reading, root)
    library = Library(settings, MeshAssets(settings, inclusion.assets, inclusion.folders))
    model = Model(root, library)
    # 3.
    for section in root.all("asset"):
        for child in section.children:
            element = settings.apply_defaults(reading, child, "") if child.tag != "model" else child
            if child.tag == "mesh":
                library.meshes.add(element)
            elif child.tag == "material":
                library.materials[element.get("name")] = element
            elif child.tag == "model":
                _add_model(reading, child, model, inclusion)
    return model


def _take_out_empty(reading: Reading, root: Element) -> None:
    """Numbers that are not there are as if their attribute was not there: defaults of classes hold."""
    for element in root.walk():
        for name in [name for name, text in element.attributes.items() if not text.strip() and name in NUMBERS]:
            reading.report(
                EMPTY_ATTRIBUTE, element, name, reading.remove_attribute(element, name),
                element=element.tag, attribute=name,
            )  # fmt: skip
            del element.attributes[name]


def _add_model(reading: Reading, element: Element, model: Model, inclusion: Inclusion) -> None:
    """A model among the assets, with its own settings; its files lie around it."""
    with inclusion.open_file(element, reading.reference(element, "file")) as root:
        if root is None:
            return
        inclusion.expand(root)
        if root.tag != "mujoco":
            reading.report(WRONG_ROOT, root, found=root.tag, expected="mujoco")
            return
        inner = replace(inclusion, assets=inclusion.assets.beside(inclusion.open[-1]))
        name = element.get("name") or root.get("model") or PurePosixPath(element.get("file")).stem
        model.models[name] = _model(reading, root, inner)
        inclusion.count = inner.count


def _scale(links: list[Link], total: float) -> list[Link]:
    """The links with masses and inertias scaled so that the masses add up to `total`, if that is positive."""
    mass = sum(link.inertial.mass for link in links if link.inertial is not None)
    if total <= 0.0 or mass <= 0.0:
        return links
    factor = total / mass
    return [
        link
        if link.inertial is None
        else replace(
            link,
            inertial=replace(
                link.inertial, mass=link.inertial.mass * factor, inertia=frozen(link.inertial.inertia * factor)
            ),
        )
        for link in links
    ]


MJCF = Format(_build)
read, diagnose, repair, file_reader = MJCF.read, MJCF.diagnose, MJCF.repair, MJCF.reader


@dataclass(slots=True)
class Inclusion:
    """The state of including: which files are open, how many were read.

    Attributes:
        reading, assets, limits: of the top model.
        open: the files that are being put in place, the innermost last.
        folders: where each included file lies, in the order of the reading's list of them.
        count: files read so far.
    """

    reading: Reading
    assets: Assets
    limits: ReadLimits
    open: list[Path] = field(default_factory=list[Path])
    folders: list[Path] = field(default_factory=list[Path])
    count: int = 0

    def expand(self, root: Element) -> None:
        """Replace every `include` below an element by the children of the file's root."""
        for element in list(root.walk()):
            if any(child.tag == "include" for child in element.children):
                element.children = [inner for child in element.children for inner in self._contents(child)]

    def _contents(self, element: Element) -> list[Element]:
        """The element itself, or what it includes, to any depth."""
        if element.tag != "include":
            return [element]
        with self.open_file(element, self.reading.reference(element, "file")) as root:
            if root is None:
                return []
            self.expand(root)
            return root.children

    @contextmanager
    def open_file(self, element: Element, name: str) -> Generator[Element | None]:
        """A file, looked for in the model's folder and then beside the file that names it; open while it is used."""
        resolved = self.assets.resolve(name)
        if resolved.path is None and self.open:
            beside = replace(self.assets, folder=self.open[-1].parent).resolve(name)
            resolved = beside if beside.path is not None else resolved
        if resolved.path is None:
            reason = "" if resolved.fault is None else resolved.fault.code
            self.reading.report(INCLUDE_REFUSED, element, "file", file=name, reason=reason)
            yield None
        elif resolved.path in self.open or self.count >= MOST_FILES:
            self.reading.report(INCLUDE_TWICE, element, "file", self.reading.remove(element), file=name)
            yield None
        else:
            self.open.append(resolved.path)
            yield self._parse(resolved.path, name)
            self.open.pop()

    def _parse(self, path: Path, name: str) -> Element | None:
        self.count += 1
        try:
            text = load(path, self.limits)
            document = parse(text.data, self.limits)
        except Refusal as refusal:
            self.reading.diagnostics.append(self._place(refusal.diagnostic, name))
            return None
        root = self.reading.include(name, text, document)
        self.folders.append(path.parent)
        elements = sum(1 for _ in root.walk())
        self.limits = replace(self.limits, elements=max(self.limits.elements - elements, 0))
        return root

    @staticmethod
    def _place(diagnostic: Diagnostic, file: str) -> Diagnostic:
        return replace(diagnostic, file=shown(file), repair=None)


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
