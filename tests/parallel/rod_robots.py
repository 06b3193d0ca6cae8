"""Parallel robots as built, for the tests: a robot, a pose in its workspace, which of the two motors of each leg."""

import numpy as np

from mafsil.parallel.legs import (
    LegDrive,
    PlatformMotion,
    RodRobot,
    five_bar_on_rods,
    h4,
    hexapod_on_rods,
    linear_delta,
    planar_on_rods,
    rotary_delta,
)

THIRDS = 2 * np.pi * np.arange(3) / 3
RING = np.radians([-15, 15, 105, 135, 225, 255])


def ring(radius, angles, z=0.0):
    return np.stack([radius * np.cos(angles), radius * np.sin(angles), np.full(len(angles), z)], axis=1)


def pose_at(p, w=(0.0, 0.0, 0.0)):
    from mafsil.geometry import pose

    T = pose.exp(np.array([*w, 0.0, 0.0, 0.0]))
    T[:3, 3] = p
    return T


BASE, PLATFORM = ring(0.3, RING), ring(0.12, np.radians([-45, 45, 75, 165, 195, 285]))
SLOPED = -ring(0.6, THIRDS) + [0, 0, 1.0]
ROBOTS = {
    "Delta": (rotary_delta(0.2, 0.05, 0.3, 0.8), [0.1, -0.05, -0.7]),
    "unequal Delta": (
        rotary_delta([0.2, 0.22, 0.19], [0.05, 0.04, 0.06], [0.3, 0.31, 0.28], [0.8, 0.82, 0.79], THIRDS + 0.1),
        [0.1, -0.05, -0.7],
    ),
    "linear Delta": (
        linear_delta(ring(0.2, THIRDS) * [1.0, 1.02, 1.0], [0.25, 0.26, 0.25], ring(0.03, THIRDS)),
        [0.03, -0.02, 0.1],
    ),
    "Keops": (linear_delta(ring(0.6, THIRDS), 0.9, ring(0.05, THIRDS), SLOPED), [0.05, 0.02, -0.4]),
    "RUS hexapod": (
        hexapod_on_rods(BASE, PLATFORM, 0.5, axes=ring(1.0, RING + np.pi / 2), arms=0.15),
        pose_at([0.02, -0.03, 0.45], [0.1, -0.08, 0.2]),
    ),
    "PUS hexapod": (
        hexapod_on_rods(BASE, PLATFORM, 0.5, axes=[0.0, 0.0, 1.0]), pose_at([0.02, -0.03, 0.6], [0.1, -0.08, 0.2]),
    ),
    "UPS hexapod": (
        RodRobot(PlatformMotion.POSE, LegDrive.EXTEND, BASE, np.zeros(6), PLATFORM, np.zeros(3)),
        pose_at([0.02, -0.03, 0.5], [0.1, -0.08, 0.2]),
    ),
    "five-bar": (five_bar_on_rods([[0, 0], [0.3, 0]], 0.3, 0.45), [0.2, 0.5]),
    "pair of SCARAs": (five_bar_on_rods([[0, 0], [0.2, 0]], [0.3, 0.32], [0.4, 0.42], [0.05, 0.1]), [0.15, 0.55]),
    "3-RRR": (
        planar_on_rods(ring(0.5, THIRDS)[:, :2], ring(0.1, THIRDS)[:, :2], 0.35, arms=0.3), [0.03, 0.05, 0.2],
    ),
    "3-PRR": (
        planar_on_rods(ring(0.5, THIRDS)[:, :2], ring(0.1, THIRDS)[:, :2], 0.6, slides=ring(1, THIRDS + 1.5)[:, :2]),
        [0.03, 0.05, 0.2],
    ),
    "H4": (
        h4(
            ring(0.3, np.array([0.3, 2.6, 3.7, 5.8])), [[0, 0.06, 0], [0, 0.06, 0], [0, -0.06, 0], [0, -0.06, 0]],
            [[0.1, 0, 0], [-0.1, 0, 0], [-0.1, 0, 0], [0.1, 0, 0]], 0.3, 0.8,
            [0.0, np.pi, 1.5 * np.pi, 1.5 * np.pi],
        ),
        [0.05, 0.03, -0.7, 0.2],
    ),
}  # fmt: skip
