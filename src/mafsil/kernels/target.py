"""The machine that kernels are compiled for: its name, its vector lanes, and the way from IR to code in memory."""

from __future__ import annotations

import itertools
import os
import threading
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any, Literal

from mafsil.errors import KernelError
from mafsil.kernels.layout import BATCH, SINGLE
from mafsil.kernels.llvm import TargetMachine, binding

FEATURES_VARIABLE = "MAFSIL_FEATURES"
"""Environment variable with changes to the host's features, such as `-avx512f` or `-avx2,-fma`."""


@dataclass(frozen=True)
class Target:
    """A processor as LLVM names it, and how many doubles one vector operation handles.

    Attributes:
        triple: LLVM triple, such as `x86_64-unknown-linux-gnu`.
        cpu: LLVM's processor name, used for instruction costs.
        features: LLVM's feature string, `+avx2,-avx512f,...`.
        lanes: rows of a batch that are evaluated together.
        fma: the target multiplies and adds with one rounding; without it the same pairs are rounded twice.
        rounding: the target rounds to integers in one instruction.
    """

    triple: str
    cpu: str
    features: str
    lanes: int
    fma: bool
    rounding: bool

    @property
    def identity(self) -> str:
        """Text that differs whenever compiled code may differ."""
        return f"{self.triple} {self.cpu} {self.features} lanes={self.lanes}"


@dataclass(frozen=True)
class Code:
    """Machine code in memory; the addresses live as long as this object.

    Attributes:
        addresses: address of every requested symbol.
    """

    addresses: Mapping[str, int]
    owner: Any = field(repr=False, compare=False)

    @property
    def batch(self) -> int:
        """Address of the batch entry."""
        return self.addresses[BATCH]

    @property
    def single(self) -> int:
        """Address of the single entry."""
        return self.addresses[SINGLE]


def host(features: str | None = None, lanes: int | None = None) -> Target:
    """The machine this process runs on.

    Args:
        features: changes to the host's features, such as `-avx512f`; None takes the environment variable
            MAFSIL_FEATURES. Features that need a removed one are removed by LLVM too.
        lanes: rows per vector; None chooses by the widest vector unit.
    """
    changes = os.environ.get(FEATURES_VARIABLE, "") if features is None else features
    base = _host()
    if changes:
        base = emulate(base, changes)
    return base if lanes is None else replace(base, lanes=lanes)


def emulate(target: Target, changes: str) -> Target:
    """`target` with features added or removed: `+fma`, `-avx512f,-avx2`."""
    flags = dict(_flags(target.features))
    for name, sign in _flags(changes):
        flags[name] = sign
        if sign == "-":
            flags.update(dict.fromkeys(_needs(name, flags), "-"))
    joined = ",".join(sign + name for name, sign in sorted(flags.items()))
    return describe_target(target.triple, target.cpu, joined)


def describe_target(triple: str, cpu: str, features: str) -> Target:
    """The target of that name, its lanes and abilities read from the features."""
    flags = dict(_flags(features))
    x86 = triple.startswith(_X86)
    fma = flags.get("fma") == "+" if x86 else triple.startswith(("aarch64", "arm64"))
    rounding = flags.get("sse4.1") == "+" if x86 else fma
    return Target(triple, cpu, features, _lanes(x86, flags), fma, rounding)


def compile(ir: str, target: Target, effort: int = 2) -> bytes:
    """Object code of an IR module whose operations are in their order already.

    Args:
        ir: the module.
        target: the processor.
        effort: of LLVM, up to 3: scheduling again after register allocation gains batches 1 %, single calls nothing.

    Raises:
        KernelError: LLVM refuses the module.
    """
    llvm = binding()
    try:
        module = llvm.parse_assembly(ir)
        module.verify()
        return bytes(_machine(target, min(effort, _effort(ir))).emit_object(module))
    except RuntimeError as error:
        raise KernelError("kernels.refused", reason=str(error)) from None


def optimise(ir: str, target: Target, effort: int = 2) -> bytes:
    """Object code of an IR module that was written as it came: LLVM finds registers, inlines and fills vectors.

    Args:
        ir: the module.
        target: the processor.
        effort: of LLVM, up to 3.

    Raises:
        KernelError: LLVM refuses the module.
    """
    llvm = binding()
    try:
        machine = _machine(target, effort)
        module = llvm.parse_assembly(f'target datalayout = "{machine.target_data}"\n' + ir)
        module.verify()
        options = llvm.create_pipeline_tuning_options(speed_level=effort)
        options.loop_vectorization, options.slp_vectorization = True, False
        passes = llvm.create_pass_builder(machine, options)
        passes.getModulePassManager().run(module, passes)
        return bytes(machine.emit_object(module))
    except RuntimeError as error:
        raise KernelError("kernels.refused", reason=str(error)) from None


def assembly(ir: str, target: Target) -> str:
    """Assembly text of an IR module, for people."""
    module = binding().parse_assembly(ir)
    return str(_machine(target, _effort(ir)).emit_assembly(module))


def translate(
    ir: str | Sequence[str],
    target: Target,
    form: Literal["object", "assembly"],
    *,
    reloc: str = "static",
    effort: int = 2,
) -> bytes:
    """Object code or assembly text of an IR module for any processor that LLVM knows, optimised on the way.

    Args:
        ir: the module, or modules that are linked to one; their triple is the target's.
        target: the processor.
        form: what to make.
        reloc: LLVM's relocation model.
        effort: of LLVM's passes over the module; reduced tapes leave them next to nothing to do.

    Raises:
        KernelError: LLVM does not know the processor or refuses the module.
    """
    llvm = binding()
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    try:
        machine = llvm.Target.from_triple(target.triple).create_target_machine(
            cpu=target.cpu, features=target.features, opt=2, reloc=reloc, codemodel="small", jit=False
        )
        texts = [ir] if isinstance(ir, str) else ir
        parts = [llvm.parse_assembly(f'target datalayout = "{machine.target_data}"\n' + text) for text in texts]
        module = parts[0]
        for part in parts[1:]:
            module.link_in(part)
        module.verify()
        options = llvm.create_pipeline_tuning_options(speed_level=effort)
        options.slp_vectorization = options.loop_vectorization = False
        passes = llvm.create_pass_builder(machine, options)
        passes.getModulePassManager().run(module, passes)
        if form == "assembly":
            return str(machine.emit_assembly(module)).encode()
        return bytes(machine.emit_object(module))
    except RuntimeError as error:
        raise KernelError("kernels.refused", reason=str(error)) from None


def load(
    object_code: bytes, symbols: Iterable[str] = (BATCH, SINGLE), imports: Mapping[str, int] | None = None
) -> Code:
    """Bring object code into memory.

    Args:
        object_code: what `compile` returned, unchanged; LLVM does not survive damaged code, so verify a checksum first.
        symbols: names whose addresses are needed.
        imports: addresses of the external symbols that the code calls.

    Raises:
        KernelError: a symbol is missing.
    """
    llvm = binding()
    library = llvm.JITLibraryBuilder().add_object_img(object_code)
    names = tuple(symbols)
    for name in names:
        library.export_symbol(name)
    for name, address in (imports or {}).items():
        library.import_symbol(name, address)
    with _linking:
        try:
            tracker = library.link(_jit(), f"mafsil.{next(_counter)}")
        except RuntimeError as error:
            raise KernelError("kernels.refused", reason=str(error)) from None
    return Code({name: int(tracker[name]) for name in names}, tracker)


_linking = threading.Lock()
_counter = itertools.count()


@cache
def _host() -> Target:
    llvm = binding()
    return describe_target(llvm.get_process_triple(), llvm.get_host_cpu_name(), llvm.get_host_cpu_features().flatten())


def _effort(ir: str) -> int:
    """LLVM's optimisation level at most: scheduling again does not pay for long code."""
    return 2 if len(ir) < 500_000 else 1


@cache
def _machine(target: Target, effort: int) -> TargetMachine:
    return (
        binding()
        .Target.from_triple(target.triple)
        .create_target_machine(
            cpu=target.cpu, features=target.features, opt=effort, reloc="pic", codemodel="small", jit=False
        )
    )


@cache
def _jit() -> object:
    """LLVM's loader: JITLink, which keeps the sections of an object within each other's reach.

    The older one places them anywhere and aborts the process on AArch64 where two of them lie too far apart; only of
    Windows' object files it knows more.
    """
    llvm = binding()
    return llvm.create_lljit_compiler(use_jit_link="windows" not in llvm.get_process_triple())


def _flags(features: str) -> list[tuple[str, str]]:
    """(name, sign) of every entry of a feature string."""
    return [(entry[1:], entry[0]) for entry in features.replace(" ", "").split(",") if entry]


def _needs(removed: str, flags: Mapping[str, str]) -> frozenset[str]:
    """Features that make no sense without `removed`: LLVM would switch it on again for them."""
    wide = ("avx512", "avx10")
    above = {
        "avx512f": wide,
        "avx2": wide,
        "fma": (*wide, "fma4"),
        "avx": (*wide, "avx2", "fma", "f16c", "xop", "vaes", "vpclmulqdq"),
    }
    prefixes = above.get(removed, ())
    return frozenset(name for name in flags if prefixes and name.startswith(prefixes))


def _lanes(x86: bool, flags: Mapping[str, str]) -> int:
    if not x86:
        return 2
    if all(flags.get(name) == "+" for name in ("avx512f", "avx512dq", "avx512vl")):
        return 8
    return 4 if flags.get("avx2") == "+" else 2


_X86 = ("x86_64", "i686", "amd64")
