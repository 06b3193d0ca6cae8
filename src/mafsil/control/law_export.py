"""A control law as files for a controller: C, object code, WebAssembly, with stored inputs and outputs as a proof."""

from __future__ import annotations

from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from mafsil import kernels
from mafsil.arrays import Floats, positive
from mafsil.control.law import Law
from mafsil.control.law_terms import law_terms
from mafsil.errors import InputError
from mafsil.kernels import Kernel, Port, Signature
from mafsil.kernels.export import Export, Legend
from mafsil.kernels.export import export as export_kernel
from mafsil.kernels.identity import content_key
from mafsil.lazy_module import lazily
from mafsil.mechanics.loop_terms import Loop, Term
from mafsil.model.fingerprint import fingerprint
from mafsil.robot import Robot, as_robot

if TYPE_CHECKING:
    import mafsil.mechanics.law_step as steps
else:
    steps = lazily("mafsil.mechanics.law_step")

PORTS = {
    "q": "measured coordinates [rad | m]",
    "qd": "measured rates [rad/s | m/s]",
    "reference": "desired positions, rates and accelerations",
    "gains": "of position, rate, and integral times the period",
    "integral": "memory of the law: zeros at first, then what the last call gave [N m | N, or accelerations]",
    "effort": "of the joints [N m | N]",
    "next_integral": "memory for the next call",
}


KNOWN_NAMES: dict[tuple[str, ...], str] = {
    ("feedback",): "pid",
    ("feedback", "gravity"): "pd_gravity",
    ("feedback", "gravity", "friction"): "pd_gravity",
    ("computed_torque", "friction"): "computed_torque",
    ("feedforward", "friction"): "feedforward",
}
"""Sums of terms that have names of their own."""


def export_law(
    robot: Robot,
    law: Law,
    *,
    period: float = 1e-3,
    saturate: bool = True,
    to: str = "c",
    target: str | None = None,
    real: str = "double",
    function: str | None = None,
) -> Export:
    """A law that is an expression as a function of fixed length: `export_law(robot, law).write("folder")`.

    One call answers one measurement: straight arithmetic without heap, recursion or loops. Gains, models and limits
    become constants. A law with an integral takes its memory as an input and gives it back.

    Args:
        robot: the arm; its effort limits clip the efforts.
        law: computed torque, feedback of the joints, feedforward, or a sum of them.
        period: between two calls [s].
        saturate: whether efforts are clipped.
        to: `c` (C99 with test vectors), `object`, `ptx` or `wasm`.
        target: processor of the object file, or oldest generation for PTX; see `mafsil.export`.
        real: `double`, or `float` for C.
        function: name of the function; made of the robot's and the law's if None.

    Raises:
        InputError: a law that is no expression, an unknown form, processor or number type, a name that C refuses.
        KernelError: the compiler refuses.
    """
    arm, h = as_robot(robot), positive("period", period)
    known = law_terms(law)
    if known is None:
        raise InputError("control.no_expression", law=type(law).__name__)
    gains = np.array([[g.kp, g.kd, h * g.ki] for g in known.gains]).reshape(-1, 3, arm.n)
    integrates = any(each.integrates for each in known.gains)
    waiting = np.stack(known.limits) if known.limits else None
    kernel = law_kernel(arm, known.terms, gains, integrates=integrates, saturate=saturate, integral_limit=waiting)
    joints = ", ".join(arm.joint_names)
    kinds = " + ".join(kind.replace("_", " ") for term in known.terms for kind in term.parts)
    words = Legend(arm.name, f"Control law ({kinds}), one call every {h:g} s. Joints: {joints}.", PORTS)
    return export_kernel(kernel, words, to, target=target, real=real, name=function)


def law_kernel(
    robot: Robot,
    terms: tuple[Term, ...],
    gains: Floats | None,
    *,
    integrates: bool,
    saturate: bool = True,
    integral_limit: Floats | None = None,
) -> Kernel:
    """A law as a kernel.

    Args:
        robot: the arm; its effort limits clip the efforts.
        terms: the law as data.
        gains: (terms with gains, 3, n) proportional, rate, integral times period; None makes them an input.
        integrates: whether it has an integral.
        saturate: whether efforts are clipped.
        integral_limit: (terms that wait, n) efforts at which integrals wait [N m | N].
    """
    limit = robot.limits.effort if saturate and np.isfinite(robot.limits.effort).any() else None
    loop = Loop(
        plant=robot.mechanism, terms=terms, shown=robot.mechanism, scheme=(), substeps=1, friction=None,
        pushed=False, noisy=False, saturated=False, integrates=integrates,
    )  # fmt: skip
    return _compiled(loop, *(None if each is None else _Constants(each) for each in (gains, limit, integral_limit)))


def _name(terms: tuple[Term, ...]) -> str:
    kinds = tuple(kind for term in terms for kind in term.parts)
    return KNOWN_NAMES.get(kinds, "_".join(kinds))


class _Constants:
    """An array that is equal to another with the same numbers."""

    def __init__(self, values: Floats) -> None:
        self.values = np.ascontiguousarray(values)
        self.key = content_key(repr(self.values.shape), self.values.tobytes().hex())

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Constants) and self.key == other.key

    def __hash__(self) -> int:
        return hash(self.key)


@lru_cache(maxsize=32)
def _compiled(
    loop: Loop, gains: _Constants | None, limit: _Constants | None, integral_limit: _Constants | None
) -> Kernel:
    constants = (gains, limit, integral_limit)
    g, *limits = (None if each is None else each.values for each in constants)
    inputs = tuple(Port(name, shape) for name, shape in steps.law_inputs(loop, g).items())
    outputs = tuple(Port(name, shape) for name, shape in steps.law_outputs(loop).items())
    terms = [term.key for term in loop.terms]
    numbers = [None if each is None else each.key for each in constants]
    return kernels.compile(
        Signature(_name(loop.terms), inputs, outputs),
        partial(_build, loop, g, *limits),
        key=f"law {fingerprint(loop.plant)} {terms} {loop.integrates} {numbers}",
        fingerprints=(kernels.fingerprint("mafsil.algebra", "mafsil.mechanics"),),
    )


def _build(loop: Loop, gains: Floats | None, limit: Floats | None, integral_limit: Floats | None) -> Any:
    return steps.law_step(loop, gains, limit, integral_limit)
