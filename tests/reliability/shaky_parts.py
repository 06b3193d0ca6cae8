"""Finite mobility of random linkages with shaky parts, of any size, planted in them.

python -m tests.reliability.shaky_parts --linkages 10000 --resume DIR

A linkage of one or two over-constrained mechanisms whose mobility a theorem tells, and, hung on any of its bodies, one
or two parts that are shaky of order 2, 4 or 8 and add nothing, from a thousandth to a thousand times as large.
"""

from __future__ import annotations

import sys
from collections import Counter

import numpy as np

from mafsil import mobility as mo
from tests.mobility.known_dimensions import SHAKY
from tests.reliability import figures
from tests.reliability.over_constrained import BUILDERS, composed, displaced, somewhere


def work(seed: int, count: int) -> dict[str, int]:
    """Verdicts on `count` random linkages."""
    total: Counter[str] = Counter(linkages=count)
    for k in range(count):
        linkage, expected = planted(np.random.default_rng([31, seed, k]))
        found = mo.finite_mobility(linkage)
        doubt = found.status is mo.finite.FiniteStatus.IN_DOUBT and found.mobility <= expected <= found.at_most
        total["in_doubt"] += doubt
        total["bad_mobility"] += found.mobility != expected and not doubt
    return {"bad_mobility": 0, "in_doubt": 0, **total}


def planted(rng: np.random.Generator) -> tuple[mo.Linkage, int]:
    """A random linkage with shaky parts, and its mobility."""
    base, mobility = composed(rng, rng.choice(sorted(BUILDERS), int(rng.integers(1, 3))).tolist())
    joints = list(base.joints)
    for k, name in enumerate(rng.choice(sorted(SHAKY), int(rng.integers(1, 3)))):
        part, none = SHAKY[str(name)](float(10 ** rng.uniform(-3, 3)))
        body = str(rng.choice(base.bodies))
        joints += displaced(part, somewhere(rng), f" shaky {k}", body)
        mobility += none
    return mo.Linkage.of(joints, ground="ground"), mobility


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "linkages", 10_000, 100)
    sys.exit(not figures.run("R9c", options, work)["passed"])
