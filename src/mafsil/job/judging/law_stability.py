"""Whether a law is stable along a planned motion: by how much small errors grow from tick to tick, at worst.

How an arm that rigid surfaces hold, and its law, answer small errors: slopes along what the surfaces leave free.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from msgspec.structs import replace

from mafsil.arrays import Floats
from mafsil.control import Law
from mafsil.control.analysis.linearization import exponential
from mafsil.control.contact import ContactSwitch
from mafsil.control.contact.tip_sensor import measured_by
from mafsil.control.laws import Combined
from mafsil.errors import MafsilError
from mafsil.job.driving.laws import law_of
from mafsil.job.driving.tip_laws import REACHED, Face, rigid_surfaces_of
from mafsil.job.language.description import Job, Noise
from mafsil.job.planning.stretch import Driven
from mafsil.simulation import Plant, RigidPlant
from mafsil.simulation.surface_forces import Mode, SurfaceForces
from mafsil.simulation.tolerances import PARALLEL, STILL
from mafsil.solvers.integrate import State
from mafsil.trajectory import Motion

METHOD = "rk4"
"""An integrator without friction of its own."""
PLACES = 9
"""Along a stretch, where it is looked."""
ASIDE = 1e-6
"""Of positions and rates in differences [rad | m], [rad/s | m/s]."""


class Growth(NamedTuple):
    """The largest factor by which small errors change from tick to tick, and when in its stretch [s]."""

    factor: float
    time: float


UNKNOWN = Growth(float("nan"), float("nan"))


def quiet_law(job: Job, driven: Driven) -> Law:
    """The law of a stretch without delay and without noise in its sensor of force: what has a slope.

    Args:
        job: whose controller it is.
        driven: the stretch.
    """
    scenario = driven.scenario
    simulated = replace(job.simulation, noise=Noise())
    quiet = replace(job, controller=replace(job.controller, delay=0.0), simulation=simulated)
    return law_of(quiet, scenario.robot, driven.stretch.trajectory, scenario.true_plant)


def growth_along(job: Job, driven: Driven) -> Growth:
    """The largest factor by which small errors change from one evaluation of the law to the next, along a stretch.

    At each place the arm is where it should be, moving as it should:

    1. Slopes of its acceleration by state and effort, viscous friction and what it touches included (surfaces that give
       way, holes, guides, and doors with their grip), and of the law's efforts by the state, from differences. Where
       the plan is on rigid surfaces, they hold: errors are those that they leave free (`HeldArm`).
    2. The step x(k + 1) = Phi x(k) + Gamma K x(k - d) under efforts that are constant between two ticks and come d
       ticks late, exactly; its spectral radius. What a law remembers, such as an integral, is left out.

    Args:
        job: whose controller it is.
        driven: a stretch under its law.

    Returns:
        Above one where the loop is unstable; NaN of laws that have no slope, and of closed chains.
    """
    scenario, trajectory = driven.scenario, driven.stretch.trajectory
    if scenario.true_plant.robot.mechanism.loops:
        return UNKNOWN
    law, late = quiet_law(job, driven), round(job.controller.delay / job.control_period)
    times = np.linspace(0.0, trajectory.duration, PLACES).tolist()
    try:
        return max(Growth(_radius(job, driven, _acting(law, t), t, late), t) for t in times)
    except (MafsilError, ValueError, TypeError, np.linalg.LinAlgError):
        return UNKNOWN


def _held(job: Job, driven: Driven, q: Floats) -> tuple[int, ...]:
    """The rigid surfaces that the plan is on at a configuration (n,)."""
    T = driven.scenario.robot.forward_kinematics(q)
    faces = [Face(surface, ()) for surface in rigid_surfaces_of(job)]
    return tuple(j for j, face in enumerate(faces) if face.depth(T) >= -REACHED)


def _acting(law: Law, t: float) -> Law:
    """The law that acts where the plan is at a time: of two laws that a contact parts, one."""
    if isinstance(law, ContactSwitch):
        return _acting(law.touching if law.intended(t) else law.free, t)
    return Combined(tuple(_acting(part, t) for part in law.laws)) if isinstance(law, Combined) else law


def _radius(job: Job, driven: Driven, law: Law, t: float, late: int) -> float:
    """The spectral radius of the step at one place."""
    h, reference = driven.scenario.control_period, Motion(*driven.stretch.trajectory.at(t))
    held = _held(job, driven, reference.u)
    # 1.
    if held:
        A, B, K = HeldArm(driven, law, t, reference, held).slopes(ASIDE)
    else:
        A, B, K = _free(driven, law, t, reference)
    # 2.
    size, n = B.shape
    if not size:
        return 0.0
    whole = np.zeros((size + n, size + n))
    whole[:size, :size], whole[:size, size:] = h * A, h * B
    found = exponential(whole)
    return float(np.abs(np.linalg.eigvals(_step(found[:size, :size], found[:size, size:], K, late))).max())


def _step(Phi: Floats, Gamma: Floats, K: Floats, late: int) -> Floats:
    """The closed step: the state, and before it the efforts that wait."""
    size, n = Gamma.shape
    if not late:
        return Phi + Gamma @ K
    step = np.zeros((size + late * n, size + late * n))
    step[:size, :size], step[:size, -n:] = Phi, Gamma
    step[size : size + n, :size] = K
    step[size + n :, size:-n] = np.eye((late - 1) * n)
    return step


def _free(driven: Driven, law: Law, t: float, reference: Motion) -> tuple[Floats, Floats, Floats]:
    """A (2 n, 2 n), B (2 n, n) of the true arm under the law's efforts there, and K (n, 2 n) of the law."""
    scenario = driven.scenario
    n, true = scenario.robot.n, scenario.true_plant
    plant = Plant(true.robot, friction=False, environment=true.environment)
    tau, aside = np.asarray(law(t, reference.u, reference.v, reference)), _aside(n)
    q, qd = reference.u + aside[:, :n], reference.v + aside[:, n:]
    slope = _slope(plant.acceleration(q, qd, np.broadcast_to(tau, q.shape)))
    inverse = np.linalg.inv(true.robot.mass_matrix(reference.u))
    if true.has_friction:
        friction = true.friction_law
        slope[:, n:] -= inverse @ friction.gain.T @ (friction.viscous[:, None] * friction.gain)
    A, B = np.zeros((2 * n, 2 * n)), np.zeros((2 * n, n))
    A[:n, n:], A[n:], B[n:] = np.eye(n), slope, inverse
    return A, B, _slope(np.stack([law(t, reference.u + x[:n], reference.v + x[n:], reference) for x in aside]))


def _aside(n: int) -> Floats:
    """(4 n, 2 n) small changes of the state, forwards and backwards."""
    return ASIDE * np.concatenate([np.eye(2 * n), -np.eye(2 * n)])


def _slope(values: Floats) -> Floats:
    """(n, 2 n) from values (4 n, n) at `_aside`."""
    half = len(values) // 2
    return (values[:half] - values[half:]).T / (2.0 * ASIDE)


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
