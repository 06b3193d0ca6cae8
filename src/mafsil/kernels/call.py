"""The fast single call: a builtin in machine code that takes NumPy arrays, allocates the results and calls the kernel.

In C it would be some forty lines around `PyArray_New`; here LLVM's assembler is printed: no compiler is at hand.
What a call `robot.gravity_torque(q)` goes through:

1. CPython calls CALL with the arguments in an array (its METH_FASTCALL convention): self, args, their number, and a
   tuple of keyword names or null.
2. Every argument is looked at (`_input`): is it the very type that is expected, contiguous, aligned, float64, of the
   right shape? Every test that fails jumps to one block, `slow`, which hands the untouched call to FORMS.
3. POINT checks that the numbers are finite (`_finite`), allocates the results through NumPy (`_allocate`), and calls
   the kernel's single entry with pointers to the numbers.
4. The results go out as one array, one number, or a tuple (`_answer`): of the class that BIND received, if there is
   one, unless their last number is not one.

The doubtful cases (lists, other types, batches, names) are those of `forms`, and behind it of Python; no object is
changed before all tests have passed, so starting over on the slow path is always right.

The code depends on the shapes of the signature alone, so all kernels of these shapes share it in the cache. It reads
the public structs of CPython and NumPy at the offsets of `runtime`, which must have passed its self-test. Addresses of
the running process (types, functions of NumPy) come from a table that is bound at load (BIND): machine code from the
disk knows no address.

How to read the IR: `%v = load ptr, ptr %p` is `v = *p`; `getelementptr i8, ptr %p, i64 n` is `(char *)p + n`;
`br i1 %c, label %a, label %b` is `if (c) goto a; else goto b;`; `phi` takes the value that belongs to the block from
which one comes.
"""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Hashable
from typing import Any

from mafsil.kernels import forms, runtime, small_batch
from mafsil.kernels.forms import FORMS, ODD, POINT
from mafsil.kernels.layout import BATCH, LOOP, Port, Signature
from mafsil.kernels.runtime import (
    ARRAY_DATA,
    ARRAY_DTYPE,
    ARRAY_FLAGS,
    ARRAY_NDIM,
    ARRAY_SHAPE,
    CONTIGUOUS_ALIGNED,
    DOUBLE,
    DTYPE_NUMBER,
    DTYPE_ORDER,
    FLOAT_VALUE,
    TABLE,
    TYPE,
    names,
    table,
)
from mafsil.kernels.small_batch import FEW, MOST, TO_LOOP, TO_SINGLE

CALL = "mafsil_call"
"""Symbol of the builtin, CPython's METH_FASTCALL | METH_KEYWORDS convention."""
BIND = "mafsil_bind"
"""Symbol that takes the addresses of the process's table, of the names of the inputs, and of the class of answers."""
_LOOP_ARGUMENTS = "(ptr %args, ptr %dims, ptr %steps, ptr %data)"
_LINKS = f"""
@{TO_SINGLE} = dso_local global ptr null, align 8
@{TO_LOOP} = dso_local global ptr null, align 8
@{MOST} = dso_local global i64 0, align 8
"""
_FASTCALL_KEYWORDS = 0x0080 | 0x0002
_UNROLLED = 64
LARGE = 1e60
"""Numbers from here on may overflow in products of a few of them: their results are looked at, on the slow path."""


def wrapper(signature: Signature, triple: str) -> str:
    """LLVM IR of the module around a kernel: the same for all kernels of these shapes.

    Args:
        signature: ports of the kernel.
        triple: LLVM triple of the target, which decides how the floating-point environment is kept.
    """
    declarations, enter, leave = _environment(triple)
    few = f"define dso_local void @{FEW}{_LOOP_ARGUMENTS} noinline {{\nentry:"
    head = [f'target triple = "{triple}"', declarations, _LINKS, few]
    body = [f"{enter}{small_batch.few(signature)}{leave}  ret void\n}}", _bind()]
    calls = _Wrapper(signature, triple).text() + _Wrapper(signature, triple).point()
    return "\n".join([*head, *body, calls, forms.entry(signature)])


def loop(triple: str) -> str:
    """LLVM IR of LOOP, to be appended to the module of the batch entry.

    Args:
        triple: as for `wrapper`.
    """
    declarations, enter, leave = _environment(triple)
    batch = f"  call void @{BATCH}{_LOOP_ARGUMENTS}\n"
    return f"\n{declarations}define dso_local void @{LOOP}{_LOOP_ARGUMENTS} {{\n{enter}{batch}{leave}  ret void\n}}\n"


def builtin(
    address: int,
    bind: int,
    signature: Signature,
    doc: str,
    fallback: Callable[..., Any],
    owner: object,
    parameters: str = "",
    answer: type[tuple[Any, ...]] | None = None,
) -> Callable[..., Any]:
    """The Python builtin around the compiled call.

    Args:
        address: of CALL.
        bind: address of BIND.
        signature: gives the name.
        doc: docstring.
        fallback: called with the same arguments whenever they are not plain contiguous float64 arrays of core shape.
        owner: object that must outlive the builtin, such as the kernel; if it has this builtin as `call` and
            pickles, so does the builtin.
        parameters: of the call, as Python writes them; the ports, `out` and `threads` if empty.
        answer: class of the results of one point; see `Kernel.answer`.
    """
    taken = ctypes.addressof(table()), ctypes.addressof(names(signature)), None if answer is None else id(answer)
    ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3)(bind)(*taken)
    ports = ", ".join(port.name for port in signature.inputs)
    head = f"{signature.name}{parameters or f'({ports}, *, out=None, threads=None)'}\n--\n\n"
    texts = (signature.name.encode(), (head + doc).encode())
    method = runtime.method_def(texts[0], address, _FASTCALL_KEYWORDS, texts[1])
    keeper = _Fallback(signature.name, fallback, owner, (texts, answer))
    return runtime.builtin(method, keeper, __name__)


class _Fallback(dict[Hashable, Callable[..., Any]]):
    """The builtin's `__self__`: the slow path, and what must live as long as the builtin.

    As a dictionary it holds builtins for forms of the call that mean another kernel: under the text of `frame`, the
    tuple of keyword names, or the number of positional arguments. The machine code looks here before the slow path.

    A builtin pickles as the attribute of its name of its `__self__`; here that is the owner's `call`.
    """

    __slots__ = ("_call_through", "_keep", "_name", "_owner")

    def __init__(self, name: str, call_through: Callable[..., Any], owner: object, keep: object) -> None:
        super().__init__()
        self._name = name
        self._call_through = call_through
        self._owner = owner
        self._keep = keep

    def __call__(self, *args: Any, **keywords: Any) -> Any:
        return self._call_through(*args, **keywords)

    def __getattr__(self, name: str) -> Any:
        if name != self._name:
            raise AttributeError(name)
        return getattr(self._owner, "call")  # noqa: B009 - the owner is any object with a `call`

    def __reduce__(self) -> tuple[Callable[[Any], object], tuple[object]]:
        return _fallback_of, (self._owner,)


def _fallback_of(owner: Any) -> object:
    return owner.call.__self__


def _bind() -> str:
    return f"""
@mafsil_runtime = internal global ptr null, align 8
@mafsil_names = internal global ptr null, align 8
@mafsil_answer = internal global ptr null, align 8
define void @{BIND}(ptr %table, ptr %names, ptr %answer) {{
  store ptr %table, ptr @mafsil_runtime, align 8
  store ptr %names, ptr @mafsil_names, align 8
  store ptr %answer, ptr @mafsil_answer, align 8
  ret void
}}
"""


def _environment(triple: str) -> tuple[str, str, str]:
    """Declarations, and IR before and after a loop: rounding, denormals and sticky flags as the standard has them.

    Rows run through both sides of every select, so flags that are raised say nothing; NumPy would warn of them.
    """
    enter, leave, declarations = "", "", ""
    if triple.startswith(("x86_64", "i686", "amd64")):
        declarations = "declare void @llvm.x86.sse.stmxcsr(ptr)\ndeclare void @llvm.x86.sse.ldmxcsr(ptr)\n"
        enter = """  %found = alloca i32, align 4
  %wanted = alloca i32, align 4
  store i32 8064, ptr %wanted, align 4
  call void @llvm.x86.sse.stmxcsr(ptr %found)
  call void @llvm.x86.sse.ldmxcsr(ptr %wanted)
"""
        leave = "  call void @llvm.x86.sse.ldmxcsr(ptr %found)\n"
    elif triple.startswith(("aarch64", "arm64")):
        declarations = "".join(
            f"declare i64 @llvm.aarch64.get.{r}()\ndeclare void @llvm.aarch64.set.{r}(i64)\n" for r in ("fpcr", "fpsr")
        )
        enter = """  %control = call i64 @llvm.aarch64.get.fpcr()
  %status = call i64 @llvm.aarch64.get.fpsr()
  call void @llvm.aarch64.set.fpcr(i64 0)
"""
        leave = """  call void @llvm.aarch64.set.fpcr(i64 %control)
  call void @llvm.aarch64.set.fpsr(i64 %status)
"""
    return declarations, enter, leave


class _Wrapper:
    """Prints the IR of the call, block by block; every doubt branches to %slow.

    `_emit` appends an instruction, `_value` one with a result under a fresh name, `_branch` an `if not: goto slow`.
    """

    def __init__(self, signature: Signature, triple: str) -> None:
        self._signature = signature
        self._triple = triple
        self._lines: list[str] = []
        self._constants: list[str] = []
        self._count = 0

    def text(self) -> str:
        """The builtin itself: plain arguments are recognised here, all others by FORMS."""
        # 1. All inputs by position and no keywords; with any, FORMS sorts them.
        count = len(self._signature.inputs)
        self._branch(self._value("icmp eq ptr %kwnames, null"))
        self._branch(self._value(f"icmp eq i64 %nargs, {count}"))
        # 2. A pointer to the numbers of every argument.
        self._emit("%table = load ptr, ptr @mafsil_runtime, align 8")
        data = [self._input(i, port) for i, port in enumerate(self._signature.inputs)]
        # 3. and 4. ODD (a pointer that no object has) says that only Python may judge these numbers.
        answer = self._value(f"call ptr @{POINT}({', '.join(f'ptr {x}' for x in (*data, 'null'))})")
        self._branch(self._value(f"icmp ne ptr {answer}, {ODD}"))
        self._emit(f"ret ptr {answer}")
        # `tail`: the frame of this function is gone before FORMS begins.
        self._open("slow")
        self._emit(f"%unusual = tail call ptr @{FORMS}(ptr %self, ptr %args, i64 %nargs, ptr %kwnames)")
        self._emit("ret ptr %unusual")
        return self._closed(f"define ptr @{CALL}(ptr %self, ptr %args, i64 %nargs, ptr %kwnames)")

    def point(self) -> str:
        """The evaluation at one point whose numbers are in place; see `forms.POINT`."""
        # The kernel's code is its own module, put in place when it is in memory; until then Python brings it.
        self._emit(f"%single = load ptr, ptr @{TO_SINGLE}, align 8")
        self._branch(self._value("icmp ne ptr %single, null"))
        self._environment()
        self._emit("%table = load ptr, ptr @mafsil_runtime, align 8")
        data = [f"%x{i}" for i in range(len(self._signature.inputs))]
        for pointer, port in zip(data, self._signature.inputs, strict=True):
            self._finite(pointer, port.size)
        self._results(data)
        self._open("failed")  # out of memory: NumPy has set the exception
        self._emit("ret ptr null")
        self._open("slow")
        self._emit(f"ret ptr {ODD}")
        return self._closed(f"define internal ptr @{POINT}({', '.join(f'ptr {x}' for x in (*data, '%out'))}) noinline")

    def _closed(self, head: str) -> str:
        """The lines so far as a function."""
        return "\n".join([*self._constants, f"{head} {{\nentry:", *self._lines, "}", ""])

    def _emit(self, line: str) -> None:
        self._lines.append("  " + line)

    def _value(self, expression: str) -> str:
        self._count += 1
        self._emit(f"%v{self._count} = {expression}")
        return f"%v{self._count}"

    def _label(self) -> str:
        self._count += 1
        return f"b{self._count}"

    def _open(self, label: str) -> None:
        self._lines.append(f"{label}:")

    def _branch(self, condition: str, otherwise: str = "slow") -> None:
        """Go on if the condition holds."""
        # A basic block ends with its branch; what follows is a new block, entered only if the condition holds.
        label = self._label()
        self._emit(f"br i1 {condition}, label %{label}, label %{otherwise}")
        self._open(label)

    def _load(self, kind: str, base: str, offset: int, align: int = 8) -> str:
        """A field of a struct: *(kind *)(base + offset)."""
        at = self._value(f"getelementptr i8, ptr {base}, i64 {offset}") if offset else base
        return self._value(f"load {kind}, ptr {at}, align {align}")

    def _runtime(self, name: str) -> str:
        """An address of this process: an entry of the table that BIND received, eight bytes each."""
        return self._load("ptr", "%table", 8 * TABLE.index(name))

    def _environment(self) -> None:
        """Another library may have set flush-to-zero or a rounding direction; the loop of the slow path undoes that."""
        # x86: the six exception flags (bits 0 to 5) do not matter, 65472 masks them; 8064 is the state at start: all
        # exceptions masked, to nearest, denormals kept. AArch64: bits 22 to 25 are rounding and flush-to-zero.
        if self._triple.startswith(("x86_64", "i686", "amd64")):
            self._emit("%mode = alloca i32, align 4")
            self._emit("call void @llvm.x86.sse.stmxcsr(ptr %mode)")
            control = self._value(f"and i32 {self._load('i32', '%mode', 0, 4)}, 65472")
            self._branch(self._value(f"icmp eq i32 {control}, 8064"))
        elif self._triple.startswith(("aarch64", "arm64")):
            control = self._value(f"and i64 {self._value('call i64 @llvm.aarch64.get.fpcr()')}, 62914560")
            self._branch(self._value(f"icmp eq i64 {control}, 0"))

    def _input(self, index: int, port: Port) -> str:
        """Pointer to the numbers of one argument, after all its checks."""
        # The exact type, not a subclass: those may have changed what an array is.
        argument = self._load("ptr", "%args", 8 * index)
        kind = self._load("ptr", argument, TYPE)
        is_array = self._value(f"icmp eq ptr {kind}, {self._runtime('ndarray')}")
        if port.shape == ():
            return self._scalar(argument, kind, is_array)
        self._branch(is_array)
        return self._array(argument, port)

    def _scalar(self, argument: str, kind: str, is_array: str) -> str:
        """A Python float or a NumPy float64 holds its number inside; an array of no dimensions points to it."""
        # if (is_array) data = array's; else if (float or np.float64) data = inside the object; else goto slow
        array, other, joined = self._label(), self._label(), self._label()
        self._emit(f"br i1 {is_array}, label %{array}, label %{other}")
        self._open(other)
        plain = self._value(f"icmp eq ptr {kind}, {self._runtime('PyFloat')}")
        numpy = self._value(f"icmp eq ptr {kind}, {self._runtime('npfloat64')}")
        self._branch(self._value(f"or i1 {plain}, {numpy}"))
        inside = self._value(f"getelementptr i8, ptr {argument}, i64 {FLOAT_VALUE}")
        last = self._lines_label()
        self._emit(f"br label %{joined}")
        self._open(array)
        pointed = self._array(argument, Port("", ()))
        from_array = self._lines_label()
        self._emit(f"br label %{joined}")
        self._open(joined)
        return self._value(f"phi ptr [ {inside}, %{last} ], [ {pointed}, %{from_array} ]")

    def _lines_label(self) -> str:
        """The block that is being written, which `phi` wants to know."""
        return next(line[:-1] for line in reversed(self._lines) if line.endswith(":"))

    def _array(self, argument: str, port: Port) -> str:
        """Pointer to the numbers of an array, which is C-contiguous, aligned, of float64 and of the core's shape.

        These are the struct fields behind `ndim`, `flags`, `dtype`, `shape` and `data` in Python.
        """
        ndim = self._load("i32", argument, ARRAY_NDIM, 4)
        flags = self._load("i32", argument, ARRAY_FLAGS, 4)
        layout = self._value(f"and i32 {flags}, {CONTIGUOUS_ALIGNED}")
        plain = self._value(f"icmp eq i32 {layout}, {CONTIGUOUS_ALIGNED}")
        rank = self._value(f"icmp eq i32 {ndim}, {len(port.shape)}")
        self._branch(self._value(f"and i1 {plain}, {rank}"))
        self._double(self._load("ptr", argument, ARRAY_DTYPE))
        if port.shape:
            shape = self._load("ptr", argument, ARRAY_SHAPE)
            for axis, size in enumerate(port.shape):
                self._branch(self._value(f"icmp eq i64 {self._load('i64', shape, 8 * axis)}, {size}"))
        return self._load("ptr", argument, ARRAY_DATA)

    def _double(self, dtype: str) -> None:
        """The dtype is NumPy's float64, or a copy of it as unpickled arrays carry."""
        copy, good = self._label(), self._label()
        same = self._value(f"icmp eq ptr {dtype}, {self._runtime('float64')}")
        self._emit(f"br i1 {same}, label %{good}, label %{copy}")
        self._open(copy)
        order = self._value(f"icmp eq i8 {self._load('i8', dtype, DTYPE_ORDER, 1)}, {ord('=')}")
        number = self._value(f"icmp eq i32 {self._load('i32', dtype, DTYPE_NUMBER, 4)}, {DOUBLE}")
        both = self._value(f"and i1 {order}, {number}")
        self._emit(f"br i1 {both}, label %{good}, label %slow")
        self._open(good)

    def _finite(self, pointer: str, size: int) -> None:
        """Sums of squares are below a bound unless there is a NaN, an infinity or a number that may overflow.

        The slow path tells these apart. Blocks may overlap, so no tail is needed.
        """
        if size == 0:
            return
        # One NaN or infinity makes the sum of squares NaN or infinite, so one comparison serves all numbers: a test of
        # each would take longer than many a kernel. `uge` also holds for NaN (unordered).
        width = 4 if size >= 4 else 2 if size >= 2 else 1
        kind = f"<{width} x double>"
        if size > _UNROLLED:
            total = self._long_sum(pointer, size, kind)
        else:
            starts = [*range(0, size - width, width), size - width]
            total = self._squares([self._load(kind, pointer, 8 * start) for start in starts], kind)
        bound = ", ".join([f"double {LARGE**2:e}"] * width)
        wrong = self._value(f"fcmp uge {kind} {total}, <{bound}>")
        # The mask as one small integer: 0 if no lane is beyond the bound.
        bits = self._value(f"bitcast <{width} x i1> {wrong} to i{width}")
        self._branch(self._value(f"icmp eq i{width} {bits}, 0"))

    def _squares(self, blocks: list[str], kind: str, total: str = "") -> str:
        """The sum of the total so far and the squares of blocks; products and sums may be contracted."""
        for x in blocks:
            square = self._value(f"fmul contract {kind} {x}, {x}")
            total = self._value(f"fadd contract {kind} {total}, {square}") if total else square
        return total

    def _long_sum(self, pointer: str, size: int, kind: str) -> str:
        """The same sum as a loop over blocks of four."""
        # do { total += square(x[i .. i+3]); i += 4; } while (i <= size - 4); the last block may overlap the one before.
        before, loop, after = self._lines_label(), self._label(), self._label()
        self._emit(f"br label %{loop}")
        self._open(loop)
        self._count += 2
        index, total = f"%i{self._count}", f"%s{self._count}"
        self._emit(f"{index} = phi i64 [ 0, %{before} ], [ {index}.next, %{loop} ]")
        self._emit(f"{total} = phi {kind} [ zeroinitializer, %{before} ], [ {total}.next, %{loop} ]")
        at = self._value(f"getelementptr double, ptr {pointer}, i64 {index}")
        square = self._squares([self._load(kind, at, 0)], kind)
        self._emit(f"{total}.next = fadd contract {kind} {total}, {square}")
        self._emit(f"{index}.next = add i64 {index}, 4")
        more = self._value(f"icmp sle i64 {index}.next, {size - 4}")
        self._emit(f"br i1 {more}, label %{loop}, label %{after}")
        self._open(after)
        return self._squares([self._load(kind, pointer, 8 * (size - 4))], kind, f"{total}.next")

    def _results(self, data: list[str]) -> None:
        """Allocate every output, or take `out` for the only one, evaluate, and hand out one array or a tuple."""
        # Where an allocation fails after others have succeeded, those leak: out of memory, that is the least concern.
        outputs = self._signature.outputs
        one = len(outputs) == 1 and outputs[0].shape != ()
        arrays = (
            [self._given_or_new(outputs[0])] if one else [self._allocate(i, port) for i, port in enumerate(outputs)]
        )
        pointers = data + [self._load("ptr", array, ARRAY_DATA) for array in arrays]
        self._emit(f"call void %single({', '.join('ptr ' + p for p in pointers)})")
        if len(outputs) == 1:
            self._emit(f"ret ptr {self._answer(arrays[0], outputs[0])}")
            return
        made = self._tuple(arrays, pointers[-1])
        answers = [self._answer(array, port) for array, port in zip(arrays, outputs, strict=True)]
        for position, answer in enumerate(answers):
            self._value(f"call i32 {self._runtime('PyTuple_SetItem')}(ptr {made}, i64 {position}, ptr {answer})")
        self._emit(f"ret ptr {made}")

    def _tuple(self, arrays: list[str], last: str) -> str:
        """A new tuple for the results, of the class of answers if there is one; not a number as `last` goes to slow."""
        plain, own, give, judged, joined = (self._label() for _ in range(5))
        kind = self._value("load ptr, ptr @mafsil_answer, align 8")
        none = self._value(f"icmp eq ptr {kind}, null")
        self._emit(f"br i1 {none}, label %{plain}, label %{own}")
        self._open(own)
        number = self._load("double", last, 8 * (self._signature.outputs[-1].size - 1))
        doubtful = self._value(f"fcmp uno double {number}, 0.0")
        self._emit(f"br i1 {doubtful}, label %{give}, label %{judged}")
        self._open(give)
        for array in arrays:
            self._emit(f"call void {self._runtime('Py_DecRef')}(ptr {array})")
        self._emit("br label %slow")
        self._open(judged)
        allocate = self._runtime("PyType_GenericAlloc")
        answer = self._value(f"call ptr {allocate}(ptr {kind}, i64 {len(arrays)})")
        self._emit(f"br label %{joined}")
        self._open(plain)
        common = self._value(f"call ptr {self._runtime('PyTuple_New')}(i64 {len(arrays)})")
        self._emit(f"br label %{joined}")
        self._open(joined)
        made = self._value(f"phi ptr [ {answer}, %{judged} ], [ {common}, %{plain} ]")
        self._branch(self._value(f"icmp ne ptr {made}, null"), "failed")
        return made

    def _given_or_new(self, port: Port) -> str:
        """`out`, which whoever hands it over has checked, or a new array."""
        # The caller gets a reference of its own to what is handed back, also to an `out` that it gave.
        keep, fresh, joined = self._label(), self._label(), self._label()
        none = self._value("icmp eq ptr %out, null")
        self._emit(f"br i1 {none}, label %{fresh}, label %{keep}")
        self._open(keep)
        self._emit(f"call void {self._runtime('Py_IncRef')}(ptr %out)")
        self._emit(f"br label %{joined}")
        self._open(fresh)
        made = self._allocate(0, port)
        from_fresh = self._lines_label()
        self._emit(f"br label %{joined}")
        self._open(joined)
        return self._value(f"phi ptr [ %out, %{keep} ], [ {made}, %{from_fresh} ]")

    def _allocate(self, index: int, port: Port) -> str:
        """A new array: PyArray_New(&PyArray_Type, ndim, shape, NPY_DOUBLE, no strides, no data, 0, 0, no parent)."""
        shape = "null"
        if port.shape:
            sizes = ", ".join(f"i64 {size}" for size in port.shape)
            shape = f"@mafsil_shape{index}"
            self._constants.append(f"{shape} = private constant [{len(port.shape)} x i64] [{sizes}], align 8")
        made = self._value(
            f"call ptr {self._runtime('PyArray_New')}(ptr {self._runtime('ndarray')}, i32 {len(port.shape)}, "
            f"ptr {shape}, i32 {DOUBLE}, ptr null, ptr null, i32 0, i32 0, ptr null)"
        )
        self._branch(self._value(f"icmp ne ptr {made}, null"), "failed")
        return made

    def _answer(self, array: str, port: Port) -> str:
        """An array as it is; one without dimensions becomes a NumPy number, as NumPy's own functions hand it out."""
        if port.shape:
            return array
        return self._value(f"call ptr {self._runtime('PyArray_Return')}(ptr {array})")
