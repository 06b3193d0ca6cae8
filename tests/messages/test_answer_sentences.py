"""Every status of every answer is a sentence in both languages with what the answer fills in."""

from __future__ import annotations

import ast
import importlib
import inspect
import pkgutil
import re
import textwrap
import typing
from collections.abc import Iterator
from typing import Any

import pytest

import mafsil as mf
from mafsil.answer import Answer, Status
from mafsil.messages import LANGUAGES, placeholders

ANSWERS: dict[str, type[Answer]] = {}


def _every_answer(of: type[Answer] = Answer) -> Iterator[type[Answer]]:
    for each in of.__subclasses__():
        yield each
        yield from _every_answer(each)


for _module in pkgutil.walk_packages(mf.__path__, "mafsil."):
    if ".cli" not in _module.name and not _module.name.endswith("__main__"):
        importlib.import_module(_module.name)
for _one in _every_answer():
    if getattr(importlib.import_module(_one.__module__), _one.__name__, None) is _one:
        ANSWERS[f"{_one.__module__}.{_one.__name__}"] = _one


def _statuses(one: type[Answer]) -> list[Status]:
    """Members of the statuses that the annotation of `status` names."""
    status: Any = inspect.getattr_static(one, "status", None)
    text = str(
        status.fget.__annotations__["return"]
        if isinstance(status, property)
        else next(
            (
                vars(base).get("__annotations__", {}).get("status")
                for base in one.__mro__
                if "status" in vars(base).get("__annotations__", {})
            ),
            "",
        )
    )
    scope = vars(importlib.import_module(one.__module__))
    named = [scope[word] for word in re.findall(r"\w+", text) if isinstance(scope.get(word), type)]
    return [member for kind in named if issubclass(kind, Status) for member in kind]


def _filled_in(one: type[Answer]) -> list[set[str]]:
    """Names of the details of `self.status.sentence(...)` in an own `explain`, where no choice comes before."""
    parts = list(ast.walk(ast.parse(textwrap.dedent(inspect.getsource(one.explain)))))
    choice = min(
        (each.lineno for each in parts if isinstance(each, ast.If)), default=inspect.getsource(one).count("\n")
    )
    said = [
        each
        for each in parts
        if isinstance(each, ast.Call) and ast.unparse(each.func) == "self.status.sentence" and each.lineno < choice
    ]
    return [{str(word.arg) for word in each.keywords} for each in said if all(word.arg for word in each.keywords)]


@pytest.mark.parametrize("name", ANSWERS)
def test_each_status_finds_what_it_names(name: str) -> None:
    one = ANSWERS[name]
    own = one.explain is not Answer.explain
    for status in _statuses(one):
        for language in LANGUAGES:
            wanted = set(placeholders(status.key, language))
            for given in _filled_in(one) if own else [set(dir(one)) | set(typing.get_type_hints(one))]:
                assert wanted <= given, (status, language, wanted - given)


def test_most_answers_are_looked_at() -> None:
    looked_at = [
        one for one in ANSWERS.values() if _statuses(one) and (one.explain is Answer.explain or _filled_in(one))
    ]
    assert len(ANSWERS) > 150
    assert len(looked_at) > 80
