"""One link transform looked at closely: its elementary motions, whether it has four parameters, and what is missing.

Any pose T of {i} in {i-1} is Rot(x, alpha) Trans(x, a) Trans(z, d) Rot(z, theta) X with a constant X that turns only
about y' and shifts only along y', y' the y axis before the last turn. X is the identity iff T has four parameters.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import PoseMatrix
from mafsil.messages import say
from mafsil.model.denavit_hartenberg import Convention, DHRow, convention_of
from mafsil.model.placement import checked_pose, inverse, rotation_x, rotation_y, rotation_z, translation


class Motion(NamedTuple):
    """One of the four elementary motions of a link transform.

    Attributes:
        name: `Rot(x, alpha)`, `Trans(x, a)`, `Trans(z, d)` or `Rot(z, theta)`.
        value: angle [rad] or length [m].
        T: (4, 4) the motion alone.
        frame: (4, 4) where the moving frame stands after it, in {i-1}.
    """

    name: str
    value: float
    T: PoseMatrix
    frame: PoseMatrix


def four_motions(row: DHRow, convention: Convention | str, q: float = 0.0) -> tuple[Motion, ...]:
    """The four motions that carry {i-1} into {i}, in the order of the convention, with the frames in between.

    The two along and about x commute, and so do the two along and about z.

    Args:
        row: of a table.
        convention: `modified` (x motions first) or `classic` (z motions first).
        q: joint coordinate [rad | m].
    """
    turn = row.theta + (row.offset + q if row.kind == "R" else 0.0)
    slide = row.d + (row.offset + q if row.kind == "P" else 0.0)
    about_x = (("Rot(x, alpha)", row.alpha, rotation_x(row.alpha)), ("Trans(x, a)", row.a, translation(row.a, 0, 0)))
    about_z = (("Trans(z, d)", slide, translation(0, 0, slide)), ("Rot(z, theta)", turn, rotation_z(turn)))
    modified = convention_of(convention) is Convention.MODIFIED
    frame, motions = np.eye(4), list[Motion]()
    for name, value, T in (*about_x, *about_z) if modified else (*reversed(about_z), *about_x):
        frame = frame @ T
        motions.append(Motion(name, value, T, frame))
    return tuple(motions)


class Obstacle(Enum):
    """Why a pose is no Denavit-Hartenberg link."""

    NONE = "none"
    """It is one."""
    TURN = "turn"
    """x does not reach the other z at a right angle: a turn about y is left."""
    SHIFT = "shift"
    """x does not meet the other z: a shift along y is left."""
    BOTH = "both"
    """A turn about and a shift along y are left."""


@dataclass(frozen=True, eq=False, slots=True)
class LinkFit:
    """The nearest link transform to a pose, and what is left: T = row.transform(convention) missing.

    For the classic convention the rest stands in front: T = missing row.transform(classic).

    Attributes:
        row: the four parameters; exact if `missing` is the identity.
        obstacle: why not, or NONE.
        turn, shift: what is left about y [rad] and along y [m].
        missing: (4, 4) the constant pose to add: a tool behind (modified), a base in front (classic).
    """

    row: DHRow
    obstacle: Obstacle
    turn: float
    shift: float
    missing: PoseMatrix

    @property
    def is_link(self) -> bool:
        """Whether four parameters give the pose."""
        return self.obstacle is Obstacle.NONE

    def message(self, language: str | None = None) -> str:
        """The reason as a sentence."""
        return say(f"dh.link_{self.obstacle.value}", language=language, turn=self.turn, shift=self.shift)


def link_fit(T: ArrayLike, convention: Convention | str = "modified", tolerance: float = 1e-9) -> LinkFit:
    """Whether a pose is a Denavit-Hartenberg link; if not, the reason and the constant pose that is missing.

    Args:
        T: (4, 4) pose of {i} in {i-1}.
        convention: of the row.
        tolerance: of the turn [rad] and the shift [m] that count as none.

    Raises:
        ModelError: T is no pose.

    Reference: Denavit & Hartenberg, J. Applied Mechanics 22, 1955.
    """
    pose = checked_pose("T", T)
    if convention_of(convention) is Convention.CLASSIC:
        # The inverse of a classic link, Rot(x, -alpha) Trans(x, -a) Trans(z, -d) Rot(z, -theta), is a modified one.
        fit = link_fit(inverse(pose), "modified", tolerance)
        r = fit.row
        row = DHRow(a=-r.a + 0.0, alpha=-r.alpha + 0.0, d=-r.d + 0.0, theta=-r.theta + 0.0)
        return LinkFit(row, fit.obstacle, fit.turn, fit.shift, inverse(fit.missing))
    R, (a, y, z) = pose[:3, :3], pose[:3, 3]
    turn = float(np.arcsin(np.clip(R[0, 2], -1.0, 1.0)))
    alpha = float(np.arctan2(-R[1, 2], R[2, 2])) if abs(turn) < np.pi / 2 - 1e-9 else 0.0
    before = rotation_x(alpha)[:3, :3].T
    shift, d = float((before @ (0.0, y, z))[1]), float((before @ (0.0, y, z))[2])
    flat = rotation_y(turn)[:3, :3].T @ before @ R
    theta = float(np.arctan2(flat[1, 0], flat[0, 0]))
    row = DHRow(a=float(a), alpha=alpha, d=d, theta=theta)
    missing = inverse(rotation_z(theta)) @ translation(0.0, shift, 0.0) @ rotation_y(turn) @ rotation_z(theta)
    return LinkFit(row, _obstacle(abs(turn) > tolerance, abs(shift) > tolerance), turn, shift, missing)


def _obstacle(turned: bool, shifted: bool) -> Obstacle:
    if turned:
        return Obstacle.BOTH if shifted else Obstacle.TURN
    return Obstacle.SHIFT if shifted else Obstacle.NONE
