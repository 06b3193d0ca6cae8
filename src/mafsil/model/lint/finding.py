"""What a rule found, before it has a place: which part of which name, numbers, and the change that would mend it.

The catalogue of what looks wrong in a description that can be read: code, severity, sentence key.

Letter P (plausibility): 08 bodies, 09 joints, 10 the whole robot. Faults of mass properties themselves keep the
readers' codes I05..; they are judged here for robots that came from no file.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

from mafsil.model.diagnostics import Diagnostic, Edit, Fault, Repair, Severity, safe
from mafsil.model.reading import Reading, written
from mafsil.model.xml_tree import Document, Element

FAULTS: dict[str, Fault] = {}
"""Every fault of this catalogue by its code."""


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


def _fault(code: str, severity: Severity, name: str) -> Fault:
    if code in FAULTS:
        raise ValueError(code)
    FAULTS[code] = Fault(code, severity, f"lint.{name}")
    return FAULTS[code]


def _error(code: str, name: str) -> Fault:
    return _fault(code, Severity.ERROR, name)


def _warning(code: str, name: str) -> Fault:
    return _fault(code, Severity.WARNING, name)


def _info(code: str, name: str) -> Fault:
    return _fault(code, Severity.INFO, name)


# Bodies
TOO_HEAVY = _warning("P0801", "too_heavy")
TOO_LIGHT = _warning("P0802", "too_light")
GRAMS = _warning("P0803", "grams")
MILLIMETRES = _warning("P0804", "millimetres")
COM_OUTSIDE = _warning("P0810", "com_outside")
COM_MIRRORED = _warning("P0811", "com_mirrored")
ABOUT_FRAME = _warning("P0812", "about_frame")
INERTIA_TOO_LARGE = _warning("P0813", "inertia_too_large")
INERTIA_TOO_SMALL = _warning("P0814", "inertia_too_small")
INERTIA_UNIT = _warning("P0815", "inertia_unit")
PLACEHOLDER = _warning("P0820", "placeholder")
COPIED = _info("P0821", "copied")
MASS_RATIO = _info("P0822", "mass_ratio")
NO_COLLISION = _info("P0830", "no_collision")
# Joints
DEGREES = _warning("P0901", "degrees")
DEGREES_RATE = _warning("P0902", "degrees_rate")
MILLIMETRES_TRAVEL = _warning("P0903", "millimetres_travel")
ABSURD_BOUND = _info("P0904", "absurd_bound")
NO_RANGE = _info("P0905", "no_range")
ZERO_BOUND = _warning("P0906", "zero_bound")
ZERO_OUTSIDE = _info("P0907", "zero_outside")
MIMIC_RANGE = _warning("P0908", "mimic_range")
NEARLY_ALONG = _info("P0910", "nearly_along")
ANTIPARALLEL = _info("P0911", "antiparallel")
MIRRORED_RANGE = _warning("P0912", "mirrored_range")
SAME_LINE = _warning("P0913", "same_line")
LONG_LINK = _warning("P0915", "long_link")
MOVES_NOTHING = _warning("P0914", "moves_nothing")
LIMIT_REFUSED = _error("P0916", "limit_refused")
BOUND_REFUSED = _error("P0917", "bound_refused")
# The whole robot
GRAVITY_UP = _warning("P1001", "gravity_up")
GRAVITY_SIZE = _warning("P1002", "gravity_size")
NO_MASSES = _info("P1003", "no_masses")
