"""Configurations as rows of numbers: coordinates wound into limits, their residuals, which branch it is.

The branches of a closed form along the value of one locked joint: what interval arithmetic is done with.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from math import pi

import mafsil.expression as ex
from mafsil.algebra.subproblems import Turn, zero_turn
from mafsil.kernels.tape import Tape, read
from mafsil.mechanics.arm_pattern import FARTHEST, FIRST_JOINTS, INSIDE, MERGED, WHOLE_TURN, WRIST_JOINTS, ArmPattern
from mafsil.mechanics.closed_form.arm import Arm, branch_solutions
from mafsil.mechanics.closed_form.decision import Row, solution_bits
from mafsil.mechanics.closed_form.line import BranchSolution, Geometry, constants

COLUMNS = ("residual", "subproblem_residual", "free", "code", "margin", "excess")
"""Columns beside the coordinates; see `mafsil.ik.closed_form`."""


@dataclass(frozen=True, eq=False)
class Preferences:
    """What a caller prefers and allows.

    Attributes:
        q0: (n,) coordinates that free and locked joints take, and to which revolute joints are wound.
        turns: (n, 2) their cosines and sines.
        lower, upper: (n,) limits.
    """

    q0: ex.Expression
    turns: ex.Expression
    lower: ex.Expression
    upper: ex.Expression


def raw(
    pattern: ArmPattern, T: ex.Expression, q0: ex.Expression | None, geometry: Geometry | None = None
) -> ex.Expression:
    """(branches, n + 3) rows (q, residual, subproblem residual, free) of every branch.

    The residual is the larger of the distances by which the branch's forward kinematics misses the pose: of the placed
    point [m], and of two unit vectors of the tip [rad]. Free is the sum of 2^i over the free coordinates i.

    Args:
        pattern: of the arm.
        T: (4, 4) requested pose of the tip in {s}.
        q0: (n,) coordinates that free and locked joints take; zero if None.
        geometry: the arm's numbers, constants of the pattern if None.
    """
    turns = None if q0 is None else ex.horzcat(ex.cos(q0), ex.sin(q0))
    found, residuals = _solve(pattern, T, q0, turns, geometry)
    rows: list[ex.Expression] = []
    for solution, residual in zip(found, residuals, strict=True):
        values, free = _coordinates(pattern, solution, q0)
        rows.append(ex.horzcat(*values, residual, solution.subproblem_residual, free))
    return ex.vertcat(*rows)


def label_branches(
    pattern: ArmPattern, T: ex.Expression, preferences: Preferences, geometry: Geometry | None = None
) -> tuple[ex.Expression, ex.Expression, ex.Expression]:
    """All branches with what names and judges them.

    Args:
        pattern: of the arm.
        T: (4, 4) requested pose; small errors of its rotation are repaired first.
        preferences: of the caller.
        geometry: the arm's numbers, constants of the pattern if None.

    Returns:
        (branches, n) coordinates, (branches, 6) details in the order of `COLUMNS`, and how far T is from a pose.
    """
    q, rows, defect = _labelled_rows(pattern, T, preferences, geometry)
    return ex.vertcat(*q), ex.vertcat(*map(_details, rows)), defect


def judge_branches(
    pattern: ArmPattern, T: ex.Expression, preferences: Preferences, tolerance: ex.Expression
) -> tuple[ex.Expression, ex.Expression, ex.Expression]:
    """The same, with what is decided about the pose in place of how far T is from one.

    Args:
        pattern: of the arm, none of its joints locked.
        T: (4, 4) requested pose; small errors of its rotation are repaired first.
        preferences: of the caller.
        tolerance: largest residual of a solution.
    """
    q, rows, defect = _labelled_rows(pattern, T, preferences, None)
    return ex.vertcat(*q), ex.vertcat(*map(_details, rows)), solution_bits(pattern, rows, defect, tolerance)


def _details(row: Row) -> ex.Expression:
    """(1, 6) in the order of `COLUMNS`."""
    return ex.horzcat(row.residual, row.subproblem_residual, row.free, row.code, row.margin, row.excess)


def _labelled_rows(
    pattern: ArmPattern, T: ex.Expression, preferences: Preferences, geometry: Geometry | None
) -> tuple[list[ex.Expression], list[Row], ex.Expression]:
    """Coordinates and details of every branch, and how far T is from a pose."""
    T, defect = orthonormalise_pose(T)
    branches = judged_branches(pattern, T, preferences, geometry)
    q = [ex.horzcat(*one.q) for one in branches]
    rows = [row_of(pattern, one.solution, (one.residual, one.free, one.excess, one.fixed)) for one in branches]
    return q, rows, defect


@dataclass(frozen=True, eq=False)
class JudgedBranch:
    """One branch within limits or not.

    Attributes:
        solution: with its branch margins.
        q: (n,) coordinates, wound into the limits where possible.
        residual: error of forward kinematics.
        free: sum of 2^i over the free coordinates i.
        excess: by how much the worst joint is beyond its limits, zero if none is.
        fixed: the same of the joints that are not the wrist's, which stay where they are when the wrist turns.
    """

    solution: BranchSolution
    q: list[ex.Expression]
    residual: ex.Expression
    free: ex.Expression
    excess: ex.Expression
    fixed: ex.Expression


def judged_branches(
    pattern: ArmPattern, T: ex.Expression, preferences: Preferences, geometry: Geometry | None = None
) -> list[JudgedBranch]:
    """All branches of a pose that is one; arguments as for `label_branches`."""
    found, residuals = _solve(pattern, T, preferences.q0, preferences.turns, geometry)
    revolute = {j for j, prismatic in zip(pattern.joints, pattern.prismatic, strict=True) if not prismatic}
    revolute |= {locked.joint for locked in pattern.locked if not locked.prismatic}
    wrist = WRIST_JOINTS.get(pattern.family, range(len(pattern.joints)))
    moving = {pattern.joints[k] for k in wrist}
    rows: list[JudgedBranch] = []
    for solution, residual in zip(found, residuals, strict=True):
        values, free = _coordinates(pattern, solution, preferences.q0)
        wound = [wound_angle(x, preferences, i) if i in revolute else x for i, x in enumerate(values)]
        rest = [i for i in range(len(wound)) if i not in moving]
        rows.append(
            JudgedBranch(
                solution, wound, residual, free, excess_of(wound, preferences), excess_of(wound, preferences, rest)
            )
        )
    return rows


def excess_of(
    q: Sequence[ex.Expression], preferences: Preferences, which: Sequence[int] | None = None
) -> ex.Expression:
    """By how much the worst coordinate is beyond its limits, zero if none is.

    Args:
        q: coordinates.
        preferences: gives the limits.
        which: of them, all if None.
    """
    excess = ex.Expression(0)
    for i in range(len(q)) if which is None else which:
        excess = ex.fmax(excess, ex.fmax(preferences.lower[i] - q[i], q[i] - preferences.upper[i]))
    return excess


def motions_along(
    pattern: ArmPattern, T: ex.Expression, locked: int, value: ex.Expression, q0: Sequence[float]
) -> list[list[ex.Expression | float]]:
    """Every branch: of coordinates not locked cosine and sine, or length and zero, then its subproblem residual.

    Args:
        pattern: of the arm, one joint locked.
        T: (4, 4) requested pose of the tip in {s}.
        locked: coordinate of the locked joint.
        value: of that [rad | m].
        q0: (n,) what free joints take.
    """
    preferences = ex.vertcat(*[value if i == locked else ex.Expression(float(x)) for i, x in enumerate(q0)])
    found, _ = _solve(pattern, T, preferences, ex.horzcat(ex.cos(preferences), ex.sin(preferences)), None)
    rows: list[list[ex.Expression | float]] = []
    for solution in found:
        row: list[ex.Expression | float] = [0.0] * (2 * pattern.n)
        for motion, joint in zip(solution.motions, pattern.joints, strict=True):
            if joint >= 0:
                row[2 * joint : 2 * joint + 2] = [motion.c, motion.s] if isinstance(motion, Turn) else [motion, 0.0]
        rows.append([*row, solution.subproblem_residual])
    return rows


def _solve(
    pattern: ArmPattern,
    T: ex.Expression,
    q0: ex.Expression | None,
    turns: ex.Expression | None,
    geometry: Geometry | None,
) -> tuple[list[BranchSolution], list[ex.Expression]]:
    numbers = constants(pattern) if geometry is None else geometry
    R, p = _displacement(pattern, numbers, T)
    arm = Arm(pattern, numbers, R, p, patient=q0 is not None)
    for locked, axis, point in reversed(numbers.locked):
        if q0 is None or turns is None:
            motion = ex.Expression(0) if locked.prismatic else zero_turn()
        else:
            motion = q0[locked.joint] if locked.prismatic else Turn(turns[locked.joint, 0], turns[locked.joint, 1])
        arm.lock(locked, axis, point, motion)
    preferred = [
        zero_turn() if turns is None or joint < 0 else Turn(turns[joint, 0], turns[joint, 1])
        for joint in pattern.joints
    ]
    return branch_solutions(arm, preferred)


def _coordinates(
    pattern: ArmPattern, solution: BranchSolution, q0: ex.Expression | None
) -> tuple[list[ex.Expression], ex.Expression]:
    """(n) coordinates, and the sum of 2^i over the free ones."""
    values: list[ex.Expression] = [ex.Expression(0)] * pattern.n
    if q0 is not None:
        for locked in pattern.locked:
            values[locked.joint] = q0[locked.joint]
    free = ex.Expression(0)
    for motion, loose, joint in zip(solution.motions, solution.free, pattern.joints, strict=True):
        if joint >= 0:
            values[joint] = motion.angle if isinstance(motion, Turn) else motion
        if joint != -1:
            free = free + 2.0 ** (joint if joint >= 0 else 20) * loose
    return values, free


def wound_angle(x: ex.Expression, preferences: Preferences, i: int) -> ex.Expression:
    """The angle moved by whole turns as near to `q0` as possible, into the limits where that can be done.

    Args:
        x: the angle [rad].
        preferences: of the caller.
        i: its coordinate.
    """
    turn = 2 * pi
    lower, upper = preferences.lower[i], preferences.upper[i]
    moved = x - turn * ex.floor((x - preferences.q0[i]) / turn + 0.5)
    up = ex.if_else(moved < lower, ex.ceil((lower - moved) / turn - WHOLE_TURN), 0)
    down = ex.if_else(moved > upper, ex.ceil((moved - upper) / turn - WHOLE_TURN), 0)
    shifted = moved + turn * (up - down)
    inside = ex.logic_and(shifted >= lower - INSIDE, shifted <= upper + INSIDE)
    return ex.if_else(inside, shifted, moved)


def row_of(
    pattern: ArmPattern,
    solution: BranchSolution,
    details: tuple[ex.Expression, ex.Expression, ex.Expression, ex.Expression],
) -> Row:
    """A branch with its name and its branch margins.

    The code is (shoulder + 1) + 3 (elbow + 1) + 9 (wrist + 1) + 27 reason, each the sign -1, 0 or 1 of a branch margin.

    Args:
        pattern: of the arm.
        solution: with its branch margins.
        details: its residual, which coordinates are free, by how much it leaves the limits, and by
            how much its joints beside the wrist do.
    """
    residual, free, excess, fixed = details
    code, margin, second = 27 * solution.reason, ex.Expression(1), ex.Expression(1)
    merged: list[ex.Expression] = []
    for branch_margin, weight in zip(solution.branch_margins, (1, 3, 9), strict=True):
        if branch_margin is None:
            code = code + weight
            merged.append(ex.Expression(1))
            continue
        code = code + weight * ex.if_else(branch_margin > MERGED, 2, ex.if_else(branch_margin < -MERGED, 0, 1))
        size = ex.fabs(branch_margin)
        second = ex.fmin(second, ex.fmax(margin, size))
        margin = ex.fmin(margin, size)
        merged.append(ex.logic_not(size > MERGED))
    first = FIRST_JOINTS.get(pattern.family, 0)
    loose = [free > 0 for free, joint in zip(solution.free[:first], pattern.joints[:first], strict=True) if joint != -1]
    free_first = loose[0] if loose else ex.Expression(0)
    for one in loose[1:]:
        free_first = ex.logic_or(free_first, one)
    total = merged[0] + merged[1] + merged[2]
    return Row(
        residual, solution.subproblem_residual, free, code, margin, excess, second, total, merged[0], free_first, fixed
    )


def _displacement(pattern: ArmPattern, geometry: Geometry, T: ex.Expression) -> tuple[ex.Expression, ex.Expression]:
    """Rotation and translation of T home^-1, or of its inverse for a reversed arm."""
    R_h, p_h = geometry.home[:3, :3], geometry.home[:3, 3]
    R = T[:3, :3] @ R_h.T
    p = T[:3, 3] - R @ p_h
    return (R.T, -R.T @ p) if pattern.reversed else (R, p)


def orthonormalise_pose(T: ex.Expression) -> tuple[ex.Expression, ex.Expression]:
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


def locked_joint_tape(pattern: ArmPattern, locked: int, q0: Sequence[float]) -> Tape:
    """The program of (T_sd, value) to all branches.

    Args:
        pattern: of the arm, one joint locked.
        locked: its coordinate.
        q0: (n,) what free joints take.

    Returns:
        Inputs: the pose (16) and the value of the locked joint (1). Outputs, one port for every branch: (2 n + 1)
            cosine
        and sine of every coordinate but the locked one, of a prismatic joint its value and zero, and residual of the
        worst subproblem.
    """
    T, value = ex.symbol("T_sd", 16), ex.symbol("value")
    branches = motions_along(pattern, ex.reshape(T, 4, 4).T, locked, value, q0)
    return read(ex.Function("course", [T, value], ex.cse([ex.vertcat(*row) for row in branches])))
