"""Types of compiled loops: numbers, lanes, arrays, tuples and values held in memory; their parts in LLVM and as text.

A value of a kind is one or more LLVM values, its parts: a number is one, an array is its address, its sizes and, where
it is not contiguous, its strides; a tuple has the parts of its items one after another. The name of a kind says all of
it, so that it can stand in the key of compiled code.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, TypeVar, cast

import numpy as np
from numpy.typing import NDArray

from mafsil.errors import KernelError

SLOT = 8
"""Bytes of a part in memory; lanes take eight of them."""
WIDTH = 8
"""Lanes."""


K = TypeVar("K", bound="Kind")


class Kind:
    """A type; two of the same name are the same object.

    Attributes:
        name: that says all of it.
        parts: LLVM types of its parts.
    """

    __slots__ = ("name", "parts")

    def __init__(self, name: str, parts: tuple[str, ...]) -> None:
        self.name, self.parts = name, parts

    def __repr__(self) -> str:
        return self.name

    @property
    def size(self) -> int:
        """Bytes in memory."""
        return sum(slot_size(part) for part in self.parts)


def slot_size(part: str) -> int:
    """Bytes of a part in memory."""
    return SLOT * WIDTH if part == VECTOR else SLOT


class Number(Kind):
    """A number.

    Attributes:
        rank: of two kinds the one of higher rank holds both.
        element: its LLVM type as an element of an array.
        tag: what its elements are for alias analysis.
    """

    __slots__ = ("element", "rank", "tag")

    def __init__(self, name: str, llvm: str, rank: int, element: str = "", tag: str = "") -> None:
        parts = ("double", "double") if name == "complex128" else (llvm,)
        super().__init__(name, parts)
        self.rank, self.element, self.tag = rank, element or llvm, tag or name


VECTOR, BITS = f"<{WIDTH} x double>", f"<{WIDTH} x i1>"
BOOL = Number("bool", "i1", 0, "i8")
INTEGER = Number("int64", "i64", 1)
UNSIGNED = Number("uint64", "i64", 2, tag="int64")
SINGLE = Number("float32", "float", 3)
REAL = Number("float64", "double", 4)
COMPLEX = Number("complex128", "", 5, "double", "float64")
LANES, MASK = Kind("lanes", (VECTOR,)), Kind("mask", (BITS,))
BUFFER = Kind("buffer", ("ptr",))
NONE = Kind("none", ())


class Narrow(Number):
    """Small whole numbers, elements of arrays only: read, they are 64 bits."""


NARROW = {
    name: Narrow(name, "i64", 1, f"i{bits}", f"int{bits}")
    for name, bits in (("int32", 32), ("int16", 16), ("int8", 8), ("uint8", 8), ("uint16", 16), ("uint32", 32))
}
NUMBERS: Mapping[str, Number] = {
    **{kind.name: kind for kind in (BOOL, INTEGER, UNSIGNED, SINGLE, REAL, COMPLEX)},
    **NARROW,
}
BYTES = {"bool": 1, "int8": 1, "uint8": 1, "int16": 2, "uint16": 2, "int32": 4, "uint32": 4, "float32": 4}
_NAMES = {np.dtype(name).num: name for name in NUMBERS}


class Array(Kind):
    """An array.

    Attributes:
        of: kind of its elements.
        ndim: axes.
        contiguous: in C order, without gaps; then it has no strides.
    """

    __slots__ = ("contiguous", "ndim", "of")

    def __init__(self, of: Number, ndim: int, contiguous: bool) -> None:
        sizes = ("i64",) * ndim
        super().__init__(
            f"{of.name}[{ndim}{'C' if contiguous else 'A'}]", ("ptr", *sizes, *(() if contiguous else sizes))
        )
        self.of, self.ndim, self.contiguous = of, ndim, contiguous

    @property
    def itemsize(self) -> int:
        """Bytes of an element."""
        return 16 if self.of is COMPLEX else BYTES.get(self.of.name, 8)


class Tuple(Kind):
    """A tuple of so many items, or a named one.

    Attributes:
        items: kinds.
        named: the class of a named tuple.
        offsets: bytes from its begin to each item, in memory.
    """

    __slots__ = ("items", "named", "offsets")

    def __init__(self, items: tuple[Kind, ...], named: type[Any] | None) -> None:
        label = f"{named.__module__}:{named.__qualname__}" if named else ""
        super().__init__(f"{label}({','.join(item.name for item in items)})", sum((item.parts for item in items), ()))
        self.items, self.named = items, named
        offsets = [0]
        for item in items:
            offsets.append(offsets[-1] + item.size)
        self.offsets = tuple(offsets)

    @property
    def fields(self) -> tuple[str, ...]:
        """Names of the items of a named tuple."""
        return getattr(self.named, "_fields", ())


class Held(Kind):
    """The address of a tuple that lies in memory as long as a loop runs.

    Attributes:
        value: kind of the tuple.
    """

    __slots__ = ("value",)

    def __init__(self, value: Kind) -> None:
        super().__init__(f"held{value.name}", ("ptr",))
        self.value = value


_KNOWN: dict[str, Kind] = {}
"""Kinds by name."""


def _one(made: K) -> K:
    """The kind of this name that there is already."""
    return cast("K", _KNOWN.setdefault(made.name, made))


def array_of(of: Number, ndim: int, contiguous: bool = True) -> Array:
    """The kind of such arrays."""
    return _one(Array(of, ndim, contiguous))


def tuple_of(items: tuple[Kind, ...], named: type[Any] | None = None) -> Tuple:
    """The kind of such tuples."""
    key = (items, named)
    found = _TUPLES.get(key)
    if found is None:
        found = _TUPLES[key] = Tuple(items, named)
    return found


_TUPLES: dict[tuple[tuple[Kind, ...], type[Any] | None], Tuple] = {}


def held_of(value: Kind) -> Held:
    """The kind of a held value."""
    return _one(Held(value))


def kind_of(value: Any) -> Kind:
    """The kind of a value of Python.

    Raises:
        KernelError: loops take no such value.
    """
    known = _OF_TYPES.get(cast("type[Any]", type(value)))
    if known is not None:
        return known
    if isinstance(value, np.ndarray):
        return array_kind(cast("NDArray[Any]", value))
    held = getattr(cast("type[Any]", type(value)), "held_kind", None)
    if held is not None:
        return cast(Kind, held)
    if isinstance(value, tuple):
        items = cast("tuple[Any, ...]", value)
        named = type(items) if hasattr(items, "_fields") else None
        return tuple_of(tuple(kind_of(item) for item in items), named)
    for kinds, kind in ((bool | np.bool_, BOOL), (int | np.signedinteger, INTEGER), (float | np.floating, REAL)):
        if isinstance(value, kinds):
            return kind
    raise refusal(f"a value of type {type(value).__name__}")


def array_kind(array: NDArray[Any]) -> Array:
    """The kind of an array of Python.

    Raises:
        KernelError: its elements are not of this machine, or of a type that loops do not know.
    """
    name = _NAMES.get(array.dtype.num)
    if name is None or not array.dtype.isnative:
        raise refusal(f"an array of {array.dtype}")
    return array_of(NUMBERS[name], array.ndim, bool(array.flags.c_contiguous))


_OF_TYPES: dict[type[Any], Kind] = {
    bool: BOOL, np.bool_: BOOL, int: INTEGER, np.int64: INTEGER, np.uint64: UNSIGNED, float: REAL, np.float64: REAL,
    complex: COMPLEX, np.complex128: COMPLEX, type(None): NONE,
}  # fmt: skip


def join_kinds(a: Kind, b: Kind) -> Kind | None:
    """The kind that holds values of both; None if there is none."""
    if a is b:
        return a
    if isinstance(a, Number) and isinstance(b, Number):
        return max(a, b, key=lambda kind: kind.rank)
    if isinstance(a, Array) and isinstance(b, Array) and a.of is b.of and a.ndim == b.ndim:
        return array_of(a.of, a.ndim, False)
    if isinstance(a, Tuple) and isinstance(b, Tuple) and a.named is b.named and len(a.items) == len(b.items):
        items = [join_kinds(x, y) for x, y in zip(a.items, b.items, strict=True)]
        return None if None in items else tuple_of(tuple(cast("list[Kind]", items)), a.named)
    if {a, b} <= {LANES, REAL, INTEGER}:
        return LANES
    return None


def has_arrays(kind: Kind) -> bool:
    """Whether an array or a buffer is part of it."""
    return isinstance(kind, Array) or kind is BUFFER or (isinstance(kind, Tuple) and any(map(has_arrays, kind.items)))


FEW_PARTS = 8
"""Parts of a tuple up to which they are handed over one by one."""


def by_address(kind: Kind) -> bool:
    """Whether functions take such values by the address of their slots."""
    return isinstance(kind, Tuple) and len(kind.parts) > FEW_PARTS


def return_types(result: Kind, fails: bool) -> list[str]:
    """LLVM types of what a function gives back: the parts of its result, and whether memory was lacking."""
    return [*result.parts, *(["i1"] if fails else [])]


def named_kind(text: str, classes: Mapping[str, type[Any]]) -> Kind:
    """The kind of a name.

    Args:
        text: `Kind.name`.
        classes: of named tuples, by `module:name`; no others are taken.

    Raises:
        KeyError, ValueError: it names none.
    """
    kind, rest = _parse(text, classes)
    if rest:
        raise ValueError(text)
    return kind


def _parse(text: str, classes: Mapping[str, type[Any]]) -> tuple[Kind, str]:
    if text.startswith("held"):
        value, rest = _parse(text[4:], classes)
        return held_of(value), rest
    stop = min(i for i in (*(text.find(c) for c in "[(,)" if c in text), len(text)))
    word, rest = text[:stop], text[stop:]
    if rest.startswith("["):
        form, _, rest = rest[1:].partition("]")
        return array_of(NUMBERS[word], int(form[:-1]), form[-1:] == "C"), rest
    if rest.startswith("("):
        items: list[Kind] = []
        rest = rest[1:]
        while not rest.startswith(")"):
            item, rest = _parse(rest.removeprefix(","), classes)
            items.append(item)
        return tuple_of(tuple(items), classes[word] if word else None), rest[1:]
    known: dict[str, Kind] = {**NUMBERS, "lanes": LANES, "mask": MASK, "buffer": BUFFER, "none": NONE}
    return known[word], rest


class RefusedError(KernelError):
    """A function is not of the language.

    Attributes:
        line: of its file.
        placed: whether its text says where.
    """

    def __init__(self, reason: str) -> None:
        super().__init__("kernels.refused", reason=reason)
        self.reason, self.line, self.placed = reason, 0, False

    def at(self, place: str) -> RefusedError:
        """The same, its text says where."""
        made = RefusedError(f"{place}: {self.reason}")
        made.placed = True
        return made


class EditedError(RefusedError):
    """The source of a function is no longer that of what is in memory."""


def refusal(reason: str) -> RefusedError:
    """What is raised where a function is not of the language."""
    return RefusedError(reason)
