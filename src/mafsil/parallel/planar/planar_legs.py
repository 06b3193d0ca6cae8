"""Planar platforms on three legs, RPR and RRR: motors, all poses, rates, forces and singularities.

A pose is (x, y, phi), a twist (omega_z, v_x, v_y) and a wrench (m_z, f_x, f_y), both in {s} about its origin.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, frozen, single
from mafsil.errors import InputError
from mafsil.parallel.legs.leg_lines import forces_for, rates, require_regular, require_rods, resultant, unit_vectors
from mafsil.parallel.planar.five_bar import MotorAngles, crank_angles
from mafsil.parallel.planar.planar_platform import FITS, all_poses, leg_vectors, sextic
from mafsil.parallel.planar.planar_poses import PlanarPoses
from mafsil.parallel.platforms.nearest_lengths import LegEnds
from mafsil.parallel.singular_kinds import SingularKinds, singular_kinds

SHORT = 1e-3
"""Of a leg, over the size."""


def planar_line_matrix(points: Floats, directions: Floats) -> Floats:
    """(*batch, 3, 3) rows (q x u, u) of lines in the plane, the moment about the origin first."""
    q, u = np.broadcast_arrays(points, directions)
    moment = q[..., 0] * u[..., 1] - q[..., 1] * u[..., 0]
    return np.concatenate([moment[..., None], u], axis=-1)


@dataclass(frozen=True, eq=False)
class PlanarThreeRPR:
    """A planar platform on three legs that extend: hinge, slider, hinge.

    Attributes:
        base: (3, 2) hinges a_i on the base, in {s} [m].
        platform: (3, 2) hinges b_i on the platform, in {b} [m].
    """

    base: Floats
    platform: Floats

    def __post_init__(self) -> None:
        for name in ("base", "platform"):
            object.__setattr__(self, name, frozen(single(name, getattr(self, name), (3, 2))))

    @cached_property
    def size(self) -> float:
        """Largest distance of two hinges of one body [m]."""
        return _size(self.base, self.platform)

    def leg_vectors(self, x: ArrayLike) -> Floats:
        """(*batch, 3, 2) d_i = p + R b_i - a_i [m] at poses x (*batch, 3)."""
        return leg_vectors(self.base, self.platform, as_batch("x", x, (3,), finite=True))[0]

    def lengths(self, x: ArrayLike, signed: bool = False) -> Floats:
        """(*batch, 3) lengths of the legs at poses (x, y, phi) (*batch, 3) [m, rad]: inverse kinematics.

        Args:
            x: (*batch, 3) poses.
            signed: both branches, (*batch, 3, 2): s_i, and -s_i of a slider that passes through its hinge.
        """
        s = np.linalg.norm(self.leg_vectors(x), axis=-1)
        return np.stack([s, -s], axis=-1) if signed else s

    def inverse_kinematics(self, x: ArrayLike) -> Floats:
        """(*batch, 3) `lengths` of the legs [m] at poses (*batch, 3), under the name that all robots have."""
        return self.lengths(x)

    def forward_kinematics(self, lengths: ArrayLike, signed: bool = False) -> PlanarPoses:
        """All poses for given lengths, six at most, through the sextic.

        Args:
            lengths: (*batch, 3) of the legs [m].
            signed: take negative lengths too, of sliders that pass through their hinge: the poses are the same.

        Raises:
            InputError: a length is negative and not `signed`.
        """
        s = as_batch("lengths", lengths, (3,), finite=True)
        if not signed and (s < 0).any():
            raise InputError("parallel.negative_length", value=float(s.min()))
        rows = np.abs(s.reshape(-1, 3))
        a, b = (np.broadcast_to(each, (len(rows), 3, 2)) for each in (self.base, self.platform))
        return planar_poses(a, b, rows, self.size, s.shape[:-1])

    def sextic(self, lengths: ArrayLike) -> Floats:
        """(*batch, 7) coefficients of the polynomial in tan(phi / 2), ascending, largest of absolute value one."""
        s = as_batch("lengths", lengths, (3,), finite=True)
        rows = s.reshape(-1, 3) / self.size
        a, b = (np.broadcast_to(each / self.size, (len(rows), 3, 2)) for each in (self.base, self.platform))
        return sextic(a, b, rows).reshape(*s.shape[:-1], 7)

    def jacobian(self, x: ArrayLike) -> Floats:
        """(*batch, 3, 3) G with s' = G V, by the lines of the legs: rows (a_i x u_i, u_i).

        Raises:
            InputError: a leg has length zero.
        """
        return planar_line_matrix(self.base, unit_vectors(self.leg_vectors(x))[1])

    def leg_rates(self, x: ArrayLike, V: ArrayLike) -> Floats:
        """(*batch, 3) rates of the lengths [m/s] for twists (*batch, 3)."""
        return rates(self.jacobian(x), V)

    def wrench(self, x: ArrayLike, forces: ArrayLike) -> Floats:
        """(*batch, 3) wrench of the legs on the platform for their forces (*batch, 3) [N], pushing positive."""
        return resultant(self.jacobian(x), forces)

    def leg_forces(self, x: ArrayLike, F: ArrayLike) -> Floats:
        """(*batch, 3) forces of the legs [N] whose wrench on the platform is F (*batch, 3).

        Args:
            x: (*batch, 3) poses.
            F: (*batch, 3) wrenches (m_z, f_x, f_y) in {s}.

        Raises:
            InputError: a pose is singular, so that some wrench needs forces without bound.
        """
        return forces_for(self.jacobian(x), F)

    def singularity(self, x: ArrayLike) -> SingularKinds:
        """Kind of singularity: the second where the lines of the legs meet in a point or are parallel."""
        G = self.jacobian(x)
        return singular_kinds(G, np.broadcast_to(np.eye(3), G.shape), self.size, 1)

    def second_order(self, x: ArrayLike, V: ArrayLike, w: ArrayLike) -> Floats:
        """(*batch,) w . s'' along the motion exp(t V): how the lengths bend where w . s' = 0 for every motion.

        Not zero at a singular pose with its free motion V and internal forces w: the free motion ends at once, the
        structure is shaky but cannot move (nondegenerate). Zero: higher orders decide.

        Args:
            x: (*batch, 3) poses.
            V: (*batch, 3) twists.
            w: (*batch, 3) weights of the legs.
        """
        twist, weights, d = as_batch("V", V, (3,)), as_batch("w", w, (3,)), self.leg_vectors(x)
        s, u = unit_vectors(d)
        end, turn = self.base + d, twist[..., None, :1]
        moving = twist[..., None, 1:] + turn * np.stack([-end[..., 1], end[..., 0]], axis=-1)
        bending = turn * np.stack([-moving[..., 1], moving[..., 0]], axis=-1)
        along = (u * moving).sum(axis=-1)
        second = ((moving**2).sum(axis=-1) - along**2) / s + (u * bending).sum(axis=-1)
        return (weights * second).sum(axis=-1)

    def motor_matrices(self, x: ArrayLike) -> tuple[Floats, Floats]:
        """A and B (*batch, 3, 3) of A V = B q' if the hinges on the base are driven and the sliders are free.

        Across a leg its end moves by its length times the rate of the hinge: rows (a_i x n_i + s_i, n_i), with n_i
        to the left of u_i.
        """
        s, u = unit_vectors(self.leg_vectors(x))
        n = np.stack([-u[..., 1], u[..., 0]], axis=-1)
        ends = self.base + self.leg_vectors(x)
        return planar_line_matrix(ends, n), s[..., None] * np.eye(3)


@dataclass(frozen=True, eq=False)
class PlanarThreeRRR:
    """A planar platform on three legs of two links with motors on the base.

    Attributes:
        base: (3, 2) motors a_i, in {s} [m].
        platform: (3, 2) hinges b_i on the platform, in {b} [m].
        cranks: (3,) lengths of the driven links [m].
        rods: (3,) lengths of the others [m].
    """

    base: Floats
    platform: Floats
    cranks: Floats
    rods: Floats

    def __post_init__(self) -> None:
        for name, shape in (("base", (3, 2)), ("platform", (3, 2)), ("cranks", (3,)), ("rods", (3,))):
            object.__setattr__(self, name, frozen(single(name, getattr(self, name), shape)))
        for name in ("cranks", "rods"):
            if not (getattr(self, name) > 0).all():
                raise InputError("input.positive", name=name, value=getattr(self, name).tolist())

    @cached_property
    def size(self) -> float:
        """Largest distance of two hinges of one body, cranks and rods included [m]."""
        return max(_size(self.base, self.platform), float(self.cranks.max()), float(self.rods.max()))

    def elbows(self, q: ArrayLike) -> Floats:
        """(*batch, 3, 2) ends of the cranks at angles q (*batch, 3) [rad]."""
        angle = as_batch("q", q, (3,), finite=True)
        return self.base + self.cranks[:, None] * np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    def ends(self, x: ArrayLike) -> Floats:
        """(*batch, 3, 2) hinges of the platform in {s} at poses (*batch, 3)."""
        return leg_vectors(np.zeros((3, 2)), self.platform, as_batch("x", x, (3,), finite=True))[0]

    def inverse_kinematics(self, x: ArrayLike) -> MotorAngles:
        """Both angles of each crank at poses (*batch, 3): elbow left of the line from motor to platform first."""
        along = self.ends(x) - self.base
        return crank_angles(along[..., 0], along[..., 1], 0.0, self.cranks, self.rods)

    def forward_kinematics(self, q: ArrayLike) -> PlanarPoses:
        """All poses at angles of the cranks (*batch, 3), six at most: the platform is held by three distances."""
        angle = as_batch("q", q, (3,), finite=True)
        elbows = self.elbows(angle).reshape(-1, 3, 2)
        b, s = np.broadcast_to(self.platform, elbows.shape), np.broadcast_to(self.rods, elbows.shape[:-1])
        return planar_poses(elbows, b, s, self.size, angle.shape[:-1])

    def motor_matrices(self, x: ArrayLike, q: ArrayLike) -> tuple[Floats, Floats]:
        """A and B (*batch, 3, 3) of A V = B q': along a rod both of its ends move alike.

        Args:
            x: (*batch, 3) poses.
            q: (*batch, 3) angles of the cranks that belong to them.

        Raises:
            InputError: they do not.
        """
        elbows = self.elbows(q)
        rods = self.ends(x) - elbows
        require_rods(rods, self.rods)
        _, u = unit_vectors(rods)
        arm = elbows - self.base
        along = arm[..., 0] * u[..., 1] - arm[..., 1] * u[..., 0]
        return planar_line_matrix(elbows, u), along[..., None] * np.eye(3)

    def jacobian(self, x: ArrayLike, q: ArrayLike) -> Floats:
        """(*batch, 3, 3) of V = J q' with the twist (omega_z, v_x, v_y) in {s}.

        Args:
            x, q: (*batch, 3) poses and angles that belong together.

        Raises:
            InputError: they do not, or the lines of the rods meet in a point or are parallel.
        """
        A, B = self.motor_matrices(x, q)
        return np.asarray(np.linalg.solve(require_regular(A), B), dtype=np.float64)

    def torques(self, x: ArrayLike, q: ArrayLike, F: ArrayLike) -> Floats:
        """(*batch, 3) efforts of the motors [N m] with which the platform exerts a wrench F (*batch, 3) in {s}.

        Args:
            x, q: (*batch, 3) poses and angles that belong together.
            F: (*batch, 3) wrenches (m_z, f_x, f_y).

        Raises:
            InputError: as `jacobian`.
        """
        return resultant(self.jacobian(x, q), F)

    def singularity(self, x: ArrayLike, q: ArrayLike) -> SingularKinds:
        """First kind: a leg is stretched or folded. Second: the lines of the rods meet in a point or are parallel."""
        A, B = self.motor_matrices(x, q)
        return singular_kinds(A, B / self.cranks, self.size, 1)


def planar_poses(a: Floats, b: Floats, s: Floats, size: float, shape: tuple[int, ...]) -> PlanarPoses:
    """All poses of bodies (k, 3, 2) at distances s (k, 3) from points (k, 3, 2), as an answer of a batch."""
    middle, centre = a.mean(axis=1, keepdims=True), b.mean(axis=1, keepdims=True)
    scale = np.maximum(size, s.max(axis=1, initial=0.0))[:, None]
    found, several, movable = all_poses((a - middle) / scale[..., None], (b - centre) / scale[..., None], s / scale)
    found[..., :2] *= scale[..., None]
    c, z = np.cos(found[..., 2]), np.sin(found[..., 2])
    turned = np.stack([c * centre[..., 0] - z * centre[..., 1], z * centre[..., 0] + c * centre[..., 1]], axis=-1)
    found[..., :2] += middle - turned
    # Newton's method loses double poses with a short leg, whose direction is hardly known; least squares do not.
    lost = np.flatnonzero(~np.isfinite(found[..., 2]).any(axis=1) & ~movable & (s.min(axis=1) < SHORT * scale[:, 0]))
    near = LegEnds(a[lost], b[lost], s[lost]).nearest()
    fits = near.distance <= FITS * scale[lost, 0]
    found[lost[fits], 0], several[lost[fits], 0] = near.x[fits], 2
    count = np.isfinite(found[..., 2]).sum(axis=1)
    found, several = found[:, : int(count.max(initial=0))], several[:, : int(count.max(initial=0))]
    d, _ = leg_vectors(a[:, None], b[:, None], found)
    error = float(np.nan_to_num(np.abs(np.linalg.norm(d, axis=-1) - s[:, None])).max(initial=0.0))
    legs = LegEnds(a.reshape(*shape, 3, 2), b.reshape(*shape, 3, 2), s.reshape(*shape, 3))
    return PlanarPoses(
        found.reshape(*shape, *found.shape[1:]), count.reshape(shape), several.reshape(*shape, found.shape[1]),
        movable.reshape(shape), error, legs,
    )  # fmt: skip


def _size(base: Floats, platform: Floats) -> float:
    spread = max(float(np.linalg.norm(p[:, None] - p, axis=-1).max()) for p in (base, platform))
    return spread if spread > 0 else 1.0
