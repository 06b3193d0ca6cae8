"""R6, singular surfaces: shoulder, elbow and wrist, at them, two and three of them at once, and 1e-12 to 1e-3 beside.

Configurations are planted on the surfaces by finding where the triple product that vanishes there changes its sign
along one joint. Every solution must reach the pose; the planted configuration must be in the list, or be the member
of a named family at its own values of the free joints. Where the elbow is straight the pose is also moved outwards:
what is found there must reach it too, or the answer is an honest no.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator
from functools import cache, partial
from itertools import product

import numpy as np

from mafsil.geometry import pose
from mafsil.ik import SolutionFamily, SolutionSet, inverse_kinematics
from mafsil.ik.chain import Chain, chain_of
from mafsil.robot import Robot, load
from tests.reliability.arm_families import forward, jacobian

DELTA = 256 * 2.0**-52
RESIDUAL = 1e-9
TURN = 2 * np.pi
GRID = 49

Surface = Callable[[np.ndarray, np.ndarray], np.ndarray]
"""(count,) a number that vanishes on the surface, of axes (count, n, 3) and points (count, n + 1, 3), the tip last."""


def bound(J: np.ndarray, n: int, residual: np.ndarray) -> np.ndarray:
    """(k,) how far a solution with a residual may be from the planted one: see `ik_complete`."""
    least = np.linalg.svd(J, compute_uv=False)[..., min(6, n) - 1]
    delta = DELTA + residual
    return np.minimum(delta / np.maximum(least, 1e-300), 64 * np.sqrt(delta))


def apart(q: np.ndarray, other: np.ndarray, slides: tuple[bool, ...]) -> np.ndarray:
    """(...) largest difference of coordinates, angles up to whole turns."""
    d = q - other
    return np.abs(np.where(np.array(slides), d, (d + np.pi) % TURN - np.pi)).max(axis=-1)


def placed(chain: Chain, hub: np.ndarray, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Axes and points of all joints at configurations, the hub carried by the last joint but two as last point."""
    T = np.broadcast_to(np.eye(4), (len(q), 4, 4))
    axes, points = [], []
    for i, screw in enumerate(chain.screws):
        if i == len(chain) - min(3, len(chain) - 1):
            before = T
        axes.append(T[:, :3, :3] @ chain.axes[i])
        points.append(T[:, :3, :3] @ chain.points[i] + T[:, :3, 3])
        T = T @ pose.exp(screw * q[:, i, None])
    carrier = before if len(chain) == 6 else T
    points.append(carrier[:, :3, :3] @ hub + carrier[:, :3, 3])
    return np.stack(axes, axis=1), np.stack(points, axis=1)


def _triple(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> np.ndarray:
    return (np.cross(a, b) * c).sum(axis=-1)


def shoulder(w: np.ndarray, r: np.ndarray) -> np.ndarray:
    """The hub is in the plane of axes 1 and 2."""
    return _triple(w[:, 0], w[:, 1], r[:, -1] - r[:, 0])


def elbow(at: int, to: int, w: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Two links are in line, joint `at` between them, the second up to point `to`."""
    return _triple(w[:, at], r[:, at] - r[:, at - 1], r[:, to] - r[:, at])


def wrist(w: np.ndarray, r: np.ndarray) -> np.ndarray:
    """Axes 4, 5 and 6 are in one plane."""
    return _triple(w[:, 4], w[:, 3], w[:, 5])


def stroke(w: np.ndarray, r: np.ndarray) -> np.ndarray:
    """The slide of joint 3 brings the hub level with joint 2."""
    return (w[:, 2] * (r[:, -1] - r[:, 1])).sum(axis=-1)


def _offset_wrist() -> Robot:
    """A UR arm whose last two axes pass each other at 60 mm."""
    chain = chain_of(load("ur5e").mechanism)
    assert chain is not None
    points = chain.points.copy()
    points[5] += 0.06 * chain.axes[4] @ np.eye(3)
    points[5] += 0.06 * np.cross(chain.axes[4], chain.axes[5])
    screws = np.concatenate([chain.axes, np.cross(points, chain.axes)], axis=1)
    return Robot.from_screws(screws, chain.home)
