"""Dynamics of closed chains: constraint forces, accelerations, efforts of the actuators, and closing the loops.

Coordinates are those of the tree, all of them: the loops tie them together. M qdd + h = tau + J' force.

Reference: Featherstone, Rigid Body Dynamics Algorithms, ch. 8; Udwadia and Kalaba, Analytical Dynamics, 1996.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Integers, JointVector, as_batch, real_array, require_finite, whole
from mafsil.errors import InputError, ModelError
from mafsil.mechanics.loop_terms import Holding
from mafsil.model import JointKind, Mechanism
from mafsil.model.loading import RobotLike
from mafsil.parallel import closed_terms, closure
from mafsil.parallel.closed_answers import ActuatorEfforts, ClosedAccelerations, ClosedConfigurations
from mafsil.parallel.closed_compiled import CompiledChain, Run, is_certain
from mafsil.parallel.closed_kernels import terms_kernel
from mafsil.parallel.closed_terms import Terms
from mafsil.parallel.closure import CLOSED, FARTHEST_START
from mafsil.robot import Robot, as_open_tree
from mafsil.robot.closed_states import loop_size
from mafsil.robot.degrees import in_tip

if TYPE_CHECKING:
    from mafsil.kernels import Kernel

MOST_STEPS, TRIES = 100, 25
"""Of a search for a closed configuration, and searches."""
AJAR = 1e-2
"""Gap over the size, or in radians, up to which a step of an integrator may leave loops that were closed."""
NEWTON_STEPS: Integers = np.array(3)
"""That compiled code takes."""
STARTS, STEPS_OF_START = 24, 40
"""Searches for configurations anywhere, and how long they may take."""


class ClosedChain:
    """A mechanism with loops, and which of its joints are driven.

    Args:
        robot: a Robot, Mechanism, library name or path, whose mechanism has `loops`.
        actuated: names of the driven joints; those that the description drives if None.

    Attributes:
        robot: its tree: open-chain functions work on it.
        n, m: coordinates of the tree, and conditions of the loops.
        actuated: (a,) indices of the driven coordinates.

    Raises:
        ModelError: it has no loops or no joint that moves, or a joint is unknown.
    """

    def __init__(self, robot: RobotLike, actuated: tuple[str, ...] | None = None) -> None:
        self.robot: Robot = as_open_tree(robot)
        mechanism = self.robot.mechanism
        if not mechanism.loops:
            raise ModelError("parallel.no_loops", robot=mechanism.name)
        if not mechanism.n:
            raise ModelError("robot.no_joints", robot=mechanism.name)
        self.n = mechanism.n
        names = [joint.name for joint in mechanism.coordinates]
        driven = [j.name for j in mechanism.coordinates if j.actuated] if actuated is None else list(actuated)
        for name in driven:
            if name not in names:
                raise ModelError("parallel.no_joint", joint=name, known=", ".join(names))
        self.actuated: Integers = np.array([names.index(name) for name in driven], dtype=np.int64)
        self.kernel: Kernel = terms_kernel(mechanism)
        self.m = next(port.shape[0] for port in self.kernel.signature.outputs if port.name == "gap")
        places = tuple(self.actuated.tolist())
        self._compiled = CompiledChain(mechanism, places, CLOSED * self.size, _anywhere, self.terms)
        self._forward: Run = self._forward_chosen

    def terms(self, q: ArrayLike, qd: ArrayLike | None = None) -> Terms:
        """Everything the dynamics need, in one compiled call.

        Args:
            q: (*batch, n) coordinates of the tree [rad | m].
            qd: (*batch, n) rates; at rest if None.
        """
        here = as_batch("q", q, (self.n,), finite=True)
        rate = np.zeros(self.n) if qd is None else as_batch("qd", qd, (self.n,), finite=True)
        run = self.kernel.call if here.ndim == 1 and rate.ndim == 1 else self.kernel.evaluate
        return Terms(*run(here, rate))

    def error(self, q: ArrayLike) -> Floats:
        """(*batch) largest gap of a loop [rad | m]; infinite where one is closed the wrong way round."""
        return closed_terms.error_of(self.terms(q))

    def loop_errors(self, q: ArrayLike) -> Floats:
        """(*batch, loops) largest gap of each loop [rad | m]; infinite where it is closed the wrong way round.

        Args:
            q: (*batch, n) coordinates [rad | m].
        """
        found = self.terms(q)
        begins = np.cumsum([0, *(6 - joint.kind.freedoms for joint in self.robot.mechanism.loops[:-1])])
        gap: Floats = np.maximum.reduceat(np.abs(found.gap), begins, axis=-1)
        return np.where(found.facing > 0.0, gap, np.inf)

    def close_loops(
        self, q: ArrayLike, *, hold: ArrayLike | None = None, max_steps: int = MOST_STEPS, tries: int = TRIES
    ) -> ClosedConfigurations:
        """The nearest configurations that close all loops, by Newton's method with shortest steps.

        Where that ends open, or with a loop closed the wrong way round, searches begin elsewhere, ever farther away: of
        those that close, the nearest in its round is taken.

        Args:
            q: (*batch, n) where the search begins [rad | m].
            hold: names or indices of coordinates that stay as they are, such as the driven ones.
            max_steps: most steps of a search.
            tries: searches for each row; 1 for the one from q alone, as a motion that must not jump asks for.

        Returns:
            Configurations; of those that were not found the best one and its gap: nothing is proved by that.
        """
        start = as_batch("q", q, (self.n,), finite=True)
        most, count = whole("max_steps", max_steps, 1, 100_000), whole("tries", tries, 1, 10_000)
        return closure.close_loops(self, start, self._free(hold), most, count)

    def rates(self, q: ArrayLike, qd: ArrayLike, *, hold: ArrayLike | None = None) -> JointVector:
        """(*batch, n) rates that keep the loops closed, the nearest to given ones in kinetic energy.

        Args:
            q: (*batch, n) coordinates that close the loops.
            qd: (*batch, n) rates.
            hold: names or indices of coordinates whose rates stay as they are; the others then change least, in the
                sense of least squares where the loops forbid the rates that stay.
        """
        rate = as_batch("qd", qd, (self.n,), finite=True)
        found = self.terms(q, rate)
        if hold is None:
            momentum = np.einsum("...ij,...j->...i", found.M, rate)
            return closed_terms.accelerations(
                found._replace(h=-momentum, gamma=np.zeros_like(found.gamma)), np.zeros(self.n), rate
            )[0]
        free = self._free(hold)
        shape = found.M.shape[:-2]
        result = np.array(np.broadcast_to(rate, (*shape, self.n)))
        missing = np.einsum("...mn,...n->...m", found.J, result)
        return self._correct(result, found.J, missing, free)

    def closed_state(self, q: ArrayLike, qd: ArrayLike) -> tuple[ClosedConfigurations, JointVector]:
        """Configurations that close all loops, and rates that keep them closed there, as by `close_loops` and `rates`.

        Args:
            q, qd: (*batch, n) coordinates and rates, such as an integrator leaves them, near closed loops.
        """
        run = self._compiled.closing(q)
        if run is not None:
            here, rate, error, doubt = run(q, qd)
            if is_certain(doubt):
                left: Floats = np.asarray(error)
                steps = np.full(left.shape, NEWTON_STEPS) if left.ndim else NEWTON_STEPS
                return ClosedConfigurations(here, left, steps, CLOSED * self.size), rate
        back = self.close_loops(q, tries=1)
        return back, self.rates(back.q, qd) if back else np.zeros_like(back.q)

    def accelerations(self, q: ArrayLike, qd: ArrayLike, driven: ArrayLike) -> JointVector:
        """(*batch, n) accelerations of all joints that keep the loops closed, from those of the driven joints.

        Where the driven joints do not decide the others, the shortest; where they contradict the loops, in the sense of
        least squares.

        Args:
            q, qd: (*batch, n) coordinates and rates.
            driven: (*batch, a) accelerations of the driven joints [rad/s^2 | m/s^2].
        """
        found, given = self.terms(q, qd), as_batch("driven", driven, (len(self.actuated),), finite=True)
        shape = np.broadcast_shapes(found.h.shape[:-1], given.shape[:-1])
        result = np.zeros((*shape, self.n))
        result[..., self.actuated] = given
        passive = self._free(self.actuated)
        missing = np.einsum("...mn,...n->...m", found.J, result) + found.gamma
        return self._correct(result, found.J, missing, passive)

    def _correct(self, x: Floats, J: Floats, missing: Floats, free: Integers) -> Floats:
        """(*batch, n) x whose free entries got the shortest step by which J x loses what is missing (*batch, m)."""
        if len(free):
            shape = x.shape[:-1]
            rows = np.broadcast_to(J[..., free], (*shape, self.m, len(free))).reshape(-1, self.m, len(free))
            x[..., free] += closed_terms.correction(rows, missing.reshape(-1, self.m)).reshape(*shape, len(free))
        return x

    def forward_dynamics(
        self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike, *, added_inertia: ArrayLike | None = None
    ) -> ClosedAccelerations:
        """Accelerations of all joints and the forces that hold the loops together.

        Loops that ask the same thing several times have no unique forces: the shortest are taken.

        Args:
            q: (*batch, n) coordinates that close the loops [rad | m].
            qd: (*batch, n) rates that keep them closed.
            tau: (*batch, n) efforts, or (*batch, a) of the driven joints alone [N m | N].
            added_inertia: (*batch, n, n) that the mass matrix gets besides, such as step times damping; none if None.
        """
        if added_inertia is None:
            # Half a microsecond, of which nothing is spent on looking at the arguments: machine code does that.
            try:
                found = self._forward(q, qd, tau)
            except InputError:
                # Efforts of as many joints as the kernel at hand does not expect, or arguments that nobody takes.
                found = self._forward_chosen(q, qd, tau)
            if type(found) is ClosedAccelerations:
                return found
            return self._looked_at((q, qd, tau), *found)
        terms = self._terms_of_closed(q, qd)
        M = np.ascontiguousarray(terms.M + as_batch("added_inertia", added_inertia, (self.n,) * 2))
        return self._solve(terms._replace(M=M), tau)

    def _forward_chosen(self, q: ArrayLike, qd: ArrayLike, tau: ArrayLike) -> tuple[Any, ...]:
        """The first call, and those that change between efforts of all joints and of the driven ones."""
        run = self._compiled.forward_for(tau, q)
        if run is None:
            return self._solve(self._terms_of_closed(q, qd), tau)
        self._forward = run
        return run(q, qd, tau)

    def _solve(self, found: Terms, tau: ArrayLike) -> ClosedAccelerations:
        """With the rank of the loops found at every state."""
        return ClosedAccelerations(closed_terms.held(found, self._efforts(tau)))

    def _terms_of_closed(self, q: ArrayLike, qd: ArrayLike) -> Terms:
        """Terms of states; of those that an integrator left ajar, where their loops close, with the gap that they have.

        Beside closed loops rows that depend on each other seem independent, and would hold what moves.
        """
        found = self.terms(q, qd)
        gap = closed_terms.error_of(found)
        ajar = np.asarray((gap > CLOSED * self.size) & (gap < AJAR * self.size))
        if not ajar.any():
            return found
        here, rate = (np.array(np.broadcast_to(x, (*ajar.shape, self.n)), dtype=np.float64) for x in (q, qd))
        back, rates = self.closed_state(here[ajar], rate[ajar])
        here[ajar], rate[ajar] = back.q, rates
        return self.terms(here, rate)._replace(gap=found.gap, facing=found.facing)

    def _looked_at(self, given: tuple[ArrayLike, ...], qdd: Floats, held: Floats) -> ClosedAccelerations:
        """Results of compiled code; rows that do not hold are found with their rank, what is not finite is refused."""
        doubtful = np.isnan(held[..., -1])
        if doubtful.any():
            q, qd, tau = (np.broadcast_to(x, (*doubtful.shape, np.shape(x)[-1]))[doubtful] for x in given)
            found = self._terms_of_closed(q, qd)
            qdd[doubtful], held[doubtful] = closed_terms.held(found, self._efforts(tau))
        return ClosedAccelerations((qdd, held))

    def following(self, guess: ArrayLike, driven: ArrayLike) -> tuple[JointVector, JointVector, JointVector]:
        """Positions, rates and accelerations (*batch, n) of all joints while the driven ones move.

        As `close_loops`, `rates` and `accelerations` find them with the driven joints held: where the loops cannot be
        closed, the nearest that was found.

        Args:
            guess: (*batch, n) configurations near closed loops.
            driven: (*batch, 3, a) positions, rates and accelerations of the driven joints.
        """
        start = as_batch("guess", guess, (self.n,), finite=True)
        motion = as_batch("driven", driven, (3, len(self.actuated)), finite=True)
        run = self._compiled.following(start)
        if run is not None:
            q, qd, qdd, doubt = run(start, motion)
            if is_certain(doubt):
                return q, qd, qdd
        u, v, a = (motion[..., k, :] for k in range(3))
        place = np.array(np.broadcast_to(start, (*np.broadcast_shapes(start.shape[:-1], u.shape[:-1]), self.n)))
        place[..., self.actuated] = u
        q = self.close_loops(place, hold=self.actuated, tries=1).q
        qd = np.zeros(q.shape)
        qd[..., self.actuated] = v
        qd = self.rates(q, qd, hold=self.actuated)
        return q, qd, self.accelerations(q, qd, a)

    def holding(self, q: ArrayLike) -> Holding | None:
        """How the loops hold the mechanism, as compiled code has to know it; None where there is none.

        Args:
            q: (*batch, n) configurations that close the loops, looked at if no others are met by chance.
        """
        return self._compiled.holding(q)

    def inverse_dynamics(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> ActuatorEfforts:
        """Efforts of the driven joints for a motion, and the forces of the loops.

        Where several efforts do it (redundant actuation), the shortest are taken; `preload` is a basis of the others.

        Args:
            q, qd, qdd: (*batch, n) coordinates, rates and accelerations that keep the loops closed.
        """
        run = self._compiled.inverse(q)
        if run is not None:
            tau, force, missing, broken, needed, driven, doubt = run(q, qd, qdd)
            if is_certain(doubt):
                redundancy = self._compiled.redundancy
                return ActuatorEfforts(tau, force, missing, broken, needed, driven, redundancy)
        qdd = as_batch("qdd", qdd, (self.n,), finite=True)
        return ActuatorEfforts(*closed_terms.efforts(self.terms(q, qd), qdd, self.actuated))

    def jacobian_body(self, q: ArrayLike, *, frame: str | None = None) -> Floats:
        """(*batch, 6, a) body twist (omega, v) of the tip per rate of the driven joints, the loops kept closed.

        Args:
            q: (*batch, n) coordinates that close the loops.
            frame: name of a link; the tip frame if None.

        Raises:
            InputError: coordinates that open a loop, or at which the driven joints do not decide the others.
        """
        return closed_terms.closed_jacobian(self, q, self.actuated, "body", frame)

    def jacobian_space(self, q: ArrayLike, *, frame: str | None = None) -> Floats:
        """(*batch, 6, a) as `jacobian_body`, the twist in {s}."""
        return closed_terms.closed_jacobian(self, q, self.actuated, "space", frame)

    def joint_torque(self, q: ArrayLike, F: ArrayLike, *, frame: str | None = None) -> Floats:
        """(*batch, a) efforts of the driven joints with which the tip exerts a wrench on the world; weight left aside.

        Args:
            q: (*batch, n) coordinates that close the loops.
            F: (*batch, 6) wrench (m, f) in that frame [N m, N].
            frame: name of a link; the tip frame if None.

        Raises:
            InputError: as `jacobian_body`.
        """
        wrench = in_tip("F", F, self.robot.tip if frame is None else frame)
        return np.einsum("...ia,...i->...a", self.jacobian_body(q, frame=frame), as_batch("F", wrench, (6,)))

    @cached_property
    def size(self) -> float:
        """Largest length of the mechanism [m], which gaps are judged over; at least one, for they are angles too."""
        return loop_size(self.robot.mechanism)

    @cached_property
    def unit(self) -> Floats:
        """(n,) one for angles, the size for lengths."""
        prismatic = [joint.kind is JointKind.PRISMATIC for joint in self.robot.mechanism.coordinates]
        return np.where(prismatic, self.size, 1.0)

    def _free(self, hold: ArrayLike | None) -> Integers:
        """Indices of the coordinates that may change."""
        if hold is None:
            return np.arange(self.n)
        names = [joint.name for joint in self.robot.mechanism.coordinates]
        kept: set[int] = set()
        for each in np.atleast_1d(np.asarray(hold)).tolist():
            index = names.index(each) if each in names else each
            if not isinstance(index, int) or not 0 <= index < self.n:
                raise ModelError("parallel.no_joint", joint=str(each), known=", ".join(names))
            kept.add(index)
        return np.array([k for k in range(self.n) if k not in kept], dtype=np.int64)

    def _efforts(self, tau: ArrayLike) -> Floats:
        """(*batch, n) efforts of all joints, from those of all or of the driven ones."""
        given = real_array("tau", tau)
        if given.ndim and given.shape[-1] == self.n:
            return require_finite("tau", given)
        driven = as_batch("tau", given, (len(self.actuated),), finite=True)
        full = np.zeros((*driven.shape[:-1], self.n))
        full[..., self.actuated] = driven
        return full


def _anywhere(mechanism: Mechanism) -> Terms | None:
    """Terms at configurations anywhere on the motion; None if none were met."""
    chain = ClosedChain(mechanism)
    starts = np.random.default_rng(0).uniform(-FARTHEST_START, FARTHEST_START, (STARTS, chain.n)) * chain.unit
    found = chain.close_loops(starts, max_steps=STEPS_OF_START, tries=1)
    return chain.terms(found.q[found.found]) if found.found.any() else None
