"""How Python calls a loop: a builtin in machine code that takes arguments apart, runs the loop and makes the result.

What a call goes through:

1. CPython calls the entry with the arguments in an array (METH_FASTCALL). Each is looked at: is it of the very type,
   and an array of the very elements, axes and order, that the loop was compiled for? Every test that fails goes to one
   block, which returns the object MISS; the caller then looks for another specialisation.
2. Numbers, addresses and sizes are read out of the objects; tuples of many parts into slots of memory. A tuple is taken
   apart in each call, and an arm in a scene has fifty arrays: a `Held` value is taken apart when it is made and lies in
   memory as the loops read it, so that a call hands over where.
3. The loop runs without the interpreter's lock.
4. Its result becomes objects. An array whose memory the loop made keeps it; one that is a view of an argument keeps
   the arguments.

The code (`entry_code`) depends on kinds alone, so all loops of these kinds share it in the store. It reads the public
structs of CPython and NumPy at the offsets of `kernels.runtime`, whose self-test must have passed. Addresses of this
process come in a table; machine code from the disk knows none.
"""

from __future__ import annotations

import ctypes
import hashlib
from collections.abc import Callable
from functools import cache
from typing import Any, Generic, TypeVar

import numpy as np

from mafsil.kernels import identity, runtime
from mafsil.kernels.loops.definition import MISS
from mafsil.kernels.loops.kinds import Held as HeldKind
from mafsil.kernels.loops.kinds import Kind, Tuple

T = TypeVar("T")
_CLASSES: dict[Kind, type[Held[Any]]] = {}
ENTRY, LINKS = "mafsil_entry", "mafsil_links"
_FASTCALL = 0x0080
FUNCTIONS = {
    "PyLong_AsLongLongAndOverflow": ("i64", "ptr", "ptr"), "PyFloat_FromDouble": ("ptr", "double"),
    "PyLong_FromLongLong": ("ptr", "i64"), "PyLong_FromUnsignedLongLong": ("ptr", "i64"),
    "PyBool_FromLong": ("ptr", "i64"), "PyComplex_FromDoubles": ("ptr", "double", "double"),
    "PyTuple_New": ("ptr", "i64"), "PyTuple_SetItem": ("i32", "ptr", "i64", "ptr"),
    "PyType_GenericAlloc": ("ptr", "ptr", "i64"), "PyEval_SaveThread": ("ptr",),
    "PyEval_RestoreThread": ("void", "ptr"), "PyErr_NoMemory": ("ptr",), "Py_IncRef": ("void", "ptr"),
    "Py_DecRef": ("void", "ptr"), "PyCapsule_New": ("ptr", "ptr", "ptr", "ptr"),
    "PyCapsule_GetPointer": ("ptr", "ptr", "ptr"),
}  # fmt: skip
_OF_NUMPY = {"PyArray_New": 93, "PyArray_SetBaseObject": 282}
_OBJECTS: dict[str, Any] = {
    "miss": MISS, "none": None, "true": True, "false": False, "bool": bool, "int": int, "float": float,
    "complex": complex, "tuple": tuple, "ndarray": np.ndarray, "npbool": np.bool_, "npint": np.int64,
    "npuint": np.uint64, "npfloat": np.float64, "npcomplex": np.complex128,
}  # fmt: skip
NAMES = (*FUNCTIONS, *_OF_NUMPY, *_OBJECTS)


@cache
def _links() -> Any:
    """Addresses of this process, in the order of NAMES."""
    array = runtime.api("_ARRAY_API")
    functions = [runtime.address(name) for name in FUNCTIONS]
    known = [*functions, *(array[place] for place in _OF_NUMPY.values()), *map(id, _OBJECTS.values())]
    links = (ctypes.c_void_p * len(known))(*known)
    runtime.forever((links, list(_OBJECTS.values())))
    return links


def key(kinds: tuple[Kind, ...], result: Kind | None, fails: bool, shares: bool, made_by: str) -> str:
    """Key of the code in the store."""
    names = " ".join(kind.name for kind in (*kinds, *((result,) if result else ())))
    return identity.content_key("entry", names, str((fails, shares, result is None)), made_by, identity.machine())


def classes_of(kinds: tuple[Kind, ...], result: Kind | None) -> list[type[Any]]:
    """The classes of named tuples and of held values that a call meets, in the order in which the code knows them."""
    found: dict[type[Any], None] = {}

    def look(kind: Kind) -> None:
        if isinstance(kind, HeldKind):
            found[class_of(kind)] = None
        elif isinstance(kind, Tuple):
            if kind.named:
                found[kind.named] = None
            for item in kind.items:
                look(item)

    for kind in (*kinds, *((result,) if result else ())):
        look(kind)
    return list(found)


def builtin(address: int, name: str, keep: Any, classes: list[type[Any]]) -> Callable[..., Any]:
    """The builtin around an entry in memory.

    Args:
        address: of ENTRY.
        name: of the loop.
        keep: what must live as long.
        classes: of `classes_of`.
    """
    texts = (name.encode(), b"")
    runtime.forever((texts, keep, classes))
    return runtime.builtin(runtime.method_def(texts[0], address, _FASTCALL, texts[1]), None, name)


def bind_entry(bind: int, target: int, classes: list[type[Any]]) -> Any:
    """Tell an entry the addresses of this process; what must live as long as it."""
    table = (ctypes.c_void_p * max(len(classes), 1))(*map(id, classes))
    taken = ctypes.addressof(_links()), ctypes.addressof(table), target
    ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 3)(bind)(*taken)
    return table


class Held(tuple[Any, ...], Generic[T]):
    """A named tuple of arrays and numbers; compiled loops read it by `open_held`.

    `holding.hold` makes it. The first item is where it lies, for the compiled code; then the value and its memory.
    """

    __slots__ = ()
    held_kind: HeldKind
    """Of the class of its values' kind."""

    @classmethod
    def from_parts(cls, *parts: Any) -> Any:
        """Of address, value and memory."""
        return tuple.__new__(cls, parts)  # pyright: ignore[reportUnknownMemberType]

    @property
    def address(self) -> int:
        """Where it lies."""
        return self[0]

    @property
    def value(self) -> T:
        """As given; it lives as long as this does."""
        return self[1]


def class_of(kind: HeldKind) -> type[Held[Any]]:
    """The class of held values of a kind."""
    if kind.value not in _CLASSES:
        name = f"Held_{hashlib.blake2b(kind.name.encode(), digest_size=6).hexdigest()}"
        _CLASSES[kind.value] = type(name, (Held,), {"__slots__": (), "held_kind": kind})
    return _CLASSES[kind.value]


def open_held(held: Held[T]) -> T:
    """The value of a `Held`, in a compiled loop that somebody else keeps it alive for."""
    return held.value
