"""The catalogue: all quantities of a robot, found by listing the files of `mechanics/quantities`.

1. The files are read, as text.
2. What their rows say was kept on disk under a hash of these texts: then no file is imported, and no expression needed.
3. Otherwise the files are imported, and what their rows say is kept. Their functions are found when they are called.

So a new file is found, a changed row is read again, and a start costs a millisecond.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping
from importlib import import_module
from pathlib import Path
from types import MappingProxyType

from mafsil.code_store import FileStore, StoreKind, code_folder
from mafsil.errors import InputError
from mafsil.mechanics.quantity import Quantity, rows_of

PACKAGE = "mafsil.mechanics.quantities"
ROWS = StoreKind(b"mafsilR\0", ".sources")
"""What the rows say."""
_HERE = Path(__file__).parent


def quantity(name: str) -> Quantity:
    """The row of that name.

    Raises:
        InputError: there is none; the sentence lists the names.
    """
    if name not in CATALOGUE:
        raise InputError("input.choice", name="quantity", value=name, known=", ".join(CATALOGUE))
    return CATALOGUE[name]


def found_rows(folder: Path = _HERE / "quantities", package: str = PACKAGE) -> list[Quantity]:
    """The rows of all files of a folder, in the order of the files.

    Args:
        folder: with modules that each hold rows.
        package: dotted name of the folder.

    Raises:
        TypeError: a row without one of its attributes; which, is said.
        ValueError: two rows of one name.
    """
    # 1. the texts
    files = sorted(path for path in folder.glob("*.py") if path.stem != "__init__")
    texts = [path.read_bytes() for path in (_HERE / "quantity.py", *files)]
    names = [path.stem for path in files]
    key = hashlib.blake2b(repr((package, names, texts)).encode(), digest_size=32).hexdigest()
    # 2. as kept
    store = FileStore(code_folder(), ROWS)
    kept = store.get(key)
    if kept is not None:
        return [Quantity.of_record(record) for record in json.loads(kept)]
    # 3. as imported
    rows = [row for name in names for row in rows_of(import_module(f"{package}.{name}"))]
    if twice := {row.name for row in rows if sum(row.name == other.name for other in rows) > 1}:
        raise ValueError(f"more than one row of the name {', '.join(sorted(twice))}")
    store.put(key, json.dumps([row.record() for row in rows]).encode())
    return rows


CATALOGUE: Mapping[str, Quantity] = MappingProxyType({row.name: row for row in found_rows()})
"""All quantities by name."""
