"""Random four-bars with the poses, points and angles that they really take: what a synthesis must find again."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.mobility import FourBar


@dataclass(frozen=True)
class Planted:
    """A four-bar somewhere in the plane.

    Attributes:
        bar: its lengths.
        theta: (N,) angles of the crank from the ground line, rising.
        poses: (N, 3) of the coupler.
        crank: (N,) angles of the crank in the world.
        rocker: (N,) angles of the rocker from the ground line.
        A, D: fixed pivots.
    """

    bar: FourBar
    theta: np.ndarray
    poses: np.ndarray
    crank: np.ndarray
    rocker: np.ndarray
    A: np.ndarray
    D: np.ndarray


def planted(rng: np.random.Generator, count: int, span: float = 1.5) -> Planted:
    """A random one that closes in one mode at `count` angles of the crank over a span."""
    while True:
        L = rng.uniform(0.3, 3, 4)
        bar, theta = FourBar(*L), rng.uniform(-3, 3) + np.linspace(0, span, count)
        found = bar.positions(theta)
        if not found.reachable.all():
            continue
        mode = int(rng.integers(2))
        s = np.cumsum(found.theta[:, mode], axis=-1)
        A, direction = rng.normal(size=2) @ np.array([1, 1j]), rng.uniform(-3, 3)
        offset, turned = rng.normal(size=2) @ np.array([1, 1j]), rng.uniform(-3, 3)
        z = A + np.exp(1j * direction) * (L[0] * np.exp(1j * s[:, 0]) + offset * np.exp(1j * s[:, 1]))
        D = A + np.exp(1j * direction) * L[3]
        C = found.C[:, mode] - np.array([L[3], 0.0])
        return Planted(
            bar,
            theta,
            np.stack([z.real, z.imag, s[:, 1] + turned + direction], axis=1),
            theta + direction,
            np.arctan2(C[:, 1], C[:, 0]),
            np.array([A.real, A.imag]),
            np.array([D.real, D.imag]),
        )


def wrapped(angle: np.ndarray) -> np.ndarray:
    return np.angle(np.exp(1j * np.asarray(angle)))
