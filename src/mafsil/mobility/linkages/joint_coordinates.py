"""Coordinates of chains and trees with their topology: angles that wrap, orientations of balls, bounds of the others.

A ball has three angles, R = rot_x(q_1) rot_y(q_2) rot_z(q_3), which no difference may be taken of: differences of
orientations are rotation vectors.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Booleans, Floats, as_batch, whole
from mafsil.errors import InputError
from mafsil.geometry import rotation
from mafsil.geometry.euler import from_euler, to_euler
from mafsil.mobility.linkages.linkage import Linkage
from mafsil.mobility.on_linkage import on_linkage
from mafsil.mobility.spaces.configuration_space import SpaceFactor, configuration_space
from mafsil.mobility.spaces.planar_positions import wrap_angle
from mafsil.mobility.torus import chart

BALL = "XYZ"
"""Sequence of the angles of a ball, about axes that move with it."""


@dataclass(frozen=True, eq=False)
class JointCoordinates:
    """Coordinates of a chain: free angles wrap, balls have orientations, the others have bounds.

    Attributes:
        wraps: (n,) which coordinates are angles that go round.
        lower, upper: (n,) bounds of the others; infinite where there are none.
        balls: indices of the first of three angles of each orientation.
    """

    wraps: Booleans
    lower: Floats
    upper: Floats
    balls: tuple[int, ...] = ()

    @classmethod
    def of(cls, linkage: Linkage) -> JointCoordinates:
        """Those of a chain or tree.

        Raises:
            InputError: it has loops, or joints that follow others.
        """
        return _of(linkage)

    def difference(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """(*batch, n) b - a, the short way round where coordinates wrap; of balls the rotation vector from a to b."""
        n = len(self.wraps)
        first, last = as_batch("a", a, (n,)), as_batch("b", b, (n,))
        step = np.where(self.wraps, wrap_angle(last - first), last - first)
        for k in self.balls:
            R_a, R_b = (from_euler(q[..., k : k + 3], BALL) for q in (first, last))
            step[..., k : k + 3] = rotation.log(np.swapaxes(R_a, -1, -2) @ R_b)
        return step

    def distance(self, a: ArrayLike, b: ArrayLike) -> Floats:
        """(*batch,) Euclidean length of the difference."""
        return np.linalg.norm(self.difference(a, b), axis=-1)

    def inside(self, q: ArrayLike) -> Booleans:
        """(*batch,) whether coordinates keep their bounds; angles that wrap always do."""
        value = as_batch("q", q, (len(self.wraps),))
        good = self.wraps | ((value >= self.lower) & (value <= self.upper))
        return np.asarray(good.all(axis=-1), dtype=np.bool_)

    def wrap_angles(self, q: ArrayLike) -> Floats:
        """(*batch, n) with angles that wrap in [0, 2 pi)."""
        value = as_batch("q", q, (len(self.wraps),))
        return np.where(self.wraps, chart(value), value)

    def sample(self, count: int, seed: int = 0) -> Floats:
        """(count, n) uniform samples; orientations too are uniform.

        Raises:
            InputError: a coordinate has no bounds, so that there is no uniform distribution.
        """
        if not np.isfinite(self.upper - self.lower).all():
            raise InputError("mobility.unbounded", index=int(np.argmin(np.isfinite(self.upper - self.lower))))
        rng, rows = np.random.default_rng(seed), whole("count", count, 0)
        q: Floats = rng.uniform(self.lower, self.upper, (rows, len(self.wraps)))
        for k in self.balls:
            q[:, k : k + 3] = chart(to_euler(rotation.random(rng, rows), BALL))
        return q


@on_linkage
def _of(linkage: Linkage) -> JointCoordinates:
    space = configuration_space(linkage)
    if linkage.couplings:
        raise InputError("mobility.followers", name=linkage.name or "-")
    wraps, balls = list[bool](), list[int]()
    for factor in space.factors:
        if factor is SpaceFactor.ROTATIONS:
            balls.append(len(wraps))
        wraps += [factor in (SpaceFactor.CIRCLE, SpaceFactor.ROTATIONS)] * factor.dimension
    bounds = np.array([(each.lower, each.upper) for each in linkage.joints for _ in range(each.freedoms)])
    low, high = bounds.reshape(-1, 2).T
    around = np.array(wraps, dtype=np.bool_)
    return JointCoordinates(around, np.where(around, 0.0, low), np.where(around, 2 * np.pi, high), tuple(balls))
