"""Lists of many poses at once without an exact closed form: by elimination, or from rows of the nearest ideal arm.

A quarter turn printed as 1.5708 leaves an arm off the shape of its family by d ~ 1e-5. Then

1. the closed form of the ideal arm gives rows, with the branch margin m of each (zero where two branches meet) and by
   how much rows that do not exist fall short;
2. Newton's method on the arm as it is moves each row, and forward kinematics judges it.

A solution q of the arm is a solution of the ideal arm for the pose that the ideal arm has at q, which is off by d at
most, in units of the arm. While the pose moves that far a row's joints move by about d / m, and m changes by as much.
So where m^2 >> d for every row that exists, and every other row falls short by more than m, each row goes on to just
one solution and there are no others: the list is complete. `CLEAR_OF_FOLDS` is the ratio that is required. Elsewhere
elimination has to prove the list.

Reference: Kantorovich, On Newton's method for functional equations, 1948.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import partial
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
from numpy.typing import NDArray

from mafsil import threads
from mafsil.arrays import Booleans, Floats, JointVector, PoseMatrix
from mafsil.ik.answers.branch import UNNAMED
from mafsil.ik.answers.candidate_table import CandidateTable
from mafsil.ik.answers.pose_question import PoseQuestion
from mafsil.ik.answers.setting import CLEAR, Setting, turns_of
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.general.findings import MOST
from mafsil.ik.refine import distinct, wound_near
from mafsil.ik.tolerances import CLOSED, FINEST, LEAST_MARGIN, QUADRATIC, REACHED, SAME_AT_DOUBLE_ROOT
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.ik.refine_loops as judging_loops
    from mafsil.ik.general import GeneralSix, GeneralSolutions
    from mafsil.ik.general.offset_wrist import OffsetWrist
else:
    judging_loops = lazily("mafsil.ik.refine_loops")


CLEAR_OF_FOLDS = 100.0
"""The least square of a branch margin, over the defect of the arm, that keeps a row away from others."""
STEPS = 8
"""Most Newton steps; two or three are made where the defect is that of rounded angles."""
PATIENT = 24
"""The same beside folds, where each step may only halve the error."""
WAYS: Floats = np.array([1e-3, 1e-2, 0.1, 0.3, 1.0, 2.0])
"""How far from a row beside a fold along the direction that moves least [rad]."""
OFFSET_CHUNK = 256
"""Poses of an arm with an offset wrist that one thread takes at a time."""
OFFSET_FEW = 16
"""Those that are not worth another thread: some 40 us."""
KEPT_ROWS = 16384
"""Rows that are kept at once."""
ROWS = 4096
"""Solutions whose poses are kept at once."""


def _unnamed(count: int) -> dict[str, NDArray[np.int64]]:
    rows = {key: np.full(count, value, dtype=np.int64) for key, value in _UNNAMED.items()}
    for values in rows.values():
        values.setflags(write=False)
    return rows


_UNNAMED = {"rows": -1, "codes": UNNAMED, "own_free": 0}
"""Rows of no table, branches without a name, no joint that may be chosen: of all lists without a closed form."""

NO_BRANCHES = [_unnamed(count) for count in range(MOST + 1)]
"""These for as many solutions as there may be."""

NO_FINDINGS: Mapping[int, GeneralSolutions] = {}
"""Where nothing was asked of elimination."""


class Eliminated(NamedTuple):
    """Lists of solutions.

    Attributes:
        sure: (k,) whether a list is proven and needs no second look; the others hold nothing.
        q: (k, most, n) solutions in front, then NaN.
        residual: (k, most) their errors, the larger of distance and angle.
        within: (k, most) whether each is within the limits.
        codes: (k, most) their branches as numbers; None where they have no names.
        found: what elimination found of poses whose lists are not proven, by place.
    """

    sure: NDArray[np.bool_]
    q: JointVector
    residual: Floats
    within: NDArray[np.bool_]
    codes: NDArray[np.int64] | None = None
    found: Mapping[int, GeneralSolutions] = NO_FINDINGS


def eliminate_poses(setting: Setting, general: GeneralSix, T: PoseMatrix, q0: JointVector) -> Eliminated:
    """What the polynomial of an offset wrist, and elimination, prove of many poses.

    Args:
        setting: the arm.
        general: its elimination.
        T: (k, 4, 4) poses; rows that are none are not sure.
        q0: (n,) values to which angles are wound.
    """
    q, residual = np.full((len(T), MOST, setting.robot.n), np.nan), np.full((len(T), MOST), np.nan)
    sure, within = np.zeros(len(T), dtype=np.bool_), np.zeros((len(T), MOST), dtype=np.bool_)
    lists = Eliminated(sure, q, residual, within)
    if general.offset is not None:
        count = max(-(-len(T) // OFFSET_CHUNK), min(threads.available(), len(T) // OFFSET_FEW))
        work = partial(_prove_chunk, setting, general.offset, T, q0, lists, -(-len(T) // max(1, count)))
        threads.run(work, count, threads.available())
    rest = np.flatnonzero(~sure)
    if not len(rest):
        return lists
    found = general.solve_all(T[rest])
    listed: Booleans = np.asarray(np.arange(MOST) < found.count[:, None], dtype=np.bool_)
    row, place = np.nonzero(listed)
    sure[rest] = found.complete & (found.count > 0)
    for begin in range(0, len(row), ROWS):
        rows, places = row[begin : begin + ROWS], place[begin : begin + ROWS]
        solutions = found.q[rows, places]
        at = rest[rows]
        q[at, places], residual[at, places], within[at, places], _ = judge(setting, solutions, T, at, q0)
    sure &= ~(residual > CLEAR).any(axis=1)
    q[~sure], residual[~sure], within[~sure] = np.nan, np.nan, False
    return lists._replace(found={int(rest[i]): found[i] for i in np.flatnonzero(~sure[rest]).tolist()})


def _prove_chunk(
    setting: Setting, wrist: OffsetWrist, T: PoseMatrix, q0: JointVector, lists: Eliminated, size: int, k: int
) -> None:
    """What the polynomial of an offset wrist proves of one chunk, into the lists of the batch."""
    part = slice(k * size, (k + 1) * size)
    proven = wrist.solve_poses(T[part])
    q, residual, within, _ = judge(setting, proven.q, T[part], proven.rows, q0)
    rows = lists.q[part], lists.residual[part], lists.within[part], lists.sure[part]
    judging_loops.place_lists(q, residual, within, proven.counts, CLEAR, *rows)


def proven_set(question: PoseQuestion, found: GeneralSolutions) -> SolutionSet | None:
    """The complete list of one pose; None where it is not proven, or empty.

    Args:
        question: to an arm without a closed form.
        found: what elimination found.
    """
    count = int(found.count)
    if not found.complete or not count:
        return None
    T, none = question.T[None], np.zeros(count, dtype=np.int64)
    judged = judge(question.setting, found.q[:count].copy(), T, none, question.q0)
    return None if judged.worst > CLEAR else elimination_set(question, judged, isolated=False)


_new = object.__new__


def elimination_set(question: PoseQuestion, judged: JudgedSolutions, *, isolated: bool) -> SolutionSet:
    """A complete list of solutions without branches as an answer.

    Args:
        question: about the pose.
        judged: its solutions.
        isolated: whether it is known that none of them can move.
    """
    setting, q = question.setting, judged.q
    answer = _new(SolutionSet)
    vars(answer).update(
        NO_BRANCHES[len(q)], own=q, q=q, residual=judged.residual, within=judged.within, method="elimination",
        complete=True, _setting=setting, _isolated=isolated, _question=question,
    )  # fmt: skip
    if setting.part.places is not None:
        answer.q = setting.part.lift(q, question.others)
    return answer


class JudgedSolutions(NamedTuple):
    """Solutions and what forward kinematics says of them.

    Attributes:
        q: (m, n) solutions, angles wound.
        residual: (m,) their errors.
        within: (m,) which are within the limits.
        worst: the largest error.
    """

    q: JointVector
    residual: Floats
    within: NDArray[np.bool_]
    worst: float


def judge(setting: Setting, q: JointVector, T: PoseMatrix, rows: NDArray[np.int64], q0: JointVector) -> JudgedSolutions:
    """Solutions judged by forward kinematics, their angles wound in place.

    Args:
        setting: the arm.
        q: (m, n) solutions; changed.
        T: (k, 4, 4) poses.
        rows: (m,) which of them each solution belongs to.
        q0: (n,) values to which angles are wound.
    """
    residual, within = np.empty(len(q)), np.empty(len(q), dtype=np.bool_)
    reached = setting.robot.forward_kinematics(q)
    worst = judging_loops.judge_solutions(
        reached, T, rows, q0, setting.lower, setting.upper, setting.revolute, q, residual, within
    )
    return JudgedSolutions(q, residual, within, worst)


class RefinedRows(NamedTuple):
    """Rows of a batch.

    Attributes:
        clear: (k,) whether the list of a pose is complete.
        q: (k, branches, m) coordinates, wound near the preferred ones.
        residual: (k, branches) on the arm as it is; NaN in rows that are no solutions.
        codes: (k, branches) branches as numbers.
    """

    clear: NDArray[np.bool_]
    q: JointVector
    residual: Floats
    codes: NDArray[np.int64]


def refinable(setting: Setting) -> bool:
    """Whether an arm is an almost ideal one of six joints, asked for its whole pose."""
    arm = setting.arm
    return arm.form is not None and not arm.exact and not arm.locked and setting.robot.n == 6 and setting.task == "pose"


def refined_rows(setting: Setting, T: PoseMatrix, q0: JointVector) -> RefinedRows:
    """All rows of poses, refined.

    Args:
        setting: of a `refinable` arm.
        T: (k, 4, 4) clean poses; rows of NaN are none.
        q0: (m,) coordinates near which angles are wound.
    """
    form = setting.arm.form
    assert form is not None
    q, columns, _ = form.labelled(T, q0, turns_of(q0), *setting.bounds)
    details = CandidateTable.of(columns)
    defect, size = form.pattern.defect, max(1.0, form.pattern.size)
    least = max(LEAST_MARGIN, float(np.sqrt(CLEAR_OF_FOLDS * defect)))
    exists = np.isfinite(q).all(axis=-1) & (details.subproblem_residual <= least * size)
    apart = (details.margin >= least) & (details.free == 0) & (details.subproblem_residual <= REACHED)
    absent = details.subproblem_residual > least * size
    where = np.nonzero(exists)
    moved, errors = _move(setting, q[where], T[where[0]])
    residual = np.full(exists.shape, np.nan)
    residual[where] = np.where(errors <= CLEAR, errors, np.nan)
    q[where] = wound_near(moved, q0, setting.lower, setting.upper, setting.revolute)
    clear = (absent | (apart & np.isfinite(residual))).all(axis=-1)
    return RefinedRows(clear, q, residual, np.nan_to_num(details.code).astype(np.int64))


def beside_folds(setting: Setting, T: PoseMatrix, q0: JointVector) -> tuple[JointVector, Floats]:
    """Solutions of poses beside folds, sought from rows and from both sides of them; nothing is proven.

    Two rows that meet on the ideal arm are two, one or none on the arm as it is, apart along the direction in which the
    Jacobian is weakest: Newton's method is begun at several distances along it.

    Args:
        setting: of a `refinable` arm.
        T: (k, 4, 4) clean poses.
        q0: (m,) coordinates near which angles are wound.

    Returns:
        (k, `MOST`, m) solutions in front and (k, `MOST`) their errors, NaN beyond.
    """
    form, n = setting.arm.form, setting.robot.n
    assert form is not None
    starts = form.labelled(T, q0, turns_of(q0), *setting.bounds)[0]
    pose_of, row = np.nonzero(np.isfinite(starts).all(axis=-1))
    q, _ = _move(setting, starts[pose_of, row], T[pose_of], PATIENT, FINEST)
    weakest = np.linalg.svd(setting.scaled_jacobians(q))[2][:, -1]
    ways = np.concatenate([[0.0], WAYS, -WAYS])
    tries = (q[:, None] + ways[:, None] * weakest[:, None]).reshape(-1, n)
    owner = np.repeat(pose_of, len(ways))
    tries, errors = _move(setting, tries, T[owner], PATIENT, FINEST)
    found, error = np.full((len(T), MOST, n), np.nan), np.full((len(T), MOST), np.nan)
    for i in range(len(T)):
        mine = np.flatnonzero((owner == i) & (errors <= CLOSED))
        mine = mine[np.argsort(errors[mine], kind="stable")]
        kept = mine[distinct(tries[mine], setting.revolute, SAME_AT_DOUBLE_ROOT)][:MOST]
        found[i, : len(kept)] = wound_near(tries[kept], q0, setting.lower, setting.upper, setting.revolute)
        error[i, : len(kept)] = errors[kept]
    return found, error


def _move(
    setting: Setting, q: JointVector, T: PoseMatrix, steps: int = STEPS, last: float = QUADRATIC
) -> tuple[JointVector, Floats]:
    """(j, m) rows where Newton's method leads them, and (j,) their errors, the larger of angle and distance."""
    plan = setting.newton
    q, errors = q.copy(), np.full(len(q), np.inf)
    for begin in range(0, len(q), KEPT_ROWS):
        part = slice(begin, begin + KEPT_ROWS)
        rows = np.arange(*part.indices(len(q)))
        for _ in range(steps):
            if not len(rows):
                break
            out = plan.step.ufunc(q[rows], T[rows], plan.vector)
            q[rows] = out[:, : q.shape[1]]
            rows = rows[np.abs(out[:, q.shape[1] :]).max(axis=1) > last]
        left = plan.check.ufunc(q[part], T[part], plan.vector)[:, 16:]
        errors[part] = np.maximum(np.linalg.norm(left[:, :3], axis=1), np.linalg.norm(left[:, 3:], axis=1))
    return q, errors
