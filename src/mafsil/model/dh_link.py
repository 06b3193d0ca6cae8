"""One link transform looked at closely: its elementary motions, whether it has four parameters, and what is missing.

Any pose T of {i} in {i-1} is Rot(x, alpha) Trans(x, a) Trans(z, d) Rot(z, theta) X with a constant X that rotates only
about y' and translates only along y', the y axis before the last rotation; X is the identity iff T has four
parameters.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import PoseMatrix
from mafsil.model.denavit_hartenberg import Convention, DHRow, convention_of
from mafsil.model.placement import checked_pose, inverse, rotation_x, rotation_y, rotation_z, translation
from mafsil.model.tolerances import WRITTEN


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
    angle = row.theta + (row.offset + q if row.kind == "R" else 0.0)
    length = row.d + (row.offset + q if row.kind == "P" else 0.0)
    about_x = (("Rot(x, alpha)", row.alpha, rotation_x(row.alpha)), ("Trans(x, a)", row.a, translation(row.a, 0, 0)))
    about_z = (("Trans(z, d)", length, translation(0, 0, length)), ("Rot(z, theta)", angle, rotation_z(angle)))
    modified = convention_of(convention) is Convention.MODIFIED
    frame, motions = np.eye(4), list[Motion]()
    for name, value, T in (*about_x, *about_z) if modified else (*reversed(about_z), *about_x):
        frame = frame @ T
        motions.append(Motion(name, value, T, frame))
    return tuple(motions)


class LinkStatus(Status):
    """Whether a pose is a Denavit-Hartenberg link, and if not, what is left over."""

    LINK = ("dh.link_fits", True)
    """It is one."""
    ROTATION_LEFT = ("dh.link_rotation", False)
    """x is not at a right angle to the other z: a rotation about y is left."""
    TRANSLATION_LEFT = ("dh.link_translation", False)
    """x does not meet the other z: a translation along y is left."""
    BOTH_LEFT = ("dh.link_both", False)
    """A rotation about and a translation along y are left."""


@dataclass(frozen=True, eq=False, slots=True)
class LinkFit(Answer, data="row rotation_y translation_y missing"):
    """The nearest link transform to a pose, and what is left: T = row.transform(convention) missing.

    For the classic convention the rest stands in front: T = missing row.transform(classic).

    Attributes:
        row: the four parameters; exact if `missing` is the identity.
        status: whether the row gives the pose, and what is left if not.
        rotation_y, translation_y: what is left about y [rad] and along y [m].
        missing: (4, 4) the constant pose to add: a tool behind (modified), a base in front (classic).
    """

    row: DHRow
    status: LinkStatus
    rotation_y: float
    translation_y: float
    missing: PoseMatrix

    def explain(self, language: str | None = None) -> str:
        """The reason as a sentence."""
        return self.status.sentence(language, rotation=self.rotation_y, translation=self.translation_y)


def link_fit(T: ArrayLike, convention: Convention | str = "modified", tolerance: float = WRITTEN) -> LinkFit:
    """Whether a pose is a Denavit-Hartenberg link; if not, the reason and the constant pose that is missing.

    Args:
        T: (4, 4) pose of {i} in {i-1}.
        convention: of the row.
        tolerance: of the rotation [rad] and the translation [m] that count as none.

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
        return LinkFit(row, fit.status, fit.rotation_y, fit.translation_y, inverse(fit.missing))
    R, (a, y, z) = pose[:3, :3], pose[:3, 3]
    about_y = float(np.arcsin(np.clip(R[0, 2], -1.0, 1.0)))
    alpha = float(np.arctan2(-R[1, 2], R[2, 2])) if abs(about_y) < np.pi / 2 - WRITTEN else 0.0
    before = rotation_x(alpha)[:3, :3].T
    along_y, d = float((before @ (0.0, y, z))[1]), float((before @ (0.0, y, z))[2])
    flat = rotation_y(about_y)[:3, :3].T @ before @ R
    theta = float(np.arctan2(flat[1, 0], flat[0, 0]))
    row = DHRow(a=float(a), alpha=alpha, d=d, theta=theta)
    missing = inverse(rotation_z(theta)) @ translation(0.0, along_y, 0.0) @ rotation_y(about_y) @ rotation_z(theta)
    return LinkFit(row, _status(abs(about_y) > tolerance, abs(along_y) > tolerance), about_y, along_y, missing)


def _status(rotated: bool, translated: bool) -> LinkStatus:
    if rotated:
        return LinkStatus.BOTH_LEFT if translated else LinkStatus.ROTATION_LEFT
    return LinkStatus.TRANSLATION_LEFT if translated else LinkStatus.LINK
