"""Annotated shapes, checked while other tests run: `pytest --check-shapes` wraps every function that has them.

`Annotated[NDArray[np.float64], Shape("*batch", 3)]` becomes jaxtyping's `Float64[np.ndarray, "*batch 3"]`, which
beartype checks at each call, with one binding of every name per call. Annotations without a shape are not looked at.
"""

import pkgutil
import sys
import types
from collections.abc import Callable, Iterator
from functools import cached_property, reduce
from importlib import import_module
from operator import or_
from typing import Annotated, Any, Union, get_args, get_origin

import jaxtyping
import numpy as np
from beartype import beartype

from mafsil.arrays import Shape

KINDS = {np.float64: jaxtyping.Float64, np.bool_: jaxtyping.Bool}
COMPILED = ("loops", "_loops")
"""Modules whose functions are read as source and compiled: a wrapper would hide it."""


def watch(*packages: str) -> int:
    """Wrap the functions, methods and properties with annotated shapes in all modules of some packages.

    Returns:
        How many functions are checked from now on.
    """
    wrapped: dict[int, Any] = {}
    for module in list(_modules(packages)):
        for name, value in list(vars(module).items()):
            if getattr(value, "__module__", None) != module.__name__ or name.startswith("_"):
                continue
            if isinstance(value, types.FunctionType):
                checked = _checked(value)
                if checked is not value:
                    wrapped[id(value)] = (value, checked)
            elif isinstance(value, type):
                for attribute, member in list(vars(value).items()):
                    checked = _member(member)
                    if checked is not member and not attribute.startswith("_"):
                        wrapped[id(member)] = (member, checked)
                        setattr(value, attribute, checked)
    for module in [m for name, m in sys.modules.items() if name.partition(".")[0] == "mafsil"]:
        for name, value in list(vars(module).items()):
            if isinstance(value, types.FunctionType) and id(value) in wrapped:
                setattr(module, name, wrapped[id(value)][1])
    return len(wrapped)


def _modules(packages: tuple[str, ...]) -> Iterator[types.ModuleType]:
    for package in packages:
        root = import_module(package)
        yield root
        for found in pkgutil.walk_packages(root.__path__, f"{package}."):
            if not found.name.endswith(COMPILED):
                yield import_module(found.name)


def _member(member: Any) -> Any:
    """A method, static method, class method or property, checked if it has shapes; else itself."""
    if isinstance(member, types.FunctionType):
        return _checked(member)
    if isinstance(member, staticmethod | classmethod):
        checked = _checked(member.__func__)
        return member if checked is member.__func__ else type(member)(checked)
    if isinstance(member, property) and isinstance(member.fget, types.FunctionType):
        checked = _checked(member.fget)
        return member if checked is member.fget else property(checked, member.fset, member.fdel, member.__doc__)
    if isinstance(member, cached_property):
        checked = _checked(member.func)
        if checked is not member.func:
            name, member = member.attrname, cached_property(checked)
            member.attrname = name
    return member


def _checked(function: Any) -> Callable[..., Any]:
    """The function, its annotated shapes checked at each call; itself if it has none."""
    if not isinstance(function, types.FunctionType):
        return function
    shapes = {name: _shaped(_evaluated(text, function)) for name, text in function.__annotations__.items()}
    shapes = {name: shape for name, shape in shapes.items() if shape is not Any}
    if not shapes:
        return function
    bare = types.FunctionType(
        function.__code__, function.__globals__, function.__name__, function.__defaults__, function.__closure__
    )
    bare.__kwdefaults__, bare.__module__, bare.__qualname__ = (
        function.__kwdefaults__,
        function.__module__,
        function.__qualname__,
    )
    bare.__annotations__ = shapes
    checked = jaxtyping.jaxtyped(bare, typechecker=beartype)
    checked.__dict__.update(function.__dict__, __wrapped__=function)
    checked.__doc__ = function.__doc__
    return checked


def _evaluated(annotation: Any, function: types.FunctionType) -> Any:
    if not isinstance(annotation, str):
        return annotation
    try:
        return eval(annotation, function.__globals__)
    except (NameError, TypeError, AttributeError):  # a name that only type checkers import
        return Any


def _shaped(annotation: Any) -> Any:
    """The annotation in jaxtyping's words; Any where it says nothing of a shape."""
    origin, parts = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        found = [each for each in parts[1:] if isinstance(each, Shape)]
        return _array(parts[0], found[0]) if found and get_origin(parts[0]) is np.ndarray else Any
    if origin in (Union, types.UnionType):
        inner = [part if part in (None, type(None)) else _shaped(part) for part in parts]
        return Any if Any in inner else reduce(or_, inner)
    if origin is tuple and Ellipsis not in parts:
        inner = tuple(map(_shaped, parts))
        return tuple[inner] if any(part is not Any for part in inner) else Any
    return Any


def _array(array: Any, shape: Shape) -> Any:
    """The array type; a single number of the batch `()` is a NumPy number."""
    kind = get_args(get_args(array)[1])[0]
    checked = KINDS[kind][np.ndarray, str(shape)]
    return checked | kind if shape.dimensions == ("*batch",) else checked
