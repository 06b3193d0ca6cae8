"""The spherical platform 3-RRR, as the Agile Eye: three motors turn a body about one point.

Leg i: the motor turns about u_i, its link carries the axis w_i at the angle alpha_1 from u_i, the second link holds the
platform's axis y_i = R v_i at the angle alpha_2 from w_i:

    w_i(q_i) . R v_i = cos alpha_2,    (w_i x y_i) . omega = (w_i' . y_i) q_i'.

References: Gosselin and Hamel, The agile eye, ICRA 1994; Bonev, Chablat and Wenger, Working and assembly modes of the
Agile Eye, ICRA 2006.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, frozen, single, spread
from mafsil.errors import InputError
from mafsil.geometry import rotation
from mafsil.mobility.spaces.planar_positions import wrap_angle
from mafsil.parallel.legs.leg_lines import require_regular, resultant
from mafsil.parallel.legs.rod_poses import RodPoses
from mafsil.parallel.planar.five_bar import MotorAngles
from mafsil.parallel.singular_kinds import SingularKinds, singular_kinds
from mafsil.parallel.tolerances import FEASIBLE, OPEN, SAME

MOST = 8
"""Orientations: three quadrics in the four homogeneous coordinates of a quaternion meet in eight points."""
STARTS = 160
STEPS = 25
LONGEST = 0.5
"""Of a Newton step [rad]."""
SIZE = 1.0
"""Angles have no unit of length."""


@dataclass(frozen=True, eq=False)
class SphericalPlatform:
    """A body on three legs RRR whose axes all meet in one point.

    Attributes:
        motors: (3, 3) unit axes u of the motors in {s}.
        zeros: (3, 3) unit directions, normal to them, towards which the first links lean at angle 0.
        platform: (3, 3) unit axes v on the platform in {b}.
        first, second: (3,) angles alpha_1 and alpha_2 of the links, between 0 and pi [rad].
    """

    motors: Floats
    zeros: Floats
    platform: Floats
    first: Floats
    second: Floats

    def __post_init__(self) -> None:
        u, e, v = (single(name, getattr(self, name), (3, 3)) for name in ("motors", "zeros", "platform"))
        for name, rows in (("motors", u), ("platform", v), ("zeros", np.cross(u, e))):
            size = np.linalg.norm(rows, axis=1)
            if not (size > 0).all():
                raise InputError("input.positive", name=name, value=size.tolist())
        u, v = (rows / np.linalg.norm(rows, axis=1, keepdims=True) for rows in (u, v))
        e = e - (e * u).sum(axis=1, keepdims=True) * u
        for name, rows in (("motors", u), ("platform", v), ("zeros", e / np.linalg.norm(e, axis=1, keepdims=True))):
            object.__setattr__(self, name, frozen(rows))
        for name in ("first", "second"):
            angle = spread(name, getattr(self, name), (3,))
            if not ((angle > 0) & (angle < np.pi)).all():
                raise InputError("input.range", name=name, value=angle.tolist(), low=0.0, high=np.pi)
            object.__setattr__(self, name, frozen(angle))

    @classmethod
    def agile_eye(cls) -> SphericalPlatform:
        """The Agile Eye: right angles everywhere, isotropic at R = 1 and q = 0."""
        x, y, z = np.eye(3)
        right = np.full(3, np.pi / 2)
        return cls(np.array([x, y, z]), np.array([z, x, y]), np.array([y, z, x]), right, right)

    @property
    def size(self) -> float:
        """One: only angles."""
        return SIZE

    def coordinates(self, T: Floats) -> Floats:
        """Rotations (*batch, 3, 3) of poses."""
        return T[..., :3, :3]

    def elbows(self, q: ArrayLike) -> tuple[Floats, Floats]:
        """Axes w (*batch, 3, 3) between the links, and their derivatives, at angles (*batch, 3) [rad]."""
        angle = as_batch("q", q, (3,), finite=True)[..., None]
        c, s = np.cos(self.first)[:, None], np.sin(self.first)[:, None]
        side = np.cross(self.motors, self.zeros)
        w = c * self.motors + s * (np.cos(angle) * self.zeros + np.sin(angle) * side)
        return w, s * (np.cos(angle) * side - np.sin(angle) * self.zeros)

    def inverse_kinematics(self, R: ArrayLike) -> MotorAngles:
        """Both angles of each motor at orientations (*batch, 3, 3); `misfit` is the angle by which a link misses."""
        y = self.platform @ np.swapaxes(rotation.check(R), -1, -2)
        side = np.cross(self.motors, self.zeros)
        up, a, b = ((y * each).sum(axis=-1) for each in (self.motors, self.zeros, side))
        reach = np.hypot(a, b)
        wanted = (np.cos(self.second) - np.cos(self.first) * up) / np.sin(self.first)
        ratio = np.divide(wanted, reach, out=np.where(wanted > 0, np.inf, -np.inf), where=reach > FEASIBLE)
        free = np.asarray((reach <= FEASIBLE) & (np.abs(wanted) <= FEASIBLE), dtype=np.bool_)
        half = np.arccos(np.clip(np.where(free, 0.0, ratio), -1.0, 1.0))
        middle, lean = np.arctan2(b, a), np.arctan2(reach, up)
        near, far = np.abs(lean - self.first), np.minimum(lean + self.first, 2 * np.pi - lean - self.first)
        misfit = np.maximum(near - self.second, 0.0) - np.maximum(self.second - far, 0.0)
        misfit = np.where(np.abs(misfit) <= FEASIBLE, 0.0, misfit)
        return MotorAngles(wrap_angle(np.stack([middle + half, middle - half], axis=-1)), misfit, free)

    def motor_matrices(self, R: ArrayLike, q: ArrayLike) -> tuple[Floats, Floats]:
        """A and B (*batch, 3, 3) of A omega = B q', rows over the sines of alpha_2.

        Raises:
            InputError: orientations and angles that do not belong together.
        """
        y = self.platform @ np.swapaxes(rotation.check(R), -1, -2)
        w, moved = self.elbows(q)
        off = np.abs((w * y).sum(axis=-1) - np.cos(self.second))
        if (off > OPEN).any():
            *_, leg = np.argwhere(off > OPEN)[0]
            raise InputError("parallel.link_wrong", leg=int(leg) + 1, angle=float(off.max()))
        s = np.sin(self.second)[:, None]
        return np.cross(w, y) / s, ((moved * y).sum(axis=-1, keepdims=True) / s) * np.eye(3)

    def jacobian(self, R: ArrayLike, q: ArrayLike) -> Floats:
        """(*batch, 3, 3) omega = J q' in {s}."""
        A, B = self.motor_matrices(R, q)
        return np.asarray(np.linalg.solve(require_regular(A), B), dtype=np.float64)

    def torques(self, R: ArrayLike, q: ArrayLike, moment: ArrayLike) -> Floats:
        """(*batch, 3) efforts [N m] with which the platform exerts a moment (*batch, 3) in {s}."""
        return resultant(self.jacobian(R, q), moment)

    def singularity(self, R: ArrayLike, q: ArrayLike) -> SingularKinds:
        """First kind: a leg is stretched or folded. Second: the normals of the second links are in one plane."""
        A, B = self.motor_matrices(R, q)
        return singular_kinds(A, B, SIZE, 3)

    def forward_kinematics(self, q: ArrayLike) -> RodPoses:
        """Orientations for angles (*batch, 3), as `x` (*batch, k, 3, 3): at most eight, by Newton's method.

        From many starts: eight are all; fewer are all that was found, the others being complex or missed.
        """
        value = as_batch("q", q, (3,), finite=True)
        w = self.elbows(value.reshape(-1, 3))[0]
        R = np.tile(np.asarray(rotation.random(np.random.default_rng(0), STARTS)), (len(w), 1, 1))
        each = np.repeat(w, STARTS, axis=0)
        for _ in range(STEPS):
            y = self.platform @ np.swapaxes(R, -1, -2)
            gap = np.cos(self.second) - (each * y).sum(axis=-1)
            turn = np.einsum("kij,kj->ki", np.linalg.pinv(np.cross(y, each), rcond=FEASIBLE), gap)
            turn *= np.minimum(1.0, LONGEST / np.maximum(np.abs(turn).max(axis=-1, keepdims=True), LONGEST))
            R = rotation.exp(turn) @ R
        y = self.platform @ np.swapaxes(R, -1, -2)
        miss = np.abs(np.cos(self.second) - (each * y).sum(axis=-1)).max(axis=-1).reshape(-1, STARTS)
        T = np.tile(np.eye(4), (len(w), MOST, 1, 1))
        off = np.full((len(w), MOST), np.inf)
        for k, own in enumerate(R.reshape(-1, STARTS, 3, 3)):
            count = 0
            for j in np.flatnonzero(miss[k] <= FEASIBLE):
                if count < MOST and (np.abs(T[k, :count, :3, :3] - own[j]).max(axis=(1, 2), initial=0.0) > SAME).all():
                    T[k, count, :3, :3], off[k, count], count = own[j], miss[k, j], count + 1
        shape = value.shape[:-1]
        complete = bool(np.isfinite(off).all())
        return RodPoses.of(self, T.reshape(*shape, MOST, 4, 4), off.reshape(*shape, MOST), complete=complete)
