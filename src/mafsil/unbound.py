"""Arguments that a signature cannot take: missing, unknown, given twice, too many; and names that nobody knows."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from difflib import get_close_matches
from importlib import import_module
from inspect import Parameter, Signature, isclass, signature
from pathlib import Path
from types import ModuleType
from typing import Any, cast, get_args

from numpy.typing import ArrayLike

from mafsil.errors import ArgumentError, UnknownNameError
from mafsil.messages import say
from mafsil.other_words import ARGUMENTS

SHORT = 3
"""Letters of a name from which on it is taken for the beginning of another."""


@dataclass(frozen=True, slots=True)
class Hint:
    """What to do, at the end of a sentence, in the reader's language.

    Attributes:
        key: of the catalogue; nothing is said without one.
        details: that it mentions.
    """

    key: str = ""
    details: dict[str, object] = field(default_factory=dict[str, object])

    def spoken(self, language: str | None = None) -> str:
        """The words, beginning with a semicolon."""
        return say(self.key, language=language, **self.details) if self.key else ""


def binding_error(
    function: Callable[..., object],
    owner: object,
    taken: Signature,
    args: tuple[Any, ...],
    named: dict[str, Any],
    hints: dict[str, Any],
) -> ArgumentError | None:
    """The error about arguments that cannot be bound; None if all can.

    Args:
        function: that was called.
        owner: the object or class that it is a method of, or None.
        taken: its signature, without the owner.
        args, named: what it was called with.
        hints: its annotations.
    """
    parameters = taken.parameters
    places = [name for name, one in parameters.items() if one.kind in (one.POSITIONAL_ONLY, one.POSITIONAL_OR_KEYWORD)]
    known, complete = _keywords(taken, hints)
    shown = call_text(function, owner)
    details: dict[str, object] = {"name": shown, "inputs": ", ".join(known)}
    doubtful = [name for name in named if name in places[: len(args)] or (complete and name not in known)]
    if doubtful:
        hint = _meant(doubtful, known)
        hint = hint if hint.key else maker_hint(function, owner)
        return ArgumentError("input.unexpected", problem=", ".join(doubtful), hint=hint, **details)
    kinds = {one.kind for one in parameters.values()}
    if len(args) > len(places) and Parameter.VAR_POSITIONAL not in kinds:
        first = hints.get(places[0]) if places else None
        alone = len(places) == 1 == len(known) or ArrayLike in (first, *get_args(first))
        return _too_many(shown, places, known, args, maker_hint(function, owner), alone=alone)
    missing = [name for name in _names_without_default(taken) if name not in named and name not in places[: len(args)]]
    if not missing:
        return None
    given = ", ".join([*places[: len(args)], *named]) or "-"
    hint = maker_hint(function, owner)
    return ArgumentError("input.missing", missing=", ".join(missing), given=given, hint=hint, **details)


def _names_without_default(taken: Signature) -> Iterator[str]:
    """Names of the parameters that have no default."""
    for name, one in taken.parameters.items():
        if one.default is one.empty and one.kind not in (one.VAR_POSITIONAL, one.VAR_KEYWORD):
            yield name


def _keywords(taken: Signature, hints: dict[str, Any]) -> tuple[list[str], bool]:
    """Names that may be given, and whether there are no others: `**parts: Unpack[Parts]` says its names."""
    known = [name for name, one in taken.parameters.items() if one.kind is not Parameter.VAR_KEYWORD]
    further = [name for name in taken.parameters if name not in known]
    for name in further:
        named = getattr(next(iter(get_args(hints.get(name))), None), "__annotations__", None)
        if named is None:
            return [*known, f"**{name}"], False
        known += named
    return known, True


def _meant(names: list[str], known: list[str]) -> Hint:
    """The arguments that unknown names are other words for, or slips of."""
    close: list[str] = []
    for name in names:
        other = ARGUMENTS.get(name.casefold())
        begun = [each for each in known if len(name) >= SHORT and each.startswith(name.casefold())]
        close += [other] if other in known else begun or get_close_matches(name, known, n=2)
    return Hint("input.close_argument", {"close": ", ".join(dict.fromkeys(close))}) if close else Hint()


def _too_many(
    shown: str, places: list[str], known: list[str], args: tuple[Any, ...], hint: Hint, *, alone: bool
) -> ArgumentError:
    """Numbers are given one by one where they are one value, or what must be given by name is not."""
    details: dict[str, object] = {"name": shown, "most": len(places), "count": len(args)}
    if alone and all(isinstance(each, int | float) for each in args):
        row = ", ".join(f"{each:g}" for each in args)
        return ArgumentError("input.in_one", form=f"{shown}(({row}))", **details)
    rest = [name for name in known if name not in places][: len(args) - len(places)]
    form = ", ".join([*places, *(f"{name}=..." for name in rest)])
    return ArgumentError("input.by_name", form=f"{shown}({form})", hint=hint, **details)


def call_text(function: Callable[..., object], owner: object) -> str:
    """How a call is written: `plan`, `Checker`, `Checker.free`.

    Args:
        function: that is called.
        owner: the object or class that it is a method of, or None.
    """
    if owner is None:
        return function.__qualname__
    kind = cast("type", owner) if isclass(owner) else type(owner)
    return kind.__name__ if function.__name__ == "__init__" else f"{kind.__name__}.{function.__name__}"


def maker_hint(function: Callable[..., object], owner: object) -> Hint:
    """What makes an instance of a class from fewer arguments, where there is such a maker.

    Args:
        function: `__init__` of the class; nothing is said of others.
        owner: the instance.
    """
    kind: Any = type(owner)
    maker = maker_of(kind) if function.__name__ == "__init__" else None
    if maker is None:
        return Hint()
    inputs = signature(getattr(kind, maker.rpartition(".")[2])).parameters
    return Hint("input.maker", {"maker": maker, "inputs": ", ".join(inputs)})


def maker_of(kind: Any) -> str | None:
    """How an instance of a class is made from plain numbers, such as `Impedance.of`; None if in no other way.

    Args:
        kind: a class, or an annotation.
    """
    makers = [name for name in ("through", "of") if isclass(kind) and name in vars(kind)]
    return f"{kind.__name__}.{makers[0]}" if makers else None


def unknown_name(package: ModuleType, name: str) -> AttributeError:
    """The error that a package has no such name, with where there is one, or what looks like it.

    Args:
        package: that was asked.
        name: the attribute.
    """
    if name.startswith("_"):
        return AttributeError(f"module {package.__name__!r} has no attribute {name!r}", name=name, obj=package)
    known, top = list(dir(package)), Path(__file__).parent
    others = [".".join(stub.parent.relative_to(top).parts) for stub in top.glob("*/**/__init__.pyi")]
    for other in sorted(others, key=lambda each: (not f"mafsil.{each}".startswith(f"{package.__name__}."), each)):
        if f"mafsil.{other}" != package.__name__:
            names = dir(import_module(f"mafsil.{other}"))
            known += [f"mf.{other}.{each}" for each in names if not each.startswith("_")]
    return UnknownNameError(package.__name__, name, known)
