"""Files that an MJCF file includes: put in place of the `include`, if they lie where the model may read."""

from __future__ import annotations

from collections.abc import Generator
from contextlib import contextmanager
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
        with self.opened(element, self.reading.reference(element, "file")) as root:
            if root is None:
                return []
            self.expand(root)
            return root.children

    @contextmanager
    def opened(self, element: Element, name: str) -> Generator[Element | None]:
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
            yield self._parsed(resolved.path, name)
            self.open.pop()

    def _parsed(self, path: Path, name: str) -> Element | None:
        self.count += 1
        try:
            text = load(path, self.limits)
            document = parse(text.data, self.limits)
        except Refusal as refusal:
            self.reading.diagnostics.append(self._placed(refusal.diagnostic, name))
            return None
        root = self.reading.include(name, text, document)
        self.folders.append(path.parent)
        elements = sum(1 for _ in root.walk())
        self.limits = replace(self.limits, elements=max(self.limits.elements - elements, 0))
        return root

    @staticmethod
    def _placed(diagnostic: Diagnostic, file: str) -> Diagnostic:
        return replace(diagnostic, file=shown(file), repair=None)
