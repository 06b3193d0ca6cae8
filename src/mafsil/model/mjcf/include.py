"""Files that an MJCF file includes: put in place of the `include`, if they lie inside the model's directory."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from pathlib import Path

from mafsil.model.asset_path import Assets
from mafsil.model.diagnostics import Diagnostic, shown
from mafsil.model.faults import INCLUDE_REFUSED, INCLUDE_TWICE
from mafsil.model.reading import Reading
from mafsil.model.source import load
from mafsil.model.xml_tree import Element, ReadLimits, Refusal, parse

MOST_FILES = 100


@dataclass(slots=True)
class Inclusion:
    """The state of including: what has been read, what may still be read."""

    reading: Reading
    assets: Assets
    limits: ReadLimits
    seen: set[Path] = field(default_factory=set[Path])

    def expand(self, root: Element) -> None:
        """Replace every `include` below an element by the children of the file's root."""
        waiting = [root]
        while waiting:
            element = waiting.pop()
            if any(child.tag == "include" for child in element.children):
                element.children = [inner for child in element.children for inner in self._contents(child)]
            waiting.extend(element.children)

    def _contents(self, element: Element) -> list[Element]:
        """The element itself, or what it includes, to any depth."""
        if element.tag != "include":
            return [element]
        root = self._read(element)
        return [] if root is None else [inner for child in root.children for inner in self._contents(child)]

    def _read(self, element: Element) -> Element | None:
        name = self.reading.reference(element, "file")
        resolved = self.assets.resolve(name)
        if resolved.path is None:
            reason = "" if resolved.fault is None else resolved.fault.code
            self.reading.report(INCLUDE_REFUSED, element, "file", file=name, reason=reason)
            return None
        if resolved.path in self.seen or len(self.seen) >= MOST_FILES:
            self.reading.report(INCLUDE_TWICE, element, "file", self.reading.remove(element), file=name)
            return None
        self.seen.add(resolved.path)
        try:
            document = parse(load(resolved.path, self.limits).data, self.limits)
        except Refusal as refusal:
            self.reading.diagnostics.append(self._placed(refusal.diagnostic, name))
            return None
        self.reading.included.append((shown(name), document))
        elements = list(document.root.walk())
        self.limits = replace(self.limits, elements=max(self.limits.elements - len(elements), 0))
        for inner in elements:
            inner.file = len(self.reading.included)
        return document.root

    @staticmethod
    def _placed(diagnostic: Diagnostic, file: str) -> Diagnostic:
        return replace(diagnostic, file=shown(file), repair=None)
