"""What one core can do at best, measured in the same run: products per second, and bytes written per second.

No kernel evaluates faster than its products and fused products take on the vector units, nor faster than its results
reach the memory that holds the batch. Both bounds leave out sums, loads, transpositions and everything else.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable

import numpy as np

from benchmarks.stopwatch import race
from mafsil.kernels import target
from mafsil.kernels.reduce import reduce
from mafsil.kernels.tape import read
from mafsil.mechanics.catalogue import quantity
from mafsil.model import Mechanism
from mafsil.robot.trace import trace_fused

CHAINS = 16
PRODUCTS = frozenset(("mul", "fma", "fms", "fnma", "fnms"))
SINCOS_PRODUCTS = 23
"""Products in one sine with its cosine (`kernels.trigonometric`)."""


def floor_ns(mechanism: Mechanism, names: tuple[str, ...], rows: int) -> tuple[float, float]:
    """Nanoseconds of one evaluation that the products alone, and the writing of the results alone, take at best."""
    tape = reduce(read(trace_fused(mechanism, [quantity(name) for name in names], None)))
    products = sum(node.op in PRODUCTS for node in tape.nodes)
    angles = {node.args for node in tape.nodes if node.op in ("sin", "cos")}
    size = 8 * sum(tape.output_sizes)
    return (products + SINCOS_PRODUCTS * len(angles)) / products_per_ns(), size / bytes_per_ns(size * rows)


def products_per_ns() -> float:
    """Fused products of doubles that one core finishes in a nanosecond."""
    if "products" not in _measured:
        lanes, count = target.host().lanes, 100_000
        run = _compiled(_chains(lanes))
        seconds = race({"fma": lambda: run(None, count)}, repeats=15, seconds=0.005)["fma"].least
        _measured["products"] = CHAINS * lanes * count / seconds / 1e9
    return _measured["products"]


def bytes_per_ns(size: int) -> float:
    """Bytes that one core writes in a nanosecond into an array of that size, again and again."""
    return _writing(f"plain {size}", size, "")


def past_bytes_per_ns(size: int) -> float:
    """The same in whole lines past the caches, as large results are written."""
    return _writing(f"past {size}", size, ", !nontemporal !0")


def fresh_bytes_per_ns(size: int) -> float:
    """Bytes a nanosecond into pages that come from the system, cleared, for this one time."""
    if f"fresh {size}" not in _measured:
        seconds = race({"fill": lambda: np.full(size // 8, 1.5)}, repeats=3, seconds=0.005)["fill"].least
        _measured[f"fresh {size}"] = size / seconds / 1e9
    return _measured[f"fresh {size}"]


def _writing(name: str, size: int, hint: str) -> float:
    if name not in _measured:
        lanes = target.host().lanes
        count = max(size // 8, lanes) // lanes * lanes
        memory = np.zeros(count + 8)
        run = _compiled(_fill(lanes, hint))
        place = memory.ctypes.data + -memory.ctypes.data % 64
        seconds = race({"fill": lambda: run(place, count)}, repeats=9, seconds=0.005)["fill"].least
        _measured[name] = 8 * count / seconds / 1e9
    return _measured[name]


_measured: dict[str, float] = {}
_codes: list[object] = []


def _compiled(body: str) -> Callable[[int | None, int], object]:
    machine = target.host()
    bits = 64 * machine.lanes
    ir = f"""target triple = "{machine.triple}"
declare <{machine.lanes} x double> @llvm.fma.v{machine.lanes}f64({", ".join([f"<{machine.lanes} x double>"] * 3)})
define void @run(ptr %p, i64 %n) #0 {{
{body}
}}
!0 = !{{i32 1}}
attributes #0 = {{ "min-legal-vector-width"="{bits}" "prefer-vector-width"="{bits}" nounwind }}
"""
    code = target.load(target.compile(ir, machine), ("run",))
    _codes.append(code)
    return ctypes.CFUNCTYPE(None, ctypes.c_void_p, ctypes.c_int64)(code.addresses["run"])


def _chains(lanes: int) -> str:
    """Independent chains x <- x x + x, long enough to hide the latency of one step; the asm keeps them alive."""
    kind = f"<{lanes} x double>"
    heads = "\n".join(f"  %x{k} = phi {kind} [ zeroinitializer, %entry ], [ %y{k}, %next ]" for k in range(CHAINS))
    steps = "\n".join(
        f"  %y{k} = call {kind} @llvm.fma.v{lanes}f64({kind} %x{k}, {kind} %x{k}, {kind} %x{k})" for k in range(CHAINS)
    )
    sums = "\n".join(f"  %s{k + 1} = fadd {kind} {f'%s{k}' if k else '%y0'}, %y{k + 1}" for k in range(CHAINS - 1))
    return f"""entry:
  %room = alloca {kind}, align 64
  br label %next
next:
  %i = phi i64 [ 0, %entry ], [ %j, %next ]
{heads}
{steps}
  %j = add i64 %i, 1
  %more = icmp slt i64 %j, %n
  br i1 %more, label %next, label %done
done:
{sums}
  store volatile {kind} %s{CHAINS - 1}, ptr %room, align 64
  ret void"""


def _fill(lanes: int, hint: str) -> str:
    return f"""entry:
  br label %next
next:
  %i = phi i64 [ 0, %entry ], [ %j, %next ]
  %place = getelementptr double, ptr %p, i64 %i
  store <{lanes} x double> splat (double 1.5), ptr %place, align {8 * lanes}{hint}
  %j = add i64 %i, {lanes}
  %more = icmp slt i64 %j, %n
  br i1 %more, label %next, label %done
done:
  ret void"""
