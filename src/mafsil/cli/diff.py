"""`mafsil diff`: what changed between the results of two runs."""

from __future__ import annotations

from mafsil.cli.answer import Answer
from mafsil.report import compare_results


def diff(before: str, after: str) -> Answer:
    """The differences between the results of two runs.

    Args:
        before: folder of the first, or its results.json.
        after: of the second.

    Raises:
        FileError: one of them is no result of a run.
    """
    found = compare_results(before, after)
    return Answer(found.to_dict(), tuple(found.explain().splitlines()))
