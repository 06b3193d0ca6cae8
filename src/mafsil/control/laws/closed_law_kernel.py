"""Efforts of a law of a closed chain by one kernel: feedback of the driven joints and the dynamics behind it."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import TYPE_CHECKING, Any

from mafsil import kernels
from mafsil.kernels import Kernel, Port, Signature
from mafsil.lazy_module import lazily
from mafsil.mechanics.loop_terms import Loop, Term, input_sizes
from mafsil.model import Mechanism
from mafsil.model.fingerprint import fingerprint

if TYPE_CHECKING:
    import mafsil.mechanics.law_step as steps
else:
    steps = lazily("mafsil.mechanics.law_step")

Run = Callable[..., Any]


def law_kernel(mechanism: Mechanism, terms: tuple[Term, ...]) -> Kernel:
    """The kernel of `mafsil.mechanics.law_step.closed_law`.

    Args:
        mechanism: with loops.
        terms: of the law.
    """
    loop = Loop(
        plant=mechanism, terms=terms, shown=mechanism, scheme=(), substeps=1, friction=None, pushed=False,
        noisy=False, saturated=False, integrates=False,
    )  # fmt: skip
    n = mechanism.n
    inputs = (*(Port(name, (n,)) for name in ("q", "qd", "u", "v", "a")), Port("gains", input_sizes(loop)["gains"]))
    parts = [
        (term.kind, None if term.model is None else fingerprint(term.model), term.holding, term.waits) for term in terms
    ]
    return kernels.compile(
        Signature("closed_law", inputs, (Port("effort", (n,)), Port("doubt", ()))),
        partial(_build, loop),
        key=f"closed_law {fingerprint(mechanism)} {parts}",
        fingerprints=(kernels.fingerprint("mafsil.algebra", "mafsil.mechanics"),),
    )


# Its expressions are loaded only when a kernel has to be made.
def _build(loop: Loop) -> Any:
    return steps.closed_law(loop)
