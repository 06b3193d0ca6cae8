"""How many closure verdicts per second, beside scipy's linprog one grasp at a time, in the same run?

python benchmarks/grasp_closure.py [--grasps 10000] [--rival 200] [--json FILE]

Random grasps of an ellipsoid, k contacts with inscribed friction cones of c edges; the rival solves the linear program
of positive spanning (HiGHS) for a part of them. Verdicts are compared; the peak of memory beyond input is measured.
"""

from __future__ import annotations

import argparse
import json
import sys
import tracemalloc
from pathlib import Path
from time import perf_counter

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

import numpy as np  # noqa: E402
from scipy.optimize import linprog  # noqa: E402

from benchmarks.stopwatch import machine  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.grasp.batch import closures  # noqa: E402

SIZES = ((3, 8), (4, 8), (5, 8), (5, 16), (8, 8))
TARGET = 100.0


def grasps(count: int, contacts: int, edges: int, mu: float, rng: np.random.Generator) -> Floats:
    """(count, 6, contacts edges) wrench sets of random contacts on an ellipsoid with axes 1, 0.7, 0.5."""
    axes = np.array([1.0, 0.7, 0.5])
    u = rng.normal(size=(count, contacts, 3))
    u /= np.linalg.norm(u, axis=-1, keepdims=True)
    points, n = u * axes, -u / axes
    n /= np.linalg.norm(n, axis=-1, keepdims=True)
    a = np.cross(n, rng.normal(size=n.shape))
    a /= np.linalg.norm(a, axis=-1, keepdims=True)
    t = 2 * np.pi * np.arange(edges) / edges
    e = n[..., None, :] + mu * (
        np.cos(t)[:, None] * a[..., None, :] + np.sin(t)[:, None] * np.cross(n, a)[..., None, :]
    )
    wrench = np.concatenate([np.cross(points[..., None, :], e), e], axis=-1)
    return np.swapaxes(wrench.reshape(count, -1, 6), 1, 2).copy()


def one(A: Floats) -> bool:
    """Positive spanning by one linear program."""
    m, n = A.shape
    found = linprog(np.zeros(n), A_eq=A, b_eq=np.zeros(m), bounds=(1.0, None), method="highs")
    return found.status == 0 and np.linalg.matrix_rank(A) == m


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--grasps", type=int, default=10_000)
    parser.add_argument("--rival", type=int, default=200)
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    rng = np.random.default_rng(0)
    rows = []
    print(f"{'contacts x edges':>16}  {'batch [us]':>10}  {'linprog [us]':>12}  {'ratio':>7}  {'MiB':>8}  yes  differ")
    for contacts, edges in SIZES:
        W = grasps(given.grasps, contacts, edges, 0.5, rng)
        mine = min(_seconds(closures, W) for _ in range(2)) / len(W)
        tracemalloc.start()
        found = closures(W)
        peak = tracemalloc.get_traced_memory()[1] / 2**20
        tracemalloc.stop()
        some = W[: given.rival]
        start = perf_counter()
        rival = np.array([one(A) for A in some])
        theirs = (perf_counter() - start) / len(some)
        differ = int((rival != found.force_closure[: len(some)]).sum())
        row = {
            "contacts": contacts, "edges": edges, "batch_us": mine * 1e6, "linprog_us": theirs * 1e6,
            "ratio": theirs / mine, "peak_mib": peak, "closed": float(found.force_closure.mean()), "differ": differ,
        }  # fmt: skip
        rows.append(row)
        print(
            f"{contacts:>12} x{edges:>2}  {mine * 1e6:10.2f}  {theirs * 1e6:12.0f}  {theirs / mine:7.0f}  {peak:8.1f}"
            f"  {row['closed']:6.2f}  {differ}"
        )
    print(f"target ratio {TARGET:g}; machine {machine('numpy', 'scipy')}")
    if given.json:
        given.json.write_text(json.dumps({"rows": rows, "machine": machine("numpy", "scipy")}, indent=1))


def _seconds(task, given) -> float:
    start = perf_counter()
    task(given)
    return perf_counter() - start


if __name__ == "__main__":
    main()
