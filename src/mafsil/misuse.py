"""Which argument of a call does not fit its annotation: asked when an error that is not ours came out."""

from __future__ import annotations

import os
import types
import typing
from collections.abc import Callable, Iterable, Mapping, Sequence
from inspect import Parameter, Signature, isclass, signature, unwrap
from itertools import islice
from pathlib import Path
from typing import Any, cast, get_args, get_origin

import numpy as np
from numpy.typing import ArrayLike

from mafsil.errors import ArgumentError, MafsilError
from mafsil.messages import say

LOOKED_AT = 100
"""Elements of a sequence or table that are looked at."""


def fault_of(
    function: Callable[..., object], args: tuple[Any, ...], named: dict[str, Any], error: Exception
) -> ArgumentError | None:
    """The error that names the argument that does not fit; None if all do, or the error names one itself.

    Args:
        function: that was called.
        args, named: with these.
        error: that came out.
    """
    if isinstance(error, MafsilError):
        return None
    taken = signature(function)
    if not {"self", "cls"}.isdisjoint(taken.parameters):
        taken, args = (
            Signature([each for name, each in taken.parameters.items() if name not in ("self", "cls")]),
            args[1:],
        )
    fault = _unbound(function, taken, args, named)
    if fault is not None:
        return fault
    hints = _hints(unwrap(function))
    for name, value in taken.bind(*args, **named).arguments.items():
        hint = hints.get(name, Any)
        several = taken.parameters[name].kind
        values = value if several is Parameter.VAR_POSITIONAL else [value]
        if several is not Parameter.VAR_KEYWORD and not all(fits(each, hint) for each in values):
            return ArgumentError("input.misfit", name=name, expected=expected(hint), got=_shown(value))
    return None


def _hints(function: Any) -> dict[str, Any]:
    """The annotations that can be resolved, one by one: names that only type checkers see cannot."""
    found: dict[str, Any] = {}
    for name, hint in function.__annotations__.items():
        try:
            found |= typing.get_type_hints(types.SimpleNamespace(__annotations__={name: hint}), function.__globals__)
        except (NameError, TypeError, AttributeError, SyntaxError):
            continue
    return found


def _unbound(
    function: Callable[..., object], taken: Signature, args: tuple[Any, ...], named: dict[str, Any]
) -> ArgumentError | None:
    """Arguments that are missing, unknown, given twice or too many."""
    parameters = taken.parameters
    kinds = {each.kind for each in parameters.values()}
    places = [name for name, one in parameters.items() if one.kind in (one.POSITIONAL_ONLY, one.POSITIONAL_OR_KEYWORD)]
    owner, _, own = getattr(function, "__qualname__", "").rpartition(".")
    shown = owner if own == "__init__" else f"{owner}.{own}" if owner else own
    details = {"name": shown, "inputs": ", ".join(parameters)}
    doubtful = [name for name in named if name in places[: len(args)]]
    if Parameter.VAR_KEYWORD not in kinds:
        doubtful += [name for name in named if name not in parameters]
    if Parameter.VAR_POSITIONAL not in kinds:
        doubtful += [repr(value)[:40] for value in args[len(places) :]]
    if doubtful:
        return ArgumentError("input.unexpected", problem=", ".join(doubtful), **details)
    needed = [
        name
        for name, one in parameters.items()
        if one.default is one.empty and one.kind not in (one.VAR_POSITIONAL, one.VAR_KEYWORD)
    ]
    missing = [name for name in needed if name not in named and name not in places[: len(args)]]
    return ArgumentError("input.missing", missing=", ".join(missing), **details) if missing else None


def fits(value: Any, hint: Any) -> bool:
    """Whether a value is of an annotated kind, as far as can be seen without using it.

    Args:
        value: that was given.
        hint: its annotation, resolved.
    """
    origin, inner = get_origin(hint), get_args(hint)
    if hint is ArrayLike or (isclass(origin) and issubclass(origin, np.ndarray)):
        return _numbers(value)
    if origin in (typing.Union, types.UnionType):
        return any(fits(value, each) for each in inner)
    if origin is typing.Literal:
        return isinstance(value, str | int | bool | None) and value in inner
    if origin is typing.Annotated:
        return fits(value, inner[0])
    plain = _PLAIN.get(hint) if isinstance(hint, type) or hint is None else None
    if plain is not None:
        return plain(value)
    if isclass(origin) or isclass(hint):
        return _of_class(value, origin if isclass(origin) else hint, inner)
    return True


def _of_class(value: Any, kind: Any, inner: tuple[Any, ...]) -> bool:
    if kind is Callable:
        return callable(value) and (not inner or not isinstance(inner[0], list) or _takes(value, _count(inner[0])))
    if kind is os.PathLike or kind is Path:
        return isinstance(value, str | os.PathLike)
    try:
        right = isinstance(value, kind)
    except TypeError:
        return True  # A protocol that can be asked only for its members, or not at all.
    if issubclass(kind, Mapping):
        return right and (len(inner) < 2 or all(fits(each, inner[1]) for each in islice(value.values(), LOOKED_AT)))
    if kind in (Iterable, Sequence, list, tuple) or (isclass(kind) and kind.__module__ == "collections.abc"):
        if isinstance(value, np.ndarray):
            return value.ndim > 0 and (not inner or not value.size or fits(value[0], inner[0]))
        return right and not isinstance(value, str | bytes) and _elements(value, kind, inner)
    return right


def _count(kinds: Any) -> int:
    return len(kinds)


def _takes(function: Any, count: int) -> bool:
    """Whether a function can be called with so many arguments, as far as it says what it takes."""
    try:
        taken = signature(function)
    except (ValueError, TypeError):
        return True
    try:
        taken.bind(*[None] * count)
    except TypeError:
        return False
    return True


def _elements(value: Any, kind: Any, inner: tuple[Any, ...]) -> bool:
    if not inner or not isinstance(value, list | tuple):
        return True
    elements = list(cast("Sequence[Any]", value))[:LOOKED_AT]
    if kind is tuple and Ellipsis not in inner:
        return len(elements) == len(inner) and all(map(fits, elements, inner))
    return all(fits(each, inner[0]) for each in elements)


def _numbers(value: Any) -> bool:
    try:
        array = np.asarray(value)
    except (ValueError, TypeError, OverflowError):
        return False
    return array.dtype.kind in "fiu" or (array.dtype.kind == "b" and array.ndim > 0)


def _number(value: Any) -> bool:
    return _numbers(value) and np.ndim(value) == 0


def _whole(value: Any) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool)


_PLAIN: dict[Any, Callable[[Any], bool]] = {
    float: _number,
    int: _whole,
    complex: lambda value: np.ndim(value) == 0 and np.asarray(value).dtype.kind in "fiuc",
    bool: lambda value: isinstance(value, bool | np.bool_),
    str: lambda value: isinstance(value, str),
    type(None): lambda value: value is None,
    None: lambda value: value is None,
    object: lambda value: True,
}


def expected(hint: Any) -> str:
    """An annotation in words.

    Args:
        hint: resolved.
    """
    origin, inner = get_origin(hint), get_args(hint)
    if hint is ArrayLike or (isclass(origin) and issubclass(origin, np.ndarray)):
        return say("input.of_numbers")
    if origin in (typing.Union, types.UnionType):
        return say("input.or").join(dict.fromkeys(expected(each) for each in inner))
    if origin is typing.Literal:
        return ", ".join(map(str, inner))
    if origin is typing.Annotated:
        return expected(inner[0])
    if hint in (None, type(None)):
        return "None"
    word = _WORDS.get(hint) if isinstance(hint, type) else None
    if word is not None:
        return say(word)
    kind: Any = origin if isclass(origin) else hint
    if kind is Callable:
        counted = bool(inner) and isinstance(inner[0], list)
        return say("input.function_of", count=_count(inner[0])) if counted else say("input.a_function")
    if isclass(kind) and issubclass(kind, Mapping):
        return say("input.a_table")
    if isclass(kind) and kind.__module__ in ("collections.abc", "builtins"):
        return say("input.several", each=expected(inner[0]) if inner else say("input.values"))
    return getattr(kind, "__name__", str(kind))


_WORDS = {
    float: "input.a_number",
    int: "input.a_whole_number",
    bool: "input.true_or_false",
    str: "input.a_text",
}


def _shown(value: Any) -> str:
    if value is None:
        return "None"
    kind = f"class {value.__name__}" if isclass(value) else type(value).__name__
    short = isinstance(value, str | int | float | complex | bytes | list | tuple | dict)
    text = repr(cast("object", value)) if short else ""
    return f"{kind} {text}" if 0 < len(text) <= 40 else kind
