"""Values of xacro expressions: what they may be, how large, how they are written and read as text."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import TypeAlias, cast

from mafsil.model.faults import XACRO_CONDITION
from mafsil.model.xacro.fault import Budget, XacroFault, wrong

Value: TypeAlias = object
"""None, bool, int, float, str, list, tuple or dict of values, or a Function."""
LONGEST_TEXT = 100_000
"""Characters of any text that an expression makes."""
LARGEST_COLLECTION = 100_000
"""Members of a list or dictionary, those of its members included."""
MOST_BITS = 4096
"""Of an integer."""


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
    """

    __slots__ = ("get",)

    def __init__(self, get: Callable[[str], Value]) -> None:
        self.get = get


def bounded(value: Value, budget: Budget) -> Value:
    """The value itself, if it is small enough.

    Raises:
        XacroFault: a text, number or collection beyond the limits.
    """
    if isinstance(value, str):
        if len(value) > LONGEST_TEXT:
            raise wrong(f"text of more than {LONGEST_TEXT} characters")
        budget.spend(len(value) >> 8)
    elif isinstance(value, int):
        if value.bit_length() > MOST_BITS:
            raise wrong(f"integer of more than {MOST_BITS} bits")
    elif isinstance(value, list | tuple | dict):
        budget.spend(_weight(cast("list[Value] | tuple[Value, ...] | dict[Value, Value]", value)))
    return cast("Value", value)


def members(value: list[Value] | tuple[Value, ...] | dict[Value, Value]) -> Iterable[Value]:
    """What a collection holds: keys and values of a dictionary."""
    if isinstance(value, dict):
        yield from value.keys()
        yield from value.values()
    else:
        yield from value


def _weight(value: list[Value] | tuple[Value, ...] | dict[Value, Value]) -> int:
    """Number of members, each counted as often as it is reached: shared ones multiply when written or compared."""
    count, waiting = 0, list(members(value))
    while waiting:
        count += 1
        if count > LARGEST_COLLECTION:
            raise wrong(f"collection of more than {LARGEST_COLLECTION} members")
        member = waiting.pop()
        if isinstance(member, list | tuple | dict):
            waiting.extend(members(cast("list[Value] | tuple[Value, ...] | dict[Value, Value]", member)))
    return count


def text_of(value: Value) -> str:
    """The text that stands for a value in the expanded file, as Python writes it."""
    if isinstance(value, Function | Namespace):
        raise wrong("a function is no value; call it with parentheses")
    return str(value)


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
