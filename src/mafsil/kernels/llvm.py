"""The one door to llvmlite, which carries no types: what this package uses of its binding, as protocols.

LLVM is loaded at the first call of `binding`, not at import: kernels from the cache start without it (`elf`).
"""

from __future__ import annotations

from contextlib import suppress
from functools import cache
from importlib import import_module
from typing import Any, Protocol


class Module(Protocol):
    """A module of LLVM IR in memory."""

    def verify(self) -> None:
        """Raise a RuntimeError if the IR is ill-formed."""
        ...

    def link_in(self, other: Module) -> None:
        """Take in the functions of another module, which is used up."""
        ...


class TargetMachine(Protocol):
    """LLVM's code generator for one processor."""

    @property
    def target_data(self) -> object:
        """Sizes and alignments of types; as text the `target datalayout` of a module."""
        ...

    def emit_object(self, module: Module) -> bytes:
        """Object code."""
        ...

    def emit_assembly(self, module: Module) -> str:
        """Assembly text."""
        ...


class Target(Protocol):
    """A processor family that this LLVM was built for."""

    def create_target_machine(
        self, *, cpu: str, features: str, opt: int, reloc: str, codemodel: str, jit: bool
    ) -> TargetMachine:
        """The code generator; `opt` from 0 to 3 is its effort."""
        ...


class Targets(Protocol):
    """Where processor families are found."""

    def from_triple(self, triple: str) -> Target:
        """The family of a triple; a RuntimeError if there is none."""
        ...


class TuningOptions(Protocol):
    """Which passes of the optimiser run."""

    loop_vectorization: bool
    slp_vectorization: bool


class PassManager(Protocol):
    """A sequence of passes."""

    def run(self, module: Module, builder: PassBuilder) -> None:
        """Rewrite the module."""
        ...


class PassBuilder(Protocol):
    """Makes sequences of passes."""

    def getModulePassManager(self) -> PassManager:
        """The passes that the options ask for."""
        ...


class Library(Protocol):
    """Object code that is being linked."""

    def add_object_img(self, code: bytes) -> Library:
        """The library with this object file."""
        ...

    def export_symbol(self, name: str) -> object:
        """Make a symbol's address known afterwards."""
        ...

    def import_symbol(self, name: str, address: int) -> object:
        """Give an external symbol its address."""
        ...

    def link(self, jit: object, name: str) -> Tracker:
        """Bring the code into memory; a RuntimeError if a symbol is missing."""
        ...


class Tracker(Protocol):
    """Linked code, alive as long as this object."""

    def __getitem__(self, name: str) -> int: ...


class Features(Protocol):
    """What a processor can do."""

    def flatten(self) -> str:
        """Such as `+avx2,-avx512f`."""
        ...


class Binding(Protocol):
    """The functions of `llvmlite.binding` in use."""

    Target: Targets

    def initialize(self) -> None: ...
    def initialize_native_target(self) -> None: ...
    def initialize_native_asmprinter(self) -> None: ...
    def initialize_all_targets(self) -> None: ...
    def initialize_all_asmprinters(self) -> None: ...
    def get_process_triple(self) -> str: ...
    def get_host_cpu_name(self) -> str: ...
    def get_host_cpu_features(self) -> Features: ...
    def parse_assembly(self, ir: str) -> Module: ...
    def create_pipeline_tuning_options(self, *, speed_level: int) -> TuningOptions: ...
    def create_pass_builder(self, machine: TargetMachine, options: TuningOptions) -> PassBuilder: ...
    def create_lljit_compiler(self, *, use_jit_link: bool) -> object: ...
    def JITLibraryBuilder(self) -> Library: ...


@cache
def binding() -> Binding:
    """llvmlite's binding, ready to compile for this machine."""
    found: Any = import_module("llvmlite.binding")
    with suppress(RuntimeError):  # llvmlite >= 0.45 initialises itself and says so by raising
        found.initialize()
    found.initialize_native_target()
    found.initialize_native_asmprinter()
    return found
