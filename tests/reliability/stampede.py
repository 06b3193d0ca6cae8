"""K3: many processes start at once on one empty cache; each expression is traced and each part of its code compiled
once, everybody is right, nobody waits for ever.

`python -m tests.reliability.stampede --rounds 1000 --resume DIR`
"""

from __future__ import annotations

import hashlib
import os
import signal
import sys
import tempfile
import threading
import time
import warnings
from pathlib import Path

from mafsil.code_store import CACHE_VARIABLE
from mafsil.kernels import Kernel, compiler, target
from mafsil.kernels.cache import Store
from mafsil.kernels.image import FROM_PYTHON
from tests.reliability import figures, specimens
from tests.reliability.kill_cache import _fork

LINKS = 3
PROCESSES = 8
CROWD = 32
THREADS = 8
PATIENCE = 60
SHARED = 1
"""Pieces of code that all kernels of a processor call."""
Variant = tuple[str | None, str]
VARIANTS: tuple[tuple[Variant, ...], ...] = (
    ((None, ""),),
    (("", ""), ("-avx512f", "")),
    ((None, "release 1"), (None, "release 2")),
)
"""Feature strings and package versions that meet on one cache."""


def work(seed: int, rounds: int) -> dict[str, int]:
    """Alternate rounds of 8 processes, a crowd of 32, two feature strings or releases on one cache, and 8 threads."""
    count = dict.fromkeys(
        (
            "rounds",
            "starts",
            "compiles",
            "bad_entries",
            "bad_wrong",
            "bad_bits",
            "bad_twice",
            "bad_dead",
            "thread_rounds",
        ),
        0,
    )
    for number in range(rounds):
        with tempfile.TemporaryDirectory(prefix="mafsil-K3-") as folder:
            os.environ[CACHE_VARIABLE] = folder
            variants = VARIANTS[number % len(VARIANTS)]
            processes = CROWD if number % 5 == 4 else PROCESSES
            answers = _together(processes, variants)
            count["rounds"] += 1
            count["starts"] += processes
            compiles = sum(int(a.split()[1]) for a in answers)
            count["compiles"] += compiles
            count["bad_dead"] += processes - len(answers)
            count["bad_wrong"] += sum(a.startswith("wrong") for a in answers)
            count["bad_bits"] += len({a.split()[0] for a in answers}) != 1
            machines = {_identity(features) for features, _ in variants}
            versions = {version for _, version in variants}
            count["bad_entries"] += _entries(folder) != (len(versions), len(machines) * (len(FROM_PYTHON) + SHARED))
            count["bad_twice"] += compiles != len(machines) * len(FROM_PYTHON)
        with tempfile.TemporaryDirectory(prefix="mafsil-K3-") as folder:
            os.environ[CACHE_VARIABLE] = folder
            count["bad_bits"] += len(_threads()) != 1
            count["bad_entries"] += _entries(folder) != (1, len(FROM_PYTHON) + SHARED)
            count["thread_rounds"] += 1
    return count


def _identity(features: str | None) -> str:
    return "this" if features is None else target.host(features).identity


def _together(processes: int, variants: tuple[Variant, ...]) -> list[str]:
    """What all children say who began at the same moment."""
    reading, writing = os.pipe()
    start = time.time() + 0.02 + 0.004 * processes
    children = [_fork(lambda i=i: _start(start, variants[i % len(variants)], writing)) for i in range(processes)]
    os.close(writing)
    with open(reading) as answers:
        said = answers.read().split("\n")[:-1]
    for child in children:
        os.waitpid(child, 0)
    return said


def _start(moment: float, variant: Variant, answer: int) -> None:
    signal.alarm(PATIENCE)
    warnings.simplefilter("ignore", DeprecationWarning)
    compiler._images.clear()
    time.sleep(max(0.0, moment - time.time()))
    kernel = specimens.kernel(LINKS, 0, *variant)
    bits = _bits(kernel)
    digest = "wrong" if specimens.wrong(LINKS, 0, kernel) else hashlib.blake2b(bits).hexdigest()
    compiled = sum(not part.cached for part in kernel.image.parts.values())
    os.write(answer, f"{digest} {compiled}\n".encode())


def _bits(kernel: Kernel) -> bytes:
    """Of a batch and of a single call; which comes first is the process's own matter."""
    states = specimens.states(LINKS, 33)
    first = kernel(*(x[0] for x in states)) if os.getpid() % 2 else None
    rows = kernel(*states)
    return specimens.bits(rows) + specimens.bits(first or kernel(*(x[0] for x in states)))


def _threads() -> set[bytes]:
    """Bits that threads see who all ask for their own kernel object at once."""
    compiler._images.clear()
    barrier = threading.Barrier(THREADS)
    seen: list[bytes] = []

    def ask() -> None:
        kernel = specimens.kernel(LINKS, 0)
        barrier.wait()
        seen.append(_bits(kernel))

    asking = [threading.Thread(target=ask) for _ in range(THREADS)]
    for thread in asking:
        thread.start()
    for thread in asking:
        thread.join()
    return set(seen) if len(seen) == THREADS else set()


def _entries(folder: str) -> tuple[int, int]:
    """Tapes and pieces of code in the folder, all of them whole; -1 if one is not."""
    store = Store(Path(folder))
    tapes, codes = (list(Path(folder).glob(f"*.{suffix}")) for suffix in ("tape", "kernel"))
    return (
        len(tapes) if all(store.get_tape(path.stem) for path in tapes) else -1,
        len(codes) if all(store.get(path.stem) for path in codes) else -1,
    )


if __name__ == "__main__":
    sys.exit(not figures.run("K3", figures.arguments(__doc__ or "", "rounds", 5, 50), work)["passed"])
