"""Robots whose platform hangs in cables: lengths, rates, wrenches; what cables can hold is in `cable_tensions`.

Cable i goes straight and without weight from a_i on the frame to b_i on the platform and can only pull. Over a pulley
of radius r it arrives in a_i along n, about which the pulley swivels, and leaves where it is tangent towards b_i: with
p across n and z along n from the middle of the pulley to b_i,

    s^2 = p^2 + z^2 - r^2,    beta = atan2(p, z) + atan2(r, s),    l = s + r beta,    l' = u . b'.

Reference: Pott, Cable-Driven Parallel Robots, 2018, sec. 3.2 and 7.2.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, frozen, positive, real_array, require_finite, spread
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import pose
from mafsil.parallel.legs.leg_lines import line_matrix, rates, unit_vectors
from mafsil.parallel.planar.planar_legs import planar_line_matrix

SPACE, PLANE = 3, 2
"""Dimensions of the places of cables."""


@dataclass(frozen=True, eq=False)
class CableRobot:
    """A platform in cables, in space or in the plane; a point in cables where all end at one place of it.

    Attributes:
        base: (m, 3) or, in the plane, (m, 2) ends a_i on the frame, in {s} [m].
        platform: (m, 3) or (m, 2) ends b_i on the platform, in {b} [m].
        lowest, highest: (m,) tensions that keep a cable straight and that it bears [N].
        pulleys: (m,) radii of the pulleys on the frame; 0 where a cable leaves a_i itself [m].
        arrivals: (m, 3) or (m, 2) directions n in which cables arrive at their pulleys; in the plane the middle of a
            pulley is on the side of the middle of the frame.
    """

    base: Floats
    platform: Floats
    lowest: Floats
    highest: Floats
    pulleys: Floats = field(default_factory=lambda: frozen(0.0))
    arrivals: Floats | None = None

    def __post_init__(self) -> None:
        base = real_array("base", self.base)
        if base.ndim != 2 or base.shape[1] not in (SPACE, PLANE) or not len(base):
            raise InputError("input.shape", name="base", expected="(m, 3) or (m, 2)", got=base.shape, hint="")
        m = len(base)
        for name, shape in (("base", base.shape), ("platform", base.shape), ("lowest", (m,)), ("highest", (m,))):
            given = require_finite(name, real_array(name, getattr(self, name)))
            try:
                object.__setattr__(self, name, frozen(np.broadcast_to(given, shape)))
            except ValueError:
                raise InputError("input.shape", name=name, expected=shape, got=given.shape, hint="") from None
        radii = spread("pulleys", self.pulleys, (m,))
        up = np.eye(base.shape[1])[-1] if self.arrivals is None else self.arrivals
        n = spread("arrivals", up, base.shape)
        far = np.linalg.norm(n, axis=1, keepdims=True)
        if not (radii >= 0.0).all() or not (far > 0.0).all():
            raise InputError("parallel.pulleys", radii=radii.tolist(), directions=n.tolist())
        object.__setattr__(self, "pulleys", frozen(radii))
        object.__setattr__(self, "arrivals", frozen(n / far))
        if not ((self.lowest >= 0.0) & (self.lowest < self.highest)).all():
            raise InputError("parallel.cable_bounds", low=self.lowest.tolist(), high=self.highest.tolist())

    @property
    def m(self) -> int:
        """Number of cables."""
        return len(self.base)

    @property
    def planar(self) -> bool:
        """Whether it lies in a plane: poses are (x, y, phi), wrenches (m_z, f_x, f_y)."""
        return self.base.shape[1] == PLANE

    @property
    def point(self) -> bool:
        """Whether all cables end at one place: no moments, and the orientation does not matter."""
        return bool(np.ptp(self.platform, axis=0).max() == 0.0)

    @cached_property
    def size(self) -> float:
        """Largest distance of an end from the middle of the platform's ends [m], which moments are judged over."""
        reach = np.linalg.norm(self.platform - self.platform.mean(axis=0), axis=1).max()
        return float(reach) if reach > 0.0 else 1.0

    @property
    def freedoms(self) -> int:
        """How many numbers a wrench on it has: 6, 3 in the plane; of a point 3 or 2."""
        return (PLANE if self.planar else SPACE) if self.point else (3 if self.planar else 6)

    def cable_vectors(self, x: ArrayLike) -> Floats:
        """(*batch, m, 3 | 2) in {s}, from where cables leave the frame or their pulleys to the platform [m].

        Args:
            x: poses T_sb (*batch, 4, 4), in the plane (x, y, phi) (*batch, 3).

        Raises:
            InputError: x is no pose, or a cable would end within its pulley.
        """
        return self._cables(self._ends(x))[0]

    def lengths(self, x: ArrayLike) -> Floats:
        """(*batch, m) lengths of the cables from a_i on [m], at poses x: inverse kinematics."""
        d, wrapped = self._cables(self._ends(x))
        return np.asarray(np.linalg.norm(d, axis=-1) + wrapped)

    def structure_matrix(self, x: ArrayLike) -> Floats:
        """(*batch, 6 | 3, m) wrenches on the platform of unit tensions, in {s} about its origin: (b_i x -u_i, -u_i).

        Args:
            x: poses, as for `cable_vectors`.

        Raises:
            InputError: x is no pose, a cable has length zero.
        """
        ends = self._ends(x)
        _, u = unit_vectors(self._cables(ends)[0])
        lines = planar_line_matrix(ends, u) if self.planar else line_matrix(ends, u)
        return -np.swapaxes(lines, -1, -2)

    def _cables(self, ends: Floats) -> tuple[Floats, Floats]:
        """Straight parts (*batch, m, k) that lead to ends, and lengths (*batch, m) on pulleys [m]."""
        w, r = ends - self.base, self.pulleys
        if not r.any():
            return w, np.zeros(w.shape[:-1])
        n = np.asarray(self.arrivals)
        z = (w * n).sum(axis=-1)
        inward = self.base.mean(axis=0) - self.base if self.planar else w
        across = inward - (inward * n).sum(axis=-1)[..., None] * n
        e = across / np.maximum(np.linalg.norm(across, axis=-1, keepdims=True), LEAST_DIVISOR)
        p = (w * e).sum(axis=-1) - r
        straight = p**2 + z**2 - r**2
        if not (straight > 0.0).all():
            raise InputError("parallel.within_pulley", cable=int(np.argwhere(~(straight > 0.0))[0][-1]) + 1)
        s = np.sqrt(straight)
        beta = np.mod(np.arctan2(p, z) + np.arctan2(r, s), 2 * np.pi)
        u = np.sin(beta)[..., None] * e + np.cos(beta)[..., None] * n
        return s[..., None] * u, r * beta

    def wrench(self, x: ArrayLike, tensions: ArrayLike) -> Floats:
        """(*batch, 6 | 3) wrench of the cables on the platform for tensions (*batch, m) [N], in {s}."""
        return rates(self.structure_matrix(x), tensions)

    def cable_rates(self, x: ArrayLike, V: ArrayLike) -> Floats:
        """(*batch, m) rates of the lengths [m/s] for twists V (*batch, 6 | 3) of the platform in {s}."""
        return -rates(np.swapaxes(self.structure_matrix(x), -1, -2), V)

    def weight(self, x: ArrayLike, mass: float, com: ArrayLike | None = None, gravity: float = 9.81) -> Floats:
        """(*batch, 6 | 3) wrench of the platform's weight in {s}, along -z, in the plane along -y.

        Args:
            x: poses, as for `cable_vectors`.
            mass: of the platform and what it carries [kg].
            com: (3,) or (2,) centre of mass in {b}; its origin if None [m].
            gravity: [m/s^2].
        """
        k = self.base.shape[1]
        place = np.zeros(k) if com is None else as_batch("com", com, (k,), finite=True)
        R, p = self._pose(x)
        centre = p + np.einsum("...ij,...j->...i", R, place)
        force = np.broadcast_to(np.eye(k)[-1] * (-positive("mass", mass) * gravity), centre.shape)
        if self.planar:
            moment = (centre[..., 0] * force[..., 1] - centre[..., 1] * force[..., 0])[..., None]
        else:
            moment = np.cross(centre, force)
        return np.concatenate([moment, force], axis=-1)

    def about_platform(self, x: ArrayLike, wrench: Floats) -> Floats:
        """(*batch, freedoms, k) wrenches (*batch, 6 | 3, k) about the middle of the platform's ends.

        Moments are over `size`; of a point there are only forces.
        """
        k, middle = self.base.shape[1], self._ends(x).mean(axis=-2)[..., None]
        shape = np.broadcast_shapes(middle.shape[:-2], wrench.shape[:-2])
        wrench = np.broadcast_to(wrench, (*shape, *wrench.shape[-2:]))
        force = wrench[..., -k:, :]
        if self.point:
            return np.ascontiguousarray(force)
        if self.planar:
            shift = (middle[..., 0, :] * force[..., 1, :] - middle[..., 1, :] * force[..., 0, :])[..., None, :]
        else:
            shift = np.cross(middle, force, axis=-2)
        return np.concatenate([(wrench[..., :-k, :] - shift) / self.size, force], axis=-2)

    def _pose(self, x: ArrayLike) -> tuple[Floats, Floats]:
        """Rotation (*batch, k, k) and place (*batch, k)."""
        if not self.planar:
            T = pose.check(x)
            return T[..., :3, :3], T[..., :3, 3]
        rows = as_batch("x", x, (3,), finite=True)
        c, s = np.cos(rows[..., 2]), np.sin(rows[..., 2])
        return np.stack([np.stack([c, -s], axis=-1), np.stack([s, c], axis=-1)], axis=-2), rows[..., :2]

    def _ends(self, x: ArrayLike) -> Floats:
        """(*batch, m, k) places of b_i in {s} [m]."""
        R, p = self._pose(x)
        return p[..., None, :] + self.platform @ np.swapaxes(R, -1, -2)
