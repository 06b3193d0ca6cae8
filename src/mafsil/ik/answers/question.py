"""One pose for one arm, answered with care: candidates, refinement, merging, families, and the reason of a no."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.analysis import Analysis
from mafsil.ik.answers.alignment import straightened
from mafsil.ik.answers.eliminated import proven_set
from mafsil.ik.answers.family import SolutionFamily
from mafsil.ik.answers.refined_rows import refinable, refined_rows
from mafsil.ik.answers.refusal import Refusal, refusal
from mafsil.ik.answers.rows import Rows, unlabelled
from mafsil.ik.answers.search import Search
from mafsil.ik.answers.setting import Setting, turns_of
from mafsil.ik.answers.solution_set import SolutionSet, wound_near
from mafsil.ik.answers.start import Start, start_of
from mafsil.ik.answers.tangents import tangents
from mafsil.ik.closed_form import ClosedForm
from mafsil.ik.general import GeneralSolutions
from mafsil.ik.refine import distinct, least_missing, refined
from mafsil.kernels.lazy import lazy
from mafsil.mechanics.arm_pattern import Family

if TYPE_CHECKING:
    from mafsil.ik.redundant.intervals import BranchIntervals

SELF_MOTION = 1e-6
"""Singular values of the Jacobian, relative to the largest, below which a motion may leave the pose as it is."""

FOLD = 1e-6
"""Marks below which roots of an equation of fourth degree may have merged."""

SCAN = 24
"""Values around a least singular value at which it is looked for again."""


LOOSE = 1e-8
"""Tolerances, and misses of the closed form, above which a posture that is near enough is looked for."""

EXACTLY = 1e-9
"""Residuals above which the pose of an arm of few joints is met in the sense of least squares only."""

STEPS = (0.02, 2e-3, 2e-4)
"""Motions that prove a continuum [rad | m]; the small ones where a joint is known to be free and an end is near."""

STRIDE = 0.05
"""Way along a family that Newton's method goes at once [rad | m]."""

SAME = 1e-4
"""How far a joint that stands still in a family may seem to move [rad | m]."""

PATIENT = 40
"""Newton steps at the end of a family, where an elbow is straight and each of them halves the error only."""

CROSSINGS = 181
"""Values of a free joint at which it is looked whether another continuum crosses nearby."""


_BEFORE = {Family.SPHERICAL_WRIST: 3, Family.THREE_PARALLEL: 1, Family.LINKED: 1}
"""How many joints of a closed form are found before those of the wrist."""


class Question:
    """One pose for one arm.

    Attributes:
        setting: the arm.
        T: (4, 4) wanted pose.
        near: (n,) values that free and held joints take, and to which angles are wound.
        tolerance: largest residual of a solution.
        others: coordinates of the whole robot, where the joints that do not move the frame are.
        search: from many starts, and what it tried.
    """

    def __init__(
        self,
        setting: Setting,
        T: PoseMatrix,
        near: JointVector,
        tolerance: float,
        others: JointVector | None = None,
        search: Search | None = None,
    ) -> None:
        self.setting, self.T, self.near, self.tolerance = setting, T, near, tolerance
        self.others = setting.part.middle if others is None else others
        self.search = Search(setting, T, tolerance) if search is None else search

    def answer(self) -> SolutionSet:
        """The solutions."""
        arm, setting = self.setting.arm, self.setting
        sure = self._listed() if arm.form is None else self._refined() if refinable(setting) else None
        if sure is not None:
            return sure
        candidates = self._candidates(arm)
        method, proven = self._method(arm)
        if setting.few:
            q, residual = least_missing(setting.robot, candidates.q, self.T, setting.mask)
        else:
            steps = 40 if setting.quartic else 8
            q, residual = refined(setting.robot, candidates.q, self.T, setting.mask, None, held=arm.held, steps=steps)
        good = np.flatnonzero(residual <= self.tolerance)
        candidates, residual = candidates.chosen(good, q), residual[good]
        if not len(good) and not setting.decisive and not self._proven(arm, 0) and not self.unreachable:
            q, residual = self.search.anywhere()
            candidates, method, proven = unlabelled(q), "search", False
        if not len(candidates.q) and self._nearly(arm):
            # Where there is no exact solution the nearest posture may be one within the tolerance.
            q, residual = self.refusal.q[None], np.array([self.refusal.residual])
            near_enough = np.flatnonzero(residual <= self.tolerance)
            candidates, residual, proven = unlabelled(q[near_enough]), residual[near_enough], False
        proven &= not setting.few or not (residual > EXACTLY).any()
        kept = distinct(candidates.q, setting.turning)
        candidates, residual = candidates.chosen(kept, candidates.q), residual[kept]
        # Beside two folds at once the coordinates are known to the fourth root of the rounding: rows may be missing.
        proven = (proven and not setting.merged_twice(candidates.codes).any()) or self._proven(arm, len(kept))
        q = candidates.q
        if len(q):
            q = wound_near(q, self.near, setting.lower, setting.upper, setting.turning)
        within = setting.allowed(q)
        settled = self.refuted or (proven and not arm.held and not candidates.free.any())
        if len(q) and not within.any() and not settled:
            # What is listed is not all: before anything is said of the limits, it is searched within them.
            found, missing = self.search.within_limits()
            candidates = Rows(q, candidates.rows, candidates.codes, candidates.free).and_more(unlabelled(found))
            q, residual = candidates.q, np.concatenate([residual, missing])
            within = setting.allowed(q)
        rest = candidates.rows, candidates.codes, candidates.free
        return SolutionSet(self, q, residual, within, *rest, method=method, complete=proven, isolated=False)

    @lazy
    def start(self) -> Start | None:
        """Where free and held joints stand, and what is proven of the others; None of an arm without a closed form."""
        form = self.setting.arm.form
        return None if form is None else start_of(self.setting, form, self.T, self.near, self.tolerance)

    @property
    def refuted(self) -> bool:
        """Whether intervals of a held joint prove that there is no solution within the limits."""
        return self.start is not None and self.start.refuted

    @property
    def unreachable(self) -> bool:
        """Whether they prove that there is none at all."""
        return self.start is not None and self.start.unreachable

    def _listed(self) -> SolutionSet | None:
        """The complete list of an arm without a closed form; None where elimination does not prove it at once."""
        known = self.setting.arm.general is not None and self.setting.robot.n == 6
        return proven_set(self, self._eliminated) if known else None

    def _refined(self) -> SolutionSet | None:
        """The complete list of an almost ideal arm away from folds; None where nothing is proven or nothing there."""
        found = refined_rows(self.setting, self.T[None], self.near)
        rows = np.flatnonzero(np.isfinite(found.residual[0]))
        if not found.clear[0] or not len(rows):
            return None
        q, residual, none = found.q[0, rows], found.residual[0, rows], np.zeros(len(rows), dtype=np.int64)
        rest = self.setting.allowed(q), rows, found.codes[0, rows], none
        return SolutionSet(self, q, residual, *rest, method="refined closed form", complete=True, isolated=True)

    def _nearly(self, arm: Analysis) -> bool:
        """Whether the nearest posture may be within the tolerance."""
        if self.tolerance > LOOSE or arm.form is None or not self.setting.decisive:
            return self.tolerance > LOOSE
        facts = self.labelled(arm.form, self.near)[1]
        missing = np.where(np.isfinite(facts[:, :2]), facts[:, :2], np.inf)
        return bool(missing.min(initial=np.inf) <= LOOSE)

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
            return "closed form", not arm.held and not self.setting.quartic
        return "refined closed form", False

    def _candidates(self, arm: Analysis) -> Rows:
        if arm.form is None:
            return unlabelled(self._seeds if arm.general is not None else self.setting.nothing)
        start = self.start
        near = self.near if start is None else start.near
        q, facts, _ = self.labelled(arm.form, near[None])
        usable = np.isfinite(q[0]).all(axis=1)
        if arm.exact:
            # Rows at a fold of an equation of fourth degree may be far off and still lead to a solution.
            folded = (facts[0, :, 4] <= FOLD) if self.setting.quartic else self.setting.folded(facts[0])
            # A pose printed with few digits misses what an arm of few joints can do: least squares decide.
            loose = 1e3 * self.tolerance if self.setting.few else 0.0
            usable &= (facts[0, :, 0] <= max(self.setting.candidate, loose)) | folded
        rows = np.flatnonzero(usable)
        found = Rows.of(q[0, rows], facts[0, rows], rows)
        if arm.exact and not arm.held:
            found = self._straightened(arm.form, found)
        if arm.general is not None:
            # The ideal arm gives the names; what it misses near folds is found by elimination.
            return found.and_more(unlabelled(self._seeds))
        return found if arm.held else found.and_more(self._crossings(arm.form, near, found))

    def _straightened(self, form: ClosedForm, found: Rows) -> Rows:
        """Candidates with a wrist held straight that only rounding bends."""
        q, free = straightened(self.setting, form.pattern, self.T, found.q, found.free)
        return Rows(q, found.rows, found.codes, free)

    def _crossings(self, form: ClosedForm, near: JointVector, found: Rows) -> Rows:
        """Members of the continua of a free joint at which more joints become free: others cross there.

        The Jacobian loses one more rank there. Its least singular value that is not always zero is sought along the
        free joint from many values, and every least one surrounded ever more closely.
        """
        more = Rows.of(self.setting.nothing, np.zeros((0, 6)), np.zeros(0, dtype=np.int64))
        for k, code, posture in zip(found.rows, found.free, found.q, strict=True):
            # Only joints that are found before others can free these.
            first = form.pattern.joints[: _BEFORE.get(form.pattern.family, 0)]
            for j in (j for j in bits(int(code), self.setting.robot.n) if j in first):
                # Turning joints all round: solutions beyond limits are listed as well.
                bounds = (
                    (-np.inf, np.inf) if self.setting.turning[j] else (self.setting.lower[j], self.setting.upper[j])
                )
                low, high = max(bounds[0], -np.pi), min(bounds[1], np.pi)
                values, width = np.linspace(low, high, CROSSINGS), (high - low) / (CROSSINGS - 1)
                rank, strength = self._strength(form, _with(near, j, values), k, None)
                least = (strength <= np.roll(strength, 1)) & (strength < np.roll(strength, -1)) & (strength < 4 * width)
                for value in values[least]:
                    there = _with(near, j, np.array([self._weakest(form, near, k, j, float(value), width, rank)]))
                    q, facts, _ = self.labelled(form, there)
                    member = self._straightened(form, Rows.of(q[0, [k]], facts[0, [k]], np.array([k])))
                    crossing = len(bits(int(member.free[0]), self.setting.robot.n)) > 1
                    crossing &= bool(int(member.free[0]) & ~int(code)) or abs(there[0, j] - posture[j]) > SAME
                    if facts[0, k, 0] <= self.setting.candidate and crossing:
                        more = more.and_more(member)
        return more

    def _strength(self, form: ClosedForm, near: Floats, row: int, rank: int | None) -> tuple[int, Floats]:
        """The common rank of the Jacobians of a row, and the singular values that make it.

        Infinite off the pose; negative where several joints are free: they take the preferred values, not those to
        which the continuum leads.
        """
        q, facts, _ = self.labelled(form, near)
        good = facts[:, row, 0] <= self.setting.candidate
        values = np.linalg.svd(self.setting.scaled_jacobians(np.where(good[:, None], q[:, row], 0.0)), compute_uv=False)
        if rank is None:
            rank = int(np.median((values > SELF_MOTION * values[:, :1]).sum(axis=1)[good])) if good.any() else 1
        several = [len(bits(int(code), self.setting.robot.n)) > 1 for code in np.nan_to_num(facts[:, row, 2])]
        return rank, np.where(good, np.where(several, -1.0, values[:, max(rank, 1) - 1]), np.inf)

    def _weakest(
        self, form: ClosedForm, near: JointVector, row: int, joint: int, value: float, width: float, rank: int
    ) -> float:
        """The value of a free joint near which the Jacobian of a row is nearest to losing one more rank."""
        while width > 1e-12:
            values = value + np.linspace(-width, width, 2 * SCAN + 1)
            value = float(values[self._strength(form, _with(near, joint, values), row, rank)[1].argmin()])
            width *= 2 / SCAN
        return value

    def labelled(self, form: ClosedForm, near: JointVector) -> tuple[Floats, Floats, Floats]:
        """All rows of the closed form with their facts, for one or many vectors of preferred values."""
        low, high = self.setting.bounds
        return form.labelled(self.T, near, turns_of(near), low, high)

    @property
    def tried(self) -> Mapping[str, int]:
        """How many starts were tried by searches: `starts` within the limits, `free_starts` without."""
        return self.search.tried

    @lazy
    def refusal(self) -> Refusal:
        """Why there is no solution, and the nearest pose."""
        form = self.setting.arm.form
        rows = None if form is None else self.labelled(form, self.near)
        eliminated = self._proven(self.setting.arm, 0) or self.unreachable
        known = rows, self.tolerance
        return refusal(self.setting, self.T, self.near, *known, eliminated=eliminated, tried=self.tried)

    def families(self, q: JointVector, rows: NDArray[np.int64], free: NDArray[np.int64]) -> Iterator[SolutionFamily]:
        """The continuum through each solution that can move while the pose stays."""
        names, n, held = self.setting.robot.joint_names, self.setting.robot.n, self.setting.arm.held
        for k, J in enumerate(self.setting.scaled_jacobians(q)):
            U, values, Vt = np.linalg.svd(J, full_matrices=True)
            rank = int((values > SELF_MOTION * values[0]).sum())
            # A free joint moves, even where merged roots leave the posture a little off its singular surface.
            rank = min(rank, n - 1) if free[k] else rank
            null = Vt[rank:]
            if not len(null):
                continue
            cone = tangents(self.setting, q[k], null, U[:, rank:])
            preferred = [j for j in sorted({*bits(int(free[k]), n), *held}) if np.abs(null[:, j]).max() > 1e-3]
            strength = np.round(np.linalg.norm(null, axis=0), 3)
            others = [int(j) for j in np.argsort(-strength, kind="stable") if strength[j] > 0.2]
            choices: list[tuple[int, Floats]] = []
            for j in [*preferred, *others]:
                rates = self._along(q[k], null, cone, j, STEPS if j in preferred else STEPS[:1])
                if rates is not None:
                    choices.append((j, np.where(np.abs(rates) < 1e-6, 0.0, rates)))
                    if j not in preferred[:-1]:
                        break
            joints = tuple(names[j] for j, _ in choices)
            for j, rates in choices:
                moving = tuple(names[i] for i in np.flatnonzero(rates))
                follow = partial(self._member, int(rows[k]), j, q[k], rates)
                within = partial(self._intervals, int(rows[k])) if (j,) == held and rows[k] >= 0 else tuple
                part = self.setting.part
                lifted = part.lifted(rates, np.zeros(part.whole.n))
                yield SolutionFamily(k, names[j], moving, lifted, joints, self._lifted(follow), within)

    def _lifted(self, follow: Callable[[Mapping[str, float]], JointVector]) -> Callable[..., JointVector]:
        """The members of a family in coordinates of the whole robot."""
        part = self.setting.part
        return follow if part.places is None else lambda values: part.lifted(follow(values), self.others)

    def _intervals(self, row: int) -> tuple[tuple[float, float], ...]:
        """Where the held joint keeps a row of the closed form within the limits."""
        known = self._held_intervals
        if known is None or len(known.doubtful):
            return ()
        mine = known.branch == row
        return tuple((float(a), float(b)) for a, b in zip(known.low[mine], known.high[mine], strict=True))

    @lazy
    def _held_intervals(self) -> BranchIntervals | None:
        from mafsil.ik.redundant.held import branch_intervals

        return branch_intervals(self.setting, self.T) if self.setting.holds_one else None

    def _along(
        self, q: JointVector, null: Floats, cone: Floats | None, joint: int, steps: tuple[float, ...]
    ) -> JointVector | None:
        """(n,) rates of a continuum through q along which a joint moves, that of the joint one; None without."""
        directions = (null.T @ null[:, joint])[None] if cone is None else cone[np.argsort(-np.abs(cone[:, joint]))]
        for direction in directions:
            rates = direction / direction[joint] if abs(direction[joint]) > 1e-3 else None
            if rates is not None and any(self._moves(q, rates, joint, step) for step in steps):
                return rates
        return None

    def _moves(self, q: JointVector, rates: JointVector, joint: int, step: float) -> bool:
        """Whether the motion goes on for a step, to one side at least: more than a singular posture."""
        way = step * rates / np.abs(rates).max()
        for start in (q + way, q - way):
            moved, size = refined(self.setting.robot, start[None], self.T, self.setting.mask, None, held=(joint,))
            if size[0] <= self.tolerance and np.abs(moved[0] - q).max() > step / 2:
                return True
        return False

    def _member(
        self, row: int, joint: int, start: JointVector, rates: JointVector, values: Mapping[str, float]
    ) -> JointVector:
        """The member of a family with joints at values."""
        setting = self.setting
        near, names = start.copy(), setting.robot.joint_names
        chosen = [names.index(name) for name in values]
        near[chosen] = list(values.values())
        if setting.arm.form is None or row < 0:
            return self._traced(chosen, start, near, rates if chosen == [joint] else None)
        if np.abs(near - start).max() <= STRIDE:
            member = self._traced(chosen, start, near, rates if chosen == [joint] else None)
            if np.isfinite(member).all():
                return member
        for wish in self._wishes(setting.arm.form, near, chosen):
            table = setting.arm.form.solve(self.T, wish)
            q = wound_near(table.q, near, setting.lower, setting.upper, setting.turning)
            q, residual = refined(setting.robot, q, self.T, setting.mask, None, held=tuple(chosen))
            off = np.abs(q[:, chosen] - near[chosen]).max(axis=1)
            # Joints that do not move in the family stand; then the same root: another may come nearer on a long way.
            fixed = (rates == 0.0) & (chosen == [joint])
            still = np.abs(q - near)[:, fixed].max(axis=1, initial=0.0) <= SAME
            good = (residual <= self.tolerance) & (off < 1e-9) & still
            cost = np.where(good, np.abs(q - near).sum(axis=1), np.inf)
            cost[row] -= 1e3
            if np.isfinite(cost.min()):
                return q[int(cost.argmin())]
        return self._traced(chosen, start, near, rates if chosen == [joint] else None)

    def _wishes(self, form: ClosedForm, near: JointVector, chosen: list[int]) -> Iterator[JointVector]:
        """Preferred values that may lead the closed form to members with chosen joints at their values."""
        yield near
        sixth, second = (form.pattern.joints[i] if i < len(form.pattern.joints) else -1 for i in (5, 1))
        if form.pattern.family in (Family.THREE_PARALLEL, Family.LINKED) and sixth in chosen and second >= 0:
            # The closed form takes the sum of the turns about the parallel axes from joint 2: joint 6 follows it.
            off = near[sixth] - form.solve(self.T, near).q[:, sixth]
            for shift in np.unique(np.round(off[np.isfinite(off)], 12)):
                for sign in (1.0, -1.0):
                    yield _with(near, second, np.array([near[second] + sign * shift]))[0]

    def _traced(self, joints: list[int], start: JointVector, goal: JointVector, rates: Floats | None) -> JointVector:
        """Along the family in small steps, the other joints following by Newton's method; the shorter way first."""
        turns = np.where(self.setting.turning[joints], 2 * np.pi, 0.0)
        way = goal[joints] - start[joints]
        short = way - turns * np.round(way / (2 * np.pi))
        for one in (short, short - turns * np.sign(short)):
            q = self._walked(joints, start, one, rates)
            if np.isfinite(q).all():
                q[joints] = goal[joints]
                return q
        return np.full(len(start), np.nan)

    def _walked(self, joints: list[int], start: JointVector, way: JointVector, rates: Floats | None) -> JointVector:
        """The member at the end of a way of some joints; NaN where the family does not go so far."""
        setting, q, count = self.setting, start, max(1, int(np.ceil(np.abs(way).max() / STRIDE)))
        # Where other joints may move as well, Newton's step of least norm would leave the family: it is led along.
        ahead = np.zeros(len(q)) if rates is None else rates * way[0] / count
        for s in np.linspace(0.0, 1.0, count + 1)[1:]:
            before, q = q, q + ahead
            q[joints] = start[joints] + s * way
            moved, size = refined(setting.robot, q[None], self.T, setting.mask, None, steps=PATIENT, held=tuple(joints))
            if size[0] > self.tolerance:
                return np.full(len(start), np.nan)
            q = moved[0]
            ahead = q - before
        return q


def _with(near: JointVector, joint: int, values: Floats) -> Floats:
    """(k, n) copies of a joint vector with one joint at each of the values."""
    many = np.repeat(near[None], len(values), axis=0)
    many[:, joint] = values
    return many


def bits(code: int, n: int) -> tuple[int, ...]:
    """The coordinates i for which 2^i is part of a sum."""
    return tuple(i for i in range(n) if code >> i & 1)
