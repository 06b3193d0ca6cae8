"""The processors that kernels are exported to, as LLVM names them."""

from __future__ import annotations

from dataclasses import dataclass

from mafsil.errors import InputError
from mafsil.kernels.export.objects.wasm import WASM_RUNTIME
from mafsil.kernels.target import Target, describe_target, host


@dataclass(frozen=True)
class Machine:
    """A processor for which object files are made.

    Attributes:
        name: how users call it.
        target: how LLVM calls it, and what it can.
        lanes: batches are evaluated by vectors of rows; else row by row.
        bits: of a pointer.
        abi: LLVM's name of the calling convention, where it must be said.
        outside: beginnings of the names that a linker finds in the processor's own run-time library.
        runtime: IR of what others call from such a library, brought along where none can be expected.
    """

    name: str
    target: Target
    lanes: bool
    bits: int = 64
    abi: str = ""
    outside: tuple[str, ...] = ()
    runtime: str = ""


def _bare(triple: str, cpu: str, features: str, *, fma: bool, rounding: bool) -> Target:
    return Target(triple, cpu, features, 1, fma, rounding)


def machine(name: str) -> Machine:
    """The processor of that name; `host` is the one that runs this.

    Raises:
        InputError: the name is not known; the sentence lists what is.
    """
    if name == "host":
        return Machine("host", host(), lanes=True)
    if name not in MACHINES:
        raise InputError("export.machine", name=name, known=", ".join(["host", *MACHINES]))
    return MACHINES[name]


_LINUX_X86 = "x86_64-unknown-linux-gnu"
_AVX2 = "+avx,+avx2,+bmi,+bmi2,+fma,+lzcnt,+movbe,+popcnt,+sse3,+ssse3,+sse4.1,+sse4.2"

MACHINES: dict[str, Machine] = {
    item.name: item
    for item in (
        Machine("x86-64", describe_target(_LINUX_X86, "x86-64", "+sse2"), lanes=True),
        Machine("x86-64-avx2", describe_target(_LINUX_X86, "haswell", _AVX2), lanes=True),
        Machine("aarch64", describe_target("aarch64-unknown-linux-gnu", "generic", "+neon"), lanes=True),
        Machine(
            "cortex-m4f",
            _bare("thumbv7em-unknown-none-eabihf", "cortex-m4", "", fma=False, rounding=False),
            lanes=False,
            bits=32,
            outside=("__aeabi_", "sqrt"),
        ),
        Machine(
            "cortex-m7",
            _bare("thumbv7em-unknown-none-eabihf", "cortex-m7", "", fma=True, rounding=True),
            lanes=False,
            bits=32,
            outside=("__aeabi_",),
        ),
        Machine(
            "riscv64",
            _bare("riscv64-unknown-none-elf", "generic-rv64", "+m,+a,+f,+d,+c", fma=True, rounding=False),
            lanes=False,
            abi="lp64d",
        ),
        Machine(
            "wasm32",
            _bare("wasm32-unknown-unknown", "generic", "", fma=False, rounding=True),
            lanes=False,
            bits=32,
            runtime=WASM_RUNTIME,
        ),
    )
}
"""By name; WebAssembly has no fused product and sum, a Cortex-M4F computes doubles in software."""
