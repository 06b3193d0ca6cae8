"""What a run touched: how hard, how long, and whether the contact chattered."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.job.remark import Remark
from mafsil.job.run import Run
from mafsil.messages.quantities import quantity
from mafsil.simulation.findings import BRIEF, brief_contacts


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
    found = brief_contacts(run.recording.t, run.recording.contact_wrench, run.job.simulation.step)
    if found is None:
        return []
    details = {"count": found[0], "time": quantity(found[1], "s"), "steps": BRIEF}
    return [Remark("warning", "simulation.brief_contact", details)]


def touching_remarks(found: Touching | None) -> list[Remark]:
    """How hard the tip pressed, or that it touched nothing."""
    if found is None:
        return []
    if not found.contacts:
        return [Remark("warning", "job.nothing_touched")]
    details = {
        "peak": quantity(found.peak, "N"),
        "peak_time": quantity(found.peak_time, "s"),
        "mean": quantity(found.mean, "N"),
        "time": quantity(found.time, "s"),
        "count": found.contacts,
    }
    return [Remark("good", "job.touched", details)]
