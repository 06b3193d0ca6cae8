"""Models that an SDFormat file includes by `model://name`, where they can be found."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from mafsil.model.asset_path import Assets
from mafsil.model.audit import audit
from mafsil.model.diagnostics import shown
from mafsil.model.faults import SDF_INCLUDE, SDF_INCLUDE_LEFT
from mafsil.model.reading import Reading
from mafsil.model.sdf.vocabulary import SDF as VOCABULARY
from mafsil.model.sdf.vocabulary import version_of
from mafsil.model.source import load
from mafsil.model.xml_tree import Document, Element, ReadLimits, Refusal, parse

MOST_FILES = 50


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
            audit(self.reading, model, VOCABULARY, version_of(document.root))
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
