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
    if sys.platform == "win32":
        libraries = [ctypes.CDLL("ucrtbase")]
    else:
        libraries = [ctypes.CDLL(None), ctypes.CDLL(_mathematics())]
    found: dict[str, int] = {}
    for name in (*_OF_MATHEMATICS, *_OF_MEMORY):
        for library in libraries:
            function = getattr(library, name, None)
            if function is not None:
                found[name] = ctypes.cast(function, ctypes.c_void_p).value or 0
    return found


def _mathematics() -> str | None:
    return "libm.so.6" if sys.platform == "linux" else ctypes.util.find_library("m")
