"""Writes docs/map.md, a line per package, docs/map.csv, a line per module and quantity, docs/names.md, one per name.

All in the first sentences of their docstrings.

python docs/make_map.py          writes them
python docs/make_map.py --check  fails if one is not what would be written
"""

from __future__ import annotations

import ast
import csv
import inspect
import sys
import tomllib
from collections.abc import Iterable, Iterator
from importlib import import_module
from io import StringIO
from pathlib import Path

from mafsil import Robot
from mafsil.lazy_module import public_names
from mafsil.mechanics.catalogue import CATALOGUE

DOCS = Path(__file__).parent
SOURCE = DOCS.parent / "src" / "mafsil"


def layers() -> list[str]:
    """Packages, lowest layer first, as pyproject.toml orders them; single modules of the house are not listed."""
    contracts = tomllib.loads((DOCS.parent / "pyproject.toml").read_text("utf-8"))["tool"]["importlinter"]["contracts"]
    order = next(contract["layers"] for contract in contracts if contract["type"] == "layers")
    names = [name.strip().removeprefix("mafsil.") for layer in reversed(order) for name in layer.split("|")]
    return [name for name in names if (SOURCE / name).is_dir()]


def main() -> int:
    """Write or check the pages and the table."""
    rows = [*_quantities(), *(row for package in layers() for row in _modules(SOURCE / package))]
    pages = {"map.md": "\n".join(_lines()) + "\n", "map.csv": _table(rows), "names.md": "\n".join(_names()) + "\n"}
    if "--check" in sys.argv:
        return int(any((DOCS / name).read_text("utf-8") != text for name, text in pages.items()))
    for name, text in pages.items():
        (DOCS / name).write_text(text, "utf-8")
    return 0


def _lines() -> list[str]:
    lines = ["# Map of the source", ""]
    lines += [
        "Made by `docs/make_map.py` from the first sentences of the files. One line per module and per quantity of a"
    ]
    lines += ["robot: [map.csv](map.csv) (name, what, file).", ""]
    lines += ["The packages of `src/mafsil`, lowest layer first; each imports only from those above it:", ""]
    lines += ["| package | files | what |", "|---|---|---|"]
    for package in layers():
        (_, sentence, _), *rest = _modules(SOURCE / package)
        lines.append(f"| `{package}` | {1 + len(rest)} | {sentence} |")
    return lines


def _names() -> Iterator[str]:
    """Every name of every face once: where it stands highest, with the first sentence of its docstring."""
    yield from (
        "# Public names",
        "",
        "Made by `docs/make_map.py`. Each name is listed once, in the package where it is found first.",
        "",
    )
    stubs = sorted(SOURCE.rglob("__init__.pyi"), key=lambda stub: (len(stub.parts), stub))
    seen: set[int] = set()
    for stub in stubs:
        package = ".".join(stub.parent.relative_to(SOURCE.parent).parts)
        things = {name: getattr(import_module(package), name) for name in public_names(import_module(package))}
        new = {name: thing for name, thing in things.items() if id(thing) not in seen and _has_meaning(thing)}
        seen |= {id(thing) for thing in new.values()}
        yield from _section(package, new)
    members = {name: getattr(Robot, name) for name in dir(Robot) if not name.startswith("_")}
    yield from _section("Robot", {name: thing for name, thing in members.items() if _has_meaning(thing)})


def _has_meaning(thing: object) -> bool:
    named = inspect.isroutine(thing) or inspect.isclass(thing) or inspect.ismodule(thing) or isinstance(thing, property)
    return bool((named or type(thing).__module__.startswith("mafsil")) and inspect.getdoc(thing))


def _section(title: str, things: dict[str, object]) -> list[str]:
    rows = [f"| `{name}` | {_sentence(thing)} |" for name, thing in sorted(things.items())]
    return [f"## {title}", "", "| name | meaning |", "|---|---|", *rows, ""] if rows else []


def _sentence(thing: object) -> str:
    return (inspect.getdoc(thing) or "").partition("\n")[0].replace("|", "\\|")


def _quantities() -> Iterator[tuple[str, str, str]]:
    for row in CATALOGUE.values():
        yield f"robot.{row.name}", row.title, f"{row.home.removeprefix('mafsil.').replace('.', '/')}.py"


def _modules(package: Path) -> list[tuple[str, str, str]]:
    rows: list[tuple[str, str, str]] = []
    for path in sorted(package.rglob("*.py"), key=lambda path: (path != package / "__init__.py", path)):
        sentence = (ast.get_docstring(ast.parse(path.read_text("utf-8"))) or "").partition("\n")[0]
        file = path.relative_to(SOURCE)
        dotted = ".".join(["mafsil", *file.with_suffix("").parts]).removesuffix(".__init__")
        if sentence:
            rows.append((dotted, sentence, file.as_posix()))
    return rows


def _table(rows: Iterable[tuple[str, str, str]]) -> str:
    text = StringIO()
    csv.writer(text, lineterminator="\n").writerows([("name", "what", "file"), *rows])
    return text.getvalue()


if __name__ == "__main__":
    raise SystemExit(main())
