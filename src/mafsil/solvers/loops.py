"""How loops to convergence are compiled: one decorator, one set of options.

Modules whose name ends in `_loops` use it at their top and are imported at first use only, for numba costs half a
second to import. Compiled loops are kept on disk by numba, release the interpreter's lock and follow IEEE rules:
a division by zero is an infinity, not an exception.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar, cast

from numba import njit

F = TypeVar("F", bound=Callable[..., Any])


def compiled(function: F) -> F:
    """The function as machine code, compiled for the types of its first call.

    Args:
        function: loops over arrays and numbers.
    """
    return cast(F, njit(cache=True, nogil=True, error_model="numpy")(function))


def reordered(function: F) -> F:
    """As `compiled`, but sums may be taken in another order, so loops along a row fill whole vectors.

    Args:
        function: loops over arrays and numbers.
    """
    flags = {"reassoc", "nsz", "contract"}
    return cast(F, njit(cache=True, nogil=True, error_model="numpy", fastmath=flags)(function))
