"""The processors that kernels are exported to, as LLVM names them, and object files of WebAssembly.

These are read, and made into modules that a browser loads without a linker.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from mafsil.errors import InputError
from mafsil.kernels.target import Target, describe_target, host

WASM_RUNTIME = """
define weak hidden void @__multi3(ptr %result, i64 %a, i64 %a.high, i64 %b, i64 %b.high) #9 {
  %a0 = and i64 %a, 4294967295
  %a1 = lshr i64 %a, 32
  %b0 = and i64 %b, 4294967295
  %b1 = lshr i64 %b, 32
  %p00 = mul i64 %a0, %b0
  %p10 = mul i64 %a1, %b0
  %p01 = mul i64 %a0, %b1
  %p11 = mul i64 %a1, %b1
  %carry = lshr i64 %p00, 32
  %low10 = and i64 %p10, 4294967295
  %sum = add i64 %carry, %low10
  %middle = add i64 %sum, %p01
  %upper = shl i64 %middle, 32
  %lower = and i64 %p00, 4294967295
  %low = or i64 %upper, %lower
  %high10 = lshr i64 %p10, 32
  %over = lshr i64 %middle, 32
  %high0 = add i64 %p11, %high10
  %high1 = add i64 %high0, %over
  %cross0 = mul i64 %a, %b.high
  %cross1 = mul i64 %a.high, %b
  %high2 = add i64 %high1, %cross0
  %high = add i64 %high2, %cross1
  %place = getelementptr i64, ptr %result, i32 1
  store i64 %low, ptr %result, align 8
  store i64 %high, ptr %place, align 8
  ret void
}
define weak hidden void @__ashlti3(ptr %result, i64 %low, i64 %high, i32 %count) #9 {
  %n = zext i32 %count to i64
  %left = and i64 %n, 63
  %whole = icmp uge i64 %n, 64
  %shifted = shl i64 %low, %left
  %joined = call i64 @llvm.fshl.i64(i64 %high, i64 %low, i64 %left)
  %new.high = select i1 %whole, i64 %shifted, i64 %joined
  %new.low = select i1 %whole, i64 0, i64 %shifted
  %place = getelementptr i64, ptr %result, i32 1
  store i64 %new.low, ptr %result, align 8
  store i64 %new.high, ptr %place, align 8
  ret void
}
attributes #9 = { noinline optnone nounwind }
"""
"""Products and shifts of 128-bit integers, which LLVM calls from a library that a browser does not have.

They are not optimised: LLVM would see what they are, and let them call themselves.
"""
_EXPORTS = 7
_DATA = 11
_ADDRESSES = {3: "leb", 4: "sleb", 5: "i32"}
"""Kinds of relocations that are addresses of constants: R_WASM_MEMORY_ADDR_LEB, _SLEB, _I32."""
_WITH_ADDEND = (3, 4, 5, 8, 9)
"""Kinds that carry an addend, those in sections for debuggers included."""
_BEHIND = (8, 9, 10, 11, 12)
"""Sections that stand behind the exports."""


def loadable(code: bytes, names: Iterable[str], base: int = 0) -> bytes:
    """The object file as a module: the functions of these names exported, what only linkers read left out.

    It imports its memory as env.__linear_memory.

    Args:
        code: of an object file.
        names: of its functions.
        base: address of its constants. Modules that share a memory need places of their own.
    """
    names = list(names)
    places = dict(functions(code))
    code = _move(code, base) if base else code
    rows = b"".join(_name(name) + b"\0" + _leb(places[name]) for name in names)
    contents = _leb(len(names)) + rows
    section = bytes([_EXPORTS]) + _leb(len(contents)) + contents
    kept = bytearray(code[:8])
    done = False
    for number, begin, end in sections(code):
        if number == 0:
            continue
        if number in _BEHIND and not done:
            kept += section
            done = True
        kept += bytes([number]) + _leb(end - begin) + code[begin:end]
    return bytes(kept)


def constants_size(code: bytes) -> int:
    """Bytes of the constants of a module."""
    return sum(end - begin for number, begin, end in sections(code) if number == _DATA)


def _move(code: bytes, base: int) -> bytes:
    """The object file with its constants at another address: in every place that the linker is told to write one.

    Reference: WebAssembly tool conventions, Linking, section "Relocation Sections".
    """
    places = sections(code)
    image = bytearray(code)
    for number, begin, end in places:
        title, at = _text(code, begin) if number == 0 else ("", 0)
        if not title.startswith("reloc."):
            continue
        which, at = leb(code, at)
        count, at = leb(code, at)
        start = places[which][1]
        for _ in range(count):
            kind, (offset, at) = code[at], leb(code, at + 1)
            _, at = leb(code, at)
            if kind in _WITH_ADDEND:
                _, at = leb(code, at)
            if kind in _ADDRESSES:
                _write_address(image, start + offset, kind, base)
        if at != end:
            raise ValueError(f"{title}: relocations end at {at}, not at {end}")
    return bytes(image[:8]) + b"".join(
        bytes([number]) + _section(_based(image, begin, end, base) if number == _DATA else bytes(image[begin:end]))
        for number, begin, end in places
    )


def _section(contents: bytes) -> bytes:
    return _leb(len(contents)) + contents


def _write_address(image: bytearray, at: int, kind: int, base: int) -> None:
    """Add the base to an address: five bytes of LEB128, or four of an integer."""
    if _ADDRESSES[kind] == "i32":
        image[at : at + 4] = (int.from_bytes(image[at : at + 4], "little") + base).to_bytes(4, "little")
        return
    value = sum((image[at + k] & 0x7F) << 7 * k for k in range(5)) + base
    image[at : at + 5] = bytes((value >> 7 * k & 0x7F) | (0x80 if k < 4 else 0) for k in range(5))


def _based(image: bytearray, at: int, end: int, base: int) -> bytes:
    """The data section with every segment's place, i32.const, moved by the base."""
    count, at = leb(image, at)
    found = bytearray(_leb(count))
    for _ in range(count):
        if bytes(image[at : at + 2]) != b"\0\x41":
            raise ValueError("a data segment whose place is no constant")
        offset, at = leb(image, at + 2)
        size, at = leb(image, at + 1)
        found += b"\0\x41" + _signed_leb(offset + base) + b"\x0b" + _leb(size) + image[at : at + size]
        at += size
    if at != end:
        raise ValueError("bytes behind the last data segment")
    return bytes(found)


def _signed_leb(value: int) -> bytes:
    """A number that is not negative."""
    found = bytearray()
    while value >= 0x40:
        found.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*found, value])


def _leb(value: int) -> bytes:
    found = bytearray()
    while value >= 0x80:
        found.append(value & 0x7F | 0x80)
        value >>= 7
    return bytes([*found, value])


def _name(name: str) -> bytes:
    text = name.encode()
    return _leb(len(text)) + text


def sections(code: bytes) -> list[tuple[int, int, int]]:
    """(number, begin, end) of the contents of every section."""
    found: list[tuple[int, int, int]] = []
    at = 8
    while at < len(code):
        size, begin = leb(code, at + 1)
        found.append((code[at], begin, begin + size))
        at = begin + size
    return found


def imports(code: bytes) -> list[tuple[str, str, int]]:
    """(module, name, kind) of every import; kind 0 is a function, 1 a table, 2 a memory, 3 a global."""
    begin = next((b for number, b, _ in sections(code) if number == 2), None)
    if begin is None:
        return []
    count, at = leb(code, begin)
    found: list[tuple[str, str, int]] = []
    for _ in range(count):
        module, at = _text(code, at)
        name, at = _text(code, at)
        kind = code[at]
        at += 1
        if kind == 0:
            _, at = leb(code, at)
        elif kind == 3:
            at += 2
        else:
            at += kind == 1
            flags, at = leb(code, at)
            for _ in range(1 + (flags & 1)):
                _, at = leb(code, at)
        found.append((module, name, kind))
    return found


def functions(code: bytes) -> list[tuple[str, int]]:
    """(name, index) of every defined function that others may call, from the linking section."""
    found: list[tuple[str, int]] = []
    for number, begin, end in sections(code):
        if number == 0:
            title, at = _text(code, begin)
            if title == "linking":
                found += _linking(code, at + 1, end)
    return found


def _linking(code: bytes, at: int, end: int) -> list[tuple[str, int]]:
    """Functions in the symbol table of a linking section."""
    found: list[tuple[str, int]] = []
    while at < end:
        kind = code[at]
        size, at = leb(code, at + 1)
        stop = at + size
        if kind == 8:
            count, at = leb(code, at)
            for _ in range(count):
                what, (flags, at) = code[at], leb(code, at + 1)
                undefined, local, explicit = flags & 0x10, flags & 0x06, flags & 0x40
                name = ""
                index = 0
                if what == 1:
                    name, at = _text(code, at)
                    for _ in range(0 if undefined else 3):
                        _, at = leb(code, at)
                    continue
                index, at = leb(code, at)
                if what != 3 and (not undefined or explicit):
                    name, at = _text(code, at)
                if what == 0 and not undefined and not local:
                    found.append((name, index))
        at = stop
    return found


def leb(code: bytes | bytearray, at: int) -> tuple[int, int]:
    """An unsigned LEB128 number and the place behind it."""
    value = shift = 0
    while True:
        byte = code[at]
        at += 1
        value |= (byte & 0x7F) << shift
        shift += 7
        if byte < 0x80:
            return value, at


def _text(code: bytes, at: int) -> tuple[str, int]:
    size, at = leb(code, at)
    return code[at : at + size].decode(), at + size


@dataclass(frozen=True)
class Machine:
    """A processor for which object files are made.

    Attributes:
        name: how users call it.
        target: how LLVM calls it, and what it can.
        lanes: batches are evaluated by vectors of rows; else row by row.
        bits: of a pointer.
        abi: LLVM's name of the calling convention, where it must be said.
        outside: beginnings of the names that a linker finds in the processor's own run-time library.
        runtime: IR of what others call from such a library, brought along where none can be expected.
    """

    name: str
    target: Target
    lanes: bool
    bits: int = 64
    abi: str = ""
    outside: tuple[str, ...] = ()
    runtime: str = ""


def _bare(triple: str, cpu: str, features: str, *, fma: bool, rounding: bool) -> Target:
    return Target(triple, cpu, features, 1, fma, rounding)


def machine(name: str) -> Machine:
    """The processor of that name; `host` is the one that runs this.

    Raises:
        InputError: the name is not known; the sentence lists what is.
    """
    if name == "host":
        return Machine("host", host(), lanes=True)
    if name not in MACHINES:
        raise InputError("export.machine", name=name, known=", ".join(["host", *MACHINES]))
    return MACHINES[name]


_LINUX_X86 = "x86_64-unknown-linux-gnu"
_AVX2 = "+avx,+avx2,+bmi,+bmi2,+fma,+lzcnt,+movbe,+popcnt,+sse3,+ssse3,+sse4.1,+sse4.2"
MACHINES: dict[str, Machine] = {
    item.name: item
    for item in (
        Machine("x86-64", describe_target(_LINUX_X86, "x86-64", "+sse2"), lanes=True),
        Machine("x86-64-avx2", describe_target(_LINUX_X86, "haswell", _AVX2), lanes=True),
        Machine("aarch64", describe_target("aarch64-unknown-linux-gnu", "generic", "+neon"), lanes=True),
        Machine(
            "cortex-m4f",
            _bare("thumbv7em-unknown-none-eabihf", "cortex-m4", "", fma=False, rounding=False),
            lanes=False,
            bits=32,
            outside=("__aeabi_", "sqrt"),
        ),
        Machine(
            "cortex-m7",
            _bare("thumbv7em-unknown-none-eabihf", "cortex-m7", "", fma=True, rounding=True),
            lanes=False,
            bits=32,
            outside=("__aeabi_",),
        ),
        Machine(
            "riscv64",
            _bare("riscv64-unknown-none-elf", "generic-rv64", "+m,+a,+f,+d,+c", fma=True, rounding=False),
            lanes=False,
            abi="lp64d",
        ),
        Machine(
            "wasm32",
            _bare("wasm32-unknown-unknown", "generic", "", fma=False, rounding=True),
            lanes=False,
            bits=32,
            runtime=WASM_RUNTIME,
        ),
    )
}
"""By name; WebAssembly has no fused product and sum, a Cortex-M4F computes doubles in software."""
