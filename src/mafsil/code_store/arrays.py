"""Arrays that take long to compute and follow from what their key says alone, kept beside the compiled code."""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from math import prod
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.code_store.folder import code_folder
from mafsil.code_store.store import FileStore, StoreKind

ARRAYS = StoreKind(b"mafsilN\0", ".arrays")


def digest_of(*parts: str | bytes | NDArray[Any]) -> str:
    """64 hexadecimal digits that differ when any of the parts does: texts, bytes, arrays with their shapes."""
    hashed = hashlib.blake2b(digest_size=32)
    for part in parts:
        kind = f"{part.dtype} {part.shape}" if isinstance(part, np.ndarray) else type(part).__name__
        data = part.encode() if isinstance(part, str) else part if isinstance(part, bytes) else part.tobytes()
        hashed.update(f"{kind} {len(data)}\n".encode() + data)
    return hashed.hexdigest()


def kept_array(key: str, compute: Callable[[], NDArray[np.float64]]) -> NDArray[np.float64]:
    """The array of a key: as it was kept, else computed and kept.

    Args:
        key: `digest_of` all that it follows from, the code that computes it among them.
        compute: makes it.
    """
    store = FileStore(code_folder(), ARRAYS)
    data = store.get(key)
    if data is None:
        array = np.ascontiguousarray(compute(), np.float64)
        store.put(key, np.array([array.ndim, *array.shape], "<i8").tobytes() + array.astype("<f8").tobytes())
        return array
    dimensions = int.from_bytes(data[:8], "little")
    shape = np.frombuffer(data, "<i8", dimensions, 8).tolist()
    return np.frombuffer(data, "<f8", prod(shape), 8 * (1 + dimensions)).reshape(shape).astype(np.float64)
