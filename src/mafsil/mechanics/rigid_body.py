"""A single rigid body: momentum, energy and equations of motion, in 3-vectors and in twists and wrenches.

Reference: Lynch & Park, Modern Robotics, sec. 8.2.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Vector3, Vector6, as_batch
from mafsil.errors import ModelError
from mafsil.geometry import twist, wrench
from mafsil.mechanics.tolerances import SINGULAR_PIVOT
from mafsil.model import Inertial


@dataclass(frozen=True, eq=False, slots=True)
class RigidBody:
    """A body with its frame {b} anywhere on it; all arguments take batches.

    Attributes:
        inertial: mass, centre of mass and inertia in {b}.
    """

    inertial: Inertial

    @property
    def spatial_inertia(self) -> Floats:
        """G (6, 6) in {b}; diag(I, m E) with {b} at the centre of mass."""
        m, c = self.inertial.mass, self.inertial.com
        C = np.array([[0.0, -c[2], c[1]], [c[2], 0.0, -c[0]], [-c[1], c[0], 0.0]])
        return np.block([[self.inertial.inertia - m * C @ C, m * C], [-m * C, m * np.eye(3)]])

    def momentum(self, V: ArrayLike) -> Vector6:
        """P (*batch, 6) = G V: angular about the origin of {b}, linear [N m s, N s]; V (*batch, 6) in {b}."""
        return as_batch("V", V, (6,)) @ self.spatial_inertia

    def kinetic_energy(self, V: ArrayLike) -> Floats:
        """K (*batch,) = V . G V / 2 [J]; V (*batch, 6) in {b}."""
        return (as_batch("V", V, (6,)) * self.momentum(V)).sum(-1) / 2

    def wrench(self, V: ArrayLike, dV: ArrayLike) -> Vector6:
        """F (*batch, 6) = G dV - [ad_V]' G V, in {b} [N m, N].

        Args:
            V, dV: (*batch, 6) body twist and the derivative of its components.

        Reference: Lynch & Park, Modern Robotics, eq. 8.40.
        """
        return as_batch("dV", dV, (6,)) @ self.spatial_inertia - wrench.dual_bracket(V, self.momentum(V))

    def acceleration(self, V: ArrayLike, F: ArrayLike) -> Vector6:
        """dV (*batch, 6) that a wrench F (*batch, 6) in {b} produces at the twist V (*batch, 6).

        Raises:
            ModelError: the inertia is singular: a point mass or a thin rod has no acceleration about its axis.
        """
        G = self.spatial_inertia
        values = np.linalg.eigvalsh(G)
        if values[0] <= SINGULAR_PIVOT * values[-1]:
            raise ModelError("dynamics.moments", moments=tuple(map(float, np.linalg.eigvalsh(self.inertial.inertia))))
        load = as_batch("F", F, (6,)) + wrench.dual_bracket(V, self.momentum(V))
        return np.asarray(np.linalg.solve(G, load[..., None])[..., 0], dtype=np.float64)

    def force(self, V: ArrayLike, dV: ArrayLike) -> Vector3:
        """Force (*batch, 3) = m (dv_c + omega x v_c) of the centre of mass, the classical form, in {b} [N]."""
        w, alpha, v, a = self._parts(V, dV)
        c = self.inertial.com
        v_c, dv_c = v + np.cross(w, c), a + np.cross(alpha, c)
        return self.inertial.mass * (dv_c + np.cross(w, v_c))

    def moment(self, V: ArrayLike, dV: ArrayLike) -> Vector3:
        """Moment (*batch, 3) = I alpha + omega x I omega about the centre of mass, in {b} [N m]."""
        w, alpha, _, _ = self._parts(V, dV)
        inertia = self.inertial.inertia
        return alpha @ inertia + np.cross(w, w @ inertia)

    def seen_from(self, T_ab: ArrayLike) -> Floats:
        """G (6, 6) in another frame {a}: Ad(T_ba)' G Ad(T_ba); T_ab (4, 4) is the pose of {b} in {a}."""
        T = as_batch("T_ab", T_ab, (4, 4), finite=True)
        columns = twist.transform(np.linalg.inv(T), np.eye(6)).T
        return columns.T @ self.spatial_inertia @ columns

    def _parts(self, V: ArrayLike, dV: ArrayLike) -> tuple[Floats, Floats, Floats, Floats]:
        velocity, rate = as_batch("V", V, (6,)), as_batch("dV", dV, (6,))
        return velocity[..., :3], rate[..., :3], velocity[..., 3:], rate[..., 3:]
