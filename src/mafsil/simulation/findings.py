"""What a motion over time shows besides its end: a row for each joint, and findings as data and as sentences.

Efforts were clipped or alternate, contact chatters; rigid surfaces did something to a tip: impacts, contact that lasts,
sticks, slips, lets go.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.messages import say
from mafsil.messages.quantities import digits, quantity
from mafsil.messages.tables import joint_units, number, table
from mafsil.messages.visible import visible


def joint_table(title: str, names: Sequence[str], q: Floats, peaks: dict[str, Floats]) -> str:
    """A sentence and a table: start, end and largest magnitudes of each joint, over a whole batch.

    Args:
        title: the sentence.
        names: (n,) of the joints.
        q: (k, *batch, n) positions [rad | m].
        peaks: (k, *batch, n) quantities, by the name of their column in the messages.
    """
    n = len(names)
    if not q.size:
        return title
    columns = [_largest(q[0].reshape(-1, n)), _largest(q[-1].reshape(-1, n))]
    columns += [np.abs(values).reshape(-1, n).max(axis=0) for values in peaks.values()]
    rows = [[name, *(number(float(x)) for x in row)] for name, *row in zip(names, *columns, strict=True)]
    names = ("joint", "start", "end", *peaks)
    head = [say(f"simulation.column_{name}") for name in names]
    return "\n".join([title, *table(head, rows, units=joint_units(names))])


def _largest(values: Floats) -> Floats:
    """(n,) of values (batch, n) those of largest magnitude, with their sign."""
    return np.take_along_axis(values, np.abs(values).argmax(axis=0)[None], axis=0)[0]


COUNTED = ("impacts", "releases", "closures", "sticks", "slips", "lost")
"""What is added up, of one run and of runs that follow each other."""
MOST_LISTED = 1_000
"""Events that are listed one by one, besides the first of each kind; all are counted."""
WINDOW, CHANGES = 40, 8
"""Ticks within which so many changes between contact and none count as chattering."""
ALTERNATIONS, SWING = 50, 0.05
"""Ticks in a row in which an effort goes up and down by turns, by this share of its largest: noise does not do that."""
BRIEF = 4
"""Steps below which a contact from its beginning to its end is too short for its forces to be computed."""


def near_singular_sentence(found: Mapping[str, float] | None, language: str | None) -> str | None:
    """How near to a singular pose a law of the tip came, and when; None if it did not.

    Args:
        found: `ratio` of singular values, `time` [s]; or None.
        language: of the sentence.
    """
    if found is None:
        return None
    details = {"ratio": digits(found["ratio"]), "time": quantity(found["time"], "s")}
    return say("simulation.near_singular", language=language, **details)


def saturation_sentence(
    t: Floats, saturated: NDArray[np.bool_], joints: Sequence[str], language: str | None
) -> str | None:
    """The joint whose effort was clipped the longest, and for which share of the run; None if none was.

    Args:
        t: (k,) times [s].
        saturated: (k, *batch, n) where efforts were clipped.
        joints: names.
        language: of the sentence.
    """
    if not saturated.any():
        return None
    shares = saturated.reshape(-1, saturated.shape[-1]).mean(axis=0)
    worst = int(shares.argmax())
    first = float(t[int(saturated.reshape(len(t), -1).any(axis=1).argmax())])
    details = {"joint": visible(joints[worst]), "share": quantity(float(shares[worst]), "share")}
    return say("simulation.was_saturated", language=language, time=quantity(first, "s"), **details)


def alternating_efforts(t: Floats, tau: Floats) -> tuple[int, float, float, float] | None:
    """The joint whose effort goes up and down from tick to tick, as behind a switch that is too fast for its sampling.

    Args:
        t: (k,) times [s].
        tau: (k, n) efforts [N m | N].

    Returns:
        The joint with the largest mean step against its largest effort, that step [N m | N], since when, and for how
        long in all [s]; None if none does.
    """
    if tau.ndim != 2 or len(tau) <= ALTERNATIONS:
        return None
    step = np.diff(tau, axis=0)
    turns = step[1:] * step[:-1] < 0.0
    # How many turns there are in a row up to each tick.
    count = np.arange(1, len(turns) + 1)[:, None]
    before = np.maximum.accumulate(np.where(turns, 0, count), axis=0)
    lasting = (count - before) >= ALTERNATIONS
    best: tuple[float, int, float, float, float] | None = None
    for joint in np.flatnonzero(lasting.any(axis=0)).tolist():
        ends = np.flatnonzero(lasting[:, joint])
        inside = np.zeros(len(turns), dtype=bool)
        for shift in range(ALTERNATIONS):
            inside[ends - shift] = True
        swing, most = float(np.abs(step[1:][inside, joint]).mean()), float(np.abs(tau[:, joint]).max())
        if swing > SWING * most and (best is None or swing / most > best[0]):
            lasted = float((t[2:] - t[1:-1])[inside].sum())
            best = swing / most, joint, swing, float(t[int(inside.argmax())]), lasted
    return None if best is None else best[1:]


def alternating_sentence(t: Floats, tau: Floats, joints: Sequence[str], language: str | None) -> str | None:
    """Which effort goes up and down from tick to tick, by how much and how long; None if none does.

    Args:
        t, tau: as of `alternating_efforts`.
        joints: names.
        language: of the sentence.
    """
    found = alternating_efforts(t, tau)
    if found is None:
        return None
    joint, swing, begin, lasted = found
    details = {"joint": visible(joints[joint]), "step": digits(swing)}
    details |= {"time": quantity(begin, "s"), "lasted": quantity(lasted, "s")}
    return say("simulation.alternates", language=language, **details)


def chatter_sentence(t: Floats, contact_wrench: Floats | None, language: str | None) -> str | None:
    """How often a contact was made that chatters, and from when on; None if none does.

    Args:
        t: (k,) times [s].
        contact_wrench: (k, *batch, 6) of the environment on the tip, or None.
        language: of the sentence.
    """
    if contact_wrench is None or len(contact_wrench) < 2:
        return None
    touching = contact_wrench.any(axis=-1).reshape(len(t), -1)
    changes = touching[1:] != touching[:-1]
    before = np.vstack([np.zeros((1, changes.shape[1]), dtype=int), changes.cumsum(axis=0)])
    recent = before[1:] - before[np.maximum(np.arange(1, len(before)) - WINDOW, 0)]
    busy = recent >= CHANGES
    if not busy.any():
        return None
    run = int(busy.any(axis=0).argmax())
    begin = max(int(busy[:, run].argmax()) - WINDOW + 1, 0)
    made = int((changes[:, run] & touching[1:, run]).sum() + touching[0, run])
    return say("simulation.chatters", language=language, count=made, time=quantity(float(t[begin]), "s"))


def brief_contact_sentence(t: Floats, contact_wrench: Floats | None, step: float, language: str | None) -> str | None:
    """How many contacts ended within a few steps of the integration: too stiff for it; None if none did.

    Args:
        t: (k,) times [s].
        contact_wrench: (k, *batch, 6) of the environment on the tip, or None.
        step: of the integration [s].
        language: of the sentence.
    """
    found = brief_contacts(t, contact_wrench, step)
    if found is None:
        return None
    count, time = found
    return say("simulation.brief_contact", language=language, count=count, time=quantity(time, "s"), steps=BRIEF)


def brief_contacts(t: Floats, contact_wrench: Floats | None, step: float) -> tuple[int, float] | None:
    """How many contacts lasted less than BRIEF steps, and when the first of them began [s]; arguments as there."""
    if contact_wrench is None or len(contact_wrench) < 3:
        return None
    touching = contact_wrench.any(axis=-1).reshape(len(t), -1)
    edges = np.diff(touching.astype(np.int8), axis=0, prepend=0)
    count, first = 0, np.inf
    for column in edges.T:
        begin, end = np.flatnonzero(column > 0), np.flatnonzero(column < 0)
        begin = begin[: len(end)]
        brief = (t[end] - t[begin]) < (BRIEF - 0.5) * step
        count += int(brief.sum())
        first = min(first, float(t[begin][brief].min(initial=np.inf)))
    return (count, first) if count else None


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
