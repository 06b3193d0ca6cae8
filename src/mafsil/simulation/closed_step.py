"""One integration step of a closed chain as one kernel: accelerations, the step, and closed loops at its end."""

from __future__ import annotations

from functools import partial
from typing import TYPE_CHECKING, Any

from mafsil import kernels
from mafsil.kernels import Port, Signature
from mafsil.lazy_module import lazily
from mafsil.mechanics.friction import SMOOTHING
from mafsil.mechanics.loop_terms import Holding, Loop
from mafsil.model import Mechanism
from mafsil.model.fingerprint import fingerprint, friction_fingerprint

if TYPE_CHECKING:
    import mafsil.mechanics.held_plant as held_plant
    from mafsil.kernels import Kernel
else:
    held_plant = lazily("mafsil.mechanics.held_plant")


def step_kernel(
    mechanism: Mechanism, holding: Holding, scheme: tuple[object, ...], *, friction: bool, pushed: bool
) -> Kernel:
    """The kernel of `mafsil.mechanics.held_plant.step_function`.

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
