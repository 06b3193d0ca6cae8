"""A stand-in for NVIDIA's driver library: the same functions, device memory in main memory, kernels run block by block.

The code it runs is the very IR that becomes PTX, compiled for this processor.
"""

from __future__ import annotations

import ctypes
import re
from functools import cache
from typing import Any

import numpy as np

from mafsil.kernels import target
from mafsil.kernels.export.exported import tapes
from mafsil.kernels.kernel import Kernel
from mafsil.kernels.ptx.grid import host_module, plan
from mafsil.kernels.ptx.program import GridProgram, device_program, inspect

CANARY = 0x5A
PADDING = 64
INVALID, NO_MEMORY, NO_DEVICE = 1, 2, 100


@cache
def emulated(kernel: Kernel) -> tuple[tuple[Any, Any], GridProgram]:
    """((what one block does as a C function, what keeps its code), the same as PTX)."""
    _, reduced = tapes(kernel)
    host = target.host()
    ir = host_module(reduced, kernel.signature, host, plan(kernel.signature), "mafsil_block")
    code = target.load(target.translate(ir, host, "object", reloc="pic"), ("mafsil_block",))
    program = device_program(kernel.signature, kernel.build)
    return (ctypes.CFUNCTYPE(None)(code.addresses["mafsil_block"]), code), program


class FakeLibrary:
    """`libcuda.so.1` of a computer with `devices` devices.

    Args:
        devices: how many.
        room: bytes of memory on each.
    """

    def __init__(self, devices: int = 1, room: int = 1 << 30) -> None:
        self.devices = devices
        self.room = room
        self.kernels: dict[str, Any] = {}
        self.memory: dict[int, tuple[int, int, Any]] = {}
        self.contexts: list[int] = []
        self.modules: list[str] = []
        self.launches: list[dict[str, Any]] = []
        self.waits: list[int | None] = []
        self.freed = 0

    def learn(self, kernel: Kernel) -> None:
        """Know the code behind the PTX of a kernel."""
        found = emulated(kernel)
        self.kernels[found[1].text] = found

    def intact(self) -> bool:
        """No write went beyond the end of an allocation."""
        return all((np.asarray(buffer)[size:] == CANARY).all() for size, _, buffer in self.memory.values())

    def cuInit(self, flags: Any) -> int:
        return 0

    def cuGetErrorName(self, code: Any, text: Any) -> int:
        text._obj.value = b"CUDA_ERROR_OUT_OF_MEMORY" if code.value == NO_MEMORY else b"CUDA_ERROR_INVALID_VALUE"
        return 0

    def cuDeviceGetCount(self, count: Any) -> int:
        count._obj.value = self.devices
        return 0

    def cuDeviceGet(self, handle: Any, ordinal: Any) -> int:
        handle._obj.value = ordinal.value
        return 0

    def cuDeviceGetName(self, text: Any, size: Any, handle: Any) -> int:
        text.value = b"Stand-in"
        return 0

    def cuDeviceGetAttribute(self, value: Any, number: Any, handle: Any) -> int:
        value._obj.value = {75: 9, 76: 0}[number.value]
        return 0

    def cuDevicePrimaryCtxRetain(self, context: Any, handle: Any) -> int:
        context._obj.value = 1000 + handle.value
        return 0

    def cuCtxPushCurrent_v2(self, context: Any) -> int:
        self.contexts.append(context.value - 1000)
        return 0

    def cuCtxPopCurrent_v2(self, context: Any) -> int:
        self.contexts.pop()
        return 0

    def cuCtxSynchronize(self) -> int:
        self.waits.append(None)
        return 0

    def cuStreamSynchronize(self, stream: Any) -> int:
        self.waits.append(stream.value)
        return 0

    def cuMemAlloc_v2(self, pointer: Any, size: Any) -> int:
        if size.value > self.room:
            return NO_MEMORY
        buffer = np.full(size.value + PADDING, CANARY, dtype=np.uint8)
        buffer[: size.value] = 0xFF  # NaN
        pointer._obj.value = buffer.ctypes.data
        self.memory[buffer.ctypes.data] = (size.value, self.contexts[-1], buffer)
        return 0

    def cuMemFree_v2(self, pointer: Any) -> int:
        self.freed += 1
        return 0 if self.memory.pop(pointer.value, None) else INVALID

    def cuMemGetInfo_v2(self, free: Any, total: Any) -> int:
        free._obj.value = total._obj.value = self.room
        return 0

    def cuMemcpyHtoD_v2(self, pointer: Any, source: Any, size: Any) -> int:
        if self._owner(pointer.value) != self.contexts[-1]:
            return INVALID
        ctypes.memmove(pointer.value, source.value, size.value)
        return 0

    def cuMemcpyDtoH_v2(self, goal: Any, pointer: Any, size: Any) -> int:
        ctypes.memmove(goal.value, pointer.value, size.value)
        return 0

    def cuPointerGetAttribute(self, value: Any, attribute: Any, pointer: Any) -> int:
        owner = self._owner(pointer.value)
        value._obj.value = owner
        return 0 if owner >= 0 else INVALID

    def _owner(self, pointer: int) -> int:
        for start, (size, device, _) in self.memory.items():
            if start <= pointer < start + size:
                return device
        return -1

    def cuModuleLoadData(self, handle: Any, image: Any) -> int:
        text = image.value.decode()
        details = inspect(text)
        assert not details.undeclared
        assert not details.outside
        self.modules.append(text)
        handle._obj.value = len(self.modules)
        return 0

    def cuModuleGetFunction(self, function: Any, handle: Any, name: Any) -> int:
        if name.value.decode() not in inspect(self.modules[handle.value - 1]).entries:
            return INVALID
        function._obj.value = handle.value
        return 0

    def cuLaunchKernel(self, function: Any, *rest: Any) -> int:
        sizes, (stream, places, extra) = [size.value for size in rest[:7]], rest[7:]
        text = self.modules[function.value - 1]
        (block, _), program = self.kernels[text]
        head = text[text.index(f".entry {program.name}") :].partition(")")[0]
        assert len(places) == len(re.findall(r"\.param", head))
        assert sizes[3] == program.plan.threads == int(re.search(r"\.maxntid (\d+)", text).group(1))
        assert sizes[1:3] == sizes[4:6] == [1, 1]
        assert 1 <= sizes[0] < 1 << 31
        assert extra is None
        values = [ctypes.c_uint64.from_address(place) for place in places]
        for k in range(sizes[0]):
            block(ctypes.c_int64(k), *values)
        launch = {"blocks": sizes[0], "stream": stream.value or 0, "device": self.contexts[-1]}
        self.launches.append(launch)
        return 0
