"""What decides the bits of compiled code, as text for the cache key; found without importing LLVM."""

from __future__ import annotations

import hashlib
import os
import sys
from collections.abc import Iterable
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from mafsil.kernels.layout import Signature
from mafsil.kernels.target import FEATURES_VARIABLE

_CPUINFO = "/proc/cpuinfo"
_CPU_FIELDS = (
    "vendor_id", "cpu family", "model", "model name", "stepping", "flags",
    "Features", "CPU implementer", "CPU architecture", "CPU variant", "CPU part",
)  # fmt: skip


def content_key(description: str, signature: Signature, machine: str, fingerprints: Iterable[str]) -> str:
    """Hexadecimal key of the compiled code.

    Args:
        description: the caller's words for the expression: equal words, equal expression.
        signature: ports.
        machine: target identity.
        fingerprints: of the sources, beyond this package, that shape the expression.
    """
    parts = (
        description,
        repr(signature),
        machine,
        fingerprint("mafsil.kernels", "mafsil.expression"),
        toolchain(),
        *fingerprints,
    )
    hashed = hashlib.blake2b(digest_size=32)
    for part in parts:
        text = part.encode()
        hashed.update(len(text).to_bytes(8, "little") + text)
    return hashed.hexdigest()


@cache
def fingerprint(*packages: str) -> str:
    """Hash of all source files of packages, such as `mafsil.mechanics`: changed code, changed kernels.

    Args:
        packages: dotted names; they are looked up, not imported (their parents are).
    """
    hashed = hashlib.blake2b(digest_size=16)
    for package in packages:
        for root in _roots(package):
            for path in sorted(root.rglob("*.py")):
                source = path.read_bytes()
                hashed.update(f"{package} {path.relative_to(root)} {len(source)}\n".encode() + source)
    return hashed.hexdigest()


@cache
def toolchain() -> str:
    """Release of llvmlite, which carries its LLVM, by the files that are installed."""
    return " ".join((_stamp("llvmlite", "_version.py", "binding"), sys.byteorder))


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
        from mafsil.kernels import target

        return target.host("").identity
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
