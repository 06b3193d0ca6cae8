"""The machine code through which Python calls a loop, printed block by block; `entry` says what it does."""

from __future__ import annotations

import numpy as np

from mafsil.kernels.loops import arrays, entry
from mafsil.kernels.loops.block import Block
from mafsil.kernels.loops.entry import ENTRY, FUNCTIONS, LINKS, NAMES, classes_of
from mafsil.kernels.loops.kinds import (
    BOOL,
    COMPLEX,
    INTEGER,
    NONE,
    REAL,
    SLOT,
    UNSIGNED,
    Array,
    Held,
    Kind,
    Tuple,
    by_address,
    has_arrays,
    refusal,
    return_types,
)
from mafsil.kernels.runtime import (
    ARRAY_DATA,
    ARRAY_DTYPE,
    ARRAY_FLAGS,
    ARRAY_NDIM,
    ARRAY_SHAPE,
    ARRAY_STRIDES,
    DTYPE_NUMBER,
    DTYPE_ORDER,
    FLOAT_VALUE,
    SIZE,
    TYPE,
)

_CONTIGUOUS, _ALIGNED, _NEW_FLAGS = 0x1, 0x100, 0x501
_OWN_TYPES: dict[Kind, str] = {BOOL: "bool", INTEGER: "int", UNSIGNED: "npuint", REAL: "float", COMPLEX: "complex"}
_MAKERS: dict[Kind, str] = {
    INTEGER: "PyLong_FromLongLong", UNSIGNED: "PyLong_FromUnsignedLongLong", REAL: "PyFloat_FromDouble",
}  # fmt: skip


class Entry:
    """Prints the entry for some kinds.

    Args:
        kinds: of the arguments.
        result: kind of the result; None for an entry that only writes its first argument to the address that is the
            second.
        fails, shares: as in `Translation`.
    """

    def __init__(self, kinds: tuple[Kind, ...], result: Kind | None, fails: bool, shares: bool) -> None:
        self.kinds, self.result, self.fails, self.shares = kinds, result, fails, shares
        self.classes = classes_of(kinds, result)
        self.block = Block("")

    def texts(self) -> list[str]:
        """Its functions."""
        block = self.block
        block.do("%links = load ptr, ptr @mafsil_links_at")
        block.do("%classes = load ptr, ptr @mafsil_classes")
        self.test(f"icmp eq i64 %nargs, {len(self.kinds)}")
        objects = [self.load("ptr", "%args", SLOT * i) for i in range(len(self.kinds))]
        if self.result is None:
            place = self.whole(objects[1])
            address = block.let(f"inttoptr i64 {place} to ptr")
            self.write(self.kinds[0], objects[0], address, 0)
            self.give("none")
        else:
            given = [text for kind, each in zip(self.kinds, objects, strict=True) for text in self.argument(kind, each)]
            self.run(given, self.result)
        block.label("miss")
        self.give("miss")
        body = "\n".join([*block.heads, *block.lines])
        head = f"define ptr @{ENTRY}(ptr %self, ptr %args, i64 %nargs) nounwind {{\nentry:\n"
        return [_BIND, _FITS, head + body + "\n}\n", *([_ARRAY] if self.result and has_arrays(self.result) else [])]

    def module(self) -> str:
        """Its module in LLVM IR."""
        texts = self.texts()
        return arrays.module_text(texts, self.block.declared | {arrays.FREE})

    # Tests and loads --------------------------------------------------------------------------------------------------

    def load(self, kind: str, base: str, offset: int) -> str:
        """A field of a struct."""
        return self.block.let(f"load {kind}, ptr {self.block.offset(base, offset)}")

    def link(self, name: str) -> str:
        """An address of this process."""
        return self.load("ptr", "%links", SLOT * NAMES.index(name))

    def call(self, name: str, *given: str) -> str:
        """Call a function of CPython."""
        result, *types = FUNCTIONS[name]
        arguments = ", ".join(f"{kind} {each}" for kind, each in zip(types, given, strict=True))
        text = f"call {result} {self.link(name)}({arguments})"
        if result == "void":
            self.block.do(text)
            return ""
        return self.block.let(text)

    def test(self, condition: str) -> None:
        """Go on if it holds."""
        ahead = self.block.fresh("ahead")
        self.block.branch(self.block.let(condition), ahead, "miss")
        self.block.label(ahead)

    def give(self, name: str) -> None:
        """Return an object that everybody knows."""
        found = self.link(name)
        self.call("Py_IncRef", found)
        self.block.end(f"ret ptr {found}")

    def require_type(self, of: str, name: str) -> None:
        """Go on if an object is of the very type."""
        self.test(f"icmp eq ptr {self.load('ptr', of, TYPE)}, {self.link(name)}")

    def of_class(self, of: str, kind: type[object]) -> None:
        """Go on if an object is of the very class."""
        wanted = self.load("ptr", "%classes", SLOT * self.classes.index(kind))
        self.test(f"icmp eq ptr {self.load('ptr', of, TYPE)}, {wanted}")

    # Arguments --------------------------------------------------------------------------------------------------------

    def argument(self, kind: Kind, of: str) -> list[str]:
        """An argument as the loop takes it, with its types."""
        if by_address(kind):
            place = self.block.room(kind.size)
            self.write(kind, of, place, 0)
            return [f"ptr {place}"]
        return [f"{part} {each}" for part, each in zip(kind.parts, self.parts(kind, of), strict=True)]

    def write(self, kind: Kind, of: str, place: str, offset: int) -> None:
        """An argument into slots of memory."""
        if isinstance(kind, Tuple):
            for i, item in enumerate(self.items(kind, of)):
                self.write(kind.items[i], item, place, offset + kind.offsets[i])
            return
        for part, each in zip(kind.parts, self.parts(kind, of), strict=True):
            stored, word = (self.block.let(f"zext i1 {each} to i8"), "i8") if part == "i1" else (each, part)
            self.block.do(f"store {word} {stored}, ptr {self.block.offset(place, offset)}")
            offset += SLOT

    def items(self, kind: Tuple, of: str) -> list[str]:
        """The items of a tuple of the class and size."""
        if kind.named:
            self.of_class(of, kind.named)
        else:
            self.require_type(of, "tuple")
            self.test(f"icmp eq i64 {self.load('i64', of, SIZE)}, {len(kind.items)}")
        return [self.load("ptr", of, tuple.__basicsize__ + SLOT * i) for i in range(len(kind.items))]

    def parts(self, kind: Kind, of: str) -> list[str]:
        """The parts of an argument."""
        if isinstance(kind, Tuple):
            items = self.items(kind, of)
            return [part for item, each in zip(kind.items, items, strict=True) for part in self.parts(item, each)]
        if isinstance(kind, Held):
            self.of_class(of, entry.class_of(kind))
            place = self.whole(self.load("ptr", of, tuple.__basicsize__))
            return [self.block.let(f"inttoptr i64 {place} to ptr")]
        if isinstance(kind, Array):
            return self.array(kind, of)
        if kind is NONE:
            self.test(f"icmp eq ptr {of}, {self.link('none')}")
            return []
        return self.number(kind, of)

    def number(self, kind: Kind, of: str) -> list[str]:
        """The parts of a number: Python's own, or NumPy's."""
        own = _OWN_TYPES.get(kind)
        if own is None:
            raise refusal(f"{kind} as an argument from Python")
        if kind is UNSIGNED:
            self.require_type(of, own)
            return [self.load("i64", of, FLOAT_VALUE)]
        block = self.block
        other, mine, joined = block.fresh("numpy"), block.fresh("python"), block.fresh("joined")
        is_own = block.let(f"icmp eq ptr {self.load('ptr', of, TYPE)}, {self.link(own)}")
        block.branch(is_own, mine, other)
        block.label(mine)
        first = self.own_number(kind, of)
        first_end = block.here
        block.jump(joined)
        block.label(other)
        self.require_type(of, f"np{own}")
        second = [
            self.load({"i1": "i8"}.get(part, part), of, FLOAT_VALUE + SLOT * i) for i, part in enumerate(kind.parts)
        ]
        if kind is BOOL:
            second = [block.let(f"trunc i8 {second[0]} to i1")]
        second_end = block.here
        block.label(joined)
        return [
            block.let(f"phi {part} [ {a}, %{first_end} ], [ {b}, %{second_end} ]")
            for part, a, b in zip(kind.parts, first, second, strict=True)
        ]

    def own_number(self, kind: Kind, of: str) -> list[str]:
        """The parts of a number of Python."""
        if kind is BOOL:
            return [self.block.let(f"icmp eq ptr {of}, {self.link('true')}")]
        if kind is INTEGER:
            return [self.whole(of)]
        return [self.load("double", of, FLOAT_VALUE + SLOT * i) for i in range(len(kind.parts))]

    def whole(self, of: str) -> str:
        """A whole number of 64 bits."""
        beyond = self.block.room(8)
        found = self.call("PyLong_AsLongLongAndOverflow", of, beyond)
        self.test(f"icmp eq i32 {self.load('i32', beyond, 0)}, 0")
        return found

    def array(self, kind: Array, of: str) -> list[str]:
        """Address, sizes and strides of an array of these elements and axes."""
        wanted = _ALIGNED | (_CONTIGUOUS if kind.contiguous else 0)
        number = np.dtype(kind.of.name).num
        fits = f"call i1 @mafsil_fits(ptr {of}, i32 {kind.ndim}, i32 {wanted}, i32 {number})"
        self.test(fits)
        shape = self.load("ptr", of, ARRAY_SHAPE) if kind.ndim else ""
        sizes = [self.load("i64", shape, SLOT * axis) for axis in range(kind.ndim)]
        steps: list[str] = []
        if not kind.contiguous:
            strides = self.load("ptr", of, ARRAY_STRIDES)
            steps = [self.load("i64", strides, SLOT * axis) for axis in range(kind.ndim)]
        return [self.load("ptr", of, ARRAY_DATA), *sizes, *steps]

    # The call and its result ------------------------------------------------------------------------------------------

    def run(self, given: list[str], result: Kind) -> None:
        """Call the loop without the interpreter's lock, and make its result."""
        block = self.block
        if self.shares:
            block.heads += ["  %region = alloca ptr", "  store ptr null, ptr %region"]
            given = [*given, "ptr %region"]
        kinds = return_types(result, self.fails)
        llvm = kinds[0] if len(kinds) == 1 else f"{{ {', '.join(kinds)} }}" if kinds else "void"
        target, thread = block.let("load ptr, ptr @mafsil_target"), self.call("PyEval_SaveThread")
        text = f"call {llvm} {target}({', '.join(given)})"
        made = block.let(text) if kinds else block.do(text)
        self.call("PyEval_RestoreThread", thread)
        parts = [str(made)] if len(kinds) == 1 else [
            block.let(f"extractvalue {llvm} {made}, {i}") for i in range(len(kinds))
        ]  # fmt: skip
        if self.fails:
            good, bad = block.fresh("good"), block.fresh("bad")
            block.branch(parts.pop(), bad, good)
            block.label(bad)
            self.release()
            block.end(f"ret ptr {self.call('PyErr_NoMemory')}")
            block.label(good)
        found = self.object(result, parts)
        self.release()
        block.end(f"ret ptr {found}")

    def release(self) -> None:
        """Give back what no array keeps."""
        if self.shares:
            self.block.do("call void @mafsil_release_rest(ptr %region)")

    def object(self, kind: Kind, parts: list[str]) -> str:
        """The object of Python for a result."""
        if isinstance(kind, Tuple):
            return self.tuple(kind, parts)
        if isinstance(kind, Array):
            return self.new_array(kind, parts)
        if kind is NONE:
            none = self.link("none")
            self.call("Py_IncRef", none)
            return none
        if kind is BOOL:
            return self.call("PyBool_FromLong", self.block.let(f"zext i1 {parts[0]} to i64"))
        if kind is COMPLEX:
            return self.call("PyComplex_FromDoubles", *parts)
        if kind not in _MAKERS:
            raise refusal(f"{kind} as a result for Python")
        return self.call(_MAKERS[kind], parts[0])

    def tuple(self, kind: Tuple, parts: list[str]) -> str:
        """A tuple, of its class if it has one."""
        if kind.named:
            wanted = self.load("ptr", "%classes", SLOT * self.classes.index(kind.named))
            made = self.call("PyType_GenericAlloc", wanted, str(len(kind.items)))
        else:
            made = self.call("PyTuple_New", str(len(kind.items)))
        for i, item in enumerate(kind.items):
            self.call("PyTuple_SetItem", made, str(i), self.object(item, parts[: len(item.parts)]))
            parts = parts[len(item.parts) :]
        return made

    def new_array(self, kind: Array, parts: list[str]) -> str:
        """An array over memory that the loop made, or over that of an argument."""
        places: list[str] = []
        for begin in (1, 1 + kind.ndim):
            numbers = parts[begin : begin + kind.ndim]
            place = self.block.room(max(SLOT * len(numbers), SLOT)) if numbers else "null"
            for axis, number in enumerate(numbers):
                self.block.do(f"store i64 {number}, ptr {self.block.offset(place, SLOT * axis)}")
            places.append(place)
        number = np.dtype(kind.of.name).num
        region = "%region" if self.shares else "null"
        return self.block.let(
            f"call ptr @mafsil_array(ptr {parts[0]}, i32 {kind.ndim}, ptr {places[0]}, ptr {places[1]}, "
            f"i32 {number}, ptr {region}, ptr %args, i64 %nargs)"
        )


_BIND = f"""
@mafsil_links_at = internal global ptr null
@mafsil_classes = internal global ptr null
@mafsil_target = internal global ptr null
define void @{LINKS}(ptr %links, ptr %classes, ptr %target) {{
  store ptr %links, ptr @mafsil_links_at
  store ptr %classes, ptr @mafsil_classes
  store ptr %target, ptr @mafsil_target
  ret void
}}
"""


def _link(name: str) -> str:
    return str(SLOT * NAMES.index(name))


_FITS = f"""
define internal i1 @mafsil_fits(ptr %of, i32 %ndim, i32 %wanted, i32 %number) noinline nounwind {{
entry:
  %links = load ptr, ptr @mafsil_links_at
  %nd_at = getelementptr i8, ptr %links, i64 {_link("ndarray")}
  %nd = load ptr, ptr %nd_at
  %type_at = getelementptr i8, ptr %of, i64 {TYPE}
  %type = load ptr, ptr %type_at
  %is_array = icmp eq ptr %type, %nd
  br i1 %is_array, label %array, label %no
array:
  %axes_at = getelementptr i8, ptr %of, i64 {ARRAY_NDIM}
  %axes = load i32, ptr %axes_at
  %flags_at = getelementptr i8, ptr %of, i64 {ARRAY_FLAGS}
  %flags = load i32, ptr %flags_at
  %dtype_at = getelementptr i8, ptr %of, i64 {ARRAY_DTYPE}
  %dtype = load ptr, ptr %dtype_at
  %number_at = getelementptr i8, ptr %dtype, i64 {DTYPE_NUMBER}
  %its = load i32, ptr %number_at
  %order_at = getelementptr i8, ptr %dtype, i64 {DTYPE_ORDER}
  %order = load i8, ptr %order_at
  %counted = and i32 %flags, {_ALIGNED | _CONTIGUOUS}
  %a = icmp eq i32 %axes, %ndim
  %b = icmp eq i32 %counted, %wanted
  %c = icmp eq i32 %its, %number
  %d = icmp eq i8 %order, {ord("=")}
  %e = icmp eq i8 %order, {ord("|")}
  %ab = and i1 %a, %b
  %abc = and i1 %ab, %c
  %de = or i1 %d, %e
  %all = and i1 %abc, %de
  ret i1 %all
no:
  ret i1 false
}}
"""
"""Whether an object is an array of so many axes, of elements of this number and order, with these flags."""

_ARRAY = f"""
define internal void @mafsil_forget(ptr %capsule) {{
  %links = load ptr, ptr @mafsil_links_at
  %at = getelementptr i8, ptr %links, i64 {_link("PyCapsule_GetPointer")}
  %get = load ptr, ptr %at
  %raw = call ptr %get(ptr %capsule, ptr null)
  call void @free(ptr %raw)
  ret void
}}
define internal ptr @mafsil_array(ptr %data, i32 %ndim, ptr %shape, ptr %strides, i32 %number, ptr %region,
    ptr %args, i64 %nargs) {{
entry:
  %links = load ptr, ptr @mafsil_links_at
  %nd_at = getelementptr i8, ptr %links, i64 {_link("ndarray")}
  %nd = load ptr, ptr %nd_at
  %new_at = getelementptr i8, ptr %links, i64 {_link("PyArray_New")}
  %new = load ptr, ptr %new_at
  %inc_at = getelementptr i8, ptr %links, i64 {_link("Py_IncRef")}
  %inc = load ptr, ptr %inc_at
  %view = call ptr %new(ptr %nd, i32 %ndim, ptr %shape, i32 %number, ptr %strides, ptr %data, i32 0,
    i32 {_NEW_FLAGS}, ptr null)
  %none = icmp eq ptr %view, null
  br i1 %none, label %failed, label %look
failed:
  ret ptr null
look:
  %alone = icmp eq ptr %region, null
  br i1 %alone, label %given, label %first
first:
  %head = load ptr, ptr %region
  br label %next
next:
  %block = phi ptr [ %head, %first ], [ %after, %ahead ]
  %end = icmp eq ptr %block, null
  br i1 %end, label %given, label %inside
inside:
  %size_at = getelementptr i8, ptr %block, i64 8
  %size = load i64, ptr %size_at
  %begin_at = getelementptr i8, ptr %block, i64 16
  %begin = load i64, ptr %begin_at
  %place = ptrtoint ptr %data to i64
  %by = sub i64 %place, %begin
  %low = icmp ule i64 %by, %size
  br i1 %low, label %found, label %ahead
ahead:
  %after = load ptr, ptr %block
  br label %next
found:
  %keeper_at = getelementptr i8, ptr %block, i64 24
  %known = load ptr, ptr %keeper_at
  %kept = icmp ne ptr %known, null
  br i1 %kept, label %again, label %fresh
again:
  call void %inc(ptr %known)
  br label %set
fresh:
  %cap_at = getelementptr i8, ptr %links, i64 {_link("PyCapsule_New")}
  %cap = load ptr, ptr %cap_at
  %capsule = call ptr %cap(ptr %block, ptr null, ptr @mafsil_forget)
  store ptr %capsule, ptr %keeper_at
  br label %set
given:
  %tuple_at = getelementptr i8, ptr %links, i64 {_link("PyTuple_New")}
  %tuple_new = load ptr, ptr %tuple_at
  %item_at = getelementptr i8, ptr %links, i64 {_link("PyTuple_SetItem")}
  %set_item = load ptr, ptr %item_at
  %tuple = call ptr %tuple_new(i64 %nargs)
  br label %more
more:
  %i = phi i64 [ 0, %given ], [ %then, %take ]
  %all = icmp eq i64 %i, %nargs
  br i1 %all, label %set, label %take
take:
  %arg_at = getelementptr ptr, ptr %args, i64 %i
  %arg = load ptr, ptr %arg_at
  call void %inc(ptr %arg)
  %stored = call i32 %set_item(ptr %tuple, i64 %i, ptr %arg)
  %then = add i64 %i, 1
  br label %more
set:
  %base = phi ptr [ %known, %again ], [ %capsule, %fresh ], [ %tuple, %more ]
  %set_at = getelementptr i8, ptr %links, i64 {_link("PyArray_SetBaseObject")}
  %setter = load ptr, ptr %set_at
  %done = call i32 %setter(ptr %view, ptr %base)
  ret ptr %view
}}
define internal void @mafsil_release_rest(ptr %list) {{
entry:
  %first = load ptr, ptr %list
  br label %look
look:
  %block = phi ptr [ %first, %entry ], [ %next, %on ]
  %end = icmp eq ptr %block, null
  br i1 %end, label %done, label %free
free:
  %next = load ptr, ptr %block
  %keeper_at = getelementptr i8, ptr %block, i64 24
  %keeper = load ptr, ptr %keeper_at
  %kept = icmp ne ptr %keeper, null
  br i1 %kept, label %on, label %give
give:
  call void @free(ptr %block)
  br label %on
on:
  br label %look
done:
  ret void
}}
"""
"""An array over memory: it keeps the block of the list that its numbers lie in, or else the arguments."""
