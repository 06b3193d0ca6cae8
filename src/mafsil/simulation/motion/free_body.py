"""A single rigid body under wrenches over time, on the group of its poses: rotations stay rotations."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from math import inf
from time import perf_counter

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import (
    Floats,
    PoseMatrix,
    Vector6,
    as_batch,
    positive,
    require_function,
    require_kind,
    single,
    whole,
)
from mafsil.geometry import pose, wrench
from mafsil.mechanics.rigid_body import RigidBody
from mafsil.messages import say
from mafsil.messages.tables import in_notebook, number, table
from mafsil.simulation.tolerances import NO_SECONDS, SLOWEST_TURN
from mafsil.solvers.adaptive import Budget, Tolerance, integrate_adaptively
from mafsil.solvers.embedded import pair
from mafsil.solvers.outcome import Outcome
from mafsil.solvers.solution import IntegrationStatus, Solution

LONGEST_TURN = 0.5
"""Angle [rad] that a local chart spans: far from pi, where the exponential coordinates end."""

BodyWrench = Callable[[float, PoseMatrix, Vector6], ArrayLike]


@dataclass(frozen=True, eq=False, slots=True, repr=False)
class FreeBodyMotion(Answer, data="t T V"):
    """Poses and twists of a body over time; true if the motion reached its end.

    Attributes:
        body: that moves.
        t: (k,) times [s].
        T: (k, 4, 4) poses T_sb.
        V: (k, 6) body twists (omega, v) in {b}.
        outcome: how the last stretch of the integration ended.
        gravity: (3,) acceleration of free fall in {s}.
    """

    body: RigidBody
    t: Floats
    T: PoseMatrix
    V: Vector6
    outcome: Outcome[Solution]
    gravity: Floats

    def __bool__(self) -> bool:
        return self.outcome.succeeded

    def _table(self) -> list[str]:
        names = ("x", "y", "z", "ω_x", "ω_y", "ω_z", "v_x", "v_y", "v_z")
        values = np.concatenate([self.T[:, :3, 3], self.V], axis=1)
        columns = (values[0], values[-1], values.min(axis=0), values.max(axis=0))
        rows = [[name, *(number(float(x)) for x in row)] for name, *row in zip(names, *columns, strict=True)]
        head = [say(f"simulation.column_{name}") for name in ("component", "start", "end", "lowest", "highest")]
        return table(head, rows)

    def _repr_html_(self) -> str:
        return in_notebook(repr(self))

    @property
    def status(self) -> Status:
        """How the integration ended."""
        return self.outcome.status

    @property
    def succeeded(self) -> bool:
        """Whether the motion reached its end."""
        return self.outcome.succeeded

    @property
    def energy(self) -> Floats:
        """Kinetic and potential energy (k,) [J]."""
        inertial = self.body.inertial
        com = self.T[:, :3, :3] @ inertial.com + self.T[:, :3, 3]
        return self.body.kinetic_energy(self.V) - inertial.mass * (com @ self.gravity)

    @property
    def momentum_space(self) -> Vector6:
        """Momentum (k, 6) seen from {s}: constant when nothing acts [N m s, N s]."""
        return wrench.transform(pose.inverse(self.T), self.body.momentum(self.V))

    def explain(self, language: str | None = None) -> str:
        """How the integration ended, in one sentence."""
        return self.outcome.explain(language)


def free_body_motion(
    body: RigidBody,
    T: ArrayLike,
    V: ArrayLike,
    F: BodyWrench | ArrayLike | None = None,
    *,
    duration: float,
    gravity: ArrayLike = (0.0, 0.0, 0.0),
    method: str = "dop853",
    tolerance: float = 1e-10,
    most_steps: int = 1_000_000,
    seconds: float = inf,
) -> FreeBodyMotion:
    """The motion of a free body: G dV = F + [ad_V]' G V, dT/dt = T [V].

    Each stretch is integrated in exponential coordinates x about its first pose, T = T_0 exp([x]), so that any method
    for vectors moves on SE(3): dx/dt = J_r(x)^-1 V.

    Args:
        body: with its frame {b} anywhere on it.
        T: (4, 4) pose T_sb at the beginning.
        V: (6,) body twist (omega, v) in {b} at the beginning.
        F: wrench (m, f) in {b} that acts on the body besides gravity [N m, N]: constant (6,), or a function of
            (t, T, V); None for none.
        duration: [s].
        gravity: (3,) acceleration of free fall in {s} [m/s^2].
        method: an adaptive pair: bs23, dp45 or dop853.
        tolerance: error of a step, relative and absolute.
        most_steps, seconds: after so many steps or so much wall-clock time the motion ends where it is.

    Raises:
        InputError: a wrong shape, no pose, a number that is not finite or positive, an unknown method.
        ModelError: the inertia is singular.

    Reference: Lynch & Park, Modern Robotics, sec. 8.2; Munthe-Kaas, High order Runge-Kutta methods on manifolds, 1999.
    """
    require_kind("body", body, "RigidBody", "inertial", "acceleration")
    start, turn = pose.check(single("T", T, (4, 4))), single("V", V, (6,))
    end, accuracy = positive("duration", duration), Tolerance(positive("tolerance", tolerance), tolerance)
    whole("most_steps", most_steps, 1)
    deadline = perf_counter() + Budget(seconds=seconds).seconds
    fall = single("gravity", gravity, (3,))
    with np.errstate(over="ignore", invalid="ignore"):
        body.acceleration(turn, np.zeros(6))
    system = _Body(body, _wrench_of(F), fall)
    times, poses, twists = [0.0], [start], [turn]
    spent = 0
    while True:
        # A stretch ends when the chart has turned far enough; its length follows from the present rate.
        system.origin = poses[-1]
        with np.errstate(over="ignore", invalid="ignore"):
            rate = max(float(np.linalg.norm(twists[-1][:3])), SLOWEST_TURN)
            outcome = integrate_adaptively(
                pair(method),
                system.rates,
                np.concatenate([np.zeros(6), twists[-1]]),
                (times[-1], min(end, max(times[-1] + LONGEST_TURN / rate, float(np.nextafter(times[-1], inf))))),
                tolerance=accuracy,
                budget=Budget(most_steps - spent, max(deadline - perf_counter(), NO_SECONDS)),
            )
        spent += outcome.iterations
        _append(outcome.value, system.origin, times, poses, twists)
        status = outcome.status
        if outcome.succeeded and times[-1] < end:
            status = IntegrationStatus.BUDGET_SPENT if spent >= most_steps else status
            status = IntegrationStatus.TIME_SPENT if perf_counter() > deadline else status
        if not status.succeeded or times[-1] >= end:
            details = {"time": times[-1], "end": end, "events": 0}
            ended = replace(outcome, status=status, iterations=spent, details=details)
            return FreeBodyMotion(body, np.array(times), np.array(poses), np.array(twists), ended, fall)


class _Body:
    """The equations of motion in the chart about a pose."""

    def __init__(self, body: RigidBody, load: BodyWrench | None, gravity: Floats) -> None:
        self.G = body.spatial_inertia
        self.inverse = np.linalg.inv(self.G)
        self.mass, self.com = body.inertial.mass, body.inertial.com
        self.load, self.gravity, self.falls = load, gravity, bool(gravity.any())
        self.origin = np.eye(4)

    def rates(self, t: float, y: Floats) -> Floats:
        """Derivative (12,) of (x, V)."""
        x, V = y[:6], y[6:]
        if not np.isfinite(y).all():
            return np.full(12, np.nan)
        F = wrench.dual_bracket(V, self.G @ V)
        if self.load is not None or self.falls:
            T = self.origin @ pose.exp(x)
            if self.falls:
                force = self.mass * (T[:3, :3].T @ self.gravity)
                F = F + np.concatenate([np.cross(self.com, force), force])
            if self.load is not None:
                F = F + as_batch("F", self.load(t, T, V), (6,))
        return np.concatenate([pose.right_jacobian_inverse(x) @ V, self.inverse @ F])


def _wrench_of(F: BodyWrench | ArrayLike | None) -> BodyWrench | None:
    if F is None:
        return None
    if callable(F):
        require_function("F", F, "function of (t, T, V)", 3)
        return F
    constant = single("F", F, (6,))
    return lambda t, T, V: constant


def _append(
    solution: Solution, origin: PoseMatrix, times: list[float], poses: list[PoseMatrix], twists: list[Vector6]
) -> None:
    """Steps of a stretch as poses and twists."""
    here = list(origin @ pose.exp(solution.y[1:, :6]))
    if here:
        # The product of many rotations leaves the group by rounding; once a stretch it is led back.
        here[-1] = pose.project(here[-1])
    times.extend(solution.t[1:].tolist())
    poses.extend(here)
    twists.extend(solution.y[1:, 6:])
