"""What an object file defines and what it still needs: enough of ELF and WebAssembly to tell."""

from __future__ import annotations

import struct
from dataclasses import dataclass

from mafsil.kernels.export.objects import wasm

MACHINES = {40: "ARM", 62: "x86-64", 183: "AArch64", 243: "RISC-V"}
"""ELF's numbers of processors."""
_SYMBOLS = 2


@dataclass(frozen=True)
class Symbols:
    """Names in an object file.

    Attributes:
        machine: processor.
        bits: of a pointer.
        defined: functions that others may call.
        needed: names that the linker must find elsewhere.
    """

    machine: str
    bits: int
    defined: tuple[str, ...]
    needed: tuple[str, ...]


def symbols(code: bytes) -> Symbols:
    """Names in an ELF or WebAssembly object file."""
    return _wasm(code) if code[:4] == b"\0asm" else _elf(code)


def _elf(code: bytes) -> Symbols:
    wide = code[4] == 2
    (machine,) = struct.unpack_from("<H", code, 18)
    start, size, count = (
        (struct.unpack_from("<Q", code, 40)[0], *struct.unpack_from("<HH", code, 58))
        if wide
        else (struct.unpack_from("<I", code, 32)[0], *struct.unpack_from("<HH", code, 46))
    )
    sections = [_section(code, start + k * size, wide) for k in range(count)]
    table = next(s for s in sections if s[0] == _SYMBOLS)
    texts = sections[table[3]][1]
    defined: list[str] = []
    needed: list[str] = []
    entry = struct.Struct("<IBBHQQ") if wide else struct.Struct("<IIIBBH")
    for row in entry.iter_unpack(code[table[1] : table[1] + table[2]]):
        name, info, section = (row[0], row[1], row[3]) if wide else (row[0], row[3], row[5])
        if info >> 4 == 0 or not name:
            continue
        begin = texts + name
        text = code[begin : code.index(b"\0", begin)].decode()
        (defined if section else needed).append(text)
    return Symbols(MACHINES.get(machine, str(machine)), 64 if wide else 32, tuple(defined), tuple(needed))


def _section(code: bytes, at: int, wide: bool) -> tuple[int, int, int, int]:
    """(kind, offset, size, link)."""
    if wide:
        _, kind, _, _, offset, size, link = struct.unpack_from("<IIQQQQI", code, at)
    else:
        _, kind, _, _, offset, size, link = struct.unpack_from("<IIIIIII", code, at)
    return kind, offset, size, link


def _wasm(code: bytes) -> Symbols:
    needed = [name for _, name, kind in wasm.imports(code) if kind == 0]
    return Symbols("WebAssembly", 32, tuple(name for name, _ in wasm.functions(code)), tuple(needed))
