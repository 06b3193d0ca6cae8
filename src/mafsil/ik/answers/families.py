"""The continua through the solutions of one pose: the joint that may be chosen, and the members at its values.

1. The null space of the Jacobian at a solution, and the directions in it that the second order leaves.
2. A joint may be chosen where a step of it, to one side at least, can be followed by the others.
3. A member near by is found by Newton's method in strides, one far away as a row of the closed form.

Along q + t u + t^2 w / 2 + ... the pose stays to second order if J u = 0 and y' (dJ/dt u) = 0 for every y with
y' J = 0, dJ/dt at rates u: quadratic forms on the null space of the Jacobian. Where two continua cross, each has its
own direction there; where the forms have no common zero, the solution is isolated though its Jacobian is singular.

Reference: Lerbet, Analytic geometry and singularities of mechanisms, 1998 (the tangent cone).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.ik.answers.pose_question import SolutionFamily
from mafsil.ik.answers.setting import Setting, bits
from mafsil.ik.refine import refine_rows, wound_near
from mafsil.ik.structure.closed_form import ClosedForm
from mafsil.ik.tolerances import DIRECTION, FAR_ALONG, REACHED, SAME_AT_DOUBLE_ROOT, SELF_MOTION, TANGENT
from mafsil.kernels.lazy import lazy
from mafsil.lazy_module import lazily
from mafsil.mechanics.arm_pattern import Family

if TYPE_CHECKING:
    import mafsil.ik.redundant.parameter_search as locked_values
    from mafsil.ik.redundant.intervals import BranchIntervals
else:
    locked_values = lazily("mafsil.ik.redundant.parameter_search")


STARTS = 64
"""Directions from which common zeros of the forms are sought."""
TANGENT_STEPS = 30
"""Newton steps from each."""
STEPS = (0.02, 2e-3, 2e-4)
"""Motions that prove a continuum [rad | m]; the small ones where a joint is known to be free and an end is near."""
STRIDE = 0.05
"""Way along a family that Newton's method goes at once [rad | m]."""
PATIENT = 40
"""Newton steps at the end of a family, where an elbow is straight and each of them halves the error only."""


class Continua:
    """The continua of one pose.

    Attributes:
        setting: the arm.
        T: (4, 4) requested pose.
        tolerance: largest residual of a solution.
        others: coordinates of the whole robot, where the joints that do not move the frame are.
    """

    def __init__(self, setting: Setting, T: PoseMatrix, tolerance: float, others: JointVector) -> None:
        self.setting, self.T, self.tolerance, self.others = setting, T, tolerance, others

    def families(self, q: JointVector, rows: NDArray[np.int64], free: NDArray[np.int64]) -> Iterator[SolutionFamily]:
        """The continuum through each solution that can move while the pose stays."""
        names, n, locked = self.setting.robot.joint_names, self.setting.robot.n, self.setting.arm.locked
        for k, J in enumerate(self.setting.scaled_jacobians(q)):
            U, values, Vt = np.linalg.svd(J, full_matrices=True)
            rank = int((values > SELF_MOTION * values[0]).sum())
            # A free joint moves, even where merged roots leave the configuration a little off its singular surface.
            rank = min(rank, n - 1) if free[k] else rank
            null = Vt[rank:]
            if not len(null):
                continue
            cone = tangents(self.setting, q[k], null, U[:, rank:])
            preferred = [j for j in sorted({*bits(int(free[k]), n), *locked}) if np.abs(null[:, j]).max() > FAR_ALONG]
            sizes: Floats = np.linalg.norm(null, axis=0)
            motion = np.round(sizes, 3)
            others = [int(j) for j in np.argsort(-motion, kind="stable") if motion[j] > 0.2]
            choices: list[tuple[int, Floats]] = []
            for j in [*preferred, *others]:
                rates = self._along(q[k], null, cone, j, STEPS if j in preferred else STEPS[:1])
                if rates is not None:
                    choices.append((j, np.where(np.abs(rates) < SELF_MOTION, 0.0, rates)))
                    if j not in preferred[:-1]:
                        break
            joints = tuple(names[j] for j, _ in choices)
            for j, rates in choices:
                moving = tuple(names[i] for i in np.flatnonzero(rates))
                follow = partial(self._member, int(rows[k]), j, q[k], rates)
                within = partial(self._intervals, int(rows[k])) if (j,) == locked and rows[k] >= 0 else tuple
                part = self.setting.part
                lifted = part.lift(rates, np.zeros(part.whole.n))
                yield SolutionFamily(k, names[j], moving, lifted, joints, self._lift(follow), within)

    def _lift(self, follow: Callable[[Mapping[str, float]], JointVector]) -> Callable[..., JointVector]:
        """The members of a family in coordinates of the whole robot."""
        part = self.setting.part
        if part.places is None:
            return follow

        def of_whole(values: Mapping[str, float]) -> JointVector:
            return part.lift(follow(values), self.others)

        return of_whole

    def _intervals(self, row: int) -> tuple[tuple[float, float], ...]:
        """Where the locked joint keeps a row of the closed form within the limits."""
        known = self._locked_intervals
        if known is None or len(known.doubtful):
            return ()
        mine = known.branch == row
        return tuple((float(a), float(b)) for a, b in zip(known.low[mine], known.high[mine], strict=True))

    @lazy
    def _locked_intervals(self) -> BranchIntervals | None:
        return locked_values.branch_intervals(self.setting, self.T) if self.setting.holds_one else None

    def _along(
        self, q: JointVector, null: Floats, cone: Floats | None, joint: int, steps: tuple[float, ...]
    ) -> JointVector | None:
        """(n,) rates of a continuum through q along which a joint moves, that of the joint one; None without."""
        directions = (null.T @ null[:, joint])[None] if cone is None else cone[np.argsort(-np.abs(cone[:, joint]))]
        for direction in directions:
            rates = direction / direction[joint] if abs(direction[joint]) > FAR_ALONG else None
            if rates is not None and any(self._moves(q, rates, joint, step) for step in steps):
                return rates
        return None

    def _moves(self, q: JointVector, rates: JointVector, joint: int, step: float) -> bool:
        """Whether the motion goes on for a step, to one side at least: more than a singular configuration."""
        way = step * rates / np.abs(rates).max()
        for start in (q + way, q - way):
            moved, size = refine_rows(self.setting.robot, start[None], self.T, self.setting.mask, locked=(joint,))
            if size[0] <= self.tolerance and np.abs(moved[0] - q).max() > step / 2:
                return True
        return False

    def _member(
        self, row: int, joint: int, start: JointVector, rates: JointVector, values: Mapping[str, float]
    ) -> JointVector:
        """The member of a family with joints at values."""
        setting = self.setting
        target, names = start.copy(), setting.robot.joint_names
        chosen = [names.index(name) for name in values]
        target[chosen] = list(values.values())
        if setting.arm.form is None or row < 0:
            return self._trace(chosen, start, target, rates if chosen == [joint] else None)
        if np.abs(target - start).max() <= STRIDE:
            member = self._trace(chosen, start, target, rates if chosen == [joint] else None)
            if np.isfinite(member).all():
                return member
        for preferred in self._prefer(setting.arm.form, target, chosen):
            table = setting.arm.form.solve(self.T, preferred)
            q = wound_near(table.q, target, setting.lower, setting.upper, setting.revolute)
            q, residual = refine_rows(setting.robot, q, self.T, setting.mask, locked=tuple(chosen))
            off = np.abs(q[:, chosen] - target[chosen]).max(axis=1)
            # Joints that do not move in the family stand; then the same root: another may come nearer on a long way.
            fixed = (rates == 0.0) & (chosen == [joint])
            still = np.abs(q - target)[:, fixed].max(axis=1, initial=0.0) <= SAME_AT_DOUBLE_ROOT
            good = (residual <= self.tolerance) & (off < REACHED) & still
            cost = np.where(good, np.abs(q - target).sum(axis=1), np.inf)
            cost[row] -= 1e3
            if np.isfinite(cost.min()):
                return q[int(cost.argmin())]
        return self._trace(chosen, start, target, rates if chosen == [joint] else None)

    def _prefer(self, form: ClosedForm, q0: JointVector, chosen: list[int]) -> Iterator[JointVector]:
        """Preferred values that may lead the closed form to members with chosen joints at their values."""
        yield q0
        sixth, second = (form.pattern.joints[i] if i < len(form.pattern.joints) else -1 for i in (5, 1))
        if form.pattern.family in (Family.THREE_PARALLEL, Family.LINKED) and sixth in chosen and second >= 0:
            # The closed form takes the sum of the turns about the parallel axes from joint 2: joint 6 follows it.
            off: Floats = q0[sixth] - form.solve(self.T, q0).q[:, sixth]
            for shift in np.unique(np.round(off[np.isfinite(off)], 12)):
                for sign in (1.0, -1.0):
                    moved = q0.copy()
                    moved[second] += sign * shift
                    yield moved

    def _trace(self, joints: list[int], start: JointVector, goal: JointVector, rates: Floats | None) -> JointVector:
        """Along the family in small steps, the other joints following by Newton's method; the shorter way first."""
        turns = np.where(self.setting.revolute[joints], 2 * np.pi, 0.0)
        way = goal[joints] - start[joints]
        short = way - turns * np.round(way / (2 * np.pi))
        for one in (short, short - turns * np.sign(short)):
            q = self._walk(joints, start, one, rates)
            if np.isfinite(q).all():
                q[joints] = goal[joints]
                return q
        return np.full(len(start), np.nan)

    def _walk(self, joints: list[int], start: JointVector, way: JointVector, rates: Floats | None) -> JointVector:
        """The member at the end of a way of some joints; NaN where the family does not go so far."""
        setting, q, count = self.setting, start, max(1, int(np.ceil(np.abs(way).max() / STRIDE)))
        # Where other joints may move as well, Newton's step of least norm would leave the family: it is led along.
        ahead = np.zeros(len(q)) if rates is None else rates * way[0] / count
        for s in np.linspace(0.0, 1.0, count + 1)[1:]:
            before, q = q, q + ahead
            q[joints] = start[joints] + s * way
            moved, size = refine_rows(setting.robot, q[None], self.T, setting.mask, steps=PATIENT, locked=tuple(joints))
            if size[0] > self.tolerance:
                return np.full(len(start), np.nan)
            q = moved[0]
            ahead = q - before
        return q


def tangents(setting: Setting, q: JointVector, null: Floats, left: Floats) -> Floats | None:
    """(k, n) unit directions that leave the pose as it is to second order; None where all of the null space do.

    Args:
        setting: the arm.
        q: (n,) a solution.
        null: (m, n) orthonormal rows, the null space of its Jacobian.
        left: (6, l) orthonormal columns y with y' J = 0.
    """
    if len(null) < 2:
        return None
    rates = np.array([setting.scaled_jacobian_rate(q, direction) for direction in null])
    forms = left.T @ rates @ null.T
    forms = (forms + forms.transpose(2, 1, 0)) / 2
    if np.abs(forms).max(initial=0.0) <= DIRECTION:
        return None
    u = np.random.default_rng(0).normal(size=(STARTS, len(null)))
    for _ in range(TANGENT_STEPS):
        u /= np.linalg.norm(u, axis=1, keepdims=True)
        pulled = np.einsum("alb,kb->kla", forms, u)
        # The forms and their slopes, and the length kept: else Newton's method would only shorten u.
        slopes = np.concatenate([2 * pulled, u[:, None]], axis=1)
        values = np.concatenate([pulled @ u[:, :, None], np.zeros((STARTS, 1, 1))], axis=1)
        u = u - (np.linalg.pinv(slopes, rcond=TANGENT) @ values)[:, :, 0]
    u /= np.linalg.norm(u, axis=1, keepdims=True)
    worst = np.abs(np.einsum("ka,alb,kb->kl", u, forms, u)).max(axis=1)
    kept: list[Floats] = []
    for direction in u[worst <= DIRECTION] @ null:
        if all(abs(float(direction @ other)) < 1 - TANGENT for other in kept):
            kept.append(direction)
    return np.reshape(kept, (-1, len(q)))
