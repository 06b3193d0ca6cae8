"""What is kept of a compiled loop, as plain bytes: names and types in JSON, the object code, the bitcode for callers.

Nothing in an entry is executed to read it. The types of the arguments come from the caller, those of results from a
short list; a loop that needs more than that is compiled in each process.
"""

from __future__ import annotations

import importlib
import json
import struct
from typing import Any, cast

import numpy as np
from numba.core import types
from numba.core.compiler import CompileResult
from numba.core.environment import Environment, lookup_environment
from numba.core.funcdesc import PythonFunctionDescriptor
from numba.core.typing.templates import signature

_parts_of, _from_parts = CompileResult._reduce, CompileResult._rebuild  # pyright: ignore[reportPrivateUsage]
_SIZES = struct.Struct("<QQ")
_NAMES = ("modname", "qualname", "unique_name", "mangled_name", "env_name", "uid", "inline", "noalias")
_SCALARS = {str(t): t for t in (types.boolean, types.int32, types.int64, types.float32, types.float64, types.none)}


_OURS = "mafsil."
"""How the modules begin whose named tuples are kept: they are looked up, nothing of an entry makes them."""


class NotPlain(Exception):
    """The loop has a result type or a constant that the plain form has no word for."""


def written(result: Any) -> bytes:
    """The bytes of numba's result of a compilation.

    Raises:
        NotPlain: it cannot be written.
    """
    (name, form, (code, bitcode)), function, environment, typed, objects, lifted, _, reload, others = _parts_of(result)
    if form != "object" or objects or lifted or reload or typed.args != function.argtypes:
        raise NotPlain
    details: dict[str, Any] = {name: getattr(function, name) for name in _NAMES}
    details |= {"library": name, "args": list(function.args), "result": _word(function.restype)}
    details["environment"] = _environment(environment)
    details["others"] = [_environment(other) for other in others]
    head = json.dumps(details).encode()
    return _SIZES.pack(len(head), len(code)) + head + code + bitcode


def read(payload: bytes, arguments: tuple[Any, ...], target_context: Any) -> Any:
    """Numba's result of a compilation, its code loaded.

    Args:
        payload: as `written`.
        arguments: numba types of the arguments that the loop was compiled for.
        target_context: numba's.
    """
    head, code = _SIZES.unpack_from(payload)
    at = _SIZES.size
    details = json.loads(payload[at : at + head])
    library = (details["library"], "object", (payload[at + head : at + head + code], payload[at + head + code :]))
    result = _type(details["result"])

    def mangled(*_args: object, **_named: object) -> str:
        return details["mangled_name"]

    function = PythonFunctionDescriptor(
        native=True,
        doc="",
        typemap=None,
        restype=result,
        calltypes=None,
        args=tuple(details["args"]),
        kws=(),
        mangler=mangled,
        argtypes=arguments,
        **{name: details[name] for name in _NAMES if name != "mangled_name"},
    )
    environment = _restored(details["environment"])
    others = tuple(_restored(other) for other in details["others"])
    typed = signature(result, *arguments)
    return _from_parts(target_context, library, function, environment, typed, False, (), "", (), others)


def _environment(environment: Any) -> list[Any]:
    """Module, constants and name: constants are NumPy's element types alone."""
    return [environment.globals["__name__"], [_element(c) for c in environment.consts], environment.env_name]


def _element(constant: Any) -> str:
    if not isinstance(constant, np.dtype) or constant.hasobject or constant.names is not None:
        raise NotPlain
    return cast("np.dtype[Any]", constant).str


def _restored(words: list[Any]) -> Any:
    module, constants, name = words
    known = lookup_environment(name)
    if known is not None:
        return known
    made = Environment(importlib.import_module(module).__dict__)
    made.consts[:] = [np.dtype(constant) for constant in constants]
    made.env_name = name
    Environment._memo[name] = made  # pyright: ignore[reportPrivateUsage]
    return made


def _word(kind: Any) -> Any:
    """A result type in JSON: a scalar's name, an array as object, a tuple as list; a named one says its class too."""
    if str(kind) in _SCALARS and kind == _SCALARS[str(kind)]:
        return str(kind)
    if type(kind) is types.Array and kind.aligned:
        return {"of": _word(kind.dtype), "ndim": kind.ndim, "layout": kind.layout, "mutable": kind.mutable}
    if type(kind) in (types.Tuple, types.UniTuple):
        return [_word(item) for item in kind]
    if type(kind) in (types.NamedTuple, types.NamedUniTuple):
        named: Any = kind.instance_class
        if (
            named.__module__.startswith(_OURS)
            and getattr(importlib.import_module(named.__module__), named.__qualname__, None) is named
        ):
            return {
                "named": [named.__module__, named.__qualname__],
                "items": [_word(item) for item in kind],
            }
    raise NotPlain


def _type(word: Any) -> Any:
    if isinstance(word, str):
        return _SCALARS[word]
    if isinstance(word, list):
        return types.BaseTuple.from_types([_type(item) for item in cast("list[Any]", word)])
    if "named" in word:
        return _named(word["named"], [_type(item) for item in word["items"]])
    return types.Array(_type(word["of"]), word["ndim"], word["layout"], readonly=not word["mutable"])


def _named(place: list[str], items: list[Any]) -> Any:
    """The type of a named tuple, its class looked up among our own."""
    module, name = place
    if not module.startswith(_OURS):
        raise NotPlain
    found = getattr(importlib.import_module(module), name)
    if not (isinstance(found, type) and issubclass(found, tuple)) or len(found._fields) != len(items):  # pyright: ignore
        raise NotPlain
    return types.BaseTuple.from_types(items, found)
