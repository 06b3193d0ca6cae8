"""How fast is the shortest time along a path beside TOPP-RA, and who keeps the limits, in the same run?

pip install toppra; MAFSIL_THREADS=1 python benchmarks/time_optimal.py [--intervals 100] [--batch 200] [--json FILE]

Random natural splines of 7 joints through 6 points with limits of velocity and acceleration; both sides get the same
polynomials and the same count of intervals. "timing": path velocities and duration, beside TOPP-RA's
compute_parameterization; "motion": a trajectory besides, beside its compute_trajectory. Excess: the largest at 4,000
times, as share of a limit. TOPP-RA parametrises by constant acceleration between places, its most faithful way.
"""

# pyright: reportMissingImports=false, reportUnknownVariableType=false, reportUnknownMemberType=false
# pyright: reportUnknownArgumentType=false, reportCallIssue=false
from __future__ import annotations

import argparse
import json
import os
import sys
from pathlib import Path
from typing import Any

os.environ.setdefault("MAFSIL_THREADS", "1")
sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

import numpy as np
import toppra
from scipy.interpolate import CubicSpline
from toppra.algorithm import TOPPRA
from toppra.constraint import JointAccelerationConstraint, JointVelocityConstraint

from benchmarks.stopwatch import machine, race
from mafsil.trajectory import JointPath, MotionLimits, time_optimal

N, POINTS, TIMES = 7, 6, 4_000


def toppra_of(path: JointPath, points: np.ndarray, v: np.ndarray, a: np.ndarray, intervals: int) -> Any:
    """The peer's problem."""
    knots = path.breaks()
    spline = toppra.SplineInterpolator(knots, points, bc_type="natural")
    constraints = [JointVelocityConstraint(np.stack([-v, v], 1)), JointAccelerationConstraint(np.stack([-a, a], 1))]
    grid = np.linspace(0.0, knots[-1], intervals + 1)
    return TOPPRA(constraints, spline, gridpoints=grid, parametrizer="ParametrizeConstAccel")


def excess(velocity: np.ndarray, acceleration: np.ndarray, v: np.ndarray, a: np.ndarray) -> float:
    """The largest excess, as share of a limit."""
    return max(float((np.abs(velocity) / v).max()), float((np.abs(acceleration) / a).max())) - 1.0


def compared(batch: int, intervals: int) -> dict[str, float]:
    """Times [s] a path, ratios, excesses, and durations beside a fine grid."""
    rng = np.random.default_rng(0)
    points = rng.uniform(-2.0, 2.0, (batch, POINTS, N))
    v, a = rng.uniform(1.0, 3.0, N), rng.uniform(2.0, 10.0, N)
    limits = MotionLimits.of(N, velocity=v, acceleration=a)
    paths = [JointPath.through(each) for each in points]
    few = min(batch, 20)
    for path, each in zip(paths[:few], points, strict=False):
        s = np.linspace(0.0, path.end, 50)
        np.testing.assert_allclose(CubicSpline(path.breaks(), each, bc_type="natural")(s), path.at(s).u, atol=1e-9)
    ours = time_optimal(paths, limits, intervals=intervals)
    theirs = [
        toppra_of(path, each, v, a, intervals).compute_trajectory()
        for path, each in zip(paths[:few], points, strict=False)
    ]
    fine = time_optimal(paths[:few], limits, intervals=10_000).durations
    usual = time_optimal(paths[:few], limits).durations
    broken = {"mafsil": -1.0, "toppra": -1.0}
    for answer, peer in zip(ours.answers[:few], theirs, strict=False):
        assert answer.trajectory is not None
        motion = answer.trajectory.at(np.linspace(0.0, answer.duration, TIMES))
        broken["mafsil"] = max(broken["mafsil"], excess(motion.v, motion.a, v, a))
        if peer is not None:
            t = np.linspace(0.0, peer.duration, TIMES)
            broken["toppra"] = max(broken["toppra"], excess(peer(t, 1), peer(t, 2), v, a))
    taken = race(
        {
            "batch timing": lambda: time_optimal(paths, limits, intervals=intervals).durations,
            "batch motion": lambda: [each.trajectory for each in time_optimal(paths, limits, intervals=intervals)],
            "single timing": lambda: time_optimal(paths[0], limits, intervals=intervals).duration,
            "single motion": lambda: time_optimal(paths[0], limits, intervals=intervals).trajectory,
            "toppra timing": lambda: toppra_of(paths[0], points[0], v, a, intervals).compute_parameterization(0, 0),
            "toppra motion": lambda: toppra_of(paths[0], points[0], v, a, intervals).compute_trajectory(),
        },
        repeats=15,
    )
    us = {name: time.least * 1e6 / (batch if "batch" in name else 1) for name, time in taken.items()}
    ratios = {
        f"{how} {what} ratio": us[f"toppra {what}"] / us[f"{how} {what}"]
        for how in ("batch", "single")
        for what in ("timing", "motion")
    }
    return {
        **{f"{name} us a path": value for name, value in us.items()},
        **ratios,
        "excess": broken["mafsil"],
        "excess_toppra": broken["toppra"],
        "longer_than_fine_grid": float((ours.durations[:few] / fine).max()) - 1.0,
        "default_grid_longer_than_fine": float((usual / fine).max()) - 1.0,
    }


def long_path(count: int) -> dict[str, float]:
    """A path through many points, from the points to its duration, and the peer on a grid of as many intervals [s]."""
    points = np.cumsum(np.random.default_rng(1).uniform(-0.2, 0.2, (count, N)), axis=0)
    v, a = np.full(N, 1.5), np.full(N, 3.0)
    limits = MotionLimits.of(N, velocity=v, acceleration=a)
    path = JointPath.through(points)
    taken = race(
        {
            "path": lambda: JointPath.through(points),
            "timing": lambda: time_optimal(path, limits).duration,
            "toppra": lambda: toppra_of(path, points, v, a, 2 * count).compute_parameterization(0, 0),
        },
        repeats=3,
    )
    ms = {f"{count} points, {name} ms": 1e3 * time.least for name, time in taken.items()}
    return {**ms, f"{count} points ratio": taken["toppra"].least / taken["timing"].least}


def main() -> None:
    """Print the table; write it on request."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--intervals", type=int, default=100)
    parser.add_argument("--batch", type=int, default=200)
    parser.add_argument("--long", type=int, default=10_000, help="points of a long path")
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    toppra.setup_logging("ERROR")
    found = compared(options.batch, options.intervals) | long_path(options.long)
    for name, value in found.items():
        print(f"{name:32s} {value:12.4g}")
    if options.json:
        options.json.write_text(json.dumps({"machine": machine("mafsil"), **found}, indent=1))


if __name__ == "__main__":
    main()
