"""What a run touched: how hard, how long, and whether the contact chattered."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.job.remark import Remark
from mafsil.job.run import Run
from mafsil.messages.quantities import quantity
from mafsil.simulation.findings import BRIEF, brief_contacts, rigid_findings


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
