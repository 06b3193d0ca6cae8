"""Many kernels in one WebAssembly module, with their ports as data: what a page in a browser computes with."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

from mafsil.code_store import FileStore, StoreKind, code_folder
from mafsil.errors import InputError
from mafsil.kernels import cache as kernel_cache
from mafsil.kernels.argument import HUGE_VALUE
from mafsil.kernels.export.legend import symbol
from mafsil.kernels.export.objects.machines import machine
from mafsil.kernels.export.objects.wasm import constants_size, loadable
from mafsil.kernels.export.traced import reduced_tape
from mafsil.kernels.identity import content_key, fingerprint, toolchain
from mafsil.kernels.kernel import Kernel
from mafsil.kernels.layout import Port, Signature
from mafsil.kernels.lower import point
from mafsil.kernels.target import Target, translate

BUNDLE = StoreKind(b"mafsilW\0", ".bundle")
"""A module and its ports."""
STACK = 1 << 18
"""Bytes of stack below everything else: a kernel that needed more would trap, not overwrite anything."""
_PAGE = 1 << 16


@dataclass(frozen=True)
class Bundle:
    """A WebAssembly module and what must be known to call it.

    Attributes:
        code: the module; it imports env.__linear_memory and, where a kernel needs it, env.__stack_pointer.
        layout: plain data: `memory` with the number of `pages`, the initial `stack` pointer and the `first` free byte;
            `kernels`, by name the `inputs` and `outputs`, each a name and a shape. A kernel takes one address of
            doubles for each input, then for each output.
    """

    code: bytes
    layout: Mapping[str, Any]


def bundle(kernels: Mapping[str, Kernel]) -> Bundle:
    """One module of many kernels, kept by content: names, expressions, compiler.

    Without fused products, so that it gives the bits of kernels compiled for `Target`s without them.

    Args:
        kernels: by the name of the exported function.

    Raises:
        InputError: a name that C refuses, a port of size zero.
        KernelError: LLVM refuses the module.
    """
    for name, kernel in kernels.items():
        symbol("", "", name)
        _require_numbers(kernel.signature)
    words = [f"{name} {kernel.order(kernel_cache.default()).key}" for name, kernel in kernels.items()]
    key = content_key("bundle", *words, machine("wasm32").target.identity, fingerprint("mafsil.kernels"), toolchain())
    store = _store()
    code = store.get(key)
    if code is None:
        code = _compile(kernels)
        store.put(key, code)
    return Bundle(code, layout({name: kernel.signature for name, kernel in kernels.items()}, code))


def layout(signatures: Mapping[str, Signature], code: bytes) -> dict[str, Any]:
    """The data that goes with a module whose constants lie above the stack.

    Args:
        signatures: by the name of the exported function.
        code: the module.
    """
    first = -(-(STACK + constants_size(code)) // 16) * 16
    need = max((8 * sum(port.size for port in s.ports) for s in signatures.values()), default=0)
    return {
        "memory": {"pages": -(-(first + need) // _PAGE) + 1, "stack": STACK, "first": first},
        "kernels": {name: {"inputs": _ports(s.inputs), "outputs": _ports(s.outputs)} for name, s in signatures.items()},
    }


def layout_text(found: Bundle) -> str:
    """The layout as JSON."""
    return json.dumps(found.layout, indent=1) + "\n"


def _ports(ports: tuple[Port, ...]) -> list[dict[str, Any]]:
    return [{"name": port.name, "shape": list(port.shape)} for port in ports]


def _require_numbers(signature: Signature) -> None:
    for port in signature.ports:
        if not port.size:
            raise InputError("export.empty_port", kernel=signature.name, port=port.name)


def _compile(kernels: Mapping[str, Kernel]) -> bytes:
    """The module: every kernel's own module, linked by LLVM, constants moved above the stack."""
    chosen = machine("wasm32")
    texts = [_module(name, kernel, chosen.target) for name, kernel in kernels.items()]
    texts[0] = chosen.runtime + texts[0]
    triple = f'target triple = "{chosen.target.triple}"\n'
    code = translate([triple + text for text in texts], chosen.target, "object", effort=0)
    return loadable(code, list(kernels), STACK)


def _module(name: str, kernel: Kernel, target: Target) -> str:
    """One evaluation; what reduces huge angles is shared by all modules that are linked.

    Long ones are cut: one pass of LLVM for WebAssembly takes time with the square of a function's length.
    """
    text = point(reduced_tape(kernel), kernel.signature, target, name, cut=True)
    shared = [
        line.replace("define internal", "define linkonce_odr hidden") if f"@{HUGE_VALUE}(" in line else line
        for line in text.split("\n")
    ]
    return "\n".join(shared)


@cache
def _store() -> FileStore:
    return FileStore(code_folder(), BUNDLE)
