"""An object file for a processor: one evaluation, and all rows of a batch, with every elementary function inside.

What such a file defines and what it still needs is read from ELF and WebAssembly, enough to tell. A `Bundle` is many
kernels in one WebAssembly module, with their ports as data: what a page in a browser computes with.
"""

from __future__ import annotations

import json
import struct
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from mafsil.code_store import FileStore, StoreKind, code_folder
from mafsil.errors import InputError
from mafsil.kernels import cache as kernel_cache
from mafsil.kernels.argument import HUGE_VALUE
from mafsil.kernels.export import wasm
from mafsil.kernels.export.legend import reduced_tape, symbol
from mafsil.kernels.export.wasm import Machine, constants_size, loadable, machine
from mafsil.kernels.identity import content_key, fingerprint, toolchain
from mafsil.kernels.kernel import Kernel
from mafsil.kernels.layout import BATCH, SINGLE, Port, Signature, contiguous_steps
from mafsil.kernels.lower import lower, point
from mafsil.kernels.tape import Tape
from mafsil.kernels.target import Target, translate

BUNDLE = StoreKind(b"mafsilW\0", ".bundle")
"""A module and its ports."""
STACK = 1 << 18
"""Bytes of stack below everything else: a kernel that needed more would trap, not overwrite anything."""
_PAGE = 1 << 16
_ELF_MACHINES = {40: "ARM", 62: "x86-64", 183: "AArch64", 243: "RISC-V"}
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
    return Symbols(_ELF_MACHINES.get(machine, str(machine)), 64 if wide else 32, tuple(defined), tuple(needed))


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


@dataclass(frozen=True)
class Bundle:
    """A WebAssembly module and what must be known to call it.

    Attributes:
        code: the module; it imports env.__linear_memory and, where a kernel needs it, env.__stack_pointer.
        layout: plain data: `memory` with the number of `pages`, the initial `stack` pointer and the `first` free byte;
            `kernels`, by name the `inputs` and `outputs`, each a name and a shape. A kernel takes one address of
            doubles for each input, then for each output.
    """

    code: bytes
    layout: Mapping[str, Any]


def bundle(kernels: Mapping[str, Kernel]) -> Bundle:
    """One module of many kernels, kept by content: names, expressions, compiler.

    Without fused products, so that it gives the bits of kernels compiled for `Target`s without them.

    Args:
        kernels: by the name of the exported function.

    Raises:
        InputError: a name that C refuses, a port of size zero.
        KernelError: LLVM refuses the module.
    """
    for name, kernel in kernels.items():
        symbol("", "", name)
        _require_numbers(kernel.signature)
    words = [f"{name} {kernel.order(kernel_cache.default()).key}" for name, kernel in kernels.items()]
    key = content_key("bundle", *words, machine("wasm32").target.identity, fingerprint("mafsil.kernels"), toolchain())
    store = _store()
    code = store.get(key)
    if code is None:
        code = _compile(kernels)
        store.put(key, code)
    return Bundle(code, layout({name: kernel.signature for name, kernel in kernels.items()}, code))


def layout(signatures: Mapping[str, Signature], code: bytes) -> dict[str, Any]:
    """The data that goes with a module whose constants lie above the stack.

    Args:
        signatures: by the name of the exported function.
        code: the module.
    """
    first = -(-(STACK + constants_size(code)) // 16) * 16
    need = max((8 * sum(port.size for port in s.ports) for s in signatures.values()), default=0)
    return {
        "memory": {"pages": -(-(first + need) // _PAGE) + 1, "stack": STACK, "first": first},
        "kernels": {
            name: {"inputs": _port_rows(s.inputs), "outputs": _port_rows(s.outputs)} for name, s in signatures.items()
        },
    }


def layout_text(found: Bundle) -> str:
    """The layout as JSON."""
    return json.dumps(found.layout, indent=1) + "\n"


def _port_rows(ports: tuple[Port, ...]) -> list[dict[str, Any]]:
    return [{"name": port.name, "shape": list(port.shape)} for port in ports]


def _require_numbers(signature: Signature) -> None:
    for port in signature.ports:
        if not port.size:
            raise InputError("export.empty_port", kernel=signature.name, port=port.name)


def _compile(kernels: Mapping[str, Kernel]) -> bytes:
    """The module: every kernel's own module, linked by LLVM, constants moved above the stack."""
    chosen = machine("wasm32")
    texts = [_module(name, kernel, chosen.target) for name, kernel in kernels.items()]
    texts[0] = chosen.runtime + texts[0]
    triple = f'target triple = "{chosen.target.triple}"\n'
    code = translate([triple + text for text in texts], chosen.target, "object", effort=0)
    return loadable(code, list(kernels), STACK)


def _module(name: str, kernel: Kernel, target: Target) -> str:
    """One evaluation; what reduces huge angles is shared by all modules that are linked.

    Long ones are cut: one pass of LLVM for WebAssembly takes time with the square of a function's length.
    """
    text = point(reduced_tape(kernel), kernel.signature, target, name, cut=True)
    shared = [
        line.replace("define internal", "define linkonce_odr hidden") if f"@{HUGE_VALUE}(" in line else line
        for line in text.split("\n")
    ]
    return "\n".join(shared)


@cache
def _store() -> FileStore:
    return FileStore(code_folder(), BUNDLE)
