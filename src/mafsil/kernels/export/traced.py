"""The expression of a kernel as it is exported."""

from __future__ import annotations

from mafsil.kernels.kernel import Kernel
from mafsil.kernels.reduce import reduce
from mafsil.kernels.tape import Tape, read


def tapes(kernel: Kernel) -> tuple[Tape, Tape]:
    """The kernel's expression as it is traced, and reduced as it is compiled."""
    tape = read(kernel.build())
    return tape, reduce(tape)
