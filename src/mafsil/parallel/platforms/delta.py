"""The Delta robot: three motors on a plate move a platform that never turns; closed forms both ways.

Leg k lies in the plane through z at the angle g_k, with u_k = (cos g_k, sin g_k, 0). Its elbow, moved inwards by the
radius of the platform, is C_k = (r_b - r_p + L cos q_k) u_k - L sin q_k z, and |p - C_k| = l. Positive angles swing the
arm down; the plate is above, the platform at negative z.

Reference: Clavel, Conception d'un robot parallele rapide a quatre degres de liberte, EPFL 1991.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, positive, radians
from mafsil.errors import InputError
from mafsil.mobility.spaces.planar_positions import wrap_angle
from mafsil.parallel.legs.leg_lines import forces_for, require_regular, require_rods
from mafsil.parallel.planar.five_bar import MotorAngles, crank_angles
from mafsil.parallel.platforms.nearest_lengths import LegEnds
from mafsil.parallel.platforms.platform_points import PlatformPoints
from mafsil.parallel.singular_kinds import SingularKinds, singular_kinds

TOUCHING = 1e-13
"""Squares below it, over the largest, are rounding: spheres that nearly touch do, arms that nearly reach do."""


@dataclass(frozen=True)
class DeltaRobot:
    """A Delta robot with three legs at thirds of a turn.

    Attributes:
        base: radius of the circle of the motors [m].
        platform: radius of the circle of the lower ends of the forearms [m].
        arm: length L of the driven links [m].
        forearm: length l of the parallelograms of rods [m].
    """

    base: float
    platform: float
    arm: float
    forearm: float

    def __post_init__(self) -> None:
        for name in ("base", "platform", "arm", "forearm"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))

    @property
    def offset(self) -> float:
        """Radius of the base less that of the platform [m]."""
        return self.base - self.platform

    @cached_property
    def directions(self) -> Floats:
        """(3, 3) the outward directions u_k of the legs."""
        angle = 2 * np.pi * np.arange(3) / 3
        return np.stack([np.cos(angle), np.sin(angle), np.zeros(3)], axis=-1)

    def elbows(self, q: ArrayLike) -> Floats:
        """(*batch, 3, 3) centres C_k of the spheres on which p lies [m], at angles (*batch, 3) [rad]."""
        angle = radians("q", as_batch("q", q, (3,), finite=True))
        found = (self.offset + self.arm * np.cos(angle))[..., None] * self.directions
        found[..., 2] -= self.arm * np.sin(angle)
        return found

    def inverse_kinematics(self, p: ArrayLike) -> MotorAngles:
        """Both angles of each motor for places p (*batch, 3): the knee outside first, as the robot is built."""
        place = as_batch("p", p, (3,), finite=True)
        along = place @ self.directions.T
        across = np.sqrt(np.maximum((place[..., 0] ** 2 + place[..., 1] ** 2)[..., None] - along**2, 0.0))
        # Angles swing the arm down: the plane is seen from the side on which they are positive, and left is inside.
        down = np.broadcast_to(-place[..., 2:], along.shape)
        found = crank_angles(along - self.offset, down, across, self.arm, np.full(3, self.forearm))
        return MotorAngles(found.q[..., ::-1], found.misfit, found.free)

    def forward_kinematics(self, q: ArrayLike) -> PlatformPoints:
        """Both places of the platform at angles (*batch, 3), the lower first.

        Three spheres of one radius meet on the line through the middle of the circle of their centres. Where they do
        not, the place is that nearest to all three, and `missing` says how far the lengths are off.
        """
        C = self.elbows(q)
        u, v = C[..., 1, :] - C[..., 0, :], C[..., 2, :] - C[..., 0, :]
        n = np.cross(u, v)
        n2, u2, v2 = ((w**2).sum(axis=-1, keepdims=True) for w in (n, u, v))
        spread = n2 > 0.0
        area = np.where(spread, n2, 1.0)
        to_middle = (np.cross(n, u) * v2 + np.cross(v, n) * u2) / (2 * area)
        h2 = (self.forearm**2 - (to_middle**2).sum(axis=-1, keepdims=True)) / area
        small = TOUCHING * self.forearm**2 / area
        h = np.sqrt(np.where(np.abs(h2) < small, 0.0, np.maximum(h2, 0.0)))
        middle = C[..., 0, :] + to_middle
        ends = np.stack([middle - h * n, middle + h * n], axis=-2)
        # Where two elbows coincide and the third is in reach, a circle of places is left.
        apart = np.sqrt(np.concatenate([u2, v2, ((v - u) ** 2).sum(axis=-1, keepdims=True)], axis=-1))
        near, far = apart.min(axis=-1) <= TOUCHING * self.forearm, apart.max(axis=-1) <= 2 * self.forearm
        free = np.asarray(near & far, dtype=np.bool_)
        if free.any():
            ends[free] = self._circle_ends(C[free])
        order = np.argsort(ends[..., 2], axis=-1)
        legs = LegEnds(C, np.zeros_like(C), np.full(C.shape[:-1], self.forearm))
        meets = np.asarray((spread & (h2 > -small))[..., 0] | free, dtype=np.bool_)
        return PlatformPoints(np.take_along_axis(ends, order[..., None], axis=-2), meets, free, legs)

    def _circle_ends(self, C: Floats) -> Floats:
        """(k, 2, 3) lowest and highest place of the circle about elbows (k, 3, 3) of which two or all coincide."""
        away = C - C[:, :1]
        across = away[np.arange(len(C)), np.linalg.norm(away, axis=-1).argmax(axis=1)]
        d2 = (across**2).sum(axis=-1, keepdims=True)
        axis = across / np.sqrt(np.where(d2 > 0.0, d2, 1.0))
        up = np.array([0.0, 0.0, 1.0]) - axis[:, 2:] * axis
        level = np.linalg.norm(up, axis=-1, keepdims=True) <= TOUCHING
        up = np.where(level, np.array([1.0, 0.0, 0.0]), up)
        up *= np.sqrt(np.maximum(self.forearm**2 - d2 / 4, 0.0)) / np.linalg.norm(up, axis=-1, keepdims=True)
        middle = C[:, 0] + across / 2
        return np.stack([middle - up, middle + up], axis=1)

    def motor_matrices(self, q: ArrayLike, p: ArrayLike) -> tuple[Floats, Floats]:
        """W and B (*batch, 3, 3) of W p' = B q': rows (p - C_k)' and (p - C_k) . dC_k/dq_k.

        Args:
            q, p: (*batch, 3) angles and places that belong together.

        Raises:
            InputError: they do not.
        """
        angle = as_batch("q", q, (3,))
        rods = as_batch("p", p, (3,))[..., None, :] - self.elbows(angle)
        require_rods(rods, self.forearm)
        swing = -np.sin(angle)[..., None] * self.directions
        swing[..., 2] -= np.cos(angle)
        return rods, (self.arm * (rods * swing).sum(axis=-1))[..., None] * np.eye(3)

    def jacobian(self, q: ArrayLike, p: ArrayLike) -> Floats:
        """(*batch, 3, 3) of p' = J q'; the platform does not turn.

        Args:
            q, p: (*batch, 3) angles and places that belong together.

        Raises:
            InputError: they do not, or the forearms lie in one plane.
        """
        W, B = self.motor_matrices(q, p)
        return np.asarray(np.linalg.solve(require_regular(W), B), dtype=np.float64)

    def torques(self, q: ArrayLike, p: ArrayLike, force: ArrayLike) -> Floats:
        """(*batch, 3) efforts of the motors [N m] that push the platform with a force (*batch, 3) [N].

        Args:
            q, p: (*batch, 3) angles and places that belong together.
            force: (*batch, 3) that the platform exerts [N].

        Raises:
            InputError: they do not, or the forearms lie in one plane.
        """
        W, B = self.motor_matrices(q, p)
        along_rods = forces_for(W, as_batch("force", force, (3,)))
        return np.einsum("...ii,...i->...i", B, along_rods)

    def singularity(self, q: ArrayLike, p: ArrayLike) -> SingularKinds:
        """First kind: a forearm stands across the swing of its elbow. Second: the forearms lie in one plane."""
        W, B = self.motor_matrices(q, p)
        return singular_kinds(W / self.forearm, B / (self.arm * self.forearm), 1.0, 0)


@dataclass(frozen=True)
class Eclipse:
    """The Eclipse machine: three columns that go round on a circle and carry blocks up and down, rods, a platform.

    Attributes:
        guide: radius of the circle [m].
        rod: length of the rods [m].
        platform: radius of the circle of the joints of the platform [m], at thirds of a turn in {b}.
    """

    guide: float
    rod: float
    platform: float

    def __post_init__(self) -> None:
        for name in ("guide", "rod", "platform"):
            object.__setattr__(self, name, positive(name, getattr(self, name)))

    def platform_joints(self, T: ArrayLike) -> Floats:
        """(*batch, 3, 3) places B_k of the spherical joints in {s} at poses T (*batch, 4, 4)."""
        pose_sb = as_batch("T", T, (4, 4), finite=True)
        angle = 2 * np.pi * np.arange(3) / 3
        b = self.platform * np.stack([np.cos(angle), np.sin(angle), np.zeros(3)], axis=-1)
        return b @ np.swapaxes(pose_sb[..., :3, :3], -1, -2) + pose_sb[..., None, :3, 3]

    def rod_misfit(self, T: ArrayLike, far: bool = False) -> Floats:
        """(*batch, 3) by how much the rod of each leg is too short to reach the platform; zero where it does [m].

        Args:
            T: (*batch, 4, 4) poses.
            far: columns on the far side of the axis.
        """
        B = self.platform_joints(T)
        rho = np.hypot(B[..., 0], B[..., 1]) * (-1.0 if far else 1.0)
        return np.maximum(np.abs(self.guide - rho) - self.rod, 0.0)

    def inverse_kinematics(self, T: ArrayLike, upper: bool = False, far: bool = False) -> Floats:
        """(*batch, 3, 2) angle on the circle [rad] and height of the block [m] of each leg.

        There are four solutions for each leg, 64 in all: block above or below the joint, column near it or across.

        Args:
            T: (*batch, 4, 4) poses.
            upper: blocks above the joints of the platform.
            far: columns on the far side of the axis.

        Raises:
            InputError: a rod does not reach; `rod_misfit` says which and by how much, for whole batches.
        """
        missing = self.rod_misfit(T, far)
        if (missing > TOUCHING * self.rod).any():
            *_, leg = np.unravel_index(int(missing.argmax()), missing.shape)
            raise InputError("parallel.rod_of_leg_short", leg=int(leg) + 1, length=float(missing.max()))
        B = self.platform_joints(T)
        rho = np.hypot(B[..., 0], B[..., 1]) * (-1.0 if far else 1.0)
        gamma = np.arctan2(B[..., 1], B[..., 0]) + (np.pi if far else 0.0)
        aside = self.guide - rho
        drop = np.sqrt(np.maximum((self.rod - aside) * (self.rod + aside), 0.0))
        return np.stack([wrap_angle(gamma), B[..., 2] + (drop if upper else -drop)], axis=-1)

    def feet(self, T: ArrayLike) -> Floats:
        """(*batch, 3, 3) places of the hinges on the blocks in {s}, on the near side with blocks below."""
        found = self.inverse_kinematics(T)
        gamma = found[..., 0]
        around = self.guide * np.stack([np.cos(gamma), np.sin(gamma)], axis=-1)
        return np.concatenate([around, found[..., 1:]], axis=-1)
