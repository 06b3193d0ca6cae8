"""Arrays of a recording read back from a file that may be damaged, or made to look like one."""

from __future__ import annotations

import json
import tokenize
import zipfile
import zlib
from collections.abc import Collection, Iterable
from pathlib import Path
from typing import Any, BinaryIO, cast

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import FileError
from mafsil.messages import say
from mafsil.regular_file import open_regular, reason

KINEMATIC = "kinematic"
"""The plant of runs without forces."""
EFFORTS = ("tau", "tau_commanded")
"""Arrays that are NaN there: nothing is known of them."""
MOST_BYTES = 8 << 30
"""Of the arrays of one file: twice the longest run that is simulated."""
MOST_PACKED = 250
"""Times that arrays may be larger than their file, and a megabyte: motions shrink to a half, constant ones to a
hundredth."""
FEW_BYTES = 1 << 20
DAMAGES = (
    EOFError,
    MemoryError,
    NotImplementedError,
    RuntimeError,
    ValueError,
    KeyError,
    TypeError,
    zipfile.BadZipFile,
    zlib.error,
    tokenize.TokenError,
)
"""What NumPy, zip and JSON raise at files that are damaged, packed by other methods or locked by a password."""


def read(path: Path, names: Iterable[str], optional: Collection[str]) -> tuple[dict[str, Any], dict[str, Floats]]:
    """What a file says of itself, and its arrays by name.

    Args:
        path: of the file.
        names: of the arrays.
        optional: those of them that it may lack.

    Raises:
        FileError: missing, no regular file, damaged, an array that is lacking or holds no numbers, or more to unpack
            than such a file holds: before it is unpacked.
    """
    try:
        with open_regular(path) as file:
            _require_bounded(file)
            file.seek(0)
            with np.load(file, allow_pickle=False) as stored:
                about = json.loads(str(stored["about"]))
                arrays = {name: stored[name] for name in names if name in stored or name not in optional}
        if not isinstance(about, dict):
            raise ValueError(say("simulation.stored_about"))
    except FileNotFoundError:
        raise FileError("simulation.no_file", path=str(path)) from None
    except (OSError, RecursionError, *DAMAGES) as fault:
        raise FileError("simulation.bad_file", path=str(path), fault=reason(fault)) from None
    return cast("dict[str, Any]", about), arrays


def _require_bounded(file: BinaryIO) -> None:
    with zipfile.ZipFile(file) as packed:
        unpacked = sum(member.file_size for member in packed.infolist())
        size = sum(member.compress_size for member in packed.infolist())
    most = min(MOST_BYTES, MOST_PACKED * max(size, FEW_BYTES))
    if unpacked > most:
        raise ValueError(say("simulation.stored_packed", size=unpacked, limit=most))


def require_whole(arrays: dict[str, Floats], metadata: dict[str, Any]) -> None:
    """Refuse arrays that are no recording: of other shapes, times that do not increase, numbers that are not finite.

    Args:
        arrays: by name; those of runs side by side that ended early are not finite after their ends.
        metadata: names the joints.

    Raises:
        ValueError: the sentence names the array.
        KeyError, TypeError: the metadata lack the joints or the step.
    """
    joints, _ = [str(name) for name in metadata["joints"]], float(metadata["step"])
    t, q = arrays["t"], arrays["q"]
    if t.ndim != 1 or q.ndim < 2 or q.shape[0] != len(t) or q.shape[-1] != len(joints):
        raise ValueError(say("simulation.stored_shape", name="q", shape=q.shape, ticks=t.shape, joints=len(joints)))
    ended = metadata.get("run_ends") is not None
    for name, array in arrays.items():
        shape = t.shape if name == "t" else _shape(name, q.shape)
        if array.shape != shape:
            raise ValueError(say("simulation.stored_array", name=name, shape=array.shape, expected=shape))
        if array.dtype.kind not in "fiu":
            raise ValueError(say("simulation.stored_kind", name=name, kind=str(array.dtype)))
        unknown = metadata.get("plant") == KINEMATIC and name in EFFORTS and bool(np.isnan(array).all())
        if not (unknown or (ended and name != "t") or np.isfinite(array).all()):
            raise ValueError(say("simulation.stored_finite", name=name))
    if not (np.diff(t) > 0.0).all():
        raise ValueError(say("simulation.stored_times"))


def _shape(name: str, of_q: tuple[int, ...]) -> tuple[int, ...]:
    if name in ("tip_position_error", "tip_rotation_error"):
        return of_q[:-1]
    return (*of_q[:-1], 6) if name == "contact_wrench" else of_q
