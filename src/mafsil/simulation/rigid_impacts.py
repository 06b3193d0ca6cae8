"""Impacts on rigid surfaces: on all that the tip closes with at once, and contact that lasts afterwards.

1. Surfaces that the tip closes with, and those that it rests on, take part together: where only one of them pushes, its
   impact is followed through its impulse (`frictional_impact`), otherwise it is Moreau's (`simultaneous_impact`).
2. What it then closes with, because it had been leaving it or by friction, is the next impact, at the same instant.
3. If these do not end, the rest of them is one impact without restitution.
4. Where the tip would meet a surface again at once, contact lasts.

The impact of a point on several rigid surfaces at once: Moreau's law, and friction of most dissipation.

The velocity v of the point changes by G P, P the impulse of all surfaces; surface i exerts p_i n_i and f_i across it.

1. Compression, without friction: the least p_i >= 0 after which no n_i . v is negative.
2. Friction of compression: of all |f_i| <= mu_i p_i those after which the kinetic energy is least.
3. Restitution (Moreau): p grows to what gives back e_i of each speed, n_i . v+ >= b_i = -e_i n_i . v-, and = b_i where
   p_i > 0. Where friction has changed these speeds, it grows by as much of that as gives back no more energy.
4. Friction of restitution, as in 2, bounded by what has been added to p_i.

1 and 3 are nearest points of polyhedra in the norm of the kinetic energy (-e v- with the largest e is in that of 3), 2
and 4 minima of convex functions of the velocity: each velocity exists, it is the only one, and no order of the surfaces
enters. Surfaces that the point leaves take no part. Energy never grows: without friction it changes by
sum p_i n_i . (v+ + v-) / 2 = -sum (1 - e_i) p_i |n_i . v-| / 2; 2 and 4 take some, and 3 gives back no more than it
would without friction. Afterwards the point may close with a surface that it was leaving: that is the next impact.

Reference: Moreau, Unilateral contact and dry friction in finite freedom dynamics, 1988.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from mafsil.arrays import Floats, JointVector, Vector6
from mafsil.simulation.findings import ContactEvents
from mafsil.simulation.frictional_impact import after_impact
from mafsil.simulation.point_contact import PointContact, tangents
from mafsil.simulation.rigid_plant import TipState
from mafsil.simulation.surface_forces import SurfaceForces, resting, without
from mafsil.simulation.tolerances import QUIET, RESTING, TOUCHING
from mafsil.solvers.integrate import State
from mafsil.solvers.linear_program import least_distance
from mafsil.solvers.solution import bracketed_root

SWEEPS = 2_000
"""Over the surfaces, until friction does not change any more."""
SETTLED = 1e-15
"""Share of the velocity below which a sweep has changed nothing."""
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


class Struck(NamedTuple):
    """What an impact on several surfaces does.

    Attributes:
        velocity: (r,) after it [m/s].
        normal: (k,) impulses along the normals [N s].
        across: (k, r) impulses of friction [N s].
    """

    velocity: Floats
    normal: Floats
    across: Floats


def after_impacts(G: Floats, normals: Floats, friction: Floats, velocity: Floats, restitution: Floats) -> Struck:
    """The velocity of a point after an impact on several surfaces at once, and the impulses.

    Args:
        G: (r, r) change of velocity for an impulse [1/kg].
        normals: (k, r) units, out of the surfaces.
        friction: (k,) mu.
        velocity: (r,) before, away from none of them [m/s].
        restitution: (k,) e.
    """
    C: Floats = np.linalg.cholesky(G).astype(np.float64, copy=False)
    rates = normals @ velocity
    change, held = least_distance(normals @ C, -rates)
    whole, normal = least_distance(normals @ C, -rates - restitution * np.minimum(rates, 0.0))
    returned = C @ (whole - change)
    v = velocity + C @ change
    if not friction.any():
        return Struck(v + returned, normal, np.zeros_like(normals))
    least, added = np.minimum(held, normal), np.maximum(normal - held, 0.0)
    rubbed, first = _rub(G, normals, v, friction * least)
    part = _share(C, returned, v, rubbed)
    after, second = _rub(G, normals, rubbed + part * returned, friction * part * added)
    return Struck(after, held + part * (normal - held), first + second)


def _share(C: Floats, returned: Floats, v: Floats, rubbed: Floats) -> float:
    """How much of a change of velocity, at most 1, gives no more energy to one velocity than all of it to another.

    Args:
        C: (r, r) of G = C C'.
        returned: (r,) change [m/s].
        v: (r,) to which all of it is added [m/s].
        rubbed: (r,) to which the part is added [m/s].
    """
    x, y, z = np.linalg.solve(C, np.stack([returned, v, rubbed], axis=1)).T
    square, given, slope = float(x @ x), float(x @ x / 2.0 + x @ y), float(x @ z)
    if slope + square / 2.0 <= given:
        return 1.0
    return 2.0 * given / (slope + float(np.sqrt(slope * slope + 2.0 * square * given))) if given > 0.0 else 0.0


def _rub(G: Floats, normals: Floats, v: Floats, most: Floats) -> tuple[Floats, Floats]:
    """Velocity (r,) and impulses (k, r) of friction after which the kinetic energy is least.

    Args:
        G: (r, r).
        normals: (k, r).
        v: (r,) before [m/s].
        most: (k,) largest impulses [N s].
    """
    across = np.zeros_like(normals)
    size = float(np.abs(v).max())
    planes = {int(i): tangents(normals[i]) for i in np.flatnonzero(most > 0.0)}
    for _ in range(SWEEPS if len(v) > 1 else 0):
        before = v
        for i, T in planes.items():
            without = v - G @ across[i]
            across[i] = T @ _least_energy(T.T @ G @ T, T.T @ without, float(most[i]))
            v = without + G @ across[i]
        if float(np.abs(v - before).max()) <= SETTLED * size:
            break
    return v, across


def _least_energy(A: Floats, v: Floats, most: float) -> Floats:
    """(m,) f with |f| <= most for which f' A f / 2 + f' v is least.

    Args:
        A: (m, m) positive definite.
        v: (m,).
        most: > 0.
    """
    values, axes = np.linalg.eigh(A)
    w = axes.T @ v

    def excess(shift: float) -> float:
        return float(np.linalg.norm(w / (values + shift))) - most

    if excess(0.0) <= 0.0:
        return -axes @ (w / values)
    # At |w| / most the force is short enough, whatever A is.
    top = float(np.linalg.norm(w)) / most
    shift = top * bracketed_root(lambda share: excess(share * top), 0.0, 1.0)
    f = -axes @ (w / (values + shift))
    return f * (most / float(np.linalg.norm(f)))
