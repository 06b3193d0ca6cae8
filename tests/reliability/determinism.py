"""D1: a scenario has one hash, whatever the threads, the split of the batch, the order of runs and the cache's warmth.

`python -m tests.reliability.determinism --scenarios 1000 --resume DIR`
"""

from __future__ import annotations

import hashlib
import itertools
import os
import random
import sys
import tempfile

import numpy as np

from mafsil.code_store import CACHE_VARIABLE
from mafsil.kernels import Kernel, compiler, small_batch
from tests.reliability import figures, specimens

ROWS = 3000
ARMS = 10
"""Scenarios share this many kernels; the rest of a scenario is its states, its specials and its memory layout."""


def work(seed: int, scenarios: int) -> dict[str, int]:
    """Hash every scenario by all ways of calling; those of one scenario must agree."""
    count = {"scenarios": 0, "hashes": 0, "bad_scenarios": 0}
    usual = small_batch.HANDED_OVER_NS
    with tempfile.TemporaryDirectory(prefix="mafsil-D1-") as folder:
        os.environ[CACHE_VARIABLE] = folder
        compiler._images.clear()
        cold = {number: _hashes(seed + number) for number in range(scenarios)}
        order = list(range(scenarios))
        random.Random(seed).shuffle(order)
        try:
            small_batch.HANDED_OVER_NS = 200  # so that small batches, too, are split in many parts
            for number in order:
                if number % ARMS == 0:
                    compiler._images.clear()
                seen = cold[number] | _hashes(seed + number)
                count["hashes"] += 12
                count["bad_scenarios"] += len(seen) != 1
                count["scenarios"] += 1
        finally:
            small_batch.HANDED_OVER_NS = usual
    return count


def _hashes(scenario: int) -> set[str]:
    """Hashes of one scenario over threads 1, 2, 8 and pieces of 1, 7, 1000 rows."""
    links = 2 + scenario % ARMS % 6
    kernel = specimens.kernel(links, scenario % ARMS)
    q, shift = _scenario(links, scenario)
    whole = {_hash(kernel(q, shift, threads=threads)) for threads in (1, 2, 8)}
    rows = 64 if scenario % 10 else ROWS
    return whole | {_hash(_pieces(kernel, q, shift, size, rows)) for size in (1, 7, 1000)}


def _scenario(links: int, scenario: int) -> tuple[np.ndarray, np.ndarray]:
    """States with bad rows strewn in, in one of three memory layouts."""
    q, shift = specimens.states(links, ROWS, scenario)
    q[scenario % 50 :: 97, 0] = (np.nan, np.inf, 1e300, 5e-324)[scenario % 4]
    if scenario % 3 == 1:
        q = np.asfortranarray(q)
    if scenario % 3 == 2:
        q, shift = np.repeat(q, 2, axis=0)[::-2], np.repeat(shift, 2)[::-2]
    return q, shift


def _pieces(kernel: Kernel, q: np.ndarray, shift: np.ndarray, size: int, rows: int) -> tuple[np.ndarray, ...]:
    """The batch in pieces; beyond `rows` rows in pieces of 1000, so that single rows do not take for ever."""
    edges = [*range(0, rows, size), *range(rows, len(q), 1000), len(q)]
    cut = [kernel(q[a:b], shift[a:b], threads=1) for a, b in itertools.pairwise(edges)]
    return tuple(np.concatenate(parts) for parts in zip(*cut, strict=True))


def _hash(answer: tuple[np.ndarray, ...]) -> str:
    """Bits of an answer, any NaN counting as the same."""
    hashed = hashlib.blake2b(digest_size=16)
    for part in answer:
        hashed.update(np.where(np.isnan(part), np.nan, part).tobytes())
    return hashed.hexdigest()


if __name__ == "__main__":
    sys.exit(not figures.run("D1", figures.arguments(__doc__ or "", "scenarios", 50, 250), work)["passed"])
