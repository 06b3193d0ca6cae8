"""Functions and methods that expressions may use; everything that could take long or grow is bounded."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from typing import Any, cast

from mafsil.model.xacro.fault import wrong
from mafsil.model.xacro.values import LARGEST_COLLECTION, LONGEST_TEXT, Function, Namespace, Value

_MATH = (
    "acos", "acosh", "asin", "asinh", "atan", "atan2", "atanh", "cbrt", "ceil", "copysign", "cos", "cosh", "degrees",
    "dist", "erf", "erfc", "exp", "exp2", "expm1", "fabs", "floor", "fmod", "frexp", "fsum", "gamma", "hypot",
    "isclose", "isfinite", "isinf", "isnan", "ldexp", "lgamma", "log", "log10", "log1p", "log2", "modf", "pow",
    "radians", "remainder", "sin", "sinh", "sqrt", "tan", "tanh", "trunc",
)  # fmt: skip
_CONSTANTS = ("pi", "e", "tau", "inf", "nan")
_CONVERSIONS: dict[str, Callable[..., Value]] = {
    "len": len,
    "str": str,
    "float": float,
    "int": int,
    "bool": bool,
    "abs": abs,
    "round": round,
    "min": min,
    "max": max,
    "any": any,
    "all": all,
    "ord": ord,
    "repr": repr,
    "divmod": divmod,
    "dict": dict,
    "zip": lambda *columns: list(zip(*columns, strict=False)),
}


def _range(*ends: int) -> Value:
    found = range(*ends)
    if len(found) > LARGEST_COLLECTION:
        raise wrong("the range is too long")
    return list(found)


def _sorted(members: Iterable[Any], reverse: Value = False) -> Value:
    return sorted(members, reverse=bool(reverse))


def _list(members: Iterable[Value] = ()) -> Value:
    return list(members)


def _tuple(members: Iterable[Value] = ()) -> Value:
    return tuple(members)


def _enumerate(members: Iterable[Value], start: int = 0) -> Value:
    return list(enumerate(members, start))


def _reversed(members: Sequence[Value]) -> Value:
    return list(reversed(members))


def _map(function: Value, members: Iterable[Value]) -> Value:
    return [_called(function, member) for member in members]


def _filter(function: Value, members: Iterable[Value]) -> Value:
    return [member for member in members if _called(function, member)]


def _sum(members: Iterable[Value], start: Value = 0) -> Value:
    """Of numbers alone: adding lists one by one takes time without end."""
    numbers = [start, *members]
    if not all(isinstance(number, int | float) for number in numbers):
        raise wrong("sum takes numbers")
    return sum(cast("list[float]", numbers))


def _called(function: Value, member: Value) -> Value:
    if not isinstance(function, Function):
        raise wrong("only the functions of xacro can be called")
    return function.call(member)


def _joined(separator: str, parts: Iterable[str]) -> str:
    found = list(parts)
    if sum(map(len, found)) + len(separator) * len(found) > LONGEST_TEXT:
        raise wrong("too long")
    return separator.join(found)


def _replaced(text: str, old: str, new: str) -> str:
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
    "sum": _sum,
    "sorted": _sorted,
    "list": _list,
    "tuple": _tuple,
    "enumerate": _enumerate,
    "reversed": _reversed,
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
    (str, "replace"): _replaced,
    (str, "join"): _joined,
    (dict, "get"): dict[Value, Value].get,
    (dict, "keys"): _keys,
    (dict, "values"): _dict_values,
    (dict, "items"): _items,
    (list, "index"): list[Value].index,
    (list, "count"): list[Value].count,
    (tuple, "index"): tuple[Value, ...].index,
    (tuple, "count"): tuple[Value, ...].count,
}  # fmt: skip
"""Methods by the type of what they belong to and by name."""


def _table(names: Iterable[str], holder: Any) -> dict[str, Value]:
    return {name: Function(name, getattr(holder, name)) for name in names}


_OF_MATH: dict[str, Value] = _table(_MATH, math) | {name: getattr(math, name) for name in _CONSTANTS}
_OF_PYTHON: dict[str, Value] = {name: Function(name, call) for name, call in _CONVERSIONS.items()}


def global_names(of_xacro: dict[str, Value]) -> dict[str, Value]:
    """Names that every expression knows: those of mathematics, conversions, and the namespaces math, python, xacro.

    Args:
        of_xacro: functions of the running expansion, such as load_yaml.
    """
    namespaces: dict[str, Value] = {
        "math": Namespace(_OF_MATH.__getitem__),
        "python": Namespace(_OF_PYTHON.__getitem__),
        "xacro": Namespace(of_xacro.__getitem__),
    }
    return _OF_MATH | _OF_PYTHON | {name: of_xacro[name] for name in ("load_yaml", "dotify")} | namespaces
