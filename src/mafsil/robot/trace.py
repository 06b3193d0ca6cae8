"""From a mechanism and rows of the catalogue to a function: the only place where joint symbols are made."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from mafsil.kernels.layout import Port, Signature
from mafsil.lazy_module import lazily
from mafsil.mechanics.quantity import INPUTS, Quantity
from mafsil.model import Mechanism

if TYPE_CHECKING:
    from mafsil.expression import Expression, Function

if TYPE_CHECKING:
    import mafsil.expression as ex
    import mafsil.mechanics.body_tree as body_tree
    import mafsil.mechanics.frame_choice as frame_choice
else:
    ex = lazily("mafsil.expression")
    body_tree = lazily("mafsil.mechanics.body_tree")
    frame_choice = lazily("mafsil.mechanics.frame_choice")


def signature(mechanism: Mechanism, quantity: Quantity, optional: tuple[str, ...] = ()) -> Signature:
    """Names and core shapes of the kernel's inputs and output.

    Args:
        mechanism: gives the sizes.
        quantity: the row.
        optional: which optional inputs are present.
    """
    return joint_signature(mechanism, (quantity,), optional)


def joint_signature(mechanism: Mechanism, quantities: Sequence[Quantity], optional: tuple[str, ...] = ()) -> Signature:
    """Names and core shapes of a kernel with an output for each quantity; inputs they share occur once.

    Args:
        mechanism: gives the sizes.
        quantities: the rows.
        optional: which optional inputs are present.
    """
    sizes = {"n": mechanism.n, "L": len(mechanism.links)}

    def sized(shape: tuple[str | int, ...]) -> tuple[int, ...]:
        return tuple(size if isinstance(size, int) else sizes[size] for size in shape)

    needed = dict.fromkeys(name for row in quantities for name in row.inputs)
    inputs = tuple(Port(name, sized(INPUTS[name])) for name in dict.fromkeys((*needed, *optional)))
    outputs = tuple(Port(row.name, sized(row.shape)) for row in quantities)
    return Signature("_and_".join(row.name for row in quantities), inputs, outputs, finite=True)


def trace(mechanism: Mechanism, quantity: Quantity, frame: str | None, optional: tuple[str, ...] = ()) -> Function:
    """The quantity as a function of columns, results in row-major order.

    Args:
        mechanism: its numbers become constants of the expression.
        quantity: the row.
        frame: link name for framed quantities; the tip frame if None.
        optional: which optional inputs are present.
    """
    return trace_fused(mechanism, (quantity,), frame, optional)


def trace_fused(
    mechanism: Mechanism, quantities: Sequence[Quantity], frame: str | None, optional: tuple[str, ...] = ()
) -> Function:
    """Several quantities as one function: what they have in common is there once; arguments as in `trace`."""
    tree = frame_choice.in_chosen_frames(body_tree.lump_bodies(mechanism))
    light = frame_choice.regroup(tree)
    ports = joint_signature(mechanism, quantities, optional)
    symbols = {port.name: ex.symbol(port.name, port.size) for port in ports.inputs}
    names = [row.name for row in quantities]
    columns: list[Expression] = []
    for row in quantities:
        chosen = light if row.regrouped else tree
        arguments: list[Any] = [symbols.get(name) for name in (*row.inputs, *row.optional)]
        if row.framed:
            arguments.append(chosen.tip if frame is None else chosen.frames[frame])
        columns.append(ex.vec(row.chosen_builder(names)(chosen, *arguments).T))
    return ex.Function(ports.name, list(symbols.values()), columns, cse=True)
