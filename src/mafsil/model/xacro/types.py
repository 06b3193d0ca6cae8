"""Types in expressions: the functions that make their values stand for them, as `python.str` does."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import cast

from mafsil.model.xacro.fault import wrong
from mafsil.model.xacro.values import Function, Value

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
