"""Writes src/mafsil/robot/routines.pyi: what type checkers and editors know of a robot's quantities.

python docs/make_robot_stub.py          writes the stub
python docs/make_robot_stub.py --check  fails if the stub is not what would be written
"""

from __future__ import annotations

import sys
from pathlib import Path
from textwrap import indent

from mafsil.mechanics.catalogue import CATALOGUE
from mafsil.mechanics.quantity import Quantity

STUB = Path(__file__).parents[1] / "src" / "mafsil" / "robot" / "routines.pyi"
HEAD = """# Made by docs/make_robot_stub.py from the files of mechanics/quantities.
from inspect import Signature
from typing import Any

from numpy.typing import ArrayLike

from mafsil.arrays import Floats
from mafsil.kernels.lazy import lazy
from mafsil.mechanics.quantity import Quantity
from mafsil.model import Mechanism

def signature_of(row: Quantity) -> Signature: ...

class Routine(lazy[Any]):
    row: Quantity
    def __init__(self, row: Quantity) -> None: ...

class Motionless:
    def __init__(self, mechanism: Mechanism, name: str) -> None: ...
    def __call__(self, q: ArrayLike, *, frame: str | None = None, out: Floats | None = None) -> Floats: ...

class Routines:
"""


def main() -> int:
    """Write or check the stub."""
    text = HEAD + "\n".join(_method(row) for row in CATALOGUE.values())
    if "--check" in sys.argv:
        return int(STUB.read_text("utf-8") != text)
    STUB.write_text(text, "utf-8")
    return 0


def _method(row: Quantity) -> str:
    named = ["frame: str | None = None"] if row.framed else []
    lines = [
        "self",
        *(f"{name}: ArrayLike" for name in row.inputs),
        *(f"{name}: ArrayLike | None = None" for name in row.optional),
        "*",
        *named,
        "out: Floats | None = None",
        "threads: int | None = None",
        "degrees: bool = False",
    ]
    arguments = "".join(f"        {line},\n" for line in lines)
    doc = indent(f'"""{row.doc()}\n"""', "        ", lambda line: bool(line.strip()))
    return f"    def {row.name}(\n{arguments}    ) -> Floats:\n{doc}\n"


if __name__ == "__main__":
    raise SystemExit(main())
