"""From a mechanism and a row of the catalogue to a CasADi function: the only place where joint symbols are made."""

from __future__ import annotations

from typing import Any

from mafsil.kernels.layout import Port, Signature
from mafsil.mechanics.quantities import INPUTS, Quantity
from mafsil.model import Mechanism


def signature(mechanism: Mechanism, quantity: Quantity, optional: tuple[str, ...] = ()) -> Signature:
    """Names and core shapes of the kernel's inputs and output.

    Args:
        mechanism: gives the sizes.
        quantity: the row.
        optional: which optional inputs are present.
    """
    sizes = {"n": mechanism.n, "L": len(mechanism.links)}

    def sized(shape: tuple[str | int, ...]) -> tuple[int, ...]:
        return tuple(size if isinstance(size, int) else sizes[size] for size in shape)

    inputs = tuple(Port(name, sized(INPUTS[name])) for name in (*quantity.inputs, *optional))
    return Signature(quantity.name, inputs, (Port(quantity.name, sized(quantity.shape)),))


def trace(mechanism: Mechanism, quantity: Quantity, frame: str | None, optional: tuple[str, ...] = ()) -> Any:
    """The quantity as a casadi.Function of columns, results in row-major order.

    Args:
        mechanism: its numbers become constants of the expression.
        quantity: the row.
        frame: link name for framed quantities; the tip frame if None.
        optional: which optional inputs are present.
    """
    import casadi as ca

    from mafsil.mechanics.body_tree import lumped
    from mafsil.mechanics.gauge import regauged
    from mafsil.mechanics.regrouping import regrouped

    tree = regauged(lumped(mechanism))
    if quantity.regrouped:
        tree = regrouped(tree)
    ports = signature(mechanism, quantity, optional).inputs
    symbols = {port.name: ca.SX.sym(port.name, port.size) for port in ports}
    arguments: list[Any] = [symbols.get(name) for name in (*quantity.inputs, *quantity.optional)]
    if quantity.framed:
        arguments.append(tree.tip if frame is None else tree.frames[frame])
    result = quantity.build()(tree, *arguments)
    column = ca.vec(ca.SX(result).T)
    return ca.Function(quantity.name, [symbols[port.name] for port in ports], [ca.cse(column)])
