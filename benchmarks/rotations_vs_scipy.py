"""How fast are rotations and poses beside SciPy, Pinocchio and plain NumPy in the manner of jaxlie, in the same run?

python benchmarks/rotations_vs_scipy.py [--rows 4096] [--json FILE]

Per operation: nanoseconds per row of a batch on one thread, and of one call. The rivals get their data in the form they
keep it in (SciPy's Rotation objects are built outside the clock); results are compared before anything is timed.
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
import pinocchio as pin
from scipy.spatial.transform import RigidTransform, Rotation, Slerp

from benchmarks.stopwatch import machine, race
from mafsil.geometry import pose, rotation

Rivals = dict[str, Callable[[], Any]]
TOLERANCE = 1e-10


def numpy_exp(r: np.ndarray) -> np.ndarray:
    """Rodrigues' formula in NumPy, batched, with the usual small-angle guard."""
    theta2 = np.sum(r * r, axis=-1)
    small = theta2 < 1e-10
    safe = np.where(small, 1.0, theta2)
    theta = np.sqrt(safe)
    a = np.where(small, 1 - theta2 / 6, np.sin(theta) / theta)[..., None, None]
    b = np.where(small, 0.5 - theta2 / 24, (1 - np.cos(theta)) / safe)[..., None, None]
    W = np.zeros((*r.shape, 3))
    W[..., 0, 1], W[..., 0, 2], W[..., 1, 2] = -r[..., 2], r[..., 1], -r[..., 0]
    W[..., 1, 0], W[..., 2, 0], W[..., 2, 1] = r[..., 2], -r[..., 1], r[..., 0]
    return np.eye(3) + a * W + b * (W @ W)


def scipy_slerp(A: Rotation, B: Rotation, t: np.ndarray) -> np.ndarray:
    """What SciPy offers for pairs of rotations: its Slerp takes one list of key rotations."""
    return (A * Rotation.from_rotvec(np.asarray(t)[..., None] * (A.inv() * B).as_rotvec())).as_matrix()


def operations(rows: int) -> dict[str, Rivals]:
    """Operation -> what each rival does; `mafsil` first. `rows` 0 is one call."""
    rng = np.random.default_rng(0)
    shape = (rows,) if rows else ()
    r, s = rng.uniform(-1.5, 1.5, (2, *shape, 3))
    p, v = rng.standard_normal((2, *shape, 3))
    t = rng.uniform(0, 1, shape)
    A, B = Rotation.from_rotvec(r), Rotation.from_rotvec(s)
    R, S, q = A.as_matrix(), B.as_matrix(), A.as_quat(scalar_first=True)
    T, U = pose.from_rotation_translation(R, p), pose.from_rotation_translation(S, v)
    V = pose.log(T)
    X = RigidTransform.from_matrix(T)
    rpy = A.as_euler("xyz")
    table: dict[str, Rivals] = {
        "rotation.exp": {
            "mafsil": lambda: rotation.exp(r),
            "scipy": lambda: Rotation.from_rotvec(r).as_matrix(),
            "numpy": lambda: numpy_exp(r),
        },
        "rotation.log": {"mafsil": lambda: rotation.log(R), "scipy": lambda: Rotation.from_matrix(R).as_rotvec()},
        "to_quaternion": {
            "mafsil": lambda: rotation.to_quaternion(R),
            "scipy": lambda: Rotation.from_matrix(R).as_quat(canonical=True, scalar_first=True),
        },
        "from_quaternion": {
            "mafsil": lambda: rotation.from_quaternion(q),
            "scipy": lambda: Rotation.from_quat(q, scalar_first=True).as_matrix(),
        },
        "from_rpy": {
            "mafsil": lambda: rotation.from_rpy(rpy),
            "scipy": lambda: Rotation.from_euler("xyz", rpy).as_matrix(),
        },
        "to_rpy": {
            "mafsil": lambda: rotation.to_rpy(R),
            "scipy": lambda: Rotation.from_matrix(R).as_euler("xyz"),
        },
        "slerp": {
            "mafsil": lambda: rotation.slerp(R, S, t),
            "scipy": lambda: scipy_slerp(A, B, t),
        },
        "pose.exp": {
            "mafsil": lambda: pose.exp(V),
            "scipy": lambda: RigidTransform.from_exp_coords(V).as_matrix(),
        },
        "pose.log": {"mafsil": lambda: pose.log(T), "scipy": X.as_exp_coords},
        "pose.compose": {"mafsil": lambda: pose.compose(T, U), "numpy": lambda: T @ U},
    }
    if not rows:
        M, N = pin.SE3(R, p), pin.SE3(S, v)
        motion = pin.Motion(np.concatenate([V[3:], V[:3]]))
        table["rotation.exp"]["pinocchio"] = lambda: pin.exp3(r)
        table["rotation.log"]["pinocchio"] = lambda: pin.log3(R)
        table["pose.exp"]["pinocchio"] = lambda: pin.exp6(motion).homogeneous
        table["pose.log"]["pinocchio"] = lambda: np.roll(pin.log6(M).vector, 3)
        table["pose.compose"]["pinocchio"] = lambda: (M * N).homogeneous
        del table["slerp"]["scipy"]
        keys = Rotation.from_rotvec([r, s])
        table["slerp"]["scipy"] = lambda: Slerp([0.0, 1.0], keys)(float(t)).as_matrix()
    return table


def main() -> None:
    """Print the table, and write it where asked."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--rows", type=int, default=4096)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    found: dict[str, Any] = {"machine": machine("numpy", "scipy", "pin", "llvmlite")}
    for rows in (options.rows, 0):
        print(f"{'batch of ' + str(rows) if rows else 'one call':20}" + "ns, and how many times ours")
        for name, rivals in operations(rows).items():
            ours = np.asarray(rivals["mafsil"]())
            for rival, task in rivals.items():
                deviation = np.abs(np.asarray(task()) - ours).max()
                if deviation > TOLERANCE:
                    raise SystemExit(f"{name}: {rival} differs by {deviation}")
            times = {k: 1e9 * timing.least / max(rows, 1) for k, timing in race(rivals).items()}
            base = times["mafsil"]
            print(f"{name:20}" + "  ".join(f"{k} {x:8.1f} ({x / base:5.1f})" for k, x in times.items()))
            found[f"{name}, {rows or 'one call'}"] = times
    if options.json:
        options.json.write_text(json.dumps(found, indent=1))


if __name__ == "__main__":
    main()
