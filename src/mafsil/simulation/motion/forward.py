"""Forward dynamics over time: efforts in, motion out, by any integrator."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, as_batch, positive, require_finite, require_kind, whole
from mafsil.errors import InputError
from mafsil.kernels.lazy import lazy
from mafsil.messages.tables import in_notebook
from mafsil.model import JointKind
from mafsil.robot import Robot, of_robot
from mafsil.simulation.findings import joint_table
from mafsil.simulation.motion.fixed_step import COMPOSITIONS, Clock, fixed_step_solution
from mafsil.simulation.motion.system import DrivenRobot, Source, breaks_of, common_shape, signal
from mafsil.simulation.tolerances import PART_OF_STEP
from mafsil.solvers import METHODS
from mafsil.solvers.adaptive import Budget, Tolerance, integrate_adaptively
from mafsil.solvers.embedded import PAIRS, pair
from mafsil.solvers.outcome import Outcome
from mafsil.solvers.solution import Crossing, Event, Solution, require_events
from mafsil.trajectory import Motion

METHOD_NAMES = (*PAIRS, *METHODS, *COMPOSITIONS)
"""Integrators by name: adaptive pairs, fixed-step methods, variational ones."""
DEFAULT_STEP = 1e-3


@dataclass(frozen=True, eq=False, repr=False)
class ForwardMotion(Answer, data="method t q qd qdd tau"):
    """The motion from an initial state under given efforts: recorded at the steps, interpolated between.

    True if the motion reached its end or a terminal event; iterable over the motions of a batch.

    Attributes:
        robot: that moved.
        method: name of the integrator.
        t: (k,) ends of the steps [s].
        q, qd, qdd: (k, *batch, n) motion there [rad | m] and time derivatives.
        tau: (k, *batch, n) efforts of the motors there [N m | N].
        outcome: how the integration ended, with the polynomials of the steps.
    """

    robot: Robot
    method: str
    t: Floats
    q: JointVector
    qd: JointVector
    qdd: JointVector
    tau: JointVector
    outcome: Outcome[Solution]
    _system: DrivenRobot
    _momenta: bool

    def __bool__(self) -> bool:
        return self.outcome.succeeded

    def __len__(self) -> int:
        return self.q.shape[1] if self.q.ndim > 2 else 1

    def __iter__(self) -> Iterator[ForwardMotion]:
        if self.q.ndim <= 2:
            return iter((self,))
        return (self._of_batch(k) for k in range(len(self)))

    def __repr__(self) -> str:
        peaks = {"rate": self.qd, "acceleration": self.qdd, "effort": self.tau}
        return joint_table(self.explain(), self.robot.joint_names, self.q, peaks)

    def _repr_html_(self) -> str:
        return in_notebook(repr(self))

    @property
    def status(self) -> Status:
        """How the integration ended."""
        return self.outcome.status

    @property
    def succeeded(self) -> bool:
        """Whether the motion reached its end or a terminal event."""
        return self.outcome.succeeded

    @property
    def duration(self) -> float:
        """Time that was reached [s]."""
        return float(self.t[-1])

    @property
    def n(self) -> int:
        """Number of coordinates."""
        return self.robot.n

    @property
    def events(self) -> tuple[Crossing, ...]:
        """Events that happened, in time; their states y hold (q, qd)."""
        return self.outcome.value.crossings

    @lazy
    def energy(self) -> Floats:
        """Kinetic plus potential energy (k, *batch) at the steps [J]."""
        return self.robot.kinetic_energy(self.q, self.qd) + self.robot.potential_energy(self.q)

    @lazy
    def energy_drift(self) -> float:
        """Largest change of the energy since the start, relative to the largest kinetic energy of the motion."""
        size = np.max(self.robot.kinetic_energy(self.q, self.qd), axis=0)
        change = np.abs(self.energy - self.energy[0]).max(axis=0)
        return float(np.max(change / np.where(size > 0.0, size, 1.0), initial=0.0))

    def at(self, t: ArrayLike) -> Motion:
        """Position, rate and acceleration (*times, *batch, n) at times between 0 and the duration.

        Args:
            t: (*times) [s].

        Raises:
            InputError: a time outside the motion, or not finite.
        """
        y, slope = self.outcome.value.at(t), self.outcome.value.rate_at(t)
        q, second, n = y[..., : self.n], y[..., self.n :], self.n
        if not self._momenta:
            return Motion(q, second, slope[..., n:])
        qd = self._system.rate_of(q, second)
        # pd = d(M qd)/dt, and dM/dt = C + C'.
        C = self.robot.coriolis_matrix(q, qd)
        mass_rate_qd = ((C + np.swapaxes(C, -1, -2)) @ qd[..., None])[..., 0]
        return Motion(q, qd, self._system.rate_of(q, slope[..., n:] - mass_rate_qd))

    def explain(self, language: str | None = None) -> str:
        """How the integration ended, in one sentence."""
        return self.outcome.explain(language)

    def to_dict(self) -> dict[str, Any]:
        """Status, method, events and the motion at the steps."""
        events = [{"time": event.t, "event": event.event, "batch": event.batch} for event in self.events]
        return Answer.to_dict(self) | {"events": events}

    def _of_batch(self, k: int) -> ForwardMotion:
        """One motion of a batch, with its own events."""
        arrays = {name: getattr(self, name)[:, k] for name in ("q", "qd", "qdd", "tau")}
        return replace(self, outcome=replace(self.outcome, value=self.outcome.value.of_batch(k)), **arrays)


@of_robot
def forward_dynamics_trajectory(
    robot: Robot,
    q: ArrayLike,
    qd: ArrayLike | None = None,
    tau: Source = None,
    *,
    duration: float,
    tip_wrench: Source = None,
    friction: bool = True,
    method: str = "dop853",
    step: float | None = None,
    tolerance: float = 1e-9,
    momenta: bool = False,
    events: Sequence[Event] = (),
    most_steps: int = 1_000_000,
    seconds: float = inf,
) -> ForwardMotion:
    """The motion q(t), qd(t) that efforts tau(t) produce from an initial state.

    M(q) qdd = tau(t) - c(q, qd) - g(q) - friction(qd) - J' F_tip(t)

    Adaptive methods (bs23, dp45, dop853) choose their step by the error estimate; those with a fixed step are euler,
    semi_implicit_euler, midpoint, heun, rk4, and the variational ones (variational, variational4, 6, 8), which keep the
    momenta of symmetries and do not let the energy drift: for long motions without friction.

    Args:
        robot: the arm.
        q, qd: (*batch, n) initial state [rad | m] and per second; at rest if None. A batch of efforts or wrenches makes
            a batch of motions from one state.
        tau: efforts [N m | N]: None for none, (*batch, n) constant, f(t) or f(t, q, qd), or `Sampled`.
        duration: of the motion [s].
        tip_wrench: (m, f) that the tip exerts on the world, in the tip frame [N m, N], given as tau is.
        friction: whether the friction that the description gives its joints acts; False leaves it out.
        method: name of an integrator.
        step: of the fixed-step methods [s]; 1 ms if None; the last one is shortened to meet the duration. Adaptive
            methods take none longer, if given.
        tolerance: error of a step that adaptive methods accept: of angles [rad]; of other numbers relative to each, and
            absolute.
        momenta: integrate coordinates and momenta (adaptive methods): conserved momenta then stay exactly constant.
        events: zeros of functions g(t, y), y = (q, qd) in one array (*batch, 2 n); see `mafsil.solvers.Event`.
        most_steps, seconds: after so many steps or so much wall-clock time the motion ends where it is.

    Returns:
        The motion; its status says whether it reached the end. A motion that blows up ends at the last good state.

    Raises:
        InputError: a wrong shape, a number that is not finite or positive, an unknown method, a variational one with
            Coulomb friction, events or momenta with a
            method that cannot have them, a step that needs more than `most_steps`.
        ModelError: the efforts determine no acceleration: some joint moves no inertia.

    Reference: Lynch & Park, Modern Robotics, sec. 8.5 and the algorithm after eq. 8.89.
    """
    require_kind("robot", robot, "Robot", "mechanism", "forward_dynamics")
    if method not in METHOD_NAMES:
        raise InputError("input.choice", name="method", value=method, known=", ".join(METHOD_NAMES))
    end, accuracy = positive("duration", duration), _accuracy(robot, positive("tolerance", tolerance))
    longest = inf if step is None else positive("step", step)
    budget = Budget(whole("most_steps", most_steps, 1), seconds, longest)
    h = DEFAULT_STEP if step is None and method not in PAIRS else longest
    if end / h > budget.steps + PART_OF_STEP:
        raise InputError("simulation.most_steps", steps=end / h, limit=budget.steps)
    require_events(events)
    if method in COMPOSITIONS and friction:
        _require_smooth(robot, method)
    system = DrivenRobot(robot, signal("tau", tau, robot.n), signal("tip_wrench", tip_wrench, 6), friction)
    positions, rates = _start(system, q, qd)
    system.acceleration(0.0, positions, rates)
    if method in PAIRS:
        start = np.concatenate([positions, system.momentum(positions, rates) if momenta else rates], axis=-1)
        outcome = integrate_adaptively(
            pair(method),
            system.momentum_rates if momenta else system.rates,
            start,
            (0.0, end),
            tolerance=accuracy,
            budget=budget,
            events=[_of_rates(event, system) for event in events] if momenta else events,
            breaks=breaks_of(tau, tip_wrench),
        )
    else:
        if momenta or any(event.reset is not None for event in events):
            raise InputError("simulation.adaptive_only", method=method, known=", ".join(PAIRS))
        outcome = fixed_step_solution(system, method, (positions, rates), Clock.until(end, h), events, seconds)
    return _record(system, method, outcome, momenta)


def _require_smooth(robot: Robot, method: str) -> None:
    """Refuse Coulomb friction with a variational method: its step solves for a mean rate, which friction makes jump."""
    for joint in robot.mechanism.joints:
        if joint.moves and joint.friction is not None and (joint.friction.coulomb or joint.friction.coulomb_negative):
            raise InputError("simulation.variational_friction", method=method, joint=joint.name)


def _start(system: DrivenRobot, q: ArrayLike, qd: ArrayLike | None) -> tuple[JointVector, JointVector]:
    """The initial state, one for each motion of the batch."""
    n = system.n
    positions = require_finite("q", as_batch("q", q, (n,)))
    rates = np.zeros(n) if qd is None else require_finite("qd", as_batch("qd", qd, (n,)))
    shape = (*common_shape("qd", rates.shape[:-1], positions.shape[:-1]), n)
    positions, rates = np.broadcast_to(positions, shape), np.broadcast_to(rates, shape)
    shape = (*system.batch(positions, rates), n)
    return np.array(np.broadcast_to(positions, shape)), np.array(np.broadcast_to(rates, shape))


def _accuracy(robot: Robot, tolerance: float) -> Tolerance:
    """The tolerance of each number; that of an angle does not grow with the turns it has made."""
    angles = [joint.kind in (JointKind.REVOLUTE, JointKind.HELICAL) for joint in robot.mechanism.coordinates]
    relative = np.full(2 * robot.n, tolerance)
    relative[: robot.n][angles] = 0.0
    return Tolerance(relative, tolerance)


def _of_rates(event: Event, system: DrivenRobot) -> Event:
    """The same event of a state in momenta."""
    n = system.n

    def states(y: Floats) -> Floats:
        return np.concatenate([y[..., :n], system.rate_of(y[..., :n], y[..., n:])], axis=-1)

    def reset(t: float, y: Floats) -> Floats:
        after = event.after(t, states(y))
        return np.concatenate([after[..., :n], system.momentum(after[..., :n], after[..., n:])], axis=-1)

    changed = None if event.reset is None else reset
    return Event(lambda t, y: event.function(t, states(y)), event.direction, event.terminal, changed, event.name)


def _record(system: DrivenRobot, method: str, outcome: Outcome[Solution], momenta: bool) -> ForwardMotion:
    """What was integrated, with accelerations and efforts at the steps."""
    solution, n = outcome.value, system.n
    q, second = solution.y[..., :n], solution.y[..., n:]
    qd = system.rate_of(q, second) if momenta else second
    t = solution.t
    if system.unloaded:
        tau, qdd = np.zeros_like(q), system.robot.forward_dynamics(q, qd, np.zeros(n))
    else:
        pairs = list(zip(t.tolist(), q, qd, strict=True))
        tau = np.stack([system.motor_efforts(*row) for row in pairs])
        qdd = np.stack([system.acceleration(*row) for row in pairs])
    return ForwardMotion(system.robot, method, t, q, qd, qdd, tau, outcome, system, momenta)
