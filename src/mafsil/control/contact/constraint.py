"""Motion under constraints A V = 0 at the tip: multipliers, projections, the freedoms that motion and force have."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch, not_negative, number, real_array, require_finite, require_kind, single
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say

DEPENDENT = 1e-9
"""Share of the largest singular value below which a row of a constraint depends on the others: data of nine digits."""


@dataclass(frozen=True, eq=False, slots=True)
class ConstrainedDynamics:
    """F = Lambda dV/dt + gamma + eta + A' lambda with A V = 0, and the projections that part motion from force.

    Attributes:
        multipliers: (*batch, k) lambda: how hard the constraint pushes back.
        acceleration: (*batch, m) dV/dt.
        P: (*batch, m, m) of rank m - k: P F moves the tip; I - P: of rank k, presses on the constraint.
        curvature_force: (*batch, m) A' (A Lambda^-1 A')^-1 dA/dt V: what a curved constraint takes for itself.
    """

    multipliers: Floats
    acceleration: Floats
    P: Floats
    curvature_force: Floats


def constrained_dynamics(
    inertia: ArrayLike,
    rest_force: ArrayLike,
    A: ArrayLike,
    force: ArrayLike,
    V: ArrayLike | None = None,
    A_rate: ArrayLike | None = None,
) -> ConstrainedDynamics:
    """Accelerations and constraint forces of a tip whose velocity keeps A V = 0.

    lambda = (A Lambda^-1 A')^-1 (A Lambda^-1 (F - gamma - eta) + dA/dt V)
    P = I - A' (A Lambda^-1 A')^-1 A Lambda^-1

    P is not symmetric: it projects at right angles in the metric of Lambda^-1 only.

    Args:
        inertia: (*batch, m, m) Lambda, or the mass matrix where constraints are said in joints.
        rest_force: (*batch, m) gamma + eta.
        A: (*batch, k, m) with independent rows, none of a tip that is free, or one row (m,).
        force: (*batch, m) F.
        V: (*batch, m) velocity; needed where A changes.
        A_rate: (*batch, k, m) dA/dt; zero if None.

    Raises:
        InputError: a wrong shape, a number that is not finite, rows that depend on each other.

    Reference: Lynch and Park, Modern Robotics, sec. 11.6.2; the sign of dA/dt V is corrected.
    """
    tip = _constrained_tip(inertia, rest_force, A, force, V, A_rate)
    Lambda, A, pushed = tip.inertia, tip.A, tip.force - tip.rest_force
    try:
        solved = real_array("inertia", np.linalg.solve(Lambda, np.swapaxes(A, -1, -2)))
    except np.linalg.LinAlgError:
        raise InputError("control.singular_inertia") from None
    weight = real_array("A", np.linalg.inv(A @ solved))
    pull = _times(np.swapaxes(solved, -1, -2), pushed) + tip.bend
    multipliers = _times(weight, pull)
    back = np.swapaxes(A, -1, -2)
    rate = real_array("inertia", np.linalg.solve(Lambda, (pushed - _times(back, multipliers))[..., None]))
    P = np.eye(Lambda.shape[-1]) - back @ weight @ np.swapaxes(solved, -1, -2)
    return ConstrainedDynamics(multipliers, rate[..., 0], P, _times(back, _times(weight, tip.bend)))


@dataclass(frozen=True, eq=False, slots=True)
class ReducedDynamics:
    """The m - k equations of a constrained tip, V = N u: N' F = N' Lambda N du/dt + N' (Lambda dN/dt u + h).

    Attributes:
        N: (*batch, m, m - k) orthonormal basis of the velocities that the constraint leaves; m - k freedoms of motion.
        inertia: (*batch, m - k, m - k) N' Lambda N.
        rest_force: (*batch, m - k) N' (Lambda dN/dt u + gamma + eta).
        force: (*batch, m - k) N' F.
        acceleration: (*batch, m - k) du/dt.
    """

    N: Floats
    inertia: Floats
    rest_force: Floats
    force: Floats
    acceleration: Floats


def reduced_dynamics(
    inertia: ArrayLike,
    rest_force: ArrayLike,
    A: ArrayLike,
    force: ArrayLike,
    V: ArrayLike | None = None,
    A_rate: ArrayLike | None = None,
) -> ReducedDynamics:
    """The equations of motion of a constrained tip without its multipliers, as many as it has freedoms.

    1. N: the right singular vectors of A that belong to no singular value.
    2. A dV/dt = -dA/dt V leaves dN/dt u = -A' (A A')^-1 dA/dt V, if N turns no more than it must.

    Args:
        inertia, rest_force, A, force, V, A_rate: as of `constrained_dynamics`.

    Raises:
        InputError: a wrong shape, a number that is not finite, rows that depend on each other.

    Reference: Murray, Li and Sastry, A Mathematical Introduction to Robotic Manipulation, sec. 6.1.
    """
    tip = _constrained_tip(inertia, rest_force, A, force, V, A_rate)
    Lambda, A, back = tip.inertia, tip.A, np.swapaxes(tip.A, -1, -2)
    # 1.
    N: Floats = np.swapaxes(np.linalg.svd(A)[2][..., A.shape[-2] :, :], -1, -2)
    # 2.
    drift = -_times(back, np.asarray(np.linalg.solve(A @ back, tip.bend[..., None])[..., 0], dtype=np.float64))
    along = np.swapaxes(N, -1, -2)
    own = along @ Lambda @ N
    rest, push = _times(along, _times(Lambda, drift) + tip.rest_force), _times(along, tip.force)
    try:
        rate_of_u = np.linalg.solve(own, (push - rest)[..., None])[..., 0]
    except np.linalg.LinAlgError:
        raise InputError("control.singular_inertia") from None
    return ReducedDynamics(N, own, rest, push, np.asarray(rate_of_u, dtype=np.float64))


class _ConstrainedTip(NamedTuple):
    """What both forms of the equations of motion start from; `bend` is dA/dt V, (*batch, k)."""

    inertia: Floats
    rest_force: Floats
    A: Floats
    force: Floats
    bend: Floats


def _constrained_tip(
    inertia: ArrayLike, rest_force: ArrayLike, A: ArrayLike, force: ArrayLike, V: ArrayLike | None,
    A_rate: ArrayLike | None,
) -> _ConstrainedTip:  # fmt: skip
    """The arguments of `constrained_dynamics`, checked."""
    Lambda = require_finite("inertia", real_array("inertia", inertia))
    if Lambda.ndim < 2 or Lambda.shape[-1] != Lambda.shape[-2]:
        raise InputError("input.shape", name="inertia", expected="(*batch, m, m)", got=Lambda.shape, hint="")
    m = Lambda.shape[-1]
    rows = np.atleast_2d(real_array("A", A))
    rows = as_batch("A", rows, (rows.shape[-2], m), finite=True)
    require_independent(rows)
    h, F = (as_batch(name, x, (m,), finite=True) for name, x in (("rest_force", rest_force), ("force", force)))
    bend = np.zeros(rows.shape[:-1])
    if A_rate is not None:
        rate = as_batch("A_rate", np.atleast_2d(real_array("A_rate", A_rate)), rows.shape[-2:], finite=True)
        bend = _times(rate, as_batch("V", np.zeros(m) if V is None else V, (m,), finite=True))
    return _ConstrainedTip(Lambda, h, rows, F, bend)


def require_independent(A: Floats) -> None:
    """Raise where rows of a constraint (*batch, k, m) depend on each other; no row at all is no constraint."""
    if not A.shape[-2]:
        return
    sizes = np.linalg.svd(A, compute_uv=False)
    if A.shape[-2] > A.shape[-1] or bool((sizes[..., -1] <= DEPENDENT * sizes[..., 0]).any()):
        raise InputError(
            "control.dependent_constraints",
            rows=A.shape[-2],
            rank=int((sizes > DEPENDENT * sizes[..., :1]).sum(axis=-1).min()),
        )


def constraint_in_joints(A: ArrayLike, J: ArrayLike) -> Floats:
    """A J: the same constraint on joint rates, A J qd = 0; its multipliers are the same.

    Args:
        A: (*batch, k, m) at the tip.
        J: (*batch, m, n) Jacobian of the same coordinates, or E with V = E dq/dt for coordinates q of the pose.
    """
    rows, columns = np.atleast_2d(real_array("A", A)), real_array("J", J)
    return rows @ as_batch("J", columns, (rows.shape[-1], *columns.shape[-1:]))


class SelectionStatus(Status):
    """Whether motion and force components can be chosen together."""

    INDEPENDENT = ("control.selection_independent", True)
    CONFLICT = ("control.selection_conflict", False)


@dataclass(frozen=True, eq=False, repr=False)
class Selection(Answer, data="rank V F conflict"):
    """Whether n components of velocity and force can be prescribed in a linear environment; true if they can.

    Attributes:
        status: whether they can.
        rank: of S_F B + S_V.
        V, F: (n,) velocity and force with the values that were asked for; NaN where they cannot be.
        conflict: (n,) weights of the prescribed components whose sum the environment fixes; zero if there is none.
    """

    status: SelectionStatus
    rank: int
    V: Floats
    F: Floats
    conflict: Floats

    def explain(self, language: str | None = None) -> str:
        """The status, with the combination that the environment fixes."""
        if self:
            return self.status.sentence(language)
        terms = ", ".join(f"{x:.3g}" for x in self.conflict)
        return self.status.sentence(language) + say("control.selection_weights", language=language, weights=terms)


def selection(
    environment: ArrayLike, forces: ArrayLike, velocities: ArrayLike, values: ArrayLike | None = None
) -> Selection:
    """Whether combinations S_F F + S_V V of force and velocity can be prescribed where the environment gives F = B V.

    Motion and force along one direction cannot both be: the environment fixes the other.

    Args:
        environment: (n, n) B.
        forces, velocities: (n, n) S_F and S_V, a row for each prescribed component.
        values: (n,) of the components; zero if None.

    Raises:
        InputError: a wrong shape, a number that is not finite.

    Reference: Lynch and Park, Modern Robotics, sec. 11.6.
    """
    B = require_finite("environment", real_array("environment", environment))
    if B.ndim != 2 or B.shape[0] != B.shape[1]:
        raise InputError("input.shape", name="environment", expected="(n, n)", got=B.shape, hint="")
    n = len(B)
    S_F, S_V = (as_batch(name, x, (n, n), finite=True) for name, x in (("forces", forces), ("velocities", velocities)))
    wanted = np.zeros(n) if values is None else as_batch("values", values, (n,), finite=True)
    system = S_F @ B + S_V
    left, sizes, _ = np.linalg.svd(system)
    rank = int((sizes > DEPENDENT * max(float(sizes[0]), LEAST_DIVISOR)).sum())
    if rank < n:
        nothing, weights = np.full(n, np.nan), left[:, -1]
        return Selection(SelectionStatus.CONFLICT, rank, nothing, nothing, weights)
    V = np.asarray(np.linalg.solve(system, wanted), dtype=np.float64)
    return Selection(SelectionStatus.INDEPENDENT, rank, V, B @ V, np.zeros_like(V))


class ContactMode(Status):
    """The mode of a contact with friction."""

    FREE = ("control.contact_free", False)
    SLIDING = ("control.contact_sliding", True)
    STICKING = ("control.contact_sticking", True)

    @property
    def force_freedoms(self) -> int:
        """Directions in which force can be chosen, of a point contact in space."""
        return {"FREE": 0, "SLIDING": 1, "STICKING": 3}[self.name]


def contact_mode(normal_force: float, tangential_force: ArrayLike, friction: float) -> ContactMode:
    """Whether a point contact sticks, slides or is lost: |F_t| <= mu F_n and F_n > 0, or beyond, or F_n <= 0.

    Args:
        normal_force: F_n that presses [N].
        tangential_force: (2,) or magnitude F_t that would hold it [N].
        friction: mu.

    Raises:
        InputError: a number that is not finite, a negative coefficient.
    """
    held, mu = _press(normal_force, friction)
    size = float(np.linalg.norm(require_finite("tangential_force", real_array("tangential_force", tangential_force))))
    if held <= 0.0:
        return ContactMode.FREE
    return ContactMode.STICKING if size <= mu * held else ContactMode.SLIDING


def sliding_friction(normal_force: float, velocity: ArrayLike, friction: float) -> Floats:
    """Friction on a point that slides: F_t = -mu F_n v / |v|, none where nothing presses or nothing slides.

    Args:
        normal_force: F_n that presses [N].
        velocity: (*batch, d) of the point along the surface [m/s].
        friction: mu.

    Returns:
        (*batch, d) [N]. At rest it is zero here: what friction does then depends on the other forces (`contact_mode`).

    Raises:
        InputError: a number that is not finite, a negative coefficient.
    """
    held, mu = _press(normal_force, friction)
    v = require_finite("velocity", np.atleast_1d(real_array("velocity", velocity)))
    speed = np.linalg.norm(v, axis=-1, keepdims=True)
    return np.asarray(-mu * max(held, 0.0) * v / np.where(speed > 0.0, speed, 1.0), dtype=np.float64)


def _press(normal_force: float, friction: float) -> tuple[float, float]:
    return number("normal_force", normal_force), not_negative("friction", friction)


@dataclass(frozen=True, slots=True)
class TaskConstraint:
    """One line of the table of a constrained task.

    Attributes:
        natural: what the environment fixes, such as `z' = 0`.
        artificial: what the controller chooses along the same direction, such as `F_z = -5`.
    """

    natural: str
    artificial: str


def constraint_table(
    constrained: tuple[bool, ...], wanted: tuple[float, ...], names: tuple[str, ...]
) -> tuple[TaskConstraint, ...]:
    """Natural and artificial constraints along the axes of a task frame.

    Along an axis that the environment blocks velocity is naturally zero and force is chosen; along a free one force is
    naturally zero and velocity is chosen: always as many chosen as there are axes.

    Args:
        constrained: of each axis, whether the environment blocks it.
        wanted: of each axis, the force or velocity that is chosen.
        names: of the axes.

    Raises:
        InputError: lists of different lengths.

    Reference: Mason, Compliance and force control for computer controlled manipulators, 1981.
    """
    for name, each in (("constrained", constrained), ("wanted", wanted), ("names", names)):
        require_kind(name, each, "sequence, an entry for each axis", "__len__", "__getitem__")
    chosen = single("wanted", wanted, (len(wanted),))
    if not len(constrained) == len(chosen) == len(names):
        lengths = (len(constrained), len(wanted), len(names))
        raise InputError("input.shape", name="wanted", expected=(len(names),), got=lengths, hint="")
    return tuple(
        TaskConstraint(f"d{name}/dt = 0", f"F_{name} = {value:g}")
        if blocked
        else TaskConstraint(f"F_{name} = 0", f"d{name}/dt = {value:g}")
        for blocked, value, name in zip(constrained, chosen.tolist(), names, strict=True)
    )


def _times(A: Floats, x: Floats) -> Floats:
    return (A @ x[..., None])[..., 0]
