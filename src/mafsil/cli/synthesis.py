"""`mafsil synthesis`: linkages for the poses, points or function of a file, with their defects."""

from __future__ import annotations

from typing import Any

import numpy as np

from mafsil.cli.answer import Answer
from mafsil.cli.numerals import count
from mafsil.cli.table import table
from mafsil.errors import FileError, InputError
from mafsil.messages import say
from mafsil.messages.tables import number
from mafsil.mobility import FourBar
from mafsil.mobility.synthesis import Candidate, FunctionTask, Synthesis, synthesise_file

MOST_SHOWN = 12
"""Rows of the table: all linkages of a finite problem, the best ones of a family."""


def synthesis_of(file: str, candidate: str | int | None = None, picture: str | None = None) -> Answer:
    """Linkages for a task in a file.

    Args:
        file: TOML with poses, points or a function.
        candidate: number of the one that is described and drawn, from 1 on.
        picture: file to draw into.

    Raises:
        MafsilError: no such file, no task, no such candidate, a file that cannot be written.
    """
    found, task = synthesise_file(file)
    shown = 1 if candidate is None else count("candidate", str(candidate))
    if candidate is not None and not 1 <= shown <= len(found):
        raise InputError("input.whole", name="candidate", value=shown, low=1, high=len(found))
    data, lines = found.to_dict(), found.explain().split("\n")
    if found.best is not None:
        lines = lines[: 2 if found.method else 1]
        lines += table(_head(), [_row(k, one) for k, one in enumerate(found.candidates[:MOST_SHOWN])], words=(6,))
        if len(found) > MOST_SHOWN:
            lines.append(say("messages.more_rows", count=len(found) - MOST_SHOWN))
        lines += found[shown - 1].explain().split("\n")
        if task is not None:
            lines.append(_error(found, task, shown - 1, data))
    if picture is not None:
        _draw(found, shown - 1, picture)
        data["picture"] = picture
        lines.append(say("cli.picture_written", path=picture))
    return Answer(data, tuple(lines), None if found else found.explain().split("\n")[0])


def _head() -> tuple[str, ...]:
    names = ("number", "crank", "coupler", "rocker", "ground", "worst", "defects")
    return tuple(say(f"synthesis.head_{name}") for name in names)


def _row(k: int, one: Candidate) -> tuple[str, ...]:
    bar = one.linkage
    lengths = bar.lengths.tolist() if isinstance(bar, FourBar) else [bar.crank, bar.rod]
    cells = [number(each) for each in lengths] + ["-"] * (4 - len(lengths))
    defects = ", ".join(say(f"synthesis.short_{each.name.lower()}") for each in one.defects)
    return (str(k + 1), *cells, number(float(np.degrees(one.worst))), defects or say("synthesis.short_free"))


def _error(found: Synthesis, task: FunctionTask, index: int, data: dict[str, Any]) -> str:
    """The sentence about the error between the precision points; the number goes into the data."""
    largest = task.structural_error(found, index).largest
    lower, upper = task.interval
    data["structural_error"] = largest if np.isfinite(largest) else None
    if not np.isfinite(largest):
        return say("synthesis.function_gap", lower=lower, upper=upper)
    return say("synthesis.function_error", lower=lower, upper=upper, largest=largest)


def _draw(found: Synthesis, index: int, picture: str) -> None:
    from mafsil.figures.synthesis import plot_synthesis

    try:
        plot_synthesis(found, picture, index=index)
    except OSError as error:
        raise FileError("file.cannot_write", path=picture, reason=error.strerror or str(error)) from None
