"""Exported C compiled and run where a compiler is: the stored numbers must come out."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mafsil.kernels.export.exported import Export

COMPILERS = ("cc", "gcc", "clang")
STRICT = ("-std=c99", "-O2", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror")
"""No warning is forgiven."""
_SECONDS = 120.0


@dataclass(frozen=True)
class Trial:
    """What became of it.

    Attributes:
        ok: compiled without a warning, and every number within its limit.
        said: what the program printed, or the compiler's first complaint.
    """

    ok: bool
    said: str


def compiler() -> str | None:
    """Path of a C compiler: the one that the environment variable CC names, else the first that is installed."""
    chosen = os.environ.get("CC")
    for name in (chosen,) if chosen else COMPILERS:
        path = shutil.which(name)
        if path:
            return path
    return None


def trial(exported: Export, path: str, flags: Sequence[str] = STRICT) -> Trial:
    """Compile an export's sources, or link its object file, with its test program, and run that.

    Args:
        exported: from C, or an object file for this processor.
        path: of the compiler.
        flags: for the compiler.
    """
    with tempfile.TemporaryDirectory(prefix="mafsil-") as folder:
        exported.write(folder)
        parts = sorted(name for name in exported.files if name.endswith((".c", ".o")))
        program = str(Path(folder) / "trial")
        try:
            built = _run([path, *flags, *parts, "-o", program, "-lm"], folder)
            if built.returncode or built.stderr.strip():
                return Trial(False, _first_line(built.stderr))
            found = _run([program], folder)
        except (OSError, subprocess.TimeoutExpired) as error:
            return Trial(False, f"{type(error).__name__}: {error}")
    return Trial(found.returncode == 0, _first_line(found.stdout or found.stderr))


def _run(words: list[str], folder: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        words, cwd=folder, capture_output=True, check=False, timeout=_SECONDS, encoding="utf-8", errors="replace"
    )


def _first_line(text: str) -> str:
    return (text.strip().splitlines() or ["-"])[0]
