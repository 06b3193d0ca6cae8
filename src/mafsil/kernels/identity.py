"""What decides the operations of a kernel and the bits of its code, as keys; found without LLVM.

Two levels: words for an expression lead to its tape (`tape_key`), the tape leads to machine code (`object_key`). When
the sources of expressions are edited, tapes are made anew, and where they come out the same, so does the key of the
code. What sources say (`meaning`) are hashes of modules without comments, docstrings and layout:

1. The modules: the roots, and what they import within given packages, however deep in a function. A package imports
   what its stub imports: its public names.
2. Each is compiled by Python itself; its instructions, names and constants are hashed, not its lines.
3. The result is kept on disk under the bytes of the sources, so that a later process does neither.

Sources that cannot be followed in this way (a module is found by its name as text) count byte by byte.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path
from types import CodeType
from typing import Any

from mafsil.code_store import FileStore, StoreKind, code_folder
from mafsil.kernels.layout import Signature
from mafsil.kernels.target import FEATURES_VARIABLE, host

_CPUINFO = "/proc/cpuinfo"
_CPU_FIELDS = (
    "vendor_id", "cpu family", "model", "model name", "stepping", "flags",
    "Features", "CPU implementer", "CPU architecture", "CPU variant", "CPU part",
)  # fmt: skip


def tape_key(description: str, signature: Signature, fingerprints: Iterable[str]) -> str:
    """Key of the reduced tape of an expression.

    Args:
        description: the caller's words for the expression: equal words, equal expression.
        signature: ports.
        fingerprints: of the sources, beyond this package, that shape the expression.
    """
    return content_key("tape", description, repr(signature), fingerprint("mafsil.kernels"), tracer(), *fingerprints)


def object_key(part: str, content: str, signature: Signature, machine: str) -> str:
    """Key of machine code.

    Args:
        part: which entries it holds.
        content: hash of the tape; empty for code that is the same for all kernels of these shapes.
        signature: ports; their names do not count.
        machine: target identity.
    """
    shapes = repr([[port.shape for port in side] for side in (signature.inputs, signature.outputs)])
    return content_key("object", part, content, shapes, machine, fingerprint("mafsil.kernels"), toolchain())


def content_key(*parts: str) -> str:
    """64 hexadecimal digits that differ when any of the parts does."""
    hashed = hashlib.blake2b(digest_size=32)
    for part in parts:
        text = part.encode()
        hashed.update(len(text).to_bytes(8, "little") + text)
    return hashed.hexdigest()


@cache
def fingerprint(*packages: str) -> str:
    """Hash of all source files and stubs of packages, such as `mafsil.mechanics`: changed code, changed kernels.

    Args:
        packages: dotted names; they are looked up, not imported (their parents are).
    """
    hashed = hashlib.blake2b(digest_size=16)
    for package in packages:
        for root in _roots(package):
            for names in sorted(_sources(root, ())):
                with open(os.path.join(root, *names), "rb") as file:
                    source = file.read()
                hashed.update(f"{package} {'/'.join(names)} {len(source)}\n".encode() + source)
    return hashed.hexdigest()


def _sources(folder: Path | str, names: tuple[str, ...]) -> Iterator[tuple[str, ...]]:
    """Names of folders and file of all source files and stubs below a folder; pathlib takes ten times as long."""
    with os.scandir(folder) as entries:
        for entry in entries:
            if entry.is_dir():
                yield from _sources(entry.path, (*names, entry.name))
            elif entry.name.endswith((".py", ".pyi")):
                yield (*names, entry.name)


@cache
def toolchain() -> str:
    """The release of llvmlite, which carries its LLVM, by the files that are installed."""
    return f"{_stamp('llvmlite', '_version.py', 'binding')} {sys.byteorder}"


def python() -> str:
    """The release of Python, as its instructions know it."""
    return sys.implementation.cache_tag or sys.version


@cache
def tracer() -> str:
    """Hash of the sources that make expressions."""
    return fingerprint("mafsil.expression")


def machine() -> str:
    """The processor of this computer and the changes to its features that the environment asks for."""
    changes = os.environ.get(FEATURES_VARIABLE, "")
    return f"{sys.platform} {_processor()} {changes}"


@cache
def _processor() -> str:
    try:
        with open(_CPUINFO, "rb") as file:
            first = file.read(8192).split(b"\n\n")[0].decode("utf-8", "replace")
    except OSError:
        first = ""
    fields = dict(line.split(":", 1) for line in first.splitlines() if ":" in line)
    known = [f"{name}={fields[key].strip()}" for key in fields if (name := key.strip()) in _CPU_FIELDS]
    if not any(entry.startswith(("flags=", "Features=")) for entry in known):
        return host("").identity
    return f"{os.uname().machine} " + ";".join(known)


def _roots(package: str) -> list[Path]:
    spec = find_spec(package)
    if spec is None:
        return []
    if spec.submodule_search_locations:
        return [Path(place) for place in spec.submodule_search_locations]
    return []


def _stamp(package: str, *files: str) -> str:
    """Name, and size and contents of small files or sizes of large ones."""
    hashed = hashlib.blake2b(digest_size=8)
    for root in _roots(package):
        for name in files:
            for path in sorted((root / name).glob("*.so")) if (root / name).is_dir() else [root / name]:
                size = path.stat().st_size if path.exists() else 0
                hashed.update(f"{name} {size}\n".encode() + (path.read_bytes() if 0 < size < 65536 else b""))
    return f"{package}:{hashed.hexdigest()}"


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
