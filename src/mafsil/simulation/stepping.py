"""One integration step of a plant under a constant effort, by the name of its method; friction explicit or implicit."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, Vector6, as_batch, positive, require_kind
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.mechanics.friction import SMOOTHING, FrictionLaw
from mafsil.mechanics.tolerances import NEGLIGIBLE_RATE
from mafsil.simulation.plant import Plant
from mafsil.solvers import METHODS, Splitting, method, second_order
from mafsil.solvers.integrate import State, Step

if TYPE_CHECKING:
    import mafsil.simulation.friction_loops as friction_loops
else:
    friction_loops = lazily("mafsil.simulation.friction_loops")

IMPLICIT_FRICTION = "implicit_friction"
"""Semi-implicit Euler whose friction acts with the rate at the end of the step: stable for any friction and step."""
INTEGRATORS = (*METHODS, IMPLICIT_FRICTION)
DEFAULT = "semi_implicit_euler"
ITERATIONS = 6
"""Secant iterations of the implicit friction. Each takes energy away, however few they are."""
MOST_EVALUATIONS = 4
"""Evaluations of the dynamics in one expression, beyond which it gets too long to compile."""
STIFF = 1.0
"""Step times the fastest decay that friction causes, from which on explicit integration is not to be trusted (2 is the
stability limit of Euler's method)."""


def friction_stiffness(plant: Plant, q: JointVector) -> float:
    """Fastest decay [1/s] of small joint rates by friction: the largest eigenvalue of M(q)^-1 diag(df/dqd at rest).

    Args:
        plant: with its friction.
        q: (k, n) positions to look at.
    """
    if not plant.has_friction or not q.size:
        return 0.0
    law = plant.friction_law
    root = np.sqrt(law.viscous + np.maximum(law.positive, law.negative) / SMOOTHING)[:, None] * law.gain
    M = plant.robot.mass_matrix(q.reshape(-1, q.shape[-1]))
    try:
        scaled = root @ np.linalg.solve(M[np.isfinite(M).all(axis=(1, 2))], root.T)
    except np.linalg.LinAlgError:
        return np.inf
    return float(np.linalg.eigvalsh((scaled + np.swapaxes(scaled, -1, -2)) / 2.0)[:, -1].max(initial=0.0))


def choose_integrator(plant: Plant, q: JointVector, step: float, preferred: str = DEFAULT) -> str:
    """The preferred method, or the one with implicit friction if friction is too stiff for the step.

    Args:
        plant: with its friction.
        q: (k, n) positions that the motion passes.
        step: of the integration [s].
        preferred: name of a method.
    """
    require_kind("plant", plant, "Plant", "has_friction", "robot")
    require_integrator(preferred)
    q, step = as_batch("q", q, (plant.robot.n,)), positive("step", step)
    return IMPLICIT_FRICTION if friction_stiffness(plant, q) * step > STIFF else preferred


def require_integrator(name: str) -> None:
    """Refuse a name that is no integrator.

    Raises:
        InputError: it is not known; the sentence lists the names.
    """
    if name not in INTEGRATORS:
        raise InputError("input.choice", name="integrator", value=name, known=", ".join(INTEGRATORS))


@dataclass(slots=True)
class Stepper:
    """Steps of a plant.

    Attributes:
        plant: that moves.
        name: of the integrator.
        step: length of a step [s].
        effort: (*batch, n), constant over the step [N m | N].
        push: (*batch, 6) of the world on the tip, or None.
    """

    plant: Plant
    name: str
    step: float
    effort: JointVector = field(default_factory=lambda: np.zeros(0))
    push: Vector6 | None = None

    def move(self) -> Step:
        """The step as a function of (t, state, h)."""
        if self.name == IMPLICIT_FRICTION:
            return self._implicit
        return second_order(method(self.name), self._explicit)

    def acceleration(self, q: JointVector, qd: JointVector, effort: JointVector, push: Vector6 | None) -> JointVector:
        """qdd (*batch, n) with which a step begins; with implicit friction, its mean over the step."""
        if self.name == IMPLICIT_FRICTION:
            return damped_acceleration(self.plant, q, qd, effort, push, self.step)
        return self.plant.acceleration(q, qd, effort, push)

    def settle(self, q: JointVector, qd: JointVector) -> State:
        """The state that a step begins with: of a tree the one that the step before left.

        Args:
            q, qd: (*batch, n) coordinates and rates.
        """
        return q, qd

    def scheme(self) -> tuple[object, ...]:
        """The method as data for the compiled loop."""
        if self.name == IMPLICIT_FRICTION:
            return (IMPLICIT_FRICTION, ITERATIONS)
        chosen = method(self.name)
        if isinstance(chosen, Splitting):
            return ("splitting", chosen.kicks, chosen.drifts)
        return ("runge_kutta", chosen.a, chosen.b)

    def evaluations(self) -> int:
        """Evaluations of the dynamics in one step."""
        if self.name == IMPLICIT_FRICTION:
            return 2
        chosen = method(self.name)
        return len(chosen.kicks) if isinstance(chosen, Splitting) else chosen.stages

    def _explicit(self, t: float, q: JointVector, qd: JointVector) -> JointVector:
        return self.plant.acceleration(q, qd, self.effort, self.push)

    def _implicit(self, t: float, state: State, h: float) -> State:
        q, qd = state
        qd = qd + h * damped_acceleration(self.plant, q, qd, self.effort, self.push, h)
        return q + h * qd, qd


def damped_acceleration(
    plant: Plant, q: JointVector, qd: JointVector, effort: JointVector, push: Vector6 | None, h: float
) -> JointVector:
    """Mean acceleration (*batch, n) over a step, friction taken at its end: M a = tau - c - g - f(qd + h a).

    Args:
        plant: that moves.
        q, qd: (*batch, n) state at the beginning of the step.
        effort: (*batch, n), constant over the step [N m | N].
        push: (*batch, 6) of the world on the tip, in the tip frame, or None.
        h: length of the step [s].
    """
    robot, push = plant.robot, plant.tip_push(q, qd, push)
    if push is None:
        load = effort - robot.inverse_dynamics(q, qd, np.zeros(robot.n))
    else:
        load = effort - robot.inverse_dynamics(q, qd, np.zeros(robot.n), -push)
    M = robot.mass_matrix(q)
    if not plant.has_friction:
        return _solve(M, load)
    found, sound = _compile(plant.friction_law, M, qd, load, h)
    if not sound.all():
        M, qd, load = M[~sound], qd[~sound], load[~sound]
        found[~sound] = by_secants(plant, qd, load, h, lambda D, b: _solve(M if D is None else M + D, b))
    return found


def _compile(law: FrictionLaw, M: Floats, qd: Floats, load: Floats, h: float) -> tuple[Floats, NDArray[np.bool_]]:
    """Accelerations (*batch, n), and where (*batch) they are sound: where matrices were positive definite."""
    n = qd.shape[-1]
    found, sound = np.empty(load.shape), np.empty(load.shape[:-1], dtype=np.bool_)
    if M.ndim == load.ndim or qd.ndim < load.ndim:  # efforts of many runs in one state
        M, qd = np.broadcast_to(M, (*load.shape, n)), np.broadcast_to(qd, load.shape)
    masses, rates = np.ascontiguousarray(M.reshape(-1, n, n)), np.ascontiguousarray(qd.reshape(-1, n))
    bare = (load - law.offset @ law.gain).reshape(-1, n)
    friction_loops.accelerations_by_secants(
        masses,
        bare,
        rates,
        law.viscous,
        law.positive,
        law.negative,
        law.gain,
        h,
        ITERATIONS,
        found.reshape(-1, n),
        sound.reshape(-1),
    )
    return found, sound


def by_secants(
    plant: Plant,
    qd: JointVector,
    load: JointVector,
    h: float,
    solve: Callable[[Floats | None, JointVector], JointVector],
) -> JointVector:
    """Mean acceleration (*batch, n) over a step with the plant's friction at its end: M a = load - f(qd + h a).

    The friction curve is replaced by its secant through rest, D v with D >= 0, at the rate found before, several times:
    (M + h D) a = load - D qd.

    Args:
        plant: whose friction it is.
        qd: (*batch, n) rates at the beginning of the step.
        load: (*batch, n) efforts without friction.
        h: length of the step [s].
        solve: gives accelerations.
    """
    if not plant.has_friction:
        return solve(None, load)
    law = plant.friction_law
    load = load - law.offset @ law.gain
    after, acceleration = qd, np.zeros_like(qd)
    for _ in range(ITERATIONS):
        slope = friction_slope(law, after)
        acceleration = solve(h * slope, load - (slope @ qd[..., None])[..., 0])
        after = qd + h * acceleration
    return acceleration


def _solve(M: Floats, b: Floats) -> Floats:
    """x with M x = b; NaN where M or b is not finite or M is singular."""
    try:
        return np.asarray(np.linalg.solve(M, b[..., None])[..., 0], dtype=np.float64)
    except np.linalg.LinAlgError:
        return np.full_like(b, np.nan)


def friction_slope(law: FrictionLaw, v: Floats) -> Floats:
    """D (*batch, n, n): D v + offset is the friction at the rates v (*batch, n)."""
    w = v @ law.gain.T
    moving = np.abs(w) > NEGLIGIBLE_RATE * SMOOTHING
    share = np.where(moving, np.tanh(w / SMOOTHING) / np.where(moving, w, 1.0), 1.0 / SMOOTHING)
    slope = law.viscous + np.where(w >= 0.0, law.positive, law.negative) * share
    return law.gain.T @ (slope[..., None] * law.gain)
