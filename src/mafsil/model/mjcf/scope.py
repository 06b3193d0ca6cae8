"""Where a part of the tree stands: its model, how its names are lengthened, the frame and the class in force."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from mafsil.arrays import PoseMatrix, frozen
from mafsil.model.diagnostics import Diagnostic
from mafsil.model.faults import INCLUDE_TWICE, NO_SUCH_PART, TOO_MANY_LINKS, UNKNOWN_ASSET
from mafsil.model.mjcf.geom import Library
from mafsil.model.mjcf.settings import read_pose, rotation_from_euler
from mafsil.model.reading import Reading
from mafsil.model.xml_tree import Element, Refusal

MOST_COPIES = 50_000
"""Parts that replication and attachment may make of one file."""
DEEPEST = 20
"""Models attached inside each other."""


@dataclass(frozen=True, eq=False, slots=True)
class Model:
    """One file with what it includes.

    Attributes:
        root: its element.
        library: its settings, meshes and materials.
        models: the models among its assets, by name.
    """

    root: Element
    library: Library
    models: dict[str, Model] = field(default_factory=dict[str, "Model"])

    def bodies(self) -> list[Element]:
        """Its `worldbody` sections."""
        return self.root.all("worldbody")


@dataclass(frozen=True, eq=False, slots=True)
class Scope:
    """A model in place: its names get a prefix where it is attached and a suffix where it is replicated.

    Attributes:
        model: which.
        prefix, suffix: of all names in it.
        partly: only a body or frame of it was attached.
        depth: how many models are attached inside each other.
    """

    model: Model
    prefix: str = ""
    suffix: str = ""
    partly: bool = False
    depth: int = 0

    @property
    def library(self) -> Library:
        """Of the model."""
        return self.model.library

    def full_name(self, name: str) -> str:
        """A name of the file as it is in the whole."""
        return f"{self.prefix}{name}{self.suffix}"


@dataclass(frozen=True, eq=False, slots=True)
class Part:
    """An element of a body, out of the frames it stands in.

    Attributes:
        element: which.
        T: (4, 4) the frames' pose in the body.
        childclass: the class in force.
        scope: its model and names.
    """

    element: Element
    T: PoseMatrix
    childclass: str
    scope: Scope


@dataclass(slots=True)
class Unfolding:
    """Takes bodies apart: frames are passed through, replications and attachments carried out.

    Attributes:
        reading: where faults are reported.
        scopes: every model in place, in the order met.
        suffixes: of all replications, in the order met.
        copies: parts made so far.
    """

    reading: Reading
    scopes: list[Scope] = field(default_factory=list[Scope])
    suffixes: dict[str, None] = field(default_factory=dict[str, None])
    copies: int = 0

    def parts(self, holder: Element, T: PoseMatrix, childclass: str, scope: Scope) -> Iterator[Part]:
        """The parts of a body (or of a frame in it, of pose T).

        1. Count: copies of copies are few lines in a file.
        2. A frame gives its content, moved by its pose, and itself if it has a name.
        3. Copies and attached models give theirs, under other names.
        4. Anything else is a part.
        """
        for child in holder.children:
            # 1.
            self.copies += 1
            if self.copies > MOST_COPIES:
                place = (child.line, child.column)
                raise Refusal(Diagnostic(TOO_MANY_LINKS, *place, {"limit": MOST_COPIES}))
            # 2.
            if child.tag == "frame":
                inner = frozen(T @ read_pose(self.reading, child, scope.library.settings))
                if child.get("name"):
                    yield Part(child, inner, childclass, scope)
                yield from self.parts(child, inner, child.get("childclass") or childclass, scope)
            # 3.
            elif child.tag == "replicate":
                yield from self._replicate(child, T, child.get("childclass") or childclass, scope)
            elif child.tag == "attach":
                yield from self._attach(child, T, scope)
            # 4.
            else:
                yield Part(child, T, childclass, scope)

    def _replicate(self, element: Element, T: PoseMatrix, childclass: str, scope: Scope) -> Iterator[Part]:
        """The content again and again, each time turned and moved further; names end with the number."""
        count = self.reading.number(element, "count", largest=MOST_COPIES)
        offset = np.array(self.reading.vector(element, "offset", 3, (0.0, 0.0, 0.0)) or (0.0, 0.0, 0.0))
        euler = np.array(self.reading.vector(element, "euler", 3, (0.0, 0.0, 0.0)) or (0.0, 0.0, 0.0))
        settings, p = scope.library.settings, np.zeros(3)
        total = int(count or 0)
        for k in range(total):
            T_k = np.eye(4)
            T_k[:3, :3] = rotation_from_euler(k * euler * settings.degree, settings.eulerseq)
            T_k[:3, 3] = p
            p = p + T_k[:3, :3] @ offset
            suffix = f"{element.get('sep')}{k:0{len(str(total))}d}{scope.suffix}"
            self.suffixes[suffix] = None
            yield from self.parts(element, frozen(T @ T_k), childclass, replace(scope, suffix=suffix))

    def _attach(self, element: Element, T: PoseMatrix, scope: Scope) -> Iterator[Part]:
        """The content of another model, or one body or frame of a model."""
        name, model = element.get("model"), scope.model
        if name:
            if name not in scope.model.models:
                self.reading.report(UNKNOWN_ASSET, element, "model", kind="model", name=name)
                return
            model = scope.model.models[name]
        if scope.depth >= DEEPEST:
            self.reading.report(INCLUDE_TWICE, element, "model", file=name)
            return
        what = "body" if element.get("body") else "frame"
        named = element.get(what)
        prefix = scope.prefix + self.reading.reference(element, "prefix")
        inner = Scope(model, prefix, scope.suffix, partly=bool(named), depth=scope.depth + 1)
        self.scopes.append(inner)
        if not named:
            for section in model.bodies():
                yield from self.parts(section, T, "", inner)
            return
        found = _find(model, what, named)
        if found is None:
            self.reading.report(NO_SUCH_PART, element, what, kind=what, name=named)
            return
        part, childclass = found
        holder = Element(part.tag, {}, part.line, part.column, part.start, children=[part], file=part.file)
        yield from self.parts(holder, T, childclass, inner)


def _find(model: Model, what: str, name: str) -> tuple[Element, str] | None:
    """A named body or frame of a model and the class in force around it."""
    waiting = [(section, "") for section in reversed(model.bodies())]
    while waiting:
        holder, childclass = waiting.pop()
        for child in holder.children:
            if child.tag == what and child.get("name") == name:
                return child, childclass
            if child.tag in ("body", "frame", "replicate"):
                waiting.append((child, child.get("childclass") or childclass))
    return None
