"""The edge of every kernel: arguments checked and named, batches broadcast, large ones split over threads."""

from __future__ import annotations

from collections.abc import Callable, Hashable, Mapping, Sequence
from math import isfinite, prod
from typing import Any

import numpy as np

from mafsil import threads as pool
from mafsil.arrays import Floats, gate, require_finite
from mafsil.errors import InputError
from mafsil.kernels.call import LARGE
from mafsil.kernels.device.array import on_device
from mafsil.kernels.layout import Port, Signature

_PART_WORK = 400_000
"""Operations that are worth handing to another thread: about 50 us."""
_PARTS_PER_THREAD = 4
_ROWS_AT_ONCE, _WORK_AT_ONCE = 1 << 16, 100_000_000
"""Rows and operations after which a waiting Ctrl-C is heard: some 20 ms."""
_FEW = 64
_FLOAT64 = np.dtype(np.float64)
_SMALL = 16


def rows_at_once(work: int) -> int:
    """Rows of the largest batch that is worth no second thread.

    Args:
        work: operations of one evaluation.
    """
    return max(1, (2 * _PART_WORK - 1) // max(work, 1))


class Loops:
    """The ufuncs of a kernel, each made when it is first called.

    Args:
        batch: makes the generalised ufunc of the kernel.
        point: makes the one for contiguous arrays of one point.
    """

    __slots__ = ("_batch", "_makers", "_point")

    def __init__(self, batch: Callable[[], Callable[..., Any]], point: Callable[[], Callable[..., Any]]) -> None:
        self._makers = batch, point
        self._batch: Callable[..., Any] | None = None
        self._point: Callable[..., Any] | None = None

    def batch(self) -> Callable[..., Any]:
        """For any arrays."""
        if self._batch is None:
            self._batch = self._makers[0]()
        return self._batch

    def point(self, arrays: Sequence[Floats]) -> Callable[..., Any]:
        """For arguments and results of one point: by the single entry where their numbers lie side by side."""
        if not all(array.flags.c_contiguous for array in arrays):
            return self.batch()
        if self._point is None:
            self._point = self._makers[1]()
        return self._point


class Evaluator:
    """Calls a ufunc on what users give.

    Args:
        signature: ports.
        loops: ufuncs of the kernel.
        work: gives the operations of one evaluation, from which the number of parts of a batch follows.
        device: called as `device(*args, out=out)` for arrays that lie on a device.

    Attributes:
        twins: builtins of other kernels for forms of the call that mean them: under the text of `frame`, the tuple of
            keyword names, or the number of positional arguments. The builtin of this kernel looks here first.
    """

    __slots__ = ("_cores", "_device", "_loops", "_names", "_ranks", "_signature", "_work", "twins")

    def __init__(
        self,
        signature: Signature,
        loops: Loops,
        work: Callable[[], int],
        device: Callable[..., Any] | None = None,
    ) -> None:
        self.twins: dict[Hashable, Callable[..., Any]] = {}
        self._signature = signature
        self._device = device
        self._loops = loops
        self._work = work
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
        arrays = self._ordered(args, named)
        batch = self._common_batch(arrays)
        if batch is None:
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
        count = self._threads(batch, threads)
        try:
            if (count > 1 or self._pieces(batch) > 1) and not _overlapping(arrays, results or ()):
                return self._split(arrays, batch, results, count)
            loop = self._loops.batch() if batch else self._loops.point((*arrays, *(results or ())))
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

    def _ordered(self, args: Sequence[Any], named: Mapping[str, Any]) -> Sequence[Any]:
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
        for array in found if isinstance(found, tuple) else (found,):
            result = np.asarray(array)
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
        arrays = out if isinstance(out, tuple) else (out,)
        if len(arrays) != len(outputs):
            raise InputError("call.outputs", name=self._signature.name, expected=len(outputs), got=len(arrays))
        for port, array in zip(outputs, arrays):  # noqa: B905 - strict takes time, and both have one length
            _check_out(port, array, batch + port.shape)
        return arrays

    def _threads(self, batch: tuple[int, ...], wanted: int | None) -> int:
        """How many threads share the batch: one, if it is not worth two parts."""
        if type(wanted) is int and wanted == 1:
            return 1
        count = 0 if wanted is None else pool.checked(wanted)
        if prod(batch) < _SMALL or self._parts(batch) < 2:
            return 1
        return count or pool.available()

    def _parts(self, batch: tuple[int, ...]) -> int:
        """The most parts that a batch is worth."""
        return min(prod(batch) * max(self._work(), 1) // _PART_WORK, max(batch))

    def _pieces(self, batch: tuple[int, ...]) -> int:
        """The fewest parts between which a waiting Ctrl-C is heard soon enough."""
        rows = prod(batch)
        if rows <= _SMALL:
            return 1
        return min(1 + max(rows // _ROWS_AT_ONCE, rows * self._work() // _WORK_AT_ONCE), max(batch))

    def _split(
        self,
        arrays: Sequence[Floats],
        batch: tuple[int, ...],
        results: tuple[Floats, ...] | None,
        threads: int,
    ) -> Any:
        """Cut the longest batch axis into parts of nearly equal length; every row is computed as if alone."""
        ports = self._signature.ports
        if results is None:
            results = tuple(np.empty(batch + port.shape) for port in self._signature.outputs)
        parts = max(min(self._parts(batch), _PARTS_PER_THREAD * threads), self._pieces(batch))
        axis = batch.index(max(batch))
        edges = [batch[axis] * part // parts for part in range(parts + 1)]
        operands = [*arrays, *results]
        inputs, loop = len(arrays), self._loops.batch()

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
    return gate(port.name, value, port.shape)


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


def _check_out(port: Port, array: Any, shape: tuple[int, ...]) -> None:
    if not isinstance(array, np.ndarray) or array.dtype != _FLOAT64 or not array.flags.writeable:
        raise InputError("call.out", name=f"out ({port.name})")
    if array.shape != shape:
        raise InputError("input.shape", name=f"out ({port.name})", expected=shape, got=array.shape, hint="")


def _overlapping(arrays: Sequence[Floats], results: Sequence[Floats]) -> bool:
    """Whether a result may lie over an argument or another result: then NumPy orders the work, in one piece."""
    return any(
        np.may_share_memory(result, other) for i, result in enumerate(results) for other in (*arrays, *results[:i])
    )
