"""How near the arm of a job came to what stands around it, what it touched, and what became of doors, holes and guides.

All of it from the recorded motion: distances, forces and whether a contact chattered, how far opened, how deep, how far
astray.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.collision import Checker
from mafsil.collision.status import SMALLEST_GAP
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.job.driving.run import Run
from mafsil.job.planning.neighbours import unusual, without_usual
from mafsil.job.planning.plan import meets_others
from mafsil.job.planning.stretch import grips
from mafsil.job.planning.surroundings import RESTING
from mafsil.job.remark import Remark
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible
from mafsil.simulation.findings import BRIEF, brief_contacts, rigid_findings

PRESSED = 0.05
"""Share of its depth by which a peg in a hole may press into the side."""
MOST_MOMENTS = 2000
"""Moments of a run at which distances are measured."""
FEWEST_MOMENTS, MANY_PIECES = 200, 200_000_000
"""The same among a cloud of a camera or the like, and how many pieces all moments together look at, about."""
NEARLY = 0.5
"""Share of the wanted clearance below which what is left of it deserves a warning."""


@dataclass(frozen=True, eq=False, slots=True)
class Clearances:
    """Smallest distances over time.

    Attributes:
        t: (k,) moments [s].
        distance: (k,) between the arm and anything, or two of its own bodies [m]; minus the depth where they meet.
        first, second: (k,) the two bodies.
        wanted: (k,) the clearance that is to be kept then [m].
        smaller: (k,) by how much distances of a part that is carried count more, where it is the nearest [m].
        itself, others: whether the robot was checked against itself, and against anything else.
    """

    t: Floats
    distance: Floats
    first: tuple[str, ...]
    second: tuple[str, ...]
    wanted: Floats
    smaller: Floats
    itself: bool = True
    others: bool = True

    @property
    def verdict(self) -> str:
        """The key of what may be said where nothing was hit: only of what was looked at."""
        if self.itself and self.others:
            return "job.nothing_hit"
        return "job.no_other_hit" if self.others else "job.not_itself_hit"

    @property
    def least(self) -> int:
        """The moment of the smallest distance."""
        return int(self.distance.argmin())

    def to_dict(self) -> dict[str, Any] | None:
        """The smallest distance, when, and between what; None where there is nothing to come near to."""
        k = self.least
        if not np.isfinite(self.distance[k]):
            return None
        found = {"least": float(self.distance[k]), "time": float(self.t[k]), "wanted": float(self.wanted[k])}
        found["smaller"] = float(self.smaller[k])
        return found | {"first": self.first[k], "second": self.second[k]}


def clearances(run: Run) -> Clearances | None:
    """Distances along the recorded motion; None where the job has nothing to meet.

    Args:
        run: what happened.
    """
    around = run.plan.surroundings
    if around is None:
        return None
    t, q = run.recording.t, run.recording.q
    pieces = max(len(around.scene.pieces.rows), 1)
    most = int(np.clip(MANY_PIECES // pieces, FEWEST_MOMENTS, MOST_MOMENTS))
    rows = np.unique(np.linspace(0, len(t) - 1, min(len(t), most)).round().astype(np.intp))
    rows = rows[np.isfinite(q[rows]).all(axis=1)]
    legs = run.plan.legs_at(t[rows])
    distance = np.empty(len(rows))
    first, second = ([""] * len(rows) for _ in range(2))
    smaller = np.zeros(len(rows))
    known = dict[int, Checker]()
    for leg in np.unique(legs):
        chosen = np.flatnonzero(legs == leg)
        own = run.plan.legs[int(leg)]
        checker = around.checker(own.load, own.clearance, own.parts)
        others = known.get(id(checker))
        if others is None:
            others = known[id(checker)] = without_usual(checker)
        found = unusual(checker, others, q[rows[chosen]])
        distance[chosen] = found.distance
        for place, contact in zip(chosen.tolist(), found, strict=True):
            first[place], second[place] = contact.first, contact.second
            if own.load.carried is not None and visible(own.load.carried.name) in (contact.first, contact.second):
                smaller[place] = own.clearance + RESTING
    for k, contact in enumerate(around.clearances_beside(q[rows], t[rows])):
        if contact.distance < distance[k]:
            distance[k], first[k], second[k] = contact.distance, contact.first, contact.second
            smaller[k] = 0.0
    wanted = np.array([leg.clearance for leg in run.plan.legs])[legs]
    itself = bool(len(around.checker(run.plan.legs[0].load).arm.pairs))
    others = meets_others(around, run.plan.legs)
    return Clearances(t[rows], distance, tuple(first), tuple(second), wanted, smaller, itself, others)


def clearance_remarks(found: Clearances | None, error: float) -> list[Remark]:
    """What of the distances the reader should know.

    A gap is held against what the run knows of its own errors, never against zero alone: a smaller one is a warning.

    Args:
        found: of a run.
        error: largest distance of the tip from its path [m].
    """
    if found is None or not np.isfinite(found.distance).any():
        return []
    k = found.least
    if found.distance[k] > 0.0:
        # What is left of the clearance counts, not the distance: some moves may come nearer than others.
        near = np.where(found.wanted > 0.0, found.distance / np.maximum(found.wanted, LEAST_DIVISOR), np.inf)
        k = int(near.argmin()) if near.min() < NEARLY else k
    least, wanted = float(found.distance[k]), float(found.wanted[k])
    details = {
        "first": visible(found.first[k]), "second": visible(found.second[k]),
        "distance": quantity(abs(least), "m"), "time": quantity(float(found.t[k]), "s"),
        "verdict": f"@{found.verdict}",
    }  # fmt: skip
    if least <= 0.0:
        return [Remark("failure", "job.hit", details)]
    carried = "_carried" if found.smaller[k] > 0.0 else ""
    details |= {"smaller": quantity(float(found.smaller[k]), "m")} if carried else {}
    if least < NEARLY * wanted:
        return [Remark("warning", f"job.near_miss{carried}", details | {"wanted": quantity(wanted, "m")})]
    # Of what is carried the distance is counted larger, for it may stand on something.
    if not carried and least < max(error, SMALLEST_GAP):
        if least < error:
            return [Remark("warning", "job.gap_below_error", details | {"error": quantity(error, "m")})]
        smallest = {"smallest": quantity(SMALLEST_GAP, "m")}
        return [Remark("warning", "job.gap_below_smallest", details | smallest)]
    return [Remark("good", f"job.least_clearance{carried}", details)]


@dataclass(frozen=True, slots=True)
class Touching:
    """Contact of the tip with the surfaces of a job.

    Attributes:
        peak, peak_time: largest force [N], and when [s].
        mean: of the force while there was contact [N]; 0 without any.
        time: in contact [s].
        contacts: how often it was made.
    """

    peak: float
    peak_time: float
    mean: float
    time: float
    contacts: int

    def to_dict(self) -> dict[str, float]:
        """Plain data."""
        return {name: getattr(self, name) for name in self.__slots__}


def touching(run: Run) -> Touching | None:
    """The contact of a run; None of a job without surfaces."""
    wrench = run.recording.contact_wrench
    if wrench is None or not len(wrench):
        return None
    force = np.linalg.norm(wrench[:, 3:], axis=-1)
    there = force > 0.0
    worst = int(force.argmax())
    made = int((there[1:] & ~there[:-1]).sum() + there[0])
    period = float(np.median(np.diff(run.recording.t))) if len(force) > 1 else 0.0
    mean = float(force[there].mean()) if there.any() else 0.0
    return Touching(float(force[worst]), float(run.recording.t[worst]), mean, float(there.sum() * period), made)


def brief_contact_remarks(run: Run) -> list[Remark]:
    """Contacts that the step is too long for."""
    if "rigid_contact" in run.recording.metadata:
        return []
    found = brief_contacts(run.recording.t, run.recording.contact_wrench, run.job.simulation.step)
    if found is None:
        return []
    details = {"count": found[0], "time": quantity(found[1], "s"), "steps": BRIEF}
    return [Remark("warning", "simulation.brief_contact", details)]


def rigid_remarks(run: Run) -> list[Remark]:
    """What a rigid surface did to the tip."""
    found = run.recording.metadata.get("rigid_contact")
    return [] if found is None else [Remark("good", key, details) for key, details in rigid_findings(found)]


def touching_remarks(found: Touching | None, *, struck: bool = False) -> list[Remark]:
    """How hard the tip pressed, or that it touched nothing.

    Args:
        found: the contact, or None.
        struck: whether the tip hit something all the same, between two ticks.
    """
    if found is None:
        return []
    if not found.contacts:
        return [] if struck else [Remark("warning", "job.nothing_touched")]
    details = {
        "peak": quantity(found.peak, "N"),
        "peak_time": quantity(found.peak_time, "s"),
        "mean": quantity(found.mean, "N"),
        "time": quantity(found.time, "s"),
        "count": found.contacts,
    }
    return [Remark("good", "job.touched", details)]


def contact_remarks(run: Run) -> list[Remark]:
    """A sentence for each door, hole and guide of a job.

    Args:
        run: what happened.
    """
    job = run.job
    if not (job.door or job.hole or job.guide):
        return []
    T, _ = run.tips()
    return [*_doors(run, T), *_holes(run, T[-1, :3, 3]), *_guides(run, T[:, :3, 3])]


def _doors(run: Run, T: Floats) -> Iterator[Remark]:
    wrench = run.recording.contact_wrench
    for grip in grips(run.job, run.plan):
        one, held = grip.table, (run.recording.t >= grip.start) & (run.recording.t <= grip.end)
        if not held.any():
            continue
        angle = np.unwrap(grip.door.angle(T[held]))
        most = float(angle[np.abs(angle).argmax()])
        force = 0.0 if wrench is None else float(np.linalg.norm(wrench[held, 3:], axis=-1).max())
        details = {"angle": quantity(float(angle[-1]), "rad"), "most": quantity(most, "rad")}
        yield Remark(
            "good", "job.door_opened", {"name": _name("door", one.name), **details, "force": quantity(force, "N")}
        )


def _holes(run: Run, p: Floats) -> Iterator[Remark]:
    for one in run.job.hole:
        u = np.array(one.axis) / np.linalg.norm(one.axis)
        away = p - np.array(one.mouth)
        height = float(away @ u)
        aside = float(np.linalg.norm(away - height * u))
        details = {"name": _name("hole", one.name), "aside": quantity(aside, "m")}
        # Beside the hole it is not in it, however deep it presses into the face.
        if height < 0.0 and aside < one.clearance + one.chamfer - height * PRESSED:
            deep = {"depth": quantity(-height, "m"), "whole": quantity(one.depth, "m")}
            yield Remark("good", "job.hole_reached", details | deep)
        else:
            yield Remark("warning", "job.hole_missed", details | {"height": quantity(height, "m")})


def _guides(run: Run, p: Floats) -> Iterator[Remark]:
    for one in run.job.guide:
        away = p - np.array(one.point)
        if one.direction is not None:
            u = np.array(one.direction) / np.linalg.norm(one.direction)
            off = np.linalg.norm(away - (away @ u)[:, None] * u, axis=-1)
        else:
            u = np.array(one.normal) / np.linalg.norm(np.array(one.normal))
            off = np.abs(away @ u)
        k = int(off.argmax())
        details = {"most": quantity(float(off[k]), "m"), "time": quantity(float(run.recording.t[k]), "s")}
        yield Remark("good", "job.guide_left", {"name": _name("guide", one.name), **details})


def _name(kind: str, name: str) -> str:
    return visible(name) if name else f"@job.unnamed_{kind}"
