"""How the run ended whose recording a file is: what stands beside it says so."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any, cast

from mafsil.errors import InputError
from mafsil.job.status import JobStatus
from mafsil.regular_file import whole_text
from mafsil.simulation.recording import SimulationStatus

MOST_BYTES = 50_000_000
"""Of a file that says how a run ended."""


def require_success(recording: Path) -> None:
    """Refuse the recording of a run that did not reach its end, or of a job that failed.

    Args:
        recording: a CSV file; its notes (`recording.json`) and the results of its job (`results.json`) are looked for
            beside it.

    Raises:
        InputError: the run failed; the sentence says how.
    """
    note = _status(recording.with_suffix(".json"))
    if note in SimulationStatus.__members__ and not SimulationStatus[note].succeeded:
        raise InputError("cli.trajectory_failed_run", file=str(recording), status=note.lower())
    result = _status(recording.with_name("results.json")) if recording.stem == "recording" else ""
    if result.upper() in JobStatus.__members__ and not JobStatus[result.upper()].succeeded:
        raise InputError("cli.trajectory_failed_run", file=str(recording), status=result)


def _status(path: Path) -> str:
    """The status that a file of ours holds; empty for any other file, or none."""
    try:
        data = json.loads(whole_text(path, MOST_BYTES))
    except (OSError, ValueError, RecursionError):
        return ""
    status = cast("dict[str, Any]", data).get("status") if isinstance(data, dict) else None
    return status if isinstance(status, str) else ""
