"""What the dynamics of closed chains need of states, and their solution where the rank of the loops is found each time.

Reference: Featherstone, Rigid Body Dynamics Algorithms, ch. 8.

Accelerations of closed chains whose tree has a singular mass matrix: of joints that move no mass by themselves.

1. Motions that the loops allow, N, and the shortest acceleration that they ask for.
2. The mass of those motions, N' M N, and the force on them. Where all have mass, the joints without were only parts of
   what the loops hold together: the acceleration is as well defined as with mass everywhere.
3. Along motions without mass a force gives an infinite acceleration, and no force leaves what is preferred.
4. Forces of the loops: the shortest.

Jacobians of closed chains: the twist of a link per rate of the driven joints, and what a wrench asks of them.

With the driven joints a, the passive ones p, the loops' rows J and the tree's Jacobian J_t of all joints:

    qd_p = G qd_a,   G = -J_p^+ J_a,   J_closed = J_t,a + J_t,p G,   tau_a = J_closed' F.

Reference: Lynch & Park, Modern Robotics, sec. 7.2; Murray, Li & Sastry, A Mathematical Introduction, sec. 3.5.
"""

from __future__ import annotations

from functools import cached_property
from typing import TYPE_CHECKING, Literal, NamedTuple, Protocol

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, Integers
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.lazy_module import lazily
from mafsil.parallel.tolerances import RANK
from mafsil.robot import Robot
from mafsil.robot.closed_states import require_closed, row_name
from mafsil.solvers import decompositions

if TYPE_CHECKING:
    import mafsil.parallel.closed_dynamics_loops as closed_dynamics_loops
else:
    closed_dynamics_loops = lazily("mafsil.parallel.closed_dynamics_loops")


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


class LoopConditions(Protocol):
    """A chain with loops, as searches for configurations that close them see it; `ClosedChain` is one.

    Attributes:
        robot: its tree.
        n: coordinates of the tree.
    """

    robot: Robot
    n: int

    @cached_property
    def size(self) -> float:
        """Of the mechanism [m]."""
        ...

    @cached_property
    def unit(self) -> Floats:
        """(n,) steps of the coordinates that count alike: one for angles, the size for lengths."""
        ...

    def terms(self, q: ArrayLike) -> Terms:
        """All that the dynamics need at coordinates (*batch, n)."""
        ...

    def loop_errors(self, q: ArrayLike) -> Floats:
        """(*batch, loops) largest gap of each loop."""
        ...


def error_of(found: Terms) -> Floats:
    """(*batch) largest gap of a loop [rad | m]; infinite where one is closed the wrong way round.

    Args:
        found: terms of the states.
    """
    gap = np.abs(found.gap).max(axis=-1, initial=0.0)
    return np.where((found.facing > 0.0).all(axis=-1), gap, np.inf)


def correction(J: Floats, gap: Floats) -> Floats:
    """(rows, k) shortest steps with J step = -gap, in the sense of least squares.

    Args:
        J: (rows, m, k) rows of the loops.
        gap: (rows, m).
    """
    step, ranks = np.empty((len(J), J.shape[2])), np.zeros(len(J), dtype=np.int64)
    closed_dynamics_loops.corrections(np.ascontiguousarray(J), np.ascontiguousarray(gap), step, ranks)
    return step


def held(found: Terms, tau: Floats) -> tuple[Floats, Floats]:
    """Accelerations (*batch, n), and (*batch, m + 2) forces, rank and largest gap of the loops, as compiled code.

    Args:
        found: terms of the states.
        tau: (*batch, n) efforts.
    """
    qdd, force, ranks = accelerations(found, tau)
    error = np.broadcast_to(error_of(found), ranks.shape)
    return qdd, np.concatenate([force, ranks[..., None].astype(np.float64), error[..., None]], axis=-1)


def accelerations(found: Terms, tau: Floats, prefer: Floats | None = None) -> tuple[Floats, Floats, Integers]:
    """Accelerations (*batch, n), forces (*batch, m) and ranks (*batch), -1 where the loops allow motions without mass.

    Args:
        found: terms of the states.
        tau: (*batch, n) efforts.
        prefer: (*batch, n) along motions that have no mass and that no effort drives; none if None.
    """
    m, n = found.J.shape[-2:]
    if found.h.ndim == tau.ndim == found.M.ndim - 1 == 1:
        # A single state needs no copies, which would cost more than its solution.
        alone, across, rank = np.empty((1, n)), np.empty((1, m)), np.empty(1, dtype=np.int64)
        given = np.ascontiguousarray(tau)
        closed_dynamics_loops.accelerations(
            found.M[None], found.h[None], found.J[None], found.gamma[None], given[None], alone, across, rank
        )
        if rank[0] < 0:
            alone[0], across[0], rank[0] = accelerations_without_mass(*found[:4], tau, _prefer(prefer, n))
        return alone[0], across[0], rank.reshape(())
    shape = np.broadcast_shapes(found.h.shape[:-1], tau.shape[:-1], found.M.shape[:-2])

    def rows(values: Floats, *core: int) -> Floats:
        return np.ascontiguousarray(np.broadcast_to(values, (*shape, *core)).reshape(-1, *core))

    M, h, J = rows(found.M, n, n), rows(found.h, n), rows(found.J, m, n)
    gamma, efforts = rows(found.gamma, m), rows(tau, n)
    qdd, force = np.empty_like(efforts), np.empty((len(efforts), m))
    ranks = np.empty(len(qdd), dtype=np.int64)
    closed_dynamics_loops.accelerations(M, h, J, gamma, efforts, qdd, force, ranks)
    light = np.flatnonzero(ranks < 0)
    if len(light):
        wanted = rows(_prefer(prefer, n), n)
        for k in light.tolist():
            qdd[k], force[k], ranks[k] = accelerations_without_mass(M[k], h[k], J[k], gamma[k], efforts[k], wanted[k])
    return qdd.reshape(*shape, n), force.reshape(*shape, m), ranks.reshape(shape)


def _prefer(prefer: Floats | None, n: int) -> Floats:
    return np.zeros(n) if prefer is None else prefer


def efforts(found: Terms, qdd: Floats, driven: Integers) -> tuple[Floats, Floats, Floats, Floats, Floats, Floats]:
    """The fields of `ActuatorEfforts`, in their order.

    Args:
        found: terms of the states.
        qdd: (*batch, n) accelerations.
        driven: (a,) coordinates of the driven joints.
    """
    needed = np.einsum("...ij,...j->...i", found.M, qdd) + found.h
    across = decompositions.pinv(found.J, RANK)
    # Motions that the loops allow feel only efforts, no forces of the loops.
    allowed = np.eye(needed.shape[-1]) - across @ found.J
    columns = allowed[..., driven]
    tau = np.einsum("...an,...n->...a", _inverse_of_part(columns), needed)
    rest = needed.copy()
    rest[..., driven] -= tau
    force = np.einsum("...nm,...n->...m", across, rest)
    missing = np.einsum("...ij,...j->...i", allowed, rest)
    broken = np.einsum("...mn,...n->...m", found.J, qdd) + found.gamma
    sizes = (
        np.linalg.norm(missing, axis=-1),
        np.abs(broken).max(axis=-1, initial=0.0),
        np.linalg.norm(needed, axis=-1),
    )
    return tau, force, *sizes, columns


def _inverse_of_part(P: Floats) -> Floats:
    """(*batch, a, n) pseudoinverses of columns (*batch, n, a) of projections, whose singular values are one at most.

    Beside one and not beside the largest: at a dead point a single motor moves nothing, whatever its size.
    """
    U, s, Vt = np.linalg.svd(P, full_matrices=False)
    inverse = np.where(s > RANK, 1.0 / np.where(s > RANK, s, 1.0), 0.0)
    return np.einsum("...ka,...k,...nk->...an", Vt, inverse, U)


def accelerations_without_mass(
    M: Floats, h: Floats, J: Floats, gamma: Floats, tau: Floats, prefer: Floats
) -> tuple[Floats, Floats, int]:
    """Accelerations (n,), forces of the loops (m,), and the rank of the loops, -1 where motions have no mass.

    Args:
        M: (n, n) mass matrix.
        h: (n,) bias forces.
        J: (m, n) rows of the loops.
        gamma: (m,) their bias.
        tau: (n,) efforts.
        prefer: (n,) along motions without mass and without a force on them.
    """
    # 1.
    U, s, Vt = np.linalg.svd(J)
    rank = int((s > RANK * max(float(s.max(initial=0.0)), LEAST_DIVISOR)).sum())
    N = Vt[rank:].T
    across = Vt[:rank].T @ ((U[:, :rank].T @ -gamma) / s[:rank])
    # 2.
    given = tau - h - M @ across
    mass, directions = np.linalg.eigh(N.T @ M @ N)
    force = directions.T @ (N.T @ given)
    heavy = mass > RANK * max(float(np.abs(np.diag(M)).max(initial=0.0)), LEAST_DIVISOR)
    along = np.where(heavy, force / np.where(heavy, mass, 1.0), directions.T @ (N.T @ prefer))
    size = float(np.abs(tau).max(initial=0.0) + np.abs(h).max(initial=0.0) + np.abs(M @ across).max(initial=0.0))
    # 3.
    pushed = ~heavy & (np.abs(force) > RANK * size)
    qdd = across + N @ (directions @ np.where(pushed, 0.0, along))
    away = N @ (directions @ np.where(pushed, force, 0.0))
    infinite = np.abs(away) > RANK * max(float(np.abs(away).max(initial=0.0)), LEAST_DIVISOR)
    # 4.
    held = U[:, :rank] @ ((Vt[:rank] @ (M @ qdd + h - tau)) / s[:rank])
    return np.where(infinite, np.copysign(np.inf, away), qdd), held, rank if heavy.all() else -1


LEFT = 1e-6
"""Share of a rate that passive joints may leave over, or add where the driven ones rest: what typed digits leave."""


def closed_jacobian(
    chain: LoopConditions, q: ArrayLike, actuated: Integers, form: Literal["body", "space"], frame: str | None
) -> Floats:
    """(*batch, 6, a) twist of a frame per rate of the driven joints.

    1. Rates of the passive joints that keep the loops closed while one driven joint moves: the shortest.
    2. They leave nothing over: the driven joints can be moved independently.
    3. What they may have besides does not move the frame, as the spin of a rod does not.

    Args:
        chain: with loops.
        q: (*batch, n) coordinates that close the loops.
        actuated: (a,) the driven coordinates.
        form: whether the twist is that of the frame or of {s}.
        frame: link name; the tip frame if None.

    Raises:
        InputError: coordinates that open a loop, or at which the driven joints do not decide the frame's twist, or
            cannot be moved independently; which in the batch, is said.
        ModelError: no such frame.
    """
    tree = chain.robot
    require_closed(tree.mechanism, q)
    J = chain.terms(q).J
    passive = np.setdiff1d(np.arange(chain.n), actuated)
    # Columns count alike: a rate of a prismatic joint is taken over the size.
    scaled: Floats = (tree.jacobian_body if form == "body" else tree.jacobian_space)(q, frame=frame) * chain.unit
    own, others = J[..., actuated] * chain.unit[actuated], J[..., passive] * chain.unit[passive]
    # 1
    inverse = decompositions.pinv(others, RANK)
    G: Floats = -inverse @ own
    # 2
    apart = _largest(others @ G + own) > LEFT * np.maximum(_largest(own), 1.0)
    # 3
    idle = np.eye(len(passive)) - inverse @ others
    loose = _largest(scaled[..., passive] @ idle) > LEFT * np.maximum(_largest(scaled), 1.0)
    _require(chain, actuated, {"contradicted": apart, "undecided": loose})
    return (scaled[..., actuated] + scaled[..., passive] @ G) / chain.unit[actuated]


def _largest(A: Floats) -> Floats:
    """(*batch) largest entry; that of NaN is NaN, which no comparison finds wrong."""
    return np.abs(A).max(axis=(-1, -2), initial=0.0)


def _require(chain: LoopConditions, actuated: Integers, wrong: dict[str, NDArray[np.bool_]]) -> None:
    places: list[int] = actuated.tolist()
    for kind, rows in wrong.items():
        if np.any(rows):
            index = tuple(int(k) for k in np.argwhere(rows)[0])
            raise InputError(
                f"parallel.jacobian_{kind}", robot=chain.robot.name, row=row_name(index),
                driven=", ".join(chain.robot.joint_names[k] for k in places) or "-",
            )  # fmt: skip
