"""Forward dynamics of closed chains beside Pinocchio's constraintDynamics: same chains, same states, same run.

    python benchmarks/closed_chains.py

Pinocchio has no hinge as a loop: two points of its axis are held, six rows of which five are independent. Both are
called from Python, Pinocchio a state at a time, which is all that it has. Least of several repeats, of a call or row.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path

import numpy as np

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from mafsil import parallel
from mafsil.model import JointKind
from tests.parallel.closed_chains import Twin, random_chain

REPEATS, ROWS, FEW = 20, 2048, 300


def shortest(action) -> float:
    times = []
    for _ in range(REPEATS):
        begin = time.perf_counter()
        action()
        times.append(time.perf_counter() - begin)
    return min(times)


def each(call, q, states) -> None:
    """One call after another; no answer outlives its call, which would measure the memory of all instead."""
    for qd, tau in states:
        call(q, qd, tau)


def main() -> None:
    for kind, n in ((JointKind.FIXED, 9), (JointKind.REVOLUTE, 9), (JointKind.FIXED, 14)):
        rng = np.random.default_rng(0)
        mechanism, q = random_chain(rng, kind, n)
        chain, twin = parallel.ClosedChain(mechanism), Twin(mechanism)
        qd, tau = chain.rates(q, rng.normal(size=(ROWS, n))), rng.normal(size=(ROWS, n))
        places = np.broadcast_to(q, (ROWS, n)).copy()
        chain.forward_dynamics(q, qd[0], tau[0])
        states = list(zip(qd[:FEW], tau[:FEW], strict=True))
        peer = shortest(lambda: each(twin.accelerations, q, states)) / FEW  # noqa: B023
        single = shortest(lambda: each(chain.forward_dynamics, q, states)) / FEW  # noqa: B023
        batch = shortest(lambda: chain.forward_dynamics(places, qd, tau)) / ROWS  # noqa: B023
        inverse = shortest(lambda: chain.inverse_dynamics(places, qd, tau)) / ROWS  # noqa: B023
        print(
            f"{kind.value:9} {n:2} joints  Pinocchio {1e6 * peer:6.2f} us  single {1e6 * single:6.2f} us "
            f"({peer / single:4.1f} times)  batch {1e6 * batch:6.2f} us ({peer / batch:5.1f} times)  "
            f"inverse, batch {1e6 * inverse:6.2f} us"
        )


if __name__ == "__main__":
    main()
