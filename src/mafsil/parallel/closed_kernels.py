"""Dynamics of closed chains compiled as a whole, one kernel a quantity."""

from __future__ import annotations

from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

from mafsil import kernels
from mafsil.kernels import Port, Signature
from mafsil.lazy_module import lazily
from mafsil.mechanics.loop_terms import Holding
from mafsil.model import Mechanism
from mafsil.model.fingerprint import fingerprint
from mafsil.parallel.closed_answers import ClosedAccelerations

if TYPE_CHECKING:
    import mafsil.mechanics.loop_constraints as loop_constraints
    import mafsil.mechanics.loop_dynamics as loop_dynamics
    import mafsil.mechanics.loop_efforts as loop_efforts
    import mafsil.mechanics.tree_plant as held_plant
    from mafsil.kernels import Kernel
else:
    held_plant = lazily("mafsil.mechanics.tree_plant")
    loop_constraints = lazily("mafsil.mechanics.loop_constraints")
    loop_dynamics = lazily("mafsil.mechanics.loop_dynamics")
    loop_efforts = lazily("mafsil.mechanics.loop_efforts")

Rows = tuple[int, ...]


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


def forward_kernel(mechanism: Mechanism, holding: Holding, driven: Rows) -> Kernel:
    """Accelerations under efforts; see `mafsil.mechanics.loop_dynamics.forward_function`.

    Args:
        mechanism: with loops.
        holding: how they hold it.
        driven: coordinates that the efforts act on.
    """
    n = mechanism.n
    inputs = {"q": (n,), "qd": (n,), "tau": (len(driven),)}
    outputs = {"qdd": (n,), "held": (_rows_of(mechanism) + 2,)}
    build = partial(_forward, mechanism, holding.rows, driven)
    details = holding.rows, driven
    return _kernel("closed_forward_dynamics", inputs, outputs, build, mechanism, *details, answer=ClosedAccelerations)


def inverse_kernel(mechanism: Mechanism, holding: Holding) -> Kernel:
    """Efforts for a motion; see `mafsil.mechanics.loop_efforts.inverse_function`.

    Args:
        mechanism: with loops.
        holding: how they hold it.
    """
    n, a = mechanism.n, len(holding.driven)
    inputs = {"q": (n,), "qd": (n,), "qdd": (n,)}
    outputs = {"tau": (a,), "force": (_rows_of(mechanism),), "missing": (), "broken": (), "needed": ()}
    outputs |= {"driven": (n, a), "doubt": ()}
    build = partial(_inverse, mechanism, holding)
    details = holding.rows, holding.driven, holding.deciding
    return _kernel("closed_inverse_dynamics", inputs, outputs, build, mechanism, *details)


def closing_kernel(mechanism: Mechanism, holding: Holding) -> Kernel:
    """States taken back to closed loops; see `mafsil.mechanics.tree_plant.closing_function`.

    Args:
        mechanism: with loops.
        holding: how they hold it.
    """
    n = mechanism.n
    outputs = {"here": (n,), "rate": (n,), "error": (), "doubt": ()}
    build = partial(_closing, mechanism, holding)
    return _kernel("closed_state", {"q": (n,), "qd": (n,)}, outputs, build, mechanism, holding.rows, holding.tolerance)


def following_kernel(mechanism: Mechanism, holding: Holding) -> Kernel:
    """All joints while the driven ones move; see `mafsil.mechanics.loop_efforts.following_function`.

    Args:
        mechanism: with loops.
        holding: how they hold it.
    """
    n = mechanism.n
    inputs = {"guess": (n,), "driven": (3, len(holding.driven))}
    outputs = {"q": (n,), "qd": (n,), "qdd": (n,), "doubt": ()}
    build = partial(_following, mechanism, holding)
    details = holding.rows, holding.driven, holding.tolerance
    return _kernel("closed_following", inputs, outputs, build, mechanism, *details)


def _kernel(
    name: str,
    inputs: dict[str, tuple[int, ...]],
    outputs: dict[str, tuple[int, ...]],
    build: Any,
    mechanism: Mechanism,
    *details: Rows | float,
    answer: type[tuple[Any, ...]] | None = None,
) -> Kernel:
    given, found = (tuple(Port(port, shape) for port, shape in side.items()) for side in (inputs, outputs))
    return kernels.compile(
        Signature(name, given, found),
        build,
        key=" ".join([name, fingerprint(mechanism), *map(str, details)]),
        fingerprints=(kernels.fingerprint("mafsil.algebra", "mafsil.mechanics"),),
        answer=answer,
    )


def _rows_of(mechanism: Mechanism) -> int:
    return sum(loop_constraints.rows_of(joint) for joint in mechanism.loops)


# The functions are made here; their expressions are loaded only when a kernel has to be made.
def _terms(mechanism: Mechanism) -> Any:
    return loop_constraints.function(mechanism)


def _forward(mechanism: Mechanism, rows: Rows, driven: Rows) -> Any:
    return loop_dynamics.forward_function(mechanism, rows, driven)


def _inverse(mechanism: Mechanism, holding: Holding) -> Any:
    return loop_efforts.inverse_function(mechanism, holding)


def _closing(mechanism: Mechanism, holding: Holding) -> Any:
    return held_plant.closing_function(mechanism, holding)


def _following(mechanism: Mechanism, holding: Holding) -> Any:
    return loop_efforts.following_function(mechanism, holding)
