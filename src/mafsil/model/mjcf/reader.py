"""The MJCF reader: bodies, hinges, slides, geometry, inertia, couplings; what it cannot keep it says.

Files that an MJCF file includes: put in place of the `include`, if they lie where the model may read.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path, PurePosixPath

from mafsil.arrays import frozen
from mafsil.model.asset_path import Assets
from mafsil.model.audit import audit
from mafsil.model.diagnostics import Diagnostic, shown
from mafsil.model.faults import EMPTY_ATTRIBUTE, INCLUDE_REFUSED, INCLUDE_TWICE, NO_LINKS, WRONG_ROOT
from mafsil.model.file_reader import Format
from mafsil.model.link import Link
from mafsil.model.mechanism import Mechanism, Provenance
from mafsil.model.mimics import resolve_mimics
from mafsil.model.mjcf.body import TreeReader, hung_frames
from mafsil.model.mjcf.coupling import read_couplings
from mafsil.model.mjcf.driving import Driving
from mafsil.model.mjcf.geom import Library
from mafsil.model.mjcf.loose import settle
from mafsil.model.mjcf.mesh_asset import MeshAssets
from mafsil.model.mjcf.references import References
from mafsil.model.mjcf.scope import Model, Scope, Unfolding
from mafsil.model.mjcf.settings import read_settings
from mafsil.model.mjcf.vocabulary import MJCF as VOCABULARY
from mafsil.model.mjcf.vocabulary import NUMBERS
from mafsil.model.reading import Reading
from mafsil.model.source import load
from mafsil.model.xml_tree import Element, ReadLimits, Refusal, parse

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
