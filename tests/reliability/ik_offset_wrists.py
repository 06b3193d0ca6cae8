"""Arms with wrists that do not meet, at round joint values, where elimination is singular: no configuration is lost.

Planted at multiples of 15, 45 and 90 degrees. A planted configuration whose conditioning is above `REGULAR` has to
be among the solutions, whether the list calls itself complete or not; of the others only lists that do are judged.
"""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from mafsil.ik import inverse_kinematics
from mafsil.ik.structure import elimination
from mafsil.robot import Robot

REGULAR = 0.01
"""Smallest over largest singular value of the Jacobian, lengths in metres."""

SAME = 1e-4
"""Distance of a solution from the planted one [rad]."""

PUBLIC = 8
"""One pose of so many is also asked by the public call; the others by the elimination alone."""

STEPS = (2, 4, 12)
"""Parts of half a turn."""

_C, _S = np.cos(np.pi / 3), np.sin(np.pi / 3)

SHAPES: dict[str, list[tuple[tuple[float, float, float], tuple[float, float, float]]]] = {
    # The last axis passes the two before at 0.15 m.
    "crx_like": [
        ((0, 0, 1), (0, 0, 0)), ((0, 1, 0), (0, 0, 0.245)), ((0, 1, 0), (0, 0, 0.785)),
        ((1, 0, 0), (0, 0, 0.785)), ((0, 1, 0), (0.54, 0, 0.785)), ((1, 0, 0), (0.54, 0.15, 0.785)),
    ],
    # Wrist axes at 60 degrees to each other, an elbow beside.
    "jaco_like": [
        ((0, 0, 1), (0, 0, 0)), ((0, 1, 0), (0, 0, 0.2755)), ((0, 1, 0), (0.41, 0.0098, 0.2755)),
        ((1, 0, 0), (0.6, 0.0098, 0.2755)), ((_C, 0, _S), (0.75, 0.0098, 0.2755)), ((-_C, 0, _S), (0.8, 0.0098, 0.36)),
    ],
    # A bent link before axis 4, the last axis 0.076 m beside.
    "xarm_like": [
        ((0, 0, 1), (0, 0, 0)), ((0, 1, 0), (0, 0, 0.267)), ((0, 1, 0), (0.053, 0, 0.551)),
        ((0, 0, -1), (0.13, 0, 0.4)), ((0, 1, 0), (0.13, 0, 0.209)), ((0, 0, -1), (0.206, 0, 0.1)),
    ],
    # The last axis 0.08 m above the fourth.
    "gofa_like": [
        ((0, 0, 1), (0, 0, 0)), ((0, 1, 0), (0, 0, 0.265)), ((0, 1, 0), (0, 0, 0.709)),
        ((1, 0, 0), (0, 0, 0.819)), ((0, 1, 0), (0.47, 0, 0.819)), ((1, 0, 0), (0.47, 0, 0.899)),
    ],
    # No two axes meet, none are parallel neighbours.
    "offset_everywhere": [
        ((0, 0, 1), (0, 0, 0)), ((0, 1, 0), (0.05, 0, 0.3)), ((1, 0, 0), (0.05, 0.02, 0.5)),
        ((0, 1, 0), (0.1, 0, 0.7)), ((1, 0, 0), (0.4, 0.03, 0.7)), ((0, 1, 0), (0.6, 0, 0.75)),
    ],
}  # fmt: skip


@lru_cache(maxsize=8)
def specimen(name: str) -> Robot:
    """One of the arms."""
    screws = [np.concatenate([w, -np.cross(w, p)]) for w, p in SHAPES[name]]
    home = np.eye(4)
    home[:3, 3] = [0.8, 0.0, 0.6]
    return Robot.from_screws(np.array(screws), home)


def work(rng: np.random.Generator, name: str, count: int) -> dict[str, int]:
    """Counts of one arm at random round joint values."""
    robot = specimen(name)
    step = rng.choice(STEPS, (count, 1))
    q = rng.integers(-step + 1, step + 1, (count, 6)) * np.pi / step
    T = robot.forward_kinematics(q)
    values = np.linalg.svd(robot.jacobian_body(q), compute_uv=False)
    regular = values[:, -1] > REGULAR * values[:, 0]
    method = elimination(robot)
    assert method is not None
    found = method.solve_all(T)
    near = _nearest(found.q, q)
    there = np.where(np.isnan(found.q), 0.0, found.q)
    wrong = ~np.isnan(found.q[..., 0]) & (np.abs(robot.forward_kinematics(there) - T[:, None]).max(axis=(2, 3)) > 1e-7)
    total = {
        "cases": count,
        "regular_postures": int(regular.sum()),
        "proven": int(found.complete.sum()),
        "bad_wrong": int(wrong.sum()),
        "bad_lost": int((regular & (near > SAME)).sum()),
        "bad_falsely_complete": int((found.complete & (near > SAME) & regular).sum()),
        "asked_publicly": 0,
        "bad_lost_publicly": 0,
    }
    for i in range(0, count, PUBLIC):
        answer = inverse_kinematics(robot, T[i])
        lost = _nearest(answer.q[None], q[i : i + 1])[0] > SAME
        total["asked_publicly"] += 1
        total["bad_lost_publicly"] += int(lost and (regular[i] or (answer.complete and not answer.families)))
    return total


def _nearest(found: np.ndarray, q: np.ndarray) -> np.ndarray:
    """(k,) distance of the nearest solution, infinite if there is none."""
    away = np.abs((found - q[:, None] + np.pi) % (2 * np.pi) - np.pi).max(axis=-1)
    return np.where(np.isnan(away), np.inf, away).min(axis=1, initial=np.inf)
