"""Functions and methods that expressions may use; everything that could take long or grow is bounded.

Types in expressions: the functions that make their values stand for them, as `python.str` does.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, cast
from zlib import crc32

from mafsil.model.xacro.values import (
    LARGEST_COLLECTION,
    LONGEST_TEXT,
    Function,
    Namespace,
    Value,
    in_order,
    text_of,
    wrong,
)

NAMED = (str, float, int, bool, complex, list, tuple, dict, set, frozenset, slice)
_NOTHING = Function("NoneType", lambda: None)
_CALLABLE = Function("function", lambda: None)


@dataclass(frozen=True, slots=True)
class Types:
    """The types that expressions know.

    Attributes:
        functions: what stands for each of NAMED.
    """

    functions: Mapping[type, Function]

    def of(self, value: Value) -> Value:
        """The type of a value."""
        return self.functions.get(type(value), _NOTHING if value is None else _CALLABLE)

    def has(self, value: Value, kinds: Value) -> bool:
        """Whether a value is of a type, or of one of several in a tuple."""
        return isinstance(value, self._meant(kinds))

    def contains(self, kind: Value, kinds: Value) -> bool:
        """Whether a type is another one, or one of several in a tuple; truth values are integers."""
        (one,) = self._meant((kind,))
        return issubclass(one, self._meant(kinds))

    def _meant(self, kinds: Value) -> tuple[type, ...]:
        """The types of Python that functions stand for."""
        several = cast("tuple[Value, ...]", kinds) if isinstance(kinds, tuple) else (kinds,)
        found: dict[object, type] = {function: kind for kind, function in self.functions.items()}
        found[_NOTHING] = type(None)
        try:
            return tuple(found[kind] for kind in several)
        except (KeyError, TypeError):
            raise wrong("a type is needed, such as python.str") from None


_MATH = (
    "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "ceil", "copysign", "cos", "cosh", "degrees",
    "dist", "erf", "erfc", "exp", "exp2", "expm1", "fabs", "floor", "fmod", "frexp", "fsum", "gamma", "hypot",
    "isclose", "isfinite", "isinf", "isnan", "ldexp", "lgamma", "log", "log10", "log1p", "log2", "modf", "pow",
    "radians", "remainder", "sin", "sinh", "sqrt", "tan", "tanh", "trunc",
)  # fmt: skip
_CONSTANTS = ("pi", "e", "tau", "inf", "nan")
_CONVERSIONS: dict[str, Callable[..., Value]] = {
    "len": len,
    "str": text_of,
    "float": float,
    "int": int,
    "bool": bool,
    "abs": abs,
    "complex": complex,
    "slice": slice,
    "min": min,
    "max": max,
    "any": any,
    "all": all,
    "ord": ord,
    "repr": repr,
    "divmod": divmod,
    "dict": dict,
}
MOST_DIGITS = 400
"""Decimals to which a number is rounded; more would take Python for ever."""


def _range(*ends: int) -> Value:
    found = range(*ends)
    if len(found) > LARGEST_COLLECTION:
        raise wrong("the range is too long")
    return list(found)


def _round(number: Any, digits: int | None = None) -> Value:
    if digits is not None and abs(digits) > MOST_DIGITS:
        raise wrong("too many digits")
    return round(number, digits)


def _zip(*columns: Iterable[Value]) -> Value:
    lists = [list(in_order(column)) for column in columns]
    if len(lists) * min(map(len, lists), default=0) > LARGEST_COLLECTION:
        raise wrong("too long")
    return list(zip(*lists, strict=False))


def _hash(value: Any) -> Value:
    """That of Python for numbers; that of a text is the same in every process, which Python's is not."""
    return crc32(value.encode("utf-8", "surrogatepass")) if isinstance(value, str) else hash(_plain(value))


def _plain(value: Any) -> Any:
    """The value with numbers in place of texts."""
    if isinstance(value, tuple):
        return tuple(map(_plain, cast("tuple[Any, ...]", value)))
    return _hash(value) if isinstance(value, str) else value


def _sort(members: Iterable[Any], reverse: Value = False) -> Value:
    return sorted(members, reverse=bool(reverse))


def _list(members: Iterable[Value] = ()) -> Value:
    return list(in_order(members))


def _tuple(members: Iterable[Value] = ()) -> Value:
    return tuple(in_order(members))


def _set(members: Iterable[Value] = ()) -> Value:
    return set(members)


def _frozenset(members: Iterable[Value] = ()) -> Value:
    return frozenset(members)


def _enumerate(members: Iterable[Value], start: int = 0) -> Value:
    return list(enumerate(in_order(members), start))


def _reverse(members: Sequence[Value]) -> Value:
    return list(reversed(members))


def _map(function: Value, members: Iterable[Value]) -> Value:
    return [_call(function, member) for member in in_order(members)]


def _filter(function: Value, members: Iterable[Value]) -> Value:
    return [member for member in in_order(members) if _call(function, member)]


def _sum(members: Iterable[Value], start: Value = 0) -> Value:
    """Of numbers alone: adding lists one by one takes time without end."""
    numbers = [start, *members]
    if not all(isinstance(number, int | float) for number in numbers):
        raise wrong("sum takes numbers")
    return sum(cast("list[float]", numbers))


def _call(function: Value, member: Value) -> Value:
    if not isinstance(function, Function):
        raise wrong("only the functions of xacro can be called")
    return function.call(member)


def _join(separator: str, parts: Iterable[str]) -> str:
    found = list(cast("Iterable[str]", in_order(parts)))
    if sum(map(len, found)) + len(separator) * len(found) > LONGEST_TEXT:
        raise wrong("too long")
    return separator.join(found)


def _replace(text: str, old: str, new: str) -> str:
    if (text.count(old) + 1) * len(new) > LONGEST_TEXT:
        raise wrong("too long")
    return text.replace(old, new)


def _keys(holder: dict[Value, Value]) -> Value:
    return list(holder)


def _dict_values(holder: dict[Value, Value]) -> Value:
    return list(holder.values())


def _items(holder: dict[Value, Value]) -> Value:
    return list(holder.items())


_CONVERSIONS |= {
    "range": _range,
    "round": _round,
    "zip": _zip,
    "hash": _hash,
    "set": _set,
    "frozenset": _frozenset,
    "sum": _sum,
    "sorted": _sort,
    "list": _list,
    "tuple": _tuple,
    "enumerate": _enumerate,
    "reversed": _reverse,
    "map": _map,
    "filter": _filter,
}
METHODS: dict[tuple[type, str], Callable[..., Value]] = {
    **{
        (str, name): getattr(str, name)
        for name in (
            "lower", "upper", "strip", "lstrip", "rstrip", "split", "startswith", "endswith", "find", "count",
            "title", "capitalize", "isdigit",
        )
    },
    (str, "replace"): _replace,
    (str, "join"): _join,
    (dict, "get"): dict[Value, Value].get,
    (dict, "keys"): _keys,
    (dict, "values"): _dict_values,
    (dict, "items"): _items,
    (list, "index"): list[Value].index,
    (list, "count"): list[Value].count,
    **{
        (kind, name): getattr(kind, name)
        for kind in (set, frozenset)
        for name in (
            "union", "intersection", "difference", "symmetric_difference", "issubset", "issuperset", "isdisjoint",
        )
    },
    (tuple, "index"): tuple[Value, ...].index,
    (tuple, "count"): tuple[Value, ...].count,
}  # fmt: skip
"""Methods by the type of what they belong to and by name."""
FIELDS = frozenset((kind, name) for kind in (int, float, complex) for name in ("real", "imag"))
"""Values behind a dot, by type and name."""


def _table(names: Iterable[str], holder: Any) -> dict[str, Value]:
    return {name: Function(name, getattr(holder, name)) for name in names}


_OF_MATH: dict[str, Value] = _table(_MATH, math) | {name: getattr(math, name) for name in _CONSTANTS}
_OF_PYTHON: dict[str, Value] = {name: Function(name, call) for name, call in _CONVERSIONS.items()}
_TYPES = Types({kind: cast("Function", _OF_PYTHON[kind.__name__]) for kind in NAMED})
_OF_PYTHON |= {
    "type": Function("type", _TYPES.of),
    "isinstance": Function("isinstance", _TYPES.has),
    "issubclass": Function("issubclass", _TYPES.contains),
}
_ONLY_IN_PYTHON = ("complex", "frozenset", "hash", "isinstance", "issubclass", "set", "slice", "type")
"""Names that the xacro of ROS has behind `python.` alone."""
_DIRECT = {name: value for name, value in _OF_PYTHON.items() if name not in _ONLY_IN_PYTHON}


def global_names(of_xacro: dict[str, Value]) -> dict[str, Value]:
    """Names that every expression knows: those of mathematics, conversions, and the namespaces math, python, xacro.

    Args:
        of_xacro: functions of the running expansion, such as load_yaml.
    """
    namespaces: dict[str, Value] = {
        "math": Namespace(_OF_MATH.__getitem__, _OF_MATH),
        "python": Namespace(_OF_PYTHON.__getitem__, _OF_PYTHON),
        "xacro": Namespace(of_xacro.__getitem__, of_xacro),
    }
    return _OF_MATH | _DIRECT | {name: of_xacro[name] for name in ("load_yaml", "dotify")} | namespaces
