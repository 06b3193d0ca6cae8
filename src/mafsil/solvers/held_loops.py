"""What compiled loops are asked about again and again, handed over once.

Numba unpacks every array of an argument anew in each call, 0.2 us each; an arm in a scene has fifty. A `Held` value is
unpacked when it is made and lies in memory as the loops read it; a call hands over where.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from typing import Any, Generic, TypeVar, cast

import numpy as np
from numba import typeof
from numba.core import cgutils, types
from numba.core.datamodel import models
from numba.extending import NativeValue, intrinsic, register_model, unbox
from numpy.typing import NDArray

from mafsil.solvers.loops import compiled, inlined

T = TypeVar("T")
USUAL = 16384
"""Bytes that most values have place in."""


def _digest(kind: Any) -> bytes:
    return hashlib.blake2b(str(kind).encode(), digest_size=16).digest()


class HeldType(types.Type):
    """The type of a `Held`, one for each type of its value; the name goes into the keys of compiled loops."""

    def __init__(self, kind: Any) -> None:
        self.kind = kind
        super().__init__(name=f"held {_digest(kind).hex()}")


class Held(Generic[T]):
    """A named tuple of arrays and numbers, unpacked once; compiled loops read it by `opened`.

    Attributes:
        value: as given; it lives as long as this does.
        type_number: a number for the type of the value.
        address: where it lies.
    """

    __slots__ = ("_numba_type_", "_place", "address", "type_number", "value")

    def __init__(self, value: T) -> None:
        self.value = value
        self._place = np.empty(USUAL, np.uint8)
        size, self.type_number = _write(value, self._place)
        if size > USUAL:
            self._place = np.empty(size, np.uint8)
            _write(value, self._place)
        # Python finds a type a hundred times as slowly as compiled code tells its number.
        if self.type_number not in _KNOWN:
            _KNOWN[self.type_number] = HeldType(typeof(value))
        self._numba_type_ = _KNOWN[self.type_number]  # Where numba looks for the type of an object.
        self.address = int(self._place.ctypes.data)


_KNOWN: dict[int, HeldType] = {}
"""Types by their numbers."""


@register_model(HeldType)
class _HeldModel(models.OpaqueModel):
    """An address."""


@unbox(HeldType)
def _unpacked(_kind: Any, held: Any, c: Any) -> Any:
    address = c.pyapi.object_getattr_string(held, "address")
    pointer = c.pyapi.long_as_voidptr(address)
    c.pyapi.decref(address)
    return NativeValue(pointer)


def _without_owners(context: Any, builder: Any, kind: Any, value: Any) -> Any:
    """The same value, its arrays owned by nobody: whoever opens it does not count owners."""
    if isinstance(kind, types.BaseTuple):
        for i, part in enumerate(kind):
            whole = _without_owners(context, builder, part, builder.extract_value(value, i))
            value = builder.insert_value(value, whole, i)
    elif isinstance(kind, types.Array):
        array = cgutils.create_struct_proxy(kind)(context, builder, value=value)
        for owner in ("meminfo", "parent"):
            setattr(array, owner, cgutils.get_null_value(getattr(array, owner).type))
        return array._getvalue()
    return value


@cast("Callable[[Any], Callable[[Any, int], None]]", intrinsic)
def _store(_typing: Any, value: Any, address: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        place = builder.inttoptr(values[1], context.get_value_type(signature.args[0]).as_pointer())
        builder.store(_without_owners(context, builder, signature.args[0], values[0]), place, align=8)
        return context.get_dummy_value()

    return types.void(value, types.uintp), generate


@cast("Callable[[Any], Callable[[Any], int]]", intrinsic)
def _size(_typing: Any, value: Any) -> Any:
    def generate(context: Any, _builder: Any, signature: Any, _values: Any) -> Any:
        return context.get_constant(types.intp, context.get_abi_sizeof(context.get_value_type(signature.args[0])))

    return types.intp(value), generate


@cast("Callable[[Any], Callable[[Any], int]]", intrinsic)
def _type_number(_typing: Any, value: Any) -> Any:
    """A number for the type of a value."""

    def generate(context: Any, _builder: Any, signature: Any, _values: Any) -> Any:
        number = int.from_bytes(_digest(signature.args[0])[:8], "little", signed=True)
        return context.get_constant(types.int64, number)

    return types.int64(value), generate


@compiled
def _write(value: Any, place: NDArray[np.uint8]) -> tuple[int, int]:
    """How many bytes a value takes, and the number of its type; it is written where there is place."""
    if len(place) >= _size(value):
        _store(value, place.ctypes.data)
    return _size(value), _type_number(value)


@intrinsic
def _opened(_typing: Any, held: Any) -> Any:
    def generate(context: Any, builder: Any, signature: Any, values: Any) -> Any:
        place = builder.bitcast(values[0], context.get_value_type(signature.return_type).as_pointer())
        return builder.load(place, align=8)

    return held.kind(held), generate


@inlined
def opened(held: Held[T]) -> T:
    """The value of a `Held`, in a compiled loop that somebody else keeps it alive for."""
    return _opened(held)
