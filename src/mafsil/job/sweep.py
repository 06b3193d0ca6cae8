"""One job with many values of its variables: what can be done, how long it takes, how near it comes to its limits."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from mafsil.answer import Answer
from mafsil.errors import InputError
from mafsil.job.driving.run import Run
from mafsil.job.judging.judgement import summary
from mafsil.job.language.reading import parse_job
from mafsil.job.remark import Refusal
from mafsil.job.solve import drive, plan_searches, prepare
from mafsil.messages import say
from mafsil.messages.tables import number, on_screen, table

MOST_CASES = 1000


@dataclass(frozen=True, eq=False, slots=True)
class Case:
    """The job with one value of each variable.

    Attributes:
        values: by name.
        cycle: until the last move ends; NaN where it is refused [s].
        refusal: why it cannot be done, or None.
        run: what happened; None where nothing was simulated.
    """

    values: dict[str, float | str]
    cycle: float
    refusal: Refusal | None
    run: Run | None

    @property
    def numbers(self) -> tuple[float, float, float]:
        """Largest tip error [m], energy [J], largest share of an effort limit; NaN where nothing was simulated."""
        if self.run is None:
            return np.nan, np.nan, np.nan
        own = summary(self.run)
        limits = self.run.robot.limits.effort
        share = float(np.max(own.peak_effort / limits, initial=0.0))
        return own.tip_error, own.energy, share


@dataclass(frozen=True, eq=False, repr=False)
class Sweep(Answer, entries="cases"):
    """All cases; true if each can be done, iterable over them.

    Attributes:
        cases: in the order of the grid, the last variable fastest.
    """

    cases: tuple[Case, ...]

    def __bool__(self) -> bool:
        return all(case.refusal is None and (case.run is None or bool(case.run)) for case in self.cases)

    @property
    def quickest(self) -> Case | None:
        """The case with the shortest cycle of those that can be done; None if none can."""
        possible = [case for case in self.cases if case.refusal is None and (case.run is None or bool(case.run))]
        return min(possible, key=lambda case: case.cycle, default=None)

    def columns(self) -> tuple[tuple[str, ...], list[tuple[str, ...]]]:
        """Head (names of variables, then keys) and rows of the table."""
        names = tuple(self.cases[0].values)
        simulated = any(case.run is not None for case in self.cases)
        head = (*names, "cycle_s", *(("tip_mm", "energy_j", "effort_share") if simulated else ()))
        rows: list[tuple[str, ...]] = []
        for case in self.cases:
            cells = [_shown(value) for value in case.values.values()]
            cells.append("-" if np.isnan(case.cycle) else number(case.cycle))
            if simulated:
                tip, energy, share = case.numbers
                cells += ["-" if np.isnan(x) else number(x) for x in (1e3 * tip, energy, 100.0 * share)]
            rows.append(tuple(cells))
        return head, rows

    def __repr__(self) -> str:
        head, rows = self.columns()
        return "\n".join([*table(head, rows), on_screen(self.explain())])

    def explain(self, language: str | None = None) -> str:
        """How many cases can be done, which is the quickest, and why the others cannot."""
        best = self.quickest
        done = sum(case.refusal is None for case in self.cases)
        lines = [say("job.sweep", language=language, done=done, total=len(self))]
        if best is not None:
            lines.append(say("job.sweep_quickest", language=language, values=_say(best.values), cycle=best.cycle))
        for case in self.cases:
            if case.refusal is not None:
                lines.append(f"{_say(case.values)}: {case.refusal.explain(language)}")
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "cases": [
                {
                    "values": case.values, "cycle": None if np.isnan(case.cycle) else case.cycle,
                    "refusal": None if case.refusal is None else case.refusal.to_dict(),
                    **{name: None if np.isnan(x) else x
                       for name, x in zip(("tip_error", "energy", "effort_share"), case.numbers, strict=True)},
                }
                for case in self.cases
            ]
        }  # fmt: skip


def sweep(
    text: str,
    grid: Mapping[str, Sequence[float | str]],
    folder: Path,
    source: str = "<text>",
    *,
    simulate: bool = False,
    progress: Callable[[float], object] = lambda share: None,
) -> Sweep:
    """Plan a job, and drive it if wanted, for every combination of values of its variables.

    Args:
        text: of the job file; the names stand in its `[variables]`.
        grid: values by name.
        folder: to which the path of a robot file is relative.
        source: what the file is called in errors.
        simulate: whether each case is driven too.
        progress: called with the share that is done.

    Raises:
        InputError: no variable, no value, more than a thousand cases.
        MafsilError: the job or the robot cannot be read, or do not fit each other; a name that is no variable.
    """
    count = int(np.prod([len(values) for values in grid.values()], dtype=np.float64)) if grid else 0
    if not 1 <= count <= MOST_CASES:
        raise InputError("job.sweep_size", count=count, most=MOST_CASES)
    cases: list[Case] = []
    for values in product(*grid.values()):
        named = dict(zip(grid, values, strict=True))
        job = parse_job(text, source, named, folder=folder)
        planned = prepare(job, text, folder, None, source)
        plan = planned if isinstance(planned, Refusal) else planned[1]
        if simulate and not isinstance(planned, Refusal):
            plan = plan_searches(job, text, folder, source, *planned)
        if isinstance(planned, Refusal) or isinstance(plan, Refusal):
            cases.append(Case(named, np.nan, plan if isinstance(plan, Refusal) else None, None))
        else:
            run = drive(job, text, planned[0], plan, explained=False) if simulate else None
            cases.append(Case(named, plan.cycle, None, run))
        progress(len(cases) / count)
    return Sweep(tuple(cases))


def _say(values: Mapping[str, float | str]) -> str:
    return ", ".join(f"{name} = {_shown(value)}" for name, value in values.items())


def _shown(value: float | str) -> str:
    """As it is typed."""
    if isinstance(value, bool):
        return str(value).lower()
    return value if isinstance(value, str) else number(value)
