"""From a description to loaded code: found in this process, found in the cache, or built and compiled once."""

from __future__ import annotations

import atexit
import os
import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any
from weakref import WeakValueDictionary

from mafsil.code_store import warn
from mafsil.errors import KernelError
from mafsil.kernels import batch, call, image, target
from mafsil.kernels.cache import Entry, Store
from mafsil.kernels.image import Image
from mafsil.kernels.layout import Signature
from mafsil.kernels.provenance import Provenance
from mafsil.kernels.target import Target

LONGEST_COMPILATION = 60.0
"""How long the end of the process waits for a thread that compiles [s]."""


@dataclass(frozen=True)
class Order:
    """What is to be compiled.

    Attributes:
        key: content key, hexadecimal.
        signature: ports.
        build: makes the function; not called on a hit.
        target: machine; None is this one.
        store: where compiled code is kept.
    """

    key: str
    signature: Signature
    build: Callable[[], Any]
    target: Target | None
    store: Store


def obtain(order: Order) -> Image:
    """Loaded code for an order; each key is compiled once, however many threads and processes ask.

    Raises:
        KernelError: the expression has no compiled form, or the code contradicts itself.
    """
    with _lock_of(order.key):
        found = _images.get(order.key) or _from_store(order) or _compiled_once(order)
        _images[order.key] = found
        return found


def _from_store(order: Order) -> Image | None:
    """The cached code, if its canary sings."""
    entry = order.store.get(order.key)
    if entry is None:
        return None
    try:
        loaded = _load(entry.code, entry.provenance, cached=True)
        answer = image.canary_outputs(loaded, order.signature, entry.inputs)
    except KernelError:
        loaded, answer = None, None
    if loaded is not None and answer is not None and image.same_bits(answer, entry.outputs):
        return loaded
    order.store.discard(order.key)
    warn("cache.canary", name=order.signature.name)
    return None


def _compiled_once(order: Order) -> Image:
    with order.store.compiling(order.key) as waited:
        found = _from_store(order) if waited else None
        return found or _compiled(order)


def _compiled(order: Order) -> Image:
    with _llvm:
        machine = order.target or target.host()
    started = time.perf_counter()
    function = order.build()
    built = time.perf_counter()
    ir, facts = translate(function, order.signature, machine)
    lowered = time.perf_counter()
    with _llvm:
        code = target.compile(ir, machine)
    seconds = {"build": built - started, "lower": lowered - built, "compile": time.perf_counter() - lowered}
    record = Provenance(
        name=order.signature.name,
        key=order.key,
        target=f"{machine.triple} {machine.cpu}",
        lanes=machine.lanes,
        object_bytes=len(code),
        seconds=seconds,
        **facts,
    ).as_json()
    loaded = _load(code, record, cached=False)
    inputs = image.canary_inputs(order.signature)
    outputs = image.canary_outputs(loaded, order.signature, inputs)
    if outputs is None:
        raise KernelError("call.unequal", name=order.signature.name)
    order.store.put(order.key, Entry(code, inputs, outputs, record))
    return loaded


def translate(function: Any, signature: Signature, machine: Target) -> tuple[str, dict[str, Any]]:
    """LLVM IR of the whole module, and the facts of the expression for its provenance."""
    from mafsil.kernels import lower, reduce, tape

    program = reduce.reduce(tape.read(function))
    ir = lower.lower(program, signature, machine) + call.wrapper(
        signature, machine.triple, batch.rows_at_once(program.operations)
    )
    return ir, {"expression": program.hash, "operations": program.counts()}


def _load(code: bytes, record: bytes, *, cached: bool) -> Image:
    with _llvm:
        return image.load(code, record, cached=cached)


_images: WeakValueDictionary[str, Image] = WeakValueDictionary()


class _KeyLock:
    """A lock that lasts as long as somebody wants it."""

    def __init__(self) -> None:
        self._lock = threading.RLock()

    def __enter__(self) -> None:
        self._lock.acquire()

    def __exit__(self, *_exception: object) -> None:
        self._lock.release()


_locks: WeakValueDictionary[str, _KeyLock] = WeakValueDictionary()
_locking = threading.Lock()
_llvm = threading.Lock()
"""Held while LLVM works, and over a fork: a child never inherits LLVM in the middle of something."""


def _lock_of(key: str) -> _KeyLock:
    with _locking:
        lock = _locks.get(key)
        if lock is None:
            lock = _locks[key] = _KeyLock()
        return lock


def _after_fork() -> None:
    """The child's only thread is the one that forked; locks of the others would never be released."""
    global _locking
    _llvm.release()
    _locking = threading.Lock()
    _locks.clear()


def _watch_forks() -> None:
    register: Any = getattr(os, "register_at_fork", None)
    if register:
        register(before=_llvm.acquire, after_in_parent=_llvm.release, after_in_child=_after_fork)


def _wait_for_llvm() -> None:
    """Nobody compiles any more: a thread inside LLVM while the process takes LLVM down would crash it."""
    _llvm.acquire(timeout=LONGEST_COMPILATION)


_watch_forks()
atexit.register(_wait_for_llvm)
