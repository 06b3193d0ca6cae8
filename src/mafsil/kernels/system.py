"""Functions of the system that compiled loops call: their addresses in this process."""

from __future__ import annotations

import ctypes
import ctypes.util
import sys
from functools import cache

_OF_MATHEMATICS = (
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "exp", "log", "pow", "hypot", "fmod", "nextafter", "floor",
    "ceil", "rint", "sincos", "exp2", "exp10", "ldexp", "cbrt",
)  # fmt: skip
_OF_MEMORY = ("malloc", "free", "memcpy", "memset", "memmove", "bcmp", "memcmp")


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
    mathematics = "libm.so.6" if sys.platform == "linux" else ctypes.util.find_library("m")
    try:
        return [ctypes.CDLL(None), ctypes.CDLL(mathematics)]
    except OSError:  # Musl has no file of that name: its C library is all there is.
        return [ctypes.CDLL(None)]
