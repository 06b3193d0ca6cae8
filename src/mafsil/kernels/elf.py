"""A linker for the one kind of object file that our kernels are, so that cached code starts without loading LLVM.

Kernels call what all of them share, loops call each other and a few functions of the system, so linking is short:

1. Read the table of sections: where each lies in the file, its size, alignment and rights (`_sections`).
2. Lay out what is needed at run time in one range of memory, code, constants and variables on pages apart (`_layout`).
3. Reserve that range, private to the process.
4. Give every symbol its address there (`_symbols`).
5. Copy the sections (`_fill`) and write the addresses into them that the compiler left open: relocations, absolute of
   64 bits or relative to their own place of 32 (`_relocate`).
6. Set the rights of the pages: read-execute, read-only or read-write, never writable code.

Whatever is not known here is declined and goes to LLVM's own loader (`target.load`), and so does everything where
MAFSIL_LINKER=llvm. It is worth its lines: loading LLVM for a kernel from the cache takes 0.05 to 0.2 s of every start
of a program.

Reference: Tool Interface Standard, Executable and Linking Format, 1995; System V ABI, AMD64 supplement, sec. 4.4.
"""

from __future__ import annotations

import ctypes
import mmap
import os
import struct
import sys
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np

from mafsil.kernels.target import Code

LINKER_VARIABLE = "MAFSIL_LINKER"
"""Environment variable: `llvm` leaves all code to LLVM's own loader, as on other systems and processors."""
_FILE = struct.Struct("<16sHHIQQQIHHHHHH")
_SECTION = struct.Struct("<IIQQQQIIQQ")
_SYMBOL = np.dtype(
    [("name", "<u4"), ("info", "u1"), ("other", "u1"), ("section", "<u2"), ("value", "<u8"), ("size", "<u8")]
)
_RELOCATION = np.dtype([("offset", "<u8"), ("info", "<u8"), ("addend", "<i8")])
_RELOCATABLE, _X86_64 = 1, 62
_PROGRAM, _SYMBOLS, _RELOCATIONS, _ZEROS = 1, 2, 4, 8
_WRITE, _ALLOCATE, _EXECUTE = 1, 2, 4
_ABSOLUTE64 = (1,)
_RELATIVE32 = (2, 4)  # R_X86_64_PC32, R_X86_64_PLT32
_JUMP = 16
"""Bytes of a jump to a function outside."""
_READ_ONLY, _READ_WRITE, _READ_EXECUTE = 1, 3, 5


@dataclass(frozen=True)
class _Section:
    kind: int
    flags: int
    offset: int
    size: int
    link: int
    info: int
    align: int


def load(code: bytes, symbols: Iterable[str], imports: Mapping[str, int] | None = None) -> Code | None:
    """Loaded code with the addresses of `symbols`, or None if this is no job for this linker.

    Args:
        code: verified object code.
        symbols: needed names.
        imports: addresses of functions outside that the code may call.
    """
    if not _here() or os.environ.get(LINKER_VARIABLE) == "llvm":
        return None
    try:
        sections = _sections(code)  # 1.
        missing = _missing(code, sections)
        places, spans, size = _layout(sections, _JUMP * len(missing))  # 2.
        memory = mmap.mmap(-1, size, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS)  # 3.
        base = ctypes.addressof(ctypes.c_char.from_buffer(memory))
        # 4.
        values, names = _symbols(code, sections, places, base)
        jumps = base + spans[0][1] - _JUMP * len(missing)
        for number, (index, name) in enumerate(missing.items()):
            values[index] = jumps + _JUMP * number
            memory[values[index] - base : values[index] - base + _JUMP] = _jump((imports or {})[name])
        needed = {name: int(values[names[name]]) for name in symbols}
        # 5.
        if not _fill(code, sections, places, memory, base, values):
            return None
    except (_UnknownError, StopIteration, struct.error, KeyError, ValueError, IndexError, OSError):
        return None
    # 6.
    protect = _protect()
    if any(protect(base + start, length, mode) for start, length, mode in spans):
        return None
    return Code(needed, memory)


class _UnknownError(Exception):
    """Something that the kernels of this package never contain."""


@cache
def _here() -> bool:
    """Whether this is the one system whose object files and page rights are known here."""
    return sys.platform == "linux" and os.uname().machine == "x86_64" and struct.calcsize("P") == 8


@cache
def _protect() -> Any:
    function = ctypes.CDLL(None, use_errno=True).mprotect
    function.argtypes = (ctypes.c_void_p, ctypes.c_size_t, ctypes.c_int)
    return function


def _sections(code: bytes) -> list[_Section]:
    """Step 1; the file must be a relocatable object for x86-64, 64 bits, little-endian."""
    ident, kind, machine, _, _, _, start, _, _, _, _, size, count, _ = _FILE.unpack_from(code)
    if ident[:6] != b"\x7fELF\x02\x01" or (kind, machine, size) != (_RELOCATABLE, _X86_64, _SECTION.size):
        raise _UnknownError
    rows = _SECTION.iter_unpack(code[start : start + count * size])
    return [_Section(r[1], r[2], r[4], r[5], r[6], r[7], max(r[8], 1)) for r in rows]


def _layout(sections: list[_Section], jumps: int) -> tuple[dict[int, int], list[tuple[int, int, int]], int]:
    """Offset of every section that is loaded, and (start, length, protection) of the page spans.

    Args:
        sections: of the file.
        jumps: bytes for those to functions outside, at the end of the first span, of the code.
    """
    places: dict[int, int] = {}
    spans: list[tuple[int, int, int]] = []
    end = 0
    for flag, mode in ((_EXECUTE, _READ_EXECUTE), (0, _READ_ONLY), (_WRITE, _READ_WRITE)):
        start = end
        for index, section in enumerate(sections):
            loaded = section.flags & _ALLOCATE and section.kind in (_PROGRAM, _ZEROS)
            if loaded and section.flags & (_EXECUTE | _WRITE) == flag:  # Code may refer to an empty one too.
                end = -(-end // section.align) * section.align
                places[index] = end
                end += section.size
                if section.align > mmap.PAGESIZE:
                    raise _UnknownError
        end += jumps if flag == _EXECUTE else 0
        end = -(-end // mmap.PAGESIZE) * mmap.PAGESIZE
        if end > start:
            spans.append((start, end - start, mode))
    if not end:
        raise _UnknownError
    return places, spans, end


def _symbols(code: bytes, sections: list[_Section], places: dict[int, int], base: int) -> tuple[Any, dict[str, int]]:
    """Address of every symbol (0 where it is not in memory), and the global names."""
    table = next(s for s in sections if s.kind == _SYMBOLS)
    texts = sections[table.link]
    rows = np.frombuffer(code, _SYMBOL, table.size // _SYMBOL.itemsize, table.offset)
    starts = np.zeros(len(sections), dtype=np.int64)
    for section, place in places.items():
        starts[section] = base + place
    inside = rows["section"] < len(sections)
    found = np.where(inside, starts[np.where(inside, rows["section"], 0)], 0)
    values = np.where(found, found + rows["value"].astype(np.int64), 0)
    names: dict[str, int] = {}
    for index in np.flatnonzero((rows["info"] >> 4).astype(bool) & (values != 0)).tolist():
        start = texts.offset + int(rows["name"][index])
        names[code[start : code.index(b"\0", start)].decode()] = index
    return values, names


def _missing(code: bytes, sections: list[_Section]) -> dict[int, str]:
    """Symbols that the code uses and does not have, by their places in the table."""
    table = next(s for s in sections if s.kind == _SYMBOLS)
    texts = sections[table.link]
    rows = np.frombuffer(code, _SYMBOL, table.size // _SYMBOL.itemsize, table.offset)
    found: dict[int, str] = {}
    for index in np.flatnonzero((rows["section"] == 0) & (rows["name"] > 0)).tolist():
        start = texts.offset + int(rows["name"][index])
        found[index] = code[start : code.index(b"\0", start)].decode()
    return found


def _jump(address: int) -> bytes:
    """`jmp *address`: functions outside may lie farther away than a call reaches."""
    return b"\xff\x25\x00\x00\x00\x00" + address.to_bytes(8, "little") + b"\x90\x90"


def _fill(
    code: bytes, sections: list[_Section], places: dict[int, int], memory: mmap.mmap, base: int, values: Any
) -> bool:
    """Copy the sections and apply their relocations; False at the first that is not understood."""
    view = np.frombuffer(memory, dtype=np.uint8)
    for index, start in places.items():
        section = sections[index]
        if section.kind == _PROGRAM:
            memory[start : start + section.size] = code[section.offset : section.offset + section.size]
    for table in sections:
        if table.kind == _RELOCATIONS and table.info in places:
            rows = np.frombuffer(code, _RELOCATION, table.size // _RELOCATION.itemsize, table.offset)
            if not _relocate(view, rows, base, places[table.info], sections[table.info].size, values):
                return False
    return True


def _relocate(view: Any, rows: Any, base: int, start: int, size: int, values: Any) -> bool:
    # The upper half of `info` is the symbol, the lower the kind. A symbol without address is not in memory: declined.
    kinds = rows["info"] & 0xFFFFFFFF
    targets = values[(rows["info"] >> np.uint64(32)).astype(np.intp)]
    if not np.isin(kinds, (*_ABSOLUTE64, *_RELATIVE32)).all() or not targets.all():
        return False
    offsets = rows["offset"].astype(np.int64)
    if len(rows) and not (0 <= offsets.min() and offsets.max() + 8 <= size + 4):
        return False
    places = start + offsets
    for group, width in ((_ABSOLUTE64, 8), (_RELATIVE32, 4)):
        chosen = np.isin(kinds, group)
        # S + A, or S + A - P, in the letters of the ABI: symbol, addend, place.
        value = (targets + rows["addend"])[chosen]
        if width == 4:
            value = value - (base + places[chosen])
            if (np.abs(value) >= 1 << 31).any():
                return False
        written = value.astype(f"<i{width}")[:, None].view(np.uint8)
        view[places[chosen][:, None] + np.arange(width)] = written
    return True
