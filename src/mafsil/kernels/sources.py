"""What the code that builds an expression says: hashes of modules without comments, docstrings and layout.

1. The modules: the roots, and what they import within given packages, however deep in a function. A package imports
   what its stub imports: its public names.
2. Each is compiled by Python itself; its instructions, names and constants are hashed, not its lines.
3. The result is kept on disk under the bytes of the sources, so that a later process does neither.

Sources that cannot be followed in this way (a module is found by its name as text) count byte by byte.
"""

from __future__ import annotations

import hashlib
import sys
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import CodeType
from typing import Any

from mafsil.code_store import FileStore, StoreKind, code_folder
from mafsil.kernels.identity import content_key, fingerprint

SOURCES = StoreKind(b"mafsilS\0", ".sources")
"""Hashes of code."""
_DYNAMIC = frozenset(("import_module", "__import__", "exec", "eval"))


@cache
def meaning(roots: tuple[str, ...], packages: tuple[str, ...], without: tuple[str, ...] = ()) -> str:
    """Hash of the code that shapes an expression: equal hash, equal expression for equal arguments.

    Args:
        roots: dotted names of the modules whose functions build it.
        packages: dotted names of the packages within which imports are followed.
        without: modules that are left out: what is used of them is in the caller's words for the expression.
    """
    raw = fingerprint(*packages)
    places = {name: _file(name) for name in roots}
    if any(place is None for place in places.values()):
        return raw
    texts = {name: _text(place) for name, place in places.items() if place is not None}
    key = content_key(
        "sources", sys.version, raw, repr(without), *(part for name in texts for part in (name, texts[name].hex()))
    )
    store = FileStore(code_folder(), SOURCES)
    payload = store.get(key)
    if payload is None:
        payload = (_closure(texts, packages, without) or raw).encode()
        store.put(key, payload)
    return payload.decode()


def _closure(texts: dict[str, bytes], packages: tuple[str, ...], without: tuple[str, ...]) -> str | None:
    """Steps 1 and 2; None where imports cannot be followed."""
    known = {name: path for name, path in _modules(packages).items() if name not in without}
    found: dict[str, str] = {}
    waiting = dict(texts)
    while waiting:
        name, text = waiting.popitem()
        try:
            code = compile(text, name, "exec", dont_inherit=True, optimize=2)
        except (SyntaxError, ValueError):
            return None
        words: set[str] = set()
        found[name] = code_hash(code, words)
        if words & _DYNAMIC:
            return None
        for imported in known:
            package, _, last = imported.rpartition(".")
            named = imported in words or (package in words and last in words)
            if named and imported not in found and imported not in waiting:
                waiting[imported] = _text(known[imported])
    return content_key(*(f"{name} {found[name]}" for name in sorted(found)))


def code_hash(code: CodeType, words: set[str]) -> str:
    """Hash of a code object, its instructions, names and constants; adds all names that occur in it to `words`."""
    words.update(code.co_names)
    parts: list[Any] = [
        code.co_name, code.co_flags, code.co_argcount, code.co_posonlyargcount, code.co_kwonlyargcount, code.co_names,
        code.co_varnames, code.co_freevars, code.co_cellvars, code.co_code, code.co_exceptiontable,
    ]  # fmt: skip
    parts += [code_hash(x, words) if isinstance(x, CodeType) else _constant(x) for x in code.co_consts]
    return hashlib.blake2b(repr(parts).encode(), digest_size=16).hexdigest()


def _constant(value: Any) -> str:
    """Text of a constant; sets have no order of their own."""
    if isinstance(value, frozenset):
        return f"{{{', '.join(sorted(map(_constant, value)))}}}"  # pyright: ignore[reportUnknownArgumentType]
    if isinstance(value, tuple):
        return f"({', '.join(map(_constant, value))})"  # pyright: ignore[reportUnknownArgumentType]
    return f"{type(value).__name__} {value!r}"


@cache
def _modules(packages: tuple[str, ...]) -> dict[str, Path]:
    """All modules of the packages, and their files."""
    found: dict[str, Path] = {}
    for package in packages:
        spec = find_spec(package)
        for root in (spec.submodule_search_locations or ()) if spec else ():
            for path in sorted(Path(root).rglob("*.py")):
                parts = path.relative_to(root).with_suffix("").parts
                found[".".join((package, *parts)).removesuffix(".__init__")] = path
    return found


def _text(path: Path) -> bytes:
    """The code of a module; of a package, the imports of its stub as well."""
    stub = path.with_name("__init__.pyi")
    return path.read_bytes() + (b"\n" + stub.read_bytes() if path.stem == "__init__" and stub.exists() else b"")


def _file(module: str) -> Path | None:
    spec = find_spec(module)
    return Path(spec.origin) if spec and spec.origin else None
