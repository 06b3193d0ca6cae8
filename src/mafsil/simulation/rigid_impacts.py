"""Impacts on rigid surfaces: on all that the tip closes with at once, and contact that lasts afterwards.

1. Surfaces that the tip closes with, and those that it rests on, take part together: where only one of them pushes, its
   impact is followed through its impulse (`frictional_impact`), otherwise it is Moreau's (`simultaneous_impact`).
2. What it then closes with, because it had been leaving it or by friction, is the next impact, at the same instant.
3. If these do not end, the rest of them is one impact without restitution.
4. Where the tip would meet a surface again at once, contact lasts.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from mafsil.arrays import Floats, JointVector, Vector6
from mafsil.simulation.contact_events import ContactEvents
from mafsil.simulation.frictional_impact import after_impact
from mafsil.simulation.point_contact import PointContact
from mafsil.simulation.rigid_plant import TipState
from mafsil.simulation.simultaneous_impact import Struck, after_impacts
from mafsil.simulation.surface_forces import SurfaceForces, resting, without
from mafsil.simulation.tolerances import QUIET, RESTING, TOUCHING
from mafsil.solvers.integrate import State

BRIEF_FLIGHT = 1e-3
"""Part of a step below which a flight between two impacts is not followed any more."""
MOST_STRUCK = 500
"""Impacts at one instant, before what is left is taken as one without restitution."""

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
            if float(rates.min()) >= -RESTING:
                break
            closing = [j for j, rate in zip(near, rates.tolist(), strict=True) if rate <= RESTING]
            qd, pushed = self._hit(t, tip, w, (q, qd), closing)
            struck.update(pushed)
        else:
            qd, _ = self._hit(t, tip, w, (q, qd), near, given_back=0.0)
        rates = tip.normals @ (tip.J @ qd)
        stays = {j for j in touching if abs(rates[j]) <= RESTING}
        qd, brief = self._closed(t, w, (q, qd), sorted(struck), effort, push)
        return (q, qd), tuple(sorted({*stays, *brief}))

    def _hit(
        self, t: float, tip: TipState, w: Floats, state: State, members: list[int], given_back: float = 1.0
    ) -> tuple[JointVector, list[int]]:
        """Rates (n,) after one impact on some surfaces, and those of them that pushed.

        Args:
            t: when [s].
            tip, w: where the tip is, and how the rates answer to its impulses.
            state: (q, qd) before.
            members: the surfaces that take part.
            given_back: share of their restitution.
        """
        qd = state[1]
        surfaces = self.forces.plant.surfaces
        contact = PointContact.of(tip.J @ w, tip.normals[members], self.forces.friction[members])
        v = contact.U.T @ (tip.J @ qd)
        e = given_back * np.array([surfaces[j].restitution for j in members])
        struck = _impact(contact, v, e)
        pushing = np.flatnonzero(struck.normal > 0.0).tolist()
        for i in pushing:
            # The energy that an impulse takes is its product with the mean velocity.
            impulse = struck.normal[i] * contact.normals[i] + struck.across[i]
            self.events.impact(
                t, -float(contact.normals[i] @ v * contact.reach[i]), float(struck.normal[i] / contact.reach[i]),
                -float(impulse @ (v + struck.velocity)) / 2.0,
                across=float(np.linalg.norm(struck.across[i])), surface=members[i],
            )  # fmt: skip
        total = struck.normal @ contact.normals + struck.across.sum(axis=0)
        return qd + w @ (contact.U @ total), [members[i] for i in pushing]

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


def _impact(contact: PointContact, v: Floats, restitution: Floats) -> Struck:
    """What surfaces do to a point that closes with them.

    Args:
        contact: of the point with them.
        v: (r,) its velocity [m/s].
        restitution: (k,) of each.
    """
    G, N, friction = contact.G, contact.normals, contact.friction
    struck = after_impacts(G, N, friction, v, restitution)
    pushing = np.flatnonzero(struck.normal > 0.0)
    if len(pushing) != 1 or friction[pushing[0]] == 0.0:
        return struck
    i = int(pushing[0])
    after = after_impact(G, N[i], float(friction[i]), v, float(restitution[i]))
    impulse = np.linalg.solve(G, after - v)
    normal, across = np.zeros_like(struck.normal), np.zeros_like(struck.across)
    normal[i] = N[i] @ impulse
    across[i] = impulse - normal[i] * N[i]
    return Struck(after, normal, across)
