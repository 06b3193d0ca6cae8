"""Broken versions of public things.

1. A function's code is replaced in place by a call of its mutant, so that everybody who holds the function meets it;
   properties, lazy ones and class methods are functions underneath, and a class is broken after its `__init__`.
2. The mutant calls the true function. What that returns is perturbed: numbers by a thousandth and a thousandth, truths
   turned, text emptied, statuses exchanged, members of containers and attributes of objects likewise, two levels deep;
   what an iterator gives, as if it were returned. What draws or saves does nothing.
3. An error of mafsil that the true function raises is swallowed: a refusal that no longer happens must be noticed too.
"""

from __future__ import annotations

import copy
import importlib
import inspect
from collections.abc import Callable, Iterator, Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

import numpy as np

from mafsil.errors import MafsilError
from mafsil.expression import Expression

LITTLE = 1e-3


def break_target(target: str) -> None:
    """Break `package.module:Class.method`, `package.module:function`, `package.module:Class` or `quantity:name`.

    `page:docs/grasping.md` is a page of the documentation that is read as empty.

    Raises:
        AttributeError, ImportError: there is no such thing; the table of targets is out of date.
    """
    place, _, name = target.partition(":")
    if place == "quantity":
        _break_quantity(name)
        return
    if place == "page":
        _empty_page(name)
        return
    module = importlib.import_module(place)
    owner: Any = module
    *path, last = name.split(".")
    for each in path:
        owner = getattr(owner, each)
    thing = inspect.getattr_static(owner, last)
    if inspect.isclass(thing):
        replace_code(_function(thing.__init__), mutant_of_constructor)
    else:
        silent = last.startswith(("draw_", "save_"))
        replace_code(_function(thing), idle_mutant if silent else mutant_of_function)


def _break_quantity(name: str) -> None:
    """A quantity of robots: what its compiled routine returns."""
    from mafsil.robot import Robot

    thing = inspect.getattr_static(Robot, name)
    replace_code(_function(thing), lambda true: lambda self: mutant_of_function(true(self)))


def _empty_page(name: str) -> None:
    true = Path.read_text

    def read_text(self: Path, *args: Any, **named: Any) -> str:
        return "" if self.as_posix().endswith(name) else true(self, *args, **named)

    Path.read_text = read_text  # type: ignore[method-assign]


def _function(thing: Any) -> FunctionType:
    """The Python function underneath a descriptor or a wrapper."""
    while not isinstance(thing, FunctionType):
        for attribute in ("__func__", "fget", "func", "_compute", "__wrapped__"):
            inner = getattr(thing, attribute, None)
            if callable(inner):
                thing = inner
                break
        else:
            raise AttributeError(f"{thing!r} is no function of Python")
    return thing


def mutant_of_function(true: Callable[..., Any]) -> Callable[..., Any]:
    """The function with its results perturbed and its refusals swallowed."""

    def mutant(*args: Any, **named: Any) -> Any:
        try:
            result = true(*args, **named)
        except MafsilError:
            return 0.5
        return perturbed(result)

    return mutant


def idle_mutant(true: Callable[..., Any]) -> Callable[..., Any]:
    """The function that does nothing."""
    return lambda *args, **named: None


def mutant_of_constructor(true: Callable[..., Any]) -> Callable[..., Any]:
    """`__init__` that leaves perturbed attributes."""

    def mutant(self: Any, *args: Any, **named: Any) -> None:
        try:
            true(self, *args, **named)
        except MafsilError:
            return
        _perturb_attributes(self, 1)

    return mutant


def replace_code(function: FunctionType, mutate: Callable[[Callable[..., Any]], Callable[..., Any]]) -> None:
    """Make `function` itself call the mutant of a copy of it; who holds the function holds the mutant."""
    true = FunctionType(
        function.__code__, function.__globals__, function.__name__, function.__defaults__, function.__closure__
    )
    true.__kwdefaults__ = function.__kwdefaults__
    function.__signature__ = inspect.signature(function)  # type: ignore[attr-defined]
    name = f"_mutant_of_{function.__name__.strip('<>')}_{id(true)}"
    function.__globals__[name] = mutate(true)
    function.__code__ = _forwarding(name, function.__code__.co_freevars)
    function.__defaults__, function.__kwdefaults__ = None, None


def _forwarding(name: str, free: tuple[str, ...]) -> CodeType:
    """Code that calls the global `name`; it mentions the free variables, of which a function must keep its number."""
    lines = [
        "def outer():",
        f"    {' = '.join([*free, 'None'])}",
        "    def forward(*args, **named):",
        f"        if 0: {', '.join([*free, 'None'])}",
        f"        return {name}(*args, **named)",
        "    return forward",
    ]
    space: dict[str, Any] = {}
    exec("\n".join(lines), space)
    return space["outer"]().__code__


def perturbed(value: Any, depth: int = 2) -> Any:
    """Another value of the same kind, a little off."""
    match value:
        case bool() | np.bool_():
            return not value
        case Enum():
            return _next_member(value)
        case int() | np.integer():
            return value + 1
        case float() | np.floating() | complex() | Expression():
            return value * (1 + LITTLE) + LITTLE
        case str():
            return ""
        case None:
            return 0.5
        case np.ndarray():
            return _perturbed_array(value)
        case _ if depth == 0:
            return value
        case Mapping():
            return {key: perturbed(each, depth - 1) for key, each in value.items()} or {"": 0.5}
        case tuple() if hasattr(value, "_fields"):
            return type(value)(*(perturbed(each, depth - 1) for each in value))
        case list() | tuple() | set() | frozenset():
            return type(value)(perturbed(each, depth - 1) for each in value) or type(value)([0.5])
        case Iterator():
            return (perturbed(each, depth) for each in value)
        case FunctionType():
            return mutant_of_function(value)
        case _ if callable(value) and not isinstance(value, type) and not is_dataclass(value):
            return mutant_of_function(value)
        case _:
            return _perturbed_object(value, depth - 1)


def _next_member(value: Enum) -> Enum:
    """Another member; of a status one that says the opposite, where there is one."""
    members = list(type(value))
    after = [*members[members.index(value) + 1 :], *members[: members.index(value)], value]
    success = getattr(value, "succeeded", None)
    return next((other for other in after if getattr(other, "succeeded", None) != success), after[0])


def _perturbed_array(value: np.ndarray[Any, Any]) -> Any:
    if value.dtype == np.bool_:
        return ~value
    if value.dtype.kind == "f":
        return value * (1 + LITTLE) + LITTLE
    if value.dtype.kind in "iu":
        return value + 1
    return value[..., :0] if value.ndim else value


def _perturbed_object(value: Any, depth: int) -> Any:
    """A copy with its attributes perturbed; the object itself where it cannot be copied."""
    try:
        other = copy.copy(value)
    except Exception:
        return value
    if other is value:
        return value
    _perturb_attributes(other, depth)
    return other


def _perturb_attributes(thing: Any, depth: int) -> None:
    names = list(getattr(thing, "__dict__", {})) or (
        [field.name for field in fields(thing)] if is_dataclass(thing) else list(getattr(thing, "__slots__", ()))
    )
    for name in names:
        if hasattr(thing, name):
            object.__setattr__(thing, name, perturbed(getattr(thing, name), depth))
