"""How quick is the synthesis of four-bars for five poses, beside SciPy's solver from many starts, in the same run?

python benchmarks/linkage_synthesis.py [--lists 10000] [--peer 100] [--starts 20] [--json FILE]

Each list holds five poses that a random four-bar really takes: its crank and its rocker are dyads that must be found.
`five_pose_dyads(lists)` finds all dyads of all lists in one call, by an eigenvalue problem each; `synthesise_motion` of
one list besides pairs them, sorts them and looks for defects. The peer is `scipy.optimize.root` (hybr, analytic
derivatives) on the same four equations in four unknowns, from random starts: what it finds and how long it takes.
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
from scipy.optimize import root  # noqa: E402

from benchmarks.comparison import Comparisons  # noqa: E402
from benchmarks.stopwatch import machine, race  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.mobility import synthesis  # noqa: E402
from tests.mobility.planted_bars import planted  # noqa: E402

NEAR = 1e-6
"""Fixed pivots nearer than this count as found [m]: near double dyads lose half of the digits."""


def equations(x: Floats, poses: Floats) -> tuple[Floats, Floats]:
    """|P_k m - a|^2 - |P_0 m - a|^2 for k = 1..4, and its derivatives; x = (a, m): fixed pivot, moving one in {b}."""
    c, s = np.cos(poses[:, 2]), np.sin(poses[:, 2])
    dx = poses[:, 0] + c * x[2] - s * x[3] - x[0]
    dy = poses[:, 1] + s * x[2] + c * x[3] - x[1]
    squares = dx**2 + dy**2
    slopes = 2 * np.stack([-dx, -dy, dx * c + dy * s, dy * c - dx * s], axis=1)
    return squares[1:] - squares[0], slopes[1:] - slopes[0]


def by_scipy(lists: Floats, starts: int, seed: int = 0) -> list[Floats]:
    """Fixed pivots (k, 2) of the dyads found for each list, from so many starts."""
    rng, found = np.random.default_rng(seed), list[Floats]()
    for poses in lists:
        middle, size = poses[:, :2].mean(axis=0), float(np.ptp(poses[:, :2], axis=0).max()) + 1.0
        pivots: list[Floats] = []
        for _ in range(starts):
            x = np.concatenate([middle, np.zeros(2)]) + size * rng.normal(size=4)
            answer = root(equations, x, args=(poses,), jac=True, method="hybr", options={"xtol": 1e-12})
            if np.abs(answer.fun).max() < 1e-9 * size**2:
                pivots.append(answer.x[:2])
        found.append(np.reshape(pivots, (-1, 2)))
    return found


def share(found: list[Floats], wanted: Floats) -> float:
    """Share of the planted pivots (k, 2, 2) that are among the found ones."""
    hit = [
        bool(len(pivots)) and bool(np.linalg.norm(pivots - pivot, axis=1).min() < NEAR)
        for pivots, pair in zip(found, wanted, strict=True)
        for pivot in pair
    ]
    return float(np.mean(hit))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--lists", type=int, default=10_000)
    parser.add_argument("--peer", type=int, default=100, help="lists that SciPy is asked for")
    parser.add_argument("--starts", type=int, default=20)
    parser.add_argument("--json")
    given = parser.parse_args()
    print(machine("numpy", "scipy"))
    rng = np.random.default_rng(0)
    bars = [planted(rng, 5) for _ in range(given.lists)]
    lists = np.stack([bar.poses for bar in bars])
    wanted = np.array([[bar.A, bar.D] for bar in bars])
    ours = synthesis.five_pose_dyads(lists)
    pivots = [row[np.isfinite(row).all(axis=1)] for row in ours.fixed]
    some = lists[: given.peer]
    tasks = {
        "batch": partial(synthesis.five_pose_dyads, lists),
        "one": partial(synthesis.five_pose_dyads, lists[0]),
        "whole": partial(synthesis.synthesise_motion, lists[0]),
        "scipy": partial(by_scipy, some, given.starts),
    }
    times = race(tasks, repeats=3)
    theirs, few = times["scipy"].least * 1e6 / len(some), by_scipy(some, given.starts)
    found = Comparisons()
    for name, call, count in (
        ("batch", "synthesis.five_pose_dyads(lists)", len(lists)),
        ("one", "synthesis.five_pose_dyads(list)", 1),
        ("whole", "synthesis.synthesise_motion(list)", 1),
    ):
        each = times[name].least * 1e6 / count
        found.add(call, f"{count} of five poses", each, f"scipy.optimize.root, {given.starts} starts", theirs)
        print(f"{call:36} {each:9.1f} us a list, SciPy {theirs:10.1f} us ({theirs / each:6.1f}x)")
    print(f"planted pivots found: ours {share(pivots, wanted):.4%} of {2 * len(lists)}, ", end="")
    print(f"SciPy {share(few, wanted[: given.peer]):.1%} of {2 * len(some)}")
    if given.json:
        Path(given.json).write_text(json.dumps(found.plain(), indent=1), "utf-8")


if __name__ == "__main__":
    main()
