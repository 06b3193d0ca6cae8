"""Acceptance cases that remember which of their keys were read, and the guard that all of them are."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

TOLD = {"id", "section", "slide", "source", "op", "what", "how", "note", "name", "tol"}
"""Keys that tell about a case and state nothing to be checked."""


class Watched(Mapping[str, Any]):
    """A mapping of a case; nested mappings, in lists too, are watched as well."""

    def __init__(self, content: Mapping[str, Any], place: str) -> None:
        self.place = place
        self.content = {key: _watched(value, f"{place}.{key}") for key, value in content.items()}
        self.read: set[str] = set()

    def __getitem__(self, key: str) -> Any:
        self.read.add(key)
        return self.content[key]

    def __iter__(self) -> Iterator[str]:
        return iter(self.content)

    def __len__(self) -> int:
        return len(self.content)

    def unread(self) -> list[str]:
        """Places of all keys that nobody has looked at."""
        found = [f"{self.place}.{key}" for key in self.content if key not in self.read | TOLD]
        return found + [place for value in self.content.values() for place in _unread(value)]


def _watched(value: Any, place: str) -> Any:
    if isinstance(value, dict):
        return Watched(value, place)
    if isinstance(value, list) and any(isinstance(entry, dict) for entry in value):
        return [_watched(entry, f"{place}[{k}]") for k, entry in enumerate(value)]
    return value


def _unread(value: Any) -> list[str]:
    if isinstance(value, Watched):
        return value.unread()
    return [place for entry in value for place in _unread(entry)] if isinstance(value, list) else []


def cases(*files: str) -> dict[str, Watched]:
    """The cases of files beside this one, by the first word of their names."""
    found: dict[str, Watched] = {}
    for file in files:
        content = json.loads(Path(__file__).with_name(file).read_text("utf-8"))
        found |= {case["id"].split()[0]: Watched(case, case["id"].split()[0]) for case in content}
    return found


def unread_after(tests: Mapping[str, Any], given: Mapping[str, Watched]) -> list[str]:
    """What stays unread when every test function without arguments of a module has run.

    They run again only where something is unread: what tests read before counts.

    Args:
        tests: the module's globals; functions whose name begins with `test_` and that take no argument are called.
        given: its cases.
    """
    for name, function in list(tests.items()):
        if not any(case.unread() for case in given.values()):
            break
        if name.startswith("test_") and callable(function) and not function.__code__.co_argcount:
            function()
    return [place for case in given.values() for place in case.unread()]
