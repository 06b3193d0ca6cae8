"""Unusual forms of a call in machine code: names, `out=`, lists, strided rows, single precision, and small batches.

What the builtin of `call` does not recognise at once comes here; only what is not recognised here goes on to Python:

1. A form for which there is a builtin of its own, such as a named frame, is found in the dictionary `self` and called.
2. Keywords take their places among the arguments; `out` is set apart; one thread is what there is here.
3. Arguments of one point are brought into contiguous memory, and the point is evaluated (`POINT` of `call`).
4. Else arguments of one batch dimension are handed with their strides to the batch entry.

Nothing is converted that NumPy would convert to other bits, and no number of a caller is changed before all is checked.
"""

from __future__ import annotations

from mafsil.kernels.emitter import prototypes
from mafsil.kernels.gathering import GATHERING
from mafsil.kernels.gathering import place as at
from mafsil.kernels.layout import Signature
from mafsil.kernels.runtime import SIZE, TYPE
from mafsil.kernels.small_batch import rows_of_one_batch

FORMS = "mafsil_forms"
"""Symbol of the function behind the builtin, of the same convention."""
POINT = "mafsil_point"
"""Symbol that evaluates one point: ptr (double *in0, ..., PyArrayObject *out); null after an error, ODD if not."""
ODD = "inttoptr (i64 1 to ptr)"
"""What POINT answers for numbers that only Python may judge."""
_MOST_NUMBERS = 1024
"""Numbers of all arguments that are copied to the stack."""


def entry(signature: Signature) -> str:
    """LLVM IR of FORMS.

    Args:
        signature: ports of the kernel.
    """
    plain = all(len(port.shape) < 2 for port in signature.inputs) and signature.inputs
    if not plain or sum(port.size for port in signature.inputs) > _MOST_NUMBERS:
        return _head() + "\n  br label %slow\n" + _slow()
    parts = [
        _head(),
        _twins(signature),
        _frame(signature),
        _CALL_OF_TWIN,
        _name(signature),
        _given(signature),
        _point(signature),
    ]
    return "\n".join([*prototypes(GATHERING), _core(signature), *parts, rows_of_one_batch(signature), _slow()])


def _head() -> str:
    return f"define internal ptr @{FORMS}(ptr %self, ptr %args, i64 %nargs, ptr %kwnames) noinline {{\nentry:"


def _core(signature: Signature) -> str:
    """The core shape of the first result, to compare `out` with."""
    shape = signature.outputs[0].shape
    sizes = ", ".join(f"i64 {size}" for size in shape)
    return f"@mafsil_core = private constant [{len(shape)} x i64] [{sizes}], align 8"


def _memory(signature: Signature) -> str:
    """What the function keeps on the stack.

    `given` the arguments in the order of the inputs (one place more for `out` behind a frame), `data`, `steps` and
    `rows` what the batch entry takes, `shape` that of a new result, and for every input a buffer for its numbers.
    """
    ports, total = len(signature.ports), len(signature.ports) + sum(len(port.shape) for port in signature.ports)
    buffers = "".join(
        f"\n  %buffer{k} = alloca [{max(port.size, 1)} x double], align 8" for k, port in enumerate(signature.inputs)
    )
    return f"""
  %given = alloca [{len(signature.inputs) + 1} x ptr], align 8
  %data = alloca [{ports} x ptr], align 8
  %steps = alloca [{total} x i64], align 8
  %rows = alloca i64, align 8
  %shape = alloca [{1 + max(len(port.shape) for port in signature.outputs)} x i64], align 8{buffers}"""


def _slow() -> str:
    return f"""
slow:
  %slow.table = load ptr, ptr @mafsil_runtime, align 8
  %slow.at = getelementptr i8, ptr %slow.table, i64 {at("PyObject_Vectorcall")}
  %slow.through = load ptr, ptr %slow.at, align 8
  %slow.answer = tail call ptr %slow.through(ptr %self, ptr %args, i64 %nargs, ptr %kwnames)
  ret ptr %slow.answer
}}
"""


def _twins(signature: Signature) -> str:
    """Step 1: more inputs by position than the kernel has, all of them and a frame, or names it does not know.

    A builtin that is found in `self` is called with the same arguments, without the frame.
    """
    count = len(signature.inputs)
    return f"""{_memory(signature)}
  %table = load ptr, ptr @mafsil_runtime, align 8
  %names = load ptr, ptr @mafsil_names, align 8
  %vectorcall.at = getelementptr i8, ptr %table, i64 {at("PyObject_Vectorcall")}
  %getitem.at = getelementptr i8, ptr %table, i64 {at("PyDict_GetItem")}
  %out.at = getelementptr i8, ptr %table, i64 {at("out")}
  %out.name = load ptr, ptr %out.at, align 8
  %more = icmp sgt i64 %nargs, {count}
  %exact = icmp eq i64 %nargs, {count}
  %unnamed = icmp eq ptr %kwnames, null
  br i1 %more, label %twin.count, label %twin.maybe
twin.count:                                                  ; step 1: too many by position: self[nargs]
  %number.at = getelementptr i8, ptr %table, i64 {at("PyLong_FromSsize_t")}
  %number.make = load ptr, ptr %number.at, align 8
  %number = call ptr %number.make(i64 %nargs)
  %number.made = icmp ne ptr %number, null
  br i1 %number.made, label %twin.ask, label %failed
twin.ask:
  %count.getitem = load ptr, ptr %getitem.at, align 8
  %count.twin = call ptr %count.getitem(ptr %self, ptr %number)
  %drop.at = getelementptr i8, ptr %table, i64 {at("Py_DecRef")}
  %drop = load ptr, ptr %drop.at, align 8
  call void %drop(ptr %number)
  br label %twin.call
twin.maybe:                                                  ; any keywords?
  br i1 %unnamed, label %unnamed.few, label %twin.named
twin.named:
  %kw.size.at = getelementptr i8, ptr %kwnames, i64 {SIZE}
  %kw.size = load i64, ptr %kw.size.at, align 8
  %kw.some = icmp sgt i64 %kw.size, 0
  br i1 %kw.some, label %twin.first, label %slow
twin.first:                                                  ; is the first keyword the very string `frame`?
  %items.at = getelementptr i8, ptr %table, i64 {at("tuple_items")}
  %items.offset = load i64, ptr %items.at, align 8
  %kw.items = getelementptr i8, ptr %kwnames, i64 %items.offset
  %kw.first = load ptr, ptr %kw.items, align 8
  %frame.at = getelementptr i8, ptr %table, i64 {at("frame")}
  %frame.name = load ptr, ptr %frame.at, align 8
  %is.frame = icmp eq ptr %kw.first, %frame.name
  %framed = and i1 %exact, %is.frame
  br i1 %framed, label %twin.last, label %given.copy"""


def _frame(signature: Signature) -> str:
    """Step 1, all inputs by position, a frame, and perhaps `out`: the frame is left out of the call."""
    count = len(signature.inputs)
    without_frame = "\n".join(
        f"  %kept.at{k} = getelementptr ptr, ptr %args, i64 {k if k < count else k + 1}\n"
        f"  %kept{k} = load ptr, ptr %kept.at{k}, align 8\n"
        f"  %kept.to{k} = getelementptr ptr, ptr %given, i64 {k}\n  store ptr %kept{k}, ptr %kept.to{k}, align 8"
        for k in range(count + 1)
    )
    return f"""
twin.last:                                                   ; a frame may have `out` behind it, nothing else
  %kw.before = sub i64 %kw.size, 1
  %kw.last.at = getelementptr ptr, ptr %kw.items, i64 %kw.before
  %kw.last = load ptr, ptr %kw.last.at, align 8
  %ends.out = icmp eq ptr %kw.last, %out.name
  %kw.real = select i1 %ends.out, i64 %kw.before, i64 %kw.size
  %only.at = getelementptr i8, ptr %table, i64 {at("out_alone")}
  %only = load ptr, ptr %only.at, align 8
  %only.frame = icmp eq i64 %kw.real, 1
  br i1 %only.frame, label %twin.frame, label %slow
twin.frame:                                                  ; its value must be a plain string: self[frame]
  %frame.value.at = getelementptr ptr, ptr %args, i64 {count}
  %frame.value = load ptr, ptr %frame.value.at, align 8
  %frame.type.at = getelementptr i8, ptr %frame.value, i64 {TYPE}
  %frame.type = load ptr, ptr %frame.type.at, align 8
  %str.at = getelementptr i8, ptr %table, i64 {at("str")}
  %str = load ptr, ptr %str.at, align 8
  %is.text = icmp eq ptr %frame.type, %str
  br i1 %is.text, label %twin.frame.ask, label %slow
twin.frame.ask:
  %frame.getitem = load ptr, ptr %getitem.at, align 8
  %frame.twin = call ptr %frame.getitem(ptr %self, ptr %frame.value)
  br i1 %ends.out, label %twin.frame.out, label %twin.call
twin.frame.out:                                              ; the arguments again, the frame left out
{without_frame}
  br label %twin.call"""


_CALL_OF_TWIN = """
twin.keywords:                                               ; unknown names: self[tuple of names]
  %kw.getitem = load ptr, ptr %getitem.at, align 8
  %kw.twin = call ptr %kw.getitem(ptr %self, ptr %kwnames)
  br label %twin.call
twin.call:                                                   ; found: with which arguments, and are there any names
  %twin = phi ptr [ %count.twin, %twin.ask ], [ %frame.twin, %twin.frame.ask ], [ %frame.twin, %twin.frame.out ], \
[ %kw.twin, %twin.keywords ]
  %twin.args = phi ptr [ %args, %twin.ask ], [ %args, %twin.frame.ask ], [ %given, %twin.frame.out ], \
[ %args, %twin.keywords ]
  %twin.nargs = phi i64 [ %nargs, %twin.ask ], [ %nargs, %twin.frame.ask ], [ %nargs, %twin.frame.out ], \
[ %nargs, %twin.keywords ]
  %twin.names = phi ptr [ %kwnames, %twin.ask ], [ null, %twin.frame.ask ], [ %only, %twin.frame.out ], \
[ %kwnames, %twin.keywords ]
  %twin.known = icmp ne ptr %twin, null
  br i1 %twin.known, label %twin.go, label %slow
twin.go:
  %vectorcall = load ptr, ptr %vectorcall.at, align 8
  %twin.answer = call ptr %vectorcall(ptr %twin, ptr %twin.args, i64 %twin.nargs, ptr %twin.names)
  ret ptr %twin.answer
unnamed.few:
  br i1 %exact, label %given.copy, label %slow"""


def _name(signature: Signature) -> str:
    """Step 2: keywords to their places; every place must be taken once.

    1. The arguments by position in their places.
    2. Of each keyword: `out` is kept apart, threads=1 needs nothing, any other is searched among the names.
    3. Every place is taken.
    """
    count = len(signature.inputs)
    last = f"copy.leave{count - 1}"
    full = "\n".join(
        f"  %place.at{k} = getelementptr ptr, ptr %given, i64 {k}\n  %place{k} = load ptr, ptr %place.at{k}, align 8\n"
        f"  %place.taken{k} = icmp ne ptr %place{k}, null\n"
        f"  br i1 %place.taken{k}, label %full{k + 1}, label %slow\nfull{k + 1}:"
        for k in range(count)
    )
    return f"""
given.copy:                                                  ; 2.1: given[k] = k < nargs ? args[k] : null
  %kw.count = phi i64 [ %kw.size, %twin.first ], [ 0, %unnamed.few ]
  %kw.list = phi ptr [ %kw.items, %twin.first ], [ null, %unnamed.few ]
{_copy(count)}
  br label %keyword.loop
keyword.loop:                                                ; 2.2: for k in 0 ... keywords: sort one into its place
  %k = phi i64 [ 0, %{last} ], [ %k.next, %keyword.next ]
  %out = phi ptr [ null, %{last} ], [ %out.next, %keyword.next ]
  %k.more = icmp slt i64 %k, %kw.count
  br i1 %k.more, label %keyword, label %full0
keyword:                                                     ; values of keywords stand behind the positional ones
  %keyword.at = getelementptr ptr, ptr %kw.list, i64 %k
  %keyword.name = load ptr, ptr %keyword.at, align 8
  %value.index = add i64 %nargs, %k
  %value.at = getelementptr ptr, ptr %args, i64 %value.index
  %value = load ptr, ptr %value.at, align 8
  %k.next = add i64 %k, 1
  %keyword.out = icmp eq ptr %keyword.name, %out.name
  br i1 %keyword.out, label %keyword.next, label %keyword.other
keyword.other:
  %threads.at = getelementptr i8, ptr %table, i64 {at("threads")}
  %threads.name = load ptr, ptr %threads.at, align 8
  %keyword.threads = icmp eq ptr %keyword.name, %threads.name
  br i1 %keyword.threads, label %threads, label %search
threads:                                                     ; threads=1 is what happens here; others are Python's
  %one.at = getelementptr i8, ptr %table, i64 {at("one")}
  %one = load ptr, ptr %one.at, align 8
  %threads.one = icmp eq ptr %value, %one
  br i1 %threads.one, label %keyword.next, label %slow
search:                                                      ; names of source code are interned: equal is same
  %s = phi i64 [ 0, %keyword.other ], [ %s.next, %search.next ]
  %s.name.at = getelementptr ptr, ptr %names, i64 %s
  %s.name = load ptr, ptr %s.name.at, align 8
  %s.same = icmp eq ptr %s.name, %keyword.name
  br i1 %s.same, label %search.found, label %search.next
search.next:
  %s.next = add i64 %s, 1
  %s.more = icmp slt i64 %s.next, {count}
  br i1 %s.more, label %search, label %twin.keywords
search.found:                                                ; a place that is taken is an error, which Python says
  %s.place = getelementptr ptr, ptr %given, i64 %s
  %s.before = load ptr, ptr %s.place, align 8
  %s.free = icmp eq ptr %s.before, null
  br i1 %s.free, label %search.take, label %slow
search.take:
  store ptr %value, ptr %s.place, align 8
  br label %keyword.next
keyword.next:
  %out.next = phi ptr [ %value, %keyword ], [ %out, %threads ], [ %out, %search.take ]
  br label %keyword.loop
full0:                                                       ; 2.3
{full}
  br label %out.none"""


def _copy(count: int) -> str:
    """The arguments by position in their places, null in the others."""
    return "\n".join(
        f"  %copy.from{k} = getelementptr ptr, ptr %args, i64 {k}\n"
        f"  %copy.there{k} = icmp sgt i64 %nargs, {k}\n"
        f"  br i1 %copy.there{k}, label %copy.take{k}, label %copy.leave{k}\n"
        f"copy.take{k}:\n  %copy.value{k} = load ptr, ptr %copy.from{k}, align 8\n  br label %copy.leave{k}\n"
        f"copy.leave{k}:\n"
        f"  %copy.found{k} = phi ptr [ %copy.value{k}, %copy.take{k} ], [ null, %{_before(k)} ]\n"
        f"  %copy.to{k} = getelementptr ptr, ptr %given, i64 {k}\n  store ptr %copy.found{k}, ptr %copy.to{k}, align 8"
        for k in range(count)
    )


def _before(k: int) -> str:
    return f"copy.leave{k - 1}" if k else "given.copy"


def _given(signature: Signature) -> str:
    """Step 2, the end: `out` is one contiguous writable array of doubles, or there is none; None is none."""
    outputs = signature.outputs
    taken = len(outputs) == 1 and outputs[0].shape != ()
    return f"""
out.none:
  %no.out = icmp eq ptr %out, null
  br i1 %no.out, label %ready, label %out.check
out.check:                                                   ; `out` is for kernels with one array as result
  br i1 {"true" if taken else "false"}, label %out.array, label %slow
out.array:
  %out.good = call i1 @mafsil_writable(ptr %out, ptr %table)
  br i1 %out.good, label %ready, label %slow
ready:
  %out.known = phi ptr [ null, %out.none ], [ %out, %out.array ]
  %with.out = xor i1 %no.out, true"""


def _point(signature: Signature) -> str:
    """Step 3: every argument of one point as contiguous doubles; the first that is none leads to step 4."""
    lines: list[str] = []
    for k, port in enumerate(signature.inputs):
        size = f", i64 {port.size}" if port.shape else ""
        reader = "mafsil_vector" if port.shape else "mafsil_number"
        lines.append(
            f"  %numbers{k} = call ptr @{reader}(ptr %place{k}, ptr %buffer{k}{size}, ptr %table)\n"
            f"  %numbers.there{k} = icmp ne ptr %numbers{k}, null\n"
            f"  br i1 %numbers.there{k}, label %point{k + 1}, label %batch0\npoint{k + 1}:"
        )
    pointers = ", ".join(f"ptr %numbers{k}" for k in range(len(signature.inputs)))
    reading = "\n".join(lines)
    rank = len(signature.outputs[0].shape)
    return f"""
{reading}
  br i1 %no.out, label %point.go, label %point.out
point.out:                                                   ; step 3 with `out`: its shape is that of one point
  %point.out.fits = call i1 @mafsil_shaped(ptr %out.known, i32 0, i64 0, i32 {rank}, ptr @mafsil_core)
  br i1 %point.out.fits, label %point.go, label %slow
point.go:
  %point.answer = call ptr @{POINT}({pointers}, ptr %out.known)
  %point.odd = icmp eq ptr %point.answer, {ODD}
  br i1 %point.odd, label %slow, label %point.done
point.done:
  ret ptr %point.answer"""
