"""R14: the compiled linear program core, random and degenerate: optimality to 1e-10, verdicts as HiGHS, certificates.

`python -m tests.reliability.programs --programs 10000000 --resume DIR`

Which matrices A have x > 0 with A x = 0? Most are random; one in ten has whole entries, repeated columns, columns that
cancel each other or rows that depend on each other. One in a hundred is asked of HiGHS too. There is no quadratic
program of our own.
"""

from __future__ import annotations

import sys

import numpy as np
from scipy.optimize import linprog

from mafsil.arrays import Floats
from mafsil.grasp.contact_batch import wrench_closures
from tests.reliability import figures

CHUNK = 10_000
HIGHS_EVERY = 100
LIMIT = 1e-10


def work(seed: int, programs: int) -> dict[str, int]:
    """Counts of programs and faults."""
    rng = np.random.default_rng([14, seed])
    count: dict[str, int] = {"programs": programs}
    for start in range(0, programs, CHUNK):
        size = min(CHUNK, programs - start)
        for W in (random_programs(rng, size - size // 10), degenerate_programs(rng, size // 10)):
            for name, value in _judge(W).items():
                count[name] = count.get(name, 0) + value
    return count


def random_programs(rng: np.random.Generator, count: int) -> Floats:
    """(count, m, n) with about as many that span as not."""
    m = int(rng.integers(2, 7))
    n = m + int(rng.integers(1, 4 * m))
    return rng.normal(size=(count, m, n)) - rng.uniform(0, 0.6) * (n - m) / n


def degenerate_programs(rng: np.random.Generator, count: int) -> Floats:
    """(count, m, n) of small whole numbers, with copies, opposites and dependent rows."""
    m = int(rng.integers(2, 7))
    n = m + int(rng.integers(1, 2 * m))
    W = rng.integers(-2, 3, (count, m, n)).astype(float)
    W[:, :, -1] = rng.choice([-1.0, 1.0, 2.0], (count, 1)) * W[:, :, 0]
    if rng.random() < 0.2:
        W[:, -1] = W[:, 0] - W[:, -2]
    return W


def _judge(W: Floats) -> dict[str, int]:
    found = wrench_closures(W)
    size = np.maximum(np.abs(W).max(axis=(1, 2)), 1e-300)
    yes, no = found.force_closure, ~found.force_closure
    x, y = found.combination[yes], found.certificate[no]
    residual = np.abs(np.einsum("bmn,bn->bm", W[yes], x)).max(axis=1, initial=0.0) / size[yes]
    support = np.einsum("bmn,bm->bn", W[no], y).min(axis=1, initial=0.0) / size[no]
    asked = range(0, len(W), HIGHS_EVERY)
    return {
        "yes": int(yes.sum()),
        "asked_of_highs": len(asked),
        "exact": found.rechecked,
        "bad_residual": int((residual > LIMIT).sum() + (x <= 0).any(axis=1).sum()),
        "bad_certificate": int((support < -LIMIT).sum() + (~y.any(axis=1)).sum()),
        "bad_verdict": sum(int(_highs(W[k]) != found.force_closure[k]) for k in asked),
    }


def _highs(A: Floats) -> bool:
    m, n = A.shape
    found = linprog(np.zeros(n), A_eq=A, b_eq=np.zeros(m), bounds=(1.0, None), method="highs")
    return found.status == 0 and np.linalg.matrix_rank(A) == m


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "programs", 100_000, 100_000)
    sys.exit(not figures.run("R14", options, work)["passed"])
