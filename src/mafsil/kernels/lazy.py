"""A property computed at its first use and kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Generic, TypeVar, overload

Value = TypeVar("Value")


class lazy(Generic[Value]):
    """Like `functools.cached_property` without its lock, which in Python 3.11 all instances share for a whole compile.

    Two threads may both compute the value; what they compute is locked where it must be.
    """

    def __init__(self, compute: Callable[[Any], Value]) -> None:
        self._compute = compute
        self._name = compute.__name__
        self.__doc__ = compute.__doc__

    @overload
    def __get__(self, instance: None, owner: type) -> lazy[Value]: ...
    @overload
    def __get__(self, instance: object, owner: type | None = None) -> Value: ...
    def __get__(self, instance: object | None, owner: type | None = None) -> Any:
        if instance is None:
            return self
        return vars(instance).setdefault(self._name, self._compute(instance))


def preset(instance: object, **values: object) -> None:
    """Give lazy properties values that are known already: they are not computed then.

    Args:
        instance: whose properties.
        values: by the names of the properties.
    """
    vars(instance).update(values)
