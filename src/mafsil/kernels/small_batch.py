"""Batches of a few rows in machine code: the last step of `forms`, without NumPy's broadcasting and without threads.

1. Data, outer stride and inner stride of every argument; all batches have one length, or the argument is one point.
2. The results are new, or `out`, under which no argument may lie.
3. Up to FEW_ROWS contiguous rows are evaluated one after another, more in the lanes of the batch entry: a tile costs
   the same however few of its rows are wanted. Both give the same bits. While the batch entry is not in memory, the
   call goes on to Python, which brings it once it pays (`SINGLY`); while the single entry is not, a few rows go to
   the batch entry.
4. Beyond ALONE_ROWS other threads may have the interpreter meanwhile.

How many rows are few, and whether a second thread is worth its call, follows from what one evaluation takes, about.
"""

from __future__ import annotations

from mafsil.kernels.gathering import place as at
from mafsil.kernels.layout import Signature
from mafsil.kernels.runtime import ARRAY_DATA, DOUBLE

OPERATION_NS = 0.2
"""One operation of one row on one lane [ns]; sines, quotients and spills included, measured over the mechanics of arms
and trees on AVX-512 at 4 GHz: 0.15 to 0.3."""
BYTE_NS = 0.013
"""One byte of a result, transposed and written [ns]."""
HANDED_OVER_NS = 250_000
"""Work that pays for being handed to another thread [ns]: waking one takes some 75 us, and on a busy machine it comes
later still, while the caller waits."""
SINGLY = 4000
"""Rows that a kernel evaluates one after another before its code for lanes is compiled: an operation of one row takes
1 ns, its compilation 60 us."""
FEW = "mafsil_few"
"""Symbol of the entry of LOOP's convention for rows so few that one after another is sooner done than all at once."""
TO_SINGLE, TO_LOOP = "mafsil_to_single", "mafsil_to_loop"
"""Symbols of the places of the addresses of a kernel's entries SINGLE and LOOP; null while they are not in memory."""
MOST = "mafsil_most"
"""Symbol of the place of the number of rows of the largest batch that is evaluated here."""
FEW_ROWS = 3
ALONE_ROWS = 64
"""Rows that are evaluated without letting other threads have the interpreter meanwhile."""
_MOST_BYTES = 4 << 20
"""Bytes of the largest new result here; pages of larger ones are used again (`result_memory`)."""


def most_rows(row_ns: float, signature: Signature) -> int:
    """Rows of the largest batch that is evaluated here: not worth a second thread, and no large result.

    Args:
        row_ns: nanoseconds of one row.
        signature: ports of the kernel.
    """
    size = 8 * sum(port.size for port in signature.outputs)
    return min(rows_for_one_thread(row_ns), (_MOST_BYTES - 1) // max(size, 1))


def rows_of_one_batch(signature: Signature) -> str:
    """Step 4 of `forms`: strides of every argument; the results, new or `out`; the evaluation.

    Args:
        signature: ports of the kernel; inputs are numbers or vectors.
    """
    inputs, outputs, starts = signature.inputs, signature.outputs, signature.core_steps
    lines: list[str] = []
    for k, port in enumerate(inputs):
        inner = starts[k] if port.shape else k  # a number has no inner stride: the place is written over
        lines.append(f"""batch{k}:
  %data.at{k} = getelementptr ptr, ptr %data, i64 {k}
  %outer.at{k} = getelementptr i64, ptr %steps, i64 {k}
  %inner.at{k} = getelementptr i64, ptr %steps, i64 {inner}
  %row.fits{k} = call i1 @mafsil_row(ptr %place{k}, i32 {len(port.shape)}, i64 {port.size}, ptr %data.at{k}, \
ptr %outer.at{k}, ptr %inner.at{k}, ptr %rows, i1 %with.out, ptr %table)
  br i1 %row.fits{k}, label %batch{k + 1}, label %slow""")
    results, stores = _results(signature, starts)
    head = f"batch{len(inputs)}"
    before = "\n".join(lines).replace("batch0:", "batch0:\n  store i64 -1, ptr %rows, align 8", 1)
    return f"""{before}
{head}:
  %count = load i64, ptr %rows, align 8
  %some = icmp sgt i64 %count, 0
  %most = load i64, ptr @{MOST}, align 8
  %few = icmp sle i64 %count, %most
  %loop = load ptr, ptr @{TO_LOOP}, align 8
  %loop.there = icmp ne ptr %loop, null
  %some.few = and i1 %some, %few
  %taken = and i1 %some.few, %loop.there
  br i1 %taken, label %batch.results, label %slow
batch.results:
{results}
{stores}
{_close(signature)}
  %single = load ptr, ptr @{TO_SINGLE}, align 8
  %single.there = icmp ne ptr %single, null
  %rows.few = icmp sle i64 %count, {FEW_ROWS}
  %no.tile = and i1 %rows.few, %single.there
  %one.by.one = and i1 %no.tile, %close
  br i1 %one.by.one, label %run.few, label %run.all
run.few:
  call void @{FEW}(ptr %data, ptr %rows, ptr %steps, ptr null)
  br label %hand
run.all:
  %brief = icmp sle i64 %count, {ALONE_ROWS}
  br i1 %brief, label %run.brief, label %run.long
run.brief:
  call void %loop(ptr %data, ptr %rows, ptr %steps, ptr null)
  br label %hand
run.long:                                                    ; step 4: the arguments are the caller's, who waits
  %give.at = getelementptr i8, ptr %table, i64 {at("PyEval_SaveThread")}
  %give = load ptr, ptr %give.at, align 8
  %take.at = getelementptr i8, ptr %table, i64 {at("PyEval_RestoreThread")}
  %take = load ptr, ptr %take.at, align 8
  %thread = call ptr %give()
  call void %loop(ptr %data, ptr %rows, ptr %steps, ptr null)
  call void %take(ptr %thread)
  br label %hand
hand:
{_hand(len(outputs))}
failed:
  ret ptr null"""


def few(signature: Signature) -> str:
    """The body of FEW: rows whose numbers are contiguous, one after another; it ends in a block of its own.

    for (row = 0; row < count; row++) single(args[0] + row steps[0], args[1] + row steps[1], ...)
    """
    lines = ["  %count = load i64, ptr %dims, align 8", f"  %single = load ptr, ptr @{TO_SINGLE}, align 8"]
    lines += ["  %some = icmp sgt i64 %count, 0", "  br i1 %some, label %rows, label %over"]
    lines += ["rows:", "  %row = phi i64 [ 0, %entry ], [ %row.next, %rows ]", "  %row.next = add i64 %row, 1"]
    for k in range(len(signature.ports)):
        lines += [
            f"  %start.at{k} = getelementptr ptr, ptr %args, i64 {k}",
            f"  %start{k} = load ptr, ptr %start.at{k}, align 8",
            f"  %stride.at{k} = getelementptr i64, ptr %steps, i64 {k}",
            f"  %stride{k} = load i64, ptr %stride.at{k}, align 8",
            f"  %offset{k} = mul i64 %row, %stride{k}",
            f"  %at{k} = getelementptr i8, ptr %start{k}, i64 %offset{k}",
        ]
    pointers = ", ".join(f"ptr %at{k}" for k in range(len(signature.ports)))
    lines += [f"  call void %single({pointers})", "  %more = icmp slt i64 %row.next, %count"]
    return "\n".join([*lines, "  br i1 %more, label %rows, label %over", "over:", ""])


def _close(signature: Signature) -> str:
    """`%close`: whether the numbers of every row lie side by side."""
    lines: list[str] = []
    known = "true"
    for k, port in enumerate(signature.inputs):
        if port.shape:
            lines.append(f"""  %side.at{k} = getelementptr i64, ptr %steps, i64 {signature.core_steps[k]}
  %side{k} = load i64, ptr %side.at{k}, align 8
  %by.side{k} = icmp eq i64 %side{k}, 8
  %together{k} = and i1 {known}, %by.side{k}""")
            known = f"%together{k}"
    return "\n".join([*lines, f"  %close = and i1 {known}, true"])


def _results(signature: Signature, starts: tuple[int, ...]) -> tuple[str, str]:
    """The result arrays, new or `out`, and where the batch entry finds their memory."""
    outputs, first = signature.outputs, len(signature.inputs)
    lines = [
        f"""  store i64 %count, ptr %shape, align 8
  %new.at = getelementptr i8, ptr %table, i64 {at("PyArray_New")}
  %new = load ptr, ptr %new.at, align 8
  %class.at = getelementptr i8, ptr %table, i64 {at("ndarray")}
  %class = load ptr, ptr %class.at, align 8"""
    ]
    if len(outputs) == 1 and outputs[0].shape:
        lines.append(f"""  br i1 %no.out, label %new0, label %batch.out
batch.out:
  %batch.out.fits = call i1 @mafsil_shaped(ptr %out.known, i32 1, i64 %count, i32 {len(outputs[0].shape)}, \
ptr @mafsil_core)
  br i1 %batch.out.fits, label %apart0, label %slow
{_apart(signature)}
batch.out.take:
  %keep.at = getelementptr i8, ptr %table, i64 {at("Py_IncRef")}
  %keep = load ptr, ptr %keep.at, align 8
  call void %keep(ptr %out.known)
  br label %placed0""")
    else:
        lines.append("  br label %new0")
    for k, port in enumerate(outputs):
        sizes = "\n".join(
            f"  %size.at{k}.{axis} = getelementptr i64, ptr %shape, i64 {axis + 1}\n"
            f"  store i64 {size}, ptr %size.at{k}.{axis}, align 8"
            for axis, size in enumerate(port.shape)
        )
        own = "[ %out.known, %batch.out.take ], " if k == 0 and len(outputs) == 1 and port.shape else ""
        lines.append(
            f"""new{k}:
{sizes}
  %made{k} = call ptr %new(ptr %class, i32 {1 + len(port.shape)}, ptr %shape, i32 {DOUBLE}, ptr null, ptr null, i32 0, \
i32 0, ptr null)
  %made.there{k} = icmp ne ptr %made{k}, null
  br i1 %made.there{k}, label %placed{k}, label %failed
placed{k}:
  %result{k} = phi ptr {own}[ %made{k}, %new{k} ]"""
            + (f"\n  br label %new{k + 1}" if k + 1 < len(outputs) else "")
        )
    stores: list[str] = []
    for k, port in enumerate(outputs):
        place = first + k
        stores.append(f"""  %memory.at{k} = getelementptr i8, ptr %result{k}, i64 {ARRAY_DATA}
  %memory{k} = load ptr, ptr %memory.at{k}, align 8
  %memory.to{k} = getelementptr ptr, ptr %data, i64 {place}
  store ptr %memory{k}, ptr %memory.to{k}, align 8
  %step.to{k} = getelementptr i64, ptr %steps, i64 {place}
  store i64 {8 * port.size}, ptr %step.to{k}, align 8""")
        step = 8 * port.size
        for axis, size in enumerate(port.shape):
            step //= max(size, 1)
            stores.append(
                f"  %inner.to{k}.{axis} = getelementptr i64, ptr %steps, i64 {starts[place] + axis}\n"
                f"  store i64 {step}, ptr %inner.to{k}.{axis}, align 8"
            )
    return "\n".join(lines), "\n".join(stores)


def _apart(signature: Signature) -> str:
    """No argument may lie under `out`: NumPy knows what to do then. All are contiguous here, or one point."""
    first, size = len(signature.inputs), signature.outputs[0].size
    lines: list[str] = []
    for k, port in enumerate(signature.inputs):
        lines.append(f"""apart{k}:
  %under.at{k} = getelementptr ptr, ptr %data, i64 {k}
  %under{k} = load ptr, ptr %under.at{k}, align 8
  %under.end{k} = getelementptr i8, ptr %under{k}, i64 %room.of.{k}
  %starts.after{k} = icmp uge ptr %under{k}, %above.end
  %ends.before{k} = icmp ule ptr %under.end{k}, %above
  %clear{k} = or i1 %starts.after{k}, %ends.before{k}
  br i1 %clear{k}, label %apart{k + 1}, label %slow""".replace(
            f"apart{k}:\n", f"apart{k}:\n  %room.of.{k} = mul i64 %count, {8 * port.size}\n"
        ))  # fmt: skip
    extent = f"""
  %above.at = getelementptr i8, ptr %out.known, i64 {ARRAY_DATA}
  %above = load ptr, ptr %above.at, align 8
  %above.size = mul i64 %count, {8 * size}
  %above.end = getelementptr i8, ptr %above, i64 %above.size"""
    text = "\n".join(lines).replace("apart0:", "apart0:" + extent, 1)
    return f"{text}\napart{first}:\n  br label %batch.out.take"


def _hand(count: int) -> str:
    """One array, or a tuple of them."""
    if count == 1:
        return "  ret ptr %result0"
    puts = "\n".join(f"  %put{k} = call i32 %set(ptr %tuple, i64 {k}, ptr %result{k})" for k in range(count))
    return f"""  %tuple.at = getelementptr i8, ptr %table, i64 {at("PyTuple_New")}
  %tuple.new = load ptr, ptr %tuple.at, align 8
  %set.at = getelementptr i8, ptr %table, i64 {at("PyTuple_SetItem")}
  %set = load ptr, ptr %set.at, align 8
  %tuple = call ptr %tuple.new(i64 {count})
  %tuple.made = icmp ne ptr %tuple, null
  br i1 %tuple.made, label %tuple.fill, label %failed
tuple.fill:
{puts}
  ret ptr %tuple"""


def row_ns(operations: int, lanes: int, signature: Signature) -> float:
    """Nanoseconds of one row of a batch on one core of a quick machine; slower ones take up to twice as long.

    Args:
        operations: of one evaluation.
        lanes: rows that are evaluated together.
        signature: gives the bytes of the results.
    """
    size = 8 * sum(port.size for port in signature.outputs)
    return max(operations * OPERATION_NS / max(lanes, 1) + size * BYTE_NS, 1.0)


def rows_for_one_thread(row: float) -> int:
    """Rows of the largest batch that is worth no second thread.

    Args:
        row: nanoseconds of one row.
    """
    return max(1, int((2 * HANDED_OVER_NS - 1) / row))
