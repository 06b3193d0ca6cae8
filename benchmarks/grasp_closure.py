"""How many closure verdicts per second, beside scipy's linprog and Klampt one grasp at a time, in the same run?

python benchmarks/grasp_closure.py [--grasps 10000] [--rival 200] [--klampt PYTHON] [--json FILE]

Random grasps of an ellipsoid with k contacts, one thread. First what a user calls:

- `mf.Grasp(contacts).closure()`, one grasp with round cones, beside Klampt's `force_closure` of its own contact points,
  whose cones are coarser; contacts exist before the clock starts on both sides, a column tells what making ours adds;
- `mf.grasp.contact_closures(points, normals, mu)`, many grasps at once;
- `mf.Grasp(contacts).closure(facets).margin`, verdict and margin, beside all facets of Qhull on the same columns.

Then verdicts on ready wrench sets with c edges a cone, beside the linear program of positive spanning (HiGHS) for a
part of them; verdicts are compared, the peak of memory beyond input measured. Klampt needs an old numpy: name an
interpreter that has it.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tracemalloc
from pathlib import Path
from time import perf_counter

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
os.environ.setdefault("MAFSIL_THREADS", "1")

import numpy as np  # noqa: E402
from scipy.optimize import linprog  # noqa: E402

from benchmarks.comparison import Comparisons  # noqa: E402
from benchmarks.stopwatch import machine, race  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.grasp import Contact, Grasp, closure, contact_closures  # noqa: E402
from mafsil.grasp.contact_batch import wrench_closures  # noqa: E402
from mafsil.grasp.enclosure import ConeWrenches  # noqa: E402
from mafsil.grasp.quality import quality_by_facets, quality_of_discs, quality_of_wrenches  # noqa: E402

SIZES = ((3, 8), (4, 8), (5, 8), (5, 16), (8, 8))
TARGET = 100.0
SINGLE_TARGET, BATCH_TARGET = 5.0, 50.0
"""Ratios to Klampt's call, from contacts."""
FRICTION = 0.5
RING = 64
"""Grasps that single calls take in turn."""


def contacts_on_ellipsoid(count: int, contacts: int, rng: np.random.Generator) -> tuple[Floats, Floats]:
    """Points and inward normals (count, contacts, 3) on an ellipsoid with axes 1, 0.7, 0.5."""
    axes = np.array([1.0, 0.7, 0.5])
    u = rng.normal(size=(count, contacts, 3))
    u /= np.linalg.norm(u, axis=-1, keepdims=True)
    n = -u / axes
    return u * axes, n / np.linalg.norm(n, axis=-1, keepdims=True)


def klampt_seconds(python: str, contacts: int, count: int) -> float:
    """Seconds for one `force_closure` of Klampt, in its own interpreter."""
    points, normals = contacts_on_ellipsoid(count, contacts, np.random.default_rng(0))
    script = (
        "import json, sys, time\n"
        "from klampt.model.contact import ContactPoint, force_closure\n"
        "grasps = [[ContactPoint(x, n, 0.5) for x, n in zip(*g)] for g in zip(*json.load(sys.stdin))]\n"
        "best = 1e9\n"
        "for _ in range(3):\n"
        "    start = time.perf_counter()\n"
        "    for g in grasps: force_closure(g)\n"
        "    best = min(best, time.perf_counter() - start)\n"
        "print('seconds', best / len(grasps))\n"
    )
    given = json.dumps([points.tolist(), normals.tolist()])
    done = subprocess.run([python, "-c", script], input=given, capture_output=True, text=True, check=True)
    return float(done.stdout.split("seconds")[-1])


def public_calls(count: int, klampt: str | None, rng: np.random.Generator) -> list[dict[str, float]]:
    """What a user calls, from contacts to the verdict and to the margin."""
    print(
        f"{'contacts':>8}  {'Grasp.closure [us]':>18}  {'new contacts':>12}  {'batch [us]':>10}"
        f"  {'with margin [us]':>16}  {'Klampt [us]':>11}  {'x single':>8}"
        f"  {'x batch':>7}  {'Qhull [us]':>10}  {'x margin':>8}  yes  differ"
    )
    rows = []
    for contacts, facets in SIZES:
        points, normals = contacts_on_ellipsoid(count, contacts, rng)
        row = public_row(points, normals, facets)
        row["klampt"] = 1e6 * klampt_seconds(klampt, contacts, 100) if klampt else float("nan")
        ratio = {name: row["klampt"] / row[name] for name in ("single", "batch")}
        ratio["margin"] = row["qhull"] / row["margin"]
        rows.append(row | {f"x_{name}": x for name, x in ratio.items()})
        print(
            f"{contacts:>5} x{facets:>2}  {row['single']:18.1f}  {row['anew']:12.1f}  {row['batch']:10.2f}"
            f"  {row['margin']:16.1f}  {row['klampt']:11.0f}  {ratio['single']:8.1f}  {ratio['batch']:7.0f}"
            f"  {row['qhull']:10.0f}  {ratio['margin']:8.0f}  {row['yes']:.2f}  {row['differ']:>6.0f}",
            flush=True,
        )
    print(
        f"goals from contacts: {SINGLE_TARGET:g} times Klampt single, {BATCH_TARGET:g} in batch, {TARGET:g} times Qhull"
    )
    return rows


def compared(rows: list[dict[str, float]]) -> Comparisons:
    """The table as lines of the page; without Klampt only the margins."""
    found = Comparisons()
    for row in rows:
        case = f"{row['contacts']:.0f} contacts"
        if np.isfinite(row["klampt"]):
            found.add("mf.Grasp(contacts).closure()", case, row["single"], "Klampt", row["klampt"], SINGLE_TARGET)
            found.add("mf.grasp.contact_closures", case, row["batch"], "Klampt", row["klampt"], BATCH_TARGET)
        call = f"mf.Grasp(contacts).closure({row['facets']:.0f}).margin"
        found.add(call, case, row["margin"], "Qhull", row["qhull"], TARGET)
    return found


def public_row(points: Floats, normals: Floats, facets: int) -> dict[str, float]:
    """Microseconds of each call on one size of grasp, and how often single and batch verdicts differ."""
    few = list(zip(points[:RING], normals[:RING], strict=True))
    held = [made(p, n) for p, n in few]
    closed = [contacts for contacts in held if Grasp(contacts).closure(facets)]
    batch = contact_closures(points, normals, FRICTION)
    first, second, third, fourth = (_ring(of) for of in (held, few, closed, closed))
    tasks = {
        "single": lambda: bool(Grasp(first()).closure()),
        "anew": lambda: bool(Grasp(made(*second())).closure()),
        "batch": lambda: contact_closures(points, normals, FRICTION),
        "margin": lambda: Grasp(third()).closure(facets).margin,
        "qhull": lambda: quality_by_facets(Grasp(fourth()).matrix(facets)).epsilon,
    }
    row = {name: 1e6 * timing.least for name, timing in race(tasks, repeats=7).items()}
    row["batch"] /= len(points)
    differ = sum(bool(Grasp(g).closure()) != yes for g, yes in zip(held, batch.force_closure, strict=False))
    return row | {
        "yes": float(batch.force_closure.mean()),
        "differ": differ,
        "contacts": len(held[0]),
        "facets": facets,
    }


def made(points: Floats, normals: Floats) -> list[Contact]:
    """Contacts with friction."""
    return [Contact(p, n, FRICTION) for p, n in zip(points, normals, strict=True)]


def _ring(of):
    """One after the other, again and again."""
    at = [0]

    def following():
        at[0] = (at[0] + 1) % len(of)
        return of[at[0]]

    return following


def balls(rng: np.random.Generator) -> list[dict[str, float]]:
    """Quality Q1: our growth beside all facets of Qhull on the same columns, and with the cones as they are."""
    rows = []
    print(f"{'contacts x edges':>16}  {'Q1 [us]':>9}  {'qhull [us]':>10}  {'ratio':>7}  {'round cones [us]':>16}  gap")
    for contacts, edges in SIZES:
        W = [A for A in grasps(60, contacts, edges, 0.5, rng) if closure(A, margins=False)][:12]
        points, normals = contacts_on_ellipsoid(60, contacts, rng)
        holds = [
            Grasp([Contact(p, n, 0.5) for p, n in zip(*g, strict=True)]) for g in zip(points, normals, strict=True)
        ]
        sets = [ConeWrenches.of(g.contacts, np.eye(6)).discs for g in holds if g.closure(margins=False)][:12]
        mine = _median(quality_of_wrenches, W)
        theirs = _median(quality_by_facets, W, 1)
        exact = _median(quality_of_discs, sets)
        gap = max(abs(quality_of_wrenches(A).epsilon / quality_by_facets(A).epsilon - 1) for A in W)
        rows.append({"contacts": contacts, "edges": edges, "q1_us": mine, "qhull_us": theirs, "round_us": exact})
        print(
            f"{contacts:>12} x{edges:>2}  {mine:9.0f}  {theirs:10.0f}  {theirs / mine:7.0f}  {exact:16.0f}  {gap:.1e}"
        )
    return rows


def _median(task, given, repeats: int = 3) -> float:
    """Median over inputs of the best time [us]."""
    return 1e6 * float(np.median([min(_seconds(task, one) for _ in range(repeats)) for one in given]))


def grasps(count: int, contacts: int, edges: int, mu: float, rng: np.random.Generator) -> Floats:
    """(count, 6, contacts edges) wrench sets of random contacts on an ellipsoid with axes 1, 0.7, 0.5."""
    points, n = contacts_on_ellipsoid(count, contacts, rng)
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
    parser.add_argument("--klampt", help="interpreter with Klampt")
    parser.add_argument("--json", type=Path)
    given = parser.parse_args()
    rng = np.random.default_rng(0)
    called = public_calls(given.grasps, given.klampt, rng)
    rows = []
    print(
        f"{'contacts x edges':>16}  {'batch [us]':>10}  {'linprog [us]':>12}  {'ratio':>7}  {'MiB':>8}  yes  differ"
        "  single [us]  Klampt [us]"
    )
    for contacts, edges in SIZES:
        W = grasps(given.grasps, contacts, edges, 0.5, rng)
        wrench_closures(W[:10])
        mine = min(_seconds(wrench_closures, W) for _ in range(3)) / len(W)
        single = _median(lambda A: closure(A, margins=False), W[:100])
        klampt = 1e6 * klampt_seconds(given.klampt, contacts, 100) if given.klampt else float("nan")
        tracemalloc.start()
        found = wrench_closures(W)
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
            "single_us": single, "klampt_us": klampt,
        }  # fmt: skip
        rows.append(row)
        print(
            f"{contacts:>12} x{edges:>2}  {mine * 1e6:10.2f}  {theirs * 1e6:12.0f}  {theirs / mine:7.0f}  {peak:8.1f}"
            f"  {row['closed']:6.2f}  {differ:>6}"
            f"  {single:>11.0f}  {klampt:>11.0f}"
        )
    rated = balls(rng)
    print(f"target ratio {TARGET:g}; machine {machine('numpy', 'scipy')}")
    if given.json:
        given.json.write_text(
            json.dumps(
                {
                    "public": called,
                    "comparisons": compared(called).plain(),
                    "rows": rows,
                    "balls": rated,
                    "machine": machine("numpy", "scipy"),
                },
                indent=1,
                default=float,
            )
        )


def _seconds(task, given) -> float:
    start = perf_counter()
    task(given)
    return perf_counter() - start


if __name__ == "__main__":
    main()
