"""A batch on a graphics processor as LLVM IR: one thread for each row, rows carried through shared memory.

The same functions make the kernel for NVPTX and a function for this processor that does what one block would do, thread
after thread: so the code that goes to the device is held against the kernels of the processor without a device.

How a block of threads moves rows of ports through the memory it shares, so that every transfer is contiguous.
"""

from __future__ import annotations

from dataclasses import dataclass

from mafsil.kernels.layout import Port, Signature
from mafsil.kernels.lower import point
from mafsil.kernels.tape import Tape
from mafsil.kernels.target import Target

SHARED_BYTES = 48 * 1024
"""What every CUDA device gives a block without being asked."""
THREADS = (128, 64, 32)
"""Threads of a block, one row each; fewer where the rows are long."""
POINT, FETCH, COMPUTE, DELIVER = "mafsil_point", "mafsil_fetch", "mafsil_compute", "mafsil_deliver"
TILE = "mafsil_tile"
GLOBAL, SHARED = "ptr addrspace(1)", "ptr addrspace(3)"
_CALLED = "alwaysinline #1"


def device_module(tape: Tape, signature: Signature, target: Target, plan: Plan, name: str) -> str:
    """IR of the kernel `name(in0, divisor0, modulus0, ..., out0, ..., rows)` for NVPTX.

    Args:
        tape: the program.
        signature: its ports.
        target: an NVPTX target.
        plan: how rows are carried.
        name: symbol of the kernel.
    """
    given = _given(signature)
    lines = [
        f"define ptx_kernel void @{name}({_parameters(signature)}) #2 {{",
        "entry:",
        "  %thread = call i32 @llvm.nvvm.read.ptx.sreg.tid.x()",
        "  %place = call i32 @llvm.nvvm.read.ptx.sreg.ctaid.x()",
        "  %block = zext i32 %place to i64",
        f"  call void @{FETCH}(i32 %thread, i64 %block, {given})",
        "  call void @llvm.nvvm.barrier0()",
        f"  call void @{COMPUTE}(i32 %thread, i64 %block, {given})",
        "  call void @llvm.nvvm.barrier0()",
        f"  call void @{DELIVER}(i32 %thread, i64 %block, {given})",
        "  ret void",
        "}",
        "declare i32 @llvm.nvvm.read.ptx.sreg.tid.x()",
        "declare i32 @llvm.nvvm.read.ptx.sreg.ctaid.x()",
        "declare void @llvm.nvvm.barrier0()",
        f'attributes #2 = {{ nounwind "nvvm.maxntid"="{plan.threads}" }}',
        "",
    ]
    return _phases(tape, signature, target, plan) + "\n".join(lines)


def host_module(tape: Tape, signature: Signature, target: Target, plan: Plan, name: str) -> str:
    """IR of `name(block, in0, divisor0, modulus0, ..., out0, ..., rows)`: what one block does, on this processor.

    Args:
        tape: the program.
        signature: its ports.
        target: this processor.
        plan: how rows are carried.
        name: symbol of the function.
    """
    given = _given(signature)
    lines = [f"define dso_local void @{name}(i64 %block, {_parameters(signature)}) #1 {{", "entry:"]
    before = "entry"
    for phase in (FETCH, COMPUTE, DELIVER):
        lines += [
            f"  br label %{phase}",
            f"{phase}:",
            f"  %{phase}.thread = phi i32 [ 0, %{before} ], [ %{phase}.next, %{phase} ]",
            f"  call void @{phase}(i32 %{phase}.thread, i64 %block, {given})",
            f"  %{phase}.next = add i32 %{phase}.thread, 1",
            f"  %{phase}.more = icmp ult i32 %{phase}.next, {plan.threads}",
            f"  br i1 %{phase}.more, label %{phase}, label %{phase}.done",
            f"{phase}.done:",
        ]
        before = f"{phase}.done"
    return _phases(tape, signature, target, plan) + "\n".join([*lines, "  ret void", "}", ""])


def _phases(tape: Tape, signature: Signature, target: Target, plan: Plan) -> str:
    """Everything but the entry."""
    tile = f"@{TILE} = internal addrspace(3) global [{max(plan.size, 1)} x double] undef, align 16"
    parts = [
        f'target triple = "{target.triple}"',
        tile,
        point(tape, signature, target, POINT, inline=True),
        "declare i64 @llvm.smin.i64(i64, i64)",
        _fetch(signature, plan),
        _compute(signature, plan),
        _deliver(signature, plan),
    ]
    return "\n".join(parts)


def _parameters(signature: Signature) -> str:
    inputs = [f"{GLOBAL} noalias readonly %x{k}, i64 %d{k}, i64 %m{k}" for k in range(len(signature.inputs))]
    outputs = [f"{GLOBAL} noalias writeonly %y{k}" for k in range(len(signature.outputs))]
    return ", ".join([*inputs, *outputs, "i64 %rows"])


def _given(signature: Signature) -> str:
    """The parameters as arguments of a call."""
    inputs = [f"{GLOBAL} %x{k}, i64 %d{k}, i64 %m{k}" for k in range(len(signature.inputs))]
    return ", ".join([*inputs, *(f"{GLOBAL} %y{k}" for k in range(len(signature.outputs))), "i64 %rows"])


def _head(name: str, signature: Signature, plan: Plan) -> list[str]:
    """The beginning of a phase: its first row, and how many rows from there on exist."""
    return [
        f"define internal void @{name}(i32 %thread, i64 %block, {_parameters(signature)}) {_CALLED} {{",
        "entry:",
        f"  %base = mul i64 %block, {plan.threads}",
        "  %left = sub i64 %rows, %base",
        f"  %live = call i64 @llvm.smin.i64(i64 %left, i64 {plan.threads})",
        "  %tid = zext i32 %thread to i64",
    ]


def _fetch(signature: Signature, plan: Plan) -> str:
    """Inputs into shared memory, neighbouring threads taking neighbouring numbers; beyond the end, the last again."""
    lines = _head(FETCH, signature, plan)
    for k, tile in enumerate(plan.tiles[: len(signature.inputs)]):
        if tile.first is not None and tile.port.size:
            lines += _loads(k, tile, plan.threads)
    return "\n".join([*lines, "  ret void", "}", ""])


def _loads(k: int, tile: Tile, threads: int) -> list[str]:
    size = tile.port.size
    straight = [f"  %s{k}.from = add i64 %s{k}.start, %s{k}.kept"]
    broadcast = [
        f"  %b{k}.row = udiv i64 %b{k}.kept, {size}",
        f"  %b{k}.element = urem i64 %b{k}.kept, {size}",
        f"  %b{k}.global = add i64 %base, %b{k}.row",
        *_source_row(f"b{k}", k),
        f"  %b{k}.begin = mul i64 %b{k}.source, {size}",
        f"  %b{k}.from = add i64 %b{k}.begin, %b{k}.element",
    ]
    return [
        f"  %s{k}.start = mul i64 %base, {size}",
        f"  %last{k} = mul i64 %live, {size}",
        f"  %limit{k} = sub i64 %last{k}, 1",
        f"  %plain{k} = icmp eq i64 %m{k}, 0",
        f"  br label %choose{k}",
        f"choose{k}:",
        f"  br i1 %plain{k}, label %s{k}, label %b{k}",
        *_carrying(f"s{k}", k, tile, threads, straight),
        *_carrying(f"b{k}", k, tile, threads, broadcast),
        f"fetched{k}:",
    ]


def _carrying(prefix: str, k: int, tile: Tile, threads: int, address: list[str]) -> list[str]:
    """A loop over the numbers that one thread carries from global to shared memory."""
    size = tile.port.size
    return [
        f"{prefix}:",
        f"  %{prefix}.turn = phi i64 [ 0, %choose{k} ], [ %{prefix}.next, %{prefix} ]",
        f"  %{prefix}.skip = mul i64 %{prefix}.turn, {threads}",
        f"  %{prefix}.index = add i64 %{prefix}.skip, %tid",
        f"  %{prefix}.kept = call i64 @llvm.smin.i64(i64 %{prefix}.index, i64 %limit{k})",
        *address,
        f"  %{prefix}.pointer = getelementptr double, {GLOBAL} %x{k}, i64 %{prefix}.from",
        f"  %{prefix}.number = load double, {GLOBAL} %{prefix}.pointer, align 8",
        *_shared_place(prefix, tile),
        f"  store double %{prefix}.number, {SHARED} %{prefix}.place, align 8",
        f"  %{prefix}.next = add i64 %{prefix}.turn, 1",
        f"  %{prefix}.more = icmp ult i64 %{prefix}.next, {size}",
        f"  br i1 %{prefix}.more, label %{prefix}, label %fetched{k}",
    ]


def _shared_place(prefix: str, tile: Tile) -> list[str]:
    """Where number `index` of a block's rows lies: rows of an even size have a gap behind them."""
    assert tile.first is not None
    lines = [f"  %{prefix}.gaps = udiv i64 %{prefix}.index, {tile.port.size}"]
    lines += [f"  %{prefix}.moved = add i64 %{prefix}.index, %{prefix}.gaps"]
    inside = f"%{prefix}.index" if tile.stride == tile.port.size else f"%{prefix}.moved"
    lines += [f"  %{prefix}.shared = add i64 {inside}, {tile.first}"]
    return [*lines, f"  %{prefix}.place = getelementptr double, {SHARED} @{TILE}, i64 %{prefix}.shared"]


def _source_row(prefix: str, k: int) -> list[str]:
    """The row of an input that belongs to row `global` of the batch: (row / divisor) mod modulus."""
    return [
        f"  %{prefix}.slow = udiv i64 %{prefix}.global, %d{k}",
        f"  %{prefix}.source = urem i64 %{prefix}.slow, %m{k}",
    ]


def _compute(signature: Signature, plan: Plan) -> str:
    """One row, if it exists."""
    lines = _head(COMPUTE, signature, plan)
    lines += ["  %exists = icmp slt i64 %tid, %live", "  br i1 %exists, label %work, label %done", "work:"]
    lines += ["  %row = add i64 %base, %tid"]
    pointers: list[str] = []
    count = len(signature.inputs)
    for k, tile in enumerate(plan.tiles):
        side, index = ("x", k) if k < count else ("y", k - count)
        name = f"{side}{index}.at"
        if tile.first is None:
            lines += _in_place(name, side, index, tile.port.size)
        else:
            lines += [
                f"  %{name}.start = mul i64 %tid, {tile.stride}",
                f"  %{name}.index = add i64 %{name}.start, {tile.first}",
                f"  %{name}.shared = getelementptr double, {SHARED} @{TILE}, i64 %{name}.index",
                f"  %{name} = addrspacecast {SHARED} %{name}.shared to ptr",
            ]
        pointers.append(f"ptr %{name}")
    lines += [f"  call void @{POINT}({', '.join(pointers)})", "  br label %done", "done:", "  ret void", "}", ""]
    return "\n".join(lines)


def _in_place(name: str, side: str, index: int, size: int) -> list[str]:
    """The row in global memory itself."""
    row = "%row"
    lines: list[str] = []
    if side == "x":
        row = f"%{name}.picked"
        lines = [
            f"  %{name}.plain = icmp eq i64 %m{index}, 0",
            f"  %{name}.modulus = select i1 %{name}.plain, i64 %rows, i64 %m{index}",
            f"  %{name}.slow = udiv i64 %row, %d{index}",
            f"  %{name}.picked = urem i64 %{name}.slow, %{name}.modulus",
        ]
    return [
        *lines,
        f"  %{name}.start = mul i64 {row}, {size}",
        f"  %{name}.global = getelementptr double, {GLOBAL} %{side}{index}, i64 %{name}.start",
        f"  %{name} = addrspacecast {GLOBAL} %{name}.global to ptr",
    ]


def _deliver(signature: Signature, plan: Plan) -> str:
    """Outputs from shared memory, neighbouring threads writing neighbouring numbers, none beyond the end."""
    lines = _head(DELIVER, signature, plan)
    for k, tile in enumerate(plan.tiles[len(signature.inputs) :]):
        if tile.first is None or not tile.port.size:
            continue
        size, o = tile.port.size, f"o{k}"
        lines += [
            f"  %{o}.start = mul i64 %base, {size}",
            f"  %{o}.limit = mul i64 %live, {size}",
            f"  br label %{o}.enter",
            f"{o}.enter:",
            f"  br label %{o}",
            f"{o}:",
            f"  %{o}.turn = phi i64 [ 0, %{o}.enter ], [ %{o}.next, %{o}.after ]",
            f"  %{o}.skip = mul i64 %{o}.turn, {plan.threads}",
            f"  %{o}.index = add i64 %{o}.skip, %tid",
            f"  %{o}.exists = icmp slt i64 %{o}.index, %{o}.limit",
            f"  br i1 %{o}.exists, label %{o}.write, label %{o}.after",
            f"{o}.write:",
            *_shared_place(o, tile),
            f"  %{o}.number = load double, {SHARED} %{o}.place, align 8",
            f"  %{o}.to = add i64 %{o}.start, %{o}.index",
            f"  %{o}.pointer = getelementptr double, {GLOBAL} %y{k}, i64 %{o}.to",
            f"  store double %{o}.number, {GLOBAL} %{o}.pointer, align 8",
            f"  br label %{o}.after",
            f"{o}.after:",
            f"  %{o}.next = add i64 %{o}.turn, 1",
            f"  %{o}.more = icmp ult i64 %{o}.next, {size}",
            f"  br i1 %{o}.more, label %{o}, label %{o}.done",
            f"{o}.done:",
        ]
    return "\n".join([*lines, "  ret void", "}", ""])


@dataclass(frozen=True)
class Tile:
    """Where a port's rows lie in shared memory.

    Attributes:
        port: the port.
        first: index of its first number, or None if its rows are too long and stay where they are.
        stride: numbers from row to row; odd, so that the threads of a block use different banks.
    """

    port: Port
    first: int | None
    stride: int


@dataclass(frozen=True)
class Plan:
    """The rows of a block.

    Attributes:
        threads: threads of a block; thread k computes row k.
        tiles: one for each port, inputs first.
        size: numbers in shared memory.
    """

    threads: int
    tiles: tuple[Tile, ...]
    size: int

    def blocks(self, rows: int) -> int:
        """How many blocks a batch takes."""
        return -(-rows // self.threads)


def plan(signature: Signature) -> Plan:
    """The widest block whose ports fit into shared memory; where none does, the longest rows stay out of it."""
    for threads in THREADS:
        found = _laid_out(signature.ports, signature.ports, threads)
        if 8 * found.size <= SHARED_BYTES:
            return found
    threads = THREADS[1]
    staged = sorted(signature.ports, key=lambda port: port.size)
    while 8 * (found := _laid_out(signature.ports, staged, threads)).size > SHARED_BYTES:
        staged.pop()
    return found


def _laid_out(ports: tuple[Port, ...], staged: tuple[Port, ...] | list[Port], threads: int) -> Plan:
    tiles: list[Tile] = []
    size = 0
    for port in ports:
        stride = port.size | 1
        inside = any(port is other for other in staged)
        tiles.append(Tile(port, size if inside else None, stride))
        size += threads * stride if inside else 0
    return Plan(threads, tuple(tiles), size)
