"""Platforms on rods: every leg a motor that moves one end of a rod, or makes it longer; the platform holds the other.

    crank    C = a + L (cos q e + sin q n x e)     RUS hexapods, Delta, 3-RRR, five-bars, pairs of SCARAs, H4
    linear   C = a + q d                           PUS hexapods, linear Delta with any towers, Keops, 3-PRR
    extend   C = a, rod of length l + q            UPS hexapods, 3-RPR

The far end is B = p + R c + b: c turns with the platform, b (of parallelograms and articulated plates) does not. From
|B - C| = l follows (r x u, u) V = (u . C') q' with u along the rod and r = p + R c: A V = B q'.

Reference: Merlet, Parallel Robots, 2nd ed., ch. 2 to 5.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, frozen, radians, real_array, single, spread
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import pose, rotation
from mafsil.parallel.legs.leg_lines import forces_for, require_regular, resultant, unit_vectors
from mafsil.parallel.legs.rod_poses import RodPoses, crossing_of_spheres, search_poses
from mafsil.parallel.planar.five_bar import MotorAngles, crank_angles
from mafsil.parallel.planar.planar_legs import planar_poses
from mafsil.parallel.platforms.stewart import StewartPlatform
from mafsil.parallel.singular_kinds import SingularKinds, singular_kinds
from mafsil.parallel.tolerances import OPEN

NEWTON_STEPS = 30
CLOSED = 1e-12
"""Largest miss of a rod over the size that ends Newton's method."""
LONGEST = 0.3
"""Of one Newton step [rad, sizes]."""
Z = np.array([0.0, 0.0, 1.0])


class LegDrive(Enum):
    """What the motor of a leg does."""

    CRANK = "crank"
    LINEAR = "linear"
    EXTEND = "extend"


class PlatformMotion(Enum):
    """What a platform can do: columns of its twist (omega, v), and how many legs hold it."""

    POSE = (0, 1, 2, 3, 4, 5)
    SCHOENFLIES = (2, 3, 4, 5)
    POINT = (3, 4, 5)
    PLANE = (2, 3, 4)
    PLANE_POINT = (3, 4)

    @property
    def columns(self) -> list[int]:
        """Of twists."""
        return list(self.value)

    @property
    def angles(self) -> int:
        """How many of them are rotations."""
        return sum(k < 3 for k in self.value)


def _directions(name: str, value: ArrayLike, m: int) -> Floats:
    """(m, 3) unit directions, one for all or one for each."""
    found = spread(name, value, (m, 3))
    size = np.linalg.norm(found, axis=1, keepdims=True)
    if not (size > 0).all():
        raise InputError("input.positive", name=name, value=size.ravel().tolist())
    return found / size


@dataclass(frozen=True, eq=False)
class RodRobot:
    """A platform on m rods with one motor each; m is the number of motions of the platform.

    Attributes:
        motion: of the platform.
        drive: of the motors.
        base: (m, 3) places a of the motors [m].
        rods: (m,) lengths l [m]; of rods that motors extend those at q = 0.
        rotating, fixed: (m, 3) parts c and b of the ends on the platform [m].
        axes: (m, 3) unit axes of cranks, directions of slides.
        arms: (m,) lengths L of cranks [m].
        zeros: (m, 3) unit directions e of cranks at angle 0, normal to the axes.
    """

    motion: PlatformMotion
    drive: LegDrive
    base: Floats
    rods: Floats
    rotating: Floats
    fixed: Floats
    axes: Floats = field(default_factory=lambda: frozen(Z))
    arms: Floats = field(default_factory=lambda: frozen(np.ones(())))
    zeros: Floats = field(default_factory=lambda: frozen((1.0, 0.0, 0.0)))

    def __post_init__(self) -> None:
        m = len(self.motion.value)
        found = {"base": single("base", self.base, (m, 3))}
        found |= {name: spread(name, getattr(self, name), (m, 3)) for name in ("rotating", "fixed")}
        found |= {name: spread(name, getattr(self, name), (m,)) for name in ("rods", "arms")}
        for name in ("rods", "arms"):
            if not (found[name] > 0).all() and (name, self.drive) != ("rods", LegDrive.EXTEND):
                raise InputError("input.positive", name=name, value=found[name].tolist())
        axes, zeros = _directions("axes", self.axes, m), _directions("zeros", self.zeros, m)
        if self.drive is LegDrive.CRANK:
            across = zeros - (zeros * axes).sum(axis=1, keepdims=True) * axes
            zeros = _directions("zeros", across, m)
        for name, value in (found | {"axes": axes, "zeros": zeros}).items():
            object.__setattr__(self, name, frozen(value))

    @property
    def is_flat(self) -> bool:
        """Whether it moves in the plane of x and y."""
        return self.motion in (PlatformMotion.PLANE, PlatformMotion.PLANE_POINT)

    @property
    def m(self) -> int:
        """Number of legs, and of motions."""
        return len(self.base)

    @property
    def size(self) -> float:
        """Longest rod, with its crank [m]: lengths are judged over it."""
        arms = self.arms if self.drive is LegDrive.CRANK else np.zeros(self.m)
        reach = np.linalg.norm(self.base - self.base.mean(axis=0), axis=1).max()
        return float(reach if self.drive is LegDrive.EXTEND else (self.rods + arms).max()) or 1.0

    def poses(self, x: ArrayLike) -> Floats:
        """(*batch, 4, 4) poses, of poses or of short coordinates: (x, y, z), (x, y), (x, y, phi), (x, y, z, phi)."""
        given = real_array("x", x)
        if given.shape[-2:] == (4, 4):
            return pose.check(given, "x")
        size = {PlatformMotion.POSE: 16}.get(self.motion, self.m)
        value = as_batch("x", given, (size,), finite=True, hint="" if size < 16 else "(4, 4)")
        T = np.zeros((*value.shape[:-1], 4, 4))
        T[...] = np.eye(4)
        turns = self.motion.angles
        T[..., : size - turns, 3] = value[..., : size - turns]
        if turns:
            T[..., :3, :3] = rotation.exp(value[..., -1:] * Z)
        return T

    def coordinates(self, T: Floats) -> Floats:
        """Short coordinates (*batch, m) of poses; of six motions the poses themselves."""
        if self.motion is PlatformMotion.POSE:
            return T
        p = T[..., : self.m - self.motion.angles, 3]
        phi = np.arctan2(T[..., 1, 0], T[..., 0, 0])[..., None]
        return np.concatenate([p, phi], axis=-1) if self.motion.angles else p

    def ends(self, x: ArrayLike) -> Floats:
        """(*batch, m, 3) ends B of the rods on the platform [m]."""
        T = self.poses(x)
        return self.rotating @ np.swapaxes(T[..., :3, :3], -1, -2) + T[..., None, :3, 3] + self.fixed

    def carriers(self, q: ArrayLike) -> Floats:
        """(*batch, m, 3) ends C of the rods on the motors [m], at coordinates (*batch, m) [rad | m]."""
        value = as_batch("q", q, (self.m,), finite=True)[..., None]
        if self.drive is LegDrive.EXTEND:
            return np.broadcast_to(self.base, (*value.shape[:-1], 3)).copy()
        if self.drive is LegDrive.LINEAR:
            return self.base + value * self.axes
        radians("q", value)
        return self.base + self.arms[:, None] * (np.cos(value) * self.zeros + np.sin(value) * self._sides)

    @cached_property
    def _sides(self) -> Floats:
        """(m, 3) directions of the cranks at a quarter turn."""
        return np.cross(self.axes, self.zeros)

    def lengths(self, q: ArrayLike) -> Floats:
        """(*batch, m) of the rods at coordinates of the motors [m]."""
        value = as_batch("q", q, (self.m,), finite=True)
        return self.rods + value if self.drive is LegDrive.EXTEND else np.broadcast_to(self.rods, value.shape)

    def inverse_kinematics(self, x: ArrayLike) -> MotorAngles:
        """Both coordinates of each motor for poses or short coordinates: `q` (*batch, m, 2), with what rods miss.

        Of slides the one farther along its direction first, of cranks the one whose elbow is to the left of the line
        from motor to end, seen against the axis. Extended rods have one length, twice.
        """
        way = self.ends(x) - self.base
        if self.drive is LegDrive.CRANK:
            along, up, across = ((way * e).sum(axis=-1) for e in (self.zeros, self._sides, self.axes))
            return crank_angles(along, up, np.abs(across), self.arms, self.rods)
        none = np.zeros(way.shape[:-1], dtype=np.bool_)
        if self.drive is LegDrive.EXTEND:
            s = np.linalg.norm(way, axis=-1) - self.rods
            return MotorAngles(np.stack([s, s], axis=-1), 0.0 * s, none, "m")
        along = (way * self.axes).sum(axis=-1)
        aside = np.linalg.norm(way - along[..., None] * self.axes, axis=-1)
        reach = np.sqrt(np.maximum((self.rods - aside) * (self.rods + aside), 0.0))
        misfit: Floats = np.maximum(aside - self.rods, 0.0)
        return MotorAngles(np.stack([along + reach, along - reach], axis=-1), misfit, none, "m")

    def branch(self, x: ArrayLike, second: ArrayLike = False) -> Floats:
        """(*batch, m) one coordinate of each motor, the first of both.

        Args:
            x: poses or short coordinates.
            second: whether the second one instead, of all motors or of each.

        Raises:
            InputError: a rod does not reach; `inverse_kinematics` says which in a batch.
        """
        found = self.inverse_kinematics(x)
        if not found:
            row, leg = np.argwhere(found.misfit.reshape(-1, self.m))[0]
            length = float(np.abs(found.misfit.reshape(-1, self.m)[row, leg]))
            reached = int(found.reached.sum())
            raise InputError(
                "parallel.rod_out_of_reach", row=int(row), motor=int(leg) + 1, length=length, reached=reached,
                rows=found.reached.size,
            )  # fmt: skip
        chosen = np.broadcast_to(np.asarray(second, dtype=np.bool_), found.q.shape[:-1])
        return np.where(chosen, found.q[..., 1], found.q[..., 0])

    def motor_matrices(self, x: ArrayLike, q: ArrayLike) -> tuple[Floats, Floats]:
        """A and B (*batch, m, m) of A V = B q', V the motions of the platform in {s}.

        Args:
            x, q: poses or short coordinates, and coordinates of the motors (*batch, m) that belong together.

        Raises:
            InputError: a rod has another length there.
        """
        T, value = self.poses(x), as_batch("q", q, (self.m,), finite=True)
        d, l = self.ends(T) - self.carriers(value), self.lengths(value)
        s, u = unit_vectors(d)
        wrong = np.abs(s - l) > OPEN * self.size
        if wrong.any():
            *_, rod = np.argwhere(wrong)[0]
            raise InputError(
                "parallel.rod_wrong", rod=int(rod) + 1, length=float((s - l)[tuple(np.argwhere(wrong)[0])])
            )
        A = self._rows(T, u)
        if self.drive is LegDrive.EXTEND:
            return A, np.broadcast_to(np.eye(self.m), A.shape)
        return A, (u * self.swings(value)).sum(axis=-1)[..., None] * np.eye(self.m)

    def swings(self, q: Floats) -> Floats:
        """(*batch, m, 3) C', velocities of the carriers per rate of their motors."""
        if self.drive is LegDrive.LINEAR:
            return np.broadcast_to(self.axes, (*q.shape, 3))
        angle = q[..., None]
        return self.arms[:, None] * (np.cos(angle) * self._sides - np.sin(angle) * self.zeros)

    def _rows(self, T: Floats, u: Floats) -> Floats:
        r = self.rotating @ np.swapaxes(T[..., :3, :3], -1, -2) + T[..., None, :3, 3]
        return np.concatenate([np.cross(r, u), u], axis=-1)[..., self.motion.columns]

    def jacobian(self, x: ArrayLike, q: ArrayLike) -> Floats:
        """(*batch, m, m) V = J q' of the motions of the platform in {s}: a twist, or the part of it that it has.

        Raises:
            InputError: x and q do not belong together, or A is singular.
        """
        A, B = self.motor_matrices(x, q)
        return np.asarray(np.linalg.solve(require_regular(A), B), dtype=np.float64)

    def efforts(self, x: ArrayLike, q: ArrayLike, F: ArrayLike) -> Floats:
        """(*batch, m) of the motors [N m | N] with which the platform exerts a wrench F (*batch, m) on the world.

        Args:
            x, q: that belong together.
            F: dual to V: (m_x, m_y, m_z, f_x, f_y, f_z), or the part of it that the platform has.
        """
        return resultant(self.jacobian(x, q), F)

    def rod_forces(self, x: ArrayLike, q: ArrayLike, F: ArrayLike) -> Floats:
        """(*batch, m) forces of the rods [N], pushing positive, whose wrench on the platform is F (*batch, m)."""
        return forces_for(self.motor_matrices(x, q)[0], F)

    def singularity(self, x: ArrayLike, q: ArrayLike) -> SingularKinds:
        """First kind: a rod stands across what its motor can do. Second: the platform moves with all motors locked."""
        A, B = self.motor_matrices(x, q)
        return singular_kinds(
            A, B / (self.arms if self.drive is LegDrive.CRANK else 1.0), self.size, self.motion.angles
        )

    def forward_near(self, q: ArrayLike, x_guess: ArrayLike) -> RodPoses:
        """The pose of each row by Newton's method from a first one: `T` (*batch, 1, 4, 4).

        Args:
            q: (*batch, m) coordinates of the motors [rad | m].
            x_guess: poses or short coordinates.
        """
        value, T = as_batch("q", q, (self.m,), finite=True), self.poses(x_guess)
        shape = np.broadcast_shapes(value.shape[:-1], T.shape[:-2])
        T = np.broadcast_to(T, (*shape, 4, 4)).reshape(-1, 4, 4).copy()
        C = np.broadcast_to(self.carriers(value), (*shape, self.m, 3))
        l = np.broadcast_to(self.lengths(value), (*shape, self.m))
        found, miss = self._newton(C.reshape(-1, self.m, 3), l.reshape(-1, self.m), T)
        return RodPoses.of(self, found.reshape(*shape, 1, 4, 4), miss.reshape(*shape, 1), complete=False, single=True)

    def _newton(self, C: Floats, l: Floats, T: Floats) -> tuple[Floats, Floats]:
        """Poses (k, 4, 4) with rods of lengths l (k, m) from C (k, m, 3), and what they miss at most (k,) [m]."""
        miss = np.full(len(T), np.inf)
        units = np.concatenate([np.ones(self.motion.angles), np.full(self.m - self.motion.angles, self.size)])
        going = np.arange(len(T))
        for _ in range(NEWTON_STEPS):
            d = self.ends(T[going]) - C[going]
            s = np.maximum(np.linalg.norm(d, axis=-1), LEAST_DIVISOR)
            gap = l[going] - s
            miss[going] = np.abs(gap).max(axis=-1)
            on = miss[going] > CLOSED * self.size
            if not on.any():
                break
            going, gap, A = going[on], gap[on], self._rows(T[going], d / s[..., None])[on] * units
            V = np.einsum("kij,kj->ki", np.linalg.pinv(A), gap)
            V *= np.minimum(1.0, LONGEST / np.maximum(np.abs(V).max(axis=-1, keepdims=True), LEAST_DIVISOR))
            twist = np.zeros((len(V), 6))
            twist[:, self.motion.columns] = V * units
            T[going] = pose.exp(twist) @ T[going]
        return T, miss

    def forward_kinematics(self, q: ArrayLike) -> RodPoses:
        """All poses for coordinates of the motors (*batch, m), in no particular order.

        Closed forms or polynomials for points and planes, all forty by continuation for six rods; four rods of an
        articulated plate by a search, which proves nothing about others.
        """
        value = as_batch("q", q, (self.m,), finite=True)
        C, l = self.carriers(value).reshape(-1, self.m, 3), self.lengths(value).reshape(-1, self.m).copy()
        match self.motion:
            case PlatformMotion.POINT | PlatformMotion.PLANE_POINT:
                p = crossing_of_spheres(C - self.fixed, l)
                T = np.tile(np.eye(4), (*p.shape[:2], 1, 1))
                T[..., :3, 3] = p
            case PlatformMotion.PLANE:
                ends = np.broadcast_to(self.rotating[:, :2], (len(C), 3, 2))
                T = self.poses_or_nan(planar_poses((C - self.fixed)[..., :2], ends, l, self.size, (len(C),)).x)
            case PlatformMotion.POSE:
                T = self._stewart_poses(C, l)
            case PlatformMotion.SCHOENFLIES:
                T = search_poses(self, C, l, self._newton)
        miss = np.abs(np.linalg.norm(self.ends_or_nan(T) - C[:, None], axis=-1) - l[:, None]).max(axis=-1)
        shape = value.shape[:-1]
        T, miss = T.reshape(*shape, *T.shape[1:]), miss.reshape(*shape, *miss.shape[1:])
        return RodPoses.of(self, T, miss, complete=self.motion is not PlatformMotion.SCHOENFLIES)

    def _stewart_poses(self, C: Floats, l: Floats) -> Floats:
        rows = [
            StewartPlatform(c - self.fixed, self.rotating).forward_kinematics(s).T for c, s in zip(C, l, strict=True)
        ]
        most = max((len(each) for each in rows), default=0)
        found = np.full((len(C), most, 4, 4), np.nan)
        for k, each in enumerate(rows):
            found[k, : len(each)] = each
        return found

    def poses_or_nan(self, x: Floats) -> Floats:
        """Poses (..., 4, 4) of short coordinates (..., m), NaN where these are."""
        T = self.poses(np.nan_to_num(x))
        T[np.isnan(x).any(axis=-1)] = np.nan
        return T

    def ends_or_nan(self, T: Floats) -> Floats:
        """(..., m, 3) ends of poses (..., 4, 4) that may be NaN."""
        R = np.swapaxes(T[..., :3, :3], -1, -2)
        return self.rotating @ R + T[..., None, :3, 3] + self.fixed
