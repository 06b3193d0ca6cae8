"""How near the arm of a job came to what stands around it, from the recorded motion."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.collision import Checker
from mafsil.collision.status import SMALLEST_GAP
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.job.remark import Remark
from mafsil.job.run import Run
from mafsil.job.surroundings import RESTING
from mafsil.job.unchecked import meets_others
from mafsil.job.usual import unusual, without_usual
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible

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
