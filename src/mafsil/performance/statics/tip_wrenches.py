"""Forces at the tip and efforts of the joints, both ways, with the reason where there is no way back."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, Vector6, as_batch, not_negative, positive, single, whole
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import wrench
from mafsil.messages import say
from mafsil.performance.singularities.screw_parameters import vector_text, wrench_screw
from mafsil.performance.singularities.singular_configuration import wrenches_of
from mafsil.performance.tolerances import CLEAR, COARSEST, ROUNDOFF
from mafsil.performance.velocity.jacobians import tool_jacobian
from mafsil.performance.velocity.scaling import TOLERANCE, Scaled, Task, rank_of, require_one, scaled_jacobian
from mafsil.robot import Robot, of_robot
from mafsil.robot.degrees import in_tip
from mafsil.solvers import decompositions


class StaticsStatus(Status):
    """Whether joint efforts determine the wrench at the tip."""

    DETERMINED = ("performance.statics_determined", True)
    CARRIED = ("performance.statics_carried", False)
    UNBALANCED = ("performance.statics_unbalanced", False)
    UNBALANCED_AND_CARRIED = ("performance.statics_both", False)
    NOT_FINITE = ("performance.statics_not_finite", False)


STATUSES = tuple(StaticsStatus)
_MEMBERS = np.array(STATUSES, dtype=np.object_)
LISTED = 6
"""Configurations of a batch whose sentences are given at once, the first that have no answer."""

JACOBIANS: dict[str, Callable[[Robot, ArrayLike, str | None], Floats]] = {
    "body": lambda robot, q, frame: robot.jacobian_body(q, frame=frame),
    "space": lambda robot, q, frame: robot.jacobian_space(q, frame=frame),
    "tip": lambda robot, q, frame: tool_jacobian(robot, q, frame=frame),
}
"""Whose transpose takes a wrench to joint efforts, by where the wrench is given."""


@of_robot
def joint_torque(
    robot: Robot,
    q: ArrayLike,
    F: ArrayLike,
    *,
    given_in: Literal["body", "space", "tip"] = "body",
    frame: str | None = None,
) -> JointVector:
    """Tau = J_b' F_b = J_s' F_s: joint efforts with which the tip exerts a wrench on the world; gravity left aside.

    To withstand an external wrench instead, change its sign.

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        F: (*batch, 6) wrench (m, f) that the frame exerts on the world [N m, N].
        given_in: `body`, the frame's own axes and origin; `space`, those of {s}; `tip`, at the frame's origin in the
            axes of {s}, as force sensors tell it. The three are different numbers for one wrench and never guessed.
        frame: name of a link; the tip frame if None.

    Returns:
        (*batch, n) [N m | N].

    Reference: Lynch & Park, Modern Robotics, sec. 5.2.
    """
    if given_in not in JACOBIANS:
        raise InputError("input.choice", name="given_in", value=given_in, known=", ".join(JACOBIANS))
    if given_in == "body":
        F = in_tip("F", F, robot.mechanism.tip if frame is None else frame)
    elif given_in == "space" and getattr(F, "frame", None) not in (None, "s"):
        raise InputError("robot.wrench_frame", name="F", frame=getattr(F, "frame", None), known="s")
    J = JACOBIANS[given_in](robot, q, frame)
    return np.einsum("...ij,...i->...j", J, as_batch("F", F, (6,)))


@dataclass(frozen=True, eq=False, repr=False)
class TipWrench(Answer, data="F unbalanced rank carried self_motion"):
    """The wrench at the tip that balances joint efforts, as far as there is one: true where all efforts determine it.

    Attributes:
        F: (*batch, m) rows of the wrench (m, f) that the tip exerts, at its origin in the axes of {s}, the task's rows;
            least squares where efforts cannot be balanced, without part in what the structure carries.
        codes: (*batch) index into STATUSES.
        unbalanced: (*batch, n) the part of the efforts that no wrench balances: it sets the arm in motion.
        rank: (*batch) of the Jacobian.
        carried: (k, 6) for a single configuration: wrenches in {s} that need no effort, so that F is known up to them.
        self_motion: (k, n) for a single configuration: joint rates with the tip at rest.
    """

    F: Floats
    codes: NDArray[np.int64]
    unbalanced: JointVector
    rank: NDArray[np.int64]
    carried: Floats
    self_motion: Floats
    n: int
    rows: int
    length: float

    @property
    def status(self) -> Any:
        """The status, a member of `StaticsStatus`; of a batch an array (*batch,) of them."""
        return STATUSES[int(self.codes)] if not self.codes.ndim else _MEMBERS[self.codes]

    def __bool__(self) -> bool:
        return bool((self.codes == STATUSES.index(StaticsStatus.DETERMINED)).all())

    def __len__(self) -> int:
        return len(self.codes) if self.codes.ndim else 1

    def __iter__(self) -> Iterator[Floats]:
        return iter(self.F if self.codes.ndim else (self.F,))

    def explain(self, *index: int, language: str | None = None) -> str:  # pyright: ignore[reportIncompatibleMethodOverride]
        """Whether F is the answer, and if not why; wrenches carried by the structure one by one.

        Of a batch, without an index, how many efforts determine F, and the sentences of the first that do not.
        """
        if self.codes.ndim and not index:
            failing = np.argwhere(self.codes != STATUSES.index(StaticsStatus.DETERMINED)).tolist()
            determined = self.codes.size - len(failing)
            lines = [say("performance.statics_batch", language=language, determined=determined, count=self.codes.size)]
            for where in failing[:LISTED]:
                lines.append(f"{', '.join(map(str, where))}: {self.explain(*where, language=language)}")
            return "\n".join(lines)
        status = STATUSES[int(self.codes[index])]
        details = {
            "rank": int(self.rank[index]),
            "n": self.n,
            "rows": self.rows,
            "free": self.rows - int(self.rank[index]),
            "motions": self.n - int(self.rank[index]),
            "unbalanced": vector_text(self.unbalanced[index]),
        }
        lines = [status.sentence(language, **details)]
        lines += [wrench_screw(F, length=self.length).sentence("carried", language) for F in self.carried]
        return "\n".join(lines)


@of_robot
def tip_wrench(
    robot: Robot, q: ArrayLike, tau: ArrayLike, *, task: Task = "pose", tolerance: float = TOLERANCE
) -> TipWrench:
    """Inverse statics F = J^-T tau, and the reason where J has no inverse.

    Args:
        robot: the arm.
        q: (*batch, n) joint coordinates [rad | m].
        tau: (*batch, n) efforts besides those that hold gravity [N m | N].
        task: rows of the wrench that may be transmitted; `planar_position` for an arm pinned in its plane.
        tolerance: of the rank.

    Reference: Lynch & Park, Modern Robotics, sec. 5.2.
    """
    tolerance = not_negative("tolerance", tolerance, most=COARSEST)
    efforts = as_batch("tau", tau, (robot.n,), finite=True)
    scaled = scaled_jacobian(robot, q, task=task)
    U, s, Vt = decompositions.svd(scaled.J)
    found = rank_of(s, tolerance)
    count: int = s.shape[-1]
    kept: NDArray[np.bool_] = np.arange(count) < found[..., None]
    inverse = np.where(kept, 1.0 / np.where(kept, s, 1.0), 0.0)
    loads = efforts * scaled.columns
    along = np.einsum("...ij,...j->...i", Vt, loads)
    F = np.einsum("...ij,...j->...i", U, inverse * along) * scaled.row_factors
    balanced = np.einsum("...ij,...i->...j", Vt, np.where(kept, along, 0.0))
    unbalanced = (loads - balanced) / scaled.columns
    size = np.abs(efforts).max(axis=-1)
    moving = np.abs(unbalanced).max(axis=-1) > CLEAR * np.maximum(size, LEAST_DIVISOR)
    free = found < len(scaled.rows)
    single = scaled.J.ndim == 2
    carried, motion = _kernels(scaled, tolerance) if single else (np.zeros((0, 6)), np.zeros((0, robot.n)))
    unbalanced = np.where(moving[..., None], unbalanced, 0.0)
    codes = np.where(found < 0, STATUSES.index(StaticsStatus.NOT_FINITE), free + 2 * moving)
    return TipWrench(F, codes, unbalanced, np.asarray(found), carried, motion, robot.n, len(scaled.rows), scaled.length)


def _kernels(scaled: Scaled, tolerance: float) -> tuple[Floats, Floats]:
    """Wrenches without effort and rates without motion of one configuration."""
    U, s, Vt = np.linalg.svd(scaled.J)
    found = int(rank_of(s, tolerance))
    return wrenches_of(scaled, U[:, found:]), Vt[found:] * scaled.columns


@of_robot
def structure_wrenches(robot: Robot, q: ArrayLike, *, task: Task = "pose", tolerance: float = TOLERANCE) -> Floats:
    """(k, 6) independent wrenches (m, f) in {s} that the arm carries without any joint effort.

    Args:
        robot: the arm.
        q: (n,) joint coordinates [rad | m].
        task: rows of the wrench that may act.
        tolerance: of the rank.
    """
    tolerance = not_negative("tolerance", tolerance, most=COARSEST)
    return _kernels(scaled_jacobian(robot, require_one("q", q, robot.n), task=task), tolerance)[0]


@of_robot
def self_motion(robot: Robot, q: ArrayLike, *, task: Task = "pose", tolerance: float = TOLERANCE) -> Floats:
    """(k, n) independent joint rates with which the tip stays at rest; arguments as `structure_wrenches`."""
    tolerance = not_negative("tolerance", tolerance, most=COARSEST)
    return _kernels(scaled_jacobian(robot, require_one("q", q, robot.n), task=task), tolerance)[1]


@dataclass(frozen=True, eq=False)
class PinnedArm:
    """An arm whose tip is pinned to the ground: a closed chain.

    Attributes:
        freedoms: n minus the rank: 1 for a planar 3R arm pinned in its plane, which is a four-bar linkage.
        rates: (freedoms, n) joint rates of its motions.
        path: (k, n) configurations along the first motion, the tip at rest.
        drift: largest distance of the tip from its pin along the path [m].
    """

    freedoms: int
    rates: Floats
    path: Floats
    drift: float


@of_robot
def pinned_arm(
    robot: Robot, q: ArrayLike, *, task: Task = "planar_position", steps: int = 50, step: float = 0.02
) -> PinnedArm:
    """The arm as a linkage with its tip held: freedoms, rates and the motion itself.

    Args:
        robot: the arm.
        q: (n,) joint coordinates at which it is pinned [rad | m].
        task: rows of the tip's motion that the pin prevents.
        steps: how many along the motion.
        step: norm of each [rad].
    """
    start = require_one("q", q, robot.n)
    rates = self_motion(robot, start, task=task)
    path, drift = [start], 0.0
    if len(rates):
        direction: Floats = rates[0] / np.linalg.norm(rates[0])
        home = robot.forward_kinematics(start)[:3, 3]
        for _ in range(whole("steps", steps, 0, 100_000)):
            nulls = self_motion(robot, path[-1], task=task)
            ahead: Floats = nulls.T @ np.linalg.lstsq(nulls.T, direction, rcond=None)[0]
            direction = ahead / np.linalg.norm(ahead)
            path.append(_correct(robot, start, path[-1] + step * direction, task))
            drift = max(drift, float(np.linalg.norm(robot.forward_kinematics(path[-1])[:3, 3] - home)))
    return PinnedArm(len(rates), rates, np.array(path), drift)


def _correct(robot: Robot, start: Floats, q: Floats, task: Task) -> Floats:
    """The nearest configuration with the tip where it was at the start, by Newton's method."""
    T_0 = robot.forward_kinematics(start)
    for _ in range(8):
        scaled = scaled_jacobian(robot, q, task=task)
        T = robot.forward_kinematics(q)
        turn = T_0[:3, :3] @ T[:3, :3].T
        omega = 0.5 * np.array([turn[2, 1] - turn[1, 2], turn[0, 2] - turn[2, 0], turn[1, 0] - turn[0, 1]])
        error = np.concatenate([omega, T_0[:3, 3] - T[:3, 3]])[list(scaled.rows)] * scaled.row_factors
        q = q + scaled.columns * (np.linalg.pinv(scaled.J) @ error)
    return q


def total_wrench(
    forces: ArrayLike, points: ArrayLike, moments: ArrayLike | None = None, about: ArrayLike = (0.0, 0.0, 0.0)
) -> Vector6:
    """Sum of forces and of their moments about one common point: zero for a body in equilibrium.

    Args:
        forces: (k, 3) [N].
        points: (k, 3) where they act [m].
        moments: (j, 3) free couples [N m].
        about: (3,) the common point [m]; the origin if left out.

    Returns:
        (6,) wrench (m, f) about that point.

    Raises:
        InputError: not one point for each force.
    """
    f = np.atleast_2d(as_batch("forces", forces, (3,), finite=True))
    r = np.atleast_2d(as_batch("points", points, (3,), finite=True)) - single("about", about, (3,))
    if f.ndim != 2 or f.shape != r.shape:
        raise InputError("performance.one_point_each", forces=f.shape, points=r.shape)
    total = wrench.from_force(r, f).sum(axis=0)
    if moments is not None:
        total[:3] += np.atleast_2d(as_batch("moments", moments, (3,), finite=True)).sum(axis=0)
    return total


def sum_of_moments(moments: ArrayLike, abouts: ArrayLike) -> Floats:
    """(3,) sum of moments (k, 3) [N m] that were all taken about the same point.

    Args:
        moments: (k, 3) [N m].
        abouts: (k, 3) the point about which each was taken [m].

    Raises:
        InputError: two of the points differ: such moments cannot be added; use `total_wrench`.
    """
    m = np.atleast_2d(as_batch("moments", moments, (3,), finite=True))
    points = np.atleast_2d(as_batch("abouts", abouts, (3,), finite=True))
    apart = np.linalg.norm(points - points[0], axis=-1)
    if apart.max(initial=0.0) > ROUNDOFF * max(1.0, float(np.abs(points).max())):
        raise InputError("performance.moments_about", index=int(apart.argmax()), distance=float(apart.max()))
    return m.sum(axis=0)


def in_equilibrium(wrenches: ArrayLike, *, length: float = 1.0, tolerance: float = 1e-9) -> bool:
    """Whether wrenches (k, 6), all about one point, add up to zero.

    Args:
        wrenches: (k, 6) (m, f) about one common point in one frame [N m, N].
        length: [m] that makes moments comparable with forces.
        tolerance: of the sum, relative to the sum of sizes.
    """
    length = positive("length", length)
    tolerance = not_negative("tolerance", tolerance)
    F = np.atleast_2d(as_batch("wrenches", wrenches, (6,), finite=True)) / np.array([length] * 3 + [1.0] * 3)
    return bool(np.abs(F.sum(axis=0)).max() <= tolerance * max(float(np.abs(F).sum()), LEAST_DIVISOR))


def work(wrenches: ArrayLike, twists: ArrayLike, times: ArrayLike) -> float:
    """Work [J] of a wrench along a motion, the integral of F . V dt by the trapezoidal rule.

    Args:
        wrenches: (k, 6) [N m, N].
        twists: (k, 6) in the same frame [rad/s, m/s].
        times: (k,) [s].

    Raises:
        InputError: other shapes, or not as many twists and times as wrenches.
    """
    F = np.atleast_2d(as_batch("wrenches", wrenches, (6,)))
    V, t = np.atleast_2d(as_batch("twists", twists, (6,))), np.atleast_1d(as_batch("times", times, ()))
    for name, rows in (("twists", V), ("times", t)):
        if len(rows) != len(F) or rows.ndim != (2 if rows is V else 1):
            raise InputError("input.shape", name=name, expected=(len(F), *rows.shape[1:]), got=rows.shape, hint="")
    return float(np.trapezoid((F * V).sum(axis=-1), t))
