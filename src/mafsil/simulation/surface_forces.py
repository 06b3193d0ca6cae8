"""Forces of rigid surfaces on the tip of an arm at a state, and how a piece of its motion goes on under them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, JointVector, Vector3, Vector6
from mafsil.simulation.point_contact import NoContactForce, PointContact, Touch
from mafsil.simulation.rigid_plant import RigidPlant, TipState
from mafsil.simulation.stepping import IMPLICIT_FRICTION, by_secants
from mafsil.simulation.tolerances import PARALLEL, RESTING, STILL, TOUCHING
from mafsil.solvers.integrate import State

CORRECTIONS = 3
"""Newton steps that put a held tip back onto its surfaces."""
FOLLOWED = 0.5
"""Part of a speed of sliding that friction may change within a piece in which its direction is followed."""
STIFF_SLIDING = 2.0
"""The same beyond which explicit methods do not bear how fast the direction settles."""
STRAIGHT = 1e-9
"""Part of an acceleration along the direction of sliding below which one across it does not turn it."""
TURNED = 0.5
"""Cosine beyond which a velocity within a piece is not one of its sliding any more."""


Decision = Callable[[PointContact, Floats, Floats], Touch]
"""(contact, drift, bends) -> what the surfaces do."""


@dataclass(frozen=True, eq=False, slots=True)
class Mode:
    """How the tip moves during a piece.

    Attributes:
        active: of the surfaces that press.
        stuck: whether friction holds the tip.
        slip: (3,) direction of sliding at the beginning; zero without any, or without friction.
        steady: whether friction keeps this direction during the piece.
    """

    active: tuple[int, ...]
    stuck: bool
    slip: Vector3
    steady: bool = False


@dataclass(frozen=True, eq=False, slots=True)
class Forces:
    """Forces of surfaces on the tip, and what they follow from.

    Attributes:
        acceleration: (n,) of the joints.
        touch: what the surfaces do.
        contact: of the tip with them.
        load: drift and bends of `PointContact.load`.
    """

    acceleration: JointVector
    touch: Touch
    contact: PointContact
    load: tuple[Floats, Floats]

    @property
    def force(self) -> Vector3:
        """(3,) on the tip in {s} [N]."""
        return self.contact.U @ self.touch.force


class SurfaceForces:
    """What the surfaces of a plant do to its tip.

    Attributes:
        plant: the arm and its surfaces.
        name: of the integrator.
        step: its length [s].
        friction: (k,) coefficients of the surfaces.
    """

    def __init__(self, plant: RigidPlant, name: str, step: float) -> None:
        self.plant, self.name, self.step = plant, name, step
        self.friction: Floats = np.array([one.friction for one in plant.surfaces])
        self._seen: tuple[JointVector, JointVector, TipState] | None = None

    def tip(self, q: JointVector, qd: JointVector) -> TipState:
        """The tip at a state; the end of a piece is asked for several times.

        Args:
            q, qd: (n,) state.
        """
        seen = self._seen
        if seen is not None and seen[0] is q and seen[1] is qd:
            return seen[2]
        tip = self.plant.tip_state(q, qd)
        self._seen = q, qd, tip
        return tip

    def chosen(
        self,
        tip: TipState,
        state: State,
        effort: JointVector,
        push: Vector6 | None,
        near: tuple[int, ...],
        held: tuple[int, ...],
    ) -> Forces:
        """What the surfaces that the tip is on do: as before, on those that held it, where that still fits.

        Args:
            tip, state: the tip, and (q, qd).
            effort: (n,) [N m | N].
            push: (6,) of the world on the tip, or None.
            near: the surfaces that the tip is on.
            held: those of them that held it so far.

        Raises:
            NoContactForce: there is no force that fits, or several.
        """
        members = list(near)
        every, before = list(range(len(members))), [members.index(j) for j in held]
        rough = bool(self.friction[members].any())

        def decide(contact: PointContact, drift: Floats, bends: Floats) -> Touch:
            along = _along(contact, tip.v, every) if rough else np.zeros_like(drift)
            if before:
                stands = along is None
                known = contact.sticking(every, drift) if stands else contact.sliding(before, along, drift, bends)
                if known is not None and contact.holds(known, drift, bends):
                    return known
            return contact.solve(drift, bends, along)

        return self._dynamics(tip, state, effort, push, members, decide)

    def in_mode(self, mode: Mode, state: State, effort: JointVector, push: Vector6 | None) -> Forces:
        """Acceleration and forces where it is known what presses, sticks and slides.

        Args:
            mode: what is known.
            state: (q, qd).
            effort: (n,) [N m | N].
            push: (6,) of the world on the tip, or None.

        Raises:
            NoContactForce: friction leaves no force that fits.
        """
        tip = self.tip(*state)
        members = list(mode.active)

        def decide(contact: PointContact, drift: Floats, bends: Floats) -> Touch:
            every = range(len(members))
            if mode.stuck:
                return contact.sticking(every, drift)
            along = np.zeros_like(drift)
            if mode.slip.any():
                # Past the end of sliding the motion goes on as smoothly, so that the end can be located.
                begun = contact.U.T @ mode.slip
                moving = None if mode.steady else _along(contact, tip.v, list(every))
                ahead = moving is not None and float(moving @ begun) > TURNED
                along = moving if moving is not None and ahead else _across(contact, begun, list(every))
            touch = contact.sliding(every, along, drift, bends)
            if touch is None:
                raise NoContactForce("simulation.contact_force_none", friction=float(self.friction[members].max()))
            return touch

        return self._dynamics(tip, state, effort, push, members, decide)

    def choose_mode(self, near: tuple[int, ...], found: Forces, tip: TipState, h: float) -> tuple[Mode, float]:
        """The mode of a tip, and how long a piece of it may be for its direction of sliding.

        1. Without contact, sticking or without friction: as long as wanted.
        2. From rest friction keeps the direction in which the tip begins to slide.
        3. Surfaces that leave one direction, or friction that hardly changes the speed: as long as wanted.
        4. Slower than friction could stop it within the piece, but not stopping: it keeps the direction at the end.
        5. Where the direction turns, as long as friction takes for a part of the speed.

        Args:
            near: the surfaces that the tip is on.
            found: what they do.
            tip: where it is.
            h: how long a piece is wanted [s].
        """
        touch, contact = found.touch, found.contact
        active = tuple(near[i] for i in touch.active)
        if not active or touch.stuck or not self.friction[list(active)].any():
            return Mode(active, touch.stuck, np.zeros(3)), h  # 1
        speed = float(np.linalg.norm(tip.v))
        if speed <= STILL:
            return Mode(active, False, contact.U @ touch.slip, steady=True), h  # 2
        d = tip.v / speed
        if len(touch.force) - len(active) < 2:
            return Mode(active, False, d), h  # 3
        n = tip.normals[active[0]]
        rubbing = float(np.linalg.norm(contact.G @ (found.force - float(n @ found.force) * n)))
        if rubbing * h <= speed * FOLLOWED:
            return Mode(active, False, d), h
        change = tip.J @ found.acceleration + tip.bend
        along = float(change @ d)
        if along * h > -speed / 2.0 and rubbing * h > STIFF_SLIDING * speed:
            ways = contact.directions(touch.active[0], *found.load, before=tip.v / h)
            return Mode(active, False, max(ways, key=lambda way: float(way @ d), default=d), steady=True), h  # 4
        # 5
        aside = float(np.linalg.norm(change - along * d - float(n @ change) * n))
        return Mode(active, False, d), h if aside <= STRAIGHT * abs(along) else min(h, FOLLOWED * speed / rubbing)

    def answer(self, q: JointVector, tip: TipState) -> Floats:
        """(n, 3) rates for an impulse on the tip, M^-1 J'.

        Args:
            q: (n,) coordinates.
            tip: there.
        """
        return np.asarray(np.linalg.solve(self.plant.robot.mass_matrix(q), tip.J.T), dtype=np.float64)

    def rest_state(self, state: State) -> State:
        """The state whose tip, which hardly moves, is at rest.

        Args:
            state: (q, qd).
        """
        q, qd = state
        tip = self.tip(q, qd)
        return q, without(tip, self.answer(q, tip), qd, np.eye(3))

    def put_back(self, state: State, mode: Mode, place: Vector3) -> State:
        """The state put back onto the surfaces, or to the place where the tip sticks, with the least kinetic energy.

        Args:
            state: (q, qd).
            mode: what presses.
            place: (3,) where a tip that is stuck is.
        """
        q, qd = state
        active = list(mode.active)
        for _ in range(CORRECTIONS):
            tip = self.tip(q, qd)
            directions = np.eye(3) if mode.stuck else tip.normals[active]
            off = tip.p - place if mode.stuck else tip.gaps[active]
            if np.abs(off).max() <= TOUCHING / 100.0:
                break
            gain = self.answer(q, tip) @ directions.T
            q = q - gain @ (np.linalg.pinv(directions @ tip.J @ gain, rcond=PARALLEL) @ off)
        tip = self.tip(q, qd)
        return q, without(tip, self.answer(q, tip), qd, np.eye(3) if mode.stuck else tip.normals[active])

    def _dynamics(
        self,
        tip: TipState,
        state: State,
        effort: JointVector,
        push: Vector6 | None,
        members: list[int],
        decide: Decision,
    ) -> Forces:
        """The motion of an arm whose tip rests on some surfaces."""
        q, qd = state
        M = self.plant.robot.mass_matrix(q)
        found: list[tuple[Touch, PointContact, tuple[Floats, Floats]]] = []

        def bound(inertia: Floats, free: JointVector) -> JointVector:
            w = np.asarray(np.linalg.solve(inertia, tip.J.T), dtype=np.float64)
            contact = PointContact.of(tip.J @ w, tip.normals[members], self.friction[members])
            load = contact.load(tip.J @ free + tip.bend, tip.bends[members])
            touch = decide(contact, *load)
            found[:] = [(touch, contact, load)]
            return np.asarray(free + w @ (contact.U @ touch.force))

        def solved(added: Floats | None, load: JointVector) -> JointVector:
            inertia = M if added is None else M + added
            return bound(inertia, np.asarray(np.linalg.solve(inertia, load), dtype=np.float64))

        if self.name != IMPLICIT_FRICTION:
            acceleration = bound(M, self.plant.acceleration(q, qd, effort, push))
        else:
            acceleration = by_secants(self.plant, qd, self._load(q, qd, effort, push), self.step, solved)
        return Forces(acceleration, *found[0])

    def _load(self, q: JointVector, qd: JointVector, effort: JointVector, push: Vector6 | None) -> JointVector:
        """Efforts (n,) that accelerate the joints, without friction and without the surfaces."""
        robot, push = self.plant.robot, self.plant.tip_push(q, qd, push)
        still = np.zeros(robot.n)
        given = (q, qd, still) if push is None else (q, qd, still, -push)
        return effort - robot.inverse_dynamics(*given)


def resting(tip: TipState) -> tuple[int, ...]:
    """The surfaces that the tip is on, moving neither away nor into them.

    Args:
        tip: and its surfaces.
    """
    return tuple(int(j) for j in np.flatnonzero((tip.gaps <= TOUCHING) & (np.abs(tip.rates) <= RESTING)))


def without(tip: TipState, w: Floats, qd: JointVector, directions: Floats) -> JointVector:
    """Rates (n,) without the tip's velocity along some directions, with the least change of energy.

    Args:
        tip: where it is.
        w: (n, 3) of `SurfaceForces.answer`.
        qd: (n,) rates.
        directions: (k, 3).
    """
    A = directions @ tip.J
    gain = w @ directions.T
    if len(directions) == 1:
        row, column = A[0], gain[:, 0]
        answer = float(row @ column)
        return qd - column * (float(row @ qd) / answer) if answer > 0.0 else qd
    return np.asarray(qd - gain @ (np.linalg.pinv(A @ gain, rcond=PARALLEL) @ (A @ qd)))


def _along(contact: PointContact, velocity: Vector3, active: list[int]) -> Floats | None:
    """(r,) direction in which a point slides along surfaces; None if it is at rest."""
    v = contact.U.T @ velocity
    if float(np.linalg.norm(v)) <= STILL:
        return None
    v = _across(contact, v, active)
    return v if v.any() else None


def _across(contact: PointContact, v: Floats, active: list[int]) -> Floats:
    """(r,) unit direction of what of a velocity is along surfaces; zero if that is less than `STILL`."""
    N = contact.normals[active]
    v = v - np.linalg.pinv(N, rcond=PARALLEL) @ (N @ v) if len(active) > 1 else v - N[0] * float(N[0] @ v)
    speed = float(np.linalg.norm(v))
    return v / speed if speed > STILL else np.zeros_like(v)
