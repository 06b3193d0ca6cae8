"""Row R9: mobility of random mechanisms by rank against Pinocchio, and finite mobility of over-constrained ones.

python -m tests.reliability.mechanisms --mechanisms 100000 --resume DIR

Every mechanism is looked at as drawn and, where Newton's method closes it, somewhere else: the mobility by rank, and
the rank of the compiled loops, are what Pinocchio's constraint Jacobian says. With every tenth comes another one: one
or two over-constrained mechanisms hung on each other, whose finite mobility a theorem tells. Ranks whose last singular
value is within four digits of the tolerance are counted as doubtful.
"""

from __future__ import annotations

import sys
from collections import Counter

import numpy as np

from mafsil import mobility as mo
from mafsil.arrays import Floats
from tests.mobility.mechanisms import random_linkage
from tests.mobility.pinocchio_rank import PinocchioLinkage
from tests.reliability import figures
from tests.reliability.over_constrained import BUILDERS, composed

DOUBTFUL = 1e-5
BUILT_EACH = 10


def work(seed: int, count: int) -> dict[str, int]:
    """Ranks of `count` random mechanisms, and the finite mobility of a tenth as many built ones."""
    total: Counter[str] = Counter(mechanisms=count)
    for k in range(count):
        rng = np.random.default_rng([9, seed, k])
        total += _compared(rng)
        if k % BUILT_EACH == 0:
            total += _built(rng)
    return {"bad_rank": 0, "bad_compiled_rank": 0, "bad_finite": 0, **total}


def _compared(rng: np.random.Generator) -> Counter[str]:
    """One random mechanism: configurations judged and doubtful, and ranks that differ."""
    linkage = random_linkage(rng, int(rng.integers(0, 4)), int(rng.integers(3, 9)))
    other, total = PinocchioLinkage(linkage), Counter[str]()
    for row in closed(linkage, rng):
        found = mo.instantaneous_mobility(linkage, row)
        if found.kept < DOUBTFUL or found.dropped > 1e-12:
            total["doubtful"] += 1
            continue
        expected = other.mobility(other.configuration(row))
        total["configurations"] += 1
        total["bad_rank"] += found.mobility != expected
        total["bad_compiled_rank"] += int(mo.batch_mobility(linkage, row)) != expected
    return total


def _built(rng: np.random.Generator) -> Counter[str]:
    """One over-constrained mechanism: whether its finite mobility is what the theorem says, and how sure we are."""
    names = rng.choice(sorted(BUILDERS), int(rng.integers(1, 3)))
    linkage, expected = composed(rng, names.tolist())
    found = mo.finite_mobility(linkage)
    total = Counter({"over_constrained": 1, "proven": int(found.proven)})
    total["bad_finite"] += found.mobility != expected
    return total


def closed(linkage: mo.Linkage, rng: np.random.Generator) -> Floats:
    """(k, F) configurations of a linkage, as drawn and one elsewhere if it was found."""
    moved = mo.linkages.close_loops_near(linkage, 0.5 * rng.normal(size=(1, linkage.coordinates)))
    return np.vstack([np.zeros((1, linkage.coordinates)), moved.theta[moved.closed]])


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "mechanisms", 10_000, 1_000)
    sys.exit(not figures.run("R9", options, work)["passed"])
