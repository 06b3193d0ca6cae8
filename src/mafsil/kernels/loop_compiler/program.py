"""Modules of loops as one piece of machine code: kept on disk by their sources, compiled when it is not there."""

from __future__ import annotations

import ast
import ctypes
import hashlib
import threading
from collections.abc import Callable, Sequence
from importlib import import_module
from pathlib import Path
from typing import Any

from mafsil.kernels import cache, elf, identity, target
from mafsil.kernels.cache import Entry
from mafsil.kernels.compiler import _llvm  # pyright: ignore[reportPrivateUsage]
from mafsil.kernels.lazy import lazy
from mafsil.kernels.loop_compiler.functions import Function
from mafsil.kernels.loop_compiler.headers import Header, header_of
from mafsil.kernels.loop_compiler.records import Record
from mafsil.kernels.loop_compiler.values import INTEGER, REAL, TAGS, TRUTH, Kind, Layout, kind_of, refused
from mafsil.kernels.target import Code, Target

_DECLARED = """
declare double @llvm.sqrt.f64(double)
declare double @llvm.fabs.f64(double)
declare float @llvm.fabs.f32(float)
declare double @llvm.copysign.f64(double, double)
attributes #0 = { nounwind "no-builtins" }
"""
"""Without builtins LLVM makes no calls of the system's library out of loops: the code refers to nothing outside."""


class LoopProgram:
    """Functions of some modules, compiled together; which robot they work for they learn from their arguments.

    Args:
        modules: dotted names; their top level holds nothing but imports, constants, records and functions of the
            language.
        entries: the functions that are called from Python.
    """

    def __init__(self, modules: Sequence[str], entries: Sequence[str]) -> None:
        self._modules, self._entries = tuple(modules), tuple(entries)
        self._lock = threading.Lock()

    def __getitem__(self, entry: str) -> Callable[..., Any]:
        """The compiled function, called with numbers and addresses of arrays; it runs without Python's lock."""
        return self._functions[entry]

    @lazy
    def _functions(self) -> dict[str, Callable[..., Any]]:
        with self._lock:
            code = self._code()
        headers = self._headers()
        functions = {name: _prototype(headers[name])(code.addresses[name]) for name in self._entries}
        _kept.append(code)
        return functions

    def ir(self, machine: Target) -> str:
        """The program in LLVM's language.

        Args:
            machine: for which it is compiled.
        """
        headers, records, texts = self._headers(), self._records, list[str]()
        for tree, constants in self._sources.values():
            for node in _functions_of(tree):
                texts.append(Function(node, headers, constants, records).text(exported=node.name in self._entries))
        return f'target triple = "{machine.triple}"\n' + "".join(texts) + _DECLARED + TAGS

    @lazy
    def _sources(self) -> dict[str, tuple[ast.Module, dict[str, int | float]]]:
        """Syntax and constants of every module; constants imported from another one of them count too."""
        found: dict[str, tuple[ast.Module, dict[str, int | float]]] = {}
        for name, text in self._texts.items():
            tree = ast.parse(text)
            names = {each.id for each in ast.walk(tree) if isinstance(each, ast.Name)}
            values = {key: vars(import_module(name)).get(key) for key in names}
            found[name] = tree, {key: x for key, x in values.items() if isinstance(x, int | float)}
        return found

    @lazy
    def _texts(self) -> dict[str, str]:
        return {name: Path(import_module(name).__file__ or "").read_text("utf-8") for name in self._modules}

    def _headers(self) -> dict[str, Header]:
        nodes = [node for tree, _ in self._sources.values() for node in _functions_of(tree)]
        return {node.name: header_of(node, self._records) for node in nodes}

    @lazy
    def _records(self) -> dict[str, Layout]:
        """The records that are declared in the modules."""
        declared = [each for name in self._modules for each in vars(import_module(name)).values()]
        found = {each.__name__: each.layout for each in declared if isinstance(each, type) and issubclass(each, Record)}
        found.pop(Record.__name__, None)
        return {
            name: {field: kind_of(annotation, found) for field, annotation in layout.items()}
            for name, layout in found.items()
        }

    def _code(self) -> Code:
        """The code from the disk, or made."""
        store, key = cache.default(), self._key()
        entry = store.get(key)
        if entry is None:
            with _llvm:
                machine = target.host()
                entry = Entry(target.optimised(self.ir(machine), machine), b"", b"", b"{}")
            store.put(key, entry)
        with _llvm:
            return elf.load(entry.code, self._entries) or target.load(entry.code, self._entries)

    def _key(self) -> str:
        """Name of the code in the store: of its sources, this compiler's, LLVM's release and the processor."""
        hashed = hashlib.blake2b(digest_size=32)
        made_by = identity.fingerprint("mafsil.kernels"), identity.toolchain(), identity.machine()
        for part in (*self._texts.values(), *self._entries, *made_by):
            hashed.update(len(part.encode()).to_bytes(8, "little") + part.encode())
        return hashed.hexdigest()


def _functions_of(tree: ast.Module) -> list[ast.FunctionDef]:
    return [node for node in tree.body if isinstance(node, ast.FunctionDef)]


def _prototype(header: Header) -> Any:
    """The function as ctypes calls it."""
    kinds = [_ctype(kind) for kind in header.arguments.values()]
    return ctypes.CFUNCTYPE(None if header.result is None else _ctype(header.result), *kinds)


def _ctype(kind: Kind) -> Any:
    known = {INTEGER: ctypes.c_int64, REAL: ctypes.c_double, TRUTH: ctypes.c_bool}
    if not kind.address and kind not in known:
        raise refused(f"{kind.llvm} as an argument from outside")
    return ctypes.c_void_p if kind.address else known[kind]


_kept: list[object] = []
"""Code that lives as long as the process."""
