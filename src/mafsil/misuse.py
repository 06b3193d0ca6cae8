"""Which argument of a call does not fit its annotation: asked when an error that is not ours came out."""

from __future__ import annotations

import ast
import os
import re
import sys
import types
import typing
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from functools import cache
from importlib import import_module
from inspect import Parameter, Signature, getsource, isclass, signature, unwrap
from itertools import islice
from pathlib import Path
from typing import Any, cast, get_args, get_origin

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import real_array, require_finite
from mafsil.errors import ArgumentError, InputError, MafsilError
from mafsil.messages import LANGUAGES, say
from mafsil.unbound import Hint, binding_error, maker_hint, maker_of

LOOKED_AT = 100
"""Elements of a sequence or table that are looked at."""
MOST = 2**31 - 1
"""The largest count that can be served."""


def fault_of(
    function: Callable[..., object], args: tuple[Any, ...], named: dict[str, Any], error: Exception
) -> InputError | None:
    """The error that names the argument that does not fit; None if all do, or the error names one itself.

    1. Arguments that cannot be bound, or are of another kind than their annotation.
    2. An exception of Python or NumPy that none of these explains: an argument of another shape than is documented,
       that is not finite, or a count that nobody can serve; not where a function of the user raised it.

    Args:
        function: that was called.
        args, named: with these.
        error: that came out; of calls within calls the outermost argument that does not fit is to blame.
    """
    if isinstance(error, MafsilError) and type(error) is not ArgumentError:
        return _with_maker(function, args, error)
    taken, hints = signature(function), _hints(unwrap(function))
    first, owner = next(iter(taken.parameters), ""), None
    if first in ("self", "cls") and args:
        owner, *rest = args
        hints |= {name: type(owner) for name, hint in hints.items() if hint is _SELF}
        taken, args = taken.replace(parameters=list(taken.parameters.values())[1:]), tuple(rest)
    # 1.
    fault = binding_error(function, owner, taken, args, named, hints)
    if fault is not None and fault.key != "input.missing":
        return fault
    given = list(_given(taken, hints, args, named))
    for name, value, hint in given:
        if not fits(value, hint):
            return _misfit(name, value, hint)
    if fault is not None:
        return fault
    # 2.
    if isinstance(error, MafsilError) or not _of_libraries(error):
        return None
    shapes = documented_shapes(function.__doc__ or "")
    faults = (_unlikely(name, value, hint, shapes.get(name)) for name, value, hint in given)
    return next((each for each in faults if each is not None), None)


def _with_maker(function: Callable[..., object], args: tuple[Any, ...], error: MafsilError) -> InputError | None:
    """A wrong shape or kind, said with the maker that takes plain numbers, where there is one."""
    if error.key == "input.kind":
        argument = str(error.details["name"]).partition("[")[0]
        maker = _makers(_hints(unwrap(function)).get(argument))
        return ArgumentError("input.misfit_maker", **{**error.details, "maker": maker}) if maker else None
    bare = error.key == "input.shape" and not error.details["hint"]
    hint = maker_hint(function, args[0]) if bare and args else Hint()
    return InputError(error.key, **{**error.details, "hint": hint}) if hint.key else None


def require_flags(given: Mapping[str, object]) -> None:
    """Refuse what is neither True nor False, nor 1 or 0.

    Args:
        given: by the name of the argument.

    Raises:
        ArgumentError: "no" would count as yes.
    """
    for name, value in given.items():
        if not isinstance(value, bool | np.bool_) and not (isinstance(value, int) and value in (0, 1)):
            raise _misfit(name, value, bool)


def _given(
    taken: Signature, hints: dict[str, Any], args: tuple[Any, ...], named: dict[str, Any]
) -> Iterator[tuple[str, Any, Any]]:
    """Name, value and annotation of every argument of a call; further keywords are left out."""
    for name, value in taken.bind_partial(*args, **named).arguments.items():
        kind = taken.parameters[name].kind
        for each in value if kind is Parameter.VAR_POSITIONAL else (value,):
            if kind is not Parameter.VAR_KEYWORD:
                yield name, each, hints.get(name, Any)


def _misfit(name: str, value: Any, hint: Any) -> ArgumentError:
    """The error that says what an argument should be; of rows of numbers what is wrong with them."""
    if _is_array(hint):
        try:
            real_array(name, value)
        except InputError as fault:
            return ArgumentError(fault.key, **fault.details)
    details = {"name": name, "expected": annotation_in_words(hint), "got": _shown(value)}
    maker = _makers(hint)
    return ArgumentError("input.misfit_maker" if maker else "input.misfit", maker=maker, **details)


def _makers(hint: Any) -> str:
    """What makes the classes of an annotation from plain numbers."""
    return " / ".join(maker for each in (hint, *get_args(hint)) if (maker := maker_of(each)) is not None)


def _unlikely(name: str, value: Any, hint: Any, shape: tuple[str, ...] | None) -> InputError | None:
    """What is the matter with an argument of the right kind, if anything is."""
    if value is None:
        return None
    if name == "language" and str(value) not in LANGUAGES:
        return ArgumentError("messages.language", code=value, known=", ".join(LANGUAGES))
    kinds = get_args(hint) or (hint,)
    if any(map(_is_array, (hint, *kinds))) or float in kinds:
        try:
            array = real_array(name, value)
            if shape is not None and not has_shape(array.shape, shape):
                return InputError("input.shape", name=name, expected=f"({', '.join(shape)})", got=array.shape, hint="")
            require_finite(name, array)
        except InputError as fault:
            return fault
        given: object = value
        if not isinstance(given, np.ndarray) and ArrayLike not in (hint, *kinds) and float not in kinds:
            return ArgumentError("input.array", name=name, got=type(given).__name__)
    if int in kinds and _whole(value) and not 0 <= value <= MOST:
        return InputError("input.whole", name=name, value=value, low=0, high=MOST)
    empty = isinstance(value, str) and not value
    return (
        ArgumentError("input.misfit", name=name, expected=annotation_in_words(hint), got=_shown(value))
        if empty
        else None
    )


_DOCUMENTED = re.compile(r"^ +(\w+(?:, \w+)*): \(([^()]*)\)", re.MULTILINE)


def documented_shapes(text: str) -> dict[str, tuple[str, ...]]:
    """The shapes that a docstring gives its arguments, as `q: (*batch, n) coordinates`.

    Args:
        text: of the docstring.
    """
    found = _DOCUMENTED.findall(text)
    return {name: tuple(re.findall(r"[^\s,]+", shape)) for names, shape in found for name in names.split(", ")}


def has_shape(shape: tuple[int, ...], dimensions: tuple[str, ...]) -> bool:
    """Whether an array may have the shape, whatever the letters in it stand for.

    Args:
        shape: of the array.
        dimensions: numbers, letters and `*batch`.
    """
    core = [each for each in dimensions if not each.startswith("*")]
    if len(shape) < len(core) or (len(shape) > len(core) and len(core) == len(dimensions)):
        return False
    last = shape[len(shape) - len(core) :]
    return all(not wanted.isdigit() or size == int(wanted) for size, wanted in zip(last, core, strict=True))


def _of_libraries(error: Exception) -> bool:
    """Whether an exception came through code of this package and of libraries alone: none of the user's own."""
    trace, own = error.__traceback__, str(Path(__file__).parent)
    while trace is not None:
        file = trace.tb_frame.f_code.co_filename
        if not file.startswith(own) and not any(part in file for part in ("site-packages", "dist-packages", _PYTHON)):
            return not os.path.isabs(file)  # Compiled: Cython says `_common.pyx`.
        trace = trace.tb_next
    return True


_SELF: Any = typing.Self
_PYTHON = str(Path(os.__file__).parent)


def _hints(function: Any) -> dict[str, Any]:
    """The annotations that can be resolved, one by one: with names that only type checkers see, where there are any."""
    found: dict[str, Any] = {}
    for name, hint in function.__annotations__.items():
        one, names = types.SimpleNamespace(__annotations__={name: hint}), function.__globals__
        with suppress(NameError, TypeError, AttributeError, SyntaxError):
            try:
                found |= typing.get_type_hints(one, names)
            except NameError:
                found |= typing.get_type_hints(one, names, _names_for_checkers(function.__module__))
    return found


@cache
def _names_for_checkers(module: str) -> dict[str, Any]:
    """What a module imports from others for type checkers alone."""
    tree = ast.parse(getsource(sys.modules[module]))
    blocks = (each.body for each in tree.body if isinstance(each, ast.If) and "TYPE_CHECKING" in ast.dump(each.test))
    lines = (line for block in blocks for line in block if isinstance(line, ast.ImportFrom) and line.module)
    names: dict[str, Any] = {}
    for line in lines:
        with suppress(ImportError):  # A stub that has no module.
            names |= {each.name: getattr(import_module(str(line.module)), each.name) for each in line.names}
    return names


def fits(value: Any, hint: Any) -> bool:
    """Whether a value is of an annotated kind, as far as can be seen without using it.

    Args:
        value: that was given.
        hint: its annotation, resolved.
    """
    origin, inner = get_origin(hint), get_args(hint)
    if _is_array(hint):
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
    if not inner or not isinstance(value, Sequence):
        return True
    elements = list(islice(cast("Sequence[Any]", value), LOOKED_AT))
    if kind is tuple and Ellipsis not in inner:
        return len(elements) == len(inner) and all(map(fits, elements, inner))
    return all(fits(each, inner[0]) for each in elements)


def _is_array(hint: Any) -> bool:
    """Whether an annotation is one of arrays."""
    origin = get_origin(hint)
    return hint is ArrayLike or (isclass(origin) and issubclass(origin, np.ndarray))


def _numbers(value: Any) -> bool:
    """Whether a value passes the gate of numbers, or is an array of yes and no."""
    try:
        real_array("", value)
    except InputError as fault:
        return fault.details.get("got") in _TRUTHS
    return True


_TRUTHS = ("ndarray of bool", "list of bool", "tuple of bool")


def _number(value: Any) -> bool:
    return _numbers(value) and np.ndim(value) == 0


def _whole(value: Any) -> bool:
    return isinstance(value, int | np.integer) and not isinstance(value, bool | np.timedelta64)


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


def annotation_in_words(hint: Any) -> str:
    """An annotation in words.

    Args:
        hint: resolved.
    """
    origin, inner = get_origin(hint), get_args(hint)
    if _is_array(hint):
        return say("input.of_numbers")
    if origin in (typing.Union, types.UnionType):
        return say("input.or").join(dict.fromkeys(annotation_in_words(each) for each in inner))
    if origin is typing.Literal:
        return ", ".join(map(str, inner))
    if origin is typing.Annotated:
        return annotation_in_words(inner[0])
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
        return say("input.several", each=annotation_in_words(inner[0]) if inner else say("input.values"))
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
