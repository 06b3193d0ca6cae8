"""One pose for one arm, answered with care: candidates, refinement, merging, families, and the reason of a no."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.answers.candidate_table import Candidates, CandidateTable, without_branch
from mafsil.ik.answers.eliminated import proven_set, refinable, refined_rows
from mafsil.ik.answers.families import Continua
from mafsil.ik.answers.lists import SELF_MOTION, complete, moving_joints, straighten_wrist
from mafsil.ik.answers.pose_question import SolutionFamily
from mafsil.ik.answers.refusal import Refusal, refusal, verdict_without_solution
from mafsil.ik.answers.search import Search, Start, start_of
from mafsil.ik.answers.setting import Setting, bits, turns_of
from mafsil.ik.answers.solution_set import SolutionSet
from mafsil.ik.refine import distinct, least_squares, refine_rows, wound_near
from mafsil.ik.result import IKStatus
from mafsil.ik.structure.analysis import Analysis
from mafsil.ik.structure.closed_form import ClosedForm
from mafsil.ik.tolerances import PLACE, REACHED, SAME_AT_DOUBLE_ROOT
from mafsil.kernels.lazy import lazy
from mafsil.mechanics.arm_pattern import APART, FIRST_JOINTS, FOLD, LOOSE

if TYPE_CHECKING:
    from mafsil.ik.general import GeneralSolutions

SCAN = 24
"""Values around a least singular value at which it is looked for again."""

CROSSINGS = 181
"""Values of a free joint at which it is looked whether another continuum crosses nearby."""


class Question:
    """One pose for one arm.

    Attributes:
        setting: the arm.
        T: (4, 4) requested pose.
        q0: (n,) values that free and locked joints take, and to which angles are wound.
        tolerance: largest residual of a solution.
        others: coordinates of the whole robot, where the joints that do not move the frame are.
    """

    def __init__(
        self,
        setting: Setting,
        T: PoseMatrix,
        q0: JointVector,
        tolerance: float,
        others: JointVector | None = None,
        search: Search | None = None,
    ) -> None:
        self.setting, self.T, self.q0, self.tolerance = setting, T, q0, tolerance
        self.others = setting.part.middle if others is None else others
        if search is not None:
            vars(self)["search"] = search

    @lazy
    def search(self) -> Search:
        """The searches from many starts, and what they tried."""
        return Search(self.setting, self.T, self.tolerance)

    def answer(self) -> SolutionSet:
        """The solutions."""
        arm, setting = self.setting.arm, self.setting
        sure = self._list() if arm.form is None else self._refine() if refinable(setting) else None
        if sure is not None:
            return sure
        candidates = self._candidates(arm)
        method, proven = self._method(arm)
        if setting.few:
            q, residual = least_squares(setting.robot, candidates.q, self.T, setting.mask)
        else:
            steps = 40 if setting.quartic else 8
            q, residual = refine_rows(setting.robot, candidates.q, self.T, setting.mask, locked=arm.locked, steps=steps)
        good = np.flatnonzero(residual <= self.tolerance)
        candidates, residual = candidates.chosen(good, q), residual[good]
        if not len(good) and not setting.decisive and not self._proven(arm, 0) and not self.unreachable:
            q, residual = self.search.anywhere()
            candidates, method, proven = without_branch(q), "search", False
        if not len(candidates.q) and self._nearly(arm):
            # Where there is no exact solution the nearest configuration may be one within the tolerance.
            q, residual = self.refusal.q[None], np.array([self.refusal.residual])
            near_enough = np.flatnonzero(residual <= self.tolerance)
            candidates, residual, proven = without_branch(q[near_enough]), residual[near_enough], False
        proven &= not setting.few or not (residual > REACHED).any()
        kept = distinct(candidates.q, setting.revolute)
        candidates, residual = candidates.chosen(kept, candidates.q), residual[kept]
        # Beside two folds at once the coordinates are known to the fourth root of the rounding: rows may be missing.
        proven = (proven and not setting.merged_twice(candidates.codes).any()) or self._proven(arm, len(kept))
        q = candidates.q
        if len(q):
            q = wound_near(q, self.q0, setting.lower, setting.upper, setting.revolute)
        within = setting.within_limits(q)
        settled = self.refuted or (proven and not arm.locked and not candidates.free.any())
        if len(q) and not within.any() and not settled:
            # What is listed is not all: before anything is said of the limits, it is searched within them.
            found, missing = self.search.within_limits()
            candidates = Candidates(q, candidates.rows, candidates.codes, candidates.free).and_more(
                without_branch(found)
            )
            q, residual = candidates.q, np.concatenate([residual, missing])
            within = setting.within_limits(q)
        rest = candidates.rows, candidates.codes, candidates.free
        return SolutionSet(self, q, residual, within, *rest, method=method, complete=proven, isolated=False)

    @lazy
    def start(self) -> Start | None:
        """Where free and locked joints stand, and what is proven of the others; None without a closed form."""
        form = self.setting.arm.form
        return None if form is None else start_of(self.setting, form, self.T, self.q0, self.tolerance)

    @property
    def start_q0(self) -> JointVector:
        """(n,) where free and locked joints stand; the preferred values without a closed form."""
        return self.q0 if self.start is None else self.start.q0

    @property
    def refuted(self) -> bool:
        """Whether intervals of a locked joint prove that there is no solution within the limits."""
        return self.start is not None and self.start.refuted

    @property
    def unreachable(self) -> bool:
        """Whether they prove that there is none at all."""
        return self.start is not None and self.start.unreachable

    def _list(self) -> SolutionSet | None:
        """The complete list of an arm without a closed form; None where elimination does not prove it at once."""
        known = self.setting.arm.general is not None and self.setting.robot.n == 6
        return proven_set(self, self._eliminated) if known else None

    def _refine(self) -> SolutionSet | None:
        """The complete list of an almost ideal arm away from folds; None where nothing is proven or nothing there."""
        found = refined_rows(self.setting, self.T[None], self.q0)
        rows = np.flatnonzero(np.isfinite(found.residual[0]))
        if not found.clear[0] or not len(rows):
            return None
        q, residual, none = found.q[0, rows], found.residual[0, rows], np.zeros(len(rows), dtype=np.int64)
        rest = self.setting.within_limits(q), rows, found.codes[0, rows], none
        return SolutionSet(self, q, residual, *rest, method="refined closed form", complete=True, isolated=True)

    def _nearly(self, arm: Analysis) -> bool:
        """Whether the nearest configuration may be within the tolerance."""
        if self.tolerance > LOOSE or arm.form is None or not self.setting.decisive:
            return self.tolerance > LOOSE
        details = self._rows_of(arm.form, self.q0)[1]
        missing = np.nan_to_num(np.fmin(details.residual, details.subproblem_residual), nan=np.inf)
        return bool(missing.min(initial=np.inf) <= LOOSE)

    def proven(self, count: int) -> bool:
        """Whether it is proven otherwise than by the closed form that there are so many solutions and no more."""
        return self._proven(self.setting.arm, count)

    def free_of(self, q: JointVector, details: CandidateTable) -> NDArray[np.int64]:
        """(k,) sum of 2^i over the coordinates that may be chosen, of exact rows of the closed form.

        Args:
            q: (k, n) coordinates.
            details: of them.
        """
        free = np.nan_to_num(details.free).astype(np.int64)
        uncertain = np.flatnonzero((free == 0) & (details.margin <= APART))
        if len(uncertain):
            joints = moving_joints(
                self.setting, q[uncertain], np.broadcast_to(self.T, (len(uncertain), 4, 4)), self.tolerance
            )
            free[uncertain] = np.where(joints >= 0, 1 << np.maximum(joints, 0), 0)
        return free

    def list_known(self, details: CandidateTable) -> bool:
        """Whether the closed form proves that there are no other solutions than these.

        Args:
            details: of exact rows.
        """
        if self.setting.quartic:
            # Where roots of an equation of fourth degree come near each other the list is not called exact.
            return True
        return complete(self.setting, np.nan_to_num(details.code).astype(np.int64), details.residual)

    def _proven(self, arm: Analysis, count: int) -> bool:
        """Whether elimination proves that there are so many solutions and no more."""
        return arm.general is not None and bool(self._eliminated.complete) and int(self._eliminated.count) == count

    @lazy
    def _eliminated(self) -> GeneralSolutions:
        """What elimination finds; only of arms that have it."""
        assert self.setting.arm.general is not None
        return self.setting.arm.general.solve_all(self.T)

    def know(self, found: GeneralSolutions) -> None:
        """What elimination found for this pose alone, where it was asked before."""
        vars(self)["_eliminated"] = found

    @property
    def _seeds(self) -> JointVector:
        """(k, n) solutions by elimination, to be judged by forward kinematics."""
        return self._eliminated.q[: int(self._eliminated.count)]

    def _method(self, arm: Analysis) -> tuple[str, bool]:
        if arm.form is None:
            return "elimination", False
        # Where an equation of fourth degree may have lost merged roots, elimination has to prove the list.
        if arm.exact:
            return "closed form", not arm.locked and not self.setting.quartic
        return "refined closed form", False

    def _candidates(self, arm: Analysis) -> Candidates:
        if arm.form is None:
            return without_branch(self._seeds if arm.general is not None else self.setting.nothing)
        q0 = self.start_q0
        q, details = self._rows_of(arm.form, q0)
        usable = np.isfinite(q).all(axis=1)
        if arm.exact:
            # Rows at a fold of an equation of fourth degree may be far off and still lead to a solution.
            folded = (details.margin <= FOLD) if self.setting.quartic else self.setting.near_folds(details)
            # A pose printed with few digits is off what an arm of few joints can do: least squares decide.
            loose = 1e3 * self.tolerance if self.setting.few else 0.0
            usable &= (details.residual <= max(self.setting.candidate, loose)) | folded
        rows = np.flatnonzero(usable)
        found = Candidates.of(q[rows], details.at(rows), rows)
        if arm.exact and not arm.locked:
            found = self._straighten(arm.form, found)
        if arm.general is not None:
            # The ideal arm gives the names; what it lacks near folds is found by elimination.
            return found.and_more(without_branch(self._seeds))
        return found if arm.locked else found.and_more(self._crossings(arm.form, q0, found))

    def _straighten(self, form: ClosedForm, found: Candidates) -> Candidates:
        """Candidates with a wrist locked straight that only rounding bends."""
        q, free = straighten_wrist(self.setting, form.pattern, self.T, found.q, found.free)
        return Candidates(q, found.rows, found.codes, free)

    def _crossings(self, form: ClosedForm, q0: JointVector, found: Candidates) -> Candidates:
        """Members of the continua of a free joint at which more joints become free: others cross there.

        The Jacobian loses one more rank there. Its least singular value that is not always zero is sought along the
        free joint from many values, and every least one surrounded ever more closely.
        """
        more = without_branch(self.setting.nothing)
        for k, code, candidate in zip(found.rows, found.free, found.q, strict=True):
            # Only joints that are found before others can free these.
            first = form.pattern.joints[: FIRST_JOINTS.get(form.pattern.family, 0)]
            for j in (j for j in bits(int(code), self.setting.robot.n) if j in first):
                # Revolute joints all round: solutions beyond limits are listed as well.
                bounds = (
                    (-np.inf, np.inf) if self.setting.revolute[j] else (self.setting.lower[j], self.setting.upper[j])
                )
                low, high = max(bounds[0], -np.pi), min(bounds[1], np.pi)
                values, width = np.linspace(low, high, CROSSINGS), (high - low) / (CROSSINGS - 1)
                rank, least_value = self._least_value(form, _with(q0, j, values), k, None)
                least = (
                    (least_value <= np.roll(least_value, 1))
                    & (least_value < np.roll(least_value, -1))
                    & (least_value < 4 * width)
                )
                for value in values[least]:
                    there = _with(q0, j, np.array([self._weakest(form, q0, k, j, float(value), width, rank)]))
                    q, details = self._rows_of(form, there[0])
                    member = self._straighten(form, Candidates.of(q[[k]], details.at([k]), np.array([k])))
                    crossing = len(bits(int(member.free[0]), self.setting.robot.n)) > 1
                    crossing &= (
                        bool(int(member.free[0]) & ~int(code)) or abs(there[0, j] - candidate[j]) > SAME_AT_DOUBLE_ROOT
                    )
                    if details.residual[k] <= self.setting.candidate and crossing:
                        more = more.and_more(member)
        return more

    def _least_value(self, form: ClosedForm, q0: Floats, row: int, rank: int | None) -> tuple[int, Floats]:
        """The common rank of the Jacobians of a row, and the singular values that make it.

        Infinite off the pose; negative where several joints are free: they take the preferred values, not those to
        which the continuum leads.
        """
        q, details = self._rows_of(form, q0)
        good = details.residual[:, row] <= self.setting.candidate
        values = np.linalg.svd(self.setting.scaled_jacobians(np.where(good[:, None], q[:, row], 0.0)), compute_uv=False)
        if rank is None:
            rank = int(np.median((values > SELF_MOTION * values[:, :1]).sum(axis=1)[good])) if good.any() else 1
        several = [len(bits(int(code), self.setting.robot.n)) > 1 for code in np.nan_to_num(details.free[:, row])]
        return rank, np.where(good, np.where(several, -1.0, values[:, max(rank, 1) - 1]), np.inf)

    def _weakest(
        self, form: ClosedForm, q0: JointVector, row: int, joint: int, value: float, width: float, rank: int
    ) -> float:
        """The value of a free joint near which the Jacobian of a row is nearest to losing one more rank."""
        while width > PLACE:
            values = value + np.linspace(-width, width, 2 * SCAN + 1)
            value = float(values[self._least_value(form, _with(q0, joint, values), row, rank)[1].argmin()])
            width *= 2 / SCAN
        return value

    def _rows_of(self, form: ClosedForm, q0: JointVector) -> tuple[JointVector, CandidateTable]:
        """All rows of the closed form with their details, for one or many vectors of preferred values."""
        q, columns, _ = form.labelled(self.T, q0, turns_of(q0), *self.setting.bounds)
        return q, CandidateTable.of(columns)

    @property
    def tried(self) -> Mapping[str, int]:
        """How many starts were tried by searches: `starts` within the limits, `free_starts` without."""
        return self.search.tried

    @lazy
    def verdict(self) -> IKStatus:
        """What is said where there is no solution; the nearest pose is sought only where it matters for that."""
        setting = self.setting
        if setting.few or not setting.decisive:
            return self.refusal.verdict
        return verdict_without_solution(setting, self.T, proven=True)

    @lazy
    def refusal(self) -> Refusal:
        """Why there is no solution, and the nearest pose."""
        form = self.setting.arm.form
        rows = None if form is None else self._rows_of(form, self.q0)
        eliminated = self._proven(self.setting.arm, 0) or self.unreachable
        known = rows, self.tolerance
        return refusal(self.setting, self.T, self.q0, *known, eliminated=eliminated, tried=self.tried)

    def families(self, q: JointVector, rows: NDArray[np.int64], free: NDArray[np.int64]) -> Iterator[SolutionFamily]:
        """The continuum through each solution that can move while the pose stays."""
        return Continua(self.setting, self.T, self.tolerance, self.others).families(q, rows, free)


def _with(q0: JointVector, joint: int, values: Floats) -> Floats:
    """(k, n) copies of a joint vector with one joint at each of the values."""
    many = np.repeat(q0[None], len(values), axis=0)
    many[:, joint] = values
    return many
