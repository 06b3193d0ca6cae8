"""Functions of the system that compiled loops call: their addresses in this process."""

from __future__ import annotations

import ctypes
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
    try:
        return [ctypes.CDLL(None), ctypes.CDLL("libm.so.6")]
    except OSError:  # No file of that name: mathematics is in the C library (musl, macOS), or Python has brought it.
        return [ctypes.CDLL(None)]
