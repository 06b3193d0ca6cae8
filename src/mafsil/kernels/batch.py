"""The edge of every kernel: arguments checked and named, batches broadcast, large ones split over threads."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from math import isfinite, prod
from typing import Any, cast

import numpy as np

from mafsil import threads as pool
from mafsil.arrays import Floats, Symbolic, as_batch, require_finite
from mafsil.errors import InputError
from mafsil.kernels import result_memory, small_batch
from mafsil.kernels.call import LARGE
from mafsil.kernels.device.array import on_device
from mafsil.kernels.layout import Port, Signature

_PARTS_PER_THREAD = 4
_ROWS_AT_ONCE, _NS_AT_ONCE = 1 << 16, 10_000_000
"""Rows and time after which a waiting Ctrl-C is heard: some 20 ms."""
_FEW = 64
_FLOAT64 = np.dtype(np.float64)
_SMALL = 16


class Loops:
    """The ufuncs of a kernel, each made when it is first called.

    Args:
        batch: makes the generalised ufunc of the kernel.
        point: makes the one for contiguous arrays of one point.
        past: makes the one that writes its results past the caches (`streaming`); None does without.
        has_lanes: whether the code of `batch` need not be compiled any more.
    """

    __slots__ = ("_done", "_has_lanes", "_made", "_makers")

    def __init__(
        self,
        batch: Callable[[], Callable[..., Any]],
        point: Callable[[], Callable[..., Any]],
        past: Callable[[], Callable[..., Any]] | None = None,
        has_lanes: Callable[[], bool] = lambda: True,
    ) -> None:
        self._makers = batch, point, past or batch
        self._has_lanes, self._done = has_lanes, 0
        self._made: list[Callable[..., Any] | None] = [None] * len(self._makers)

    def batch(self, past: bool = False) -> Callable[..., Any]:
        """For any arrays, perhaps with results past the caches."""
        return self._ufunc(2 if past else 0)

    def point(self, arrays: Sequence[Floats]) -> Callable[..., Any]:
        """For arguments and results of one point: by the single entry where their numbers lie side by side."""
        return self._ufunc(1 if all(array.flags.c_contiguous for array in arrays) else 0)

    def is_for_few(self, rows: int) -> bool:
        """Whether these rows are sooner evaluated one after another than the code for lanes is compiled.

        Args:
            rows: of a batch; counted together with those of earlier ones.
        """
        done = self._done + rows
        if done >= small_batch.SINGLY or self._has_lanes():
            return False
        self._done = done
        return True

    def _ufunc(self, which: int) -> Callable[..., Any]:
        made = self._made[which]
        if made is None:
            made = self._made[which] = self._makers[which]()
        return made


class Evaluator:
    """Calls a ufunc on what users give.

    Args:
        signature: ports.
        loops: ufuncs of the kernel.
        row_ns: gives the nanoseconds of one row of a batch, from which the number of its parts follows.
        device: called as `device(*args, out=out)` for arrays that lie on a device.
        symbolic: called as `symbolic(*args)` for arrays of expressions.

    Attributes:
        twins: builtins of other kernels for forms of the call that mean them: under the text of `frame`, the tuple of
            keyword names, or the number of positional arguments. The builtin of this kernel looks here first.
    """

    __slots__ = (
        "_cores", "_device", "_loops", "_names", "_ranks", "_row", "_row_ns", "_signature", "_symbolic", "twins",
    )  # fmt: skip

    def __init__(
        self,
        signature: Signature,
        loops: Loops,
        row_ns: Callable[[], float],
        device: Callable[..., Any] | None = None,
        symbolic: Callable[..., Any] | None = None,
    ) -> None:
        self._symbolic = symbolic
        self.twins: dict[Hashable, Callable[..., Any]] = {}
        self._signature = signature
        self._device = device
        self._loops = loops
        self._row = 8 * sum(port.size for port in signature.outputs)
        self._row_ns = row_ns
        self._cores = tuple(port.shape for port in signature.inputs)
        self._ranks = tuple(map(len, self._cores))
        self._names = tuple(port.name for port in signature.inputs)

    def __call__(self, *args: Any, out: Any = None, threads: int | None = None, **named: Any) -> Any:
        """Evaluate over the broadcast batch.

        Args:
            args: one array (*batch, *core) per input port, by position or by name; all of them in main memory, or all
                on one device (then so is the result, and NaN passes on).
            out: array, or tuple of arrays, of the exact result shape to write into.
            threads: how many cores a large batch may use; the default is all that the process may run on.
            named: inputs by name.

        Returns:
            Array (*batch, *core) of the output port, or a tuple of them.

        Raises:
            InputError: wrong number, name, type or shape; in a call without batch also NaN and infinities, and finite
                numbers whose result overflows, where the signature says that it should be finite.
        """
        ports = self._signature.inputs
        arrays = self._order(args, named)
        batch = self._common_batch(arrays)
        if batch is None:
            if self._symbolic is not None and any(isinstance(array, Symbolic) for array in arrays):
                return self._symbolic(*arrays)
            if self._device is not None and any(map(on_device, arrays)):
                if threads is not None:
                    raise InputError("export.options", name=self._signature.name, option="threads")
                return self._device(*arrays, out=out)
            arrays = [_numbers(port, value) for port, value in zip(ports, arrays, strict=True)]
            batch = self._batch(arrays)
        if not batch:
            for port, array in zip(ports, arrays, strict=True):
                if not _finite(array):
                    require_finite(port.name, array)
        results = None if out is None else self._given(out, batch)
        try:
            if threads is None and self._is_for_few(batch, results):
                loop = self._loops.point(arrays := [np.asarray(array, order="C") for array in arrays])
                return loop(*arrays) if results is None else loop(*arrays, out=results)
            past, count = False, self._threads(batch, threads)
            if prod(batch) * self._row >= result_memory.SMALLEST:
                results, past = self._large(batch, results)
            if (count > 1 or self._pieces(batch) > 1) and not _overlapping(arrays, results or ()):
                return self._split(past, arrays, batch, results, count)
            loop = self._loops.batch(past) if batch else self._loops.point((*arrays, *(results or ())))
            found = loop(*arrays) if results is None else loop(*arrays, out=results)
        except MemoryError:
            raise InputError("call.memory", name=self._signature.name, batch=batch) from None
        if not batch and self._signature.finite:
            self._require_finite(arrays, found)
        return found

    def _common_batch(self, arrays: Sequence[Any]) -> tuple[int, ...] | None:
        """The batch, if all arguments are float64 arrays of the same one: the usual case, found out in little time."""
        batch: tuple[int, ...] | None = None
        for array, rank, core in zip(arrays, self._ranks, self._cores):  # noqa: B905 - strict takes time
            if type(array) is not np.ndarray or array.dtype is not _FLOAT64:
                return None
            cut = array.ndim - rank
            if cut < 0 or array.shape[cut:] != core:
                return None
            own = array.shape[:cut]
            if batch is None:
                batch = own
            elif own != batch:
                return None
        return batch

    def _order(self, args: Sequence[Any], named: Mapping[str, Any]) -> Sequence[Any]:
        if not named and len(args) == len(self._names):
            return args
        positional = self._names[: len(args)]
        missing = [name for name in self._names[len(args) :] if name not in named]
        strange = [name for name in named if name not in self._names or name in positional]
        if missing or strange or len(args) > len(self._names):
            raise InputError(
                "call.arguments",
                name=self._signature.name,
                expected=", ".join(self._names),
                got=", ".join([str(len(args)), *named]),
            )
        return [*args, *(named[name] for name in self._names[len(args) :])]

    def _batch(self, arrays: Sequence[Floats]) -> tuple[int, ...]:
        shapes = [a.shape[: a.ndim - rank] for a, rank in zip(arrays, self._ranks, strict=True)]
        if shapes.count(shapes[0] if shapes else ()) == len(shapes):
            return shapes[0] if shapes else ()
        try:
            return np.broadcast_shapes(*shapes)
        except (ValueError, RuntimeError):  # NumPy raises the second beyond 32 dimensions
            named = ", ".join(f"{name} {shape}" for name, shape in zip(self._names, shapes, strict=True))
            raise InputError("call.batches", name=self._signature.name, batches=named) from None

    def _require_finite(self, arrays: Sequence[Floats], found: Any) -> None:
        """Refuse a result that is not finite though all that was given is.

        Raises:
            InputError: names the number that leads beyond the range of floating-point numbers.
        """
        for array in _all_of(found):
            result: Floats = np.asarray(array)
            if _finite(result):
                continue
            index = tuple(int(i) for i in np.argwhere(~np.isfinite(result))[0])
            sizes = [float(np.abs(x).max(initial=0.0)) for x in arrays]
            largest = max(sizes)
            raise InputError(
                "call.overflow" if largest >= LARGE else "call.undefined",
                name=self._signature.name,
                value=float(result[index]),
                index=index,
                input=self._names[sizes.index(largest)],
                largest=largest,
            )

    def _given(self, out: Any, batch: tuple[int, ...]) -> tuple[Floats, ...]:
        """The caller's result arrays, fit to be written."""
        outputs = self._signature.outputs
        arrays = _all_of(out)
        if len(arrays) != len(outputs):
            raise InputError("call.outputs", name=self._signature.name, expected=len(outputs), got=len(arrays))
        for port, array in zip(outputs, arrays):  # noqa: B905 - strict takes time, and both have one length
            _check_out(port, array, batch + port.shape)
        return arrays

    def _large(self, batch: tuple[int, ...], results: tuple[Floats, ...] | None) -> tuple[tuple[Floats, ...], bool]:
        """Memory for large results, and whether to write past the caches, which could not keep them.

        Pages that have never been written are in the caches when the system has cleared them; they are written plainly.
        """
        past = prod(batch) * self._row > result_memory.kept_bytes(self._row)
        if results is not None:
            return results, past
        found = [result_memory.new(batch + port.shape) for port in self._signature.outputs]
        return tuple(array for array, _ in found), past and all(written for _, written in found)

    def _threads(self, batch: tuple[int, ...], requested: int | None) -> int:
        """How many threads share the batch: one, if it is not worth two parts."""
        if type(requested) is int and requested == 1:
            return 1
        count = 0 if requested is None else pool.check_count(requested)
        if prod(batch) < _SMALL or self._parts(batch) < 2:
            return 1
        return min(count or pool.available(), self._parts(batch))

    def _is_for_few(self, batch: tuple[int, ...], results: tuple[Floats, ...] | None) -> bool:
        """Whether the rows of a batch go one after another: while lanes are not compiled, to results side by side."""
        rows = prod(batch)
        small = batch and rows * self._row < result_memory.SMALLEST
        return bool(small) and all(x.flags.c_contiguous for x in results or ()) and self._loops.is_for_few(rows)

    def _parts(self, batch: tuple[int, ...]) -> int:
        """The most parts that a batch is worth."""
        return min(int(prod(batch) * self._row_ns() / small_batch.HANDED_OVER_NS), max(batch))

    def _pieces(self, batch: tuple[int, ...]) -> int:
        """The fewest parts between which a waiting Ctrl-C is heard soon enough."""
        rows = prod(batch)
        if rows <= _SMALL:
            return 1
        return min(1 + max(rows // _ROWS_AT_ONCE, int(rows * self._row_ns() / _NS_AT_ONCE)), max(batch))

    def _split(
        self,
        past: bool,
        arrays: Sequence[Floats],
        batch: tuple[int, ...],
        results: tuple[Floats, ...] | None,
        threads: int,
    ) -> Any:
        """Cut the longest batch axis into parts of nearly equal length; every row is computed as if alone."""
        ports = self._signature.ports
        if results is None:
            results = tuple(np.empty(batch + port.shape) for port in self._signature.outputs)
        # As many parts for each thread: a left-over one would be waited for by all others.
        parts = threads * max(1, min(self._parts(batch) // threads, _PARTS_PER_THREAD))
        parts = min(max(parts, self._pieces(batch)), max(batch))
        axis = batch.index(max(batch))
        edges = [batch[axis] * part // parts for part in range(parts + 1)]
        operands = [*arrays, *results]
        inputs, loop = len(arrays), self._loops.batch(past)

        def evaluate(part: int) -> None:
            rows = slice(edges[part], edges[part + 1])
            cut = [_rows(x, port, len(batch) - axis, rows) for x, port in zip(operands, ports, strict=True)]
            loop(*cut[:inputs], out=tuple(cut[inputs:]))

        pool.run(evaluate, parts, threads)
        return results[0] if len(results) == 1 else results


def _numbers(port: Port, value: Any) -> Floats:
    """The argument as float64 (*batch, *core); what already is that passes unasked."""
    if type(value) is np.ndarray and value.dtype is _FLOAT64:
        core = port.shape
        if value.shape[max(value.ndim - len(core), 0) :] == core:
            return value
    return as_batch(port.name, value, port.shape)


def _finite(array: Floats) -> bool:
    """Whether all numbers are finite; a few are asked in Python, where NumPy's reductions cost a microsecond."""
    if array.size <= _FEW:
        return all(map(isfinite, array.ravel().tolist()))
    return bool(np.isfinite(array).all())


def _rows(array: Floats, port: Port, from_end: int, rows: slice) -> Floats:
    """Part of an operand along a batch axis, unless it is broadcast along it."""
    axis = array.ndim - len(port.shape) - from_end
    if axis < 0 or array.shape[axis] == 1:
        return array
    return array[(slice(None),) * axis + (rows,)]


def _all_of(result: Any) -> tuple[Any, ...]:
    """One array or a tuple of them, as a tuple."""
    return cast("tuple[Any, ...]", result) if isinstance(result, tuple) else (result,)


def _check_out(port: Port, given: Any, shape: tuple[int, ...]) -> None:
    array = cast("np.ndarray[Any, Any]", given)
    if not isinstance(given, np.ndarray) or array.dtype != _FLOAT64 or not array.flags.writeable:
        raise InputError("call.out", name=f"out ({port.name})")
    if array.shape != shape:
        raise InputError("input.shape", name=f"out ({port.name})", expected=shape, got=array.shape, hint="")


def _overlapping(arrays: Sequence[Floats], results: Sequence[Floats]) -> bool:
    """Whether a result may lie over an argument or another result: then NumPy orders the work, in one piece."""
    return any(
        np.may_share_memory(result, other) for i, result in enumerate(results) for other in (*arrays, *results[:i])
    )
