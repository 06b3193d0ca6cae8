"""Primitives full of matter or with matter on their surface only: volumes, areas, principal moments."""

from __future__ import annotations

from math import pi

import numpy as np

from mafsil.arrays import Floats

THOMSEN = 1.6075
"""Exponent of Thomsen's formula for the surface of an ellipsoid."""
_SKIN = 1e-6
"""Thickness of the skin by which the shell of an ellipsoid is approximated, as MuJoCo does [m]."""


def volume(kind: str, size: tuple[float, ...], shell: bool) -> float:
    """Volume [m^3], or area [m^2] of a shell, of a geometry of MJCF sizes (radii and half lengths)."""
    match kind, size:
        case "sphere", (r,):
            return 4 * pi * r * r if shell else 4 / 3 * pi * r**3
        case "capsule", (r, h):
            return 4 * pi * r * (r + h) if shell else pi * r * r * 2 * h + 4 / 3 * pi * r**3
        case "cylinder", (r, h):
            return 2 * pi * r * (r + 2 * h) if shell else pi * r * r * 2 * h
        case "ellipsoid", (a, b, c):
            if shell:
                mean = ((a * b) ** THOMSEN + (b * c) ** THOMSEN + (c * a) ** THOMSEN) / 3
                return 4 * pi * mean ** (1 / THOMSEN)
            return 4 / 3 * pi * a * b * c
        case _:
            a, b, c = size
            return 8 * (a * b + b * c + c * a) if shell else 8 * a * b * c


def moments(kind: str, size: tuple[float, ...], mass: float, shell: bool) -> Floats:
    """(3,) principal moments of a homogeneous geometry about its centre [kg m^2]."""
    return _shell(kind, size, mass) if shell else mass * _solid(kind, size)


def _solid(kind: str, size: tuple[float, ...]) -> Floats:
    """(3,) principal moments of unit mass [m^2]."""
    match kind, size:
        case "sphere", (r,):
            return np.full(3, 0.4 * r * r)
        case "capsule", (r, h):
            ball = 4 / 3 * r / (4 / 3 * r + 2 * h)
            rod = 1.0 - ball
            across = rod * (r * r / 4 + h * h / 3) + ball * (0.4 * r * r + h * h + 0.75 * r * h)
            return np.array([across, across, rod * r * r / 2 + ball * 0.4 * r * r])
        case "cylinder", (r, h):
            across = r * r / 4 + h * h / 3
            return np.array([across, across, r * r / 2])
        case "ellipsoid", (a, b, c):
            return np.array([b * b + c * c, a * a + c * c, a * a + b * b]) / 5
        case _:
            a, b, c = size
            return np.array([b * b + c * c, a * a + c * c, a * a + b * b]) / 3


def _shell(kind: str, size: tuple[float, ...], mass: float) -> Floats:
    """(3,) principal moments of a surface of even thickness."""
    match kind, size:
        case "sphere", (r,):
            return np.full(3, 2 / 3 * mass * r * r)
        case "capsule", (r, h):
            ball = mass * r / (r + h)
            tube = mass - ball
            across = tube * (r * r / 2 + h * h / 3) + ball * (2 / 3 * r * r + h * h + h * r)
            return np.array([across, across, tube * r * r + ball * 2 / 3 * r * r])
        case "cylinder", (r, h):
            disk = mass * r / (2 * r + 4 * h)
            tube = mass - 2 * disk
            across = tube * (r * r / 2 + h * h / 3) + 2 * disk * (r * r / 4 + h * h)
            return np.array([across, across, tube * r * r + disk * r * r])
        case "ellipsoid", (a, b, c):
            grown = (a + _SKIN, b + _SKIN, c + _SKIN)
            inner, outer = volume(kind, size, shell=False), volume(kind, grown, shell=False)
            density = mass / (outer - inner)
            return density * (outer * _solid(kind, grown) - inner * _solid(kind, size))
        case _:
            return _box_shell(size, mass)


def _box_shell(size: tuple[float, ...], mass: float) -> Floats:
    """Six plates: each about its own middle, moved to the middle of the box."""
    half = np.array(size)
    areas = 4 * np.array([half[1] * half[2], half[0] * half[2], half[0] * half[1]])
    second = np.zeros(3)
    for axis in range(3):
        plate = mass * areas[axis] / (2 * areas.sum())
        spread = half**2 / 3
        spread[axis] = half[axis] ** 2
        second += 2 * plate * spread
    return second.sum() - second
