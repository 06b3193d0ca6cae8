"""NVIDIA's driver by ctypes: the few calls that a launch needs, found at the first use."""

from __future__ import annotations

import ctypes
import sys
import threading
from collections.abc import Generator, Sequence
from contextlib import contextmanager, suppress
from functools import cache
from typing import Any

from mafsil.errors import InputError, KernelError
from mafsil.kernels.lazy import lazy

NAMES = ("nvcuda.dll",) if sys.platform == "win32" else ("libcuda.so.1", "libcuda.so")
_MAJOR, _MINOR = 75, 76
_OUT_OF_MEMORY = 2
_POINTER_DEVICE = 9


@cache
def driver() -> Driver:
    """The driver of this computer.

    Raises:
        KernelError: there is none, or it finds no device.
    """
    for name in NAMES:
        try:
            return Driver(ctypes.CDLL(name))
        except OSError:
            continue
    raise KernelError("export.no_driver", tried=", ".join(NAMES))


class Driver:
    """The driver's library, every answer checked.

    Args:
        library: what has the functions `cuInit`, `cuDeviceGetCount` and so on.
    """

    def __init__(self, library: Any) -> None:
        self._library = library
        self._devices: dict[int, Device] = {}
        self._opening = threading.Lock()
        self.call("cuInit", ctypes.c_uint(0))
        count = ctypes.c_int()
        self.call("cuDeviceGetCount", ctypes.byref(count))
        self.count = count.value
        if not self.count:
            raise KernelError("export.no_device")

    def call(self, name: str, *arguments: Any) -> None:
        """Call the driver.

        Raises:
            KernelError: it refuses; the sentence has its own words.
        """
        code = int(getattr(self._library, name)(*arguments))
        if code:
            raise KernelError("export.driver", call=name, reason=self._reason(code), code=code)

    def _reason(self, code: int) -> str:
        text = ctypes.c_char_p()
        self._library.cuGetErrorName(ctypes.c_int(code), ctypes.byref(text))
        return (text.value or b"unknown").decode()

    def device(self, ordinal: int = 0) -> Device:
        """A device by its number.

        Raises:
            InputError: there are fewer.
        """
        if not 0 <= ordinal < self.count:
            raise InputError("export.which_device", device=ordinal, count=self.count)
        with self._opening:
            if ordinal not in self._devices:
                self._devices[ordinal] = Device(self, ordinal)
            return self._devices[ordinal]

    def owner(self, pointer: int) -> int:
        """Number of the device on which memory lies."""
        ordinal = ctypes.c_int()
        self.call(
            "cuPointerGetAttribute", ctypes.byref(ordinal), ctypes.c_int(_POINTER_DEVICE), ctypes.c_uint64(pointer)
        )
        return ordinal.value


class Device:
    """One device and its primary context, which CuPy and PyTorch use too.

    Args:
        driver: its driver.
        ordinal: its number.
    """

    def __init__(self, driver: Driver, ordinal: int) -> None:
        self.driver = driver
        self.ordinal = ordinal
        self._handle = ctypes.c_int()
        driver.call("cuDeviceGet", ctypes.byref(self._handle), ctypes.c_int(ordinal))
        self._context = ctypes.c_void_p()
        driver.call("cuDevicePrimaryCtxRetain", ctypes.byref(self._context), self._handle)

    def __repr__(self) -> str:
        return f"<Device {self.ordinal}: {self.name}, {self.processor}>"

    @lazy
    def name(self) -> str:
        """As its maker calls it."""
        text = ctypes.create_string_buffer(256)
        self.driver.call("cuDeviceGetName", text, ctypes.c_int(256), self._handle)
        return text.value.decode("utf-8", "replace")

    @lazy
    def processor(self) -> str:
        """Its generation, such as `sm_90`."""
        return f"sm_{self._attribute(_MAJOR)}{self._attribute(_MINOR)}"

    def _attribute(self, number: int) -> int:
        value = ctypes.c_int()
        self.driver.call("cuDeviceGetAttribute", ctypes.byref(value), ctypes.c_int(number), self._handle)
        return value.value

    @contextmanager
    def current(self) -> Generator[None]:
        """Calls inside are about this device."""
        self.driver.call("cuCtxPushCurrent_v2", self._context)
        try:
            yield
        finally:
            self.driver.call("cuCtxPopCurrent_v2", ctypes.byref(ctypes.c_void_p()))

    def allocate(self, size: int) -> Memory:
        """Memory of `size` bytes; it is given back when the object goes."""
        return Memory(self, size)

    def write(self, pointer: int, source: int, size: int) -> None:
        """Copy from main memory to the device."""
        with self.current():
            self.driver.call(
                "cuMemcpyHtoD_v2", ctypes.c_uint64(pointer), ctypes.c_void_p(source), ctypes.c_size_t(size)
            )

    def read(self, target: int, pointer: int, size: int) -> None:
        """Copy from the device to main memory, after all that was asked before on the default stream."""
        with self.current():
            self.driver.call(
                "cuMemcpyDtoH_v2", ctypes.c_void_p(target), ctypes.c_uint64(pointer), ctypes.c_size_t(size)
            )

    def synchronize(self, stream: int | None = None) -> None:
        """Wait until the device, or one of its streams, is done."""
        with self.current():
            if stream is None:
                self.driver.call("cuCtxSynchronize")
            else:
                self.driver.call("cuStreamSynchronize", ctypes.c_void_p(stream))

    def module(self, text: str, entry: str) -> Module:
        """Load PTX; the driver finishes its compilation."""
        return Module(self, text, entry)

    def launch(self, function: Any, blocks: int, threads: int, arguments: Sequence[Any], stream: int = 0) -> None:
        """Start a kernel.

        Args:
            function: handle of the kernel.
            blocks, threads: how many, along one axis.
            arguments: ctypes values.
            stream: handle of a stream; 0 is the default one.
        """
        places = (ctypes.c_void_p * len(arguments))(*(ctypes.addressof(value) for value in arguments))
        sizes = (ctypes.c_uint(value) for value in (blocks, 1, 1, threads, 1, 1, 0))
        with self.current():
            self.driver.call("cuLaunchKernel", function, *sizes, ctypes.c_void_p(stream), places, None)


class Memory:
    """Memory on a device.

    Attributes:
        pointer: where it begins; 0 if it is empty.
    """

    def __init__(self, device: Device, size: int) -> None:
        self.device = device
        self.pointer = 0
        if not size:
            return
        found = ctypes.c_uint64()
        with device.current():
            try:
                device.driver.call("cuMemAlloc_v2", ctypes.byref(found), ctypes.c_size_t(size))
            except KernelError as error:
                if error.details["code"] != _OUT_OF_MEMORY:
                    raise
                raise KernelError("export.too_large", name=device.name, bytes=size, free=self._free()) from None
        self.pointer = found.value

    def _free(self) -> int:
        free, total = ctypes.c_size_t(), ctypes.c_size_t()
        self.device.driver.call("cuMemGetInfo_v2", ctypes.byref(free), ctypes.byref(total))
        return free.value

    def __del__(self) -> None:
        pointer, self.pointer = getattr(self, "pointer", 0), 0
        if pointer and not sys.is_finalizing():
            with suppress(KernelError), self.device.current():
                self.device.driver.call("cuMemFree_v2", ctypes.c_uint64(pointer))


class Module:
    """A loaded kernel.

    Attributes:
        function: its handle.
    """

    def __init__(self, device: Device, text: str, entry: str) -> None:
        self.device = device
        self.function = ctypes.c_void_p()
        self._handle = ctypes.c_void_p()
        image = ctypes.create_string_buffer(text.encode())
        with device.current():
            device.driver.call("cuModuleLoadData", ctypes.byref(self._handle), image)
            device.driver.call(
                "cuModuleGetFunction", ctypes.byref(self.function), self._handle, ctypes.c_char_p(entry.encode())
            )
