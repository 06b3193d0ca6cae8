"""Inverse dynamics over time: a motion in, the efforts that make it out."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import (
    Floats,
    JointVector,
    as_batch,
    real_array,
    require_finite,
    require_function,
    require_kind,
    whole,
)
from mafsil.errors import InputError
from mafsil.messages.tables import in_notebook
from mafsil.robot import Robot, of_robot
from mafsil.simulation.findings import joint_table
from mafsil.simulation.motion.system import Source, signal, spread
from mafsil.trajectory import Trajectory

STENCIL = 7
"""Samples that a derivative uses: exact for polynomials of degree six."""


class EffortStatus(Status):
    """Whether the efforts of a motion are numbers."""

    FOUND = ("simulation.efforts_found", True)
    NOT_FINITE = ("simulation.efforts_not_finite", False)


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class InverseMotion(Answer, data="joints t q qd qdd tau"):
    """A motion with the efforts it needs, at given times; true if all of them are finite.

    Attributes:
        joints: (n,) names.
        t: (k,) times [s].
        q, qd, qdd: (k, *batch, n) motion [rad | m] and time derivatives.
        tau: (k, *batch, n) efforts [N m | N].
    """

    joints: tuple[str, ...]
    t: Floats
    q: JointVector
    qd: JointVector
    qdd: JointVector
    tau: JointVector

    def __repr__(self) -> str:
        peaks = {"rate": self.qd, "acceleration": self.qdd, "effort": self.tau}
        return joint_table(self.explain(), self.joints, self.q, peaks)

    def _repr_html_(self) -> str:
        return in_notebook(repr(self))

    @property
    def status(self) -> EffortStatus:
        """Whether the efforts are finite."""
        return EffortStatus.FOUND if bool(np.isfinite(self.tau).all()) else EffortStatus.NOT_FINITE

    def explain(self, language: str | None = None) -> str:
        """Whether the efforts were found, in one sentence."""
        finite = np.isfinite(self.tau).reshape(len(self.t), -1).all(axis=1)
        time = float(self.t[int(np.argmin(finite))]) if len(self.t) else 0.0
        return self.status.sentence(language, count=len(self.t), time=time)

    @property
    def power(self) -> Floats:
        """Mechanical power tau . qd (k, *batch) [W]."""
        return (self.tau * self.qd).sum(axis=-1)


@of_robot
def inverse_dynamics_trajectory(
    robot: Robot,
    motion: Trajectory | ArrayLike | Callable[[float], ArrayLike],
    t: ArrayLike,
    *,
    qd: ArrayLike | None = None,
    qdd: ArrayLike | None = None,
    tip_wrench: Source = None,
    friction: bool = True,
) -> InverseMotion:
    """The efforts tau(t) that a motion q(t) needs: tau = M qdd + c + g + friction + J' F_tip at each time.

    Rates and accelerations that are not given are found by differentiation: exactly for a trajectory, by formulas of
    sixth order through seven neighbouring samples otherwise (a function is sampled at the times `t`).

    Args:
        robot: the arm.
        motion: a trajectory, a function q(t), or (k, *batch, n) samples at the times `t` [rad | m].
        t: (k,) increasing times [s].
        qd, qdd: (k, *batch, n) rates and accelerations of sampled motions, if they are known.
        tip_wrench: (m, f) that the tip exerts on the world, in the tip frame: None, constant, f(t), f(t, q, qd) or
            `Sampled` [N m, N].
        friction: whether the friction that the description gives its joints counts; False leaves it out.

    Raises:
        InputError: a wrong shape, a number that is not finite, times that do not increase, fewer than three samples to
            differentiate.

    Reference: Lynch & Park, Modern Robotics, sec. 8.3.2.
    """
    require_kind("robot", robot, "Robot", "mechanism", "inverse_dynamics")
    times = require_finite("t", real_array("t", t))
    if times.ndim != 1 or not (np.diff(times) > 0.0).all():
        raise InputError("simulation.times", got=times.shape)
    if isinstance(motion, Trajectory):
        u, v, a = motion.at(times)
        as_batch("motion", u, (robot.n,))
    else:
        sampled = _sample(motion, times, robot.n) if callable(motion) else motion
        u, v, a = _differentiate(robot.n, times, sampled, qd, qdd)
    load = _wrenches(times, u, v, tip_wrench)
    tau = robot.inverse_dynamics(u, v, a) if load is None else robot.inverse_dynamics(u, v, a, load)
    if friction:
        tau = tau + robot.friction_torque(v)
    return InverseMotion(robot.joint_names, times, u, v, a, tau)


def _sample(motion: Callable[[float], ArrayLike], times: Floats, n: int) -> Floats:
    """Values (k, *batch, n) of a function of time."""
    require_function("motion", motion, "function q(t)", 1)
    rows = [as_batch("motion", motion(t), (n,)) for t in times.tolist()]
    for row in rows:
        if row.shape != rows[0].shape:
            raise InputError("input.shape", name="motion", expected=rows[0].shape, got=row.shape, hint="")
    return np.stack(rows) if rows else np.zeros((0, n))


def _wrenches(t: Floats, q: Floats, qd: Floats, source: Source) -> Floats | None:
    wrench = signal("tip_wrench", source, 6)
    if wrench is None:
        return None
    rows = [spread("tip_wrench", wrench(*row), (*q.shape[1:-1], 6)) for row in zip(t.tolist(), q, qd, strict=True)]
    return require_finite("tip_wrench", np.reshape(rows, (*q.shape[:-1], 6)))


def _differentiate(
    n: int, t: Floats, q: ArrayLike, qd: ArrayLike | None, qdd: ArrayLike | None
) -> tuple[Floats, Floats, Floats]:
    """Samples with their derivatives, found where they are not given."""
    u = require_finite("q", as_batch("q", q, (n,)))
    if u.ndim < 2 or len(u) != len(t):
        raise InputError("input.shape", name="q", expected=(len(t), "*batch", n), got=u.shape, hint="")
    given: list[Floats | None] = []
    for name, value in (("qd", qd), ("qdd", qdd)):
        array = None if value is None else require_finite(name, as_batch(name, value, (n,)))
        if array is not None and array.shape != u.shape:
            raise InputError("input.shape", name=name, expected=u.shape, got=array.shape, hint="")
        given.append(array)
    v, a = given
    if (v is None or a is None) and len(t) < 3:
        raise InputError("simulation.samples", count=len(t))
    rates = differentiate(t, u, 1) if v is None else v
    if a is None:
        a = differentiate(t, u, 2) if v is None else differentiate(t, v, 1)
    return u, rates, a


def differentiate(t: ArrayLike, values: ArrayLike, order: int = 1) -> Floats:
    """Derivative (k, ...) of samples at any increasing times, through up to seven neighbours of each.

    Args:
        t: (k,) times [s].
        values: (k, ...) samples.
        order: 1 or 2.

    Raises:
        InputError: not finite, too few times, times that do not rise, another number of samples.

    Reference: Fornberg, Generation of finite difference formulas on arbitrarily spaced grids, Math. Comp. 51, 1988.
    """
    times, samples = (require_finite(name, real_array(name, x)) for name, x in (("t", t), ("values", values)))
    whole("order", order, 1, 2)
    count = times.size
    if times.ndim != 1 or count <= order:
        raise InputError("input.shape", name="t", expected=f"(k,), k > {order}", got=times.shape, hint="")
    if samples.shape[:1] != (count,):
        raise InputError("input.shape", name="values", expected=f"({count}, ...)", got=samples.shape, hint="")
    if not (np.diff(times) > 0.0).all():
        raise InputError("simulation.times", got=times.shape)
    width = min(STENCIL, count)
    first = np.clip(np.arange(count) - width // 2, 0, count - width)
    rows = first[:, None] + np.arange(width)
    spacing = (times[rows[:, -1]] - times[rows[:, 0]]) / max(width - 1, 1)
    offsets = (times[rows] - times[:, None]) / spacing[:, None]
    powers = np.arange(float(width))[:, None]
    # Weights that differentiate 1, x, x^2, ... exactly.
    moments = np.zeros((count, width, 1))
    moments[:, order] = float(order)
    weights = np.linalg.solve(offsets[:, None, :] ** powers, moments)[..., 0] / spacing[:, None] ** order
    return cast(Floats, np.einsum("kw,kw...->k...", weights, samples[rows]))
