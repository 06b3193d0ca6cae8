"""An arm with letters for its lengths: the Denavit-Hartenberg table that a derivation starts from, and its poses.

Turns about parallel neighbouring axes are added as angles before anything is multiplied, which is why the cosine of a
sum (c12, s23) appears where a teacher writes it and no trigonometric identity has to be found afterwards.

In classic tables frame {i} is at the far end of link i, on the axis of joint i + 1. Inside, the angles are added in the
modified table that holds the same numbers one row further down; its frames {i}, on the axis of joint i, become those of
the classic table by Trans(x, a_i) Rot(x, alpha_i).
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import chain, combinations, islice
from math import pi
from typing import Literal

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.derivation.polynomial import (
    ZERO,
    Angle,
    Entries,
    Polynomial,
    Row,
    SymbolicPose,
    angle_sum,
    numbers,
    plus,
    product,
    rotation_x,
    rotation_z,
    scale_row,
    symbol,
    transform,
)
from mafsil.derivation.tolerances import NOTHING, ROUNDOFF
from mafsil.model import JointKind, Mechanism
from mafsil.model.denavit_hartenberg import Convention, DHRow, convention_of
from mafsil.model.dh_from_axes import DHTable, Relation, classic_from_modified, dh_from_mechanism
from mafsil.model.exponentials import chain_to_tip
from mafsil.model.placement import rotation_x as turn_x
from mafsil.model.placement import translation


def typed_classic(mechanism: Mechanism) -> DHTable | None:
    """The classic table from which a mechanism was made, as it was typed; None if it was made otherwise.

    `mechanism_from_dh` puts the frame of link i on the axis that moves it, so the first joint stands at the identity
    and every later one at Rot(z, theta) Trans(z, d) Trans(x, a) Rot(x, alpha) of the row before. An arm that is a
    modified table as well, such as one in a plane, counts as that.

    Args:
        mechanism: any.
    """
    joints = chain_to_tip(mechanism)
    plain = all(
        joint.kind in (JointKind.REVOLUTE, JointKind.PRISMATIC) and np.array_equal(joint.axis, (0.0, 0.0, 1.0))
        for joint in joints
    )
    if not joints or not plain or not np.array_equal(joints[0].T_pj, np.eye(4)):
        return None
    places = [np.asarray(joint.T_pj) for joint in joints[1:]]
    rows = [_classic_row(T) for T in places]
    if any(row is None for row in rows) or all(_is_modified(T) for T in places):
        return None
    last = _classic_row(np.asarray(mechanism.T_lt))
    tool = np.eye(4) if last is not None else np.asarray(mechanism.T_lt)
    found = [row for row in (*rows, last or DHRow()) if row is not None]
    letters: tuple[Literal["R", "P"], ...] = tuple("R" if joint.kind is JointKind.REVOLUTE else "P" for joint in joints)
    kinds = [replace(row, kind=kind) for row, kind in zip(found, letters, strict=True)]
    relations: tuple[Relation, ...] = ()
    return DHTable(tuple(kinds), Convention.CLASSIC, np.asarray(mechanism.T_sb), tool, relations, 0.0)


def modified_core(table: DHTable) -> DHTable:
    """The modified table of the same frames: lengths and twists one row further down, the last ones in the tool.

    Args:
        table: classic.
    """
    before = (DHRow(), *table.rows[:-1])
    rows = tuple(replace(row, a=b.a, alpha=b.alpha) for row, b in zip(table.rows, before, strict=True))
    last = table.rows[-1]
    tool = translation(last.a, 0.0, 0.0) @ turn_x(last.alpha) @ table.tool
    return replace(table, rows=rows, tool=tool, convention=Convention.MODIFIED)


def _classic_row(T: PoseMatrix) -> DHRow | None:
    """The four classic parameters of a pose: r_31 = 0, and (p_x, p_y) along (r_11, r_21)."""
    (r11, _, _, x), (r21, _, _, y), (r31, r32, r33, z) = T[:3]
    if abs(r31) > ROUNDOFF or abs(x * r21 - y * r11) > ROUNDOFF:
        return None
    return DHRow(
        a=float(r11 * x + r21 * y), alpha=float(np.arctan2(r32, r33)), d=float(z), theta=float(np.arctan2(r21, r11))
    )


def _is_modified(T: PoseMatrix) -> bool:
    """Whether a pose is a modified link as well: r_13 = 0 and (p_y, p_z) along (r_23, r_33)."""
    return abs(T[0, 2]) <= ROUNDOFF and abs(T[1, 3] * T[2, 2] - T[2, 3] * T[1, 2]) <= ROUNDOFF


_IDENTITY = SymbolicPose(rotation_z(()), (ZERO, ZERO, ZERO))


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicRow:
    """One row of the table in letters.

    Attributes:
        a, d: lengths; d holds the coordinate of a sliding joint.
        alpha, theta: angles besides whole quarter turns.
        alpha_quarters, theta_quarters: quarter turns added to them.
        row: the numbers.
    """

    a: Polynomial
    alpha: Angle
    alpha_quarters: int
    d: Polynomial
    theta: Angle
    theta_quarters: int
    row: DHRow

    def transform(self) -> SymbolicPose:
        """T_i-1,i = Rot(x, alpha) Trans(x, a) Trans(z, d) Rot(z, theta)."""
        tilt = rotation_x(self.alpha, self.alpha_quarters)
        along_z = scale_row(self.d, tuple(r[2] for r in tilt))
        return SymbolicPose(
            product(tilt, rotation_z(self.theta, self.theta_quarters)), plus((self.a, ZERO, ZERO), along_z)
        )


@dataclass(frozen=True, slots=True, eq=False)
class ClassicEnds:
    """What turns the frames of the modified table into those of a classic one.

    Attributes:
        table: classic, in numbers.
        ends: for each row Trans(x, a_i) Rot(x, alpha_i).
        tool: constant pose of the tip in {n}.
    """

    table: DHTable
    ends: tuple[SymbolicPose, ...]
    tool: SymbolicPose


@dataclass(frozen=True, slots=True, eq=False)
class SymbolicArm:
    """The chain from base to tip in letters.

    Attributes:
        mechanism: the robot.
        table: its modified Denavit-Hartenberg table in numbers.
        rows: the table in letters.
        base, tool: constant poses of {0} in {s} and of the tip in {n}.
        letters: number of every letter [m | rad].
        coordinates: for each row, its place in q.
        offsets: constant that is added to q_i in theta_i [rad], quarter turns not counted.
        classic: the classic table that is shown instead, and its links' far ends, or None.
    """

    mechanism: Mechanism
    table: DHTable
    rows: tuple[SymbolicRow, ...]
    base: SymbolicPose
    tool: SymbolicPose
    letters: dict[str, float]
    coordinates: tuple[int, ...]
    offsets: tuple[float, ...]
    classic: ClassicEnds | None = None

    @property
    def n(self) -> int:
        """Number of joints of the chain."""
        return len(self.rows)

    def values(self, q: Floats) -> dict[str, float | Floats]:
        """Numbers of all letters and angles at states q (count, n of the robot)."""
        found: dict[str, float | Floats] = dict(self.letters)
        for i, (place, offset) in enumerate(zip(self.coordinates, self.offsets, strict=True), start=1):
            found[f"theta{i}"] = q[..., place] + offset
            found[f"q{i}"] = q[..., place]
        return found

    @property
    def shown_table(self) -> DHTable:
        """The table in the convention in which it is shown."""
        return self.table if self.classic is None else self.classic.table

    @property
    def shown_tool(self) -> SymbolicPose:
        """Pose of the tip in the last frame that is shown."""
        return self.tool if self.classic is None else self.classic.tool

    def shown_link(self, i: int) -> SymbolicPose:
        """T_i-1,i of the frames that are shown, i from 1."""
        row = self.rows[i - 1]
        if self.classic is None:
            return row.transform()
        turned = SymbolicPose(rotation_z(row.theta, row.theta_quarters), (ZERO, ZERO, row.d))
        return compose(turned, self.classic.ends[i - 1])

    def shown(self, poses: Sequence[SymbolicPose]) -> tuple[SymbolicPose, ...]:
        """Poses {0} .. of the frames that are shown, from those of the modified table."""
        if self.classic is None:
            return tuple(poses)
        later = (compose(pose, end) for pose, end in zip(poses[1:], self.classic.ends, strict=False))
        return (poses[0], *later)

    def frames(self, longest: int) -> tuple[SymbolicPose, ...]:
        """T_s0, T_s1, ... of the modified table, as far as none is longer than `longest` on paper."""
        found: list[SymbolicPose] = []
        for pose in self._poses(self.base, self.rows):
            if length(pose) > longest:
                break
            found.append(pose)
        return tuple(found)

    def block(self, start: int, longest: int) -> tuple[int, SymbolicPose]:
        """The last frame {i} whose T_start,i is not longer than `longest`, one link at least, and that pose."""
        found = list(islice(self._poses(_IDENTITY, self.rows[start:]), 2))
        last = found[-1]
        for count, pose in enumerate(self._poses(_IDENTITY, self.rows[start:])):
            if count > 1 and length(pose) > longest:
                return start + count - 1, last
            last = pose if count else last
        return self.n, last

    def poses(self) -> tuple[SymbolicPose, ...]:
        """T_s0, T_s1, ..., T_sn and the tip: n + 2 poses in {s}."""
        frames = tuple(self._poses(self.base, self.rows))
        return (*frames, compose(frames[-1], self.tool))

    def between(self, k: int, i: int) -> SymbolicPose:
        """T_ki of the table's frames, 0 <= k <= i <= n."""
        *_, last = self._poses(_IDENTITY, self.rows[k:i])
        return last

    def _poses(self, start: SymbolicPose, rows: Sequence[SymbolicRow]) -> Iterator[SymbolicPose]:
        """The starting frame and the frames of the rows after it."""
        yield start
        angle: Angle = ()
        before, quarters, p, R = start.R, 0, start.p, start.R
        for row in rows:
            tilt = row.alpha_quarters % 4
            if row.alpha or tilt % 2:
                before = product(product(before, rotation_z(angle, quarters)), rotation_x(row.alpha, tilt))
                angle, quarters = row.theta, row.theta_quarters
            elif tilt == 2:
                before = product(before, rotation_x((), 2))
                angle, quarters = angle_sum(row.theta, angle, -1), row.theta_quarters - quarters
            else:
                angle, quarters = angle_sum(angle, row.theta), quarters + row.theta_quarters
            p = plus(p, scale_row(row.a, tuple(r[0] for r in R)))
            p = plus(p, scale_row(row.d, tuple(r[2] for r in before)))
            R = product(before, rotation_z(angle, quarters))
            yield SymbolicPose(R, p)


def compose(T_ab: SymbolicPose, T_bc: SymbolicPose) -> SymbolicPose:
    """T_ac."""
    return SymbolicPose(product(T_ab.R, T_bc.R), plus(T_ab.p, transform(T_ab.R, T_bc.p)))


def length(pose: SymbolicPose) -> int:
    """How long a pose is on paper: factors and terms of all entries."""
    return sum(x.length for row in pose.entries for x in row)


def symbolic_arm(mechanism: Mechanism, convention: Convention | str | None = Convention.MODIFIED) -> SymbolicArm:
    """The arm to the tip in letters.

    Of the tables that the two senses of intersecting axes allow, the one with the fewest constant joint offsets.

    Args:
        mechanism: any; its chain to the tip is taken.
        convention: of the table that is shown; None for that in which the robot was typed, else modified.

    Raises:
        ModelError: a mimic or helical joint on the chain, or no joint at all; an unknown convention.
    """
    requested = None if convention is None else convention_of(convention)
    classic = None if requested is Convention.MODIFIED else typed_classic(mechanism)
    if requested is Convention.CLASSIC and classic is None:
        classic = classic_from_modified(best_table(mechanism))
    table = best_table(mechanism) if classic is None else modified_core(classic)
    letters: dict[str, float] = {}
    planar = _is_planar(table)
    rows = tuple(_row(i, row, planar, letters) for i, row in enumerate(table.rows, start=1))
    moving = [joint for joint in chain_to_tip(mechanism) if joint.moves]
    base = _constant_pose(table.base, "b", letters)
    ends = None if classic is None else _ends(classic, rows, planar, letters)
    return SymbolicArm(
        mechanism,
        table,
        rows,
        base,
        _constant_pose(table.tool, f"L{len(rows)}" if planar else "t", letters)
        if ends is None
        else compose(ends.ends[-1], ends.tool),
        letters,
        tuple(mechanism.joint_names.index(joint.name) for joint in moving),
        tuple(_rest(row.theta) if row.kind == "R" else 0.0 for row in table.rows),
        ends,
    )


def _ends(table: DHTable, rows: Sequence[SymbolicRow], planar: bool, letters: dict[str, float]) -> ClassicEnds:
    """Trans(x, a_i) Rot(x, alpha_i) of every row, and the tool, in letters."""
    n, last = len(rows), table.rows[-1]
    a = _length(f"L{n}" if planar else f"a{n}", last.a, letters)
    alpha, quarters = _angle(f"alpha{n}", last.alpha, letters)
    far = [(row.a, row.alpha, row.alpha_quarters) for row in rows[1:]]
    ends = tuple(SymbolicPose(rotation_x(x, k), (along, ZERO, ZERO)) for along, x, k in [*far, (a, alpha, quarters)])
    return ClassicEnds(table, ends, _constant_pose(table.tool, "t", letters))


def best_table(mechanism: Mechanism) -> DHTable:
    """The modified table with the fewest constant joint offsets; among those, the fewest negative twists."""
    first = dh_from_mechanism(mechanism)
    free = [i for i, relation in enumerate(first.relations, start=1) if relation is Relation.INTERSECTING]
    choices = chain.from_iterable(combinations(free, count) for count in range(len(free) + 1))
    return min((dh_from_mechanism(mechanism, flipped=choice) for choice in choices), key=_offsets)


def _offsets(table: DHTable) -> tuple[int, int]:
    angles = [row.theta + row.offset for row in table.rows if row.kind == "R"]
    return sum(abs(x) > NOTHING for x in angles), sum(row.alpha < -NOTHING for row in table.rows)


def _row(i: int, row: DHRow, planar: bool, letters: dict[str, float]) -> SymbolicRow:
    alpha, alpha_quarters = _angle(f"alpha{i - 1}", row.alpha, letters)
    revolute = row.kind == "R"
    theta, theta_quarters = ((f"theta{i}", 1),), round((row.theta - _rest(row.theta)) / (pi / 2))
    if not revolute:
        theta, theta_quarters = _angle(f"theta{i}_", row.theta, letters)
    d = _length(f"d{i}", row.d, letters)
    return SymbolicRow(
        _length(f"L{i - 1}" if planar else f"a{i - 1}", row.a, letters),
        alpha,
        alpha_quarters,
        d if revolute else d + symbol(f"q{i}", i),
        theta,
        theta_quarters,
        row,
    )


def _angle(name: str, value: float, letters: dict[str, float]) -> tuple[Angle, int]:
    """A constant angle: quarter turns, or a letter if it is something else."""
    rest = _rest(value)
    if rest == 0.0:
        return (), round(value / (pi / 2))
    letters[name] = value
    return ((name, 1),), 0


def _rest(value: float) -> float:
    """The angle itself, or 0 if it is a whole number of quarter turns."""
    quarter = pi / 2
    return 0.0 if abs(value - round(value / quarter) * quarter) < NOTHING else value


def _length(name: str, value: float, letters: dict[str, float]) -> Polynomial:
    if abs(value) < NOTHING:
        return ZERO
    letters[name] = value
    return symbol(name)


def _constant_pose(T: PoseMatrix, letter: str, letters: dict[str, float]) -> SymbolicPose:
    """Rotation in numbers, origin in letters: b_x, or one letter alone if it names a link of a planar arm."""
    names = (letter, "", "") if letter.startswith("L") else tuple(f"{letter}_{axis}" for axis in "xyz")
    p: Row = tuple(_length(name, float(x), letters) for name, x in zip(names, T[:3, 3], strict=True))
    R: Entries = numbers(T[:3, :3])
    return SymbolicPose(R, p)


def _is_planar(table: DHTable) -> bool:
    """Parallel revolute axes in one plane, tip in that plane along the last link."""
    rows = table.rows
    flat = all(row.kind == "R" and abs(row.d) < NOTHING and abs(row.alpha) < NOTHING for row in rows)
    return flat and bool(np.abs(table.tool[1:3, 3]).max() < NOTHING)
