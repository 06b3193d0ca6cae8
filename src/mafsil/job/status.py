"""How a job ended."""

from __future__ import annotations

from mafsil.answer import Status


class JobStatus(Status):
    """How a job ended."""

    DONE = ("job.status_done", True)
    FAILED = ("job.status_failed", False)
    STOPPED = ("job.status_stopped", False)
    REFUSED = ("job.status_refused", False)
