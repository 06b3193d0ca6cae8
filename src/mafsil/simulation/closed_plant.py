"""Mechanisms with loops as plants: only driven joints get efforts, and every step ends with closed loops.

1. A step of the integrator with the accelerations of the closed chain.
2. Newton's method takes the coordinates back to closed loops by the shortest step.
3. Rates lose what would open the loops, with the least kinetic energy.

One integration step of a closed chain as one kernel: accelerations, the step, and closed loops at its end.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from mafsil import kernels, parallel
from mafsil.arrays import Floats, JointVector, Vector6, as_batch
from mafsil.errors import InputError
from mafsil.kernels import Port, Signature
from mafsil.kernels.lazy import lazy
from mafsil.lazy_module import lazily
from mafsil.mechanics.friction import SMOOTHING
from mafsil.mechanics.loop_terms import Holding, Loop
from mafsil.model import Mechanism
from mafsil.model.fingerprint import fingerprint, friction_fingerprint
from mafsil.simulation.plant import Plant
from mafsil.simulation.rigid_plant import RigidPlant
from mafsil.simulation.stepping import IMPLICIT_FRICTION, MOST_EVALUATIONS, Stepper, by_secants
from mafsil.solvers import method, second_order
from mafsil.solvers.integrate import State, Step

if TYPE_CHECKING:
    import mafsil.mechanics.tree_plant as held_plant
    import mafsil.parallel.closed_compiled as closed_compiled
    import mafsil.simulation.mujoco_plant as mujoco_plant
    import mafsil.simulation.rigid_stepper as rigid_stepper
    from mafsil.kernels import Kernel
    from mafsil.parallel import ClosedChain
    from mafsil.robot import Robot
else:
    closed_compiled = lazily("mafsil.parallel.closed_compiled")
    rigid_stepper = lazily("mafsil.simulation.rigid_stepper")
    mujoco_plant = lazily("mafsil.simulation.mujoco_plant")
    held_plant = lazily("mafsil.mechanics.tree_plant")


STARTS_OPEN = 1e-6
"""Gap over the size beyond which a start is refused instead of closed."""


class LoopsLost(InputError):
    """After a step the loops could not be closed any more."""


@dataclass(frozen=True, eq=False)
class ClosedPlant(Plant):
    """A mechanism with loops; efforts of joints that are not driven do nothing.

    Attributes:
        actuated: names of the driven joints; those that the description drives if None.

    Raises:
        ModelError: the mechanism has no loops, or a joint is unknown.
    """

    actuated: tuple[str, ...] | None = None
    keeps_loops: ClassVar[bool] = True

    @lazy
    def chain(self) -> ClosedChain:
        """The dynamics with the forces of the loops."""
        return parallel.ClosedChain(self.robot, self.actuated)

    @lazy
    def _driven(self) -> Floats:
        """(n,) one for driven joints, zero for the others."""
        driven = np.zeros(self.robot.n)
        driven[self.chain.actuated] = 1.0
        return driven

    def require_closed(self, q: JointVector) -> None:
        """Refuse a start whose loops gape.

        Args:
            q: (*batch, n) coordinates.

        Raises:
            InputError: the sentence says how far, and where the nearest closed configuration is.
        """
        error = float(self.chain.error(q).max(initial=0.0))
        if error > STARTS_OPEN * self.chain.size:
            raise InputError("parallel.starts_open", error=error, why=self.chain.close_loops(q).explain())

    def closed_start(self, q: JointVector, qd: JointVector) -> State:
        """Starts (runs, n) with closed loops: the driven joints stay, the others follow.

        Args:
            q, qd: (runs, n) coordinates and rates.

        Raises:
            InputError: no closed configuration was found for a run; the sentence says which.
        """
        back = self.chain.close_loops(q, hold=self.chain.actuated, tries=1)
        if not back:
            raise InputError("simulation.varied_start", run=int(np.argmin(back.found)), why=back.explain())
        return back.q, self.chain.rates(back.q, qd, hold=self.chain.actuated)

    def acceleration(self, q: JointVector, qd: JointVector, tau: JointVector, push: Vector6 | None = None) -> Floats:
        """Joint accelerations (*batch, n) with closed loops; arguments as for `Plant.acceleration`."""
        return self.chain.forward_dynamics(q, qd, self._applied_efforts(q, qd, tau, push, friction=True)).qdd

    def mean_acceleration(
        self, q: JointVector, qd: JointVector, tau: JointVector, push: Vector6 | None, h: float
    ) -> Floats:
        """Mean acceleration (*batch, n) over a step, friction taken at its end; see `damped_acceleration`.

        Args:
            q, qd: (*batch, n) state at the beginning of the step.
            tau: (*batch, n) efforts of the motors [N m | N].
            push: (*batch, 6) of the world on the tip, or None.
            h: length of the step [s].
        """
        load = self._applied_efforts(q, qd, tau, push, friction=False)
        return by_secants(self, qd, load, h, lambda D, b: self.chain.forward_dynamics(q, qd, b, added_inertia=D).qdd)

    def loop_forces(self, q: JointVector, qd: JointVector, tau: JointVector) -> Floats:
        """(*batch, m) forces that hold the loops together, without pushes [N m, N]; as a recording has its arguments.

        Args:
            q, qd: (*batch, n) motion.
            tau: (*batch, n) efforts that acted.
        """
        return self.chain.forward_dynamics(q, qd, self._applied_efforts(q, qd, tau, None, friction=True)).force

    def _applied_efforts(
        self, q: JointVector, qd: JointVector, tau: JointVector, push: Vector6 | None, *, friction: bool
    ) -> Floats:
        """(*batch, n) efforts of motors, friction and world."""
        applied = as_batch("tau", tau, self._driven.shape) * self._driven
        if friction and self.has_friction:
            applied = applied - self.robot.friction_torque(qd)
        push = self.tip_push(q, qd, push)
        if push is not None:
            J = self.robot.jacobian_body(q)
            applied = applied + (np.swapaxes(J, -1, -2) @ push[..., None])[..., 0]
        return applied


class ClosedStepper(Stepper):
    """Steps of a closed plant."""

    def __init__(self, plant: ClosedPlant, name: str, step: float) -> None:
        super().__init__(plant, name, step)
        self._closed = plant
        self._kernels: dict[bool, Callable[..., Any] | None] = {}
        self._free = self._damped_state if name == IMPLICIT_FRICTION else second_order(method(name), self._acceleration)

    def move(self) -> Step:
        """The step as a function of (t, state, h)."""
        return self._step

    def _as_kernel(self, q: JointVector, pushed: bool) -> Callable[..., Any] | None:
        """The whole step in one call; None where no code of fixed size can do it, or it would get too long.

        Args:
            q: (*batch, n) coordinates that close the loops.
            pushed: whether something pushes the tip.
        """
        if pushed not in self._kernels:
            plant, holding = self._closed, self._closed.chain.holding(q)
            short = plant.environment is None and self.evaluations() <= MOST_EVALUATIONS
            self._kernels[pushed] = None
            if holding is not None and short:
                scheme, mechanism = self.scheme(), plant.robot.mechanism
                made = step_kernel(mechanism, holding, scheme, friction=plant.has_friction, pushed=pushed)
                self._kernels[pushed] = made.call
        return self._kernels[pushed]

    def acceleration(self, q: JointVector, qd: JointVector, effort: JointVector, push: Vector6 | None) -> JointVector:
        """qdd (*batch, n) with which a step begins; with implicit friction, its mean over the step."""
        if self.name == IMPLICIT_FRICTION:
            return self._closed.mean_acceleration(q, qd, effort, push, self.step)
        return self._closed.acceleration(q, qd, effort, push)

    def settle(self, q: JointVector, qd: JointVector) -> State:
        """The state with closed loops near one that an integrator has left.

        Args:
            q, qd: (*batch, n) coordinates and rates.

        Raises:
            LoopsLost: they cannot be closed.
        """
        back, rates = self._closed.chain.closed_state(q, qd)
        if not back:
            raise LoopsLost("simulation.loops_lost", gap=float(back.error.max(initial=0.0)))
        return back.q, rates

    def _step(self, t: float, state: State, h: float) -> State:
        """One call where its results hold; what it doubts is done part by part."""
        push = self.push
        run = self._as_kernel(state[0], push is not None)
        if run is not None:
            q, qd = state
            given = (q, qd, self.effort, h) if push is None else (q, qd, self.effort, h, push)
            here, rate, _, doubt = run(*given)
            if closed_compiled.is_certain(doubt):
                return here, rate
        return self.settle(*self._free(t, state, h))

    def _acceleration(self, t: float, q: JointVector, qd: JointVector) -> JointVector:
        return self._closed.acceleration(q, qd, self.effort, self.push)

    def _damped_state(self, t: float, state: State, h: float) -> State:
        q, qd = state
        qd = qd + h * self._closed.mean_acceleration(q, qd, self.effort, self.push, h)
        return q + h * qd, qd


def plant_of(robot: Robot) -> Plant:
    """The plant of a robot as it is: with loops if it has some."""
    return ClosedPlant(robot) if robot.mechanism.loops else Plant(robot)


def stepper_of(plant: Plant, name: str, step: float) -> Stepper:
    """What moves a plant: our integrators for trees or for loops, or MuJoCo.

    Args:
        plant: that moves.
        name: of the integrator.
        step: its length [s].

    Raises:
        InputError: MuJoCo has no such integrator.
    """
    match plant:
        case mujoco_plant.MuJoCoPlant():
            return mujoco_plant.MuJoCoStepper(plant, name, step)
        case ClosedPlant():
            return ClosedStepper(plant, name, step)
        case RigidPlant():
            return rigid_stepper.RigidStepper(plant, name, step)
        case _:
            return Stepper(plant, name, step)


def step_kernel(
    mechanism: Mechanism, holding: Holding, scheme: tuple[object, ...], *, friction: bool, pushed: bool
) -> Kernel:
    """The kernel of `mafsil.mechanics.tree_plant.step_function`.

    Args:
        mechanism: with loops.
        holding: how they hold it.
        scheme: of the integrator, see `Loop`.
        friction: whether joints lose effort to it.
        pushed: whether something pushes the tip.
    """
    n, push = mechanism.n, {"push": (6,)} if pushed else {}
    loop = Loop(
        plant=mechanism, terms=(), shown=mechanism, scheme=scheme, substeps=1, friction=SMOOTHING if friction else None,
        pushed=pushed, noisy=False, saturated=False, integrates=False, holding=holding,
    )  # fmt: skip
    rubbing = friction_fingerprint(mechanism) if friction else ""
    inputs = {"q": (n,), "qd": (n,), "tau": (n,), "step": (), **push}
    outputs = {"q_next": (n,), "qd_next": (n,), "error": (), "doubt": ()}
    given, found = (tuple(Port(name, shape) for name, shape in side.items()) for side in (inputs, outputs))
    return kernels.compile(
        Signature("closed_step", given, found),
        partial(_build, loop, holding),
        key=f"closed_step {fingerprint(mechanism)} {holding} {scheme} {rubbing} {pushed}",
        fingerprints=(kernels.fingerprint("mafsil.algebra", "mafsil.mechanics"),),
    )


# Its expressions are loaded only when a kernel has to be made.
def _build(loop: Loop, holding: Holding) -> Any:
    return held_plant.step_function(loop, holding)
