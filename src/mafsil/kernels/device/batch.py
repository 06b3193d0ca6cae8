"""A kernel called with arrays on a device: shapes checked, batches broadcast, one launch."""

from __future__ import annotations

import ctypes
from collections.abc import Callable, Sequence
from math import prod
from typing import Any, cast

import numpy as np

from mafsil.errors import InputError
from mafsil.kernels.device.array import DeviceArray, View, on_device, view
from mafsil.kernels.device.driver import Device, Module, driver
from mafsil.kernels.layout import Signature
from mafsil.kernels.ptx.program import GridProgram


class DeviceEvaluator:
    """Evaluates a kernel on the device where its arguments lie.

    Args:
        signature: ports.
        program: makes the kernel's PTX, once.
    """

    def __init__(self, signature: Signature, program: Callable[[], GridProgram]) -> None:
        self._signature = signature
        self._program = program
        self._made: GridProgram | None = None
        self._modules: dict[int, Module] = {}

    def __call__(self, *args: Any, out: Any = None) -> Any:
        """Evaluate over the broadcast batch.

        Args:
            args: one array (*batch, *core) per input port, each with `__cuda_array_interface__`, float64, contiguous.
            out: array of the exact result shape to write into, or a tuple of them.

        Returns:
            DeviceArray (*batch, *core) of the output port, or a tuple of them; `out`, if it was given.

        Raises:
            InputError: numbers in main memory, wrong shapes or types, arrays on different devices.
            KernelError: no driver, no device, no room.
        """
        ports = self._signature.inputs
        views = [self._seen(port.name, value) for port, value in zip(ports, args, strict=True)]
        batches = [self._batch_of(k, found) for k, found in enumerate(views)]
        try:
            batch = np.broadcast_shapes(*batches)
        except ValueError:
            named = ", ".join(f"{port.name} {shape}" for port, shape in zip(ports, batches, strict=True))
            raise InputError("call.batches", name=self._signature.name, batches=named) from None
        device = self._device(views)
        stream = _stream(views, device)
        results, given = self._results(out, batch, device, stream, views)
        rows = prod(batch)
        if rows and any(found.pointer for found in given):
            sources = [source(own, batch, port.name) for own, port in zip(batches, ports, strict=True)]
            self._launch(device, stream, views, sources, given, rows)
        return results[0] if len(results) == 1 else tuple(results)

    def _seen(self, name: str, value: object) -> View:
        if not on_device(value):
            raise InputError("export.mixed", name=self._signature.name, argument=name, got=type(value).__name__)
        return view(name, value)

    def _batch_of(self, k: int, found: View) -> tuple[int, ...]:
        port = self._signature.inputs[k]
        cut = len(found.shape) - len(port.shape)
        if cut < 0 or found.shape[cut:] != port.shape:
            expected = "(*batch, " + ", ".join(map(str, port.shape)) + ")"
            raise InputError("input.shape", name=port.name, expected=expected, got=found.shape, hint="")
        return found.shape[:cut]

    def _device(self, views: Sequence[View]) -> Device:
        """Where all arguments lie; empty ones lie anywhere."""
        found = driver()
        names = [port.name for port in self._signature.inputs]
        owners = [(name, found.owner(v.pointer)) for name, v in zip(names, views, strict=True) if v.pointer]
        first = owners[0][1] if owners else 0
        for name, owner in owners:
            if owner != first:
                raise InputError("export.other_device", argument=name, got=owner, expected=first)
        return found.device(first)

    def _results(
        self, out: Any, batch: tuple[int, ...], device: Device, stream: int, views: Sequence[View]
    ) -> tuple[list[Any], list[View]]:
        """The arrays that are handed back, and where they lie."""
        outputs = self._signature.outputs
        if out is None:
            arrays = [DeviceArray(device, batch + port.shape, stream) for port in outputs]
            return list(arrays), [view("out", x) for x in arrays]
        given: list[Any] = list(cast("tuple[Any, ...]", out)) if isinstance(out, tuple) else [out]
        if len(given) != len(outputs):
            raise InputError("call.outputs", name=self._signature.name, expected=len(outputs), got=len(given))
        found = [self._seen("out", x) for x in given]
        for port, place in zip(outputs, found, strict=True):
            self._fit(place, batch + port.shape, device, views)
        return given, found

    def _fit(self, place: View, shape: tuple[int, ...], device: Device, views: Sequence[View]) -> None:
        """Refuse a result array that cannot be written as asked."""
        if place.shape != shape:
            raise InputError("input.shape", name="out", expected=shape, got=place.shape, hint="")
        if not place.writable:
            raise InputError("export.read_only")
        owner = driver().owner(place.pointer) if place.pointer else device.ordinal
        if owner != device.ordinal:
            raise InputError("export.other_device", argument="out", got=owner, expected=device.ordinal)
        for port, other in zip(self._signature.inputs, views, strict=True):
            ends = place.pointer + 8 * prod(place.shape), other.pointer + 8 * prod(other.shape)
            if place.pointer < ends[1] and other.pointer < ends[0]:
                raise InputError("export.overlapping", argument=port.name)

    def _launch(
        self,
        device: Device,
        stream: int,
        views: Sequence[View],
        sources: Sequence[tuple[int, int]],
        given: Sequence[View],
        rows: int,
    ) -> None:
        program, module = self._loaded(device)
        arguments: list[Any] = []
        for found, (divisor, modulus) in zip(views, sources, strict=True):
            arguments += [ctypes.c_uint64(found.pointer), ctypes.c_int64(divisor), ctypes.c_int64(modulus)]
        arguments += [*(ctypes.c_uint64(found.pointer) for found in given), ctypes.c_int64(rows)]
        device.launch(module.function, program.plan.blocks(rows), program.plan.threads, arguments, stream)
        if any(found.stream not in (None, stream) for found in given):
            device.synchronize(stream)

    def _loaded(self, device: Device) -> tuple[GridProgram, Module]:
        if self._made is None:
            self._made = self._program()
        if device.ordinal not in self._modules:
            self._modules[device.ordinal] = device.module(self._made.text, self._made.name)
        return self._made, self._modules[device.ordinal]


def source(own: tuple[int, ...], batch: tuple[int, ...], name: str) -> tuple[int, int]:
    """(divisor, modulus): row r of the batch takes row (r / divisor) mod modulus of the argument; r itself if it is 0.

    Args:
        own: the argument's batch.
        batch: the whole batch.
        name: the argument's, for the error.

    Raises:
        InputError: the argument repeats along an axis between axes along which it does not.
    """
    own = (1,) * (len(batch) - len(own)) + own
    kept = [k for k, (a, b) in enumerate(zip(own, batch, strict=True)) if a == b and b != 1]
    if own == batch:
        return 1, 0
    if not kept:
        return 1, 1
    first, last = kept[0], kept[-1]
    if any(own[k] != batch[k] for k in range(first, last + 1)):
        raise InputError("export.broadcast", argument=name, batch=own, whole=batch)
    return prod(batch[last + 1 :]), prod(own)


def _stream(views: Sequence[View], device: Device) -> int:
    """The stream of the arguments, the default one if none says; of several, all but the chosen one are waited for."""
    named = sorted({found.stream for found in views if found.stream is not None}, reverse=True)
    for other in named[1:]:
        device.synchronize(other)
    return named[0] if named else 0
