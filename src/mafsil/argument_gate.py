"""One gate for the arguments of all public functions and classes: what they raise at a wrong one is said in our words.

A call costs nothing more than a Python call until an exception comes out of it. Then `mafsil.misuse` holds its
arguments against their annotations, and the first that does not fit is named, with what it should be and what it is.
What fits is not to blame: the exception goes on as it is.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from inspect import isclass, isfunction
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar, cast
from weakref import WeakSet

from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.misuse as misuse
else:
    misuse = lazily("mafsil.misuse")

P = ParamSpec("P")
Result = TypeVar("Result")
MISUSE = (TypeError, AttributeError, ValueError, LookupError, ArithmeticError, AssertionError, RecursionError)
"""What Python and NumPy raise at arguments of a wrong kind."""
COMPILING = "mafsil.kernels"
"""Functions of this package are words of the language of loops: the compiler knows them by what they are."""
_GUARDED: WeakSet[Callable[..., object]] = WeakSet()


def gated(value: Any) -> Any:
    """A public function or class with the gate before it; anything else, and what loops are compiled from, as it is.

    Args:
        value: what stands under a public name.
    """
    home = str(getattr(value, "__module__", ""))
    if home.startswith(COMPILING) or home.endswith("_loops"):
        return value
    if isfunction(value):
        return _guarded(value) if value not in _GUARDED else value
    if isclass(value) and not issubclass(value, BaseException):
        for base in value.__mro__:
            if base.__module__.startswith("mafsil."):
                _guard_makers(base)
    return value


def _guard_makers(base: type) -> None:
    """The gate before what makes instances: `__init__` and the public class methods of a class itself."""
    for name, each in list(vars(base).items()):
        if name == "__init__" and isfunction(each) and each not in _GUARDED:
            setattr(base, name, _guarded(each))
        elif isinstance(each, classmethod) and not name.startswith("_"):
            maker = cast("Callable[..., object]", each.__func__)
            if maker not in _GUARDED:
                setattr(base, name, classmethod(_guarded(maker)))


def _guarded(function: Callable[P, Result]) -> Callable[P, Result]:
    @wraps(function)
    def call(*args: P.args, **named: P.kwargs) -> Result:
        try:
            return function(*args, **named)
        except MISUSE as error:
            fault = misuse.fault_of(function, args, named, error)
            if fault is None:
                raise
        raise fault

    _GUARDED.add(call)
    return call
