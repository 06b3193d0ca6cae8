"""Writes docs/job.schema.json, the JSON Schema of job files: `python docs/make_job_schema.py`."""

from __future__ import annotations

import json
from pathlib import Path

from mafsil.job import schema

FILE = Path(__file__).parent / "job.schema.json"


def text() -> str:
    """What stands in the file."""
    return json.dumps(schema(), indent=1, ensure_ascii=False) + "\n"


if __name__ == "__main__":
    FILE.write_text(text(), encoding="utf-8")
