"""Machine code of compiled loops on disk, valid for exactly the sources that it was made from.

A loop's code contains the loops that it calls, so its key covers all of them; numba's own cache asks only for the file
of the loop itself and serves stale code when a callee has changed. The entries lie beside those of the kernels, in the
same form (`code_store`): whole or absent, bound to their key, read only where nobody else could have written them.
"""

from __future__ import annotations

import contextlib
import hashlib
import logging
import os
import sys
from collections.abc import Callable
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numba

from mafsil.code_store import FileStore, Kind, code_folder
from mafsil.messages import say
from mafsil.solvers import loop_entry

PACKAGE = Path(__file__).resolve().parents[1]
COMPILED = ("loops.py", "tolerances.py")
"""How the names of the files end whose functions are compiled, of the one with the options, and of those that hold
the numbers that stand in the code."""
LOOP = Kind(b"mafsilL\0", ".loop")


class LoopCache:
    """What numba asks before it compiles a function, and tells after.

    Args:
        function: the function before compilation.
    """

    def __init__(self, function: Callable[..., Any]) -> None:
        self._name = f"{function.__module__}.{function.__qualname__}"
        kept = function.__code__.co_filename.endswith(COMPILED) and function.__closure__ is None
        self._sources = _sources() if kept else None
        self.cache_path = None

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """The code for these types, or None, whereupon it is compiled.

        Args:
            sig: types of the arguments.
            target_context: numba's.
        """
        target_context.refresh()
        found = None
        store = _store()
        if self._sources is not None:
            key = self._key(sig, target_context.codegen())
            payload = store.get(key)
            if payload is not None:
                try:
                    found = loop_entry.read(payload, tuple(sig), target_context)
                except Exception:  # Whatever is wrong with an entry, the loop can be compiled.
                    store.discard(key)
        if found is None:
            _tell_once(store.directory)
        return found

    def save_overload(self, sig: Any, data: Any) -> None:
        """Keep what was compiled; nothing is lost but time where the disk refuses.

        Args:
            sig: types of the arguments.
            data: numba's result of compilation.
        """
        if self._sources is None or data.library.has_dynamic_globals:
            return
        with contextlib.suppress(OSError, loop_entry.NotPlain):
            # A file edited since this process began may be in the code, but not in the key.
            if _digest_of_sources(PACKAGE) == self._sources:
                _store().put(self._key(sig, data.codegen), loop_entry.written(data))

    def flush(self) -> None:
        """Nothing to forget: a key answers for the sources of its entry."""

    def _key(self, sig: Any, codegen: Any) -> str:
        """One entry per function, types, and processor with its features."""
        return _digest(repr((self._sources, self._name, str(sig), codegen.magic_tuple())).encode())


@cache
def _store() -> FileStore:
    return FileStore(code_folder(), LOOP)


@cache
def _sources() -> str | None:
    """Name of the present sources, taken once in a process; None if they cannot be read."""
    try:
        return _digest_of_sources(PACKAGE)
    except OSError:
        return None


def _digest_of_sources(package: Path) -> str:
    """Name of the sources of all compiled loops, with the releases of numba, LLVM and Python."""
    releases = (numba.__version__, version("llvmlite"), sys.implementation.cache_tag or sys.version)
    parts = [release.encode() for release in releases]
    for place, folders, files in os.walk(package):
        folders[:] = sorted(name for name in folders if name != "__pycache__")
        for name in sorted(files):
            if name.endswith(COMPILED):
                path = Path(place, name)
                parts += [path.relative_to(package).as_posix().encode(), path.read_bytes()]
    return _digest(b"".join(len(part).to_bytes(8, "little") + part for part in parts))


def _digest(data: bytes) -> str:
    return hashlib.blake2b(data, digest_size=32).hexdigest()


@cache
def _tell_once(folder: Path | None) -> None:
    """That seconds pass, for whoever listens to the logger `mafsil` (the command line on a terminal does)."""
    sentence = say("solvers.compiling_unkept") if folder is None else say("solvers.compiling", path=str(folder))
    logging.getLogger("mafsil").info(sentence)
