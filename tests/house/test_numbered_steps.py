"""Compiled loops say their algorithm: what is long has numbered steps, and the numbers stand in the code."""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

import pytest

SOURCE = Path(__file__).parents[2] / "src" / "mafsil"
LONG = 30
"""Lines of a loop without its docstring from which on it has steps."""
TABLES = {"ik/redundant/interval_loops.py: plain"}
"""Long lists of cases, one line each, in which nothing comes after anything."""
LOOPS = sorted(SOURCE.rglob("*loops.py"))


def _long_loops(path: Path) -> Iterator[tuple[str, str, str]]:
    """Name, docstring and text of the long compiled functions of a file."""
    text = path.read_text("utf-8")
    lines = text.splitlines()
    for node in ast.parse(text).body:
        if not isinstance(node, ast.FunctionDef) or not {"compiled", "reordered", "uncounted", "inlined"} & {
            ast.unparse(decorator) for decorator in node.decorator_list
        }:
            continue
        docstring = ast.get_docstring(node) or ""
        assert node.end_lineno is not None
        if node.end_lineno - node.lineno - len(docstring.splitlines()) > LONG:
            yield node.name, docstring, "\n".join(lines[node.body[0].lineno : node.end_lineno])


def test_there_are_loops() -> None:
    assert sum(len(list(_long_loops(path))) for path in LOOPS) > 30


@pytest.mark.parametrize("path", LOOPS, ids=lambda path: path.relative_to(SOURCE).as_posix())
def test_long_loops_number_their_steps(path: Path) -> None:
    module = ast.get_docstring(ast.parse(path.read_text("utf-8"))) or ""
    for name, docstring, text in _long_loops(path):
        if f"{path.relative_to(SOURCE).as_posix()}: {name}" in TABLES:
            continue
        numbered = [docs for docs in (docstring, module) if re.search(r"^ *1\.? ", docs, re.MULTILINE)]
        assert numbered, f"{name} is long and says no steps"
        assert re.search(r"#.*\b\d\b", text), f"{name}: the numbers of the steps do not stand in the code"
