"""The JSON Schema of job files: editors complete and check keys with it."""

from __future__ import annotations

import json
from typing import Any

import msgspec

from mafsil.job.language import JobFile


def schema() -> dict[str, Any]:
    """JSON Schema (2020-12) of a job file: every key with its type, range and choices."""
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "mafsil job"}
    return head | json.loads(msgspec.json.encode(msgspec.json.schema(JobFile)))
