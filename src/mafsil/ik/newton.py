"""Newton's method for one pose as texts have it: body and space form, every iterate kept."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer
from mafsil.arrays import Floats, JointVector, PoseMatrix, not_negative, positive, single, whole
from mafsil.errors import InputError
from mafsil.geometry import pose, rotation
from mafsil.ik.root_finding import GROWING, RootStatus, orders
from mafsil.ik.tolerances import CENTRAL
from mafsil.model.loading import RobotLike
from mafsil.robot import Robot, as_robot
from mafsil.robot.degrees import remark_on_degrees

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
