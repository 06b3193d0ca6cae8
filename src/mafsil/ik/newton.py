"""Newton's method as texts have it, every iterate kept: for any f: R^n -> R^n, and for a pose in body and space form.

x' = x - (df/dx)^-1 f(x), until |f| <= tolerance.  Near a regular root the errors obey e' ~ e^2; the order
p_k = ln(e_{k+1} / e_k) / ln(e_k / e_{k-1}) is measured from the distances to the last iterate.

Variants: `newton`; `damped`, whose steps are halved until |f| falls (Armijo); `broyden`, which keeps one Jacobian and
corrects it by each step (rank one); `levenberg`, (J'J + lambda I)^-1 J' f with lambda as the last steps went.

References: Ortega and Rheinboldt, Iterative solution of nonlinear equations in several variables, 1970; Broyden, A
class of methods for solving nonlinear simultaneous equations, 1965; Levenberg, 1944.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal, get_args

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import (
    Floats,
    JointVector,
    PoseMatrix,
    not_negative,
    positive,
    real_array,
    require_kind,
    single,
    whole,
)
from mafsil.errors import InputError
from mafsil.floating_point import EPS
from mafsil.geometry import pose, rotation
from mafsil.ik.tolerances import CENTRAL, START_DAMPING, SUFFICIENT
from mafsil.model.loading import RobotLike
from mafsil.robot import Robot, as_robot
from mafsil.robot.degrees import remark_on_degrees

Variant = Literal["newton", "damped", "broyden", "levenberg"]
VARIANTS: tuple[str, ...] = get_args(Variant)
GROWING = 3
"""Steps in a row by which |f| grows that are called divergence."""
HALVINGS = 40
"""Most halvings of a damped step."""
NewtonForm = Literal["body", "space"]
ResidualForm = Literal["twist", "euler"]


@dataclass(frozen=True, eq=False, repr=False)
class NewtonRecord(Answer, data="q iterates differences ranks", entries="iterates"):
    """The iterates of Newton's method; true if it converged.

    Attributes:
        q: (n,) the last iterate.
        converged: whether both tolerances are met there.
        iterates: (k + 1, n) start and every step.
        twists: (k + 1, 6) twist that leads from each iterate to the desired pose in unit time, body or space.
        differences: (k + 1) Frobenius norm of T(q) - T_sd.
        ranks: (k) rank of the Jacobian of each step; below min(6, n) the step passed a singular configuration.
    """

    q: JointVector
    converged: bool
    iterates: Floats
    twists: Floats
    differences: Floats
    ranks: tuple[int, ...]

    def __bool__(self) -> bool:
        return self.converged

    def explain(self, language: str | None = None) -> str:
        """The status in a sentence, with the number of steps, |T - T_sd| and the last order that was measured."""
        seen = self.orders[np.isfinite(self.orders)]
        details = {"steps": self.iterations, "residual": f"{self.differences[-1]:.3g}"}
        rank = self.ranks[-1] if self.ranks else 0
        return self.status.sentence(language, **details, order=f"{seen[-1]:.2f}" if len(seen) else "-", rank=rank)

    @property
    def iterations(self) -> int:
        """Number of steps."""
        return len(self.iterates) - 1

    @property
    def orders(self) -> Floats:
        """(k - 2,) measured orders of convergence, 2 near a regular solution; NaN where an error is rounding."""
        return orders(self.iterates)

    @property
    def status(self) -> RootStatus:
        """Converged; at a singular configuration; the difference of the poses grew again and again; none of these."""
        if self.converged:
            return RootStatus.CONVERGED
        if self.ranks and self.ranks[-1] < min(6, self.iterates.shape[1]):
            return RootStatus.SINGULAR
        last = self.differences[-GROWING - 1 :]
        grew = len(last) > GROWING and bool((np.diff(last) > 0.0).all())
        return RootStatus.DIVERGED if grew or not np.isfinite(last).all() else RootStatus.NOT_CONVERGED


def newton_ik(
    robot: RobotLike,
    T_sd: ArrayLike,
    q0: ArrayLike,
    *,
    form: NewtonForm = "body",
    rotation_tolerance: float = 1e-10,
    position_tolerance: float = 1e-10,
    max_steps: int = 50,
    damping: float = 0.0,
    residual: ResidualForm = "twist",
    by_differences: bool = False,
) -> NewtonRecord:
    """Newton-Raphson iteration to one pose.

    body:   J_b(q) dq = log(T(q)^-1 T_sd);    space:   J_s(q) dq = log(T_sd T(q)^-1)

    For six and more joints of full rank both make the same steps.

    Args:
        robot: any arm; least-norm steps where it has more joints than six, least-squares steps where fewer.
        T_sd: (4, 4) desired pose in {s}.
        q0: (n,) initial guess, the first iterate [rad | m].
        form: in which frame the twist and the Jacobian are expressed.
        rotation_tolerance: [rad].
        position_tolerance: [m].
        max_steps: most steps.
        damping: lambda of dq = J' (J J' + lambda^2 I)^-1 V; zero is Newton's own step.
        residual: `twist`, the logarithm of T^-1 T_sd; or `euler`, (roll, pitch, yaw of R_sd less those of R, p_sd - p),
            which has the representation's singularity at a pitch of a quarter turn.
        by_differences: whether the Jacobian of the residual is taken by central differences instead of the arm's own.

    Returns:
        The record; not converged is an answer, not an error.

    Raises:
        InputError: wrong shapes, numbers that are not finite, an unknown form, tolerances that are not positive.

    Reference: Lynch & Park, Modern Robotics, sec. 6.2.2.
    """
    if form not in ("body", "space"):
        raise InputError("input.choice", name="form", value=form, known="body, space")
    robot = as_robot(robot)
    T_goal, q = single("T_sd", T_sd, (4, 4)), single("q0", q0, (robot.n,)).copy()
    remark_on_degrees(robot, "q0", q0)
    turn, shift = positive("rotation_tolerance", rotation_tolerance), positive("position_tolerance", position_tolerance)
    most, least = whole("max_steps", max_steps), not_negative("damping", damping)
    if residual not in ("twist", "euler"):
        raise InputError("input.choice", name="residual", value=residual, known="twist, euler")
    error, jacobian = (pose.error, robot.jacobian_body) if form == "body" else (pose.space_error, robot.jacobian_space)
    iterates: list[JointVector] = []
    twists: list[Floats] = []
    differences: list[float] = []
    ranks: list[int] = []
    converged = False
    while True:
        T = robot.forward_kinematics(q)
        V = error(T, T_goal)
        iterates.append(q)
        twists.append(V)
        differences.append(float(np.linalg.norm(T - T_goal)))
        # The distance of the origins, which the linear part of a space twist is not.
        converged = bool(np.linalg.norm(V[:3]) <= turn and np.linalg.norm((T - T_goal)[:3, 3]) <= shift)
        if converged or len(ranks) == most or not np.isfinite(q).all():
            break
        if residual == "euler":
            lacking = partial(_lacking, robot, T_goal)
            J, V = -_slopes(lacking, q), lacking(q)
        else:
            J = -_slopes(lambda x: error(robot.forward_kinematics(x), T_goal), q) if by_differences else jacobian(q)
        ranks.append(int(np.linalg.matrix_rank(J)))
        q = q + _step(J, V, least)
    return NewtonRecord(q, converged, np.array(iterates), np.array(twists), np.array(differences), tuple(ranks))


def _step(J: Floats, V: Floats, damping: float) -> JointVector:
    if damping == 0.0:
        return np.linalg.pinv(J) @ V
    return J.T @ np.linalg.solve(J @ J.T + damping**2 * np.eye(6), V)


def _lacking(robot: Robot, T_goal: PoseMatrix, q: JointVector) -> Floats:
    """(6,) roll, pitch, yaw and position that are still lacking."""
    T = robot.forward_kinematics(q)
    turn = rotation.to_euler(T_goal[:3, :3], "ZYX") - rotation.to_euler(T[:3, :3], "ZYX")
    return np.concatenate([(turn + np.pi) % (2 * np.pi) - np.pi, T_goal[:3, 3] - T[:3, 3]])


def _slopes(f: Callable[[JointVector], Floats], q: JointVector) -> Floats:
    """(6, n) central differences."""
    steps = CENTRAL * np.eye(len(q))
    return np.stack([(f(q + h) - f(q - h)) / (2 * CENTRAL) for h in steps], axis=1)


class RootStatus(Status):
    """How an iteration went."""

    CONVERGED = ("ik.root_converged", True)
    SINGULAR = ("ik.root_singular", False)
    DIVERGED = ("ik.root_diverged", False)
    NOT_CONVERGED = ("ik.root_not_converged", False)


@dataclass(frozen=True, eq=False, repr=False)
class RootRecord(Answer, data="x iterates values ranks", entries="iterates"):
    """The iterates of a root search; true if it converged.

    Attributes:
        x: (n,) the last iterate.
        status: converged; refused at a singular Jacobian; |f| grew again and again; none of these in all steps.
        iterates: (k + 1, n) start and every step.
        values: (k + 1, m) f at each.
        ranks: (j,) rank of each Jacobian that was asked for.
    """

    x: Floats
    status: RootStatus
    iterates: Floats
    values: Floats
    ranks: tuple[int, ...]

    @property
    def iterations(self) -> int:
        """Number of steps."""
        return len(self.iterates) - 1

    @property
    def residuals(self) -> Floats:
        """(k + 1,) norms of f."""
        return np.linalg.norm(self.values, axis=1)

    @property
    def orders(self) -> Floats:
        """(k - 2,) measured orders of convergence; NaN where an error is zero or rounding."""
        return orders(self.iterates)

    def explain(self, language: str | None = None) -> str:
        """The status in a sentence, with the number of steps, |f| and the last order that was measured."""
        seen = self.orders[np.isfinite(self.orders)]
        details = {"steps": self.iterations, "residual": f"{self.residuals[-1]:.3g}"}
        rank = self.ranks[-1] if self.ranks else 0
        return self.status.sentence(language, **details, order=f"{seen[-1]:.2f}" if len(seen) else "-", rank=rank)


def orders(iterates: Floats) -> Floats:
    """(k - 2,) measured orders of convergence of iterates (k + 1, n) that end at a root; NaN where none can be said."""
    errors = np.linalg.norm(iterates[:-1] - iterates[-1], axis=1)
    scale = max(1.0, float(np.abs(iterates[-1]).max(initial=0.0)))
    errors = np.where(errors > 2 * EPS * scale, errors, np.nan)
    with np.errstate(divide="ignore", invalid="ignore"):
        logs = np.log(errors[1:] / errors[:-1])
        return logs[1:] / logs[:-1]


def find_root(
    f: Callable[[Floats], ArrayLike],
    x0: ArrayLike,
    jacobian: Callable[[Floats], ArrayLike] | None = None,
    *,
    variant: Variant = "newton",
    tolerance: float = 1e-12,
    max_steps: int = 50,
) -> RootRecord:
    """A root of f by Newton's method or one of its variants.

    Args:
        f: of x (n,), to (n,).
        x0: (n,) initial guess, the first iterate.
        jacobian: of x, to (n, n); central differences if None.
        variant: `newton`, `damped`, `broyden` or `levenberg`.
        tolerance: norm of f that ends the iteration.
        max_steps: most steps.

    Returns:
        The record; a status without success is an answer, not an error.

    Raises:
        InputError: no function, an unknown variant, wrong shapes, a tolerance that is not positive.
    """
    require_kind("f", f, "function", "__call__")
    if variant not in VARIANTS:
        raise InputError("input.choice", name="variant", value=variant, known=", ".join(VARIANTS))
    first = real_array("x0", x0)
    x, most, near = (
        single("x0", first, (first.size,)).copy(),
        whole("max_steps", max_steps),
        positive("tolerance", tolerance),
    )
    return _Iteration(f, jacobian, variant, x).run(near, most)


class _Iteration:
    """The state of one iteration."""

    def __init__(
        self,
        f: Callable[[Floats], ArrayLike],
        jacobian: Callable[[Floats], ArrayLike] | None,
        variant: str,
        x: Floats,
    ) -> None:
        self.f, self.jacobian, self.variant, self.x = f, jacobian, variant, x
        self.J, self.damping, self.ranks = np.eye(len(x)), START_DAMPING, list[int]()

    def run(self, tolerance: float, most: int) -> RootRecord:
        """Steps until an end is seen; numbers that overflow on the way are that end, and no warning."""
        y, grown = self._value(self.x), 0
        iterates, values, status = [self.x], [y], RootStatus.NOT_CONVERGED
        while True:
            if np.linalg.norm(y) <= tolerance:
                status = RootStatus.CONVERGED
            elif grown >= GROWING or not np.isfinite(y).all():
                status = RootStatus.DIVERGED
            if status is not RootStatus.NOT_CONVERGED or len(iterates) > most:
                break
            if not self._is_prepared(len(iterates) == 1):
                status = RootStatus.SINGULAR
                break
            before = y
            with np.errstate(over="ignore", invalid="ignore"):
                self.x, y = self._step(y)
            grown = grown + 1 if np.linalg.norm(y) > np.linalg.norm(before) else 0
            iterates.append(self.x)
            values.append(y)
        return RootRecord(self.x, status, np.array(iterates), np.array(values), tuple(self.ranks))

    def _value(self, x: Floats) -> Floats:
        return single("f", self.f(x), (len(x),)) if np.isfinite(x).all() else np.full(len(x), np.nan)

    def _is_prepared(self, begin: bool) -> bool:
        """Whether there is a Jacobian that a step can be made with."""
        if begin or self.variant != "broyden":
            n = len(self.x)
            self.J = self._differences() if self.jacobian is None else single("jacobian", self.jacobian(self.x), (n, n))
        self.ranks.append(int(np.linalg.matrix_rank(self.J)))
        return self.variant == "levenberg" or self.ranks[-1] == len(self.x)

    def _step(self, y: Floats) -> tuple[Floats, Floats]:
        if self.variant == "levenberg":
            return self._levenberg(y)
        step, share = -np.linalg.solve(self.J, y), 1.0
        x, value = self.x + step, self._value(self.x + step)
        for _ in range(HALVINGS if self.variant == "damped" else 0):
            if np.linalg.norm(value) < (1 - SUFFICIENT * share) * np.linalg.norm(y):
                break
            share /= 2
            x = self.x + share * step
            value = self._value(x)
        if self.variant == "broyden" and step @ step > 0.0:
            self.J = self.J + np.outer(value - y - self.J @ step, step) / (step @ step)
        return x, value

    def _levenberg(self, y: Floats) -> tuple[Floats, Floats]:
        for _ in range(HALVINGS):
            step = -np.linalg.solve(self.J.T @ self.J + self.damping * np.eye(len(y)), self.J.T @ y)
            value = self._value(self.x + step)
            if np.linalg.norm(value) < np.linalg.norm(y):
                self.damping /= 16
                return self.x + step, value
            self.damping *= 8
        return self.x, y

    def _differences(self) -> Floats:
        columns: list[Floats] = []
        for i in range(len(self.x)):
            h = np.zeros(len(self.x))
            h[i] = CENTRAL * max(1.0, abs(float(self.x[i])))
            columns.append((self._value(self.x + h) - self._value(self.x - h)) / (2 * h[i]))
        return np.stack(columns, axis=1)
