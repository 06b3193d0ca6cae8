"""From a description to loaded code: found in this process, found in the cache, or traced and compiled once.

1. The words for an expression lead to its tape: from the cache, or traced and reduced (`obtain`).
2. The tape leads to the code of a part of the kernel: from the cache, if its canary sings, or compiled (`_make`).
3. Batch entry, single entry and the one for lanes must give the same bits: each is held against another.
"""

from __future__ import annotations

import atexit
import gc
import json
import os
import threading
import time
from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any
from weakref import WeakValueDictionary

from mafsil.code_store import compilation, warn
from mafsil.errors import KernelError
from mafsil.kernels import cache, elf, identity, image, runtime, target
from mafsil.kernels.cache import Entry, KernelRecord, Store, TapeEntry
from mafsil.kernels.call import CALL
from mafsil.kernels.image import Image, Part
from mafsil.kernels.layout import BATCH, LANES, SINGLE, Signature
from mafsil.kernels.target import Target
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.kernels.lower as translation
else:
    translation = lazily("mafsil.kernels.lower")

LONGEST_COMPILATION = 60.0
"""How long the end of the process waits for a thread that compiles [s]."""


@dataclass(frozen=True)
class Order:
    """What is to be compiled.

    Attributes:
        key: of the tape, hexadecimal.
        signature: ports.
        build: makes the function; not called where the tape is in the cache.
        target: machine; None is this one.
        store: where tapes and code are kept.
    """

    key: str
    signature: Signature
    build: Callable[[], Any]
    target: Target | None
    store: Store

    @property
    def machine(self) -> str:
        """What the code depends on besides the tape."""
        return identity.machine() if self.target is None else self.target.identity

    def object_key(self, part: str, hash: str) -> str:
        """Key of the code of a part.

        Args:
            part: BATCH, SINGLE, LANES or CALL.
            hash: of the tape.
        """
        return identity.object_key(part, "" if part == CALL else hash, self.signature, self.machine)


def obtain(order: Order) -> Image:
    """The image of an order, its parts still to come; each tape is traced once, however many threads and processes ask.

    Raises:
        KernelError: the expression has no compiled form.
    """
    known = order.key + order.machine
    with _lock_of(order.key):
        found = _images.get(known)
        if found is None:
            entry = order.store.get_tape(order.key) or _traced_once(order)
            origin = KernelRecord(
                name=order.signature.name,
                key=order.key,
                expression=entry.hash,
                operations=entry.operations,
                seconds={"build": entry.seconds},
            )
            found = _images[known] = Image(partial(_put, order), entry, origin, order.signature)
        return found


def tape_text(order: Order) -> str:
    """The reduced tape of an order as text, traced at most once.

    Raises:
        KernelError: the expression has no compiled form.
    """
    return _tape_text(order, obtain(order))


def _traced_once(order: Order) -> TapeEntry:
    with order.store.compiling(order.key) as waited:
        found = order.store.get_tape(order.key) if waited else None
        return found or _trace(order)


def _trace(order: Order) -> TapeEntry:
    """The expression built, read and reduced."""
    started = time.perf_counter()
    with _no_collection():
        program = translation.trace_function(order.build())
    seconds = time.perf_counter() - started
    entry = TapeEntry(program.hash, program.counts(), seconds, cache.pack_tape(program.text))
    order.store.put_tape(order.key, entry)
    return entry


@contextmanager
def _no_collection() -> Generator[None, None, None]:
    """Python looks for no circles of garbage: among the many small objects of expressions and tapes there are none."""
    enabled = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if enabled:
            gc.enable()


def _put(order: Order, whole: Image, name: str, compiles: bool) -> None:
    """Make a part, or only look for it in the store, and put it in its place, unless another thread has done so.

    Raises:
        KernelError: LLVM refuses the code, or it contradicts the other part.
    """
    with _lock_of(order.key):
        if name not in whole.parts:
            made = _make(order, whole, name, compiles)
            if made is not None:
                whole.add(name, made)


def _make(order: Order, whole: Image, name: str, compiles: bool) -> Part | None:
    key = order.object_key(name, whole.hash)
    found = _from_store(order, whole, name, key)
    if found is None and compiles:
        with order.store.compiling(key) as waited:
            found = _from_store(order, whole, name, key) if waited else None
            if found is None:
                with compilation(order.signature.name):
                    found = _compiled(order, whole, name, key)
    return found


def _from_store(order: Order, whole: Image, name: str, key: str) -> Part | None:
    """The cached code, if its canary sings, and the same song as the other part's."""
    entry = order.store.get(key)
    if entry is None:
        return None
    try:
        part = _load(order, name, entry, cached=True)
    except KernelError:
        part = None
    known = whole.parts.get(_OTHER.get(name, ""))
    if part is not None and (known is None or image.same_bits(part.answers, known.answers)):
        return part
    order.store.discard(key)
    warn("cache.canary", name=order.signature.name)
    return None


def _compiled(order: Order, whole: Image, name: str, key: str) -> Part:
    with _llvm:
        machine = order.target or target.host()
    started = time.perf_counter()
    with _no_collection():
        program = _tape_text(order, whole) if name != CALL else None
        ir = translation.translate(name, program, order.signature, machine)
    lowered = time.perf_counter()
    with _llvm:
        code = target.compile(ir, machine, 1 if name in (SINGLE, CALL) else 2)
    record = KernelRecord(
        name=order.signature.name,
        key=key,
        target=f"{machine.triple} {machine.cpu}",
        lanes=machine.lanes,
        object_bytes=len(code),
        seconds={"lower": lowered - started, "compile": time.perf_counter() - lowered},
    ).as_json()
    inputs = b"" if name == CALL else image.canary_inputs(order.signature)
    part = _load(order, name, Entry(code, inputs, b"", record), cached=False)
    others = _other_answers(order, whole, name)
    if part is None or not (others is None or image.same_bits(part.answers, others)):
        raise KernelError("call.unequal", name=order.signature.name)
    order.store.put(key, Entry(code, inputs, part.answers, record))
    return part


def _tape_text(order: Order, whole: Image) -> str:
    """The tape, read from the cache or, where it is there no more, traced again."""
    entry = order.store.get_tape(order.key)
    text = entry.text() if entry is not None and entry.hash == whole.hash else None
    if text is None:
        order.store.discard(order.key)
        entry = _trace(order)
        text = entry.text() if entry.hash == whole.hash else None
    if text is None:
        raise KernelError("call.unequal", name=order.signature.name)
    return text


def _other_answers(order: Order, whole: Image, name: str) -> bytes | None:
    """The answers of another entry to the canary, where they are known."""
    other = _OTHER.get(name, "")
    if not other:
        return None
    if other in whole.parts:
        return whole.parts[other].answers
    entry = order.store.get(order.object_key(other, whole.hash))
    return None if entry is None else entry.outputs


def _load(order: Order, name: str, entry: Entry, *, cached: bool) -> Part | None:
    imports = shared_code(order.target, order.store)
    with _llvm:
        return image.load(name, entry, order.signature, imports, cached=cached)


def shared_code(machine: Target | None = None, store: Store | None = None) -> Mapping[str, int]:
    """Addresses of what all kernels of a processor call (`lower.shared_module`), compiled once, kept for the process.

    Args:
        machine: the processor; None is this one.
        store: where the code is kept; None is that of this process.
    """
    words = identity.machine() if machine is None else machine.identity
    key = identity.object_key("shared", "", Signature("shared", (), ()), words)
    kept = store or cache.default()
    with _lock_of(key):
        if (key, kept) not in _in_stores:
            entry = kept.get(key) or _put_shared(key, kept, machine)
            _in_stores.add((key, kept))
            if key not in _shared:
                _shared[key] = entry, _load_shared(entry)
        return _shared[key][1]


def _put_shared(key: str, store: Store, machine: Target | None) -> Entry:
    """Put the code that all kernels call into a store, as one process of all that ask at the same time."""
    with store.compiling(key) as waited:
        entry = store.get(key) if waited else None
        if entry is None:
            with _llvm:
                entry = _shared[key][0] if key in _shared else _compile_shared(machine or target.host())
            store.put(key, entry)
    return entry


def _load_shared(entry: Entry) -> Mapping[str, int]:
    symbols: list[str] = json.loads(entry.provenance)
    with _llvm:
        loaded = elf.load(entry.code, symbols) or target.load(entry.code, symbols)
    runtime.forever(loaded)
    return loaded.addresses


def _compile_shared(machine: Target) -> Entry:
    ir, symbols = translation.shared_module(machine)
    return Entry(target.compile(ir, machine), b"", b"", json.dumps(symbols).encode())


_shared: dict[str, tuple[Entry, Mapping[str, int]]] = {}
_in_stores: set[tuple[str, Store]] = set()
"""Which stores have it, so that a later process need not compile it."""


_OTHER = {BATCH: SINGLE, SINGLE: BATCH, LANES: BATCH}
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
