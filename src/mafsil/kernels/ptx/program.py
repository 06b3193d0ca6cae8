"""A quantity as a kernel for graphics processors: its PTX text and how it is launched."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from mafsil.errors import InputError
from mafsil.expression import Function
from mafsil.kernels.identifiers import identifier
from mafsil.kernels.layout import Signature
from mafsil.kernels.ptx.grid import Plan, device_module, plan
from mafsil.kernels.reduce import reduce
from mafsil.kernels.tape import Tape, read
from mafsil.kernels.target import Target, translate

TRIPLE = "nvptx64-nvidia-cuda"
OLDEST = "sm_75"
"""PTX for this generation (Turing) runs on it and on every later one: the driver finishes the compilation."""
KNOWN = ("sm_60", "sm_70", "sm_75", "sm_80", "sm_86", "sm_89", "sm_90", "sm_100", "sm_120")


@dataclass(frozen=True)
class GridProgram:
    """PTX and what its launch needs.

    Attributes:
        name: symbol of the kernel.
        signature: ports.
        plan: threads of a block, and how rows are carried.
        text: PTX.
    """

    name: str
    signature: Signature
    plan: Plan
    text: str


def grid_program(tape: Tape, signature: Signature, name: str, processor: str = OLDEST) -> GridProgram:
    """The kernel of a tape.

    Args:
        tape: the program.
        signature: its ports.
        name: symbol of the kernel.
        processor: oldest generation that it shall run on.

    Raises:
        InputError: no such generation.
        KernelError: LLVM refuses the module.
    """
    target = nvptx(processor)
    found = plan(signature)
    text = translate(device_module(tape, signature, target, found, name), target, "assembly").decode()
    return GridProgram(name, signature, found, text)


def device_program(signature: Signature, build: Callable[[], Function]) -> GridProgram:
    """A kernel as it is launched over arrays on a device.

    Args:
        signature: its ports.
        build: makes its expression.
    """
    return grid_program(reduce(read(build())), signature, f"mafsil_{identifier(signature.name)}")


def nvptx(processor: str) -> Target:
    """A generation of graphics processors; each fuses products and sums and rounds to integers.

    Raises:
        InputError: no such generation.
    """
    if processor not in KNOWN:
        raise InputError("export.machine", name=processor, known=", ".join(KNOWN))
    return Target(TRIPLE, processor, "", 1, fma=True, rounding=True)
