"""C1: threads share kernels; every answer has the bits of the serial one.

`python -m tests.reliability.concurrency --calls 640000 --resume DIR`
"""

from __future__ import annotations

import os
import sys
import tempfile
import threading

import numpy as np

from mafsil.code_store import CACHE_VARIABLE
from mafsil.kernels import Kernel, compiler
from tests.reliability import figures, specimens

THREADS = 64
LINKS = (2, 3, 7)
ROWS = (1, 7, 9, 1000)


def work(seed: int, calls: int) -> dict[str, int]:
    """`calls` calls in all, spread over 64 threads: points, batches, keywords, results of the caller."""
    with tempfile.TemporaryDirectory(prefix="mafsil-C1-") as folder:
        os.environ[CACHE_VARIABLE] = folder
        compiler._images.clear()
        kernels = [specimens.kernel(links) for links in LINKS]
        serial = [_answers(kernel, links, seed) for kernel, links in zip(kernels, LINKS, strict=True)]
        wrong: list[int] = []
        barrier = threading.Barrier(THREADS)

        def call_many(number: int) -> None:
            barrier.wait()
            bad = 0
            for call in range(-(-calls // THREADS)):
                which = (call + number) % len(LINKS)
                bad += not _one(kernels[which], LINKS[which], serial[which], seed, call, number)
            wrong.append(bad)

        threads = [threading.Thread(target=call_many, args=(n,)) for n in range(THREADS)]
        for thread in threads:
            thread.start()
        for thread in threads:
            thread.join()
    return {"calls": calls, "bad_bits": sum(wrong), "bad_threads": THREADS - len(wrong)}


def _answers(kernel: Kernel, links: int, seed: int) -> tuple[np.ndarray, ...]:
    return kernel(*specimens.states(links, max(ROWS), seed), threads=1)


def _one(kernel: Kernel, links: int, serial: tuple[np.ndarray, ...], seed: int, call: int, number: int) -> bool:
    q, shift = _STATES.setdefault((links, seed), specimens.states(links, max(ROWS), seed))
    row = (call * 7 + number) % max(ROWS)
    if call % 4:
        return specimens.bits(kernel(q[row], float(shift[row]))) == specimens.bits(tuple(x[row] for x in serial))
    rows = ROWS[(call // 4) % len(ROWS)]
    out = tuple(np.empty_like(x[:rows]) for x in serial) if call % 8 else None
    answer = kernel(shift=shift[:rows], q=q[:rows], out=out, threads=1 + call % 3)
    return specimens.bits(answer) == specimens.bits(tuple(x[:rows] for x in serial))


_STATES: dict[tuple[int, int], tuple[np.ndarray, np.ndarray]] = {}


if __name__ == "__main__":
    sys.exit(not figures.run("C1", figures.arguments(__doc__ or "", "calls", 64_000, 640_000), work)["passed"])
