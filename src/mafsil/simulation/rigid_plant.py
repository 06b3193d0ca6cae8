"""An arm whose tip meets rigid surfaces: the tip's motion as they see it."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from mafsil.arrays import Floats, JointVector, Vector3, require_kind
from mafsil.errors import InputError
from mafsil.model.loading import as_mechanism
from mafsil.simulation.plant import Plant
from mafsil.simulation.rigid_surface import RigidSurface
from mafsil.simulation.stepping import IMPLICIT_FRICTION

METHODS = ("rk4", "midpoint", "heun", IMPLICIT_FRICTION)
"""Integrators whose steps follow a parabola exactly: with others, flights within a step come out too short."""
STARTS_INSIDE = 1e-6
"""Depth [m] beyond which a start in the surface is refused; what is less is put right when contact lasts."""


class TipState(NamedTuple):
    """The tip's origin at a state, and k surfaces near it.

    Attributes:
        R: (3, 3) of the tip frame.
        p, v: (3,) place and velocity in {s} [m, m/s].
        J: (3, n) with v = J qd.
        bend: (3,) dJ/dt qd [m/s^2].
        gaps: (k,) distances from the surfaces [m].
        normals: (k, 3) out of them.
        bends: (k,) second time derivatives of the distances by the curvature of the surfaces [m/s^2].
    """

    R: Floats
    p: Vector3
    v: Vector3
    J: Floats
    bend: Vector3
    gaps: Floats
    normals: Floats
    bends: Floats

    @property
    def rates(self) -> Floats:
        """(k,) time derivatives of the distances [m/s]."""
        return self.normals @ self.v


@dataclass(frozen=True, eq=False)
class RigidPlant(Plant):
    """A simulated arm that meets rigid surfaces; one arm at a time, no batches, and no loops.

    Attributes:
        surface: what the tip's origin cannot enter, one or a tuple of several.

    Raises:
        InputError: the robot has closed loops; no surface.
    """

    surface: RigidSurface | tuple[RigidSurface, ...] = field(kw_only=True)

    def __post_init__(self) -> None:
        if as_mechanism(self.robot, keeps_loops=True).loops:
            raise InputError("simulation.rigid_loops")
        Plant.__post_init__(self)
        if not self.surfaces:
            raise InputError("simulation.rigid_nothing")
        for one in self.surfaces:
            require_kind("surface", one, "RigidSurface", "distance", "outward", "outward_rate")

    @property
    def surfaces(self) -> tuple[RigidSurface, ...]:
        """All of them."""
        return self.surface if isinstance(self.surface, tuple) else (self.surface,)

    def tip_state(self, q: JointVector, qd: JointVector) -> TipState:
        """The tip and the surfaces at a state.

        Args:
            q, qd: (n,) state.
        """
        T, J, rate = self.robot.forward_kinematics(q), self.robot.jacobian_body(q), self.robot.jacobian_body_rate(q, qd)
        R, p = T[:3, :3], T[:3, 3]
        V, bent = J @ qd, rate @ qd
        v = R @ V[3:]
        bend = R @ (bent[3:] + _cross(V[:3], V[3:]))
        surfaces = self.surfaces
        gaps = np.array([float(one.distance(p)) for one in surfaces])
        normals = np.array([one.outward(p) for one in surfaces])
        bends = np.array([one.outward_rate(p, v) @ v for one in surfaces])
        return TipState(R, p, v, R @ J[3:], bend, gaps, normals, bends)

    def require_outside(self, q: JointVector) -> None:
        """Refuse a start in a surface, and a batch of them.

        Args:
            q: (n,) coordinates.

        Raises:
            InputError: the sentence says how deep.
        """
        if q.ndim != 1:
            raise InputError("simulation.rigid_batch", shape=q.shape[:-1])
        p = self.robot.forward_kinematics(q)[:3, 3]
        depth = -min(float(one.distance(p)) for one in self.surfaces)
        if depth > STARTS_INSIDE:
            raise InputError("simulation.rigid_start", depth=depth)


def _cross(a: Vector3, b: Vector3) -> Vector3:
    """a x b of two vectors (3,): without the loops over axes of NumPy's, which take longer than all the rest."""
    (x, y, z), (u, v, w) = a.tolist(), b.tolist()
    return np.array([y * w - z * v, z * u - x * w, x * v - y * u])
