"""What a rule found, before it has a place: which part of which name, numbers, and the change that would mend it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from mafsil.model.diagnostics import Diagnostic, Edit, Fault, Repair, safe
from mafsil.model.numbers import written
from mafsil.model.reading import Reading
from mafsil.model.xml_tree import Document, Element


@dataclass(frozen=True, slots=True)
class Put:
    """A new value of an attribute: a text, or a factor to what stands there.

    Attributes:
        path: tags from the part's element inward.
        attribute: its name.
        value: the new text, or None.
        factor: what every number there is multiplied by.
    """

    path: tuple[str, ...]
    attribute: str
    value: str | None = None
    factor: float = 1.0


@dataclass(frozen=True, slots=True)
class Finding:
    """One remark about one part.

    Attributes:
        fault: what kind.
        part: `link`, `joint` or `robot`.
        name: of the part.
        details: for the sentence.
        path: tags from the part's element to the place that is meant.
        attribute: at that place, or None.
        puts: the change that would mend it, for a file; empty where it is not clear.
        offer: key of the sentence that says what the change does.
    """

    fault: Fault
    part: str
    name: str
    details: dict[str, object] = field(default_factory=dict[str, object])
    path: tuple[str, ...] = ()
    attribute: str | None = None
    puts: tuple[Put, ...] = ()
    offer: str = ""

    def without_place(self) -> Diagnostic:
        """The remark about a robot that came from no file."""
        return Diagnostic(self.fault, 0, 0, safe(self.details))

    def report(self, reading: Reading, *, repairs: bool) -> None:
        """The remark at its place in a file.

        Args:
            reading: of the file.
            repairs: whether the file's format is one in which the change can be written.
        """
        element = _part(reading.document.root, self.part, self.name)
        if element is None:
            reading.diagnostics.append(self.without_place())
            return
        repair = self._repair(reading.document, element) if repairs and self.puts else None
        reading.report(self.fault, _inner(element, self.path), self.attribute, repair, **self.details)

    def _repair(self, document: Document, element: Element) -> Repair | None:
        edits: list[Edit] = []
        for put in self.puts:
            for target in _targets(element, put.path):
                value = put.value if put.value is not None else _scale(target.get(put.attribute), put.factor)
                if value is None:
                    return None
                edits.append(document.set_attribute(target, put.attribute, value))
        return Repair(self.offer, tuple(edits), safe(self.details)) if edits else None


def _part(root: Element, part: str, name: str) -> Element | None:
    """The element of a part: links and joints of URDF, bodies and joints of MJCF."""
    if part == "robot":
        return root
    tags = ("link", "body") if part == "link" else ("joint",)
    return next((e for e in root.walk() if e.tag in tags and e.get("name") == name), None)


def _inner(element: Element, path: tuple[str, ...]) -> Element:
    """The place inside, as far as it exists."""
    for tag in path:
        element = element.first(tag) or element
    return element


def _targets(element: Element, path: tuple[str, ...]) -> Iterator[Element]:
    """All elements of a path."""
    if not path:
        yield element
        return
    for child in element.all(path[0]):
        yield from _targets(child, path[1:])


def _scale(text: str, factor: float) -> str | None:
    """Numbers of an attribute times a factor; one alone for a missing one; None if they are no numbers."""
    try:
        return " ".join(written(float(word) * factor) for word in (text.split() or ["1", "1", "1"]))
    except ValueError:
        return None
