"""Steps of an arm whose tip meets rigid surfaces: contact made, broken, stuck and slipped by events within the step.

A step is made of pieces. In each the same surfaces press, and the tip sticks to them or slides along them; a piece ends
where that changes, located to rounding.

1. Away from a surface: the first zero of its signed distance is an impact, of all surfaces that are met at once
   (`rigid_impacts`).
2. If a surface would be met again within `BRIEF_FLIGHT` of a step, 2 v / |a| later with the speed v away from it and
   the acceleration a towards it, contact lasts from here on: the rest of the bounces would take 1 / (1 - e) times as
   long (geometric series, Zeno), and never end one by one.
3. On surfaces: their forces keep the distances zero, and the tip at its place where it sticks (`point_contact`). A
   piece ends where a surface would have to pull, where friction cannot hold the tip any more, or where sliding ends.
4. Where the direction of sliding turns fast, as just before the tip stops, pieces get short with the speed. A tip that
   slides on, but slower than friction could stop it within a piece, is stiff against its direction: there friction
   keeps the direction in which the tip moves at the end of the piece.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

import numpy as np

from mafsil.arrays import JointVector, Vector3, Vector6
from mafsil.errors import InputError
from mafsil.simulation.findings import ContactEvents
from mafsil.simulation.point_contact import NoContactForce
from mafsil.simulation.rigid_impacts import Impacts
from mafsil.simulation.rigid_plant import METHODS, RigidPlant, TipState
from mafsil.simulation.stepping import IMPLICIT_FRICTION, Stepper
from mafsil.simulation.surface_forces import Mode, SurfaceForces, resting
from mafsil.simulation.tolerances import PART_OF_STEP, QUIET, RESTING, STILL, TOUCHING
from mafsil.solvers import method, second_order
from mafsil.solvers.integrate import State, Step
from mafsil.solvers.solution import bracketed_root

MOST_EVENTS = 20_000
"""Within one step: flights of at least a thousandth of it make a thousand impacts."""
TURN = 0.03
"""Sine of the angle by which the direction of sliding may turn within a piece."""


class _End(NamedTuple):
    """What ends a piece: after which share of it, a surface that is met, whether the tip stops."""

    share: float
    hit: int = -1
    stops: bool = False


class RigidStepper(Stepper):
    """Steps of a plant that meets rigid surfaces.

    Attributes:
        touching: of the surfaces on which the tip is held.
        events: what happened so far.

    Raises:
        InputError: an integrator that bounces within a step would upset.
    """

    def __init__(self, plant: RigidPlant, name: str, step: float) -> None:
        super().__init__(plant, name, step)
        if name not in METHODS:
            raise InputError("input.choice", name="integrator", value=name, known=", ".join(METHODS))
        self._surfaces = SurfaceForces(plant, name, step)
        self.touching: tuple[int, ...] = ()
        self._stuck = False
        self.events = ContactEvents()
        self._impacts = Impacts(self._surfaces, self.events, self.acceleration)
        self._free: Step = self._stepping(lambda q, qd: self.acceleration(q, qd, self.effort, self.push))

    def begin(self, q: JointVector, qd: JointVector) -> None:
        """Look which surfaces the tip rests on before the first step.

        Args:
            q, qd: (n,) state.
        """
        self.touching = resting(self._surfaces.tip(q, qd))

    def move(self) -> Step:
        """The step as a function of (t, state, h)."""
        return self._step

    def forces(
        self,
        q: JointVector,
        qd: JointVector,
        effort: JointVector,
        push: Vector6 | None,
        held: Sequence[tuple[int, ...]],
    ) -> tuple[JointVector, Vector6]:
        """Accelerations (k, n) and the surfaces' wrench (k, 6) on the tip, in the tip frame, at recorded instants.

        Args:
            q, qd: (k, n) states.
            effort: (k, n) [N m | N].
            push: (k, 6) of the world on the tip, or None.
            held: of each instant the surfaces on which the tip was held; NaN where these have no force.
        """
        acceleration = np.array(self.acceleration(q, qd, effort, push))
        wrench = np.zeros((len(q), 6))
        for k, surfaces in enumerate(held):
            if surfaces:
                try:
                    acceleration[k], wrench[k] = self.force(
                        q[k], qd[k], effort[k], None if push is None else push[k], surfaces
                    )
                except NoContactForce:
                    acceleration[k], wrench[k] = np.nan, np.nan
        return acceleration, wrench

    def force(
        self, q: JointVector, qd: JointVector, effort: JointVector, push: Vector6 | None, held: tuple[int, ...]
    ) -> tuple[JointVector, Vector6]:
        """Acceleration (n,) and the surfaces' wrench (6,) on the tip, in the tip frame, at one state.

        Args:
            q, qd: (n,) state.
            effort: (n,) [N m | N].
            push: (6,) of the world on the tip, or None.
            held: the surfaces on which the tip is held.

        Raises:
            NoContactForce: there is no force that fits, or several.
        """
        tip = self._surfaces.tip(q, qd)
        found = self._surfaces.chosen(tip, (q, qd), effort, push, held, held)
        return found.acceleration, np.concatenate([np.zeros(3), tip.R.T @ found.force])

    def _step(self, t: float, state: State, h: float) -> State:
        """Pieces from event to event."""
        left = h
        for _ in range(MOST_EVENTS):
            spent, state = self._piece(t + h - left, state, left)
            left -= spent
            if left <= PART_OF_STEP * h:
                return state
        raise InputError("simulation.rigid_endless", count=MOST_EVENTS, time=t)

    def _piece(self, t: float, state: State, h: float) -> tuple[float, State]:
        """Motion in which nothing changes: how long, and the state at its end.

        1. A tip on a surface that moves into it: an impact now, and no motion.
        2. The motion of the present mode, to the end of what is left of the step.
        3. What ends it before: a surface that is met, a force that is not there any more, sliding that turns or ends.
        """
        tip = self._surfaces.tip(*state)
        if bool(((tip.gaps <= 0.0) & (tip.rates < -RESTING)).any()):
            return 0.0, self._struck(t, state, -1)  # 1
        mode, h = self._mode(t, tip, state, h)
        motion = self._held(mode, tip) if mode.active else self._free
        end = motion(t, state, h)  # 2
        after = self._surfaces.tip(*end)

        def at(share: float) -> TipState:
            return self._surfaces.tip(*motion(t, state, share * h))

        ends = [_End(self._meeting(j, tip, after, at, h), hit=j) for j in range(len(tip.gaps)) if j not in mode.active]
        if mode.active:
            ends.append(_End(self._loss(mode, motion, t, state, h, end)))
        if mode.slip.any():
            ends.append(_End(*self._end_of_sliding(mode, tip, after, at)))
        first = min((one for one in ends if one.share < 1.0), key=lambda one: one.share, default=None)  # 3
        if first is None:
            return h, end
        state = motion(t, state, first.share * h)
        if first.hit >= 0:
            return first.share * h, self._struck(t + first.share * h, state, first.hit)
        return first.share * h, self._surfaces.rest_state(state) if first.stops else state

    def _mode(self, t: float, tip: TipState, state: State, h: float) -> tuple[Mode, float]:
        """How the tip goes on, with the events that this is, and for how long at most."""
        near = resting(tip)
        mode = Mode((), False, np.zeros(3))
        if near:
            held = tuple(j for j in self.touching if j in near)
            found = self._surfaces.chosen(tip, state, self.effort, self.push, near, held)
            mode, h = self._surfaces.choose_mode(near, found, tip, h)
        for j in mode.active:
            if j not in self.touching:
                self.events.rest(t, surface=j)
        for j in self.touching:
            if j not in mode.active:
                self.events.release(t, surface=j)
        if mode.stuck and not self._stuck:
            self.events.stick(t, surface=mode.active[0])
        elif self._stuck and mode.active and not mode.stuck:
            self.events.slip(t, surface=mode.active[0])
        self.touching, self._stuck = mode.active, mode.stuck
        return mode, h

    def _meeting(self, j: int, tip: TipState, after: TipState, at: Callable[[float], TipState], h: float) -> float:
        """The share of a piece after which a surface is hit, 1 if it is not.

        1. A start on the surface is no zero of the distance: where the tip leaves it, what is looked at is
           (d - d0) / s; where it hardly moves, a depth of `TOUCHING` is rounding.
        2. A zero shows by a negative distance at the end, or at the bending point of a motion that dips in between.
        """
        gap, rate = float(tip.gaps[j]), float(tip.rates[j])
        leaves = gap <= TOUCHING and rate > RESTING  # 1
        floor = gap if leaves else gap - TOUCHING if gap <= TOUCHING and rate >= -RESTING else 0.0

        def height(share: float) -> float:
            if leaves:
                return rate * h if share == 0.0 else (float(at(share).gaps[j]) - floor) / share
            return float(at(share).gaps[j]) - floor

        end, speed = float(after.gaps[j]), float(after.rates[j])
        last = 1.0
        if not (end < floor and (speed < 0.0 or end < floor - TOUCHING)):  # 2
            if not rate < 0.0 < speed:
                return 1.0
            last = bracketed_root(lambda share: float(at(share).rates[j]), 0.0, 1.0)
            if height(last) >= 0.0:
                return 1.0
        return bracketed_root(height, 0.0, last)

    def _loss(self, mode: Mode, motion: Step, t: float, state: State, h: float, end: State) -> float:
        """The share of a piece after which a surface would have to pull, or friction cannot hold the tip; 1 if not."""

        def worst(there: State) -> float:
            touch = self._surfaces.in_mode(mode, there, self.effort, self.push).touch
            return touch.slack if mode.stuck else float(touch.pressed.min()) + QUIET

        if worst(end) >= 0.0:
            return 1.0
        return bracketed_root(lambda share: worst(motion(t, state, share * h)), 0.0, 1.0)

    @staticmethod
    def _end_of_sliding(
        mode: Mode, tip: TipState, after: TipState, at: Callable[[float], TipState]
    ) -> tuple[float, int, bool]:
        """The share of a piece up to which the direction of sliding hardly turns; no surface; whether the tip stops."""
        d = mode.slip
        began, ended = float(tip.v @ d), float(after.v @ d)

        def aside(v: Vector3) -> float:
            return float(np.linalg.norm(v - (v @ d) * d))

        if ended > 0.0:
            turns = not mode.steady and aside(after.v) > TURN * float(np.linalg.norm(after.v))
            return (0.5 if turns else 1.0), -1, False
        half = 0.5 * began / (began - ended) if began > STILL else 0.5
        if began > STILL and aside(at(half).v) > STILL:
            return half, -1, False

        def forward(share: float) -> float:
            return 1.0 if share == 0.0 else float(at(share).v @ d) / share

        return bracketed_root(forward, 0.0, 1.0), -1, True

    def _struck(self, t: float, state: State, hit: int) -> State:
        """The state after the impacts of one instant."""
        state, self.touching = self._impacts.struck(t, state, self.touching, self.effort, self.push, hit)
        return state

    def _held(self, mode: Mode, tip: TipState) -> Step:
        """The step of motion on surfaces, which ends on them."""
        surfaces = self._surfaces
        step = self._stepping(lambda q, qd: surfaces.in_mode(mode, (q, qd), self.effort, self.push).acceleration)
        return lambda t, state, h: surfaces.put_back(step(t, state, h), mode, tip.p)

    def _stepping(self, accelerated: Callable[[JointVector, JointVector], JointVector]) -> Step:
        """The integrator's step of a motion."""

        def damped(t: float, state: State, h: float) -> State:
            # With the mean of both rates, flights within a step last as long as they should.
            q, qd = state
            after = qd + h * accelerated(q, qd)
            return q + h / 2.0 * (qd + after), after

        if self.name == IMPLICIT_FRICTION:
            return damped
        return second_order(method(self.name), lambda t, q, qd: accelerated(q, qd))
