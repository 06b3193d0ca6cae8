"""Frames of a Denavit-Hartenberg table: where they stand, what determines them, and the moves that stay free.

Two skew axes leave nothing free; meeting axes leave the sense of x; parallel axes leave the origin free along them;
collinear axes let the frame rotate as well. {0} is free and put on {1} at q = 0; {n} may move along and rotate about
axis n.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from enum import Enum
from itertools import chain, combinations, product

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import PoseMatrix, as_batch
from mafsil.errors import ModelError
from mafsil.messages import say
from mafsil.model.denavit_hartenberg import Convention, DHRow
from mafsil.model.dh_from_axes import DHTable, Relation, dh_from_screws
from mafsil.model.placement import cos_sin, inverse, rotation_z, translation


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
