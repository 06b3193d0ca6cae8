"""How quick is mobility by rank, beside Pinocchio's constraint Jacobian with NumPy's SVD, in the same run?

python benchmarks/mobility_rank.py [--batch 2000] [--random 2000] [--json FILE]

Single: `mo.mobilities(linkage, theta)` of one configuration beside `computeJointJacobians`, `getConstraintJacobian` of
each loop and the rank. Batch: many configurations in one call beside a loop over them. Random mechanisms with loops:
the mobility must be the same in both. Last, the whole of `mf.mobility` for mechanisms of many bodies.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from functools import partial
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
os.environ.setdefault("MAFSIL_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402

from benchmarks.comparison import Comparisons  # noqa: E402
from benchmarks.stopwatch import machine, race  # noqa: E402
from mafsil import mobility as mo  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.mobility import Linkage  # noqa: E402
from tests.mobility.mechanisms import random_linkage, scissors  # noqa: E402
from tests.mobility.pinocchio_rank import PinocchioLinkage  # noqa: E402
from tests.reliability.local_dimensions import miura  # noqa: E402

MANY = {
    "scissors 10": scissors(10), "scissors 30": scissors(30),
    "Miura 3 3": Linkage.of(miura(3, 3)[0]), "Miura 6 6": Linkage.of(miura(6, 6)[0]),
}  # fmt: skip
NAMES = ("four_bar", "watt", "bennett", "three_rpr", "delta", "six_ups", "six_sps")


def each_alone(peer: PinocchioLinkage, rows: Floats) -> list[int]:
    """Mobility by Pinocchio, one configuration after the other."""
    return [peer.mobility(q) for q in rows]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--batch", type=int, default=2000)
    parser.add_argument("--random", type=int, default=2000)
    parser.add_argument("--json")
    given = parser.parse_args()
    print(machine("numpy", "pin"))
    found = Comparisons()
    for name in NAMES:
        linkage = mo.library.linkage(name)
        peer, n = PinocchioLinkage(linkage), linkage.coordinates
        theta = np.random.default_rng(0).normal(size=(given.batch, n)) * 1e-3
        rows = theta[:50]
        tasks = {
            "one": partial(mo.batch_mobility, linkage, theta[0]),
            "pinocchio": partial(each_alone, peer, rows),
            "batch": partial(mo.batch_mobility, linkage, theta),
        }
        times = race(tasks, repeats=7)
        theirs = times["pinocchio"].least * 1e6 / len(rows)
        one, batch = times["one"].least * 1e6, times["batch"].least * 1e6 / given.batch
        found.add("mo.mobilities(linkage, theta)", f"{name}, one", one, "Pinocchio", theirs)
        found.add("mo.mobilities(linkage, theta)", f"{name}, {given.batch}", batch, "Pinocchio", theirs)
        print(f"{name:12} F={n:3} Pinocchio {theirs:8.1f} us   one {one:8.1f} us ({theirs / one:5.2f}x)   ", end="")
        print(f"batch {batch:8.2f} us ({theirs / batch:5.1f}x)")
    different = 0
    for seed in range(given.random):
        rng = np.random.default_rng(seed)
        linkage = random_linkage(rng, int(rng.integers(0, 4)), int(rng.integers(3, 9)))
        different += mo.instantaneous_mobility(linkage).mobility != PinocchioLinkage(linkage).mobility()
    print(f"random mechanisms: {different} of {given.random} differ from Pinocchio")
    for name, many in MANY.items():
        once = race({name: partial(mo.mobility, many)}, repeats=5)[name].least
        print(f"{name:12} F={many.coordinates:3} mf.mobility {once * 1e3:8.1f} ms")
    if given.json:
        Path(given.json).write_text(json.dumps(found.plain(), indent=1), "utf-8")


if __name__ == "__main__":
    main()
