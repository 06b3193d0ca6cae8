"""Impacts on rigid surfaces: on several one after the other, and contact that lasts afterwards."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mafsil.arrays import Floats, JointVector, Vector6
from mafsil.simulation.contact_events import ContactEvents
from mafsil.simulation.frictional_impact import after_impact
from mafsil.simulation.point_contact import PointContact
from mafsil.simulation.rigid_plant import TipState
from mafsil.simulation.surface_forces import SurfaceForces, resting, without
from mafsil.simulation.tolerances import QUIET, RESTING, TOUCHING
from mafsil.solvers.integrate import State

BRIEF_FLIGHT = 1e-3
"""Part of a step below which a flight between two impacts is not followed any more."""
MOST_STRUCK = 500
"""Impacts at one instant, on surfaces that are met at once, before what is left is taken as one without restitution."""

Acceleration = Callable[[JointVector, JointVector, JointVector, "Vector6 | None"], JointVector]
"""(q, qd, effort, push) -> qdd of the arm without surfaces."""


class Impacts:
    """Impacts of one run.

    Attributes:
        forces: of the surfaces.
        events: where they are noted.
        free: acceleration without the surfaces.
    """

    def __init__(self, forces: SurfaceForces, events: ContactEvents, free: Acceleration) -> None:
        self.forces, self.events, self.free = forces, events, free

    def struck(
        self,
        t: float,
        state: State,
        touching: tuple[int, ...],
        effort: JointVector,
        push: Vector6 | None,
        hit: int = -1,
    ) -> tuple[State, tuple[int, ...]]:
        """The state after all impacts of one instant, and the surfaces that hold the tip then.

        Args:
            t: when [s].
            state: (q, qd) before.
            touching: surfaces that held the tip.
            effort, push: that act.
            hit: a surface that is met, however near it is; -1 for none.
        """
        q, qd = state
        tip = self.forces.tip(q, qd)
        w = self.forces.answer(q, tip)
        near = [j for j in range(len(tip.gaps)) if j == hit or tip.gaps[j] <= TOUCHING]
        struck: set[int] = set()
        for _ in range(MOST_STRUCK):
            rates = tip.normals[near] @ (tip.J @ qd)
            first = int(rates.argmin())
            if rates[first] >= -RESTING:
                break
            qd = self._hit(t, tip, w, (q, qd), near[first])
            struck.add(near[first])
        else:
            qd = self._all_stopped(t, tip, w, (q, qd), near)
        rates = tip.normals @ (tip.J @ qd)
        stays = {j for j in touching if abs(rates[j]) <= RESTING}
        qd, brief = self._closed(t, w, (q, qd), sorted(struck), effort, push)
        return (q, qd), tuple(sorted({*stays, *brief}))

    def _hit(self, t: float, tip: TipState, w: Floats, state: State, j: int) -> JointVector:
        """Rates (n,) after the impact on one surface."""
        q, qd = state
        robot, one = self.forces.plant.robot, self.forces.plant.surfaces[j]
        contact = PointContact.of(tip.J @ w, tip.normals[[j]], self.forces.friction[[j]])
        n, v = contact.normals[0], contact.U.T @ (tip.J @ qd)
        after = after_impact(contact.G, n, float(contact.friction[0]), v, float(one.restitution))
        impulse = np.linalg.solve(contact.G, after - v)
        changed = qd + w @ (contact.U @ impulse)
        lost = float(robot.kinetic_energy(q, qd)) - float(robot.kinetic_energy(q, changed))
        normal = float(n @ impulse)
        across = float(np.linalg.norm(impulse - normal * n)) if one.friction else 0.0
        speed = -float(tip.normals[j] @ (tip.J @ qd))
        self.events.impact(t, speed, normal / float(contact.reach[0]), lost, across=across, surface=j)
        return changed

    def _all_stopped(self, t: float, tip: TipState, w: Floats, state: State, near: list[int]) -> JointVector:
        """Rates (n,) after one impact on several surfaces without friction and restitution: the least change."""
        q, qd = state
        robot = self.forces.plant.robot
        contact = PointContact.of(tip.J @ w, tip.normals[near], np.zeros(len(near)))
        touch = contact.solved(contact.U.T @ (tip.J @ qd), np.zeros(len(near)), None)
        changed = qd + w @ (contact.U @ touch.force)
        lost = float(robot.kinetic_energy(q, qd)) - float(robot.kinetic_energy(q, changed))
        self.events.impact(t, 0.0, float(np.linalg.norm(touch.force)), lost, surface=near[0])
        return changed

    def _closed(
        self,
        t: float,
        w: Floats,
        state: State,
        struck: list[int],
        effort: JointVector,
        push: Vector6 | None,
    ) -> tuple[JointVector, list[int]]:
        """Rates (n,) after impacts: without the speed away from surfaces that would be met again at once, and these."""
        q, qd = state
        tip, robot = self.forces.tip(q, qd), self.forces.plant.robot
        bouncing = [j for j in struck if tip.rates[j] > RESTING]
        if not bouncing:
            return qd, []
        near = resting(tip)
        if near:
            acceleration = self.forces.chosen(tip, state, effort, push, near, ()).acceleration
        else:
            acceleration = self.free(q, qd, effort, push)
        into = -(tip.normals @ (tip.J @ acceleration + tip.bend) + tip.bends)
        flights = {j: 2.0 * float(tip.rates[j] / into[j]) for j in bouncing if into[j] > QUIET}
        brief = [j for j, flight in flights.items() if flight < BRIEF_FLIGHT * self.forces.step]
        for j in brief:
            stays = without(tip, w, qd, tip.normals[[*near, j]])
            lost = float(robot.kinetic_energy(q, qd)) - float(robot.kinetic_energy(q, stays))
            e, qd, near = float(self.forces.plant.surfaces[j].restitution), stays, (*near, j)
            if 0.0 < e < 1.0:
                self.events.closure(t, flights[j], t + flights[j] / (1.0 - e), lost, surface=j)
            else:
                self.events.rest(t, lost, surface=j)
        return qd, brief
