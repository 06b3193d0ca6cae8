"""Models inside models: their parts gathered under full names such as `arm::hand::finger`.

A model also stands in files of its own, included by `model://name`. Numbers, flags and poses are text between tags;
every element and attribute around a mechanism, of SDFormat 1.4 to 1.12, stands in `vocabulary.toml`.
"""

from __future__ import annotations

import re
from dataclasses import dataclass, field, replace
from math import radians
from pathlib import Path

import numpy as np

from mafsil.arrays import PoseMatrix, frozen
from mafsil.model.asset_path import Assets
from mafsil.model.diagnostics import shown
from mafsil.model.faults import (
    FOREIGN_ATTRIBUTE,
    SDF_CHOICE,
    SDF_INCLUDE,
    SDF_INCLUDE_LEFT,
    SDF_QUATERNION,
    UNKNOWN_ELEMENT,
)
from mafsil.model.placement import inverse, pose_from_xyz_quaternion, pose_from_xyz_rpy, quaternion_length
from mafsil.model.reading import LARGEST, Reading
from mafsil.model.sdf.frames import WORLD, Frames, Given
from mafsil.model.source import load
from mafsil.model.tolerances import QUATERNION_LENGTHS
from mafsil.model.vocabulary import Row, Version, Vocabulary, audit, read_rows
from mafsil.model.xml_tree import Document, Element, ReadLimits, Refusal, parse

NEWEST = (1, 12)
ROWS = read_rows(__file__)
"""What becomes of everything that a file may hold; elements without a row are text alone."""
_TEXT = Row()
_NEUTRAL = {"gravity": ("", "true", "1"), "kinematic": ("", "false", "0")}
MOST_FILES = 50
_WORDS = {"true": True, "1": True, "false": False, "0": False}
MODEL = "__model__"


@dataclass(frozen=True, slots=True)
class Part:
    """A link or joint with the scope in which its references are meant.

    Attributes:
        element: as it stands in the file.
        name: full name.
        prefix: of the names inside its model.
        model: full name of its model's frame.
    """

    element: Element
    name: str
    prefix: str
    model: str

    def full(self, name: str) -> str:
        """The full name of something that is called so inside the model."""
        if name == WORLD:
            return name
        return self.model if name in ("", MODEL) else self.prefix + name


@dataclass(slots=True)
class Parts:
    """Everything of one robot.

    Attributes:
        links: in the order of the file.
        connections: joints and named frames, which hang on what they are attached to, in the order of the file.
        frames: poses of all of them.
        stands_for: what carries the frames of joints and models, by their names: a joint's child, a model's canonical
            link.
    """

    links: list[Part] = field(default_factory=list[Part])
    connections: list[Part] = field(default_factory=list[Part])
    frames: Frames = field(default_factory=Frames)
    stands_for: dict[str, str] = field(default_factory=dict[str, str])

    def of(self, tag: str) -> list[Part]:
        """The joints, or the named frames."""
        return [part for part in self.connections if part.element.tag == tag]

    def carrier(self, name: str) -> str:
        """The link or named frame that is meant where a joint or a frame names something of the robot.

        Args:
            name: full name of a link, frame, joint or model; any other one comes back as it is.
        """
        passed: set[str] = set()
        while name in self.stands_for and name not in passed:
            passed.add(name)
            name = self.stands_for[name]
        return name


def gather_parts(reading: Reading, model: Element, inclusion: Inclusion) -> Parts:
    """The parts of a model and of those inside it."""
    parts = Parts()
    _gather(reading, model, "", "", parts, inclusion)
    placement = model.get("placement_frame")
    T = pose(reading, model.first("pose"))
    if placement:
        T = T @ inverse(parts.frames.placement_frame(reading, placement, model))
    parts.frames.T_ws = frozen(T)
    return parts


def _gather(reading: Reading, model: Element, prefix: str, outer: str, parts: Parts, inclusion: Inclusion) -> None:
    frame = prefix + MODEL
    if not outer:
        parts.frames.given[frame] = Given("", frozen(np.eye(4)), model)
    before = len(parts.links)
    others = {prefix + element.get("name") for element in model.children if element.tag in ("link", "frame", "model")}
    for element in model.children:
        if element.tag not in ("link", "joint", "frame", "model", "include"):
            continue
        if element.tag == "include":
            element = inclusion.model(element, must=True)
            if element is None:
                continue
        part = Part(element, prefix + reading.name(element), prefix, frame)
        if element.tag == "link":
            parts.links.append(part)
        elif element.tag in ("joint", "frame"):
            parts.connections.append(part)
        holder = element.first("pose")
        relative = "" if holder is None else holder.get("relative_to") or holder.get("frame")
        given = Given(part.full(relative or _default(element)), pose(reading, holder), element)
        if element.tag == "model":
            _gather_inner(reading, part, given, parts, inclusion)
        else:
            _place(part, given, parts, also_another=part.name in others)
    inside = sorted(parts.links[before:], key=lambda part: part.prefix != prefix)
    named = model.get("canonical_link")
    if named or inside:
        carrier = prefix + named if named else inside[0].name
        parts.stands_for |= dict.fromkeys((frame, prefix.removesuffix("::") or frame), carrier)


def _place(part: Part, given: Given, parts: Parts, *, also_another: bool) -> None:
    """The frame of a link, joint or named frame; a joint may bear the name of something else of its model."""
    is_joint = part.element.tag == "joint"
    if is_joint and also_another:
        parts.frames.of_joints[part.name] = f"{part.name}_joint"
    key = parts.frames.joint(part.name) if is_joint else part.name
    parts.frames.given.setdefault(key, given)
    if (child := part.element.first("child")) is not None:
        parts.stands_for[key] = part.full(child.text)


def _gather_inner(reading: Reading, part: Part, given: Given, parts: Parts, inclusion: Inclusion) -> None:
    """The parts of a model inside a model: under names of their own, or merged into those around."""
    element, merged = part.element, part.element.get("merge") == "true"
    inner, inner_frame = part.prefix if merged else f"{part.name}::", f"{part.name}::{MODEL}"
    placement = element.get("placement_frame")
    parts.frames.given[inner_frame] = Given("", frozen(np.eye(4)), element) if placement else given
    if merged:
        _merge(reading, element, inner, inner_frame, parts, inclusion)
    else:
        parts.frames.given[part.name] = Given(inner_frame, frozen(np.eye(4)), element)
        _gather(reading, element, inner, part.model, parts, inclusion)
    if placement:
        T_mp = parts.frames.placement_frame(reading, inner + placement, element)
        parts.frames.given[inner_frame] = Given(given.relative_to, given.T @ inverse(T_mp), element)


def _merge(reading: Reading, model: Element, prefix: str, frame: str, parts: Parts, inclusion: Inclusion) -> None:
    """The parts of a merged model, which keep their short names but refer to their own model's frame."""
    inner = Parts(frames=parts.frames)
    kept = parts.frames.given.get(prefix + MODEL)
    _gather(reading, model, prefix, frame, inner, inclusion)
    if kept is not None:
        parts.frames.given[prefix + MODEL] = kept
    for part in (*inner.links, *inner.connections):
        key = parts.frames.joint(part.name) if part.element.tag == "joint" else part.name
        given = parts.frames.given[key]
        if given.relative_to == prefix + MODEL:
            parts.frames.given[key] = Given(frame, given.T, given.element)
    parts.links.extend(Part(p.element, p.name, p.prefix, frame) for p in inner.links)
    parts.connections.extend(Part(p.element, p.name, p.prefix, frame) for p in inner.connections)
    own = {prefix + MODEL: frame}
    parts.stands_for |= {own.get(name, name): own.get(link, link) for name, link in inner.stands_for.items()}


def _default(element: Element) -> str:
    """What a pose without `relative_to` is relative to: joints to their child, frames to what they are attached to."""
    if element.tag == "joint":
        child = element.first("child")
        return "" if child is None else child.text
    return element.get("attached_to") if element.tag == "frame" else ""


def numbers(reading: Reading, element: Element | None, count: int, default: tuple[float, ...]) -> tuple[float, ...]:
    """`count` numbers between the tags of an element; the default if it is missing or empty, or after an error."""
    if element is None or not element.text:
        return default
    return reading.vector(_as_attribute(element), element.tag, count) or default


def number(reading: Reading, parent: Element, tag: str, default: float, *, infinite: bool = False) -> float:
    """One number in a child; limits may be infinite."""
    child = reading.one(parent, tag)
    if child is None:
        return default
    if infinite and (word := child.text.strip().lower().lstrip("+")) in ("inf", "-inf"):
        return float(word)
    largest = float("inf") if infinite else LARGEST
    value = reading.number(_as_attribute(child), tag, default, largest=largest) if child.text else default
    return default if value is None else value


def flag(reading: Reading, parent: Element, tag: str, *, default: bool) -> bool:
    """True or false in a child."""
    child = reading.one(parent, tag)
    if child is None:
        return default
    if child.text.lower() not in _WORDS:
        reading.report(SDF_CHOICE, child, None, None, element=tag, text=child.text, known=", ".join(_WORDS))
        return default
    return _WORDS[child.text.lower()]


def pose(reading: Reading, element: Element | None) -> PoseMatrix:
    """The pose (4, 4) between the tags of `pose`: x y z and roll pitch yaw, or a quaternion x y z w."""
    if element is None:
        return frozen(np.eye(4))
    quaternion = element.get("rotation_format") == "quat_xyzw"
    zero = (0.0,) * 6
    if quaternion:
        x, y, z, *q = numbers(reading, element, 7, (*zero, 1.0))
        return _from_quaternion(reading, element, (x, y, z), tuple(q))
    x, y, z, *rpy = numbers(reading, element, 6, zero)
    turn = radians(1.0) if element.get("degrees") in ("true", "1") else 1.0
    return frozen(pose_from_xyz_rpy((x, y, z), tuple(turn * angle for angle in rpy)))


def _from_quaternion(
    reading: Reading, element: Element, xyz: tuple[float, float, float], xyzw: tuple[float, ...]
) -> PoseMatrix:
    shortest, longest = QUATERNION_LENGTHS
    if not shortest < quaternion_length(xyzw) < longest:
        reading.report(SDF_QUATERNION, element, None, None, text=element.text)
        return frozen(np.eye(4))
    return frozen(pose_from_xyz_quaternion(xyz, xyzw))


def _as_attribute(element: Element) -> Element:
    """The element with its text as an attribute of its own name, for the strict number reader."""
    return Element(
        element.tag, {element.tag: element.text}, element.line, element.column, element.start, element.close,
        file=element.file,
    )  # fmt: skip


@dataclass(slots=True)
class Inclusion:
    """Reads included models."""

    reading: Reading
    assets: Assets
    limits: ReadLimits

    def model(self, include: Element, *, must: bool) -> Element | None:
        """The model that an `include` stands for, with the name, pose and flags that it is given there.

        Args:
            include: the element.
            must: whether it is an error if there is none; otherwise a warning.
        """
        uri = include.first("uri")
        reference = "" if uri is None else uri.text
        path = self._path(reference)
        document = self._document(path, reference) if path is not None else None
        model = None if document is None else document.root.first("model")
        if model is None:
            self.reading.report(SDF_INCLUDE if must else SDF_INCLUDE_LEFT, include, None, None, uri=reference)
            return None
        if document is not None:
            audit(self.reading, model, SDF, version_of(document.root))
        attributes = dict(model.attributes)
        for tag in ("name", "placement_frame"):
            if (given := include.first(tag)) is not None:
                attributes[tag] = given.text
        if "merge" in include.attributes:
            attributes["merge"] = include.attributes["merge"]
        given = {child.tag: child for child in include.children if child.tag in ("pose", "static")}
        children = [child for child in model.children if child.tag not in given]
        return replace(model, attributes=attributes, children=[*given.values(), *children])

    def _path(self, reference: str) -> Path | None:
        if "://" not in reference or reference.startswith("file://"):
            found = self.assets.resolve(reference)
            return found.path or self._of_folder(self.assets.resolve(f"{reference}/model.config").path)
        if (direct := self.assets.resolve(reference).path) is not None:
            return direct
        return self._of_folder(self.assets.resolve(f"{reference.rstrip('/')}/model.config").path)

    def _of_folder(self, config: Path | None) -> Path | None:
        """The file that a model.config names, the last of several versions."""
        if config is None:
            return None
        try:
            root = parse(load(config, self.limits).data, self.limits).root
        except Refusal:
            return None
        names = [child.text for child in root.all("sdf")]
        return self.assets.resolve(str(config.parent / names[-1])).path if names else None

    def _document(self, path: Path, name: str) -> Document | None:
        if len(self.reading.included) > MOST_FILES:
            return None
        try:
            text = load(path, self.limits)
            document = parse(text.data, self.limits)
        except Refusal as refusal:
            self.reading.diagnostics.append(replace(refusal.diagnostic, file=shown(name), repair=None))
            return None
        self.reading.include(name, text, document)
        return document


def row_of(tag: str, _parent: str) -> Row:
    """The row of an element that is read."""
    return ROWS.get(tag, _TEXT)


def _changes_nothing(element: Element) -> bool:
    """Whether an element that is left out has the value that it has without it."""
    if element.tag in _NEUTRAL:
        return element.text.strip().lower() in _NEUTRAL[element.tag]
    return not element.text and all(child.text.strip() in ("", "0", "0.0") for child in element.children)


SDF = Vocabulary(
    "SDFormat", row_of, FOREIGN_ATTRIBUTE, UNKNOWN_ELEMENT, strict=False,
    is_neutral=lambda _tag, _attribute, _text: False, is_neutral_part=_changes_nothing,
)  # fmt: skip


def version_of(root: Element) -> Version:
    """The version that a file declares; the newest if it declares none."""
    found = re.match(r"(\d{1,3})\.(\d{1,3})", root.get("version"))
    return NEWEST if found is None else (int(found[1]), int(found[2]))
