"""Many runs of a job as a table: up to how large an error how many runs stay, and what the others failed by."""

from __future__ import annotations

from mafsil.job.run import Run
from mafsil.job.variation import SHARES
from mafsil.messages import say
from mafsil.messages.quantities import digits
from mafsil.report.content import Finding, Table


def variation_table(run: Run, language: str) -> Table | None:
    """A row for each quantity: what so many runs do not exceed; None where nothing was varied.

    Args:
        run: what happened.
        language: of all texts.
    """
    if run.variation is None:
        return None
    head = (say("report.variation_quantity", language=language), *(f"{digits(100.0 * share)} %" for share in SHARES))
    rows = tuple((say(f"report.variation_{name}", language=language), *cells) for name, *cells in run.variation.rows())
    return Table(head, rows)


def variation_findings(run: Run, language: str) -> tuple[Finding, ...]:
    """How many runs did the job, and what the others failed by.

    Args:
        run: what happened.
        language: of all texts.
    """
    if run.variation is None:
        return ()
    sentences = run.variation.explain(language).split("\n")
    level = "good" if run.variation else "warning"
    return (Finding(level, sentences[0]), *(Finding("good", sentence) for sentence in sentences[1:]))
