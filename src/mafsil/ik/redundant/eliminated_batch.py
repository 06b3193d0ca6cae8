"""Batches for arms without a closed form: by elimination of all joints but one, or by searches.

Arms with seven coordinates are asked at values of one joint, the others by elimination. Other arms without a closed
form are searched for from many starts.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.answers.branch import UNNAMED
from mafsil.ik.answers.question import LOOSE, SELF_MOTION, Question
from mafsil.ik.answers.redundant_batch import BatchRows, finite_poses
from mafsil.ik.answers.search import RESTARTS, SEARCHES
from mafsil.ik.answers.setting import Setting
from mafsil.ik.redundant.at_parameter import BESIDE, TRIED, answer_at
from mafsil.ik.redundant.form import Redundancy, redundancy
from mafsil.ik.redundant.parameter_search import beyond_sphere
from mafsil.ik.refine import pose_errors, refine_rows, residuals, wound_near
from mafsil.ik.result import IKStatus, clean_poses
from mafsil.ik.tolerances import AT_LIMIT, NEARLY_REACHED, SAME
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.ik.numerical as numerical
else:
    numerical = lazily("mafsil.ik.numerical")


ROWS = 16
"""Most solutions of six joints."""

CHUNK = 1024
"""Poses that are worked on at once."""


def counted_by_elimination(setting: Setting) -> bool:
    """Whether the arm has seven coordinates and no closed form: one is locked, six are found by elimination."""
    arm = setting.arm
    return setting.task == "pose" and arm.form is None and arm.chain is not None and len(arm.chain) == 7


@dataclass(frozen=True, eq=False)
class _Found:
    """The first solutions of k poses that were found, and those within the limits.

    Attributes:
        q: (k, ROWS, 7) coordinates.
        residual: (k, ROWS) of solutions, NaN elsewhere.
        listed: (k,) whether there is a solution.
        within: (k,) whether one is within the limits.
    """

    q: JointVector
    residual: Floats
    listed: NDArray[np.bool_]
    within: NDArray[np.bool_]


def eliminated_batch(setting: Setting, T: PoseMatrix, near: JointVector, tolerance: float) -> tuple[NDArray[Any], ...]:
    """Solutions of many poses with one joint locked, at values that are tried as for one pose.

    For each chunk of poses:

    1. The preferred value is tried for all poses.
    2. A pose beyond the sphere that the frame cannot leave has no solution.
    3. For the others a search looks for a solution within the limits: the spread values beside its own are tried.
    4. All spread values are tried, the nearest first.
    5. Poses without a solution within the limits for which a configuration with a joint at its limit may lead to one,
       and those without any, are answered one by one. The others keep the first solutions that were found.
    6. A solution whose Jacobian has full rank is the member of a continuum; without one the pose is answered alone.

    Args:
        setting: an arm for which `counted_by_elimination` holds.
        T: (k, 4, 4) poses; rows that are none are told so.
        near: (7,) values that the redundant joint takes, and to which angles are wound.
        tolerance: largest residual of a solution.

    Returns:
        As `redundant_batch`.
    """
    form, out = redundancy(setting.robot), BatchRows(len(T), ROWS, 7)
    out.codes[:] = UNNAMED
    clean, valid = clean_poses(finite_poses(T))
    for begin in range(0, len(T), CHUNK):
        part = begin + np.flatnonzero(valid[begin : begin + CHUNK])
        if len(part):
            _answer(setting, form, clean, part, near, tolerance, out)
    used = max(1, int(out.valid.sum(axis=1).max(initial=0)))
    columns = (out.q, out.valid, out.within, out.residual, out.codes, out.free)
    return (*(one[:, :used] for one in columns), out.status)


def _answer(
    setting: Setting,
    form: Redundancy,
    T: PoseMatrix,
    part: NDArray[np.intp],
    near: JointVector,
    tolerance: float,
    out: BatchRows,
) -> None:
    """The rows `part` of a batch."""
    poses, count = T[part], len(part)
    found = _Found(
        np.full((count, ROWS, 7), np.nan),
        np.full((count, ROWS), np.nan),
        np.zeros(count, dtype=np.bool_),
        np.zeros(count, dtype=np.bool_),
    )
    spread = form.spread(TRIED)
    # 1.
    every = np.arange(count)
    _try(setting, form, poses, every, np.full(count, near[form.locked]), tolerance, found)
    # 2.
    beyond = ~found.listed & beyond_sphere(setting, poses, tolerance) & (tolerance <= LOOSE)
    # 3.
    rows = np.flatnonzero(~found.within & ~beyond)
    if len(rows):
        q, residual = sought_within_limits(setting, poses[rows], tolerance)
        rows, own = rows[np.isfinite(residual)], form.value(q[np.isfinite(residual)])
        order = np.argsort(np.abs(spread - own[:, None]), axis=1, kind="stable")
        for values in (*spread[order[:, :BESIDE]].T, own):
            left = ~found.within[rows]
            _try(setting, form, poses, rows[left], values[left], tolerance, found)
    # 4.
    for value in spread[np.argsort(np.abs(spread - near[form.locked]), kind="stable")]:
        rows = np.flatnonzero(~found.within & ~beyond)
        _try(setting, form, poses, rows, np.full(len(rows), value), tolerance, found)
    # 5.
    alone = ~found.listed & ~beyond
    rows = np.flatnonzero(found.listed & ~found.within)
    alone[rows] = _may_end_at_limits(setting, form, poses[rows])
    # 6.
    settled = np.flatnonzero(~alone & ~beyond)
    smooth = np.zeros((count, ROWS), dtype=np.bool_)
    solutions = np.isfinite(found.residual) & ~alone[:, None]
    smooth[solutions] = regular(setting, found.q[solutions])
    alone[settled] |= found.within[settled] & ~smooth[settled].any(axis=1)
    settled = settled[~alone[settled]]
    places = part[settled]
    out.q[places], out.residual[places] = found.q[settled], found.residual[settled]
    out.valid[places] = np.isfinite(found.residual[settled])
    out.within[places] = out.valid[places] & setting.within_limits(found.q[settled])
    out.set_status(places, IKStatus.CONTINUUM)
    out.set_status(places[~found.within[settled]], IKStatus.NOT_FOUND_WITHIN_LIMITS)
    out.set_status(part[beyond], IKStatus.OUT_OF_REACH)
    for i in np.flatnonzero(alone):
        out.write(int(part[i]), answer_at(Question(setting, poses[i], near, tolerance)))


def _try(
    setting: Setting,
    form: Redundancy,
    T: PoseMatrix,
    rows: NDArray[np.intp],
    values: Floats,
    tolerance: float,
    found: _Found,
) -> None:
    """Solutions of some poses with the redundant joint at values (one for each), kept if better than what is known."""
    if not len(rows):
        return
    # As `solve_known_form` does it for one pose.
    poses = T[rows]
    table = form.solve(poses, values[:, None])
    q, residual = table.q[:, 0], np.full((len(rows), ROWS), np.nan)
    pose, place = np.nonzero(table.residual[:, 0] <= NEARLY_REACHED)
    q[pose, place], residual[pose, place] = refine_rows(
        setting.robot, q[pose, place], poses[pose], setting.mask, locked=(form.locked,)
    )
    good = residual <= tolerance
    _keep_first(setting, q, good)
    # Solutions in front, in their order.
    order = np.argsort(~good, axis=1, kind="stable")
    q, good = np.take_along_axis(q, order[..., None], axis=1), np.take_along_axis(good, order, axis=1)
    residual = np.where(good, np.take_along_axis(residual, order, axis=1), np.nan)
    q[~good] = np.nan
    listed = np.asarray(good.any(axis=1), dtype=np.bool_)
    within = np.asarray((good & setting.within_limits(q)).any(axis=1), dtype=np.bool_)
    better = within | (listed & ~found.listed[rows])
    chosen = rows[better]
    found.q[chosen], found.residual[chosen] = q[better], residual[better]
    found.listed[chosen], found.within[chosen] = True, within[better]


def _keep_first(setting: Setting, q: JointVector, good: NDArray[np.bool_]) -> None:
    """Rows that repeat an earlier solution of their pose are no longer good."""
    for k in range(1, ROWS):
        for j in range(k):
            both = np.flatnonzero(good[:, k] & good[:, j])
            if len(both):
                d: Floats = q[both, k] - q[both, j]
                d = np.where(setting.revolute, (d + np.pi) % (2 * np.pi) - np.pi, d)
                good[both, k] = np.abs(d).max(axis=1) > SAME


def _may_end_at_limits(setting: Setting, form: Redundancy, T: PoseMatrix) -> NDArray[np.bool_]:
    """(k,) for which poses a configuration with one joint at a limit has the others within theirs."""
    found = np.zeros(len(T), dtype=np.bool_)
    if not len(T):
        return found
    for joint, limit, method in form.limited:
        others = method.solve_all(T).q
        q = wound_near(
            np.insert(others, joint, limit, axis=-1), setting.middle, setting.lower, setting.upper, setting.revolute
        )
        q[..., joint] = np.where(np.isnan(q[..., joint]), np.nan, limit)
        inside = (q >= setting.lower - AT_LIMIT) & (q <= setting.upper + AT_LIMIT)
        found |= np.any(np.all(inside, axis=-1), axis=1)
    return found


SAMPLES = 16
"""Random configurations from which the rank of the Jacobian at regular ones is read."""

CHUNK = 4096
"""Poses that are worked on at once."""


def is_search_only(setting: Setting) -> bool:
    """Whether nothing better than a search is known of the arm: no closed form, no elimination of all joints or six."""
    arm = setting.arm
    eliminated = setting.task == "pose" and arm.chain is not None and len(arm.chain) == 7
    return arm.chain is not None and arm.form is None and arm.general is None and not eliminated


def search_batch(setting: Setting, T: PoseMatrix, q0: JointVector, tolerance: float) -> tuple[NDArray[Any], ...]:
    """For every pose a solution within the limits, if one is found; the other poses are answered one by one.

    For each chunk of poses:

    1. A solution within the limits is sought by the search with which the single answer begins.
    2. It is brought to working precision where that leaves no limit.
    3. Where the Jacobian has the rank of regular configurations, less than the number of joints, the solution is the
       member of a continuum (constant rank theorem); with as many joints it is isolated.
    4. Other poses are answered one by one: not found so, or at a singular configuration.

    Args:
        setting: an arm without closed form and without elimination.
        T: (k, 4, 4) poses; rows that are no poses get `NOT_A_POSE`.
        q0: (n,) values to which angles are wound.
        tolerance: largest residual of a solution.

    Returns:
        As `redundant_batch`, one row for every pose where no careful answer has more.
    """
    clean, valid = clean_poses(finite_poses(T))
    n = setting.robot.n
    verdict = IKStatus.CONTINUUM if regular_rank(setting) < n else IKStatus.SOLVED
    q, residual, sure = np.full((len(T), n), np.nan), np.full(len(T), np.nan), np.zeros(len(T), dtype=np.bool_)
    for begin in range(0, len(T), CHUNK):
        part = begin + np.flatnonzero(valid[begin : begin + CHUNK])
        # 1. and 2.
        found, residual[part] = sought_within_limits(setting, clean[part], tolerance)
        q[part] = wound_near(found, q0, setting.lower, setting.upper, setting.revolute)
        # 3.
        solved = (residual[part] <= tolerance) & setting.within_limits(q[part])
        sure[part[solved]] = regular(setting, q[part[solved]])
    # 4.
    careful = {int(i): Question(setting, clean[i], q0, tolerance).answer() for i in np.flatnonzero(valid & ~sure)}
    out = BatchRows(len(T), max([int(sure.any()), *map(len, careful.values())]), n)
    out.codes[:] = UNNAMED
    if sure.any():
        out.q[sure, 0], out.residual[sure, 0] = q[sure], residual[sure]
        out.valid[sure, 0] = out.within[sure, 0] = True
        out.set_status(sure, verdict)
    for i, answer in careful.items():
        out.write(i, answer)
    return out.columns


def sought_within_limits(setting: Setting, T: PoseMatrix, tolerance: float) -> tuple[JointVector, Floats]:
    """Solutions within the limits as `Search.within_limits` finds them for one pose.

    Args:
        setting: any arm.
        T: (k, 4, 4) poses.
        tolerance: largest residual of a solution.

    Returns:
        (k, n) coordinates and (k,) residuals, NaN where none is found.
    """
    robot, mask = setting.robot, setting.mask
    q, residual = np.full((len(T), robot.n), np.nan), np.full(len(T), np.nan)
    for seed in range(SEARCHES // 2):
        rows = np.flatnonzero(np.isnan(residual))
        if not len(rows):
            break
        found = numerical.solve_ik(robot, T[rows], task=setting.task, tolerance=tolerance, restarts=RESTARTS, seed=seed)
        start, rows = found.nearest[found.solved], rows[found.solved]
        before = residuals(pose_errors(robot, start, T[rows], mask))
        better, after = refine_rows(robot, start, T[rows], mask)
        kept = setting.within_limits(better) & (after <= before)
        q[rows], residual[rows] = np.where(kept[:, None], better, start), np.where(kept, after, before)
    return q, residual


def regular(setting: Setting, q: JointVector) -> NDArray[np.bool_]:
    """(k,) at which configurations (k, n) the Jacobian of the task has the rank that it has at random ones."""
    if not len(q):
        return np.zeros(0, dtype=np.bool_)
    return _ranks(setting, q) == regular_rank(setting)


@lru_cache(maxsize=128)
def regular_rank(setting: Setting) -> int:
    """The largest rank that the Jacobian of the task has at random configurations."""
    return int(_ranks(setting, np.random.default_rng(0).uniform(-np.pi, np.pi, (SAMPLES, setting.robot.n))).max())


def _ranks(setting: Setting, q: JointVector) -> NDArray[np.int64]:
    values = np.linalg.svd(setting.scaled_jacobians(q), compute_uv=False)
    return (values > SELF_MOTION * values[:, :1]).sum(axis=1)
