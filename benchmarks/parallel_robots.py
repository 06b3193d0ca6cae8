"""How quick are poses of platforms on six legs, beside scipy, in the same run?

python benchmarks/parallel_robots.py [--batch 2000] [--platforms 200] [--json FILE]

Newton: one pose from a near guess beside `scipy.optimize.root` with exact derivatives, single and in a batch. All
poses: milliseconds for each platform of its own geometry, and for each row of lengths of one platform, with the shares
of platforms whose forty poses were all found and of planted poses that are among them.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
from functools import partial
from pathlib import Path
from time import perf_counter

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))
os.environ.setdefault("MAFSIL_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import numpy as np  # noqa: E402
import scipy.optimize  # noqa: E402

from benchmarks.comparison import Comparisons  # noqa: E402
from benchmarks.stopwatch import machine, race  # noqa: E402
from mafsil import parallel  # noqa: E402
from mafsil.arrays import Floats  # noqa: E402
from mafsil.geometry import pose, rotation  # noqa: E402


def by_scipy(robot: parallel.StewartPlatform, lengths: Floats, T: Floats) -> list[Floats]:
    """Poses by exponential coordinates from T, one after the other."""
    return [scipy.optimize.root(missed, np.zeros(6), (robot, s, T), jac=True, tol=1e-12).x for s in lengths]


def missed(V: Floats, robot: parallel.StewartPlatform, s: Floats, T: Floats) -> tuple[Floats, Floats]:
    """Errors of the lengths and their derivatives by V, in plain NumPy."""
    angle = float(np.linalg.norm(V[:3]))
    k = V[:3] / angle if angle > 0 else V[:3]
    K = np.array([[0, -k[2], k[1]], [k[2], 0, -k[0]], [-k[1], k[0], 0]])
    R = np.eye(3) + np.sin(angle) * K + (1 - np.cos(angle)) * K @ K
    W = angle * K
    c = (1 - np.cos(angle)) / angle**2 if angle > 1e-4 else 0.5
    e = (angle - np.sin(angle)) / angle**3 if angle > 1e-4 else 1 / 6
    r = (robot.platform @ T[:3, :3].T) @ R.T
    d = T[:3, 3] + V[3:] + r - robot.base
    length = np.linalg.norm(d, axis=1)
    u = d / length[:, None]
    return length - s, np.hstack([np.cross(r, u) @ (np.eye(3) + c * W + e * W @ W), u])


def planted(rng: np.random.Generator, count: int) -> tuple[Floats, Floats, Floats, Floats]:
    """Random platforms, poses and lengths."""
    a, b = rng.normal(size=(2, count, 6, 3))
    T = pose.from_rotation_translation(rotation.random(rng, count), rng.normal(size=(count, 3)))
    ends = T[:, None, :3, 3] + b @ np.swapaxes(T[:, :3, :3], 1, 2)
    return a, b, T, np.linalg.norm(ends - a, axis=-1)


def all_modes(count: int) -> dict[str, float]:
    """Times and shares of platforms with all their poses."""
    a, b, T, s = planted(np.random.default_rng(1), count)
    parallel.stewart_assembly_modes(a[:2], b[:2], s[:2])
    begin = perf_counter()
    found = parallel.stewart_assembly_modes(a, b, s)
    each = (perf_counter() - begin) / count
    there = np.nanmin(np.abs(found.T - T[:, None]).max(axis=(2, 3)), axis=1) < 1e-8
    robot = parallel.StewartPlatform(a[0], b[0])
    rows = robot.lengths(T)
    robot.forward_kinematics(rows[:2])
    begin = perf_counter()
    robot.forward_kinematics(rows)
    same = (perf_counter() - begin) / count
    return {
        "ms for each platform": 1e3 * each,
        "ms for each row of one platform": 1e3 * same,
        "share with all 40": float((found.finite == 40).mean()),
        "share with the planted pose": float(there.mean()),
        "largest error of a leg": found.error,
    }


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--batch", type=int, default=2000)
    parser.add_argument("--platforms", type=int, default=200)
    parser.add_argument("--json")
    given = parser.parse_args()
    print(machine("numpy", "scipy"))
    robot = parallel.StewartPlatform.on_circles(
        2.0, 1.0, np.radians([-15, 15, 105, 135, 225, 255]), np.radians([-45, 45, 75, 165, 195, 285])
    )
    home = pose.from_translation([0.0, 0.0, 1.5])
    V = 0.1 * np.random.default_rng(0).normal(size=(given.batch, 6))
    lengths = robot.lengths(home @ pose.exp(V))
    tasks = {
        "one": partial(robot.forward_near, lengths[0], home),
        "scipy": partial(by_scipy, robot, lengths[:50], home),
        "batch": partial(robot.forward_near, lengths, home),
    }
    times = race(tasks, repeats=7)
    found, theirs = Comparisons(), times["scipy"].least * 1e6 / 50
    one, batch = times["one"].least * 1e6, times["batch"].least * 1e6 / given.batch
    for case, ours in (("one", one), (str(given.batch), batch)):
        found.add("robot.forward_near(lengths, T_guess)", case, ours, "scipy.optimize.root", theirs)
        print(f"Newton, {case:6} scipy {theirs:8.1f} us   ours {ours:8.2f} us ({theirs / ours:6.1f}x)")
    modes = all_modes(given.platforms)
    for name, value in modes.items():
        print(f"{name:34} {value:.4g}")
    if given.json:
        Path(given.json).write_text(json.dumps({"comparisons": found.plain(), "modes": modes}, indent=1), "utf-8")


if __name__ == "__main__":
    main()
