"""`mafsil sweep`: a job for many values of its variables."""

from __future__ import annotations

from pathlib import Path

from mafsil.cli.answer import Answer, Laid
from mafsil.cli.numerals import typed_value
from mafsil.cli.progress import Progress
from mafsil.cli.table import table
from mafsil.errors import InputError
from mafsil.job.sweep import sweep as swept
from mafsil.job.text import text_of
from mafsil.messages import say


def sweep(job: str, over: list[str], simulate: bool, progress: bool) -> Answer:
    """Every combination of values.

    Args:
        job: path of the file.
        over: `name=value,value,...` of variables of the job.
        simulate: drive each case too.
        progress: print progress even when stderr is no terminal.

    Raises:
        MafsilError: the job or the robot cannot be read, or do not fit each other; a name that is no variable.
    """
    path = Path(job)
    with Progress(progress) as bar:
        bar.enter("stage_planning")
        grid = dict(map(_values, over))
        found = swept(text_of(path), grid, path.parent, path.name, simulate=simulate, progress=bar.update)
    head, rows = found.columns()
    shown = [name if name in grid else say(f"cli.sweep_{name}") for name in head]
    lines = [*(Laid(line) for line in table(shown, rows)), *found.explain().splitlines()]
    return Answer(found.to_dict(), tuple(lines))


def _values(words: str) -> tuple[str, list[bool | float | str]]:
    """Name and values of `name=value,value`."""
    name, equals, values = words.partition("=")
    parts = [part.strip() for part in values.split(",") if part.strip()]
    if not equals or not name.strip() or not parts:
        raise InputError("cli.sweep_values", given=words)
    return name.strip(), [typed_value(part) for part in parts]
