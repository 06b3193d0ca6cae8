"""How large a result the caches of this machine keep until somebody reads it."""

from __future__ import annotations

from functools import cache
from pathlib import Path

_LAST_LEVEL = Path("/sys/devices/system/cpu/cpu0/cache/index3/size")
_USUAL = 32 << 20
"""Bytes of a last-level cache that does not say its size."""
_LONG_ROW = 512
"""Bytes of a row from which on plain stores lose early: many lines of each of the rows of a tile are open at once."""


def kept_bytes(row: int) -> int:
    """The largest result that is written through the caches; a larger one is written past them.

    Half of the last-level cache, since inputs and what the caller has in it want the other half; of long rows a
    quarter. Measured on 32 MiB: past the caches short rows win from 16 MB on, rows of 1 kB from 8 MB on; results that
    stay in the caches lose 10 to 40 % if they are written past them.

    Args:
        row: bytes of the results of one evaluation.
    """
    return last_level() // (2 if row < _LONG_ROW else 4)


@cache
def last_level() -> int:
    """Bytes of the last-level cache that this machine's cores share; the usual size where it is not known."""
    try:
        text = _LAST_LEVEL.read_text().strip()
        size = int(text.removesuffix("K").removesuffix("M")) << {"K": 10, "M": 20}.get(text[-1], 0)
    except (OSError, ValueError, IndexError):
        return _USUAL
    return size or _USUAL
