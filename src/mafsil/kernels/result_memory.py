"""Memory of large results: pages are written again instead of being fetched from the system and cleared each time.

A fresh array of many megabytes costs more than the numbers in it: the system clears every page before we may write it,
and takes it back when the array is gone. Here the pages of a result that nobody refers to any more wait for the next.

1. A result of SMALLEST bytes or more lies in a block, an anonymous private mapping with large pages where the system
   has them. Its base is a lease; every view and every buffer of the result keeps the lease alive.
2. When the last of them is gone, the lease hands its block back. The system is told that it may take the idle pages
   (MADV_FREE): under memory pressure they are the first to go, at no cost, and come back as zeros.
3. Idle blocks are bounded: at most MOST_BLOCKS, together at most an eighth of the machine's memory, or as many MiB as
   the environment variable MAFSIL_RESULT_MEMORY says; 0 takes every result from NumPy. A block beyond the bound, the
   longest idle first, goes back to the system.

Arrays of this kind do not own their data (`flags.owndata`), so NumPy does not `resize` them in place; all else is as
ever. After a fork each process has its own copy of every block. Lists change by single operations that the interpreter
does not interrupt, so no lock is held when a lease dies, whichever thread it dies in.

What the caches of this machine cannot keep until somebody reads it (`kept_bytes`) is written past them.
"""

from __future__ import annotations

import mmap
import os
from functools import cache
from math import prod
from pathlib import Path
from typing import Any

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import InputError

_LAST_LEVEL = Path("/sys/devices/system/cpu/cpu0/cache/index3/size")
_USUAL = 32 << 20
"""Bytes of a last-level cache that does not say its size."""
_LONG_ROW = 512
"""Bytes of a row from which on plain stores lose early: many lines of each of the rows of a tile are open at once."""
MEMORY_VARIABLE = "MAFSIL_RESULT_MEMORY"
"""Environment variable with the most MiB of idle results that are kept for later ones; 0 keeps none."""
SMALLEST = 4 << 20
"""Bytes from which on a result's pages come from the system one by one: NumPy's own threshold for large pages."""
MOST_BLOCKS = 4
"""Idle blocks: as many results as are usually computed in turns."""
_SHARE = 8
_PAGE = 2 << 20
"""Blocks are whole large pages: the system then aligns them, and to leave idle ones to it is one stroke for each."""
_WASTE = 2
"""A block serves results of at least half its size."""
_FREE: int | None = getattr(mmap, "MADV_FREE", None)
_LARGE_PAGES: int | None = getattr(mmap, "MADV_HUGEPAGE", None)


class Block:
    """Pages of one mapping.

    Attributes:
        size: bytes.
        address: where they begin.
    """

    __slots__ = ("_bytes", "_mapping", "address", "size")

    def __init__(self, size: int) -> None:
        """Map so many bytes.

        Raises:
            OSError: no memory.
        """
        self.size = size
        self._mapping = mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)
        if _LARGE_PAGES is not None:
            _advise(self._mapping, _LARGE_PAGES)
        self._bytes = np.frombuffer(self._mapping, np.uint8)
        self.address: int = self._bytes.ctypes.data

    def release(self) -> None:
        """Let the system take the pages if it needs them; what they hold is worth nothing."""
        if _FREE is not None:
            _advise(self._mapping, _FREE)


class _Lease:
    """What a result and all its views hold on to: as long as it lives, its block belongs to nobody else."""

    __slots__ = ("__array_interface__", "__weakref__", "_block", "_idle", "_limit")

    def __init__(self, block: Block, shape: tuple[int, ...], idle: list[Block], limit: int) -> None:
        self._block, self._idle, self._limit = block, idle, limit
        self.__array_interface__: dict[str, Any] = {
            "data": (block.address, False),
            "shape": shape,
            "typestr": "<f8",
            "version": 3,
        }

    def __del__(self) -> None:
        # Step 2. All that is needed hangs on the lease itself: at the end of the process modules are already empty.
        self._block.release()
        _keep(self._idle, self._block, self._limit)


def _keep(idle: list[Block], block: Block, limit: int, most: int = MOST_BLOCKS) -> None:
    """Step 3: the block joins the idle ones, and those that are too many go, the longest idle first."""
    idle.append(block)
    while idle and (len(idle) > most or sum([each.size for each in idle[:]]) > limit):
        try:
            idle.pop(0)
        except IndexError:  # another thread was quicker
            return


_idle: list[Block] = []


def new(shape: tuple[int, ...]) -> tuple[Floats, bool]:
    """An array of doubles with any contents, and whether its pages have been written before.

    Args:
        shape: of the array.

    Raises:
        MemoryError: there is none.
    """
    size = 8 * prod(shape)
    limit = _limit()
    if size < SMALLEST or size > limit:
        return np.empty(shape), False
    block = _idle_block(size)
    written = block is not None
    if block is None:
        try:
            block = Block(-(-size // _PAGE) * _PAGE)
        except (OSError, ValueError, OverflowError):
            return np.empty(shape), False
    return np.asarray(_Lease(block, shape, _idle, limit)), written


def _idle_block(size: int) -> Block | None:
    """An idle block that is large enough and not much larger; nobody else has it then."""
    for block in _idle[::-1]:
        if size <= block.size <= _WASTE * size + _PAGE:
            try:
                _idle.remove(block)
            except ValueError:  # another thread took it
                continue
            return block
    return None


def available() -> bool:
    """Whether idle pages can be left to the system; elsewhere every result is an array of NumPy's."""
    return _FREE is not None


def idle_bytes() -> int:
    """Bytes of the blocks that wait for a result."""
    return sum([block.size for block in _idle[:]])


def release() -> None:
    """Give all idle blocks back to the system."""
    del _idle[:]


def _limit() -> int:
    """The most bytes of idle blocks; 0 where idle pages could not be left to the system."""
    setting = os.environ.get(MEMORY_VARIABLE, "")
    if not setting:
        return _share_of_memory()
    if not setting.isascii() or not setting.isdecimal():
        raise InputError("input.whole", name=MEMORY_VARIABLE, value=setting, low=0, high=1 << 40)
    return int(setting) << 20 if _FREE is not None else 0


@cache
def _share_of_memory() -> int:
    if _FREE is None or not hasattr(os, "sysconf"):
        return 0
    try:
        return os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE") // _SHARE
    except (ValueError, OSError):
        return 0


def _advise(mapping: mmap.mmap, advice: int) -> None:
    """Advice that the system may not know; nothing depends on it."""
    try:
        mapping.madvise(advice)
    except OSError:
        return


def kept_bytes(row: int) -> int:
    """The largest result that is written through the caches; a larger one is written past them.

    Half of the last-level cache, since inputs and what the caller has in it want the other half; of long rows a
    quarter. Measured on 32 MiB: past the caches short rows win from 16 MB on, rows of 1 kB from 8 MB on; results that
    stay in the caches lose 10 to 40 % if they are written past them.

    Args:
        row: bytes of the results of one evaluation.
    """
    return last_level() // (2 if row < _LONG_ROW else 4)


@cache
def last_level() -> int:
    """Bytes of the last-level cache that this machine's cores share; the usual size where it is not known."""
    try:
        text = _LAST_LEVEL.read_text().strip()
        size = int(text.removesuffix("K").removesuffix("M")) << {"K": 10, "M": 20}.get(text[-1], 0)
    except (OSError, ValueError, IndexError):
        return _USUAL
    return size or _USUAL
