"""How fast are curves planned and sampled beside SciPy (and roboticstoolbox where it is installed), in the same run?

python benchmarks/trajectory_curves.py [--json FILE]

Seven joints through 10 points in 10 s; position, velocity and acceleration at 1 kHz, at one time, and per tick of a
generator. Results are compared before anything is timed.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

os.environ.setdefault("MAFSIL_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np
from scipy.interpolate import CubicSpline, make_interp_spline

from benchmarks.stopwatch import BRIEF, machine, race
from mafsil import trajectory as tr

Rivals = dict[str, Callable[[], Any]]


def operations() -> dict[str, Rivals]:
    """Operation -> what each rival does; `mafsil` first."""
    rng = np.random.default_rng(0)
    points, h = rng.normal(size=(11, 7)), np.ones(10)
    knots = np.arange(11.0)
    t, one = np.linspace(0.0, 10.0, 10_001)[:-1], 3.21
    ours, theirs = tr.cubic_through(points, h), CubicSpline(knots, points, bc_type="clamped")
    first, second = theirs.derivative(), theirs.derivative(2)
    rest = [(1, np.zeros(7)), (2, np.zeros(7))]
    smooth = tr.minimum_jerk_through(points, h)
    generator = tr.TrajectoryGenerator(ours, 1000.0)

    def tick() -> tuple[np.ndarray, ...]:
        generator.index = 3210
        return generator.tick()

    table: dict[str, Rivals] = {
        "plan a clamped cubic spline": {
            "mafsil": lambda: tr.cubic_through(points, h).coefficients[:, 1],
            "scipy": lambda: CubicSpline(knots, points, bc_type="clamped").c[2],
        },
        "plan a spline of degree 5": {
            "mafsil": lambda: tr.minimum_jerk_through(points, h).control,
            "scipy": lambda: make_interp_spline(knots, points, 5, t=smooth.knots, bc_type=(rest, rest)).c,
        },
        "sample 10 s at 1 kHz": {
            "mafsil": lambda: ours.at(t),
            "scipy": lambda: (theirs(t), first(t), second(t)),
        },
        "sample one time": {
            "mafsil": lambda: ours.at(one),
            "scipy": lambda: (theirs(one), first(one), second(one)),
        },
        "one tick of a generator": {
            "mafsil": tick,
            "scipy": lambda: (theirs(one), first(one), second(one)),
        },
    }
    try:
        import roboticstoolbox as rtb
    except ImportError:
        return table
    table["quintic of seven joints, 1000 times"] = {
        "mafsil": lambda: tr.quintic(points[0], points[1], 1.0).at(np.linspace(0, 1, 1000)).u,
        "roboticstoolbox": lambda: rtb.jtraj(points[0], points[1], 1000).q,
    }
    return table


def main() -> None:
    """Print the table, and write it where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    found: dict[str, Any] = {"machine": machine("numpy", "scipy")}
    print(f"{'':36}microseconds, and how many times ours")
    for name, rivals in operations().items():
        ours = np.asarray(rivals["mafsil"]())
        for rival, task in rivals.items():
            deviation = np.abs(np.asarray(task()) - ours).max()
            if deviation > 1e-8:
                raise SystemExit(f"{name}: {rival} differs by {deviation}")
        times = {k: 1e6 * timing.least for k, timing in race(rivals, **BRIEF).items()}
        print(f"{name:36}" + "  ".join(f"{k} {x:9.2f} ({x / times['mafsil']:5.1f})" for k, x in times.items()))
        found[name] = times
    if options.json:
        options.json.write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
