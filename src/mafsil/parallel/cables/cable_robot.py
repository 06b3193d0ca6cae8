"""Robots whose platform hangs in cables: lengths, rates, wrenches; what cables can hold is in `cable_tensions`.

Cable i goes straight and without weight from a_i on the frame to b_i on the platform and can only pull. Over a pulley
of radius r it arrives in a_i along n, about which the pulley swivels, and leaves where it is tangent towards b_i: with
p across n and z along n from the middle of the pulley to b_i,

    s^2 = p^2 + z^2 - r^2,    beta = atan2(p, z) + atan2(r, s),    l = s + r beta,    l' = u . b'.

Reference: Pott, Cable-Driven Parallel Robots, 2018, sec. 3.2 and 7.2.

Poses of a platform in straight, taut cables of given lengths: forward kinematics near a first guess.

More cables than freedoms: their lengths fit one pose only if they agree, so the pose is one of least squares, and what
the lengths disagree by is part of the answer.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import (
    Booleans,
    Floats,
    Integers,
    as_batch,
    frozen,
    positive,
    real_array,
    require_finite,
    spread,
    whole,
)
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import pose
from mafsil.parallel.legs.leg_lines import line_matrix, rates, unit_vectors
from mafsil.parallel.planar.planar_legs import planar_line_matrix
from mafsil.solvers import decompositions

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


FITS = 1e-9
"""Largest error of a length over the size up to which the lengths fit a pose."""
SETTLED = 1e-13
"""Length of a step over the size, beyond which least squares has not settled."""
LONGEST = 0.3
"""Of one step [sizes, rad]."""
RANK = 1e-10


class CablePoseStatus(Status):
    """How the search for poses in cables ended."""

    FOUND = ("parallel.cable_pose_found", True)
    DISAGREE = ("parallel.cable_pose_disagree", False)
    NOT_FOUND = ("parallel.cable_pose_not_found", False)


@dataclass(frozen=True, eq=False, repr=False)
class CablePoses(Answer, data="x error settled steps"):
    """Poses of least squares near first ones; true if the lengths fit in every row, iterable over the rows.

    Attributes:
        x: (*batch, 4, 4) or (*batch, 3) poses, the orientation of a point as it was given.
        error: (*batch, m) by how much each cable is too long for its pose [m].
        settled: (*batch,) whether the search came to rest.
        steps: (*batch,) that it took.
        size: of the robot [m].
    """

    x: Floats
    error: Floats
    settled: Booleans
    steps: Integers
    size: float

    @property
    def fits(self) -> Booleans:
        """(*batch,) whether all lengths fit the pose."""
        return np.asarray((np.abs(self.error) <= FITS * self.size).all(axis=-1), dtype=np.bool_)

    @property
    def status(self) -> CablePoseStatus:
        """Of the worst row."""
        if self.fits.all():
            return CablePoseStatus.FOUND
        return CablePoseStatus.DISAGREE if self.settled.all() else CablePoseStatus.NOT_FOUND

    def __len__(self) -> int:
        return int(self.settled.size)

    def __iter__(self) -> Iterator[Floats]:
        core = self.x.shape[self.settled.ndim :]
        return iter(self.x.reshape(-1, *core))

    def explain(self, language: str | None = None) -> str:
        """How many fit, and which cable is off most."""
        rows = np.abs(self.error).reshape(-1, self.error.shape[-1])
        cable = int(rows.max(axis=0, initial=0.0).argmax()) + 1
        return self.status.sentence(
            language, found=int(self.fits.sum()), count=self.settled.size, error=float(rows.max(initial=0.0)),
            cable=cable, steps=int(self.steps.max(initial=0)),
        )  # fmt: skip


def cable_poses(robot: CableRobot, lengths: ArrayLike, x_guess: ArrayLike, *, max_steps: int = 60) -> CablePoses:
    """Poses in which the cables have given lengths, by Gauss and Newton's method from first guesses.

    Args:
        robot: its ends.
        lengths: (*batch, m) of straight, taut cables [m].
        x_guess: poses T_sb (*batch, 4, 4), in the plane (x, y, phi) (*batch, 3).
        max_steps: most steps.

    Raises:
        InputError: wrong shapes, no poses, a cable of length zero on the way.
    """
    core = (3,) if robot.planar else (4, 4)
    wanted = as_batch("lengths", lengths, (robot.m,), finite=True)
    guess = as_batch("x_guess", x_guess, core, finite=True) if robot.planar else pose.check(x_guess, "x_guess")
    most = whole("max_steps", max_steps, 1)
    shape = np.broadcast_shapes(wanted.shape[:-1], guess.shape[: guess.ndim - len(core)])
    x = np.array(np.broadcast_to(guess, (*shape, *core)).reshape(-1, *core))
    goal = np.broadcast_to(wanted, (*shape, robot.m)).reshape(-1, robot.m)
    steps, settled = np.zeros(len(x), dtype=np.int64), np.zeros(len(x), dtype=np.bool_)
    for _ in range(most):
        going = np.flatnonzero(~settled)
        if not len(going):
            break
        error = robot.lengths(x[going]) - goal[going]
        V = -np.einsum("kij,kj->ki", decompositions.pinv(_rates(robot, x[going]), RANK), error)
        length = np.linalg.norm(V / _units(robot), axis=-1)
        V *= np.minimum(1.0, LONGEST / np.maximum(length, LEAST_DIVISOR))[:, None]
        x[going] = _move(robot, x[going], V)
        steps[going] += 1
        settled[going] = length <= SETTLED
    left = robot.lengths(x) - goal
    return CablePoses(
        x.reshape(*shape, *core), -left.reshape(*shape, robot.m), settled.reshape(shape), steps.reshape(shape),
        robot.size,
    )  # fmt: skip


def _units(robot: CableRobot) -> Floats:
    """Of a step: radians, sizes."""
    k = robot.base.shape[1]
    turns = 0 if robot.point else 3 if k == 3 else 1
    return np.concatenate([np.ones(turns), np.full(k, robot.size)])


def _rates(robot: CableRobot, x: Floats) -> Floats:
    """(rows, m, freedoms) rates of the lengths per rotation about the platform's origin and per its velocity."""
    k = robot.base.shape[1]
    W = -np.swapaxes(robot.structure_matrix(x), -1, -2)
    force = W[..., -k:]
    if robot.point:
        return np.ascontiguousarray(force)
    p = (x[:, :2] if robot.planar else x[:, :3, 3])[:, None, :]
    if robot.planar:
        about = W[..., :1] - (p[..., :1] * force[..., 1:] - p[..., 1:] * force[..., :1])
    else:
        about = W[..., :3] - np.cross(p, force)
    return np.concatenate([about, force], axis=-1)


def _move(robot: CableRobot, x: Floats, V: Floats) -> Floats:
    """Poses after rotations about the platform's origin, in {s}, and shifts."""
    k = robot.base.shape[1]
    result = x.copy()
    if robot.planar:
        result[:, :2] += V[:, -k:]
        if not robot.point:
            result[:, 2] += V[:, 0]
        return result
    result[:, :3, 3] += V[:, -k:]
    if not robot.point:
        turn = pose.exp(np.concatenate([V[:, :3], np.zeros_like(V[:, :3])], axis=-1))
        result[:, :3, :3] = turn[:, :3, :3] @ x[:, :3, :3]
    return result
