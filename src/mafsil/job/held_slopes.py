"""How an arm that rigid surfaces hold, and its law, answer small errors: slopes along what the surfaces leave free."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats
from mafsil.control import Law
from mafsil.control.contact.tip_sensor import measured_by
from mafsil.job.stretch import Driven
from mafsil.simulation import RigidPlant
from mafsil.simulation.surface_forces import Mode, SurfaceForces
from mafsil.simulation.tolerances import PARALLEL, STILL
from mafsil.solvers.integrate import State
from mafsil.trajectory import Motion

METHOD = "rk4"
"""An integrator without friction of its own."""


class HeldArm:
    """An arm on rigid surfaces near a place of its plan.

    Its states there are q(y), qd(y) with y = (x, w), 2 r numbers: x along the r directions Z that the surfaces leave
    free, put back onto the surfaces, and w its rate. With the left inverse Z+ that is blind to the surfaces' forces,
    x'' = Z+ qdd exactly.

    Where the tip moves, what is tangent to the surfaces changes, and which errors of two ticks are called equal is a
    choice: here those of equal Z+ of this place. Some of the joints as coordinates have another growth at finite speed.

    Args:
        driven: a stretch on a `RigidPlant`.
        law: that acts there.
        t: in the stretch [s].
        reference: of the plan at that time.
        active: surfaces that the plan is on.
    """

    def __init__(self, driven: Driven, law: Law, t: float, reference: Motion, active: tuple[int, ...]) -> None:
        true = driven.scenario.true_plant
        assert isinstance(true, RigidPlant)
        self.plant, self.law, self.t, self.reference = true, law, t, reference
        smooth = RigidPlant(true.robot, False, true.environment, surface=true.surfaces)
        self.forces = SurfaceForces(smooth, METHOD, driven.scenario.step)
        self.mode, self.base = self._held(active)
        q, qd = self.base
        tip = self.forces.tip(q, qd)
        self.place = tip.p
        directions = np.eye(3) if self.mode.stuck else tip.normals[list(active)]
        _, sizes, rows = np.linalg.svd(directions @ tip.J)
        self.Z = np.asarray(rows[int((sizes > PARALLEL * sizes[0]).sum()) :].T, dtype=np.float64)
        weighted = self.Z.T @ true.robot.mass_matrix(q)
        self.inverse = np.asarray(np.linalg.solve(weighted @ self.Z, weighted), dtype=np.float64)

    def slopes(self, aside: float) -> tuple[Floats, Floats, Floats]:
        """A (2 r, 2 r) and B (2 r, n) of y' = A y + B tau, and K (n, 2 r) of tau = K y.

        1. Efforts of the law at the place, with what its sensor then reads.
        2. Slopes by the state, at those efforts, and of the law, whose sensor reads the force at each state.
        3. Slopes by the efforts; viscous friction of the joints acts as they do.

        Args:
            aside: size of the differences.
        """
        n, r = self.plant.robot.n, len(self.Z.T)
        tau = self._efforts(self.base, self._efforts(self.base, np.zeros(n)))  # 1
        A, K = np.zeros((2 * r, 2 * r)), np.zeros((n, 2 * r))
        A[:r, r:] = np.eye(r)
        for k, y in enumerate(aside * np.eye(2 * r)):  # 2
            ahead, behind = self._state(y), self._state(-y)
            A[r:, k] = self.inverse @ (self._acceleration(ahead, tau) - self._acceleration(behind, tau)) / (2.0 * aside)
            K[:, k] = (self._efforts(ahead, tau) - self._efforts(behind, tau)) / (2.0 * aside)
        size = max(1.0, float(np.abs(tau).max()))  # 3
        pushed = [
            self._acceleration(self.base, tau + x) - self._acceleration(self.base, tau - x) for x in size * np.eye(n)
        ]
        answer = self.inverse @ np.stack(pushed, axis=1) / (2.0 * size)
        if self.plant.has_friction:
            friction = self.plant.friction_law
            A[r:, r:] -= answer @ friction.gain.T @ (friction.viscous[:, None] * friction.gain) @ self.Z
        return A, np.concatenate([np.zeros((r, n)), answer]), K

    def _held(self, active: tuple[int, ...]) -> tuple[Mode, State]:
        """How the tip is held, and the state of the plan put onto the surfaces."""
        state = np.asarray(self.reference.u), np.asarray(self.reference.v)
        state = self.forces.put_back(state, Mode(active, False, np.zeros(3)), np.zeros(3))
        tip = self.forces.tip(*state)
        rough, speed = bool(self.forces.friction[list(active)].any()), float(np.linalg.norm(tip.v))
        if not rough:
            return Mode(active, False, np.zeros(3)), state
        if speed <= STILL:
            return Mode(active, True, np.zeros(3)), state
        return Mode(active, False, tip.v / speed), state

    def _state(self, y: Floats) -> State:
        (q, qd), r = self.base, self.Z.shape[1]
        return self.forces.put_back((q + self.Z @ y[:r], qd + self.Z @ y[r:]), self.mode, self.place)

    def _acceleration(self, state: State, tau: Floats) -> Floats:
        return self.forces.in_mode(self.mode, state, tau, None).acceleration

    def _efforts(self, state: State, tau: Floats) -> Floats:
        """(n,) of the law, whose sensor reads the force of contact under some efforts."""
        q, qd = state
        force = self.forces.in_mode(self.mode, state, tau, None).force
        local = self.forces.tip(q, qd).R.T @ force
        with measured_by(lambda: np.concatenate([np.zeros(3), local])):
            return np.asarray(self.law(self.t, q, qd, self.reference))
