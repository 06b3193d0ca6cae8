"""Values of xacro expressions: what they may be, how large, how they are written and read as text.

An `XacroFault` stops an expansion before it has a place in a file. The list of parameters of a macro looks like
`name parent:=world scale:=^|1.0 *origin **children`.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Mapping
from time import thread_time
from typing import TypeAlias, cast

from mafsil.model.diagnostics import Fault
from mafsil.model.faults import XACRO_CONDITION, XACRO_EXPRESSION, XACRO_NAME, XACRO_TOO_MUCH

SECONDS = 1.5
"""Of the processor, for one expansion: with reading the file and the result less than two."""
_BETWEEN_LOOKS = 500
"""Steps between two looks at the clock."""
_VALUE = r"""\$\{.*?\}|\$\(.*?\)|(?:'[^']*'|"[^"]*"|[^\s'"])+|"""
_WITH_DEFAULT = re.compile(rf"([^\s:=]+)\s*:?=\s*(\^\|?)?({_VALUE})(?=\s|$)")
_PLAIN = re.compile(r"\S+")
LONGEST = 20_000
Value: TypeAlias = object
"""None, bool, int, float, complex, str, list, tuple, dict or set of values, slice, or a Function."""
LONGEST_TEXT = 100_000
"""Characters of any text that an expression makes."""
LARGEST_COLLECTION = 100_000
"""Members of a list or dictionary, those of its members included."""
MOST_BITS = 4096
"""Of an integer."""
Collected: TypeAlias = "list[Value] | tuple[Value, ...] | dict[Value, Value] | set[Value] | frozenset[Value]"
_COLLECTIONS = (list, tuple, dict, set, frozenset)


class Function:
    """A function that expressions may call; calling anything else is refused.

    Attributes:
        name: for sentences.
        call: what it does; takes values.
    """

    __slots__ = ("call", "name")

    def __init__(self, name: str, call: Callable[..., Value]) -> None:
        self.name = name
        self.call = call


class Namespace:
    """Names behind a dot, such as `math.pi`.

    Attributes:
        get: the value of a name.
        known: names that it surely has, for hints.
    """

    __slots__ = ("get", "known")

    def __init__(self, get: Callable[[str], Value], known: Iterable[str] = ()) -> None:
        self.get = get
        self.known = tuple(known)


def check_size(value: Value, budget: Budget) -> Value:
    """The value itself, if it is small enough.

    Raises:
        XacroFault: a text, number or collection beyond the limits.
    """
    if isinstance(value, str):
        if len(value) > LONGEST_TEXT:
            raise wrong(f"text of more than {LONGEST_TEXT} characters")
        budget.spend(value.__sizeof__() >> 4)
    elif isinstance(value, int):
        if value.bit_length() > MOST_BITS:
            raise wrong(f"integer of more than {MOST_BITS} bits")
        budget.spend(value.bit_length() >> 7)
    elif isinstance(value, _COLLECTIONS):
        budget.spend(_weight(cast("Collected", value)))
    return cast("Value", value)


def in_order(value: Value) -> Iterable[Value]:
    """The members of what can be run through; those of a set in an order that every process has."""
    if isinstance(value, set | frozenset):
        return sorted(cast("set[Value]", value), key=repr)
    return cast("Iterable[Value]", value)


def members(value: Collected) -> Iterable[Value]:
    """What a collection holds: keys and values of a dictionary."""
    if isinstance(value, dict):
        yield from value.keys()
        yield from value.values()
    else:
        yield from value


def _weight(value: Collected) -> int:
    """Number of members, each counted as often as it is reached: shared ones multiply when written or compared.

    A text counts as its length in sixteens.
    """
    count, waiting = 0, list(members(value))
    while waiting:
        count += 1
        if count > LARGEST_COLLECTION:
            raise wrong(f"collection of more than {LARGEST_COLLECTION} members")
        member = waiting.pop()
        if isinstance(member, str):
            count += len(member) >> 4
        elif isinstance(member, _COLLECTIONS):
            waiting.extend(members(cast("Collected", member)))
    return count


def text_of(value: Value) -> str:
    """The text that stands for a value in the expanded file, as Python writes it."""
    if isinstance(value, Function | Namespace):
        raise wrong("a function is no value; call it with parentheses")
    if isinstance(value, set | frozenset) and value:
        text = "{" + ", ".join(repr(member) for member in in_order(cast("Value", value))) + "}"
        return text if isinstance(value, set) else f"frozenset({text})"
    return str(cast("Value", value))


def literal(value: Value) -> Value:
    """A text that is a number, a boolean or in single quotes, as what it means; everything else as it is."""
    if not isinstance(value, str):
        return value
    if len(value) >= 2 and value[0] == value[-1] == "'":
        return value[1:-1]
    if "_" in value or len(value) > 400:
        return value
    for kind in (int, float):
        try:
            return kind(value)
        except ValueError:
            continue
    return {"true": True, "True": True, "false": False, "False": False}.get(value, value)


def truth(value: Value, condition: str) -> bool:
    """Whether a condition holds: true, false and numbers; texts only where they are one of these.

    Raises:
        XacroFault: any other text.
    """
    if isinstance(value, str):
        known = {"true": True, "True": True, "false": False, "False": False}.get(value.strip())
        if known is not None:
            return known
        try:
            return bool(int(value))
        except ValueError:
            raise XacroFault(XACRO_CONDITION, condition=condition, value=value) from None
    return bool(value)


def as_mapping(value: Value) -> Mapping[Value, Value] | None:
    """The value as a dictionary, or None."""
    return cast("dict[Value, Value]", value) if isinstance(value, dict) else None


class XacroFault(Exception):
    """A fault with its details; whoever knows the element gives it a place. Never leaves the expander.

    Attributes:
        fault: what kind.
        details: values for the sentence.
    """

    def __init__(self, fault: Fault, **details: object) -> None:
        super().__init__(fault.code)
        self.fault = fault
        self.details = details


class Reported(Exception):
    """Ends an expansion after its error was reported. Never leaves the expander."""


def wrong(reason: str) -> XacroFault:
    """An expression that has no value."""
    return XacroFault(XACRO_EXPRESSION, reason=reason)


class Budget:
    """Steps and seconds that an expansion may still take: a file that never ends is refused in a moment.

    A step is about a microsecond of a plain machine, or sixteen bytes. Steps end a text at the same place everywhere;
    the processor's time, looked at now and then, ends what costs more than its steps.

    Attributes:
        limit: steps in all.
        left: steps not yet taken.
    """

    def __init__(self, limit: int, seconds: float = SECONDS) -> None:
        self.limit = limit
        self.left = limit
        self._seconds = seconds
        self._end = thread_time() + seconds
        self._look_at = limit - _BETWEEN_LOOKS

    def spend(self, steps: int = 1) -> None:
        """Take steps.

        Raises:
            XacroFault: there are none left, or no time.
        """
        self.left -= steps
        if self.left <= self._look_at:
            self._look_at = self.left - _BETWEEN_LOOKS
            if self.left < 0 or thread_time() > self._end:
                raise XacroFault(XACRO_TOO_MUCH, limit=self.limit, seconds=self._seconds)


def parameters_of(text: str) -> tuple[tuple[str, ...], dict[str, tuple[bool, str | None]]]:
    """Names and defaults.

    Args:
        text: the attribute `params`.

    Returns:
        The names in order, those of blocks with their stars; for each name with a default whether the caller's property
        of that name comes first (`^`), and the text or None.

    Raises:
        XacroFault: longer than any list of parameters.
    """
    if len(text) > LONGEST:
        raise XacroFault(XACRO_NAME, name=text)
    names: list[str] = []
    defaults: dict[str, tuple[bool, str | None]] = {}
    at = 0
    while (start := re.compile(r"\s*").match(text, at)) is not None and start.end() < len(text):
        found = _WITH_DEFAULT.match(text, start.end())
        if found is not None:
            defaults[found[1]] = (found[2] is not None, found[3] or None)
            names.append(found[1])
        else:
            found = _PLAIN.match(text, start.end())
            names.append(found[0] if found else "")
        at = found.end() if found else len(text)
    return tuple(names), defaults
