"""What rigid surfaces did to a tip: impacts, contact that lasts, sticks, slips, lets go; as data and as sentences."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from mafsil.messages import say
from mafsil.messages.quantities import quantity

COUNTED = ("impacts", "releases", "closures", "sticks", "slips", "lost")
"""What is added up, of one run and of runs that follow each other."""
MOST_LISTED = 1_000
"""Events that are listed one by one, besides the first of each kind; all are counted."""


@dataclass(slots=True)
class ContactEvents:
    """Events of one run, in time.

    Attributes:
        listed: the first ones: `kind` (impact, rest, closure, stick, slip or release), `time` [s], `surface` by its
            place in the plant's; of impacts the `speed` into the surface before [m/s], the `impulse` along the normal
            and `across` it [N s], and the kinetic energy `lost` [J]; of closures, after ever shorter bounces, how many
            `bounces` there were, how long the next `flight` would have been, and when all of them would be `over` [s].
        impacts, releases, closures: how many there were; closures after ever shorter bounces.
        sticks, slips: how often friction began to hold the tip, and could not hold it any more.
        lost: kinetic energy that impacts took [J].
        bounces: impacts of each surface since the contact lasted or the tip was away the last time.
    """

    listed: list[dict[str, Any]] = field(default_factory=list[dict[str, Any]])
    impacts: int = 0
    releases: int = 0
    closures: int = 0
    sticks: int = 0
    slips: int = 0
    lost: float = 0.0
    bounces: Counter[int] = field(default_factory=Counter[int])

    def impact(
        self, time: float, speed: float, impulse: float, lost: float, *, across: float = 0.0, surface: int = 0
    ) -> None:
        """The tip hits a surface."""
        self.impacts += 1
        self.bounces[surface] += 1
        self.lost += lost
        self._add(kind="impact", time=time, surface=surface, speed=speed, impulse=impulse, across=across, lost=lost)

    def rest(self, time: float, lost: float = 0.0, *, surface: int = 0) -> None:
        """Contact begins to last."""
        self.bounces[surface] = 0
        self.lost += lost
        self._add(kind="rest", time=time, surface=surface)

    def closure(self, time: float, flight: float, over: float, lost: float, *, surface: int = 0) -> None:
        """Contact begins to last instead of bounces that get ever shorter."""
        self.closures += 1
        self.lost += lost
        bounces = self.bounces[surface]
        self._add(kind="closure", time=time, surface=surface, bounces=bounces, flight=flight, over=over, lost=lost)
        self.bounces[surface] = 0

    def stick(self, time: float, *, surface: int = 0) -> None:
        """Friction begins to hold the tip."""
        self.sticks += 1
        self._add(kind="stick", time=time, surface=surface)

    def slip(self, time: float, *, surface: int = 0) -> None:
        """Friction cannot hold the tip any more."""
        self.slips += 1
        self._add(kind="slip", time=time, surface=surface)

    def release(self, time: float, *, surface: int = 0) -> None:
        """The surface would have to pull: contact ends."""
        self.releases += 1
        self._add(kind="release", time=time, surface=surface)

    def to_dict(self) -> dict[str, Any]:
        """Plain data, as the metadata of a recording hold it."""
        return {name: getattr(self, name) for name in COUNTED} | {"events": list(self.listed)}

    def _add(self, **event: Any) -> None:
        if len(self.listed) < MOST_LISTED or event["kind"] not in {known["kind"] for known in self.listed}:
            self.listed.append(event)


def joined_events(starts: Sequence[float], parts: Sequence[Mapping[str, Any] | None]) -> dict[str, Any] | None:
    """Events of runs that follow each other; None if none had a rigid surface.

    Args:
        starts: when each run began [s], and perhaps where the last ended.
        parts: events of each as plain data, or None.
    """
    known = [(begin, found) for begin, found in zip(starts, parts, strict=False) if found is not None]
    if not known:
        return None
    whole = {name: sum(found.get(name, 0) for _, found in known) for name in COUNTED}
    events = [_later(event, begin) for begin, found in known for event in found["events"]]
    return whole | {"events": events}


def _later(event: Mapping[str, Any], begin: float) -> dict[str, Any]:
    return dict(event) | {name: event[name] + begin for name in ("time", "over") if name in event}


def rigid_sentences(found: Mapping[str, Any] | None, language: str | None) -> list[str]:
    """What a rigid surface did to the tip; nothing without one.

    Args:
        found: events as plain data, or None.
        language: of the sentences.
    """
    if found is None:
        return []
    return [say(key, language=language, **details) for key, details in rigid_findings(found)]


def rigid_findings(found: Mapping[str, Any]) -> list[tuple[str, dict[str, object]]]:
    """Keys and details of the sentences on rigid surfaces: impacts, ever shorter bounces, friction, releases.

    Args:
        found: events as plain data.
    """
    sentences: list[tuple[str, dict[str, object]]] = []
    if found["impacts"]:
        details = {"time": _first(found, "impact"), "lost": quantity(found["lost"], "J")}
        sentences.append(("simulation.rigid_impacts", {"count": found["impacts"], **details}))
    closing = next((event for event in found["events"] if event["kind"] == "closure"), None)
    if closing is not None:
        details = {name: quantity(closing[name], "s") for name in ("time", "flight", "over")}
        counted = {"bounces": closing["bounces"], "count": found["closures"]}
        sentences.append(("simulation.rigid_closure", {**details, **counted}))
    if found.get("sticks"):
        sentences.append(("simulation.rigid_stick", {"count": found["sticks"], "time": _first(found, "stick")}))
    if found.get("slips"):
        sentences.append(("simulation.rigid_slip", {"count": found["slips"], "time": _first(found, "slip")}))
    if found["releases"]:
        first = _first(found, "release")
        sentences.append(("simulation.rigid_release", {"count": found["releases"], "time": first}))
    return sentences


def _first(found: Mapping[str, Any], kind: str) -> str:
    """When the first event of a kind was."""
    return quantity(min(event["time"] for event in found["events"] if event["kind"] == kind), "s")
