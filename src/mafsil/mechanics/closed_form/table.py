"""Postures as rows of numbers: coordinates wound into limits, how far forward kinematics misses, which branch it is."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import mafsil.expression as ex
from mafsil.algebra.subproblems import Turn, unturned
from mafsil.mechanics.arm_pattern import ArmPattern
from mafsil.mechanics.closed_form.arm import Arm, postures
from mafsil.mechanics.closed_form.decision import Row, decided
from mafsil.mechanics.closed_form.geometry import Geometry, constants
from mafsil.mechanics.closed_form.line import Posture
from mafsil.mechanics.closed_form.thresholds import FARTHEST, FIRST_JOINTS, MERGED, WRIST_JOINTS

FACTS = ("residual", "shortfall", "free", "code", "margin", "excess")
"""Columns beside the coordinates; see `mafsil.ik.closed_form`."""


@dataclass(frozen=True, eq=False)
class Wishes:
    """What a caller prefers and allows.

    Attributes:
        near: (n,) coordinates that free and held joints take, and to which turning joints are wound.
        turns: (n, 2) their cosines and sines.
        lower, upper: (n,) limits.
    """

    near: ex.Expression
    turns: ex.Expression
    lower: ex.Expression
    upper: ex.Expression


def raw(
    pattern: ArmPattern, T: ex.Expression, near: ex.Expression | None, geometry: Geometry | None = None
) -> ex.Expression:
    """(branches, n + 3) rows (q, residual, shortfall, free) of every branch.

    The residual is the larger of the distances by which the branch's forward kinematics misses the pose: of the placed
    point [m], and of two unit vectors of the tip [rad]. Free is the sum of 2^i over the free coordinates i.

    Args:
        pattern: of the arm.
        T: (4, 4) wanted pose of the tip in {s}.
        near: (n,) coordinates that free joints take; zero if None.
        geometry: the arm's numbers, constants of the pattern if None.
    """
    turns = None if near is None else ex.horzcat(ex.cos(near), ex.sin(near))
    found, misses = _solved(pattern, T, near, turns, geometry)
    rows: list[ex.Expression] = []
    for posture, miss in zip(found, misses, strict=True):
        values, free = _coordinates(pattern, posture, near)
        rows.append(ex.horzcat(*values, miss, posture.shortfall, free))
    return ex.vertcat(*rows)


def labelled(
    pattern: ArmPattern, T: ex.Expression, wishes: Wishes, geometry: Geometry | None = None
) -> tuple[ex.Expression, ex.Expression, ex.Expression]:
    """All branches with what names and judges them.

    Args:
        pattern: of the arm.
        T: (4, 4) wanted pose; small errors of its rotation are repaired first.
        wishes: of the caller.
        geometry: the arm's numbers, constants of the pattern if None.

    Returns:
        (branches, n) coordinates, (branches, 6) details in the order of `FACTS`, and how far T is from a pose.
    """
    q, rows, defect = _labelled_rows(pattern, T, wishes, geometry)
    return ex.vertcat(*q), ex.vertcat(*map(_details, rows)), defect


def judged(
    pattern: ArmPattern, T: ex.Expression, wishes: Wishes, tolerance: ex.Expression
) -> tuple[ex.Expression, ex.Expression, ex.Expression]:
    """The same, with what is decided about the pose in place of how far T is from one.

    Args:
        pattern: of the arm, none of its joints held.
        T: (4, 4) wanted pose; small errors of its rotation are repaired first.
        wishes: of the caller.
        tolerance: largest residual of a solution.
    """
    q, rows, defect = _labelled_rows(pattern, T, wishes, None)
    return ex.vertcat(*q), ex.vertcat(*map(_details, rows)), decided(pattern, rows, defect, tolerance)


def _details(row: Row) -> ex.Expression:
    """(1, 6) in the order of `FACTS`."""
    return ex.horzcat(row.residual, row.shortfall, row.free, row.code, row.margin, row.excess)


def _labelled_rows(
    pattern: ArmPattern, T: ex.Expression, wishes: Wishes, geometry: Geometry | None
) -> tuple[list[ex.Expression], list[Row], ex.Expression]:
    """Coordinates and details of every branch, and how far T is from a pose."""
    T, defect = repaired(T)
    branches = judged_branches(pattern, T, wishes, geometry)
    q = [ex.horzcat(*one.q) for one in branches]
    rows = [row_of(pattern, one.posture, (one.miss, one.free, one.excess, one.fixed)) for one in branches]
    return q, rows, defect


@dataclass(frozen=True, eq=False)
class JudgedBranch:
    """One branch within limits or not.

    Attributes:
        posture: with its marks.
        q: (n,) coordinates, wound into the limits where possible.
        miss: by how much forward kinematics misses the pose.
        free: sum of 2^i over the free coordinates i.
        excess: by how much the worst joint is beyond its limits, zero if none is.
        fixed: the same of the joints that are not the wrist's, which stay where they are when the wrist turns.
    """

    posture: Posture
    q: list[ex.Expression]
    miss: ex.Expression
    free: ex.Expression
    excess: ex.Expression
    fixed: ex.Expression


def judged_branches(
    pattern: ArmPattern, T: ex.Expression, wishes: Wishes, geometry: Geometry | None = None
) -> list[JudgedBranch]:
    """All branches of a pose that is one; arguments as for `labelled`."""
    found, misses = _solved(pattern, T, wishes.near, wishes.turns, geometry)
    turning = {j for j, slides in zip(pattern.joints, pattern.slides, strict=True) if not slides}
    turning |= {held.joint for held in pattern.held if not held.slides}
    wrist = WRIST_JOINTS.get(pattern.family, range(len(pattern.joints)))
    moving = {pattern.joints[k] for k in wrist}
    rows: list[JudgedBranch] = []
    for posture, miss in zip(found, misses, strict=True):
        values, free = _coordinates(pattern, posture, wishes.near)
        wound = [wound_angle(x, wishes, i) if i in turning else x for i, x in enumerate(values)]
        rest = [i for i in range(len(wound)) if i not in moving]
        rows.append(JudgedBranch(posture, wound, miss, free, excess_of(wound, wishes), excess_of(wound, wishes, rest)))
    return rows


def excess_of(q: Sequence[ex.Expression], wishes: Wishes, which: Sequence[int] | None = None) -> ex.Expression:
    """By how much the worst coordinate is beyond its limits, zero if none is.

    Args:
        q: coordinates.
        wishes: gives the limits.
        which: of them, all if None.
    """
    excess = ex.Expression(0)
    for i in range(len(q)) if which is None else which:
        excess = ex.fmax(excess, ex.fmax(wishes.lower[i] - q[i], q[i] - wishes.upper[i]))
    return excess


def motions_along(
    pattern: ArmPattern, T: ex.Expression, held: int, value: ex.Expression, near: Sequence[float]
) -> list[list[ex.Expression | float]]:
    """Every branch as cosine and sine of the coordinates not held, of a slide its value and zero, and its shortfall.

    Args:
        pattern: of the arm, one joint held.
        T: (4, 4) wanted pose of the tip in {s}.
        held: coordinate of the held joint.
        value: of that [rad | m].
        near: (n,) what free joints take.
    """
    wishes = ex.vertcat(*[value if i == held else ex.Expression(float(x)) for i, x in enumerate(near)])
    found, _ = _solved(pattern, T, wishes, ex.horzcat(ex.cos(wishes), ex.sin(wishes)), None)
    rows: list[list[ex.Expression | float]] = []
    for posture in found:
        row: list[ex.Expression | float] = [0.0] * (2 * pattern.n)
        for motion, joint in zip(posture.motions, pattern.joints, strict=True):
            if joint >= 0:
                row[2 * joint : 2 * joint + 2] = [motion.c, motion.s] if isinstance(motion, Turn) else [motion, 0.0]
        rows.append([*row, posture.shortfall])
    return rows


def _solved(
    pattern: ArmPattern,
    T: ex.Expression,
    near: ex.Expression | None,
    turns: ex.Expression | None,
    geometry: Geometry | None,
) -> tuple[list[Posture], list[ex.Expression]]:
    numbers = constants(pattern) if geometry is None else geometry
    R, p = _displacement(pattern, numbers, T)
    arm = Arm(pattern, numbers, R, p, patient=near is not None)
    for held, axis, point in reversed(numbers.held):
        assert near is not None
        assert turns is not None
        motion = near[held.joint] if held.slides else Turn(turns[held.joint, 0], turns[held.joint, 1])
        arm.hold(held, axis, point, motion)
    preferred = [
        unturned() if turns is None or joint < 0 else Turn(turns[joint, 0], turns[joint, 1]) for joint in pattern.joints
    ]
    return postures(arm, preferred)


def _coordinates(
    pattern: ArmPattern, posture: Posture, near: ex.Expression | None
) -> tuple[list[ex.Expression], ex.Expression]:
    """(n) coordinates, and the sum of 2^i over the free ones."""
    values: list[ex.Expression] = [ex.Expression(0)] * pattern.n
    for held in pattern.held:
        assert near is not None
        values[held.joint] = near[held.joint]
    free = ex.Expression(0)
    for motion, loose, joint in zip(posture.motions, posture.free, pattern.joints, strict=True):
        if joint >= 0:
            values[joint] = motion.angle if isinstance(motion, Turn) else motion
        if joint != -1:
            free = free + 2.0 ** (joint if joint >= 0 else 20) * loose
    return values, free


def wound_angle(x: ex.Expression, wishes: Wishes, i: int) -> ex.Expression:
    """The angle moved by whole turns as near to `near` as possible, into the limits where that can be done.

    Args:
        x: the angle [rad].
        wishes: of the caller.
        i: its coordinate.
    """
    turn = 2 * pi
    lower, upper = wishes.lower[i], wishes.upper[i]
    moved = x - turn * ex.floor((x - wishes.near[i]) / turn + 0.5)
    up = ex.if_else(moved < lower, ex.ceil((lower - moved) / turn - 1e-12), 0)
    down = ex.if_else(moved > upper, ex.ceil((moved - upper) / turn - 1e-12), 0)
    shifted = moved + turn * (up - down)
    inside = ex.logic_and(shifted >= lower - 1e-12, shifted <= upper + 1e-12)
    return ex.if_else(inside, shifted, moved)


def row_of(
    pattern: ArmPattern, posture: Posture, details: tuple[ex.Expression, ex.Expression, ex.Expression, ex.Expression]
) -> Row:
    """A branch with its name and its marks.

    The code is (shoulder + 1) + 3 (elbow + 1) + 9 (wrist + 1) + 27 reason, each the sign -1, 0 or 1 of a mark.

    Args:
        pattern: of the arm.
        posture: with its marks.
        details: by how much it misses the pose, which coordinates are free, by how much it leaves the limits, and by
            how much its joints beside the wrist do.
    """
    miss, free, excess, fixed = details
    code, margin, second = 27 * posture.reason, ex.Expression(1), ex.Expression(1)
    merged: list[ex.Expression] = []
    for mark, weight in zip(posture.marks, (1, 3, 9), strict=True):
        if mark is None:
            code = code + weight
            merged.append(ex.Expression(1))
            continue
        code = code + weight * ex.if_else(mark > MERGED, 2, ex.if_else(mark < -MERGED, 0, 1))
        size = ex.fabs(mark)
        second = ex.fmin(second, ex.fmax(margin, size))
        margin = ex.fmin(margin, size)
        merged.append(ex.logic_not(size > MERGED))
    first = FIRST_JOINTS.get(pattern.family, 0)
    loose = [free > 0 for free, joint in zip(posture.free[:first], pattern.joints[:first], strict=True) if joint != -1]
    free_first = loose[0] if loose else ex.Expression(0)
    for one in loose[1:]:
        free_first = ex.logic_or(free_first, one)
    total = merged[0] + merged[1] + merged[2]
    return Row(miss, posture.shortfall, free, code, margin, excess, second, total, merged[0], free_first, fixed)


def _displacement(pattern: ArmPattern, geometry: Geometry, T: ex.Expression) -> tuple[ex.Expression, ex.Expression]:
    """Rotation and translation of T home^-1, or of its inverse for a reversed arm."""
    R_h, p_h = geometry.home[:3, :3], geometry.home[:3, 3]
    R = T[:3, :3] @ R_h.T
    p = T[:3, 3] - R @ p_h
    return (R.T, -R.T @ p) if pattern.reversed else (R, p)


def repaired(T: ex.Expression) -> tuple[ex.Expression, ex.Expression]:
    """The pose with its rotation brought to working precision, and by how much it was none; large if a reflection."""
    R = T[:3, :3]
    gram = R.T @ R
    defect = ex.Expression(0)
    for i in range(3):
        defect = ex.fmax(defect, ex.fabs(T[3, i]))
        for j in range(i, 3):
            defect = ex.fmax(defect, ex.fabs(gram[i, j] - float(i == j)))
    defect = ex.fmax(defect, ex.fabs(T[3, 3] - 1))
    defect = ex.if_else(ex.det(R) > 0, defect, 2)
    size = ex.sumsqr(T)
    # NaN and infinity pass no comparison.
    defect = ex.if_else(size < FARTHEST**2, defect, 2)
    for _ in range(2):
        # Newton's iteration for the polar factor: the defect is squared each time.
        R = R @ (1.5 * ex.eye(3) - 0.5 * (R.T @ R))
    return ex.vertcat(ex.horzcat(R, T[:3, 3]), ex.Expression([[0, 0, 0, 1]])), defect
