"""Task spaces of textbook arms: annuli, spheres and bands, directions, what stays free behind a task point."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, positive, real_array, single, whole
from mafsil.errors import InputError
from mafsil.mobility.spaces.configuration_space import named_space
from mafsil.mobility.spaces.planar_positions import PolygonSpace, polygon_space
from mafsil.mobility.tolerances import TYPED


def annulus(lengths: ArrayLike) -> tuple[float, float]:
    """Least and greatest distance of the tip of a planar chain of revolute joints from its base, without limits [m].

    R_max = sum L, R_min = max(0, 2 L_max - sum L)

    Args:
        lengths: (n,) positive [m].
    """
    L = [positive(f"lengths[{k}]", value) for k, value in enumerate(np.atleast_1d(real_array("lengths", lengths)))]
    if not L:
        raise InputError("mobility.polygon_lengths", got=(0,))
    total = sum(L)
    return max(0.0, 2 * max(L) - total), total


def self_motion_manifold(lengths: ArrayLike, distance: float) -> PolygonSpace:
    """All configurations of a planar chain of revolute joints whose tip stands at a distance from the base.

    The chain and the distance make a polygon: none, some, or families of configurations lie behind a task point.

    Args:
        lengths: (n,) of the links [m].
        distance: of the tip from the base [m], zero or more.
    """
    return polygon_space(np.append(real_array("lengths", lengths), real_array("distance", distance)))


@dataclass(frozen=True)
class SphereBand:
    """Where the tip of a spatial 2R arm with axes that meet can be: a band of a sphere.

    Attributes:
        radius: of the sphere about the point where the axes meet [m].
        z_min, z_max: of the band along the first axis [m].
    """

    radius: float
    z_min: float
    z_max: float

    @property
    def whole_sphere(self) -> bool:
        """Whether the band is everything."""
        small = TYPED * self.radius
        return self.z_max >= self.radius - small and self.z_min <= -self.radius + small


def spatial_2r(alpha: float, distance: float, offset: float = 0.0) -> SphereBand:
    """Reach of two revolute joints whose axes meet: z within c cos(alpha) +- rho sin(alpha) on a sphere.

    Args:
        alpha: angle of the axes [rad].
        distance: rho of the tip from the second axis [m].
        offset: c of the tip along the second axis [m].
    """
    rho, (angle, c) = positive("distance", distance), single("alpha, offset", [alpha, offset], (2,)).tolist()
    middle, half = c * np.cos(angle), rho * abs(np.sin(angle))
    return SphereBand(float(np.hypot(rho, c)), float(middle - half), float(middle + half))


def direction_of(theta: ArrayLike, phi: ArrayLike) -> Floats:
    """(*batch, 3) (sin theta cos phi, sin theta sin phi, cos theta): polar angle from z, azimuth [rad]."""
    t, p = np.broadcast_arrays(real_array("theta", theta), real_array("phi", phi))
    return np.stack([np.sin(t) * np.cos(p), np.sin(t) * np.sin(p), np.cos(t)], axis=-1)


def angles_of_direction(direction: ArrayLike) -> tuple[Floats, np.ndarray[tuple[int, ...], np.dtype[np.bool_]]]:
    """(*batch, 2) polar angle and azimuth of directions [rad], and (*batch,) where the azimuth is free (poles: 0).

    Args:
        direction: (*batch, 3) of any length but zero.

    Raises:
        InputError: a direction is zero.
    """
    d = as_batch("direction", direction, (3,), finite=True)
    if not d.any(axis=-1).all():
        raise InputError("mobility.no_direction")
    level = np.hypot(d[..., 0], d[..., 1])
    pole = level <= TYPED * np.linalg.norm(d, axis=-1)
    phi = np.where(pole, 0.0, np.arctan2(d[..., 1], d[..., 0]))
    return np.stack([np.arctan2(level, d[..., 2]), phi], axis=-1), np.asarray(pole, dtype=np.bool_)


def task_redundancy(freedoms: int, task: str) -> int:
    """Freedoms of an arm beyond those of a task, named as in `configuration_space.DICTIONARY`."""
    return whole("freedoms", freedoms) - named_space(task).dimension
