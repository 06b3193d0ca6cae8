"""Poses of a platform in straight, taut cables of given lengths: forward kinematics near a first guess.

More cables than freedoms: their lengths fit one pose only if they agree, so the pose is one of least squares, and what
the lengths disagree by is part of the answer.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, Integers, as_batch, whole
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import pose
from mafsil.parallel.cables.cable_robot import CableRobot
from mafsil.solvers import decompositions

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
