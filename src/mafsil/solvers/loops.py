"""How loops to convergence are compiled: one decorator, one set of options.

Modules whose name ends in `_loops` use it at their top and are imported at first use only, for numba costs half a
second to import. Compiled loops are kept on disk (`loop_cache`), release the interpreter's lock and follow IEEE rules:
a division by zero is an infinity, not an exception.
"""

from __future__ import annotations

import atexit
from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit
from numba.core.compiler_lock import global_compiler_lock

try:
    from mafsil.solvers.loop_cache import LoopCache
except (ImportError, AttributeError):  # A release of numba that is arranged otherwise: loops stay in memory.
    LoopCache = None

# A thread inside LLVM while the process takes LLVM down would crash it: the end waits for whoever compiles.
atexit.register(global_compiler_lock.acquire)

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """The function as machine code, compiled for the types of its first call.

    Args:
        function: loops over arrays and numbers.
    """
    return _kept(function, njit(nogil=True, error_model="numpy")(function))


def reordered(function: F) -> F:
    """As `compiled`, but sums may be taken in another order, so loops along a row fill whole vectors.

    Args:
        function: loops over arrays and numbers.
    """
    flags = {"reassoc", "nsz", "contract"}
    return _kept(function, njit(nogil=True, error_model="numpy", fastmath=flags)(function))


def uncounted(function: F) -> F:
    """As `compiled`, for inner loops that make no arrays: owners of the arrays that they are handed are not counted.

    Numba counts owners by an atomic addition wherever an array is passed on or sliced; a loop that hands on a dozen
    arrays a million times spends its time with that. The caller's own arrays outlive the call.

    Args:
        function: loops over arrays and numbers, which neither makes nor returns an array.
    """
    return _kept(function, njit(nogil=True, error_model="numpy", _nrt=False)(function))


def inlined(function: F) -> F:
    """As `uncounted`, put into each of its callers: for short functions whose arguments cost more than their work."""
    return _kept(function, njit(nogil=True, error_model="numpy", _nrt=False, forceinline=True)(function))


def _kept(function: F, dispatcher: Any) -> F:
    """The compiled function, its code looked for on disk first.

    Numba's own cache is never asked: it unpickles what it finds.
    """
    if LoopCache is not None and hasattr(dispatcher, "_cache"):
        dispatcher._cache = LoopCache(function)
    return cast(F, dispatcher)
