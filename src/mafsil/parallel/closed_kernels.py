"""Dynamics of closed chains compiled as a whole, and the independent rows of the loops that such code is made for.

Code of fixed size cannot look for the rank of the loops at each state. Which rows are independent is found once for a
mechanism, at configurations anywhere on its motion; every result comes with a number that says whether that holds.
"""

from __future__ import annotations

from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from mafsil import kernels
from mafsil.arrays import Floats, Integers
from mafsil.kernels import Kernel, Port, Signature
from mafsil.lazy_module import lazily
from mafsil.mechanics.loop_terms import Holding
from mafsil.model import Mechanism
from mafsil.model.fingerprint import fingerprint
from mafsil.parallel.tolerances import RANK
from mafsil.solvers import decompositions

if TYPE_CHECKING:
    import mafsil.mechanics.held_plant as held_plant
    import mafsil.mechanics.loop_constraints as loop_constraints
    import mafsil.mechanics.loop_dynamics as loop_dynamics
    import mafsil.mechanics.loop_efforts as loop_efforts
else:
    held_plant = lazily("mafsil.mechanics.held_plant")
    loop_constraints = lazily("mafsil.mechanics.loop_constraints")
    loop_dynamics = lazily("mafsil.mechanics.loop_dynamics")
    loop_efforts = lazily("mafsil.mechanics.loop_efforts")

Rows = tuple[int, ...]
REMAINDERS = (0.2, 0.02, 2e-3)
"""Shares of a row that must be left beside the rows before it for it to be taken, one pass after the other: the first
rows that are well apart, so that the choice is the same at nearly all configurations."""

MOST = 0.75
"""Share of the states at which that has to be so: a few may happen to be nearly singular."""


def independent_rows(M: Floats, J: Floats) -> Rows | None:
    """Rows of loops that span all others, the same at most states; None where no such rows are found.

    1. Rows in kinetic energy, W = J L'^-1 with M = L L', and their rank; states of less than the largest are singular.
    2. A row is taken if at most of the other states enough of it is left beside those taken before.

    Args:
        M: (k, n, n) mass matrices of the tree.
        J: (k, m, n) rows of the loops.
    """
    try:
        W = np.swapaxes(np.linalg.solve(np.linalg.cholesky(M), np.swapaxes(J, -1, -2)), -1, -2)
    except np.linalg.LinAlgError:
        return None
    # 1
    values = np.linalg.svd(W, compute_uv=False)
    ranks = (values > RANK * values[:, :1]).sum(axis=1)
    rank = int(ranks.max(initial=0))
    W = W[ranks == rank]
    W = W / np.maximum(np.linalg.norm(W, axis=-1).max(axis=-1), RANK)[:, None, None]
    length = np.linalg.norm(W, axis=-1)
    # 2
    taken: list[int] = []
    for share in REMAINDERS:
        for k in range(W.shape[1]):
            left = np.linalg.norm(W[:, k], axis=-1)
            apart = left > share * np.maximum(length[:, k], share)
            if len(taken) < rank and apart.mean() >= MOST:
                along = np.where(apart, 1.0 / np.where(apart, left, 1.0), 0.0)[:, None] * W[:, k]
                W = W - (W @ along[..., None]) * along[:, None, :]
                taken.append(k)
    return tuple(sorted(taken)) if len(taken) == rank else None


def deciding_joints(J: Floats, driven: Integers, freedoms: int) -> Rows | None:
    """Which driven joints decide the efforts of all: as many as freedoms or as driven; None where they do not.

    Args:
        J: (k, m, n) rows of the loops.
        driven: (a,) coordinates of the driven joints.
        freedoms: of the mechanism.
    """
    if not len(driven) or not freedoms:
        return None
    allowed = np.eye(J.shape[-1]) - decompositions.pinv(J, RANK) @ J
    across = np.swapaxes(allowed[..., driven], -1, -2)
    rows = independent_rows(np.broadcast_to(np.eye(J.shape[-1]), (len(J), *allowed.shape[1:])), across)
    return rows if rows is not None and len(rows) == min(freedoms, len(driven)) else None


@lru_cache(maxsize=32)
def terms_kernel(mechanism: Mechanism) -> Kernel:
    """All that the dynamics need of a state; see `mafsil.mechanics.loop_constraints.function`.

    Args:
        mechanism: with loops.
    """
    n, loops = mechanism.n, mechanism.loops
    m = _rows_of(mechanism)
    shapes = {"M": (n, n), "h": (n,), "J": (m, n), "gamma": (m,), "gap": (m,), "facing": (len(loops),), "energy": ()}
    return _kernel("closed_chain", {"q": (n,), "qd": (n,)}, shapes, partial(_terms, mechanism), mechanism)


@lru_cache(maxsize=64)
def forward_kernel(mechanism: Mechanism, rows: Rows, driven: Rows) -> Kernel:
    """Accelerations under efforts; see `mafsil.mechanics.loop_dynamics.forward_function`.

    Args:
        mechanism: with loops.
        rows: independent rows of the loops.
        driven: coordinates that the efforts act on.
    """
    n = mechanism.n
    inputs = {"q": (n,), "qd": (n,), "tau": (len(driven),)}
    outputs = {"qdd": (n,), "force": (_rows_of(mechanism),), "error": (), "doubt": ()}
    build = partial(_forward, mechanism, rows, driven)
    return _kernel("closed_forward_dynamics", inputs, outputs, build, mechanism, rows, driven)


@lru_cache(maxsize=64)
def inverse_kernel(mechanism: Mechanism, rows: Rows, driven: Rows, deciding: Rows) -> Kernel:
    """Efforts for a motion; see `mafsil.mechanics.loop_efforts.inverse_function`.

    Args:
        mechanism: with loops.
        rows: independent rows of the loops.
        driven, deciding: the driven joints, and those of them that decide.
    """
    n, a = mechanism.n, len(driven)
    outputs = {"tau": (a,), "force": (_rows_of(mechanism),), "missing": (), "broken": (), "needed": ()}
    outputs |= {"driven": (n, a), "doubt": ()}
    build = partial(_inverse, mechanism, rows, driven, deciding)
    inputs = {"q": (n,), "qd": (n,), "qdd": (n,)}
    return _kernel("closed_inverse_dynamics", inputs, outputs, build, mechanism, rows, driven, deciding)


@lru_cache(maxsize=64)
def closing_kernel(mechanism: Mechanism, holding: Holding) -> Kernel:
    """States taken back to closed loops; see `mafsil.mechanics.held_plant.closing_function`.

    Args:
        mechanism: with loops.
        holding: how they hold it.
    """
    n = mechanism.n
    outputs = {"here": (n,), "rate": (n,), "error": (), "doubt": ()}
    build = partial(_closing, mechanism, holding)
    return _kernel("closed_state", {"q": (n,), "qd": (n,)}, outputs, build, mechanism, holding.rows, holding.tolerance)


def _kernel(
    name: str,
    inputs: dict[str, tuple[int, ...]],
    outputs: dict[str, tuple[int, ...]],
    build: Any,
    mechanism: Mechanism,
    *details: Rows | float,
) -> Kernel:
    given, found = (tuple(Port(port, shape) for port, shape in side.items()) for side in (inputs, outputs))
    return kernels.compile(
        Signature(name, given, found),
        build,
        key=" ".join([name, fingerprint(mechanism), *map(str, details)]),
        fingerprints=(kernels.fingerprint("mafsil.algebra", "mafsil.mechanics"),),
    )


def _rows_of(mechanism: Mechanism) -> int:
    return sum(loop_constraints.rows_of(joint) for joint in mechanism.loops)


# The functions are made here; their expressions are loaded only when a kernel has to be made.
def _terms(mechanism: Mechanism) -> Any:
    return loop_constraints.function(mechanism)


def _forward(mechanism: Mechanism, rows: Rows, driven: Rows) -> Any:
    return loop_dynamics.forward_function(mechanism, rows, driven)


def _inverse(mechanism: Mechanism, rows: Rows, driven: Rows, deciding: Rows) -> Any:
    return loop_efforts.inverse_function(mechanism, rows, driven, deciding)


def _closing(mechanism: Mechanism, holding: Holding) -> Any:
    return held_plant.closing_function(mechanism, holding)
