"""An arm whose tip meets rigid surfaces: the tip's motion as they see it.

A surface that does not give way: its signed distance, its normal, its friction, and how an impact ends.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from math import inf
from typing import NamedTuple, Self

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, Vector3, as_batch, not_negative, positive, require_kind, single
from mafsil.control.contact.shaped_environment import round_normal, round_normal_rate
from mafsil.errors import InputError
from mafsil.fields import between, check_fields
from mafsil.model.loading import as_mechanism
from mafsil.simulation.plant import Plant
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


@dataclass(frozen=True, eq=False, slots=True)
class RigidSurface:
    """A plane, a sphere or a cylinder that the tip's origin cannot enter: it only pushes.

    What it does to the tip is a force along its normal and one of friction across it, at most `friction` times as
    large: a tip that it can hold sticks, another one slides, and friction is against the sliding.

    Attributes:
        point: (3,) on the plane, in the middle of the sphere, on the axis of the cylinder, in {s} [m].
        restitution: from 0 (it stays) to 1: square root of the share of the normal work that an impact gives back;
            without friction, and where the tip slides all the time, speed along the normal after over that before.
        normal: (3,) of a plane, out of it, towards the arm.
        radius: of a sphere or a cylinder [m].
        axis: (3,) of a cylinder.
        hollow: whether the tip is inside and touches the inner side.
        friction: Coulomb's coefficient mu, of sticking and of sliding.

    Raises:
        InputError: a wrong shape, neither or both of normal and radius, a restitution outside 0 to 1, friction below 0.
    """

    point: Vector3
    restitution: float = 0.0
    normal: Vector3 | None = None
    radius: float | None = None
    axis: Vector3 | None = None
    hollow: bool = False
    friction: float = 0.0
    _numbers = check_fields(restitution=between(0.0, 1.0), friction=not_negative)

    def __post_init__(self) -> None:
        if (self.normal is None) == (self.radius is None):
            raise InputError("simulation.rigid_form")
        object.__setattr__(self, "point", single("point", self.point, (3,)))
        for name in ("normal", "axis"):
            if getattr(self, name) is not None:
                object.__setattr__(self, name, _unit(name, getattr(self, name)))
        if self.radius is not None:
            positive("radius", self.radius)
        self._numbers()

    @classmethod
    def plane(cls, point: ArrayLike, normal: ArrayLike, *, restitution: float = 0.0, friction: float = 0.0) -> Self:
        """A plane.

        Args:
            point, normal: (3,) on it, and out of it towards the arm; in {s} [m, 1].
            restitution, friction: as of the class.
        """
        out = single("normal", normal, (3,))
        return cls(single("point", point, (3,)), restitution, normal=out, friction=friction)

    @classmethod
    def sphere(
        cls, centre: ArrayLike, radius: float, *, restitution: float = 0.0, hollow: bool = False, friction: float = 0.0
    ) -> Self:
        """A sphere, touched from outside, or with `hollow` from inside.

        Args:
            centre: (3,) in {s} [m].
            radius: [m].
            restitution, friction: as of the class.
            hollow: whether the tip is inside.
        """
        return cls(single("centre", centre, (3,)), restitution, radius=radius, hollow=hollow, friction=friction)

    @classmethod
    def cylinder(
        cls,
        point: ArrayLike,
        axis: ArrayLike,
        radius: float,
        *,
        restitution: float = 0.0,
        hollow: bool = False,
        friction: float = 0.0,
    ) -> Self:
        """A cylinder without ends, touched from outside, or with `hollow` from inside.

        Args:
            point, axis: (3,) on its axis, and along it; in {s} [m, 1].
            radius: [m].
            restitution, friction: as of the class.
            hollow: whether the tip is inside.
        """
        at, along = single("point", point, (3,)), single("axis", axis, (3,))
        return cls(at, restitution, radius=radius, axis=along, hollow=hollow, friction=friction)

    def distance(self, p: Vector3) -> Floats:
        """(*batch,) from points p (*batch, 3) in {s} to the surface [m]; negative inside."""
        p = as_batch("p", p, (3,))
        if self.normal is not None:
            return np.asarray((p - self.point) @ self.normal)
        return -round_normal(p, self.point, self.radius or inf, self.axis, self.hollow)[1]

    def outward(self, p: Vector3) -> Vector3:
        """(*batch, 3) normal at points p (*batch, 3)."""
        p = as_batch("p", p, (3,))
        if self.normal is not None:
            return np.broadcast_to(self.normal, p.shape)
        return round_normal(p, self.point, self.radius or inf, self.axis, self.hollow)[0]

    def outward_rate(self, p: Vector3, velocity: Vector3) -> Vector3:
        """(*batch, 3) of the normal at points p (*batch, 3) that move [1/s]."""
        p, velocity = as_batch("p", p, (3,)), as_batch("velocity", velocity, (3,))
        if self.normal is not None:
            return np.zeros_like(p)
        return round_normal_rate(p, velocity, self.point, self.axis, self.hollow)


def _unit(name: str, value: ArrayLike) -> Vector3:
    vector = single(name, value, (3,))
    length = float(np.linalg.norm(vector))
    if not length > 0.0:
        raise InputError("control.no_normal")
    return vector / length
