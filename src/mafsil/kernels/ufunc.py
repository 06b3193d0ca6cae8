"""A true NumPy generalised ufunc around compiled code: broadcasting, strides, casting, `out=`, released lock."""

from __future__ import annotations

import ctypes
from collections.abc import Callable
from functools import cache
from typing import Any, cast

import numpy as np

from mafsil.kernels.layout import Port, Signature, contiguous_steps
from mafsil.kernels.runtime import api

_CREATE = 31
"""Place of PyUFunc_FromFuncAndDataAndSignature in NumPy's table."""
_OWNER = 88
"""Offset of the field `obj` in NumPy's PyUFuncObject: a Python object that lives as long as the ufunc."""
_DOUBLE = 12
_NO_IDENTITY = -1

_immortal: list[object] = []


def gufunc(address: int, signature: Signature, doc: str, owner: object, data: int | None = None) -> Callable[..., Any]:
    """The ufunc of a compiled loop, or a plain Python loop with the same manners where NumPy cannot be trusted.

    Args:
        address: of the loop, NumPy's PyUFuncGenericFunction.
        signature: ports; gives the name and the core shapes.
        doc: docstring.
        owner: object that must outlive the ufunc, such as the loaded code.
        data: handed to the loop with every call.
    """
    if available():
        return _make(address, signature, doc, owner, data)
    return PlainLoop(address, signature, owner, data)


@cache
def available() -> bool:
    """Whether NumPy's table holds the ufunc factory in its place and it makes working ufuncs."""
    try:
        return api("_UFUNC_API")[0] == id(np.ufunc) and _copies()
    except (AttributeError, ValueError, OSError, TypeError):
        return False


class PlainLoop:
    """The same loop driven from Python: broadcasting and contiguous copies by NumPy, one call of the machine code."""

    def __init__(self, address: int, signature: Signature, owner: object, data: int | None = None) -> None:
        self.signature = signature
        self._data = data
        self._owner = owner
        self._loop = ctypes.CFUNCTYPE(None, *[ctypes.c_void_p] * 4)(address)
        steps = [8 * port.size for port in signature.ports]
        steps += [step for port in signature.ports for step in contiguous_steps(port)]
        self._steps = (ctypes.c_ssize_t * len(steps))(*steps)
        cores = sorted({size for port in signature.ports for size in port.shape})
        self._cores = cores

    def __call__(self, *inputs: Any, out: Any = None) -> Any:
        """As the ufunc: inputs broadcast over their leading dimensions, results new or in `out`."""
        ports = self.signature.inputs
        arrays = [np.asarray(x, dtype=np.float64) for x in inputs]
        batch = np.broadcast_shapes(
            *(x.shape[: x.ndim - len(port.shape)] for x, port in zip(arrays, ports, strict=True))
        )
        rows = [
            np.array(np.broadcast_to(x, batch + port.shape), order="C") for x, port in zip(arrays, ports, strict=True)
        ]
        results = [np.empty(batch + port.shape) for port in self.signature.outputs]
        pointers = [x.ctypes.data for x in (*rows, *results)]
        dims = [int(np.prod(batch, dtype=np.int64)), *self._cores]
        self._loop(
            (ctypes.c_void_p * len(pointers))(*pointers), (ctypes.c_ssize_t * len(dims))(*dims), self._steps, self._data
        )
        return self._hand(results, out)

    def _hand(self, results: list[np.ndarray[Any, Any]], out: Any) -> Any:
        if out is not None:
            given = cast("tuple[Any, ...]", out) if isinstance(out, tuple) else (out,)
            for target, result in zip(given, results, strict=True):
                target[...] = result
            results = list(given)
        else:
            results = [result if result.ndim else result[()] for result in results]
        return results[0] if len(results) == 1 else tuple(results)


def _make(address: int, signature: Signature, doc: str, owner: object, data: int | None = None) -> Any:
    ports = len(signature.ports)
    functions = (ctypes.c_void_p * 1)(address)
    handed = (ctypes.c_void_p * 1)(data)
    types = (ctypes.c_char * ports)(*[_DOUBLE] * ports)
    name, text = signature.name.encode(), doc.encode()
    made = _factory()(
        ctypes.addressof(functions), ctypes.addressof(handed), ctypes.addressof(types), 1,
        len(signature.inputs), len(signature.outputs), _NO_IDENTITY, name, text, 0, signature.gufunc.encode(),
    )  # fmt: skip
    _tie(made, (functions, handed, types, name, text, owner))
    return made


@cache
def _factory() -> Any:
    pointer, integer, text = ctypes.c_void_p, ctypes.c_int, ctypes.c_char_p
    kinds = [pointer, pointer, pointer, integer, integer, integer, integer, text, text, integer, text]
    return ctypes.PYFUNCTYPE(ctypes.py_object, *kinds)(api("_UFUNC_API")[_CREATE] or 0)


def _tie(ufunc: Any, keep: object) -> None:
    """Let `keep` live as long as the ufunc; where the field is not found, for ever."""
    if not _owner_field_is_there():
        _immortal.append(keep)
        return
    ctypes.pythonapi.Py_IncRef(ctypes.py_object(keep))
    ctypes.c_ssize_t.from_address(id(ufunc) + _OWNER).value = id(keep)


@cache
def _owner_field_is_there() -> bool:
    """`numpy.frompyfunc` keeps its function in the field, every compiled ufunc has it empty."""

    def sample(x: float) -> float:
        return x

    probe = np.frompyfunc(sample, 1, 1)
    # Only a ufunc of the very class and size that we know is read at that offset.
    if np.ufunc.__basicsize__ < _OWNER + 8:
        return False
    empty = all(ctypes.c_ssize_t.from_address(id(u) + _OWNER).value == 0 for u in (np.add, np.matmul, np.sin))
    return empty and ctypes.c_ssize_t.from_address(id(probe) + _OWNER).value == id(sample)


def _copies() -> bool:
    """A ufunc of a copying loop in Python answers rightly over broadcast, strided and cast inputs."""
    signature = Signature("copy", (_port("x"),), (_port("y"),))
    kind = ctypes.PYFUNCTYPE(None, *[ctypes.c_void_p] * 4)
    loop = kind(_copy_pairs)
    address = ctypes.cast(loop, ctypes.c_void_p).value or 0
    probe = _make(address, signature, "", loop)
    given = np.arange(24, dtype=np.float32).reshape(3, 4, 2)[::-1, ::2]
    return probe.signature == "(2)->(2)" and bool((probe(given) == given).all()) and probe(given).dtype == np.float64


def _port(name: str) -> Port:
    return Port(name, (2,))


def _copy_pairs(args: int, dims: int, steps: int, _data: int) -> None:
    source, target = (ctypes.c_ssize_t * 2).from_address(args)
    rows, cores = (ctypes.c_ssize_t * 2).from_address(dims)
    outer = (ctypes.c_ssize_t * 4).from_address(steps)
    for row in range(rows):
        for column in range(cores):
            at = source + row * outer[0] + column * outer[2]
            to = target + row * outer[1] + column * outer[3]
            ctypes.c_double.from_address(to).value = ctypes.c_double.from_address(at).value
