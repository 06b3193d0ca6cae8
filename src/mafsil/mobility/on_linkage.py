"""Functions of a linkage: what is none is refused in our words, with what makes one."""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from typing import ParamSpec, TypeVar, cast

from mafsil.errors import InputError
from mafsil.mobility.linkages.linkage import Linkage

P = ParamSpec("P")
Result = TypeVar("Result")


def on_linkage(function: Callable[P, Result]) -> Callable[P, Result]:
    """The function, which refuses anything but a Linkage as its first argument.

    Args:
        function: whose first argument is called `linkage`.
    """

    @wraps(function)
    def call(*args: P.args, **named: P.kwargs) -> Result:
        given: object = args[0] if args else cast("dict[str, object]", named).get("linkage")
        if not isinstance(given, Linkage):
            raise InputError("mobility.needs_linkage", got=type(given).__name__)
        return function(*args, **named)

    return call
