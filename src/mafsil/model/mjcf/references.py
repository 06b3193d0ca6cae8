"""Names that equalities, tendons and actuators use: found with the prefix and the suffixes of their model in place."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass

from mafsil.model.faults import UNKNOWN_BODY, UNKNOWN_JOINT, UNKNOWN_SITE
from mafsil.model.mjcf.body import WORLD, Tree
from mafsil.model.mjcf.scope import Scope, Unfolding
from mafsil.model.reading import Reading
from mafsil.model.xml_tree import Element


@dataclass(frozen=True, eq=False, slots=True)
class References:
    """Looks names up.

    Attributes:
        reading: where unknown names are reported.
        unfolding: the models in place and the suffixes of replications.
        tree: the bodies and joints.
    """

    reading: Reading
    unfolding: Unfolding
    tree: Tree

    def sections(self, tag: str) -> Iterator[tuple[Element, Scope]]:
        """The elements inside the sections of that tag, of every model in place."""
        for scope in self.unfolding.scopes:
            for section in scope.model.root.all(tag):
                for child in section.children:
                    yield child, scope

    def joints(self, element: Element, names: list[str], scope: Scope) -> list[tuple[str, ...]]:
        """The joints that an element names, once for every replication it belongs to; unknown ones are reported."""
        return self._instances(element, names, scope, self.tree.elements, "joint")

    def bodies(self, element: Element, names: list[str], scope: Scope) -> list[tuple[str, ...]]:
        """The bodies that an element names, as `joints`; an empty name is the world."""
        return self._instances(element, names, scope, self.tree.poses, "body")

    def sites(self, element: Element, names: list[str], scope: Scope) -> list[tuple[str, ...]]:
        """The sites that an element names, as `joints`."""
        return self._instances(element, names, scope, self.tree.sites, "site")

    def tied_pairs(self, element: Element, scope: Scope) -> list[tuple[str, ...]]:
        """The pairs of bodies that a constraint ties, by themselves or by their sites; unknown ones are passed over."""
        between_sites = "site1" in element.attributes or "site2" in element.attributes
        keys, known = (("site1", "site2"), self.tree.sites) if between_sites else (("body1", "body2"), self.tree.poses)
        rows = self._instances(element, [element.get(key) for key in keys], scope, known, None)
        return [tuple(self.tree.sites[name][0] for name in row) for row in rows] if between_sites else rows

    def _instances(
        self, element: Element, names: list[str], scope: Scope, known: Collection[str], kind: str | None
    ) -> list[tuple[str, ...]]:
        suffixes = [s for s in self.unfolding.suffixes if s.endswith(scope.suffix) and s != scope.suffix]
        found: list[tuple[str, ...]] = []
        for suffix in (scope.suffix, *suffixes):
            lengthened = [self._lengthen(name, scope, suffix, known) for name in names]
            if all(lengthened) and (suffix == scope.suffix or any(name.endswith(suffix) for name in lengthened)):
                found.append(tuple(lengthened))
                if suffix == scope.suffix:
                    break
        if not found and kind is not None:
            self._report(element, names, scope, suffixes, known, kind)
        absent = self._absent(known)
        return [row for row in found if not any(name in absent for name in row)]

    def _absent(self, known: Collection[str]) -> set[str]:
        """The names of that kind that are not part of the mechanism."""
        return self.tree.absent_joints if known is self.tree.elements else self.tree.left_out

    def _lengthen(self, name: str, scope: Scope, suffix: str, known: Collection[str]) -> str:
        """A name in place, or empty if there is none such."""
        if name in ("", WORLD):
            return WORLD
        for candidate in (f"{scope.prefix}{name}{suffix}", f"{scope.prefix}{name}{scope.suffix}"):
            if candidate in known or candidate in self._absent(known):
                return candidate
            if candidate.startswith(tuple(f"{soft}_" for soft in self.tree.soft)):
                self._absent(known).add(candidate)
                return candidate
        return ""

    def _report(
        self, element: Element, names: list[str], scope: Scope, suffixes: list[str], known: Collection[str],
        kind: str,
    ) -> None:  # fmt: skip
        """An unknown name; what belongs to a part of a model that was not attached is none."""
        if scope.partly:
            return
        places = (scope.suffix, *suffixes)
        unknown = (n for n in names if not any(self._lengthen(n, scope, suffix, known) for suffix in places))
        missing = next(unknown, names[0])
        repair = self.reading.remove(element)
        fault = {"body": UNKNOWN_BODY, "joint": UNKNOWN_JOINT, "site": UNKNOWN_SITE}[kind]
        self.reading.report(fault, element, None, repair, **{kind: missing})
