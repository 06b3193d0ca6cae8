"""An arm whose tip meets a rigid surface: contact made and broken by events that are located within the step.

The tip is away, or it is held: then the surface exerts the force along its normal that keeps the distance zero.

1. Away: the first zero of the signed distance within the step is an impact.
2. An impact turns the speed along the normal round, times the restitution (Newton): qd+ = qd - (1 + e) m M^-1 A' A qd,
   A = dd/dq, m = 1 / (A M^-1 A') the mass that is felt along the normal.
3. If the surface would be met again within `BRIEF_FLIGHT` of a step, 2 e |A qd| / |a| later with the acceleration a
   along the normal, contact lasts from here on: the rest of the bounces would take 1 / (1 - e) times as long
   (geometric series, Zeno), and never end one by one.
4. Held: lambda = -m (A qdd + dA/dt qd) with the qdd without contact. Where it would have to pull, contact ends.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from mafsil.arrays import Floats, JointVector, Vector6
from mafsil.errors import InputError
from mafsil.simulation.contact_events import ContactEvents
from mafsil.simulation.plant import Plant
from mafsil.simulation.rigid_surface import RigidSurface
from mafsil.simulation.stepping import IMPLICIT_FRICTION, Stepper, by_secants
from mafsil.simulation.tolerances import PART_OF_STEP, QUIET, RESTING, TOUCHING
from mafsil.solvers import method, second_order
from mafsil.solvers.bracketed_root import bracketed_root
from mafsil.solvers.integrate import State, Step

METHODS = ("rk4", "midpoint", "heun", IMPLICIT_FRICTION)
"""Integrators whose steps follow a parabola exactly: with others, flights within a step come out too short."""
STARTS_INSIDE = 1e-6
"""Depth [m] beyond which a start in the surface is refused; what is less is put right when contact lasts."""
BRIEF_FLIGHT = 1e-3
"""Part of a step below which a flight between two impacts is not followed any more."""
MOST_EVENTS = 20_000
"""Within one step: flights of at least a thousandth of it make a thousand impacts."""
CORRECTIONS = 3
"""Newton steps that put a held tip back onto the surface."""


@dataclass(frozen=True, eq=False)
class RigidPlant(Plant):
    """A simulated arm that meets a rigid surface; one arm at a time, no batches, and no loops.

    Attributes:
        surface: what the tip's origin cannot enter.

    Raises:
        InputError: the robot has closed loops.
    """

    surface: RigidSurface = field(kw_only=True)

    def __post_init__(self) -> None:
        Plant.__post_init__(self)
        if self.robot.mechanism.loops:
            raise InputError("simulation.rigid_loops")

    def normal_motion(self, q: JointVector, qd: JointVector) -> tuple[Floats, Floats, Floats, Floats]:
        """Distance of the tip [m], A = dd/dq, dA/dt qd [m/s^2] and the normal in the tip frame.

        Args:
            q, qd: (*batch, n) state.

        Returns:
            (*batch,), (*batch, n), (*batch,), (*batch, 3).
        """
        T, J, rate = self.robot.forward_kinematics(q), self.robot.jacobian_body(q), self.robot.jacobian_body_rate(q, qd)
        R, p = T[..., :3, :3], T[..., :3, 3]
        V, bent = ((each @ qd[..., None])[..., 0] for each in (J, rate))
        velocity = (R @ V[..., 3:, None])[..., 0]
        n = self.surface.outward(p)
        inward = (np.swapaxes(R, -1, -2) @ n[..., None])[..., 0]
        A = (inward[..., None, :] @ J[..., 3:, :])[..., 0, :]
        bend = ((bent[..., 3:] + np.cross(V[..., :3], V[..., 3:])) * inward).sum(axis=-1)
        bending = (self.surface.outward_rate(p, velocity) * velocity).sum(axis=-1)
        return self.surface.distance(p), A, bend + bending, inward

    def require_outside(self, q: JointVector) -> None:
        """Refuse a start in the surface, and a batch of them.

        Args:
            q: (n,) coordinates.

        Raises:
            InputError: the sentence says how deep.
        """
        if q.ndim != 1:
            raise InputError("simulation.rigid_batch", shape=q.shape[:-1])
        depth = -float(self.surface.distance(self.robot.forward_kinematics(q)[:3, 3]))
        if depth > STARTS_INSIDE:
            raise InputError("simulation.rigid_start", depth=depth)


class RigidStepper(Stepper):
    """Steps of a plant that meets a rigid surface.

    Attributes:
        touching: whether the tip is held on the surface.
        events: what happened so far.

    Raises:
        InputError: an integrator that bounces within a step would upset.
    """

    def __init__(self, plant: RigidPlant, name: str, step: float) -> None:
        super().__init__(plant, name, step)
        if name not in METHODS:
            raise InputError("input.choice", name="integrator", value=name, known=", ".join(METHODS))
        self._rigid = plant
        self.touching, self._released, self.events = False, False, ContactEvents()
        self._free: Step = self._moving(False)
        self._bound: Step = self._moving(True)

    def begin(self, q: JointVector, qd: JointVector) -> None:
        """Look whether the tip rests on the surface before the first step.

        Args:
            q, qd: (n,) state.
        """
        self.touching = self._rests(*self._normal((q, qd)))

    def move(self) -> Step:
        """The step as a function of (t, state, h)."""
        return self._step

    def forces(
        self, q: JointVector, qd: JointVector, effort: JointVector, push: Vector6 | None, held: Floats
    ) -> tuple[JointVector, Vector6]:
        """Accelerations (k, n) and the surface's wrench (k, 6) on the tip, in the tip frame, at recorded instants.

        Args:
            q, qd: (k, n) states.
            effort: (k, n) [N m | N].
            push: (k, 6) of the world on the tip, or None.
            held: (k,) whether the tip was held then.
        """
        bound, force, _ = self._contact(q, qd, effort, push)
        pushes = np.asarray(held, dtype=bool) & (force > 0.0)
        free = self.acceleration(q, qd, effort, push)
        wrench = np.zeros((*q.shape[:-1], 6))
        wrench[..., 3:] = np.where(pushes, force, 0.0)[..., None] * self._rigid.normal_motion(q, qd)[3]
        return np.where(pushes[..., None], bound, free), wrench

    def _step(self, t: float, state: State, h: float) -> State:
        """Pieces of free and of held motion, from event to event."""
        left = h
        for _ in range(MOST_EVENTS):
            spent, state = (self._held if self.touching else self._flown)(t + h - left, state, left)
            left -= spent
            if left <= PART_OF_STEP * h:
                return state
        raise InputError("simulation.rigid_endless", count=MOST_EVENTS, time=t)

    def _flown(self, t: float, state: State, h: float) -> tuple[float, State]:
        """Free motion up to the first impact, or to the end: how long, and the state there.

        1. A tip that rests on the surface and is pressed onto it is held; one that is in it and sinks hits it.
        2. A start on the surface is no zero of the distance: where the tip leaves it, what is looked at is
           (d - d0) / s; where it hardly moves, a depth of `TOUCHING` is rounding.
        3. A zero shows by a negative distance at the end, or at the bending point of a motion that dips in between.
        """
        gap, rate = self._normal(state)
        fresh, self._released = self._released, False
        if not fresh and self._rests(gap, rate) and self._pressed(state) > QUIET:  # 1
            self.touching = True
            self.events.rest(t)
            return 0.0, state
        if gap <= 0.0 and rate < -RESTING:
            return 0.0, self._struck(t, state)
        leaves = gap <= TOUCHING and rate > RESTING  # 2
        floor = gap if leaves else gap - TOUCHING if gap <= TOUCHING and rate >= -RESTING else 0.0

        def height(share: float) -> float:
            if leaves:
                return rate * h if share == 0.0 else (self._at(t, state, share * h)[0] - floor) / share
            return self._at(t, state, share * h)[0] - floor

        end = self._free(t, state, h)
        after, speed = self._normal(end)
        last = 1.0
        if not (after < floor and (speed < 0.0 or after < floor - TOUCHING)):  # 3
            if not rate < 0.0 < speed:
                return h, end
            last = bracketed_root(lambda share: self._at(t, state, share * h)[1], 0.0, 1.0)
            if height(last) >= 0.0:
                return h, end
        share = bracketed_root(height, 0.0, last)
        return share * h, self._struck(t + share * h, self._free(t, state, share * h))

    def _held(self, t: float, state: State, h: float) -> tuple[float, State]:
        """Motion on the surface up to where it would have to pull, or to the end: how long, and the state there."""

        def pressed(share: float) -> float:
            return self._pressed(self._bound(t, state, share * h)) + QUIET

        spent = 0.0
        if self._pressed(state) >= -QUIET:
            end = self._bound(t, state, h)
            if self._pressed(end) >= -QUIET:
                return h, end
            spent = h * bracketed_root(pressed, 0.0, 1.0)
            state = self._bound(t, state, spent)
        self.touching, self._released = False, True
        self.events.release(t + spent)
        return spent, state

    def _struck(self, t: float, state: State) -> State:
        """The state after an impact, in which contact may begin to last."""
        q, qd = state
        robot, e = self._rigid.robot, float(self._rigid.surface.restitution)
        _, A, _, _ = self._rigid.normal_motion(q, qd)
        w = np.linalg.solve(robot.mass_matrix(q), A)
        mass, speed = 1.0 / float(A @ w), -float(A @ qd)
        after = qd + (1.0 + e) * mass * speed * w
        before = float(robot.kinetic_energy(q, qd))
        self.events.impact(t, speed, (1.0 + e) * mass * speed, before - float(robot.kinetic_energy(q, after)))
        pressed = self._pressed((q, after))
        if pressed <= QUIET:
            return q, after
        flight = 2.0 * e * speed / pressed
        if flight >= BRIEF_FLIGHT * self.step:
            return q, after
        self.touching = True
        stays = after - e * mass * speed * w
        lost = float(robot.kinetic_energy(q, after)) - float(robot.kinetic_energy(q, stays))
        if 0.0 < e < 1.0:
            self.events.closure(t, flight, t + flight / (1.0 - e), lost)
        else:
            self.events.rest(t, lost)
        return q, stays

    def _moving(self, held: bool) -> Step:
        """The step of free motion, or of motion on the surface, which ends on it."""

        def accelerated(t: float, q: JointVector, qd: JointVector) -> JointVector:
            if held:
                return self._contact(q, qd, self.effort, self.push)[0]
            return self.acceleration(q, qd, self.effort, self.push)

        def damped(t: float, state: State, h: float) -> State:
            # With the mean of both rates, flights within a step last as long as they should.
            q, qd = state
            after = qd + h * accelerated(t, q, qd)
            return q + h / 2.0 * (qd + after), after

        step = damped if self.name == IMPLICIT_FRICTION else second_order(method(self.name), accelerated)
        return step if not held else lambda t, state, h: self._on_surface(step(t, state, h))

    def _on_surface(self, state: State) -> State:
        """The state put back onto the surface: the shortest way, measured by the mass matrix."""
        q, qd = state
        for _ in range(CORRECTIONS):
            gap, A, _, _ = self._rigid.normal_motion(q, qd)
            if abs(gap) <= TOUCHING / 100.0:
                break
            w = np.linalg.solve(self._rigid.robot.mass_matrix(q), A)
            q = q - w * (gap / (A @ w))
        A = self._rigid.normal_motion(q, qd)[1]
        w = np.linalg.solve(self._rigid.robot.mass_matrix(q), A)
        return q, qd - w * ((A @ qd) / (A @ w))

    def _contact(
        self, q: JointVector, qd: JointVector, effort: JointVector, push: Vector6 | None
    ) -> tuple[JointVector, Floats, Floats]:
        """Accelerations (*batch, n) of a held tip, the force (*batch,) on it, and its acceleration into the surface."""
        _, A, bend, _ = self._rigid.normal_motion(q, qd)
        M, found = self._rigid.robot.mass_matrix(q), [np.zeros(0), np.zeros(0)]

        def bound(inertia: Floats, free: JointVector) -> JointVector:
            w = np.linalg.solve(inertia, A[..., None])[..., 0]
            into = -((A * free).sum(axis=-1) + bend)
            force = into / (A * w).sum(axis=-1)
            found[:] = force, into
            return free + w * force[..., None]

        def solved(added: Floats | None, load: JointVector) -> JointVector:
            inertia = M if added is None else M + added
            return bound(inertia, np.asarray(np.linalg.solve(inertia, load[..., None])[..., 0], dtype=np.float64))

        if self.name != IMPLICIT_FRICTION:
            acceleration = bound(M, self._rigid.acceleration(q, qd, effort, push))
        else:
            acceleration = by_secants(self._rigid, qd, self._load(q, qd, effort, push), self.step, solved)
        return acceleration, found[0], found[1]

    def _load(self, q: JointVector, qd: JointVector, effort: JointVector, push: Vector6 | None) -> JointVector:
        """Efforts (*batch, n) that accelerate the joints, without friction and without the surface."""
        robot, push = self._rigid.robot, self._rigid.tip_push(q, qd, push)
        still = np.zeros(robot.n)
        given = (q, qd, still) if push is None else (q, qd, still, -push)
        return effort - robot.inverse_dynamics(*given)

    def _pressed(self, state: State) -> float:
        """Acceleration of the tip into the surface, were it free [m/s^2]: above zero it is pressed onto it."""
        return float(self._contact(state[0], state[1], self.effort, self.push)[2])

    def _normal(self, state: State) -> tuple[float, float]:
        """Distance of the tip from the surface, and its rate [m, m/s]."""
        gap, A, _, _ = self._rigid.normal_motion(*state)
        return float(gap), float(A @ state[1])

    def _at(self, t: float, state: State, s: float) -> tuple[float, float]:
        """The same after free motion of s seconds."""
        return self._normal(self._free(t, state, s))

    @staticmethod
    def _rests(gap: float, rate: float) -> bool:
        return gap <= TOUCHING and abs(rate) <= RESTING
