"""K2: damaged entries are found out before anything of them is used, and compiled again.

`python -m tests.reliability.corrupt_cache --cases 10000 --resume DIR`
"""

from __future__ import annotations

import os
import random
import struct
import sys
import tempfile
import warnings
from pathlib import Path

from mafsil.code_store import CACHE_VARIABLE, CacheWarning, FileStore
from mafsil.kernels import compiler
from mafsil.kernels.cache import KERNEL, TAPE
from mafsil.kernels.loops.specialisation import LOOP
from tests.reliability import figures, specimens

SPECIMENS = tuple((links, 0) for links in (1, 2, 3, 4, 6))
LOOPS = 3
_HEADER = 84
RECOMPILE_EVERY = 250


def work(seed: int, cases: int) -> dict[str, int]:
    """Damage one entry per case, ask for it, see that it is refused and replaced."""
    dice = random.Random(seed)
    count = dict.fromkeys(("cases", "bad_undetected", "bad_kept", "bad_recovered", "recompiled"), 0)
    warnings.simplefilter("ignore", CacheWarning)
    with tempfile.TemporaryDirectory(prefix="mafsil-K2-") as folder:
        os.environ[CACHE_VARIABLE] = folder
        compiler._images.clear()  # what an earlier shard loaded would not be written to this folder
        known = [specimens.keys(specimens.kernel(*which)) for which in SPECIMENS]
        owners = [owner for owner, (_, codes) in enumerate(known) for _ in (0, *codes)]
        paths = [
            Path(folder) / name for tape, codes in known for name in (f"{tape}.tape", *(f"{k}.kernel" for k in codes))
        ]
        paths += [_loop(Path(folder), dice) for _ in range(LOOPS)]
        whole = [path.read_bytes() for path in paths]
        for case in range(cases):
            victim = dice.randrange(len(paths))
            damage = DAMAGES[case % len(DAMAGES)]
            paths[victim].write_bytes(damage(dice, whole[victim], whole[victim - 1]))
            count["cases"] += 1
            kind = next(kind for kind in (KERNEL, TAPE, LOOP) if kind.suffix == paths[victim].suffix)
            count["bad_undetected"] += FileStore(Path(folder), kind).get(paths[victim].stem) is not None
            count["bad_kept"] += paths[victim].exists()
            if case % RECOMPILE_EVERY == RECOMPILE_EVERY - 1 and victim < len(owners):
                compiler._images.clear()
                links, which = SPECIMENS[owners[victim]]
                made = specimens.kernel(links, which)
                count["bad_recovered"] += specimens.wrong(links, which, made)
                specimens.keys(made)
                count["recompiled"] += 1
                whole[victim] = paths[victim].read_bytes()
            paths[victim].write_bytes(whole[victim])
    return count


def _loop(folder: Path, dice: random.Random) -> Path:
    """An entry of a compiled loop's size: what is in it does not matter to the seal."""
    key = dice.randbytes(32).hex()
    FileStore(folder, LOOP).put(key, dice.randbytes(dice.randrange(5_000, 60_000)))
    return folder / f"{key}.loop"


def _flip(dice: random.Random, data: bytes, _other: bytes) -> bytes:
    at = dice.randrange(8 * len(data))
    return data[: at // 8] + bytes([data[at // 8] ^ 1 << at % 8]) + data[at // 8 + 1 :]


def _flip_header(dice: random.Random, data: bytes, _other: bytes) -> bytes:
    return _flip(dice, data[:_HEADER], b"") + data[_HEADER:]


def _cut(dice: random.Random, data: bytes, _other: bytes) -> bytes:
    return data[: dice.randrange(len(data))]


def _grow(dice: random.Random, data: bytes, _other: bytes) -> bytes:
    return data + dice.randbytes(dice.randrange(1, 5000))


def _zero_fill(dice: random.Random, data: bytes, other: bytes) -> bytes:
    """Zeros from somewhere to the end, as a file system leaves after a lost write; or blocks of 512."""
    at = dice.randrange(len(data) - 1) if dice.random() < 0.5 else dice.randrange(len(data)) // 512 * 512
    end = len(data) if dice.random() < 0.5 else min(at + 512, len(data))
    filled = data[:at] + bytes(end - at) + data[end:]
    return filled if filled != data else _flip(dice, data, other)


def _swap(_dice: random.Random, _data: bytes, other: bytes) -> bytes:
    """Another kernel's file under this name."""
    return other


def _swap_payload(_dice: random.Random, data: bytes, other: bytes) -> bytes:
    """This header over another kernel's payload, its length corrected."""
    length = struct.pack("<Q", len(other) - _HEADER)
    return data[:44] + length + data[52:_HEADER] + other[_HEADER:]


def _swap_key(_dice: random.Random, data: bytes, other: bytes) -> bytes:
    """Another kernel's file with this key written into its header."""
    return other[:12] + data[12:44] + other[44:]


def _stale(dice: random.Random, data: bytes, _other: bytes) -> bytes:
    """The header of another format version, or of another program."""
    if dice.random() < 0.5:
        return data[:8] + struct.pack("<I", dice.choice([0, 2, 3, 1 << 31])) + data[12:]
    return dice.randbytes(8) + data[8:]


def _shuffle(dice: random.Random, data: bytes, other: bytes) -> bytes:
    """Two blocks of 64 bytes changed places."""
    a, b = (dice.randrange(len(data) // 64) * 64 for _ in range(2))
    moved = bytearray(data)
    moved[a : a + 64], moved[b : b + 64] = data[b : b + 64], data[a : a + 64]
    return bytes(moved) if bytes(moved) != data else _flip(dice, data, other)


DAMAGES = (_flip, _flip_header, _cut, _grow, _zero_fill, _swap, _swap_payload, _swap_key, _stale, _shuffle)


if __name__ == "__main__":
    sys.exit(not figures.run("K2", figures.arguments(__doc__ or "", "cases", 1000, 2000), work)["passed"])
