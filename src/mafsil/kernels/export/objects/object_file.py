"""An object file for a processor: one evaluation, and all rows of a batch, with every elementary function inside.

What an object file defines and what it still needs: enough of ELF and WebAssembly to tell.
"""

from __future__ import annotations

import struct
from dataclasses import dataclass

from mafsil.kernels.export.objects import wasm
from mafsil.kernels.export.objects.machines import Machine
from mafsil.kernels.layout import BATCH, SINGLE, Signature, contiguous_steps
from mafsil.kernels.lower import lower, point
from mafsil.kernels.tape import Tape
from mafsil.kernels.target import translate

MACHINES = {40: "ARM", 62: "x86-64", 183: "AArch64", 243: "RISC-V"}
"""ELF's numbers of processors."""
_SYMBOLS = 2


def object_file(tape: Tape, signature: Signature, machine: Machine, name: str) -> bytes:
    """Object code with the functions `name` and `name_rows`.

    Args:
        tape: the program.
        signature: its ports.
        machine: the processor.
        name: of the function.

    Raises:
        KernelError: LLVM refuses the module.
    """
    ir = _with_lanes(tape, signature, machine, name) if machine.lanes else _plain(tape, signature, machine, name)
    if machine.abi:
        ir += f'!llvm.module.flags = !{{!99}}\n!99 = !{{i32 1, !"target-abi", !"{machine.abi}"}}\n'
    return translate(ir, machine.target, "object", reloc="pic" if machine.lanes else "static")


def rows_prototype(single: str, name: str) -> str:
    """The declaration of `name_rows`, from that of `name`."""
    return single.replace(f"void {name}(", f"void {name}_rows(").removesuffix(")") + ", size_t rows);"


def _plain(tape: Tape, signature: Signature, machine: Machine, name: str) -> str:
    """Row after row."""
    size = f"i{machine.bits}"
    ports = _ports(signature)
    lines = [
        f'target triple = "{machine.target.triple}"',
        machine.runtime,
        point(tape, signature, machine.target, name),
        f"define dso_local void @{name}_rows({', '.join(f'ptr %{p}' for p, _ in ports)}, {size} %rows) #1 {{",
        "entry:",
        f"  %any = icmp ne {size} %rows, 0",
        "  br i1 %any, label %next, label %done",
        "next:",
        f"  %row = phi {size} [ 0, %entry ], [ %following, %next ]",
    ]
    for port, count in ports:
        lines += [
            f"  %{port}.skip = mul {size} %row, {count}",
            f"  %{port}.row = getelementptr double, ptr %{port}, {size} %{port}.skip",
        ]
    lines += [
        f"  call void @{name}({', '.join(f'ptr %{p}.row' for p, _ in ports)})",
        f"  %following = add {size} %row, 1",
        f"  %more = icmp ult {size} %following, %rows",
        "  br i1 %more, label %next, label %done",
        "done:",
        "  ret void",
        "}",
        "",
    ]
    return "\n".join(lines)


def _with_lanes(tape: Tape, signature: Signature, machine: Machine, name: str) -> str:
    """The kernel as this package itself calls it, behind two plain C functions."""
    inside = lower(tape, signature, machine.target).replace("define dso_local void", "define internal void")
    ports = _ports(signature)
    given = ", ".join(f"ptr %{port}" for port, _ in ports)
    cores = sorted({size for port in signature.ports for size in port.shape})
    steps = [8 * port.size for port in signature.ports]
    steps += [step for port in signature.ports for step in contiguous_steps(port)]
    lines = [
        inside,
        f"define dso_local void @{name}({given}) #0 {{",
        f"  call void @{SINGLE}({given})",
        "  ret void",
        "}",
        f"define dso_local void @{name}_rows({given}, i64 %rows) #0 {{",
        *_stack("args", [f"ptr %{port}" for port, _ in ports]),
        *_stack("dims", ["i64 %rows", *(f"i64 {core}" for core in cores)]),
        *_stack("steps", [f"i64 {step}" for step in steps]),
        f"  call void @{BATCH}(ptr %args, ptr %dims, ptr %steps, ptr null)",
        "  ret void",
        "}",
        "",
    ]
    return "\n".join(lines)


def _stack(name: str, values: list[str]) -> list[str]:
    """An array of these values."""
    lines = [f"  %{name} = alloca [{len(values)} x i64], align 8"]
    for k, value in enumerate(values):
        lines += [f"  %{name}{k} = getelementptr i64, ptr %{name}, i64 {k}", f"  store {value}, ptr %{name}{k}"]
    return lines


def _ports(signature: Signature) -> list[tuple[str, int]]:
    """(name in IR, numbers of a row) of every port."""
    count = len(signature.inputs)
    names = [f"x{k}" if k < count else f"y{k - count}" for k in range(len(signature.ports))]
    return [(name, port.size) for name, port in zip(names, signature.ports, strict=True)]


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
