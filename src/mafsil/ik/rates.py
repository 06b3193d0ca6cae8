"""Joint rates of a desired twist: weighted least norm, null-space goals, priorities, integration along a motion.

From a desired motion X(t) to the twists that a rate formula asks for.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, PoseMatrix, Vector6, as_batch, positive, real_array, require_kind, single
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.ik.chain import moving_part
from mafsil.ik.tolerances import MADE, RANK, SIXTH_ORDER, SYMMETRIC
from mafsil.messages import say
from mafsil.model.loading import RobotLike
from mafsil.robot import as_robot
from mafsil.robot.degrees import remark_on_degrees
from mafsil.solvers import decompositions

WEIGHTS = ((1, 45.0 / 60.0), (2, -9.0 / 60.0), (3, 1.0 / 60.0))
"""Central differences of sixth order."""
TwistForm = Literal["body", "space", "tip"]
MOST_STEPS = 10_000_000
"""Most steps of an integration: more would not fit the memory."""


class RateStatus(Status):
    """How well joint rates make a twist."""

    EXACT = ("ik.rates_exact", True)
    SLOWED = ("ik.rates_slowed", False)
    APPROXIMATE = ("ik.rates_approximate", False)


STATUSES = tuple(RateStatus)
_MEMBERS = np.array(STATUSES, dtype=np.object_)


class RatesAnswer(Answer, data="qd residual rank"):
    """What answers for joint rates share: true where all twists are made.

    Attributes:
        qd: (*batch, n) rates [rad/s | m/s].
        residual: (*batch,) norm of what J qd lacks.
        rank: (*batch,) of the task's Jacobian.
        codes: (*batch,) index into `STATUSES`.
    """

    qd: JointVector
    residual: Floats
    rank: NDArray[np.int64]
    codes: NDArray[np.int8]

    def __bool__(self) -> bool:
        return bool((self.codes == STATUSES.index(RateStatus.EXACT)).all())

    def __len__(self) -> int:
        return len(self.codes) if self.codes.ndim else 1

    def __iter__(self) -> Iterator[JointVector]:
        return iter(self.qd if self.codes.ndim else (self.qd,))

    @property
    def status(self) -> Any:
        """The status, a member of `RateStatus`; of a batch an array (*batch,) of them."""
        return STATUSES[int(self.codes)] if not self.codes.ndim else _MEMBERS[self.codes]

    @property
    def factor(self) -> Floats:
        """(*batch,) part of the twist that is sought."""
        return np.ones_like(self.residual)

    def explain(self, language: str | None = None) -> str:
        """The status in a sentence; of a batch, how many twists are made, and the sentence of the worst."""
        index = np.unravel_index(int(self.residual.argmax()), self.residual.shape) if self.residual.size else None
        lines: list[str] = []
        if self.codes.ndim:
            exact = int((self.codes == STATUSES.index(RateStatus.EXACT)).sum())
            lines.append(say("ik.rates_batch", language=language, exact=exact, count=self.codes.size))
        if index is not None and not (self.codes.ndim and self):
            details = {"residual": float(self.residual[index]), "rank": int(self.rank[index])}
            status = STATUSES[int(self.codes[index])]
            lines.append(status.sentence(language, **details, factor=float(self.factor[index])))
        return "\n".join(lines)


def rate_codes(residual: Floats, twist: Floats, factor: Floats | float = 1.0) -> NDArray[np.int8]:
    """(*batch,) index into `STATUSES`.

    Args:
        residual: (*batch,) norm of what the rates lack.
        twist: (*batch, m) desired.
        factor: (*batch,) part of it that was sought.
    """
    exact = residual <= MADE * np.linalg.norm(twist, axis=-1)
    slowed = np.where(np.less(factor, 1.0), STATUSES.index(RateStatus.SLOWED), STATUSES.index(RateStatus.EXACT))
    return np.asarray(np.where(exact, slowed, STATUSES.index(RateStatus.APPROXIMATE)), dtype=np.int8)


@dataclass(frozen=True, eq=False, repr=False)
class Rates(RatesAnswer):
    """Joint rates for a twist.

    Attributes:
        qd: (*batch, n) rates [rad/s | m/s].
        residual: (*batch,) norm of what J qd lacks of the desired twist; zero within rounding unless singular.
        rank: (*batch,) rank of the task's Jacobian; lower than its rows at a singular configuration.
        null_space: (*batch, n, n) projector on the rates that do not move the task: rates of self-motion. Joints
            that do not move the tip at all have none.
        moving: number of joints that move the tip.
        codes: (*batch,) index into `STATUSES`.
    """

    qd: JointVector
    residual: Floats
    rank: NDArray[np.int64]
    null_space: Floats
    moving: int
    codes: NDArray[np.int8]

    @property
    def redundancy(self) -> NDArray[np.int64]:
        """(*batch,) dimension of the self-motion: moving joints less the rank."""
        return self.moving - self.rank


def twist_jacobian(
    robot: RobotLike, q: ArrayLike, form: TwistForm = "body", rows: Sequence[int] | None = None
) -> Floats:
    """(*batch, m, n) Jacobian of a twist, or of some of its rows: what `performance.task_jacobian` calls a task.

    Args:
        robot: any arm.
        q: (*batch, n) coordinates.
        form: `body` and `space` twists, or `tip`: angular velocity and velocity of the tip's origin along the axes
            of {s}.
        rows: components (0 to 2 angular, 3 to 5 linear) that count; all if None.

    Raises:
        InputError: an unknown form, wrong shapes, rows that are none.
    """
    robot = as_robot(robot)
    match form:
        case "body":
            J = robot.jacobian_body(q)
        case "space":
            J = robot.jacobian_space(q)
        case "tip":
            R = robot.forward_kinematics(q)[..., :3, :3]
            J = robot.jacobian_body(q)
            J = np.concatenate([R @ J[..., :3, :], R @ J[..., 3:, :]], axis=-2)
        case _:
            raise InputError("input.choice", name="form", value=form, known="body, space, tip")
    return J if rows is None else J[..., _chosen(rows), :]


def twists_for(J: Floats, V: ArrayLike, **others: ArrayLike) -> Floats:
    """(*batch, m) desired twists of a task, once their batch is seen to fit the Jacobians'.

    Args:
        J: (*batch, m, n).
        V: (*batch, m).
        others: (*batch, n) under their names, checked too.

    Raises:
        InputError: a wrong shape, numbers that are not finite, batches that do not fit.
    """
    twist = as_batch("V", V, (J.shape[-2],), finite=True)
    batches = {"q": J.shape[:-2], "V": twist.shape[:-1]}
    batches |= {name: as_batch(name, x, (J.shape[-1],), finite=True).shape[:-1] for name, x in others.items()}
    try:
        np.broadcast_shapes(*batches.values())
    except ValueError:
        named = ", ".join(f"{name} {batch}" for name, batch in batches.items())
        raise InputError("call.batches", name="rates", batches=named) from None
    return twist


def joint_rates(
    robot: RobotLike,
    q: ArrayLike,
    V: ArrayLike,
    *,
    form: TwistForm = "body",
    rows: Sequence[int] | None = None,
    cost: ArrayLike | None = None,
    qd_preferred: ArrayLike | None = None,
) -> Rates:
    """Rates that make a twist at least cost, and pursue preferred rates with what is left.

    min qd' Q qd  subject to  J qd = V:    qd = J# V + (I - J# J) z,  J# = Q^-1 J' (J Q^-1 J')^-1

    Args:
        robot: any arm.
        q: (*batch, n) coordinates.
        V: (*batch, m) desired twist (omega, v), or its components `rows` [rad/s, m/s].
        form: frame of the twist, see `twist_jacobian`.
        rows: components that count; all six if None.
        cost: (n,) diagonal or (n, n) symmetric positive definite Q; a joint of larger cost moves less. Weights that
            grow with a motor's capability are its reciprocals. Ones if None.
        qd_preferred: (*batch, n) preferred rates z; only their self-motion is done.

    Raises:
        InputError: wrong shapes, a cost that is not symmetric and positive definite.

    Reference: Whitney, Resolved motion rate control, 1969; Lynch & Park, Modern Robotics, sec. 6.3.
    """
    robot = as_robot(robot)
    J = twist_jacobian(robot, q, form, rows)
    twist = twists_for(J, V) if qd_preferred is None else twists_for(J, V, qd_preferred=qd_preferred)
    Q, moving = _cost(cost, robot.n), moving_part(robot).columns
    own = J[..., moving]
    # With y = L' qd, Q = L L', the least cost is the least norm of y.
    back = np.linalg.inv(np.linalg.cholesky(Q[np.ix_(moving, moving)])).T
    scaled = own @ back
    sharp = np.zeros((*J.shape[:-2], robot.n, J.shape[-2]))
    sharp[..., moving, :] = back @ decompositions.pinv(scaled, RANK)
    null_space = np.zeros((*J.shape[:-2], robot.n, robot.n))
    null_space[..., moving[:, None], moving] = np.eye(len(moving)) - sharp[..., moving, :] @ own
    qd = (sharp @ twist[..., None])[..., 0]
    if qd_preferred is not None:
        qd = qd + (null_space @ real_array("qd_preferred", qd_preferred)[..., None])[..., 0]
    residual = np.linalg.norm((J @ qd[..., None])[..., 0] - twist, axis=-1)
    values = decompositions.singular_values(scaled)
    rank = (values > RANK * values[..., :1]).sum(axis=-1)
    return Rates(qd, residual, rank, null_space, len(moving), rate_codes(residual, twist))


def prioritised_rates(robot: RobotLike, q: ArrayLike, tasks: Sequence[tuple[ArrayLike, ArrayLike]]) -> JointVector:
    """(n,) rates that fulfil tasks in strict order: each is pursued only in the self-motion left by those before.

    Args:
        robot: any arm.
        q: (n,) coordinates; only for their shape.
        tasks: pairs of a Jacobian (m, n) and a desired velocity (m,), most important first.

    Raises:
        InputError: wrong shapes.

    Reference: Siciliano and Slotine, A general framework for managing multiple tasks, 1991.
    """
    robot = as_robot(robot)
    single("q", q, (robot.n,))
    qd, N = np.zeros(robot.n), np.eye(robot.n)
    require_kind("tasks", tasks, "list of pairs", "__iter__")
    for k, task in enumerate(tasks):
        require_kind(f"tasks[{k}]", task, "(Jacobian, velocity)", "__len__")
        if len(task) != 2:
            raise InputError("input.shape", name=f"tasks[{k}]", expected="(Jacobian, velocity)", got=len(task), hint="")
        rows = real_array(f"tasks[{k}][1]", task[1])
        desired = single(f"tasks[{k}][1]", rows, (rows.size,))
        J = single(f"tasks[{k}][0]", task[0], (rows.size, robot.n))
        inverse = decompositions.pinv(J @ N, RANK)
        qd = qd + inverse @ (desired - J @ qd)
        N = N - inverse @ (J @ N)
    return qd


def integrate_rates(
    robot: RobotLike,
    q0: ArrayLike,
    twist: Callable[[float, JointVector], ArrayLike],
    duration: float,
    step: float,
    *,
    form: TwistForm = "body",
    rows: Sequence[int] | None = None,
    cost: ArrayLike | None = None,
) -> JointVector:
    """(k + 1, n) coordinates along a motion of given twist, by explicit Euler steps of least cost.

    q(t + dt) = q(t) + dt J#(q) V(t).  The drift is of first order; `track` corrects it.

    Args:
        robot: any arm.
        q0: (n,) coordinates at t = 0 [rad | m].
        twist: V of time [s] and coordinates, (m,).
        duration: of the motion [s].
        step: dt [s].
        form: frame of the twist, see `twist_jacobian`.
        rows: components that count.
        cost: as for `joint_rates`.

    Raises:
        InputError: wrong shapes, a duration or step that is not positive.
    """
    robot = as_robot(robot)
    require_kind("twist", twist, "function of time and coordinates", "__call__")
    count = min(positive("duration", duration) / positive("step", step), 2.0 * MOST_STEPS)
    if count > MOST_STEPS:
        raise InputError("input.range", name="duration / step", value=count, low=0, high=MOST_STEPS)
    q = single("q0", q0, (robot.n,))
    remark_on_degrees(robot, "q0", q0)
    path = [q]
    for k in range(round(count)):
        q = q + step * joint_rates(robot, q, twist(k * step, q), form=form, rows=rows, cost=cost).qd
        path.append(q)
    return np.array(path)


def _chosen(rows: Sequence[int]) -> list[int]:
    """The rows of a twist that count."""
    numbers = real_array("rows", rows)
    known = numbers.ndim == 1 and numbers.size > 0 and np.isin(numbers, np.arange(6)).all()
    if not known or len(np.unique(numbers)) < numbers.size:
        raise InputError("ik.rows", name="rows", value=rows)
    return numbers.astype(int).tolist()


def _cost(cost: ArrayLike | None, n: int) -> Floats:
    """(n, n) the cost as a symmetric positive definite matrix."""
    if cost is None:
        return np.eye(n)
    array = real_array("cost", cost)
    Q = np.diag(single("cost", array, (n,))) if array.ndim == 1 else single("cost", array, (n, n))
    skew = np.abs(Q - Q.T).max(initial=0.0)
    if skew > SYMMETRIC * np.abs(Q).max(initial=0.0):
        raise InputError("ik.asymmetric", name="cost", value=float(skew))
    try:
        np.linalg.cholesky(Q)
    except np.linalg.LinAlgError:
        raise InputError("ik.cost", name="cost", value=float(np.linalg.eigvalsh(Q).min())) from None
    return Q


def twist_of_motion(X: Callable[[float], ArrayLike], t: float, *, step: float = SIXTH_ORDER) -> tuple[Vector6, Vector6]:
    """The body and the space twist of a motion at a time.

    [V_b] = X^-1 dX/dt,  [V_s] = dX/dt X^-1 = Ad(X) V_b

    Args:
        X: of the time [s], a pose (4, 4) in {s}.
        t: the time [s].
        step: of the central differences of log(X(t)^-1 X(t + h)) [s]; the motion must be smooth over three of them.

    Returns:
        V_b, V_s (6,) each [rad/s, m/s].

    Raises:
        InputError: no function, a pose of a wrong shape, a step that is not positive.
    """
    require_kind("X", X, "function of time", "__call__")
    h, time = positive("step", step), float(single("t", t, ()))
    here = single("X(t)", X(time), (4, 4))
    back = pose.inverse(here)
    V_b = np.zeros(6)
    for k, weight in WEIGHTS:
        ahead, behind = (single("X(t)", X(time + s * k * h), (4, 4)) for s in (1, -1))
        V_b += weight / h * (pose.log(back @ ahead) - pose.log(back @ behind))
    return V_b, pose.adjoint(here) @ V_b


def twists_between(poses: ArrayLike, times: ArrayLike) -> Floats:
    """(k - 1, 6) body twists that lead from each sample of a motion to the next exactly, constant over the step.

    V_b = log(X_k^-1 X_{k+1}) / (t_{k+1} - t_k)

    Args:
        poses: (k, 4, 4) in {s}.
        times: (k,) increasing [s].

    Raises:
        InputError: wrong shapes, times that do not increase.
    """
    X: PoseMatrix = as_batch("poses", poses, (4, 4), finite=True)
    if X.ndim != 3:
        raise InputError("input.shape", name="poses", expected="(k, 4, 4)", got=X.shape, hint="")
    clock = single("times", times, (len(X),))
    if (np.diff(clock) <= 0.0).any():
        raise InputError("ik.times", name="times", index=int((np.diff(clock) <= 0.0).argmax()) + 1)
    return pose.log(pose.inverse(X[:-1]) @ X[1:]) / np.diff(clock)[:, None]
