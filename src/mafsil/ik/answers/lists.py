"""The solutions of many poses from the rows of their closed form: candidates, refined, merged, certified.

1. Candidates: rows that are solutions or may become one, wrists straightened that only rounding bends.
2. Refined by Newton's method on the arm itself, all rows of all poses at once; arms of few joints by least squares.
3. Merged: rows that repeat an earlier solution of their pose are left out.
4. Certified: a solution may move where a joint is free, or where the Jacobian loses rank and a step along its null
   space can be followed; and a pose stays open where nothing is proven yet.

Every row keeps its place, so that rows are the same root of the closed form in all poses.

Wrists that stand straight while an elbow or a shoulder is at its limit, where rounding hides the continuum.

Rounding splits the merged roots of the elbow by its square root. The wrist then seems bent by as much, and each of the
split roots gets turns of the wrist's outer joints that mean nothing. With the wrist locked straight both roots are one
again, and where they still reach the pose the outer joints are free.
"""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.answers.candidate_table import CandidateTable
from mafsil.ik.answers.setting import Setting
from mafsil.ik.refine import least_squares, refine_rows, wound_near
from mafsil.ik.structure.closed_form import ClosedForm
from mafsil.ik.tolerances import FINEST, HIDDEN, PART_OF_BEND, REACHED, SELF_MOTION, STRAIGHT
from mafsil.lazy_module import lazily
from mafsil.mechanics.arm_pattern import APART, FIRST_JOINTS, FOLD, LOOSE, ON_LIMIT, WRIST_JOINTS, ArmPattern, Family

if TYPE_CHECKING:
    import mafsil.ik.refine_loops as winding_loops
else:
    winding_loops = lazily("mafsil.ik.refine_loops")

NEARLY = 1e-2
"""Angle up to which a wrist may be straight but for rounding [rad]: four merged roots are split by its fourth root."""
PATIENT = 40
"""Newton steps where an equation of fourth degree has roots that merge by three or four."""


class Lists(NamedTuple):
    """Rows of many poses.

    Attributes:
        q: (k, rows, n) coordinates.
        residual: (k, rows) error of forward kinematics, distance [m] or angle [rad], the larger.
        valid: (k, rows) which rows are solutions, each of them once.
        within: (k, rows) which of them are within the joint limits.
        codes: (k, rows) branches as numbers.
        free: (k, rows) sum of 2^i over the coordinates that may be chosen; zero in rows that are no solutions.
        open: (k,) poses of which nothing is proven yet: they are searched one by one.
    """

    q: JointVector
    residual: Floats
    valid: NDArray[np.bool_]
    within: NDArray[np.bool_]
    codes: NDArray[np.int64]
    free: NDArray[np.int64]
    open: NDArray[np.bool_]


def exact_lists(setting: Setting, q: JointVector, details: CandidateTable, tolerance: float) -> Lists:
    """Lists of poses whose solutions are exact as they stand: step 3 only.

    Args:
        setting: the arm.
        q: (k, rows, n) of the closed form.
        details: of the rows.
        tolerance: largest residual of a solution.
    """
    valid = np.array(details.residual <= tolerance)
    winding_loops.unique_rows(q, valid, setting.revolute)
    within = valid & (details.excess <= ON_LIMIT)
    codes, free = _whole(details.code), np.where(valid, _whole(details.free), 0)
    return Lists(q, details.residual, valid, within, codes, free, np.zeros(len(q), dtype=np.bool_))


def refined_lists(
    setting: Setting, form: ClosedForm, T: PoseMatrix, q0: JointVector, lists: tuple[JointVector, CandidateTable, float]
) -> Lists:
    """Lists of poses whose rows have to be refined: all steps.

    Args:
        setting: the arm.
        form: its exact closed form, no joint locked.
        T: (k, 4, 4) clean poses.
        q0: (n,) values that free joints take and to which angles are wound.
        lists: coordinates and details of the closed form, and the largest residual of a solution.
    """
    q, details, tolerance = lists
    # 1. Candidates.
    usable = _candidates(setting, q, details, tolerance)
    pose_of, row = np.nonzero(usable)
    start, loose, poses = q[pose_of, row], _whole(details.free)[pose_of, row], T[pose_of]
    moved, loose = straighten_wrist(setting, form.pattern, poses, start, loose)
    # 2. Refined.
    exact = (details.residual[pose_of, row] <= min(FINEST, tolerance)) & (moved == start).all(axis=1)
    rest = np.flatnonzero(~exact)
    reached = details.residual[pose_of, row]
    if setting.few:
        moved[rest], reached[rest] = least_squares(setting.robot, moved[rest], poses[rest], setting.mask)
    else:
        steps = PATIENT if setting.quartic else 8
        moved[rest], reached[rest] = refine_rows(setting.robot, moved[rest], poses[rest], setting.mask, steps=steps)
    moved[rest] = wound_near(moved[rest], q0, setting.lower, setting.upper, setting.revolute)
    q, residual, free = q.copy(), details.residual.copy(), np.zeros(usable.shape, dtype=np.int64)
    q[pose_of, row], residual[pose_of, row], free[pose_of, row] = moved, reached, loose
    # 3. Merged.
    valid = usable & (residual <= tolerance)
    winding_loops.unique_rows(q, valid, setting.revolute)
    within = valid & setting.within_limits(q)
    free[~valid] = 0
    # 4. Certified.
    codes = _whole(details.code)
    unproven = _open(setting, form, (q, details, usable), valid, within, tolerance)
    doubtful = valid & (free == 0) & ((details.margin <= APART) | (np.abs(residual - details.residual) > 0.0))
    _add_self_motions(setting, T, q, free, doubtful & ~unproven[:, None], tolerance)
    return Lists(q, residual, valid, within, codes, free, unproven)


def complete(setting: Setting, codes: NDArray[np.int64], residual: Floats) -> bool:
    """Whether the closed form proves that there are no further solutions of a pose.

    Beside two folds at once the coordinates are known to the fourth root of the rounding: rows may be missing.

    Args:
        setting: the arm.
        codes: (k,) branches of its solutions.
        residual: (k,) of them.
    """
    if setting.quartic or setting.merged_twice(codes).any():
        return False
    return not setting.few or bool((residual <= REACHED).all())


def _candidates(setting: Setting, q: JointVector, details: CandidateTable, tolerance: float) -> NDArray[np.bool_]:
    """(k, rows) solutions and what may become one."""
    # Rows at a fold of an equation of fourth degree may be far off and still lead to a solution.
    folded = details.margin <= FOLD if setting.quartic else setting.near_folds(details)
    # A pose printed with few digits is off what an arm of few joints can do: least squares decide.
    most = max(setting.candidate, 1e3 * tolerance if setting.few else 0.0)
    return np.isfinite(q).all(axis=-1) & ((details.residual <= most) | folded)


def _open(
    setting: Setting,
    form: ClosedForm,
    rows: tuple[JointVector, CandidateTable, NDArray[np.bool_]],
    valid: NDArray[np.bool_],
    within: NDArray[np.bool_],
    tolerance: float,
) -> NDArray[np.bool_]:
    """(k,) poses whose free joints have to be chosen, where continua may cross, or where nothing was found so far."""
    q, details, usable = rows
    loose = _whole(details.free)
    inside = ((q >= setting.lower) & (q <= setting.upper)).all(axis=-1) & (details.residual <= setting.candidate)
    first = sum(1 << j for j in form.pattern.joints[: FIRST_JOINTS.get(form.pattern.family, 0)] if j >= 0)
    may_enter = _may_enter(setting, form.pattern, (q, details), first)
    chosen = may_enter.any(axis=1) & ~inside.any(axis=1)
    crossing = (usable & (loose & first > 0)).any(axis=1)
    found = valid.any(axis=1)
    least = np.fmin(details.residual, details.subproblem_residual)
    nearly = np.nan_to_num(least, nan=np.inf).min(axis=1) <= LOOSE
    missing = ~found & (nearly | (not setting.decisive) | (tolerance > LOOSE))
    unsettled = (valid & may_enter).any(axis=1) | setting.quartic
    unsettled |= (valid & setting.merged_twice(_whole(details.code))).any(axis=1)
    if setting.few:
        unsettled |= (valid & (details.residual > REACHED)).any(axis=1)
    return chosen | crossing | missing | (found & ~within.any(axis=1) & unsettled)


def _may_enter(
    setting: Setting, pattern: ArmPattern, rows: tuple[JointVector, CandidateTable], first: int
) -> NDArray[np.bool_]:
    """(k, rows) whether free joints may be chosen so that a row is within the limits, as the compiled decision says it.

    Where joints of the wrist alone are free, those that stand while it turns have to be within theirs.
    """
    q, details = rows
    loose = _whole(details.free)
    wrist = [pattern.joints[k] for k in WRIST_JOINTS.get(pattern.family, range(len(pattern.joints)))]
    standing = np.setdiff1d(np.arange(setting.robot.n), wrist)
    low, high, there = setting.lower[standing] - LOOSE, setting.upper[standing] + LOOSE, q[..., standing]
    inside = ((there >= low) & (there <= high)).all(axis=-1) & (details.residual <= setting.candidate)
    known = (loose & first == 0) & (loose < 1 << pattern.n) & (not setting.quartic)
    return np.asarray((loose > 0) & (~known | inside), dtype=np.bool_)


def _add_self_motions(
    setting: Setting, T: PoseMatrix, q: JointVector, free: NDArray[np.int64], rows: NDArray[np.bool_], tolerance: float
) -> None:
    """Add to the free coordinates of some rows the one along which they can move while the pose stays."""
    pose_of, row = np.nonzero(rows)
    if len(row):
        joint = moving_joints(setting, q[pose_of, row], T[pose_of], tolerance)
        free[pose_of, row] = np.where(joint >= 0, 1 << np.maximum(joint, 0), 0)


def _whole(x: Floats) -> NDArray[np.int64]:
    """Whole numbers; zero for NaN."""
    return np.where(np.isfinite(x), x, 0.0).astype(np.int64)


STEP = 0.02
"""Motion that proves a continuum [rad | m]."""


def moving_joints(setting: Setting, q: JointVector, T: PoseMatrix, tolerance: float) -> NDArray[np.int64]:
    """(k,) the coordinate that moves most along the continuum through each solution; -1 of isolated ones.

    1. Singular values of the Jacobian: only where one is next to nothing may anything move.
    2. The joint that moves most along the null space is moved by a step, to both sides, and locked there.
    3. Newton's method on the others: where the pose is met again and the joint is still away, the solution moves.

    Where the null space has more than one direction the same is tried along each joint's projection on it.

    Args:
        setting: the arm.
        q: (k, n) solutions.
        T: (k, 4, 4) their poses.
        tolerance: largest residual of a solution.
    """
    joint = np.full(len(q), -1)
    # 1.
    jacobians = setting.scaled_jacobians(q)
    _, values, rights = np.linalg.svd(jacobians, full_matrices=True)
    weak = np.ones((len(q), q.shape[1]), dtype=np.bool_)
    weak[:, : values.shape[1]] = values <= SELF_MOTION * values[:, :1]
    rows = np.flatnonzero(weak.any(axis=1))
    if not len(rows):
        return joint
    # 2.
    null = rights[rows] * weak[rows][:, :, None]
    sizes: Floats = np.linalg.norm(null, axis=1)
    best = np.round(sizes, 3).argmax(axis=1)
    direction = np.take_along_axis(null, best[:, None, None], axis=2)[:, :, 0]
    rates = np.einsum("ki,kij->kj", direction, null)
    way: Floats = STEP * rates / np.abs(rates).max(axis=1, keepdims=True)
    starts = np.concatenate([q[rows] + way, q[rows] - way])
    locked = np.zeros(starts.shape, dtype=np.bool_)
    locked[np.arange(len(starts)), np.tile(best, 2)] = True
    # 3.
    moved, size = refine_rows(setting.robot, starts, np.tile(T[rows], (2, 1, 1)), setting.mask, locked=locked)
    away = np.abs(moved - np.tile(q[rows], (2, 1))).max(axis=1) > STEP / 2
    moves = ((size <= tolerance) & away).reshape(2, -1).any(axis=0)
    joint[rows[moves]] = best[moves]
    return joint


def straighten_wrist(
    setting: Setting, pattern: ArmPattern, T: PoseMatrix, q: JointVector, free: NDArray[np.int64]
) -> tuple[JointVector, NDArray[np.int64]]:
    """Solutions with the wrist locked straight where that reaches the pose, and the coordinates that are free then.

    Args:
        setting: the arm.
        pattern: of its closed form.
        T: (4, 4) requested pose, or (k, 4, 4) one of each candidate.
        q: (k, n) candidates.
        free: (k,) sum of 2^i over their free coordinates.
    """
    bend, loose = pattern.joints[4:5], pattern.joints[3 if pattern.family is Family.SPHERICAL_WRIST else 5 : 6]
    if not bend or not len(q) or bend[0] < 0 or loose[0] < 0:
        return q, free
    poses = np.broadcast_to(T, (len(q), 4, 4))
    for value in setting.straight:
        off = (q[:, bend[0]] - value + np.pi) % (2 * np.pi) - np.pi
        rows = np.flatnonzero((np.abs(off) < NEARLY) & ((free >> loose[0]) % 2 == 0))
        if len(rows):
            start = q[rows]
            start[:, bend[0]] -= off[rows]
            found, residual = refine_rows(setting.robot, start, poses[rows], setting.mask, locked=bend)
            reached = residual <= np.maximum(STRAIGHT, np.minimum(HIDDEN, PART_OF_BEND * np.abs(off[rows])))
            rows = rows[reached]
            q, free = q.copy(), free.copy()
            q[rows] = found[reached]
            free[rows] += 1 << loose[0]
    return q, free
