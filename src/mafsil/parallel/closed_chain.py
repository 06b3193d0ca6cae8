"""Dynamics of closed chains: constraint forces, accelerations, efforts of the actuators, and closing the loops.

Coordinates are those of the tree, all of them: the loops tie them together. M qdd + h = tau + J' force.

Reference: Featherstone, Rigid Body Dynamics Algorithms, ch. 8; Udwadia and Kalaba, Analytical Dynamics, 1996.
"""

from __future__ import annotations

from functools import cached_property, lru_cache, partial
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mafsil import kernels
from mafsil.arrays import Floats, Integers, JointVector, as_batch, real_array, require_finite, whole
from mafsil.errors import ModelError
from mafsil.kernels import Kernel, Port, Signature
from mafsil.lazy_module import lazily
from mafsil.model import JointKind, Mechanism
from mafsil.model.fingerprint import fingerprint
from mafsil.model.loading import RobotLike
from mafsil.parallel.closed_answers import ActuatorEfforts, ClosedAccelerations, ClosedConfigurations
from mafsil.parallel.tolerances import RANK
from mafsil.robot import Robot, as_robot
from mafsil.solvers import decompositions

if TYPE_CHECKING:
    import mafsil.mechanics.loop_constraints as loop_constraints
    import mafsil.parallel.closed_dynamics_loops as closed_dynamics_loops
else:
    loop_constraints = lazily("mafsil.mechanics.loop_constraints")
    closed_dynamics_loops = lazily("mafsil.parallel.closed_dynamics_loops")

CLOSED = 1e-13
"""Gap over the size of the mechanism, or in radians, at which a loop is closed: some hundred roundings."""
TINY = 1e-300
MOST_STEPS = 100
LONGEST_STEP = 0.3
"""Of one coordinate in a Newton step [rad | sizes]."""


class Terms(NamedTuple):
    """All that the dynamics need of states.

    Attributes:
        M: (*batch, n, n) mass matrix of the tree.
        h: (*batch, n) efforts that hold the tree at qdd = 0.
        J: (*batch, m, n) rows of the loops: J qd = 0.
        gamma: (*batch, m) with J qdd + gamma = 0.
        gap: (*batch, m) how far the loops gape [rad, m].
        facing: (*batch, loops) positive unless a loop is closed the wrong way round.
        energy: (*batch) kinetic and potential [J].
    """

    M: Floats
    h: Floats
    J: Floats
    gamma: Floats
    gap: Floats
    facing: Floats
    energy: Floats


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
        self.robot: Robot = as_robot(robot)
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
        self.kernel: Kernel = _kernel_of(mechanism)
        self.m = next(port.shape[0] for port in self.kernel.signature.outputs if port.name == "gap")

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
        return _error(self.terms(q))

    def closed(
        self, q: ArrayLike, *, hold: ArrayLike | None = None, max_steps: int = MOST_STEPS
    ) -> ClosedConfigurations:
        """The nearest configurations that close all loops, by Newton's method with shortest steps.

        Args:
            q: (*batch, n) where the search begins [rad | m].
            hold: names or indices of coordinates that stay as they are, such as the driven ones.
            max_steps: most steps.

        Returns:
            Configurations; of those that were not found the best one and its gap: nothing is proved by that.
        """
        x = np.array(as_batch("q", q, (self.n,), finite=True))
        most, free = whole("max_steps", max_steps, 1, 100_000), self._free(hold)
        shape, rows = x.shape[:-1], x.reshape(-1, self.n)
        best, steps = rows.copy(), np.zeros(len(rows), dtype=np.int64)
        error = np.full(len(rows), np.inf)
        open_, found = np.arange(len(rows)), self.terms(rows)
        for _ in range(most + 1):
            gap = _error(found)
            better = gap < error[open_]
            error[open_[better]], best[open_[better]] = gap[better], rows[open_[better]]
            going = gap > CLOSED * self.size
            open_ = open_[going]
            if not len(open_):
                break
            move = _correction(found.J[going][:, :, free], found.gap[going])
            longest = np.abs(move / self._unit[free]).max(axis=1, initial=0.0)
            rows[open_[:, None], free] += move * np.minimum(1.0, LONGEST_STEP / np.maximum(longest, TINY))[:, None]
            steps[open_] += 1
            found = self.terms(rows[open_])
        return ClosedConfigurations(
            best.reshape(*shape, self.n), error.reshape(shape), steps.reshape(shape), CLOSED * self.size
        )

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
            return _solved(found._replace(h=-momentum, gamma=np.zeros_like(found.gamma)), np.zeros(self.n))[0]
        free = self._free(hold)
        shape = found.M.shape[:-2]
        result = np.array(np.broadcast_to(rate, (*shape, self.n)))
        missing = np.einsum("...mn,...n->...m", found.J, result)
        change = _correction(found.J[..., free].reshape(-1, self.m, len(free)), missing.reshape(-1, self.m))
        result[..., free] += change.reshape(*shape, len(free))
        return result

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
        change = _correction(
            np.ascontiguousarray(np.broadcast_to(found.J[..., passive], (*shape, self.m, len(passive)))).reshape(
                -1, self.m, len(passive)
            ),
            missing.reshape(-1, self.m),
        )
        result[..., passive] += change.reshape(*shape, len(passive))
        return result

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
        found = self.terms(q, qd)
        if added_inertia is not None:
            found = found._replace(
                M=np.ascontiguousarray(found.M + as_batch("added_inertia", added_inertia, (self.n,) * 2))
            )
        qdd, force, ranks = _solved(found, self._efforts(tau))
        return ClosedAccelerations(qdd, force, ranks, self.m, _error(found))

    def inverse_dynamics(self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike) -> ActuatorEfforts:
        """Efforts of the driven joints for a motion, and the forces of the loops.

        Where several efforts do it (redundant actuation), the shortest are taken; `preload` is a basis of the others.

        Args:
            q, qd, qdd: (*batch, n) coordinates, rates and accelerations that keep the loops closed.
        """
        found = self.terms(q, qd)
        acceleration = as_batch("qdd", qdd, (self.n,), finite=True)
        needed = np.einsum("...ij,...j->...i", found.M, acceleration) + found.h
        across = decompositions.pinv(found.J, RANK)
        # Motions that the loops allow feel only efforts, no forces of the loops.
        allowed = np.eye(self.n) - across @ found.J
        driven = allowed[..., self.actuated]
        tau = np.einsum("...an,...n->...a", decompositions.pinv(driven, RANK), needed)
        rest = needed.copy()
        rest[..., self.actuated] -= tau
        force = np.einsum("...nm,...n->...m", across, rest)
        missing = np.einsum("...ij,...j->...i", allowed, rest)
        broken = np.einsum("...mn,...n->...m", found.J, acceleration) + found.gamma
        scale = np.linalg.norm(needed, axis=-1)
        return ActuatorEfforts(tau, force, np.linalg.norm(missing, axis=-1), np.abs(broken).max(axis=-1), scale, driven)

    @cached_property
    def size(self) -> float:
        """Largest length of the mechanism [m], which gaps are judged over; at least one, for they are angles too."""
        places = [joint.T_pj[:3, 3] for joint in (*self.robot.mechanism.joints, *self.robot.mechanism.loops)]
        return max(1.0, float(max(np.linalg.norm(place) for place in places)))

    @cached_property
    def _unit(self) -> Floats:
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


def _error(found: Terms) -> Floats:
    gap = np.abs(found.gap).max(axis=-1, initial=0.0)
    return np.where((found.facing > 0.0).all(axis=-1), gap, np.inf)


def _correction(J: Floats, gap: Floats) -> Floats:
    """(rows, k) shortest steps with J step = -gap."""
    step, ranks = np.empty((len(J), J.shape[2])), np.zeros(len(J), dtype=np.int64)
    closed_dynamics_loops.corrections(np.ascontiguousarray(J), np.ascontiguousarray(gap), step, ranks)
    return step


def _solved(found: Terms, tau: Floats) -> tuple[Floats, Floats, Integers]:
    """Accelerations, forces and ranks."""
    m, n = found.J.shape[-2:]
    if found.h.ndim == tau.ndim == 1:
        # A single state needs no copies, which would cost more than its solution.
        alone, across, rank = np.empty((1, n)), np.empty((1, m)), np.empty(1, dtype=np.int64)
        given = np.ascontiguousarray(tau)
        closed_dynamics_loops.accelerations(
            found.M[None], found.h[None], found.J[None], found.gamma[None], given[None], alone, across, rank
        )
        return alone[0], across[0], rank.reshape(())
    shape = np.broadcast_shapes(found.h.shape[:-1], tau.shape[:-1])

    def rows(values: Floats, *core: int) -> Floats:
        return np.ascontiguousarray(np.broadcast_to(values, (*shape, *core)).reshape(-1, *core))

    efforts = rows(tau, n)
    qdd, force = np.empty_like(efforts), np.empty((len(efforts), m))
    ranks = np.empty(len(efforts), dtype=np.int64)
    closed_dynamics_loops.accelerations(
        rows(found.M, n, n), rows(found.h, n), rows(found.J, m, n), rows(found.gamma, m), efforts, qdd, force, ranks
    )
    return qdd.reshape(*shape, n), force.reshape(*shape, m), ranks.reshape(shape)


@lru_cache(maxsize=32)
def _kernel_of(mechanism: Mechanism) -> Kernel:
    n, loops = mechanism.n, mechanism.loops
    m = sum(loop_constraints.rows_of(joint) for joint in loops)
    shapes = {"M": (n, n), "h": (n,), "J": (m, n), "gamma": (m,), "gap": (m,), "facing": (len(loops),), "energy": ()}
    return kernels.compile(
        Signature(
            "closed_chain", (Port("q", (n,)), Port("qd", (n,))),
            tuple(Port(name, shape) for name, shape in shapes.items()),
        ),
        partial(_build, mechanism),
        key=f"closed_chain {fingerprint(mechanism)}",
        fingerprints=(kernels.fingerprint("mafsil.algebra", "mafsil.mechanics"),),
    )  # fmt: skip


def _build(mechanism: Mechanism) -> Any:
    """The function; its expressions are loaded only when a kernel has to be made."""
    return loop_constraints.function(mechanism)
