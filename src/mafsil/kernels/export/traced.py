"""The expression of a kernel as it is exported."""

from __future__ import annotations

from mafsil.kernels import cache, compiler
from mafsil.kernels.kernel import Kernel
from mafsil.kernels.reduce import reduce
from mafsil.kernels.tape import Tape, from_text, read


def tapes(kernel: Kernel) -> tuple[Tape, Tape]:
    """The kernel's expression as it is traced, and reduced as it is compiled."""
    tape = read(kernel.build())
    return tape, reduce(tape)


def reduced_tape(kernel: Kernel) -> Tape:
    """The kernel's reduced expression, from the store where it was traced before."""
    return from_text(compiler.tape_text(kernel.order(cache.default())))
