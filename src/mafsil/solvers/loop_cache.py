"""Machine code of compiled loops on disk, valid for exactly the sources that it was made from.

A loop's code contains the loops that it calls, so what names its folder is a digest of all of them; numba's own cache
asks only for the file of the loop itself and serves stale code when a callee has changed. One file per function and
types, written whole and checked before anything of it is used: processes that start together cannot mix their entries.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
import pickle
import shutil
import sys
import time
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba.core.compiler import CompileResult
from numba.core.serialize import dumps

from mafsil.code_folder import code_folder, prepare, write_whole
from mafsil.messages import say

PACKAGE = Path(__file__).resolve().parents[1]
COMPILED = "loops.py"
"""How the names of the files end whose functions are compiled, and of the one that holds the options."""
KEPT_DAYS = 14
"""Folders of other sources that nobody has used for so long are removed."""

_to_parts, _from_parts = CompileResult._reduce, CompileResult._rebuild  # pyright: ignore[reportPrivateUsage]
_SUFFIX = ".loop"
_CHECK = 32
_DAY = 86400.0


class LoopCache:
    """What numba asks before it compiles a function, and tells after.

    Args:
        function: the function before compilation.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self._name = f"{function.__module__}.{function.__qualname__}"
        kept = function.__code__.co_filename.endswith(COMPILED) and function.__closure__ is None
        self._folder = _folder() if kept else None
        self.cache_path = None if self._folder is None else str(self._folder)

    def load_overload(self, sig: Any, target_context: Any) -> CompileResult | None:
        """The code for these types, or None, whereupon it is compiled.

        Args:
            sig: types of the arguments.
            target_context: numba's.
        """
        target_context.refresh()
        found = None
        if self._folder is not None:
            # Whatever is wrong with an entry, the loop can be compiled.
            with contextlib.suppress(Exception):
                data = self._path(self._folder, sig, target_context.codegen()).read_bytes()
                if _digest(data[_CHECK:]) == data[:_CHECK]:
                    found = _from_parts(target_context, *pickle.loads(data[_CHECK:]))
        if found is None:
            _tell_once(self._folder)
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled; nothing is lost but time where the disk refuses.

        Args:
            sig: types of the arguments.
            data: numba's result of compilation.
        """
        if self._folder is None or data.library.has_dynamic_globals:
            return
        with contextlib.suppress(OSError):
            if _digest_of_sources(PACKAGE) != self._folder.name:
                return  # A file edited since this process began may be in the code, but not in the folder's name.
            if not self._folder.is_dir():
                _remove_unused(self._folder.parent)
                self._folder.mkdir(mode=0o700, parents=True, exist_ok=True)
            payload = dumps(_to_parts(data))
            write_whole(self._path(self._folder, sig, data.codegen), _digest(payload) + payload)

    def flush(self) -> None:
        """Nothing to forget: a folder's name answers for the sources of what lies in it."""

    def _path(self, folder: Path, sig: Any, codegen: Any) -> Path:
        """One file per function, types, and processor with its features."""
        words = repr((self._name, str(sig), codegen.magic_tuple()))
        return folder / f"{self._name.rpartition('.')[2]}-{_digest(words.encode()).hex()[:32]}{_SUFFIX}"


@cache
def _folder() -> Path | None:
    """Where the code of the present sources is kept, decided once in a process; None: in memory only."""
    place = code_folder()
    try:
        name = _digest_of_sources(PACKAGE)
    except OSError:
        return None
    if place is None or prepare(place):
        return None
    folder = place / "loops" / name
    with contextlib.suppress(OSError):
        if time.time() - folder.stat().st_mtime > _DAY:
            os.utime(folder)
    return folder


def _digest_of_sources(package: Path) -> str:
    """Name of the sources of all compiled loops, with the releases of numba and Python."""
    parts = [numba.__version__.encode(), (sys.implementation.cache_tag or sys.version).encode()]
    for place, folders, files in os.walk(package):
        folders[:] = sorted(name for name in folders if name != "__pycache__")
        for name in sorted(files):
            if name.endswith(COMPILED):
                path = Path(place, name)
                parts += [path.relative_to(package).as_posix().encode(), path.read_bytes()]
    return _digest(b"".join(len(part).to_bytes(8, "little") + part for part in parts)).hex()[:32]


def _digest(data: bytes) -> bytes:
    return hashlib.blake2b(data, digest_size=_CHECK).digest()


def _remove_unused(place: Path) -> None:
    """Remove the folders of sources that nobody has begun to use for long."""
    for folder in place.iterdir() if place.is_dir() else ():
        with contextlib.suppress(OSError):
            if time.time() - folder.stat().st_mtime > KEPT_DAYS * _DAY:
                shutil.rmtree(folder, ignore_errors=True)


@cache
def _tell_once(folder: Path | None) -> None:
    """That seconds pass, for whoever listens to the logger `mafsil` (the command line on a terminal does)."""
    sentence = say("solvers.compiling_unkept") if folder is None else say("solvers.compiling", path=str(folder.parent))
    logging.getLogger("mafsil").info(sentence)
