"""Quantities of a mechanism as compiled kernels, found by the content of the mechanism."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

from mafsil.errors import ModelError
from mafsil.kernels.identity import meaning
from mafsil.kernels.kernel import Kernel, compile
from mafsil.mechanics.catalogue import quantity
from mafsil.mechanics.quantity import Quantity
from mafsil.model import Mechanism
from mafsil.model.fingerprint import fingerprint
from mafsil.robot.trace import joint_signature, signature, trace, trace_fused

SOURCES = ("mafsil.algebra", "mafsil.mechanics")
"""Packages whose code shapes the expressions: where a builder's own code or what it imports changes, it is traced anew.
"""
BESIDE = (
    "mafsil.mechanics.catalogue", "mafsil.mechanics.quantity", "mafsil.mechanics.arm_size", "mafsil.mechanics.quantity",
    "mafsil.mechanics.textbook",
)  # fmt: skip
"""What the files of quantities import for their rows: it shapes no expression."""


def compile_quantity(
    mechanism: Mechanism,
    name: str,
    frame: str | None = None,
    optional: tuple[str, ...] = (),
    fallback: Callable[..., Any] | None = None,
    recipe: tuple[Callable[..., Kernel], tuple[Any, ...]] | None = None,
) -> Kernel:
    """The kernel of a quantity; machine code is made or loaded at its first use.

    Args:
        mechanism: its numbers become constants of the code.
        name: a name of the catalogue.
        frame: link name for framed quantities; the tip frame if None.
        optional: which optional inputs are present.
        fallback: see `Kernel`.
        recipe: how the kernel pickles, if it must come back with its fallback.
    """
    row = quantity(name)
    _require_joints(mechanism)
    return compile(
        signature(mechanism, row, optional),
        partial(trace, mechanism, row, frame, optional),
        key=f"{fingerprint(mechanism)} {name} {frame!r} {optional}",
        fingerprints=_sources(row),
        doc=row.doc(),
        parameters=row.parameters,
        fallback=fallback,
        recipe=recipe or (compile_quantity, (mechanism, name, frame, optional)),
    )


def compiled_fused(
    mechanism: Mechanism, names: tuple[str, ...], frame: str | None = None, optional: tuple[str, ...] = ()
) -> Kernel:
    """One kernel with an output for each quantity: what they have in common is computed once.

    Args:
        mechanism: its numbers become constants of the code.
        names: of the catalogue.
        frame: link name for the framed quantities among them; the tip frame if None.
        optional: which optional inputs are present.
    """
    rows = [quantity(name) for name in names]
    _require_joints(mechanism)
    return compile(
        joint_signature(mechanism, rows, optional),
        partial(trace_fused, mechanism, rows, frame, optional),
        key=f"{fingerprint(mechanism)} {names} {frame!r} {optional}",
        fingerprints=_sources(*rows),
        doc="At the same state:\n\n" + "\n".join(f"{row.symbol}: {row.title} [{row.unit}]" for row in rows),
        recipe=(compiled_fused, (mechanism, names, frame, optional)),
    )


def _sources(*rows: Quantity) -> tuple[str, ...]:
    """What shapes the expressions of quantities besides the robot: the code of their builders, and their rows."""
    roots = ("mafsil.robot.trace", *sorted({row.home for row in rows}))
    details = [(r.name, r.home, r.inputs, r.optional, r.shape, r.framed, r.regrouped) for r in rows]
    return repr(details), meaning(roots, SOURCES, BESIDE)


def _require_joints(mechanism: Mechanism) -> None:
    if not mechanism.n:
        raise ModelError("robot.no_joints", robot=mechanism.name)
