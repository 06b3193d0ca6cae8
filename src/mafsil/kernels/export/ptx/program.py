"""A quantity as a kernel for graphics processors: its PTX text and how it is launched."""

from __future__ import annotations

from dataclasses import dataclass

from mafsil.errors import InputError
from mafsil.kernels.export.legend import wrapped
from mafsil.kernels.export.ptx.grid import device_module
from mafsil.kernels.export.ptx.tiles import Plan, plan
from mafsil.kernels.layout import Signature
from mafsil.kernels.tape import Tape
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


def nvptx(processor: str) -> Target:
    """A generation of graphics processors; each fuses products and sums and rounds to integers.

    Raises:
        InputError: no such generation.
    """
    if processor not in KNOWN:
        raise InputError("export.machine", name=processor, known=", ".join(KNOWN))
    return Target(TRIPLE, processor, "", 1, fma=True, rounding=True)


def launch_notes(program: GridProgram) -> tuple[str, ...]:
    """How others launch it, for the comment at the head of the file."""
    inputs = [f"{p.name} pointer, divisor, modulus (64 bits each)" for p in program.signature.inputs]
    outputs = [f"{p.name} pointer" for p in program.signature.outputs]
    return (
        f"Kernel {program.name}: {program.plan.threads} threads in a block, (rows + {program.plan.threads - 1}) / "
        f"{program.plan.threads} blocks, no dynamic shared memory.",
        *wrapped(f"Parameters: {'; '.join([*inputs, *outputs, 'rows (64 bits)'])}.", "  "),
        "Rows lie one after another without gaps. Row r of the batch takes row r of an input whose modulus is 0,",
        "and row (r / divisor) mod modulus of one that is broadcast; the divisor is 1 or more.",
    )
