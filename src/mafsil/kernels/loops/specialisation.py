"""A loop for some kinds of arguments: translated, compiled, kept on disk, in memory.

1. Its key is its meaning, the kinds, the compiler and the processor; what is kept under it is its machine code and
   what callers know of it.
2. Short functions become part of the modules of their callers, where LLVM may inline them; long ones are compiled once
   and called.
3. Code that is loaded gets the addresses of the loops that it calls, and of the few functions of the system.

Entries of loops: the loop for the kinds of some arguments, and the builtin through which Python calls it.
"""

from __future__ import annotations

import json
import re
import struct
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import TYPE_CHECKING, Any, TypeAlias, cast

from mafsil.code_store import FileStore, StoreKind, code_folder, compilation
from mafsil.kernels import elf, identity, runtime, target
from mafsil.kernels.compiler import _llvm  # pyright: ignore[reportPrivateUsage]
from mafsil.kernels.lazy import lazy
from mafsil.kernels.loops import entry, library
from mafsil.kernels.loops.definition import Closure, Definition, closure_of, source_of
from mafsil.kernels.loops.kinds import (
    INTEGER,
    EditedError,
    Held,
    Kind,
    RefusedError,
    Tuple,
    kind_of,
    named_kind,
    refusal,
)
from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.kernels.loops.arrays as memory
    import mafsil.kernels.loops.entry_code as entry_code
    import mafsil.kernels.loops.statements as statements
    from mafsil.kernels.loops.statements import Translation
else:
    memory = lazily("mafsil.kernels.loops.arrays")
    statements = lazily("mafsil.kernels.loops.statements")
    entry_code = lazily("mafsil.kernels.loops.entry_code")


LOOP = StoreKind(b"mafsilL\0", ".loop")
SHORT = 220
"""Lines of IR up to which a function becomes part of its callers' modules."""
EFFORT = 1
"""Of LLVM, up to 3: more takes half as long again, and the code is as fast within 3 %."""
_HEAD = struct.Struct("<Q")
Kept: TypeAlias = tuple[list[Any], bytes]
"""What is known of code, in words of JSON, and the code."""


@dataclass(frozen=True)
class Interface:
    """What callers of a specialisation know of it.

    Attributes:
        result: kind of its result.
        fails, shares_region: as in `Translation`.
        weight: lines of IR with those of what becomes part of it.
        prototype: its declaration in LLVM IR.
        calls: names of loops and of kinds of their arguments that its code calls.
    """

    result: Kind
    fails: bool
    shares_region: bool
    weight: int
    prototype: str
    calls: tuple[tuple[str, tuple[str, ...]], ...]


class Specialisation:
    """A loop for some kinds of arguments.

    Args:
        definition: of the loop.
        kinds: of its arguments.

    Attributes:
        key: of its code in the store.
        symbol: its name in LLVM IR.
    """

    def __init__(self, definition: Definition, kinds: tuple[Kind, ...]) -> None:
        self.definition, self.kinds = definition, kinds
        self.closure: Closure = closure_of(definition)
        names = " ".join(kind.name for kind in kinds)
        self.key = identity.content_key("loop", self.closure.digest, names, made_by(), identity.machine())
        self.symbol = f"{definition.function.__name__}.{self.key[:20]}"
        self._lock = threading.RLock()

    def __repr__(self) -> str:
        return f"{self.definition.name}({', '.join(kind.name for kind in self.kinds)})"

    @lazy
    def translation(self) -> Translation:
        """The function in LLVM IR.

        Raises:
            KernelError: it is not of the language; with file and line.
        """
        node = source_of(self.definition)
        try:
            return statements.translate_function(self.definition, node, self.kinds, self.symbol, specialise)
        except RefusedError as error:
            if not error.placed and not isinstance(error, EditedError):
                function = self.definition.function
                raise error.at(f"{function.__code__.co_filename}:{error.line}, {function.__qualname__}") from None
            raise

    @property
    def called(self) -> tuple[Specialisation, ...]:
        """The specialisations that its source calls."""
        return cast("tuple[Specialisation, ...]", self.translation.callees)

    @lazy
    def interface(self) -> Interface:
        """What callers know of it: from the store, or from its translation."""
        if self._stored is not None:
            return self._stored[0]
        made = self.translation
        weight = made.text.count("\n") + sum(
            callee.interface.weight for callee in self.called if callee.definition.inline
        )
        prototype = re.sub(r" %[\w.]+(?=[,)])", "", made.text[: made.text.index(" nounwind")])
        return Interface(made.result, made.fails, made.shares_region, weight, prototype, ())

    @property
    def result(self) -> Kind:
        """Kind of its result."""
        return self.interface.result

    @property
    def fails(self) -> bool:
        """Whether it says at its end that memory was lacking."""
        return self.interface.fails

    @property
    def shares_region(self) -> bool:
        """Whether its memory joins that of its caller."""
        return self.interface.shares_region

    @property
    def becomes_part(self) -> bool:
        """Whether it is translated into the modules of its callers."""
        return self.definition.inline or self.interface.weight <= SHORT

    # Code -------------------------------------------------------------------------------------------------------------

    def module(self) -> tuple[str, list[Specialisation]]:
        """Its module in LLVM IR, and the specialisations that it calls."""
        included: list[Specialisation] = [self]
        external, declared = dict[Specialisation, None](), set[str]()
        for each in included:
            declared |= each.translation.declared
            for callee in each.called:
                if callee.becomes_part and callee not in included:
                    included.append(callee)
                elif not callee.becomes_part:
                    external[callee] = None
        texts = [f"define {'' if each is self else 'internal '}{each.translation.text}" for each in included]
        declared |= {f"declare {each.interface.prototype}" for each in external}
        return memory.module_text(texts, declared), list(external)

    @lazy
    def address(self) -> int:
        """Where its code begins; it stays as long as the process."""
        with self._lock:
            interface, code = self._stored or self._read(
                obtain_code(self.key, self.definition.function.__name__, self._compiled)
            )
            known = {**library.DEFINITIONS, **self.closure.definitions}
            callees = [
                specialise(known[name], tuple(named_kind(each, self._classes) for each in kinds))
                for name, kinds in interface.calls
            ]
            imports = {callee.symbol: callee.address for callee in callees}
        return load(code, (self.symbol,), imports)[self.symbol]

    def _compiled(self) -> Kept:
        ir, external = self.module()
        with _llvm:
            code = target.optimise(ir, target.host(), EFFORT)
        own = self.interface
        calls = [[each.definition.name, [kind.name for kind in each.kinds]] for each in external]
        return [own.result.name, own.fails, own.shares_region, own.weight, own.prototype, calls], code

    @lazy
    def _classes(self) -> dict[str, type[Any]]:
        """Classes of named tuples that may occur: those that the source names, and those of the arguments."""
        found = dict(self.closure.classes)
        waiting = list(self.kinds)
        for kind in waiting:
            if isinstance(kind, Held):
                waiting.append(kind.value)
            elif isinstance(kind, Tuple):
                waiting += kind.items
                if kind.named:
                    found[f"{kind.named.__module__}:{kind.named.__qualname__}"] = kind.named
        return found

    @lazy
    def _stored(self) -> tuple[Interface, bytes] | None:
        """What the store has, if it can be read; of what becomes part of its callers it has nothing."""
        found = None if self.definition.inline else stored_code(self.key)
        try:
            return None if found is None else self._read(found)
        except (ValueError, TypeError, KeyError):
            store().discard(self.key)
            return None

    def _read(self, found: Kept) -> tuple[Interface, bytes]:
        (result, fails, shares, weight, prototype, calls), code = found
        names = tuple((name, tuple(kinds)) for name, kinds in calls)
        return Interface(named_kind(result, self._classes), fails, shares, weight, prototype, names), code


def obtain_code(key: str, name: str, make: Callable[[], Kept]) -> Kept:
    """Code from the store, or made, once among all processes, and kept there; with what is known of it.

    Args:
        key: in the store.
        name: for people.
        make: compiles it.
    """
    found = stored_code(key)
    if found is not None:
        return found
    with store().compiling(key) as waited:
        found = stored_code(key) if waited else None
        if found is None:
            with compilation(name):
                found = make()
            head = json.dumps(found[0]).encode()
            store().put(key, _HEAD.pack(len(head)) + head + found[1])
        return found


def stored_code(key: str) -> Kept | None:
    """What is known of code, and the code; None if there is none that can be read."""
    payload = store().get(key)
    if payload is None:
        return None
    try:
        (size,) = _HEAD.unpack_from(payload)
        head, code = json.loads(payload[_HEAD.size : _HEAD.size + size]), payload[_HEAD.size + size :]
    except (struct.error, ValueError):
        head, code = None, b""
    if isinstance(head, list) and code:
        return cast("list[Any]", head), code
    store().discard(key)
    return None


def load(code: bytes, symbols: tuple[str, ...], imports: Mapping[str, int]) -> Mapping[str, int]:
    """Bring code into memory as long as there is a process; where its symbols are.

    Args:
        code: verified.
        symbols: that are asked for.
        imports: addresses of the loops that it calls.
    """
    known = {**runtime.functions(), **imports}
    with _llvm:
        loaded = elf.load(code, symbols, known) or target.load(code, symbols, known)
    runtime.forever(loaded)
    return loaded.addresses


_SPECIALISED: dict[tuple[Definition, tuple[Kind, ...]], Specialisation] = {}


def specialise(loop: Any, kinds: tuple[Kind, ...]) -> Specialisation:
    """A loop for some kinds of arguments, made once in a process."""
    definition: Definition = loop.definition
    if len(kinds) != len(definition.arguments):
        raise refusal(f"{definition.name} takes {len(definition.arguments)} arguments, not {len(kinds)}")
    found = _SPECIALISED.get((definition, kinds))
    if found is None:
        found = _SPECIALISED.setdefault((definition, kinds), Specialisation(definition, kinds))
    return found


@cache
def store() -> FileStore:
    """Where the code of loops is kept."""
    return FileStore(code_folder(), LOOP)


@cache
def made_by() -> str:
    """This compiler, LLVM and Python's instructions."""
    return " ".join((identity.fingerprint("mafsil.kernels"), identity.toolchain(), identity.python()))


_ENTRIES: dict[Specialisation, Callable[..., Any]] = {}
_LOCK = threading.RLock()


def entry_for(definition: Definition, arguments: tuple[Any, ...]) -> Callable[..., Any]:
    """The builtin for arguments of such kinds, made at the first question.

    Where objects of this Python lie elsewhere than the machine code looks, loops run as the Python that they are.

    Raises:
        KernelError: the loop is not of the language, or takes no such arguments.
    """
    if not runtime.available():
        return definition.function
    kinds = tuple(kind_of(argument) for argument in arguments)
    try:
        return _entry(definition, kinds)
    except EditedError:  # Nobody knows the source of what is in memory, so it runs as the Python that it is.
        return definition.function


def _entry(definition: Definition, kinds: tuple[Kind, ...]) -> Callable[..., Any]:
    loop = specialise(definition, kinds)
    with _LOCK:
        found = _ENTRIES.get(loop)
        if found is None:
            found = _make(kinds, loop.result, loop.fails, loop.shares_region, loop.address, definition.name)
            _ENTRIES[loop] = found
        return found


def layout_for(kind: Kind) -> Callable[..., Any]:
    """What writes values of a kind to an address."""
    with _LOCK:
        return _make((kind, INTEGER), None, False, False, 0, f"layout of {kind.name[:60]}")


def _make(
    kinds: tuple[Kind, ...], result: Kind | None, fails: bool, shares: bool, address: int, name: str
) -> Callable[..., Any]:
    key = entry.key(kinds, result, fails, shares, made_by())
    classes = entry.classes_of(kinds, result)

    def compiled() -> Kept:
        text = entry_code.Entry(kinds, result, fails, shares).module()
        with _llvm:
            return [name], target.compile(text, target.host(), 0)  # its many lines run once a call

    _, code = obtain_code(key, name, compiled)
    places = load(code, (entry.ENTRY, entry.LINKS), {})
    table = entry.bind_entry(places[entry.LINKS], address, classes)
    return entry.builtin(places[entry.ENTRY], name, table, classes)
