"""Inverse kinematics with all solutions: recognise the arm, solve it, verify, explain."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix, gate, require_kind
from mafsil.errors import InputError
from mafsil.ik.analysis import Analysis, Task, analysis, branch_of
from mafsil.ik.closed_form import Branches, ClosedForm
from mafsil.ik.problem import ORTHOGONALITY, clean_poses, reach_bound
from mafsil.ik.refine import distinct, misses, refined
from mafsil.ik.solution_set import SolutionFamily, SolutionSet, Verdict, wound_near
from mafsil.model import JointKind, Mechanism
from mafsil.robot import Robot

MASKS = {"pose": (1, 1, 1, 1, 1, 1), "position": (0, 0, 0, 1, 1, 1), "axis": (1, 1, 0, 1, 1, 1)}
"""Components of the error that each task asks for."""

MOST = 16
"""Isolated solutions that an arm of six turning joints can have."""

SELF_MOTION = 1e-6
"""Singular values of the Jacobian, relative to the largest, below which a motion may leave the pose as it is."""

SCAN = 24
"""Values of a free or held joint that are tried where the preferred one leads nowhere."""


def inverse_kinematics(
    robot: Robot,
    T_sd: ArrayLike,
    *,
    frame: str | None = None,
    task: Task = "pose",
    near: ArrayLike | None = None,
    tolerance: float = 1e-9,
) -> SolutionSet:
    """All joint vectors that bring the tip to a pose.

    Args:
        robot: any arm.
        T_sd: (4, 4) wanted pose in {s}; for batches see `closed_form` and `solve_ik`.
        frame: name of a link; the tip if None.
        task: `pose`, `position` only, or `axis`: position and direction of the tip's z axis.
        near: (n,) values that free joints and held joints of redundant arms take; the middle of their limits if None.
        tolerance: largest residual [m | rad] of a solution.

    Returns:
        The solutions with branches, families and reasons; see `SolutionSet`. Where `complete` is set there are no
        others. A redundant arm (more joints than the task needs) gets the solutions with the held joints at `near`,
        each the member of a family.

    Raises:
        InputError: a wrong shape, no pose, an unknown frame or task.
    """
    require_kind("robot", robot, "Robot", "mechanism", "forward_kinematics")
    if task not in MASKS:
        raise InputError("input.choice", name="task", value=task, known=", ".join(MASKS))
    wanted = gate("T_sd", T_sd, (4, 4))
    if wanted.ndim != 2:
        raise InputError("input.shape", name="T_sd", expected="(4, 4)", got=wanted.shape, hint="")
    clean, valid = clean_poses(wanted[None])
    if not valid[0]:
        raise InputError("ik.no_pose", name="T_sd", limit=ORTHOGONALITY)
    if frame is not None:
        robot = Robot(_with_tip(robot.mechanism, frame))
    middle = _middle(robot)
    start = middle if near is None else gate("near", near, (robot.n,), finite=True)
    return _Question(robot, clean[0], task, start, tolerance).answer()


@lru_cache(maxsize=64)
def _with_tip(mechanism: Mechanism, frame: str) -> Mechanism:
    return mechanism.with_tip(frame)


@dataclass(frozen=True, eq=False)
class _Question:
    """One pose for one arm."""

    robot: Robot
    T: PoseMatrix
    task: Task
    near: JointVector
    tolerance: float

    @property
    def mask(self) -> NDArray[np.bool_]:
        return np.array(MASKS[self.task], dtype=np.bool_)

    @property
    def turning(self) -> NDArray[np.bool_]:
        return np.array(
            [joint.kind is JointKind.REVOLUTE for joint in self.robot.mechanism.coordinates], dtype=np.bool_
        )

    def answer(self) -> SolutionSet:
        arm = analysis(self.robot.mechanism, self.task)
        q, rows, free, table = self._candidates(arm)
        if table is None and not len(q):
            method, proven = "search", False
        else:
            method, proven = self._method(arm)
        q, residual = refined(self.robot, q, self.T, self.mask, None, held=arm.held)
        good = np.flatnonzero(residual <= self.tolerance)
        q, rows, free, residual = q[good], rows[good], free[good], residual[good]
        if not len(q) and not arm.exact:
            q, residual, method, proven = *self._searched(), "search", False
            rows, free = np.full(len(q), -1), np.zeros(len(q), dtype=np.int64)
        kept = distinct(q, self.turning)
        q, rows, free, residual = q[kept], rows[kept], free[kept], residual[kept]
        return self._set(arm, q, rows, free, residual, table, method, proven)

    def _method(self, arm: Analysis) -> tuple[str, bool]:
        if arm.form is None:
            return "elimination", False
        return ("closed form", not arm.held) if arm.exact else ("refined closed form", False)

    def _candidates(self, arm: Analysis) -> tuple[JointVector, NDArray[np.int64], NDArray[np.int64], Branches | None]:
        """Candidate joint vectors, their rows in the closed form's table and their free joints."""
        if arm.form is None:
            q = arm.general.solve(self.T) if arm.general is not None else np.zeros((0, self.robot.n))
            return q, np.full(len(q), -1), np.zeros(len(q), dtype=np.int64), None
        table = self._table(arm, arm.form)
        usable = np.isfinite(table.q).all(axis=1)
        if arm.exact:
            usable &= table.residual <= 1e-5
        rows = np.flatnonzero(usable)
        return table.q[rows], rows, table.free[rows], table

    def _table(self, arm: Analysis, form: ClosedForm) -> Branches:
        """The closed form at the preferred values of free joints, else where it first finds solutions."""
        table = form.solve(self.T, self.near)
        if not arm.held and not table.free.any():
            return table
        if self._allowed(table).any():
            return table
        changed = arm.held if arm.held else _bits(int(table.free.max()), self.robot.n)
        if not changed:
            return table
        generator = np.random.default_rng(0)
        tries = np.repeat(self.near[None], SCAN * 8 ** min(len(changed) - 1, 2), axis=0)
        for j in changed:
            low, high = max(self.robot.limits.lower[j], -np.pi), min(self.robot.limits.upper[j], np.pi)
            tries[:, j] = (
                np.linspace(low, high, len(tries)) if len(changed) == 1 else generator.uniform(low, high, len(tries))
            )
        found = form.solve(self.T, tries)
        count = self._allowed(found).sum(axis=1)
        if not count.max():
            if (table.residual <= 1e-5).any():
                return table
            count = (found.residual <= 1e-5).sum(axis=1)
        best = int(np.where(count == count.max(), -np.abs(tries - self.near).max(axis=1), -np.inf).argmax())
        return Branches(found.table[best])

    def _allowed(self, table: Branches) -> NDArray[np.bool_]:
        """(*batch, branches) which rows are solutions within the limits."""
        low, high = self.robot.limits.lower, self.robot.limits.upper
        q = wound_near(table.q, self.near, low, high, self.turning)
        return (table.residual <= 1e-5) & ((q >= low) & (q <= high)).all(axis=-1)

    def _searched(self) -> tuple[JointVector, Floats]:
        """Solutions from many starts; nothing is proven."""
        from mafsil.ik.numerical import solve_ik

        if self.task == "pose":
            some = [solve_ik(self.robot, self.T, limits=False, restarts=63, rng=k) for k in range(8)]
            q = np.array([one.q for one in some if one.all_solved]).reshape(-1, self.robot.n)
        else:
            q = _middle(self.robot) + np.random.default_rng(0).uniform(-np.pi, np.pi, (256, self.robot.n))
        q, residual = refined(self.robot, q, self.T, self.mask, None, steps=60)
        good = residual <= self.tolerance
        return q[good], residual[good]

    def _set(
        self,
        arm: Analysis,
        q: JointVector,
        rows: NDArray[np.int64],
        free: NDArray[np.int64],
        residual: Floats,
        table: Branches | None,
        method: str,
        proven: bool,
    ) -> SolutionSet:
        limits, turning = self.robot.limits, self.turning
        middle = self.near
        q = wound_near(q, middle, limits.lower, limits.upper, turning) if len(q) else q
        within = np.asarray(((q >= limits.lower - 1e-12) & (q <= limits.upper + 1e-12)).all(axis=1), dtype=np.bool_)
        families = tuple(self._families(arm, q, rows, free)) if len(q) else ()
        # Six turning joints have at most sixteen solutions (Primrose, 1986).
        proven = proven or (method == "elimination" and len(q) == MOST and self.robot.n == 6)
        status, facts, nearest = self._verdict(arm, q, within, families, table, proven)
        return SolutionSet(
            q=q,
            branches=tuple(branch_of(arm, int(row)) for row in rows),
            status=status,
            families=families,
            residual=residual,
            complete=proven,
            conditioning=self._conditioning(q),
            within=within,
            q_nearest=nearest,
            T_nearest=self.robot.forward_kinematics(nearest),
            method=method,
            lower=limits.lower,
            upper=limits.upper,
            turning=turning,
            facts=facts,
        )

    def _conditioning(self, q: JointVector) -> Floats:
        J = self._scaled_jacobians(q)
        values = np.linalg.svd(J, compute_uv=False) if len(q) else np.zeros((0, 1))
        return (
            values[:, min(self.mask.sum(), self.robot.n) - 1] / np.maximum(values[:, 0], 1e-300)
            if len(q)
            else np.zeros(0)
        )

    def _scaled_jacobians(self, q: JointVector) -> Floats:
        """(k, 6, n) body Jacobians of the task, lengths in units of the reach."""
        if not len(q):
            return np.zeros((0, 6, self.robot.n))
        _, radius = reach_bound(self.robot.mechanism, None)
        length = radius if np.isfinite(radius) and radius > 0 else 1.0
        return self.robot.jacobian_body(q) * (self.mask * np.repeat([1.0, 1.0 / length], 3))[:, None]

    def _families(
        self, arm: Analysis, q: JointVector, rows: NDArray[np.int64], free: NDArray[np.int64]
    ) -> Iterator[SolutionFamily]:
        """The continuum through each solution that can move while the pose stays."""
        names, n = self.robot.joint_names, self.robot.n
        for k, J in enumerate(self._scaled_jacobians(q)):
            _, values, Vt = np.linalg.svd(J, full_matrices=True)
            null = Vt[int((values > SELF_MOTION * values[0]).sum()) :]
            if not len(null):
                continue
            preferred = [j for j in sorted({*_bits(int(free[k]), n), *arm.held}) if np.abs(null[:, j]).max() > 1e-3]
            strength = np.round(np.linalg.norm(null, axis=0), 3)
            others = [int(j) for j in np.argsort(-strength, kind="stable") if strength[j] > 0.2]
            for j in [*preferred, *others]:
                rates = null.T @ null[:, j] / (null[:, j] @ null[:, j])
                if not self._moves(q[k], rates, j):
                    continue
                rates = np.where(np.abs(rates) < 1e-6, 0.0, rates)
                moving = tuple(names[i] for i in np.flatnonzero(rates))
                yield SolutionFamily(k, names[j], moving, rates, partial(self._member, arm, int(rows[k]), j, q[k]))
                if j not in preferred[:-1]:
                    break

    def _moves(self, q: JointVector, rates: JointVector, joint: int) -> bool:
        """Whether the motion goes on for a finite way, to one side at least: more than a singular posture."""
        step = 0.02 * rates / np.abs(rates).max()
        for start in (q + step, q - step):
            moved, size = refined(self.robot, start[None], self.T, self.mask, None, held=(joint,))
            if size[0] <= self.tolerance and np.abs(moved[0] - q).max() > 0.01:
                return True
        return False

    def _member(self, arm: Analysis, row: int, joint: int, start: JointVector, value: float) -> JointVector:
        """The member of a family with the joint at a value."""
        near = start.copy()
        near[joint] = value
        if arm.form is None or row < 0:
            return self._traced(joint, start, value)
        table = arm.form.solve(self.T, near)
        q = wound_near(table.q, near, self.robot.limits.lower, self.robot.limits.upper, self.turning)
        q, residual = refined(self.robot, q, self.T, self.mask, None, held=(joint,))
        cost = np.where(residual <= self.tolerance, np.abs(q - near).sum(axis=1), np.inf)
        cost[row] *= 1.0 - 1e-9
        best = int(cost.argmin())
        if np.isfinite(cost[best]) and abs(q[best, joint] - value) < 1e-9:
            return q[best]
        return self._traced(joint, start, value)

    def _traced(self, joint: int, start: JointVector, value: float) -> JointVector:
        """Along the family in small steps, the other joints following by Newton's method."""
        q, count = start, max(1, int(np.ceil(abs(value - start[joint]) / 0.05)))
        for x in np.linspace(start[joint], value, count + 1)[1:]:
            q = q.copy()
            q[joint] = x
            moved, size = refined(self.robot, q[None], self.T, self.mask, None, held=(joint,))
            if size[0] > self.tolerance:
                return np.full(self.robot.n, np.nan)
            q = moved[0]
        return q

    def _verdict(
        self,
        arm: Analysis,
        q: JointVector,
        within: NDArray[np.bool_],
        families: tuple[SolutionFamily, ...],
        table: Branches | None,
        proven: bool,
    ) -> tuple[Verdict, dict[str, object], JointVector]:
        """Status, the facts of its sentence, and the nearest posture."""
        facts: dict[str, object] = {"count": len(q), "allowed": int(within.sum()), "families": len(families)}
        if len(q) and within.any():
            best = q[int(np.flatnonzero(within)[0])]
            return (Verdict.CONTINUUM if families else Verdict.SOLVED), facts, best
        if len(q):
            return self._beyond(q, facts)
        nearest = self._nearest(table)
        error = misses(self.robot, nearest[None], self.T, self.mask, None)[0]
        facts |= {
            "position_error": float(np.linalg.norm(error[3:])),
            "rotation_error": float(np.linalg.norm(error[:3])),
        }
        centre, radius = reach_bound(self.robot.mechanism, None)
        distance = float(np.linalg.norm(self.T[:3, 3] - centre))
        if distance > radius * (1 + 1e-12):
            return Verdict.OUT_OF_REACH, facts | {"shortfall": distance - radius}, nearest
        if arm.exact and table is not None and proven:
            shortfall = float(np.nanmin(table.shortfall))
            if shortfall > 1e-12 and not self._place_reached(nearest):
                return Verdict.OUT_OF_REACH, facts | {"shortfall": shortfall}, nearest
            return Verdict.NOT_OF_THIS_ARM, facts | {"joints": self.robot.n}, nearest
        return Verdict.NOT_FOUND, facts, nearest

    def _place_reached(self, q: JointVector) -> bool:
        """Whether the position alone can be reached, by an arm of few joints."""
        if self.robot.n >= 6 or self.task != "pose":
            return False
        _, size = refined(self.robot, q[None], self.T, np.array(MASKS["position"], dtype=np.bool_), None, steps=40)
        return bool(size[0] <= self.tolerance)

    def _beyond(self, q: JointVector, facts: dict[str, object]) -> tuple[Verdict, dict[str, object], JointVector]:
        """Every solution leaves the limits: the one that leaves them least, its worst joint and the value needed."""
        limits = self.robot.limits
        excess = np.maximum(np.maximum(limits.lower - q, q - limits.upper), 0.0)
        best = int(excess.max(axis=1).argmin())
        j = int(excess[best].argmax())
        bound = limits.lower[j] if q[best, j] < limits.lower[j] else limits.upper[j]
        named = {"joint": self.robot.joint_names[j], "value": float(q[best, j]), "bound": float(bound)}
        return Verdict.BEYOND_LIMITS, facts | named, q[best]

    def _nearest(self, table: Branches | None) -> JointVector:
        """The posture nearest to a pose that has no solution."""
        starts = [self.near[None]]
        if table is not None:
            starts.append(table.q[np.isfinite(table.q).all(axis=1)])
        q, size = refined(self.robot, np.concatenate(starts), self.T, self.mask, None, steps=40)
        return q[int(size.argmin())]


def _middle(robot: Robot) -> JointVector:
    """(n,) the middle of the limits, zero where one is missing."""
    low, high = robot.limits.lower, robot.limits.upper
    both = np.isfinite(low) & np.isfinite(high)
    return np.where(both, (np.where(both, low, 0.0) + np.where(both, high, 0.0)) / 2, 0.0)


def _bits(code: int, n: int) -> tuple[int, ...]:
    return tuple(i for i in range(n) if code >> i & 1)
