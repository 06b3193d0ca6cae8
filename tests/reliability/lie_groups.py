"""R8: exp and log of SO(3) and SE(3) on random and adversarial coordinates, one in a hundred against 50 digits.

`python -m tests.reliability.lie_groups --cases 1000000000 --resume DIR`
"""

from __future__ import annotations

import sys
from math import pi

import mpmath as mp
import numpy as np

from mafsil.geometry import pose, rotation
from tests.reliability import figures

EPS = 2.0**-52
LIMIT = 8
NEAR_PI = 1e-3
"""Angle [rad] to pi from which on the round trip of the logarithm is only held to 1e-8."""
EXACT_EVERY = 100
CHUNK = 50_000


def work(seed: int, cases: int) -> dict[str, int]:
    """Half random, half adversarial; counts of errors by their size in units of 2^-52."""
    rng = np.random.default_rng(seed)
    count: dict[str, int] = {}
    for start in range(0, cases, CHUNK):
        n = min(CHUNK, cases - start)
        coordinates = np.concatenate([_random(rng, n // 2), _adversarial(rng, n - n // 2)])
        for name, value in {**_rotations(coordinates), **_poses(rng, coordinates), **_exact(coordinates)}.items():
            count[name] = count.get(name, 0) + value
    return {"cases": cases, **count}


def _axes(rng: np.random.Generator, n: int) -> np.ndarray:
    w = rng.standard_normal((n, 3))
    w[rng.random((n, 3)) < 0.1] = 0.0
    w[(w == 0).all(-1)] = 1.0
    return w / np.linalg.norm(w, axis=-1, keepdims=True)


def _random(rng: np.random.Generator, n: int) -> np.ndarray:
    return _axes(rng, n) * rng.uniform(0, pi, (n, 1))


def _adversarial(rng: np.random.Generator, n: int) -> np.ndarray:
    """Theta = k pi +- 10^-j, or a power of ten from 1e-300 to 1e8."""
    k = rng.integers(0, 8, n)
    near = np.abs(k * pi + rng.choice([-1.0, 1.0], n) * 10.0 ** -rng.integers(0, 17, n))
    wide = 10.0 ** rng.uniform(-300, 8, n)
    return _axes(rng, n) * np.where(rng.random(n) < 0.5, near, wide)[:, None]


def _rotations(r: np.ndarray) -> dict[str, int]:
    R = rotation.exp(r)
    back = rotation.log(R)
    theta = np.linalg.norm(r, axis=-1)
    inside = theta <= pi - NEAR_PI
    relative = np.abs(back - r).max(-1)[inside] / np.where(theta > 0, theta, 1.0)[inside]
    orthogonal = np.abs(np.swapaxes(R, -1, -2) @ R - np.eye(3)).max((-1, -2))
    again = np.abs(rotation.exp(back) - R).max((-1, -2))
    rim = np.abs(theta - pi) < NEAR_PI
    other = np.abs(back - r * (1 - 2 * pi / np.where(rim, theta, 1.0))[:, None]).max(-1)
    at_pi = np.minimum(np.abs(back - r).max(-1), other)[rim]
    return {
        "bad_nan": int(np.isnan(R).any((-1, -2)).sum() + np.isnan(back).any(-1).sum()),
        "bad_angle": int((np.linalg.norm(back, axis=-1) > pi * (1 + 2 * EPS)).sum()),
        "bad_at_pi": int((at_pi > 1e-8).sum()),
        **_histogram("log_of_exp", relative),
        **_histogram("orthogonality", orthogonal),
        **_histogram("exp_of_log", again),
    }


def _poses(rng: np.random.Generator, r: np.ndarray) -> dict[str, int]:
    v = rng.uniform(-1, 1, r.shape)
    theta = np.linalg.norm(r, axis=-1)
    T = pose.exp(np.concatenate([r, v], axis=-1))
    again = pose.exp(pose.log(T))
    error = np.abs(again - T).max((-1, -2)) / np.maximum(1.0, np.abs(T).max((-1, -2)))
    back = pose.log(T)[theta < pi - NEAR_PI, 3:]
    return {
        "bad_nan_pose": int(np.isnan(again).any((-1, -2)).sum()),
        **_histogram("pose_exp_of_log", error),
        **_histogram("pose_log_of_exp", np.abs(back - v[theta < pi - NEAR_PI]).max(-1) / 2),
    }


def _exact(coordinates: np.ndarray) -> dict[str, int]:
    chosen = coordinates[::EXACT_EVERY]
    found = rotation.exp(chosen)
    errors = [_deviation(R, r) for R, r in zip(found, chosen, strict=True)]
    return {"exact_cases": len(chosen), **_histogram("exact_exp", np.array(errors))}


def _deviation(R: np.ndarray, r: np.ndarray) -> float:
    """Largest error of an entry against 50 digits, over max(1, theta): rounding theta itself costs that much."""
    with mp.workdps(50):
        x, y, z = (mp.mpf(float(c)) for c in r)
        s = x * x + y * y + z * z
        theta = mp.sqrt(s)
        a = mp.sin(theta) / theta if theta else mp.mpf(1)
        b = 2 * (mp.sin(theta / 2) / theta) ** 2 if theta else mp.mpf(1) / 2
        exact = [
            [1 - b * (y * y + z * z), b * x * y - a * z, b * x * z + a * y],
            [b * x * y + a * z, 1 - b * (x * x + z * z), b * y * z - a * x],
            [b * x * z - a * y, b * y * z + a * x, 1 - b * (x * x + y * y)],
        ]
        worst = max(abs(mp.mpf(float(R[i, j])) - exact[i][j]) for i in range(3) for j in range(3))
        return float(worst / max(mp.mpf(1), theta))


def _histogram(name: str, errors: np.ndarray) -> dict[str, int]:
    units = errors / EPS
    edges = (1, 2, 4, LIMIT)
    below = {f"{name}_to_{edge}_eps": int((units <= edge).sum()) for edge in edges}
    return {**below, f"bad_{name}": int((~(units <= LIMIT)).sum())}


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "cases", 1_000_000, 1_000_000)
    sys.exit(not figures.run("R8", options, work)["passed"])
