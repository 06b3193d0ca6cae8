"""How quick is a surface of configurations, beside slices of it by curves, and how often is its topology right?

python benchmarks/configuration_surfaces.py [--pentagons 100] [--json FILE]

Time: `trace_surface` of five-bars and of two linkages on one ground, beside what there is without it: one joint locked
at values a step apart, and the curves of what is left, which give points as dense but no surface. Right: random
pentagons against a theorem (M. Farber, D. Schuetz 2007) that tells the number of pieces and the Euler characteristic;
what is stuck says so, and wrong ones are counted apart. The exit status says whether none is wrong.
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
from mafsil.mobility.surface import LONGEST  # noqa: E402
from tests.mobility.test_surfaces import beside, pentagon_numbers, pentagons, polygon  # noqa: E402


def slices(linkage: mo.Linkage, joint: str) -> int:
    """Points on the curves that are left while a joint is locked at values a step apart."""
    points = 0
    for value in np.arange(-np.pi, np.pi, LONGEST):
        modes = mo.assembly_modes(linkage, {joint: float(value)}, starts=4)
        if modes:
            rest = mo.linkages.lock_joints(mo.linkages.draw_at(linkage, modes.theta[0]), [joint])
            points += sum(len(curve.theta) for curve in mo.configuration_curves(rest, starts=4, step=LONGEST))
    return points


def topology(count: int) -> tuple[int, int, int]:
    """How many random pentagons are right, stuck and wrong."""
    right = stuck = 0
    for lengths in pentagons(count, 0, away=0.0):
        found = mo.configuration_surfaces(polygon(lengths), starts=16)
        if any(one.status is mo.surface.SurfaceStatus.STUCK for one in found):
            stuck += 1
        else:
            euler = [one.euler_characteristic for one in found]
            right += None not in euler and (len(found), sum(map(int, filter(None, euler)))) == pentagon_numbers(lengths)
    return right, stuck, count - right - stuck


def main() -> int:
    """Print the table; the exit status says whether no pentagon is wrong."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pentagons", type=int, default=100)
    parser.add_argument("--linkages", nargs="*", help="names of those raced; all without it")
    parser.add_argument("--json")
    given = parser.parse_args()
    print(machine("numpy", "scipy"))
    found = Comparisons()
    two = beside(mo.library.four_bar(), mo.library.slider_crank())
    cases = {
        "five-bar": (mo.library.five_bar(), "O"),
        "equal pentagon": (polygon([1.0] * 5), "J0"),
        "four-bar and slider-crank": (two, "A1"),
    }
    for name in given.linkages or cases:
        linkage, joint = cases[name]
        surface = mo.trace_surface(linkage)
        tasks = {"surface": partial(mo.trace_surface, linkage), "slices": partial(slices, linkage, joint)}
        times = race(tasks, repeats=3, seconds=0.0)
        ours, theirs = times["surface"].least, times["slices"].least
        found.add("mo.trace_surface(linkage)", name, 1e6 * ours, "curves of slices", 1e6 * theirs)
        print(f"{name:26} {len(surface.theta):6} points {ours:6.2f} s   slices {theirs:6.2f} s ({theirs / ours:4.1f}x)")
    right, stuck, wrong = topology(given.pentagons)
    print(f"random pentagons: {right} right, {stuck} stuck, {wrong} wrong")
    if given.json:
        Path(given.json).write_text(json.dumps(found.plain(), indent=1), "utf-8")
    return int(wrong > 0)


if __name__ == "__main__":
    sys.exit(main())
