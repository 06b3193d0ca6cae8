"""Frames of a Denavit-Hartenberg table: where they stand, what determines them, the moves that stay free; and one link.

Two skew axes leave nothing free; meeting axes leave the sense of x; parallel axes leave the origin free along them;
collinear axes let the frame rotate as well. {0} is free and put on {1} at q = 0; {n} may move along and rotate about
axis n.

Any pose T of {i} in {i-1} is Rot(x, alpha) Trans(x, a) Trans(z, d) Rot(z, theta) X with a constant X that rotates only
about y' and translates only along y', the y axis before the last rotation; X is the identity iff T has four
parameters (`link_fit`).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum
from itertools import chain, combinations, product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import PoseMatrix, as_batch
from mafsil.errors import ModelError
from mafsil.messages import say
from mafsil.model.denavit_hartenberg import Convention, DHRow, convention_of
from mafsil.model.dh_from_axes import DHTable, Relation, dh_from_screws
from mafsil.model.placement import checked_pose, cos_sin, inverse, rotation_x, rotation_y, rotation_z, translation
from mafsil.model.tolerances import WRITTEN


class Freedom(Enum):
    """What the rules leave to choose of one frame."""

    DETERMINED = "determined"
    """Nothing."""
    DIRECTION_OF_X = "direction_of_x"
    """The sense of x: the twists before and behind change their sign."""
    TRANSLATION = "translation"
    """The place of the origin along z."""
    CYLINDRICAL = "cylindrical"
    """The place of the origin along z and the rotation of x about z."""
    ANY = "any"
    """The whole frame; {0} is put where it zeroes most parameters."""


@dataclass(frozen=True, slots=True)
class FrameChoice:
    """One frame of a table and what was free about it.

    Attributes:
        index: 0 .. n.
        freedom: what the rules leave open.
        prismatic: the frame's joint is prismatic: its axis has a direction but no place, so the origin is free besides.
    """

    index: int
    freedom: Freedom
    prismatic: bool = False

    @property
    def determined(self) -> bool:
        """Whether the rules leave nothing to choose."""
        return self.freedom is Freedom.DETERMINED and not self.prismatic

    def explain(self, language: str | None = None) -> str:
        """The sentence that says so, and what was chosen."""
        text = say(f"dh.freedom_{self.freedom.value}", language=language, index=self.index)
        return text + (" " + say("dh.freedom_prismatic", language=language) if self.prismatic else "")


def frame_choices(table: DHTable) -> tuple[FrameChoice, ...]:
    """What was free about each frame {0} .. {n} of a table in the modified convention.

    Args:
        table: from `dh_from_screws` or `dh_from_mechanism`.

    Returns:
        n + 1 choices.
    """
    _require_modified(table)
    freedom = {
        Relation.SKEW: Freedom.DETERMINED,
        Relation.INTERSECTING: Freedom.DIRECTION_OF_X,
        Relation.PARALLEL: Freedom.TRANSLATION,
        Relation.COLLINEAR: Freedom.CYLINDRICAL,
    }
    along = [row.kind == "P" for row in table.rows]
    between = [
        FrameChoice(i, freedom[relation], along[i - 1] or along[i]) for i, relation in enumerate(table.relations, 1)
    ]
    last = FrameChoice(len(table.rows), Freedom.CYLINDRICAL, along[-1])
    return (FrameChoice(0, Freedom.ANY), *between, last)


def frame_poses(table: DHTable, q: ArrayLike | None = None) -> PoseMatrix:
    """(n + 1, 4, 4) poses in {s} of the frames {0} .. {n}.

    Args:
        table: in either convention.
        q: (n,) joint coordinates [rad | m]; zero if None.
    """
    values = np.zeros(len(table.rows)) if q is None else as_batch("q", q, (len(table.rows),), finite=True)
    poses = [np.asarray(table.base)]
    for row, value in zip(table.rows, values, strict=True):
        poses.append(poses[-1] @ row.transform(table.convention, float(value)))
    return np.stack(poses)


def slid(table: DHTable, index: int, distance: float) -> DHTable:
    """The same arm with frame {index} moved along its own z.

    Args:
        table: in the modified convention.
        index: 1 .. n - 1 where axes index and index + 1 are parallel or collinear, or n.
        distance: [m], along z.

    Raises:
        ModelError: the frame is not free to move along its axis.
    """
    return _move(table, index, Freedom.TRANSLATION, distance, 0.0)


def turn_frame(table: DHTable, index: int, angle: float) -> DHTable:
    """The same arm with frame {index} turned about its own z.

    Args:
        table: in the modified convention.
        index: 1 .. n - 1 where axes index and index + 1 are collinear, or n.
        angle: [rad].

    Raises:
        ModelError: the frame is not free to turn.
    """
    return _move(table, index, Freedom.CYLINDRICAL, 0.0, angle)


def tables_of_screws(S_s: ArrayLike, home: ArrayLike) -> Iterator[DHTable]:
    """Every modified table that the two senses of meeting axes allow: 2^k for k pairs.

    Args:
        S_s: (n, 6) unit screw axes at q = 0 in the space frame.
        home: (4, 4) pose of the tip at q = 0.

    Raises:
        ModelError: as `dh_from_screws`.
    """
    first = dh_from_screws(S_s, home)
    meeting = [i for i, relation in enumerate(first.relations, 1) if relation is Relation.INTERSECTING]
    choices = chain.from_iterable(combinations(meeting, count) for count in range(len(meeting) + 1))
    return (dh_from_screws(S_s, home, flipped=choice) for choice in choices)


def tables_of_either_sense(S_s: ArrayLike, home: ArrayLike) -> Iterator[tuple[DHTable, tuple[int, ...]]]:
    """Every modified table of an arm whose senses of z are not prescribed: 2^n times those of `tables_of_screws`.

    Args:
        S_s: (n, 6) unit screw axes at q = 0 in the space frame.
        home: (4, 4) pose of the tip at q = 0.

    Yields:
        A table, and n signs: it describes the arm with q_i counted as sign_i q_i. Tables of one arm are compared by
        their poses, never by their entries.

    Raises:
        ModelError: as `dh_from_screws`.
    """
    axes = np.atleast_2d(as_batch("S_s", S_s, (6,), finite=True))
    for signs in product((1, -1), repeat=len(axes)):
        for table in tables_of_screws(axes * np.array(signs)[:, None], home):
            yield table, signs


def _move(table: DHTable, index: int, needed: Freedom, distance: float, angle: float) -> DHTable:
    """Frame {index} moved by Trans(z, distance) Rot(z, angle); the next row, or the tool, takes it back."""
    choices = frame_choices(table)
    if not 1 <= index < len(choices):
        raise ModelError("dh.no_frame", index=index, last=len(choices) - 1)
    allowed = (Freedom.TRANSLATION, Freedom.CYLINDRICAL) if needed is Freedom.TRANSLATION else (Freedom.CYLINDRICAL,)
    if choices[index].freedom not in allowed:
        raise ModelError("dh.not_free", index=index, freedom=choices[index].explain())
    rows = list(table.rows)
    rows[index - 1] = _advance(rows[index - 1], distance, angle)
    if index < len(rows):
        side = cos_sin(rows[index].alpha)[0]
        rows[index] = _advance(rows[index], -side * distance, -side * angle)
        return replace(table, rows=tuple(rows))
    back = inverse(rotation_z(angle) @ translation(0.0, 0.0, distance))
    return replace(table, rows=tuple(rows), tool=back @ table.tool)


def _advance(row: DHRow, distance: float, angle: float) -> DHRow:
    return replace(row, d=row.d + distance, theta=row.theta + angle)


def _require_modified(table: DHTable) -> None:
    if table.convention is not Convention.MODIFIED:
        raise ModelError("dh.modified_only", convention=table.convention.value)


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
