"""One gate for the arguments of public functions, classes and methods: what they raise at a wrong one, in our words.

A call costs nothing more than a Python call until an exception comes out of it. Then `mafsil.misuse` holds its
arguments against their annotations, and the first that does not fit is named, with what it should be and what it is.
What fits is not to blame: the exception goes on as it is. Only what is said to be True or False is looked at before a
call, where it is given by name: anything would pass for one of them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import wraps
from inspect import isclass, isfunction
from types import MethodType, ModuleType
from typing import TYPE_CHECKING, Any, ParamSpec, TypeVar, cast
from weakref import WeakSet

from mafsil.lazy_module import lazily

if TYPE_CHECKING:
    import mafsil.misuse as misuse
    import mafsil.unbound as unbound
else:
    misuse = lazily("mafsil.misuse")
    unbound = lazily("mafsil.unbound")

P = ParamSpec("P")
Result = TypeVar("Result")
MISUSE = (TypeError, AttributeError, ValueError, LookupError, ArithmeticError, AssertionError, RecursionError)
"""What Python and NumPy raise at arguments of a wrong kind."""
COMPILING = ("mafsil.kernels", "mafsil.expression")
"""What these packages define is code of compilers: functions that are words of their languages, and methods that run
for every operation of an expression."""
MAKERS = ("__init__", "__call__")
"""What is called by the name of a class or of an object."""
_GUARDED: WeakSet[Callable[..., object]] = WeakSet()


def gated(value: Any) -> Any:
    """A public function, or a class and its methods, with the gate before it; what loops are compiled from as it is.

    Args:
        value: what stands under a public name.
    """
    if _compiles(value):
        return value
    if isfunction(value):
        return _guard(value) if value not in _GUARDED else value
    if isinstance(value, MethodType):
        return MethodType(gated(value.__func__), value.__self__)
    if isclass(value) and not issubclass(value, BaseException):
        for base in value.__mro__:
            if base.__module__.startswith("mafsil.") and not _compiles(base):
                _guard_class(base)
    return value


def unknown_name(package: ModuleType, name: str) -> AttributeError:
    """The error that a package has no such name.

    Args:
        package: that was asked.
        name: the attribute.
    """
    return unbound.unknown_name(package, name)


def _compiles(value: object) -> bool:
    home = str(getattr(value, "__module__", ""))
    return home.startswith(COMPILING) or home.endswith("_loops")


def _guard_class(owner: type) -> None:
    """The gate before what makes instances and before every public method of the class itself.

    Routines of a robot are no functions but compiled, with checks of their own: their calls cost what they cost.
    """
    for name, each in list(vars(owner).items()):
        if name.startswith("_") and name not in MAKERS:
            continue
        bound = type(each) in (classmethod, staticmethod)
        method = cast("Callable[..., object]", getattr(each, "__func__", each))
        if isfunction(method) and method not in _GUARDED:
            guarded = _guard(method)
            setattr(owner, name, type(each)(guarded) if bound else guarded)


def _guard(function: Callable[P, Result]) -> Callable[P, Result]:
    flags = frozenset(name for name, hint in function.__annotations__.items() if hint == "bool")

    @wraps(function)
    def call(*args: P.args, **named: P.kwargs) -> Result:
        try:
            if named and flags and not flags.isdisjoint(named):
                misuse.require_flags({name: named[name] for name in flags & named.keys()})
            return function(*args, **named)
        except MISUSE as error:
            fault = misuse.fault_of(function, args, named, error)
            if fault is None:
                raise
        raise fault

    _GUARDED.add(call)
    return call
