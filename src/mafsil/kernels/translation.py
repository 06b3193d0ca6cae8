"""From an expression to LLVM IR: what is loaded only where something has to be compiled.

1. The function is read into a tape and reduced (`trace_function`).
2. The tape is printed as the IR of one part of a kernel (`translate`).

Kernels from the cache need neither. `compiler` imports this module when it must: with the expressions, the rules of
reduction and the printers of IR it takes 30 ms, more than all the rest of a start.
"""

from __future__ import annotations

from mafsil.expression import Function
from mafsil.kernels import call
from mafsil.kernels.call import CALL
from mafsil.kernels.layout import BATCH, Signature
from mafsil.kernels.lower import lower
from mafsil.kernels.reduce import reduce
from mafsil.kernels.tape import Tape, from_text, read
from mafsil.kernels.target import Target


def trace_function(function: Function) -> Tape:
    """The reduced tape of a function.

    Args:
        function: whose ports are columns.

    Raises:
        KernelError: an operation has no compiled form.
    """
    return reduce(read(function))


def translate(part: str, program: str | None, signature: Signature, machine: Target) -> str:
    """LLVM IR of the module of a part.

    Args:
        part: BATCH, SINGLE, LANES or CALL.
        program: text of the reduced tape; None for CALL, which does no arithmetic.
        signature: ports.
        machine: to compile for.
    """
    if program is None or part == CALL:
        return call.wrapper(signature, machine.triple)
    ir = lower(from_text(program), signature, machine, (part,))
    return ir + call.loop(machine.triple) if part == BATCH else ir
