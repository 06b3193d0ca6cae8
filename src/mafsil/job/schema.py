"""The JSON Schema of job files: editors complete and check keys with it."""

from __future__ import annotations

import inspect
import json
from typing import Any

import msgspec

from mafsil.job.language import JobFile


def schema() -> dict[str, Any]:
    """JSON Schema (2020-12) of a job file: every key with its type, range and choices."""
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "mafsil job"}
    text = msgspec.json.encode(msgspec.json.schema(JobFile))
    return head | json.loads(text, object_hook=_without_margin)


def _without_margin(node: dict[str, Any]) -> dict[str, Any]:
    """The node with its docstring as read by people: msgspec 0.23 cuts the margin, 0.22 kept it."""
    words = node.get("description")
    return node | {"description": inspect.cleandoc(words)} if isinstance(words, str) else node
