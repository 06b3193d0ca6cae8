"""What machine code reads and calls in this process: structs of CPython and NumPy, a table of addresses, the system.

The structs are public and have not moved for years, but nothing is taken on trust: `available`, the self-test, compares
the offsets with objects of known contents, and without that proof no machine code looks at an object.
"""

from __future__ import annotations

import ctypes
import struct
import sys
from collections.abc import Callable
from functools import cache
from importlib import import_module
from typing import Any

import numpy as np

from mafsil.kernels.layout import Signature

_OF_MATHEMATICS = (
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "exp", "log", "pow", "hypot", "fmod", "nextafter", "floor",
    "ceil", "rint", "sincos", "exp2", "exp10", "ldexp", "cbrt",
)  # fmt: skip
_OF_MEMORY = ("malloc", "free", "memcpy", "memset", "memmove", "bcmp", "memcmp")
TYPE, ARRAY_DATA, ARRAY_NDIM, ARRAY_SHAPE, ARRAY_STRIDES, ARRAY_DTYPE, ARRAY_FLAGS = 8, 16, 24, 32, 40, 56, 64
DTYPE_ORDER, DTYPE_NUMBER, FLOAT_VALUE = 26, 28, 16
SIZE, LIST_ITEMS = 16, 24
CONTIGUOUS_ALIGNED, WRITEABLE = 0x101, 0x400
SINGLE_PRECISION, DOUBLE = 11, 12
TABLE = (
    "ndarray", "float64", "PyFloat", "npfloat64", "PyArray_New", "PyArray_Return",
    "PyTuple_New", "PyTuple_SetItem", "PyObject_Vectorcall", "Py_DecRef", "Py_IncRef",
    "PyDict_GetItem", "PyLong_FromSsize_t", "PyLong_AsLongLongAndOverflow",
    "PyEval_SaveThread", "PyEval_RestoreThread", "PyType_GenericAlloc",
    "list", "tuple", "int", "str", "tuple_items", "out", "frame", "threads", "one", "out_alone",
)  # fmt: skip
_FUNCTIONS = ("PyTuple_", "PyObject_", "Py_", "PyDict_", "PyLong_", "PyEval_", "PyType_")
_OUT, _FRAME, _THREADS = sys.intern("out"), sys.intern("frame"), sys.intern("threads")
_OUT_ALONE = (_OUT,)


@cache
def available() -> bool:
    """Whether this interpreter and this NumPy store their objects where the machine code will look."""
    try:
        return _same_layout() and _runtime_answers()
    except (AttributeError, ValueError, OSError, TypeError):
        return False


def api(capsule: str) -> ctypes.Array[ctypes.c_void_p]:
    """NumPy's table of C functions: `_ARRAY_API` or `_UFUNC_API`."""
    core = import_module("numpy._core._multiarray_umath")

    pointer = ctypes.PYFUNCTYPE(ctypes.c_void_p, ctypes.py_object, ctypes.c_char_p)(
        ("PyCapsule_GetPointer", ctypes.pythonapi)
    )
    return (ctypes.c_void_p * 300).from_address(pointer(getattr(core, capsule), None))


@cache
def table() -> ctypes.Array[ctypes.c_void_p]:
    """Addresses of this process that the machine code needs, in the order of TABLE."""
    array = api("_ARRAY_API")
    python = {name: address(name) for name in TABLE if name.startswith(_FUNCTIONS)}
    known: dict[str, int | None] = {
        "ndarray": id(np.ndarray),
        "float64": id(np.dtype(np.float64)),
        "PyFloat": id(float),
        "npfloat64": id(np.float64),
        "PyArray_New": array[93],
        "PyArray_Return": array[76],
        **{kind.__name__: id(kind) for kind in (list, tuple, int, str)},
        "tuple_items": tuple.__basicsize__,
        "out": id(_OUT),
        "frame": id(_FRAME),
        "threads": id(_THREADS),
        "one": id(1),
        "out_alone": id(_OUT_ALONE),
        **python,
    }
    return (ctypes.c_void_p * len(TABLE))(*(known[name] for name in TABLE))


@cache
def names(signature: Signature) -> ctypes.Array[ctypes.c_void_p]:
    """The names of a kernel's inputs as the interpreter holds those of keywords in source code; kept for ever.

    Args:
        signature: ports of the kernel.
    """
    texts = tuple(sys.intern(port.name) for port in signature.inputs)
    _interned.append(texts)
    return (ctypes.c_void_p * max(len(texts), 1))(*map(id, texts))


_interned: list[tuple[str, ...]] = []


def address(name: str) -> int:
    """Where a function of CPython begins."""
    return ctypes.cast(getattr(ctypes.pythonapi, name), ctypes.c_void_p).value or 0


def forever(thing: object) -> None:
    """Let an object outlive the interpreter itself.

    At its end the interpreter empties modules in an order of its own: an array may go after the code that gives back
    its memory, and a thread that asks nobody still runs. What machine code consists of is therefore never let go.

    Args:
        thing: which.
    """
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(thing))


class MethodDef(ctypes.Structure):
    """CPython's PyMethodDef."""

    _fields_ = (
        ("name", ctypes.c_void_p),
        ("method", ctypes.c_void_p),
        ("flags", ctypes.c_int),
        ("doc", ctypes.c_void_p),
    )


def method_def(name: bytes, method: int, flags: int, doc: bytes) -> MethodDef:
    """The definition of a builtin; it is never let go.

    The collector reads the flags of a builtin in a cycle after it has emptied the owner that would keep them.

    Args:
        name, doc: texts, which live as long as the builtin.
        method: address of machine code.
        flags: how it is called.
    """
    places = [ctypes.cast(ctypes.c_char_p(text), ctypes.c_void_p).value for text in (name, doc)]
    made = MethodDef(places[0], method, flags, places[1])
    forever(made)
    return made


def builtin(method: MethodDef, owner: object, module: str) -> Callable[..., Any]:
    """The builtin of a method, which must outlive it.

    Args:
        method: names machine code.
        owner: its `__self__`.
        module: its `__module__`.
    """
    make = ctypes.PYFUNCTYPE(ctypes.py_object, ctypes.c_void_p, ctypes.py_object, ctypes.py_object)(
        ("PyCFunction_NewEx", ctypes.pythonapi)
    )
    return make(ctypes.addressof(method), owner, module)


def _same_layout() -> bool:
    """Offsets read by the machine code, compared with arrays, scalars and dtypes of known contents."""
    if sys.implementation.name != "cpython" or struct.calcsize("P") != 8 or sys.byteorder != "little":
        return False
    if "t" in getattr(sys, "abiflags", ""):  # free-threaded builds have another object header
        return False
    base = np.arange(24.0).reshape(2, 3, 4)
    odd = np.frombuffer(bytes(65), dtype=np.uint8)[1:].view(np.float64)
    fixed = np.zeros(3)
    fixed.setflags(write=False)
    samples = [fixed, base, base[:, ::2], base.T, base[1, 2, 3:], np.zeros(()), np.zeros(7), np.zeros((0, 6)), odd]
    return all(map(_reads_right, samples)) and _scalars_read_right() and _sequences_read_right()


def _reads_right(array: np.ndarray[Any, Any]) -> bool:
    at = id(array)
    ndim = _read(ctypes.c_int, at + ARRAY_NDIM)
    if ndim != array.ndim or _read(ctypes.c_ssize_t, at + TYPE) != id(np.ndarray):
        return False
    shape = _read(ctypes.c_ssize_t, at + ARRAY_SHAPE)
    strides = _read(ctypes.c_ssize_t, at + ARRAY_STRIDES)
    flags = _read(ctypes.c_int, at + ARRAY_FLAGS)
    return (
        _read(ctypes.c_ssize_t, at + ARRAY_DATA) == array.ctypes.data
        and tuple(_read(ctypes.c_ssize_t, shape + 8 * axis) for axis in range(ndim)) == array.shape
        and strides == shape + 8 * ndim
        and tuple(_read(ctypes.c_ssize_t, strides + 8 * axis) for axis in range(ndim)) == array.strides
        and _read(ctypes.c_ssize_t, at + ARRAY_DTYPE) == id(array.dtype)
        and bool(flags & 0x001) == array.flags.c_contiguous
        and bool(flags & 0x100) == array.flags.aligned
        and bool(flags & WRITEABLE) == array.flags.writeable
    )


def _scalars_read_right() -> bool:
    dtypes = [np.dtype(np.float64), np.dtype(">f8"), np.dtype(np.float32), np.dtype(np.int64)]
    orders = [chr(_read(ctypes.c_ubyte, id(d) + DTYPE_ORDER)) == d.byteorder for d in dtypes]
    numbers = [_read(ctypes.c_int, id(d) + DTYPE_NUMBER) == d.num for d in dtypes]
    values = [_read(ctypes.c_double, id(x) + FLOAT_VALUE) == 1.25 for x in (float("1.25"), np.float64(1.25))]
    return all(orders) and all(numbers) and all(values) and (dtypes[0].num, dtypes[2].num) == (DOUBLE, SINGLE_PRECISION)


def _sequences_read_right() -> bool:
    """Sizes and items of lists and tuples; behind its items a list says for how many it has room."""
    if LIST_ITEMS + 16 != list.__basicsize__:
        return False
    items = [object() for _ in range(3)]
    pair, lone = tuple(items), list(items)
    inside = id(pair) + tuple.__basicsize__
    places = (inside, _read(ctypes.c_ssize_t, id(lone) + LIST_ITEMS))
    sizes = all(_read(ctypes.c_ssize_t, id(entry) + SIZE) == 3 for entry in (pair, lone))
    found = [[_read(ctypes.c_ssize_t, place + 8 * k) for k in range(3)] for place in places]
    return sizes and found == [list(map(id, items))] * 2


def _runtime_answers() -> bool:
    """NumPy's table has the allocator and the scalar maker where they are expected."""
    array = api("_ARRAY_API")
    if array[2] != id(np.ndarray):
        return False
    voidp, integer = ctypes.c_void_p, ctypes.c_int
    new = ctypes.PYFUNCTYPE(ctypes.py_object, voidp, integer, voidp, integer, voidp, voidp, integer, integer, voidp)(
        array[93] or 0
    )
    shape = (ctypes.c_ssize_t * 2)(3, 4)
    made = new(id(np.ndarray), 2, ctypes.addressof(shape), DOUBLE, None, None, 0, 0, None)
    return type(made) is np.ndarray and made.shape == (3, 4) and made.dtype == np.float64 and all(table())


def _read(kind: Any, address: int) -> Any:
    return kind.from_address(address).value


@cache
def functions() -> dict[str, int]:
    """Addresses by name; those that this system does not have are left out."""
    libraries = _libraries()
    found: dict[str, int] = {}
    for name in (*_OF_MATHEMATICS, *_OF_MEMORY):
        for library in libraries:
            function = getattr(library, name, None)
            if function is not None:
                found[name] = ctypes.cast(function, ctypes.c_void_p).value or 0
    return found


def _libraries() -> list[ctypes.CDLL]:
    """The C library and that of mathematics, which are one on some systems."""
    if sys.platform == "win32":
        return [ctypes.CDLL("ucrtbase")]
    try:
        return [ctypes.CDLL(None), ctypes.CDLL("libm.so.6")]
    except OSError:  # No file of that name: mathematics is in the C library (musl, macOS), or Python has brought it.
        return [ctypes.CDLL(None)]
