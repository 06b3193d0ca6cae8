"""Arguments of a call as machine code reads them: lists, tuples, numbers and strided arrays as contiguous doubles.

Functions in LLVM IR for `forms`; none of them changes an object, runs Python code or raises. What they do not know they
refuse (null or false), and Python sees to it. As C would declare them, `table` being that of `runtime.TABLE`:

1. bool is_array(object, table): the very type `numpy.ndarray`.
2. int dtype(array): NumPy's number of the type of the elements, -1 if their bytes are swapped.
3. bool flags(array, wanted): all of these flags are set.
4. bool writable(object, table): an array of doubles, contiguous, aligned, writable: fit for `out`.
5. bool shaped(array, lead, rows, rank, core): shape is (rows, *core), or core where lead is 0.
6. double *number(object, buffer, table): where one number lies; integers are converted into the buffer.
7. double *vector(object, buffer, size, table): where `size` numbers lie side by side; others are copied there.
8. bool row(object, rank, size, data, outer, inner, rows, close, table): base and strides of one argument of a batch.
"""

from __future__ import annotations

from mafsil.kernels.runtime import (
    ARRAY_DATA,
    ARRAY_DTYPE,
    ARRAY_FLAGS,
    ARRAY_NDIM,
    ARRAY_SHAPE,
    ARRAY_STRIDES,
    CONTIGUOUS_ALIGNED,
    DOUBLE,
    DTYPE_NUMBER,
    DTYPE_ORDER,
    FLOAT_VALUE,
    LIST_ITEMS,
    SINGLE_PRECISION,
    SIZE,
    TABLE,
    TYPE,
    WRITEABLE,
)

ALIGNED = 0x100
LARGEST_TYPED = 9.0
"""Of numbers in a list: larger ones are left to Python, which asks whether people mean degrees."""


def place(name: str) -> int:
    """Where an entry of the process's table lies, in bytes."""
    return 8 * TABLE.index(name)


def _field(name: str, base: str, offset: int, kind: str = "ptr", align: int = 8) -> str:
    return (
        f"  %{name}.at = getelementptr i8, ptr {base}, i64 {offset}\n"
        f"  %{name} = load {kind}, ptr %{name}.at, align {align}"
    )


_ARRAY = f"""
define internal i1 @mafsil_is_array(ptr %object, ptr %table) {{
{_field("kind", "%object", TYPE)}
{_field("array", "%table", place("ndarray"))}
  %same = icmp eq ptr %kind, %array
  ret i1 %same
}}
define internal i32 @mafsil_dtype(ptr %array) {{
{_field("dtype", "%array", ARRAY_DTYPE)}
{_field("order", "%dtype", DTYPE_ORDER, "i8", 1)}
{_field("number", "%dtype", DTYPE_NUMBER, "i32", 4)}
  %native = icmp eq i8 %order, {ord("=")}
  %known = select i1 %native, i32 %number, i32 -1
  ret i32 %known
}}
define internal i1 @mafsil_flags(ptr %array, i32 %wanted) {{
{_field("flags", "%array", ARRAY_FLAGS, "i32", 4)}
  %held = and i32 %flags, %wanted
  %all = icmp eq i32 %held, %wanted
  ret i1 %all
}}
define internal i1 @mafsil_writable(ptr %object, ptr %table) {{
  %is.array = call i1 @mafsil_is_array(ptr %object, ptr %table)
  br i1 %is.array, label %look, label %no
look:
  %flags = call i1 @mafsil_flags(ptr %object, i32 {CONTIGUOUS_ALIGNED | WRITEABLE})
  %number = call i32 @mafsil_dtype(ptr %object)
  %double = icmp eq i32 %number, {DOUBLE}
  %good = and i1 %flags, %double
  ret i1 %good
no:
  ret i1 false
}}
; lead is 0 or 1: whether a batch axis stands before the axes of the core
define internal i1 @mafsil_shaped(ptr %array, i32 %lead, i64 %rows, i32 %rank, ptr %core) {{
{_field("ndim", "%array", ARRAY_NDIM, "i32", 4)}
{_field("shape", "%array", ARRAY_SHAPE)}
  %wanted = add i32 %lead, %rank
  %right = icmp eq i32 %ndim, %wanted
  br i1 %right, label %first, label %no
first:                                                       ; the batch axis, if there is one
  %batched = icmp ne i32 %lead, 0
  br i1 %batched, label %length, label %axes
length:
  %found = load i64, ptr %shape, align 8
  %equal = icmp eq i64 %found, %rows
  br i1 %equal, label %axes, label %no
axes:                                                        ; then the core's, one by one
  %own = getelementptr i64, ptr %shape, i32 %lead
  br label %loop
loop:
  %axis = phi i32 [ 0, %axes ], [ %next, %compare ]
  %more = icmp slt i32 %axis, %rank
  br i1 %more, label %compare, label %yes
compare:
  %here.at = getelementptr i64, ptr %own, i32 %axis
  %here = load i64, ptr %here.at, align 8
  %there.at = getelementptr i64, ptr %core, i32 %axis
  %there = load i64, ptr %there.at, align 8
  %next = add i32 %axis, 1
  %fits = icmp eq i64 %here, %there
  br i1 %fits, label %loop, label %no
yes:
  ret i1 true
no:
  ret i1 false
}}
"""

_NUMBER = f"""
define internal ptr @mafsil_number(ptr %object, ptr %buffer, ptr %table) {{
  %beyond = alloca i32, align 4
{_field("kind", "%object", TYPE)}
{_field("float", "%table", place("PyFloat"))}
{_field("npfloat", "%table", place("npfloat64"))}
{_field("int", "%table", place("int"))}
  %is.float = icmp eq ptr %kind, %float
  %is.npfloat = icmp eq ptr %kind, %npfloat
  %is.real = or i1 %is.float, %is.npfloat
  br i1 %is.real, label %real, label %other
real:                                                        ; a float has its number inside
  %inside = getelementptr i8, ptr %object, i64 {FLOAT_VALUE}
  ret ptr %inside
other:
  %is.int = icmp eq ptr %kind, %int
  br i1 %is.int, label %whole, label %maybe
whole:                                                       ; an int: beyond 64 bits Python sees to it
{_field("convert", "%table", place("PyLong_AsLongLongAndOverflow"))}
  %value = call i64 %convert(ptr %object, ptr %beyond)
  %flag = load i32, ptr %beyond, align 4
  %inside.range = icmp eq i32 %flag, 0
  br i1 %inside.range, label %store, label %no
store:
  %real.value = sitofp i64 %value to double
  store double %real.value, ptr %buffer, align 8
  ret ptr %buffer
maybe:
  %is.array = call i1 @mafsil_is_array(ptr %object, ptr %table)
  br i1 %is.array, label %look, label %no
look:                                                        ; an array of no dimensions points to its number
{_field("ndim", "%object", ARRAY_NDIM, "i32", 4)}
  %point = icmp eq i32 %ndim, 0
  %number = call i32 @mafsil_dtype(ptr %object)
  %double = icmp eq i32 %number, {DOUBLE}
  %flags = call i1 @mafsil_flags(ptr %object, i32 {ALIGNED})
  %one = and i1 %point, %double
  %all = and i1 %one, %flags
  br i1 %all, label %held, label %no
held:
{_field("data", "%object", ARRAY_DATA)}
  ret ptr %data
no:
  ret ptr null
}}
"""

_VECTOR = f"""
define internal ptr @mafsil_vector(ptr %object, ptr %buffer, i64 %size, ptr %table) noinline {{
  %is.array = call i1 @mafsil_is_array(ptr %object, ptr %table)
  br i1 %is.array, label %array, label %sequence
array:                                                       ; one axis, aligned
{_field("ndim", "%object", ARRAY_NDIM, "i32", 4)}
  %row = icmp eq i32 %ndim, 1
  %aligned = call i1 @mafsil_flags(ptr %object, i32 {ALIGNED})
  %plain = and i1 %row, %aligned
  br i1 %plain, label %sized, label %no
sized:                                                       ; of the right length, float64 or float32
{_field("shape", "%object", ARRAY_SHAPE)}
{_field("strides", "%object", ARRAY_STRIDES)}
{_field("data", "%object", ARRAY_DATA)}
  %length = load i64, ptr %shape, align 8
  %step = load i64, ptr %strides, align 8
  %number = call i32 @mafsil_dtype(ptr %object)
  %fits = icmp eq i64 %length, %size
  %double = icmp eq i32 %number, {DOUBLE}
  %narrow = icmp eq i32 %number, {SINGLE_PRECISION}
  %close = icmp eq i64 %step, 8
  %there = and i1 %double, %close
  %known = or i1 %double, %narrow
  %good = and i1 %fits, %known
  br i1 %good, label %which, label %no
which:                                                       ; doubles side by side are read where they lie
  br i1 %there, label %held, label %copy
held:
  ret ptr %data
copy:                                                        ; for i in 0 ... size: buffer[i] = array[i]
  %i = phi i64 [ 0, %which ], [ %i.next, %copied ]
  %more = icmp slt i64 %i, %size
  br i1 %more, label %element, label %done
element:
  %offset = mul i64 %i, %step
  %from = getelementptr i8, ptr %data, i64 %offset
  %to = getelementptr double, ptr %buffer, i64 %i
  br i1 %double, label %wide, label %thin
wide:
  %wide.value = load double, ptr %from, align 8
  br label %copied
thin:
  %thin.value = load float, ptr %from, align 4
  %widened = fpext float %thin.value to double
  br label %copied
copied:
  %element.value = phi double [ %wide.value, %wide ], [ %widened, %thin ]
  store double %element.value, ptr %to, align 8
  %i.next = add i64 %i, 1
  br label %copy
sequence:                                                    ; a list or a tuple of the right length
{_field("kind", "%object", TYPE)}
{_field("list", "%table", place("list"))}
{_field("tuple", "%table", place("tuple"))}
{_field("int", "%table", place("int"))}
  %is.list = icmp eq ptr %kind, %list
  %is.tuple = icmp eq ptr %kind, %tuple
  %either = or i1 %is.list, %is.tuple
  br i1 %either, label %counted, label %no
counted:
{_field("count", "%object", SIZE, "i64")}
  %full = icmp eq i64 %count, %size
  br i1 %full, label %inside, label %no
inside:
  br i1 %is.list, label %of.list, label %of.tuple
of.list:                                                     ; items lie elsewhere
{_field("list.items", "%object", LIST_ITEMS)}
  br label %items
of.tuple:                                                    ; items follow the head of the object
{_field("tuple.offset", "%table", place("tuple_items"), "i64")}
  %tuple.items = getelementptr i8, ptr %object, i64 %tuple.offset
  br label %items
items:
  %first = phi ptr [ %list.items, %of.list ], [ %tuple.items, %of.tuple ]
  br label %loop
loop:                                                        ; for k in 0 ... size: buffer[k] = number(items[k])
  %k = phi i64 [ 0, %items ], [ %k.next, %kept ]
  %k.more = icmp slt i64 %k, %size
  br i1 %k.more, label %take, label %done
take:
  %item.at = getelementptr ptr, ptr %first, i64 %k
  %item = load ptr, ptr %item.at, align 8
  %own = getelementptr double, ptr %buffer, i64 %k
{_field("item.kind", "%item", TYPE)}
{_field("item.array", "%table", place("ndarray"))}
  %nested = icmp eq ptr %item.kind, %item.array
  br i1 %nested, label %no, label %convert
convert:
  %number.at = call ptr @mafsil_number(ptr %item, ptr %own, ptr %table)
  %converted = icmp ne ptr %number.at, null
  br i1 %converted, label %next, label %no
next:                                                        ; numbers that may be degrees are left to Python
  %number.value = load double, ptr %number.at, align 8
  %below = fcmp olt double %number.value, {LARGEST_TYPED:.1f}
  %above = fcmp ogt double %number.value, -{LARGEST_TYPED:.1f}
  %usual = and i1 %below, %above
  br i1 %usual, label %kept, label %no
kept:
  store double %number.value, ptr %own, align 8
  %k.next = add i64 %k, 1
  br label %loop
done:
  ret ptr %buffer
no:
  ret ptr null
}}
"""

_ROW = f"""
define internal i1 @mafsil_row(ptr %object, i32 %rank, i64 %size, ptr %data, ptr %outer, ptr %inner, ptr %rows, \
i1 %close, ptr %table) noinline {{
  %is.array = call i1 @mafsil_is_array(ptr %object, ptr %table)
  br i1 %is.array, label %array, label %lone
lone:                                                        ; a plain number stays the same in every row: stride 0
  %scalar = icmp eq i32 %rank, 0
  br i1 %scalar, label %number, label %no
number:
{_field("kind", "%object", TYPE)}
{_field("float", "%table", place("PyFloat"))}
{_field("npfloat", "%table", place("npfloat64"))}
  %is.float = icmp eq ptr %kind, %float
  %is.npfloat = icmp eq ptr %kind, %npfloat
  %is.real = or i1 %is.float, %is.npfloat
  br i1 %is.real, label %real, label %no
real:
  %value.at = getelementptr i8, ptr %object, i64 {FLOAT_VALUE}
  store ptr %value.at, ptr %data, align 8
  store i64 0, ptr %outer, align 8
  ret i1 true
array:
  %wanted = select i1 %close, i32 {CONTIGUOUS_ALIGNED}, i32 {ALIGNED}
  %flags = call i1 @mafsil_flags(ptr %object, i32 %wanted)
  %dtype = call i32 @mafsil_dtype(ptr %object)
  %double = icmp eq i32 %dtype, {DOUBLE}
  %plain = and i1 %flags, %double
  br i1 %plain, label %axes, label %no
axes:
{_field("ndim", "%object", ARRAY_NDIM, "i32", 4)}
{_field("shape", "%object", ARRAY_SHAPE)}
{_field("strides", "%object", ARRAY_STRIDES)}
{_field("numbers", "%object", ARRAY_DATA)}
  %lead = sub i32 %ndim, %rank
  %batched = icmp eq i32 %lead, 1
  %alone = icmp eq i32 %lead, 0
  %either = or i1 %batched, %alone
  br i1 %either, label %core, label %no
core:                                                        ; inner stride of a vector, and its length
  store ptr %numbers, ptr %data, align 8
  %vector = icmp eq i32 %rank, 1
  br i1 %vector, label %width, label %length
width:
  %size.at = getelementptr i64, ptr %shape, i32 %lead
  %size.found = load i64, ptr %size.at, align 8
  %step.at = getelementptr i64, ptr %strides, i32 %lead
  %step = load i64, ptr %step.at, align 8
  store i64 %step, ptr %inner, align 8
  %fits = icmp eq i64 %size.found, %size
  br i1 %fits, label %length, label %no
length:
  br i1 %batched, label %count, label %repeated
repeated:
  store i64 0, ptr %outer, align 8
  ret i1 true
count:                                                       ; all batches have one length; -1: none was seen yet
  %found = load i64, ptr %shape, align 8
  %stride = load i64, ptr %strides, align 8
  store i64 %stride, ptr %outer, align 8
  %before = load i64, ptr %rows, align 8
  store i64 %found, ptr %rows, align 8
  %first = icmp eq i64 %before, -1
  %same = icmp eq i64 %before, %found
  %agreed = or i1 %first, %same
  ret i1 %agreed
no:
  ret i1 false
}}
"""

GATHERING = _ARRAY + _NUMBER + _VECTOR + _ROW
"""LLVM IR of `mafsil_writable`, `mafsil_shaped`, `mafsil_number`, `mafsil_vector` and `mafsil_row`."""
