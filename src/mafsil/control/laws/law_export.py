"""A control law as files for a controller: C, object code, WebAssembly, with stored inputs and outputs as a proof."""

from __future__ import annotations

from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np

from mafsil import kernels
from mafsil.arrays import Floats, positive
from mafsil.control.laws.closed_chain_laws import law_terms
from mafsil.control.laws.law import Law, LawFunction, as_law
from mafsil.errors import InputError
from mafsil.kernels import Kernel, Port, Signature
from mafsil.kernels.export import Export, Legend
from mafsil.kernels.export import export as export_kernel
from mafsil.kernels.identity import content_key
from mafsil.kernels.tape import read
from mafsil.lazy_module import lazily
from mafsil.mechanics.loop_terms import Loop, Term
from mafsil.model.fingerprint import fingerprint
from mafsil.robot import Robot, as_robot

if TYPE_CHECKING:
    import mafsil.control.laws.law_trace as law_trace
    import mafsil.kernels.traced_number as traced_number
    import mafsil.mechanics.closed_loop as steps
else:
    law_trace = lazily("mafsil.control.laws.law_trace")
    traced_number = lazily("mafsil.kernels.traced_number")
    steps = lazily("mafsil.mechanics.closed_loop")

PORTS = {
    "q": "measured coordinates [rad | m]",
    "qd": "measured rates [rad/s | m/s]",
    "reference": "desired positions, rates and accelerations",
    "gains": "of position, rate, and integral times the period",
    "integral": "memory of the law: zeros at first, then what the last call gave [N m | N, or accelerations]",
    "effort": "of the joints [N m | N]",
    "next_integral": "memory for the next call",
    "motor": "measured coordinates of the motors, at the joints [rad | m]",
    "motor_rate": "measured rates of the motors, at the joints [rad/s | m/s]",
    "t": "time [s]",
    "target": "of the tip: position, then a quaternion (w, x, y, z) of any length [m]",
    "target_rate": "its velocity in the coordinates of the task, all six",
    "target_growth": "its acceleration in the coordinates of the task, all six",
    "force": "what the law's sensor reads, in its coordinates and with its sign [N m, N]",
    "acceleration": "of the tip, as it is measured, in the coordinates of the task",
    "memory": "memory of the law: zeros at first, then what the last call gave",
    "next_memory": "memory for the next call",
}
REASONS = {"decides": "control.law_decides", "leaves": "control.law_leaves", "memory": "control.law_memory"}
"""Why a law is no expression, by the reason of `Untraceable`."""


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
    law: Law | LawFunction,
    *,
    period: float = 1e-3,
    saturate: bool = True,
    to: str = "c",
    target: str | None = None,
    real: str = "double",
    function: str | None = None,
) -> Export:
    """A law as a function of fixed length: `export_law(robot, law).write("folder")`.

    One call answers one measurement: straight arithmetic without heap, recursion or loops. Gains, models and limits
    become constants. References and sensors of the tip become inputs. A law with a memory takes it as an input, zeros
    at first, and gives it back.

    Args:
        robot: the arm; its effort limits clip the efforts.
        law: any that is arithmetic of what it measures and remembers; functions of (t, q, qd, reference) too.
        period: between two calls [s].
        saturate: whether efforts are clipped.
        to: `c` (C99 with test vectors), `object`, `ptx` or `wasm`.
        target: processor of the object file, or oldest generation for PTX; see `mafsil.export`.
        real: `double`, or `float` for C.
        function: name of the function; made of the robot's and the law's if None.

    Raises:
        InputError: a law that decides by numbers, searches, or follows a course in time: it is named, with the reason;
            an unknown form, processor or number type, a name that C refuses.
        KernelError: the compiler refuses.
    """
    arm, h = as_robot(robot), positive("period", period)
    law = as_law(law)
    known = law_terms(law)
    if known is None:
        traced = _trace(law, arm, h, _limit(arm, saturate))
        kinds = " + ".join(type(part).__name__ for part in law_trace.traced_parts(law) or (law,))
        words = Legend(arm.name, _title(kinds, h, arm), _ports(traced.signature))
        return export_kernel(_kernel_of(traced), words, to, target=target, real=real, name=function)
    gains = np.array([[g.kp, g.kd, h * g.ki] for g in known.gains]).reshape(-1, 3, arm.n)
    integrates = any(each.integrates for each in known.gains)
    waiting = np.stack(known.limits) if known.limits else None
    kernel = law_kernel(arm, known.terms, gains, integrates=integrates, saturate=saturate, integral_limit=waiting)
    kinds = " + ".join(kind.replace("_", " ") for term in known.terms for kind in term.parts)
    words = Legend(arm.name, _title(kinds, h, arm), PORTS)
    return export_kernel(kernel, words, to, target=target, real=real, name=function)


def _title(kinds: str, period: float, arm: Robot) -> str:
    return f"Control law ({kinds}), one call every {period:g} s. Joints: {', '.join(arm.joint_names)}."


def _limit(arm: Robot, saturate: bool) -> Floats | None:
    return arm.limits.effort if saturate and np.isfinite(arm.limits.effort).any() else None


def _trace(law: Law, arm: Robot, period: float, limit: Floats | None) -> law_trace.TracedLaw:
    """The law as an expression, or the reason why it is none, said of the very law that has it."""
    try:
        return law_trace.traced_law(law, arm.n, period, limit, _words(type(law).__name__))
    except traced_number.Untraceable as reason:
        for part in law_trace.traced_parts(law):
            _trace(part, arm, period, limit)
        raise InputError(REASONS[reason.reason], law=type(law).__name__, what=reason.what) from None


def _words(name: str) -> str:
    """The name of a class as one of a function."""
    return "".join(f"_{c.lower()}" if c.isupper() else c for c in name).strip("_")


def _ports(signature: Signature) -> dict[str, str]:
    """What the ports mean; the second of a kind is numbered."""
    return {port.name: PORTS.get(port.name) or PORTS[port.name.rpartition("_")[0]] for port in signature.ports}


def _kernel_of(traced: law_trace.TracedLaw) -> Kernel:
    key = f"traced law {read(traced.function).hash}"
    return kernels.compile(traced.signature, partial(_given, traced.function), key=key)


def _given(function: Any) -> Any:
    return function


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
    limit = _limit(robot, saturate)
    loop = Loop(
        plant=robot.mechanism, terms=terms, shown=robot.mechanism, scheme=(), substeps=1, friction=None,
        pushed=False, noisy=False, saturated=False, integrates=integrates,
    )  # fmt: skip
    return _compile(loop, *(None if each is None else _Constants(each) for each in (gains, limit, integral_limit)))


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
def _compile(
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
