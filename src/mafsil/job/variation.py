"""Answers of a job driven many times (`job.vary`): what fails how often, and why."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats
from mafsil.job.variation_table import VariationTable
from mafsil.messages import say
from mafsil.messages.quantities import quantity
from mafsil.messages.tables import number, table
from mafsil.simulation import MonteCarlo
from mafsil.simulation.many_runs import wilson
from mafsil.simulation.variation import drawn_name

SHARES = (0.5, 0.9, 0.95, 0.99, 1.0)
"""Of the runs, up to whose worst errors are told."""
CLIPPED = 0.01
"""Share of the time with clipped efforts from which on they are taken as the cause of a missed target."""
CAUSES = ("blown_up", "loops_lost", "saturated", "not_reached")
"""Why a run fails: the motion ran away; its loops could not be followed; a target was missed while efforts were
clipped, or without that."""


class VariationStatus(Status):
    """Whether all runs did the job."""

    ALL_DONE = ("job.variation_all", True)
    SOME_FAILED = ("job.variation_some", False)


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class JobVariation(Answer):
    """Many runs of a job; true if each did it; iterable over the numbers of those that did not.

    Attributes:
        drawn: the runs: what was drawn, and what came out.
        asked: the table of the job.
        missed: (b,) index of the leg whose target was missed first, -1 where none was.
        legs: names of the legs.
    """

    drawn: MonteCarlo
    asked: VariationTable
    missed: NDArray[np.int64]
    legs: tuple[str, ...]

    @property
    def causes(self) -> dict[str, NDArray[np.bool_]]:
        """(b,) each: which runs failed by what; no run by two causes."""
        ended, clipped = self.drawn.outcomes.finished, self.drawn.outcomes.saturated > CLIPPED
        off, lost = ended & (self.missed >= 0), self.drawn.outcomes.lost
        return dict(zip(CAUSES, (~ended & ~lost, ~ended & lost, off & clipped, off & ~clipped), strict=True))

    @property
    def failed(self) -> NDArray[np.bool_]:
        """(b,) which runs did not do the job."""
        return np.logical_or.reduce(list(self.causes.values()))

    @property
    def runs(self) -> int:
        """How many there are."""
        return len(self.missed)

    @property
    def done(self) -> int:
        """How many did the job."""
        return self.runs - len(self)

    @property
    def status(self) -> VariationStatus:
        """Whether all did."""
        return VariationStatus.SOME_FAILED if self.failed.any() else VariationStatus.ALL_DONE

    def __len__(self) -> int:
        return int(self.failed.sum())

    def __iter__(self) -> Iterator[int]:
        return iter(np.flatnonzero(self.failed).tolist())

    def quantiles(self) -> dict[str, Floats]:
        """Values that SHARES of the runs do not exceed: tip error [m, rad], its mean square, clipped time, work [J]."""
        found = self.drawn.outcomes
        names = ("tip_error", "tip_rotation", "tip_rms", "saturated", "work")
        place = [max(0, int(np.ceil(share * len(found.end))) - 1) for share in SHARES]
        return {name: np.sort(getattr(found, name))[place] for name in names}

    def rows(self) -> list[tuple[str, ...]]:
        """The table of quantiles: a row for each quantity, with its key first."""
        units = {"tip_error": "m", "tip_rotation": "rad", "tip_rms": "m", "work": "J"}
        shown: list[tuple[str, ...]] = []
        for name, values in self.quantiles().items():
            cells = (
                "–" if not np.isfinite(value) else quantity(value, units[name]) if name in units
                else f"{number(100.0 * value)} %"
                for value in values.tolist()
            )  # fmt: skip
            shown.append((name, *cells))
        return shown

    def explain(self, language: str | None = None) -> str:
        """How many runs did the job, what the others failed by, and what goes most with the error."""
        share, low, high = wilson(self.done, self.runs)
        details = {"runs": self.runs, "done": self.done, "seed": self.asked.seed}
        percent = {"share": 100.0 * share, "low": 100.0 * low, "high": 100.0 * high}
        lines = [self.status.sentence(language, **details, **percent)]
        for name, which in self.causes.items():
            if which.any():
                lines.append(self._cause(name, which, language))
        if self.asked.bound is not None:
            within, low, high = (100.0 * x for x in self.drawn.share_within)
            bound = {"share": within, "low": low, "high": high, "bound": 1e3 * self.asked.bound}
            lines.append(say("simulation.share_within", language=language, **bound))
        strongest = next(iter(self.drawn.influence.items()), None)
        if strongest is not None:
            words = {"name": drawn_name(strongest[0], language), "correlation": strongest[1]}
            lines.append(say("simulation.influence", language=language, **words))
        return "\n".join(lines)

    def _table(self) -> list[str]:
        head = ("", *(f"{100.0 * share:g} %" for share in SHARES))
        return table(head, self.rows())

    def to_dict(self) -> dict[str, Any]:
        """Plain data: the counts, the quantiles, and every run."""
        found, causes = self.drawn.outcomes, self.causes
        return {
            "status": self.status.name.lower(),
            "runs": self.runs, "asked": self.asked.runs, "seed": self.asked.seed,
            "done": self.done, "done_share": wilson(self.done, self.runs),
            "failed_by": {name: int(which.sum()) for name, which in causes.items()},
            "missed": {name: int(count) for name, count in self._missed_legs().items()},
            "bound": self.asked.bound,
            "within_bound": None if self.asked.bound is None else self.drawn.share_within,
            "shares": SHARES,
            "quantiles": {name: _plain(values) for name, values in self.quantiles().items()},
            "influence": self.drawn.influence,
            "sentence": {language: self.explain(language) for language in ("en", "ar")},
            "each": {
                "drawn": {name: _plain(column) for name, column in self.drawn.variants.columns().items()},
                "tip_error": _plain(found.tip_error), "tip_rms": _plain(found.tip_rms),
                "saturated": _plain(found.saturated), "work": _plain(found.work), "end": _plain(found.end),
                "failed_by": [next((name for name in CAUSES if causes[name][k]), None) for k in range(self.runs)],
            },
        }  # fmt: skip

    def _cause(self, name: str, which: NDArray[np.bool_], language: str | None) -> str:
        details: dict[str, object] = {"count": int(which.sum()), "total": len(which), "first": int(which.argmax())}
        if name in ("saturated", "not_reached"):
            legs, counts = np.unique(self.missed[which], return_counts=True)
            details["move"] = self.legs[int(legs[counts.argmax()])]
        return say(f"job.variation_{name}", language=language, **details)

    def _missed_legs(self) -> dict[str, int]:
        legs, counts = np.unique(self.missed[self.missed >= 0], return_counts=True)
        return {self.legs[int(leg)]: int(count) for leg, count in zip(legs, counts, strict=True)}


def _plain(values: Floats) -> list[float | None]:
    """Numbers as JSON can hold them."""
    return [value if np.isfinite(value) else None for value in np.asarray(values, dtype=float).tolist()]
