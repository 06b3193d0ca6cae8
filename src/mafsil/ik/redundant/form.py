"""Seven coordinates: all configurations at a value of the free parameter, sweeps over it, and its intervals.

The parameter is the arm angle where shoulder and wrist are spherical, else the value of a joint that is locked so that
the six others have a closed form, else that of a joint whose six others are solved by elimination.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix, as_batch
from mafsil.errors import InputError
from mafsil.ik.answers.setting import setting
from mafsil.ik.chain import Chain, chain_of, moving_part
from mafsil.ik.general import GeneralSix
from mafsil.ik.redundant.intervals import certify_intervals, programs, range_of
from mafsil.ik.redundant.parametric_form import (
    ArmAngleForm,
    ParametricForm,
    ParametricSolutions,
    arm_angle_form,
    form_of_pattern,
    has_redundant_joints,
    parametric_form,
)
from mafsil.ik.refine import refine_rows, wound_near
from mafsil.ik.result import ORTHOGONALITY, clean_poses, printed_pose
from mafsil.ik.structure.analysis import analysis, recognise_locked
from mafsil.ik.structure.closed_form import ClosedForm
from mafsil.ik.tolerances import INSIDE, REACHED, RELATIVELY
from mafsil.kernels.lazy import lazy
from mafsil.robot import Robot, of_robot

MERGING = 40
"""Newton steps where two branches merge, each of which halves the error only."""

ARM_ANGLE = "arm angle"
"""Name of the parameter of arms with a spherical shoulder and a spherical wrist."""

GRID = 360
"""Values at which intervals are looked for where nothing better is known."""


@dataclass(frozen=True, eq=False)
class SelfMotionFamily:
    """Configurations of one branch while the parameter goes through an interval, all within the joint limits.

    Attributes:
        parameter: `arm angle`, or the name of a joint.
        low, high: ends of the interval [rad | m]; of a full turn, or across pi, `high` exceeds pi.
        branch: place of the branch in the tables of `Redundancy.solve`.
        certain: whether it is proven that every value in it, and none beside it but for 1e-9, is within the limits.
        at: configuration (7,) at a value of the parameter; NaN where there is none.
    """

    parameter: str
    low: float
    high: float
    branch: int
    certain: bool
    at: Callable[[float], JointVector]


@dataclass(frozen=True, eq=False)
class Redundancy:
    """How the configurations of an arm with seven coordinates are counted: by arm angle, or by the value of a joint.

    Attributes:
        robot: with seven coordinates.
        parameter: `arm angle`, or the name of the locked joint.
        angle_form: of arms with an arm angle.
        closed: closed form of the other joints.
        locked: coordinate of the locked joint; -1 with an arm angle.
    """

    robot: Robot
    parameter: str
    angle_form: ArmAngleForm | None
    closed: ClosedForm | None
    locked: int

    def solve(self, T: ArrayLike, values: ArrayLike) -> ParametricSolutions:
        """All configurations of poses at values of the parameter.

        Args:
            T: (*batch, 4, 4) poses of the tip in {s}.
            values: (m,) or (*batch, m) of the parameter [rad | m].

        Raises:
            InputError: a wrong shape, or no poses.
        """
        X = as_batch("T", T, (4, 4)) if self.kernels is not None else _poses(T)
        given = np.atleast_1d(as_batch("values", values, (), finite=True))
        if given.ndim > 1 and given.shape[:-1] != X.shape[:-2]:
            expected = str((*X.shape[:-2], "m")).replace("'", "")
            raise InputError("input.shape", name="values", expected=expected, got=given.shape, hint="")
        return self._judge(X, np.broadcast_to(given, (*X.shape[:-2], given.shape[-1])))

    def sweep(self, T: ArrayLike, count: int = 16) -> ParametricSolutions:
        """All configurations of poses at evenly spread values of the parameter: over the turn, or the joint's range.

        Args:
            T: (*batch, 4, 4) poses of the tip in {s}.
            count: of values.
        """
        return self.solve(T, _spread(self, count))

    def value(self, q: ArrayLike) -> Floats:
        """(*batch,) the parameter of configurations (*batch, 7) [rad | m]."""
        x = as_batch("q", q, (7,))
        return x[..., self.locked] if self.angle_form is None else self.angle_form.angle(x)

    def families(self, T: ArrayLike) -> tuple[SelfMotionFamily, ...]:
        """Intervals of the parameter in which one pose (4, 4) is reached within the limits, branch by branch.

        With an arm angle they end at the roots of equations of second degree. With a locked joint interval arithmetic
        proves of every value, but for gaps of 1e-9, whether it belongs to one; where it does not succeed, or
        the closed form solves equations of fourth degree, `certain` is not set. Empty where branches cannot be told
        apart along the parameter (elimination).

        Raises:
            InputError: a wrong shape, or no pose.
        """
        X = _poses(T)
        if X.ndim != 2:
            raise InputError("input.shape", name="T", expected="(4, 4)", got=X.shape, hint="")
        return tuple(
            SelfMotionFamily(self.parameter, low, high, branch, certain, partial(self._member, X, branch))
            for low, high, branch, certain in self.intervals(X)
        )

    def intervals(self, X: PoseMatrix) -> list[tuple[float, float, int, bool]]:
        """Ends, branch, and whether they are certain, of the intervals of one pose (4, 4) that is one."""
        if self.angle_form is not None:
            return self._between(X, self.angle_form)
        if self.closed is None:
            return []
        own = setting(self.robot, None, "pose")
        given = programs(self.closed.pattern, self.locked, tuple(map(float, own.middle)))
        domain = self.domain(X)
        if given is None or self.closed.pattern.quartic:
            return [(*one, False) for one in self._sample(X, np.linspace(*domain, GRID))]
        found = certify_intervals(given, X, self.locked, domain, own.lower, own.upper, ~own.revolute)
        sure = [(float(a), float(b), int(k), True) for a, b, k in zip(found.low, found.high, found.branch, strict=True)]
        doubtful = [(float(a), float(b), int(k)) for k, a, b in found.doubtful]
        return sure + [(*one, False) for one in self._in_doubt(X, doubtful)]

    @property
    def proves(self) -> bool:
        """Whether an empty list of intervals proves that there is no configuration within the limits."""
        return self.angle_form is not None or (self.closed is not None and not self.closed.pattern.quartic)

    def _between(self, X: PoseMatrix, form: ArmAngleForm) -> list[tuple[float, float, int, bool]]:
        """Of an arm angle: between two neighbouring angles at which a joint meets a limit nothing changes."""
        found: list[tuple[float, float, int, bool]] = []
        for elbow, ends in enumerate(form.breaks(X, *(setting(self.robot, None, "pose").bounds))):
            if not len(ends):
                continue
            nexts = np.append(ends[1:], ends[0] + 2 * np.pi)
            wide = nexts - ends > RELATIVELY
            starts, nexts = ends[wide], nexts[wide]
            within = self._judge(X, (starts + nexts) / 2).within
            for branch in range(4 * elbow, 4 * elbow + 4):
                for first, last in _runs(within[:, branch]):
                    whole = first < 0
                    low, high = (-np.pi, np.pi) if whole else (float(starts[first]), float(nexts[last]))
                    found.append((low, high + 2 * np.pi * (high < low), branch, True))
        return found

    def domain(self, X: PoseMatrix) -> tuple[float, float]:
        """Ends of the values of the locked joint that have to be looked at for a pose (4, 4)."""
        limits = self.robot.limits
        ends = float(limits.lower[self.locked]), float(limits.upper[self.locked])
        return range_of(self._chain, self.locked, *ends, limits, X)

    def _in_doubt(self, X: PoseMatrix, cells: list[tuple[float, float, int]]) -> list[tuple[float, float, int]]:
        """Those cells that are within the limits at both ends and in the middle, neighbours joined."""
        if not cells:
            return []
        low, high, branch = (np.array(x) for x in zip(*sorted(cells, key=lambda one: (one[2], one[0])), strict=True))
        values = np.stack([low, (low + high) / 2, high])
        within = self._judge(X, values.reshape(-1)).within[np.arange(values.size), np.tile(branch, 3)]
        found: list[tuple[float, float, int]] = []
        for k in np.flatnonzero(within.reshape(3, -1).all(axis=0)):
            if found and found[-1][2] == branch[k] and found[-1][1] >= low[k]:
                found[-1] = (found[-1][0], float(high[k]), int(branch[k]))
            else:
                found.append((float(low[k]), float(high[k]), int(branch[k])))
        return found

    def _sample(self, X: PoseMatrix, values: Floats) -> list[tuple[float, float, int]]:
        """Intervals seen at some values of a locked joint, their ends by halving; shorter ones may be missed."""
        good = self._judge(X, values).within
        runs = [
            (branch, max(first, 0), last if first >= 0 else len(values) - 1)
            for branch in range(good.shape[1])
            for first, last in _runs(good[:, branch], around=False)
        ]
        if not runs:
            return []
        step = values[1] - values[0]
        branch, begins, ends = np.array(runs).T
        inside = np.stack([values[begins], values[ends]])
        outside = np.clip(inside + np.array([[-step], [step]]), values[0], values[-1])
        low, high = self._edges(X, inside, outside, branch)
        return [(float(a), float(b), int(k)) for a, b, k in zip(low, high, branch, strict=True)]

    def _member(self, X: PoseMatrix, branch: int, value: float) -> JointVector:
        one = self._judge(X, np.array([value]))
        if one.residual[0, branch] <= REACHED or self.closed is None:
            return np.where(one.residual[0, branch] <= REACHED, one.q[0, branch], np.nan)
        # At the end of an interval two branches may merge: the table is off by the square root of the rounding.
        own = setting(self.robot, None, "pose")
        near = own.middle.copy()
        near[self.locked] = value
        start = self.closed.solve(X, near).q[branch]
        q, residual = refine_rows(self.robot, start[None], X, own.mask, steps=MERGING, locked=(self.locked,))
        wound = wound_near(q[0], near, own.lower, own.upper, own.revolute)
        return np.where(residual[0] <= REACHED, wound, np.nan)

    def _edges(self, X: PoseMatrix, inside: Floats, outside: Floats, branch: NDArray[np.int64]) -> Floats:
        """(2, k) ends of intervals between values inside and outside, all halved together."""
        columns = np.arange(2 * len(branch)), np.tile(branch, 2)
        for _ in range(36):
            middle = (inside + outside) / 2
            fits = self._judge(X, middle.reshape(-1)).within[columns].reshape(inside.shape)
            inside, outside = np.where(fits, middle, inside), np.where(fits, outside, middle)
        return inside

    def spread(self, count: int) -> Floats:
        """Evenly spread values of the parameter, (count,): over the turn, or the range of the joint [rad]."""
        return _spread(self, count).copy()

    def _judge(self, X: PoseMatrix, values: Floats) -> ParametricSolutions:
        if self.kernels is not None:
            q, residual, within = self._labelled_rows(self.kernels, X, values)
        else:
            q = self._eliminate(X, values)
            residual, within = self._check(X, values, q)
        return ParametricSolutions(values, q, residual, within, self.kernels is not None)

    @lazy
    def kernels(self) -> ParametricForm | None:
        """Of poses and values to configurations; None where the other joints are solved by elimination."""
        if self.angle_form is not None:
            return self.angle_form.kernels
        return None if self.closed is None else form_of_pattern(self.closed.pattern)

    @lazy
    def regular(self) -> ParametricForm | None:
        """The kernels that also say whether an answer is regular; None where an equation of fourth degree is solved."""
        if self.closed is None or self.closed.pattern.quartic:
            return None if self.angle_form is None else self.angle_form.kernels
        own = setting(self.robot, None, "pose")
        shared = own.arm.form is self.closed and has_redundant_joints(own)
        return parametric_form(own) if shared else form_of_pattern(self.closed.pattern)

    def _labelled_rows(
        self, form: ParametricForm, X: PoseMatrix, values: Floats
    ) -> tuple[JointVector, Floats, NDArray[np.bool_]]:
        """Configurations, their residuals, and which are within the limits: all by one kernel."""
        own = setting(self.robot, None, "pose")
        preferred = own.middle, own.middle_turns, *own.bounds
        q, residual, excess, defect = form.configurations(X[..., None, :, :], values[..., None], *preferred, REACHED)
        if not np.less_equal(defect, ORTHOGONALITY).all():
            return self._labelled_rows(form, printed_pose("T", X), values)
        return q, residual, excess <= INSIDE

    def _check(self, X: PoseMatrix, values: Floats, q: JointVector) -> tuple[Floats, NDArray[np.bool_]]:
        """Residuals of configurations, and which are within the limits, into which they are wound in place."""
        own = setting(self.robot, None, "pose")
        off = self.robot.forward_kinematics(q) - X[..., None, None, :, :]
        distance, chord = (off[..., :3, 3] ** 2).sum(axis=-1), (off[..., :3, :3] ** 2).sum(axis=(-2, -1))
        angle = 2 * np.arcsin(np.minimum(1.0, np.sqrt(chord / 8)))
        residual = np.maximum(np.sqrt(distance), angle)
        wound = wound_near(q, own.middle, own.lower, own.upper, own.revolute)
        wound[..., self.locked] = np.where(np.isnan(residual), np.nan, values[..., None])
        q[...] = wound
        inside = (q >= own.lower - INSIDE) & (q <= own.upper + INSIDE)
        return residual, (residual <= REACHED) & inside.all(axis=-1)

    def _eliminate(self, X: PoseMatrix, values: Floats) -> JointVector:
        """Every value gives another arm of six joints; poses with the same value are solved together."""
        chain = self._chain
        q = np.full((*values.shape, 16, 7), np.nan)
        flat, poses = values.reshape(-1), np.broadcast_to(X[..., None, :, :], (*values.shape, 4, 4)).reshape(-1, 4, 4)
        rows = q.reshape(-1, 16, 7)
        others = [k for k in range(7) if k != self.locked]
        for value in np.unique(flat):
            same = np.flatnonzero(flat == value)
            found = _lock(chain, self.locked, float(value)).solve_all(poses[same])
            rows[same[:, None], :, others] = np.moveaxis(found.q, -1, 1)
            rows[same, :, self.locked] = np.where(np.isnan(found.q[..., 0]), np.nan, value)
        return q

    @lazy
    def limited(self) -> tuple[tuple[int, float, GeneralSix], ...]:
        """Every joint but the locked one at each of its limits, with the elimination of the six others."""
        low, high = self.robot.limits.lower, self.robot.limits.upper
        return tuple(
            (k, float(limit), GeneralSix(self._chain.lock_joint(k, float(limit))))
            for k in range(7)
            for limit in (low[k], high[k])
            if k != self.locked and np.isfinite(limit)
        )

    @lazy
    def _chain(self) -> Chain:
        chain = chain_of(self.robot.mechanism)
        assert chain is not None
        return chain


@lru_cache(maxsize=256)
def _spread(form: Redundancy, count: int) -> Floats:
    """The values of `Redundancy.spread`, made once."""
    if form.angle_form is not None:
        values = np.linspace(-np.pi, np.pi, count, endpoint=False)
    else:
        values = np.linspace(*form.domain(np.eye(4)), count)
    values.setflags(write=False)
    return values


def _runs(good: NDArray[np.bool_], *, around: bool = True) -> list[tuple[int, int]]:
    """First and last place of every run of configurations; (-1, -1) for a whole turn."""
    if around and good.all():
        return [(-1, -1)]
    before = np.roll(good, 1) if around else np.append(False, good[:-1])
    after = np.roll(good, -1) if around else np.append(good[1:], False)
    begins, ends = np.flatnonzero(good & ~before), np.flatnonzero(good & ~after)
    if len(ends) and ends[0] < begins[0]:
        ends = np.roll(ends, -1)
    return [(int(a), int(b)) for a, b in zip(begins, ends, strict=True)]


@of_robot
def redundancy(robot: Robot, parameter: str | None = None) -> Redundancy:
    """How the configurations of an arm with seven coordinates are counted.

    Args:
        robot: with seven revolute or prismatic joints that move its tip; those of a gripper are left out, and the
            coordinates are those of `Redundancy.robot`.
        parameter: `arm angle`, or the name of the joint to hold; if None the arm angle where there is one, else the
            joint whose six others have a closed form, else the third.

    Raises:
        InputError: not an arm of seven revolute or prismatic joints, or a parameter that it does not have.
    """
    return _redundancy(moving_part(robot, None).robot, parameter)


@lru_cache(maxsize=64)
def _redundancy(robot: Robot, parameter: str | None) -> Redundancy:
    chain = chain_of(robot.mechanism)
    if chain is None or len(chain) != 7:
        raise InputError("redundant.not_seven", joints=robot.n)
    angle = arm_angle_form(chain)
    names = [ARM_ANGLE, *robot.joint_names] if angle is not None else list(robot.joint_names)
    if parameter is not None and parameter not in names:
        raise InputError("input.choice", name="parameter", value=parameter, known=", ".join(names))
    if angle is not None and parameter in (None, ARM_ANGLE):
        return Redundancy(robot, ARM_ANGLE, angle, None, -1)
    if parameter is None:
        arm = analysis(robot.mechanism, "pose")
        locked = arm.locked[0] if arm.form is not None and len(arm.locked) == 1 else 2
        form = arm.form if len(arm.locked) == 1 else None
    else:
        locked = robot.joint_names.index(parameter)
        form = _holding(chain, locked)
    return Redundancy(robot, robot.joint_names[locked], None, form, locked)


@lru_cache(maxsize=128)
def _lock(chain: Chain, locked: int, value: float) -> GeneralSix:
    """The other joints; its constants take longer than a pose, and searches try the same values for every pose."""
    return GeneralSix(chain.lock_joint(locked, value))


def _holding(chain: Chain, locked: int) -> ClosedForm | None:
    """The closed form of the others whatever value a joint takes."""
    pattern = recognise_locked(chain, 7, (locked,))
    return ClosedForm(pattern) if pattern is not None else None


def _poses(T: ArrayLike) -> PoseMatrix:
    """Poses that are poses; NaN where they are not numbers."""
    X = as_batch("T", T, (4, 4))
    clean, valid = clean_poses(X.reshape(-1, 4, 4))
    return clean.reshape(X.shape) if valid.all() else printed_pose("T", X)
