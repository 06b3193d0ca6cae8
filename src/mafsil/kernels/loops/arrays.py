"""Arrays of compiled loops: elements, views, memory of their own.

An array is its address and its sizes; one that is not contiguous in C order has strides too, in bytes. Nothing is
checked when an element is read: negative indices count from the end, others are taken as they are.

Memory of running loops, as LLVM IR that is part of each module that needs it: blocks in a list, freed together.

A function that makes arrays has a list of their blocks, and frees them when it ends. Arrays can leave a function only
in its result; one with arrays in its result adds to the list of its caller.
"""

from __future__ import annotations

from dataclasses import dataclass

from mafsil.kernels import target
from mafsil.kernels.loops.block import METADATA, Block, Value, constant
from mafsil.kernels.loops.kinds import INTEGER, Array, Number, Tuple, array_of, refusal, tuple_of
from mafsil.kernels.loops.numbers import arithmetic, compare, convert, select_value

ALLOCATE, RELEASE, TIMES = "mafsil_allocate", "mafsil_release", "mafsil_times"
ALIGNMENT = 64
"""Bytes in front of the numbers of a block of memory; they begin with a cache line."""
ON_STACK = 4096
"""Bytes of an array of fixed size up to which it lies on the stack."""


@dataclass(frozen=True)
class Span:
    """A slice of an axis; no end is the axis's own, no step is one."""

    first: Value | None
    last: Value | None
    backwards: bool = False


Index = Value | Span


def sizes(value: Value) -> list[Value]:
    """The sizes of an array."""
    kind = value.kind
    assert isinstance(kind, Array)
    return [Value(INTEGER, (part,), _digits(part), True) for part in value.parts[1 : 1 + kind.ndim]]


def _digits(part: str) -> int | None:
    return int(part) if part.isdigit() else None


def make_array(kind: Array, data: str, shape: list[Value], strides: list[Value] | None = None) -> Value:
    """An array of these parts."""
    return Value(kind, (data, *(size.name for size in shape), *(stride.name for stride in strides or ())))


def strides(block: Block, value: Value) -> list[Value]:
    """Bytes from one element to the next along each axis."""
    kind = value.kind
    assert isinstance(kind, Array)
    if not kind.contiguous:
        return [Value(INTEGER, (part,), _digits(part)) for part in value.parts[1 + kind.ndim :]]
    found: list[Value] = []
    stride = constant(kind.itemsize)
    for size in reversed(sizes(value)):
        found.insert(0, stride)
        stride = _of(block, "*", stride, size)
    return found


def general(block: Block, value: Value) -> Value:
    """The same array, its strides said."""
    kind = value.kind
    assert isinstance(kind, Array)
    if not kind.contiguous:
        return value
    return make_array(array_of(kind.of, kind.ndim, False), value.name, sizes(value), strides(block, value))


def _of(block: Block, operation: str, a: Value, b: Value) -> Value:
    found = arithmetic(block, operation, a, b)
    assert found is not None
    return found


def wrap_index(block: Block, index: Value, size: Value) -> Value:
    """An index that counts from the end where it is negative."""
    index = convert(block, index, INTEGER)
    if index.natural:
        return index
    if index.constant is not None:
        return _of(block, "+", size, index)
    below = compare(block, "<", index, constant(0))
    return select_value(block, below.name, _of(block, "+", index, size), index)


def place(block: Block, array: Value, indices: list[Value]) -> str:
    """Address of an element."""
    kind, shape = array.kind, sizes(array)
    assert isinstance(kind, Array)
    found = [wrap_index(block, index, size) for index, size in zip(indices, shape, strict=True)]
    if not kind.contiguous:
        return _stepped(block, array.name, found, strides(block, array))
    total = found[0]
    for index, size in zip(found[1:], shape[1:], strict=True):
        total = _of(block, "+", _of(block, "*", total, size), index)
    element = kind.of.element if kind.itemsize <= 8 else "{ double, double }"
    return block.let(f"getelementptr inbounds {element}, ptr {array.name}, i64 {total.name}")


def _stepped(block: Block, data: str, indices: list[Value], steps: list[Value]) -> str:
    total = constant(0)
    for index, step in zip(indices, steps, strict=True):
        total = _of(block, "+", total, _of(block, "*", index, step))
    if total.constant == 0:
        return data
    return block.let(f"getelementptr inbounds i8, ptr {data}, i64 {total.name}")


def view(block: Block, array: Value, indices: list[Index]) -> Value:
    """The array that indices and slices leave, axis by axis from the first; axes that are not named stay whole."""
    kind, shape, steps = array.kind, sizes(array), strides(block, array)
    assert isinstance(kind, Array)
    if len(indices) > kind.ndim:
        raise refusal(f"{len(indices)} indices of {kind}")
    starts: list[Value] = []
    left: list[Value] = []
    left_steps: list[Value] = []
    for axis, size in enumerate(shape):
        index = indices[axis] if axis < len(indices) else Span(None, None)
        if isinstance(index, Span):
            first, count, step = _cut(block, index, size, steps[axis])
            starts.append(first)
            left.append(count)
            left_steps.append(step)
        else:
            starts.append(wrap_index(block, index, size))
    data = _stepped(block, array.name, starts, steps)
    contiguous = kind.contiguous and _stays_contiguous(indices)
    return make_array(array_of(kind.of, len(left), contiguous), data, left, None if contiguous else left_steps)


def _stays_contiguous(indices: list[Index]) -> bool:
    """Numbers first, then at most one slice, then whole axes."""
    spans = [index for index in indices if isinstance(index, Span)]
    numbers_first = all(isinstance(index, Value) for index in indices[: len(indices) - len(spans)])
    whole = all(span.first is None and span.last is None for span in spans[1:])
    return numbers_first and whole and not any(span.backwards for span in spans)


def _cut(block: Block, span: Span, size: Value, step: Value) -> tuple[Value, Value, Value]:
    """First element, count and stride of a slice, its ends brought inside as Python does."""
    if span.backwards:
        return _of(block, "-", size, constant(1)), size, _of(block, "*", step, constant(-1))
    first = constant(0) if span.first is None else _inside(block, span.first, size)
    last = size if span.last is None else _inside(block, span.last, size)
    if first.constant == 0:
        return first, last, step
    count = _of(block, "-", last, first)
    below = compare(block, "<", count, constant(0))
    found = select_value(block, below.name, constant(0), count)
    return first, Value(INTEGER, found.parts, None, True), step


def _inside(block: Block, end: Value, size: Value) -> Value:
    if end.constant == 0:
        return end
    end = wrap_index(block, end, size)
    if not end.natural:
        low = compare(block, "<", end, constant(0))
        end = select_value(block, low.name, constant(0), end)
    high = compare(block, ">", end, size)
    return Value(INTEGER, select_value(block, high.name, size, end).parts, None, True)


def allocate(block: Block, of: Number, shape: list[Value], region: str | None) -> Value:
    """A new array; its address is null where memory is lacking.

    Args:
        block: of the function.
        of: kind of its elements.
        shape: sizes.
        region: list of memory that it joins; None on the stack, where sizes are constants.
    """
    kind = array_of(of, len(shape))
    shape = [Value(INTEGER, convert(block, each, INTEGER).parts, each.constant, True) for each in shape]
    if region is None:
        data = block.room(max(fixed_size(of, shape) or 0, 8), ALIGNMENT)
    else:
        size = constant(kind.itemsize).name
        for each in shape:
            size = block.call(TIMES, "i64", f"i64 {size}", f"i64 {each.name}")
        data = block.call(ALLOCATE, "ptr", f"i64 {size}", f"ptr {region}")
    return make_array(kind, data, shape)


def clear(block: Block, array: Value) -> None:
    """Every byte of a contiguous array set to zero."""
    assert isinstance(array.kind, Array)
    size = constant(array.kind.itemsize)
    for each in sizes(array):
        size = _of(block, "*", size, each)
    block.call("llvm.memset.p0.i64", "void", f"ptr {array.name}", "i8 0", f"i64 {size.name}", "i1 false")


def fixed_size(of: Number, shape: list[Value]) -> int | None:
    """Bytes of an array whose sizes are constants; None if they are not."""
    total = array_of(of, 1).itemsize
    for size in shape:
        if not isinstance(size.constant, int):
            return None
        total *= size.constant
    return total


def view_as(block: Block, array: Value, of: Number) -> Value:
    """The same memory as elements of another kind, of the last axis."""
    kind, shape = array.kind, sizes(array)
    assert isinstance(kind, Array)
    have, want = kind.itemsize, array_of(of, 1).itemsize
    if not kind.contiguous or (have != want and not shape):
        raise refusal(f"{kind} as {of}")
    if have > want:
        shape[-1] = _of(block, "*", shape[-1], constant(have // want))
    elif have < want:
        shape[-1] = _of(block, "//", shape[-1], constant(want // have))
    return make_array(array_of(of, kind.ndim), array.name, shape)


def reshape_array(array: Value, shape: list[Value]) -> Value:
    """The same elements under other sizes, which the caller has right."""
    kind = array.kind
    assert isinstance(kind, Array)
    if not kind.contiguous:
        raise refusal(f"other sizes for {kind}")
    return make_array(array_of(kind.of, len(shape)), array.name, shape)


def transpose(block: Block, array: Value) -> Value:
    """The axes in the other order."""
    kind = array.kind
    assert isinstance(kind, Array)
    if kind.ndim < 2:
        return array
    return make_array(array_of(kind.of, kind.ndim, False), array.name, sizes(array)[::-1], strides(block, array)[::-1])


def shape_of(array: Value) -> Value:
    """Its sizes as a tuple."""
    kind = array.kind
    assert isinstance(kind, Array)
    return Value(tuple_of((INTEGER,) * kind.ndim), array.parts[1 : 1 + kind.ndim])


def shape_from(block: Block, value: Value) -> list[Value]:
    """The sizes that a number or a tuple of numbers says."""
    if isinstance(value.kind, Tuple):
        return [block.item(value, i) for i in range(len(value.kind.items))]
    return [value]


HEAD = 32
"""Bytes that begin a block: the next one, its size, where its numbers begin, and the object that keeps it, if any."""
FREE = "declare void @free(ptr)"
_DECLARED = {FREE, "declare ptr @malloc(i64)", "declare { i64, i1 } @llvm.smul.with.overflow.i64(i64, i64)"}
_TEXT = f"""
define internal i64 @{TIMES}(i64 %a, i64 %b) alwaysinline nounwind {{
  %both = call {{ i64, i1 }} @llvm.smul.with.overflow.i64(i64 %a, i64 %b)
  %product = extractvalue {{ i64, i1 }} %both, 0
  %over = extractvalue {{ i64, i1 }} %both, 1
  %low = icmp slt i64 %a, 0
  %under = icmp slt i64 %b, 0
  %below = or i1 %low, %under
  %wrong = or i1 %over, %below
  %found = select i1 %wrong, i64 -1, i64 %product
  ret i64 %found
}}
define internal noalias ptr @{ALLOCATE}(i64 %size, ptr %list) noinline nounwind {{
entry:
  %sane = icmp ult i64 %size, {1 << 62}
  br i1 %sane, label %try, label %none
try:
  %whole = add i64 %size, {ALIGNMENT + 64}
  %raw = call ptr @malloc(i64 %whole)
  %got = icmp ne ptr %raw, null
  br i1 %got, label %made, label %none
made:
  %number = ptrtoint ptr %raw to i64
  %above = add i64 %number, {HEAD + ALIGNMENT - 1}
  %begin = and i64 %above, {-ALIGNMENT}
  %data = inttoptr i64 %begin to ptr
  %next = load ptr, ptr %list
  store ptr %next, ptr %raw
  %size_at = getelementptr i8, ptr %raw, i64 8
  store i64 %size, ptr %size_at
  %data_at = getelementptr i8, ptr %raw, i64 16
  store ptr %data, ptr %data_at
  %keeper_at = getelementptr i8, ptr %raw, i64 24
  store ptr null, ptr %keeper_at
  store ptr %raw, ptr %list
  ret ptr %data
none:
  ret ptr null
}}
define internal void @{RELEASE}(ptr %list) nounwind {{
entry:
  %first = load ptr, ptr %list
  br label %look
look:
  %block = phi ptr [ %first, %entry ], [ %next, %free ]
  %end = icmp eq ptr %block, null
  br i1 %end, label %done, label %free
free:
  %next = load ptr, ptr %block
  call void @free(ptr %block)
  br label %look
done:
  ret void
}}
"""


def module_text(texts: list[str], declared: set[str]) -> str:
    """A module of these functions and declarations, with what it needs of this file."""
    own = {line for line in declared if any(f"@{name}(" in line for name in (TIMES, ALLOCATE, RELEASE))}
    outside = (declared - own) | (_DECLARED if own else set[str]())
    head = [f'target triple = "{target.host().triple}"', *sorted(outside), *([_TEXT] if own else [])]
    return "\n".join([*head, *texts, METADATA])
