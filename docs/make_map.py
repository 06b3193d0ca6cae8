"""Writes docs/map.md: one line per module and per quantity, from their own first sentences, so that it cannot rot.

python docs/make_map.py          writes the page
python docs/make_map.py --check  fails if the page is not what would be written
"""

from __future__ import annotations

import ast
import sys
import tomllib
from pathlib import Path

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
    """Write or check the page."""
    page = "\n".join(_lines()) + "\n"
    path = DOCS / "map.md"
    if "--check" in sys.argv:
        return int(path.read_text("utf-8") != page)
    path.write_text(page, "utf-8")
    return 0


def _lines() -> list[str]:
    lines = ["# Where is ...?", "", "Made by `docs/make_map.py` from the first sentence of every module.", ""]
    lines += ["## Quantities of a robot", "", "| name | what | file |", "|---|---|---|"]
    for row in CATALOGUE.values():
        module = row.home.removeprefix("mafsil.").replace(".", "/")
        lines.append(f"| `robot.{row.name}` | {row.title.replace('|', '&#124;')} | `{module}.py` |")
    lines += ["", "## Modules, lowest layer first", ""]
    for package in layers():
        lines += [f"### {package}", "", *_modules(SOURCE / package), ""]
    return lines[:-1]


def _modules(package: Path) -> list[str]:
    rows: list[str] = []
    for path in sorted(package.rglob("*.py")):
        sentence = (ast.get_docstring(ast.parse(path.read_text("utf-8"))) or "").partition("\n")[0]
        if sentence:
            name = path.relative_to(SOURCE).as_posix()
            rows.append(f"- `{name}`: {sentence}")
    return rows


if __name__ == "__main__":
    raise SystemExit(main())
