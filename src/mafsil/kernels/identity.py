"""What decides the operations of a kernel and the bits of its code, as keys; found without LLVM.

Two levels: words for an expression lead to its tape (`tape_key`), the tape leads to machine code (`object_key`). When
the sources of expressions are edited, tapes are made anew, and where they come out the same, so does the key of the
code.
"""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterable, Iterator
from functools import cache
from importlib.util import find_spec
from pathlib import Path

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
