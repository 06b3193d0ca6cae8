"""How planning ended: a path with its account, or the reason why there is none; at Ctrl-C the best path so far.

A reason is a text in the present language that can be said again in the other one. Where Ctrl-C comes just when a
compiled loop gives its result, Python raises a SystemError whose cause it is.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from functools import wraps
from threading import local
from typing import TYPE_CHECKING, Any, ParamSpec, Protocol, Self, TypeAlias, TypeVar

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import JointVector
from mafsil.messages import clauses, say
from mafsil.planning.problem import length_of

if TYPE_CHECKING:
    from mafsil.planning.placement_answer import BasePlacement


class PlanningStatus(Status):
    """Whether there is a path."""

    FOUND = ("planning.found", True)
    START_BLOCKED = ("planning.start_blocked", False)
    GOAL_BLOCKED = ("planning.goal_blocked", False)
    START_OUTSIDE = ("planning.start_outside", False)
    GOAL_OUTSIDE = ("planning.goal_outside", False)
    START_OFF = ("planning.start_off", False)
    GOAL_OFF = ("planning.goal_off", False)
    UNREACHABLE = ("planning.unreachable", False)
    SEPARATED = ("planning.separated", False)
    LOCAL_MINIMUM = ("planning.local_minimum", False)
    NOT_FOUND = ("planning.not_found", False)
    PATH_BLOCKED = ("planning.path_blocked", False)
    FINE_BLOCKED = ("planning.fine_blocked", False)
    DEADLOCK = ("planning.deadlock_proved", False)
    NOT_COORDINATED = ("planning.not_coordinated", False)


@dataclass(frozen=True, eq=False, repr=False)
class Plan(Answer, data="path length reason interrupted planner configurations segments nodes seconds"):
    """A path, or why there is none; true if there is one.

    `SEPARATED` is said by exact methods only, which looked at everything; searches say `NOT_FOUND` in their budget.

    Attributes:
        status: how it ended.
        path: (k, n) from start to goal; where there is none, what was reached [rad | m].
        planner: its name.
        configurations, segments: how many were looked at.
        nodes: of the graph or trees.
        seconds: that it took.
        reason: what stands in the way, in words, where that is known.
        interrupted: whether Ctrl-C ended the search, which gave its best so far.
    """

    status: PlanningStatus
    path: JointVector
    planner: str
    configurations: int
    segments: int
    nodes: int
    seconds: float
    reason: str = ""
    interrupted: bool = field(default=False, kw_only=True)

    @property
    def length(self) -> float:
        """Of the path; infinite where there is none [rad | m]."""
        return length_of(self.path) if self else np.inf

    def explain(self, language: str | None = None) -> str:
        """The status, the reason, and the account."""
        reason = reason_text(self.reason, language)
        first = self.status.sentence(language) + (f" ({reason})" if reason else "")
        details = {"planner": self.planner, "nodes": self.nodes, "configurations": self.configurations}
        more = {"segments": self.segments, "seconds": self.seconds, "points": len(self.path), "length": self.length}
        account = "planning.account" if self else "planning.account_no_path"
        lines = [first, say(account, language=language, **details, **more)]
        if self.interrupted:
            lines.insert(1, say("planning.interrupted", language=language))
        return "\n".join(lines)


class Sayable(Protocol):
    """What explains itself in either language."""

    def explain(self, *, language: str | None = None) -> str:
        """The text, in `en` or `ar` or the present language."""
        ...


Part: TypeAlias = tuple[str, Mapping[str, object]] | Sayable
"""Key of a sentence in the catalogue and its values, or what explains itself."""


class Reason(str):
    """Sentences one after the other; empty without any.

    Args:
        parts: of each sentence its key and its values, or what says it.
    """

    __slots__ = ("parts",)
    parts: tuple[Part, ...]

    def __new__(cls, *parts: Part) -> Self:
        """The text in the present language."""
        found = super().__new__(cls, _say(parts, None))
        found.parts = parts
        return found

    def explain(self, language: str | None = None) -> str:
        """The text, in `en` or `ar` or the present language."""
        return _say(self.parts, language)

    def and_then(self, *others: str) -> Reason:
        """With further reasons behind it."""
        return Reason(*self.parts, *(part for other in others if isinstance(other, Reason) for part in other.parts))

    def __reduce__(self) -> tuple[Any, ...]:
        return Reason, self.parts


@dataclass(frozen=True, slots=True)
class Named:
    """What is said of something that has a name.

    Attributes:
        name: of it.
        said: of it.
    """

    name: str
    said: Sayable

    def explain(self, language: str | None = None) -> str:
        """`left: ...`."""
        return f"{self.name}: {self.said.explain(language=language)}"


@dataclass(frozen=True, slots=True)
class FirstLine:
    """The first line of a longer answer.

    Attributes:
        said: the answer.
    """

    said: Sayable

    def explain(self, language: str | None = None) -> str:
        """The line."""
        return self.said.explain(language=language).split("\n")[0]


def reason_text(reason: str, language: str | None = None) -> str:
    """A reason in a language; a plain text as it is.

    Args:
        reason: of a plan.
        language: `en` or `ar`, or the present one.
    """
    return reason.explain(language) if isinstance(reason, Reason) else reason


def _say(parts: tuple[Part, ...], language: str | None) -> str:
    return clauses([_one(part, language) for part in parts], language)


def _one(part: Part, language: str | None) -> str:
    if isinstance(part, tuple):
        key, values = part
        return say(key, language=language, **values)
    return part.explain(language=language)


P = ParamSpec("P")
Answered = TypeVar("Answered", bound="Plan | BasePlacement")


class _OfThread(local):
    def __init__(self) -> None:
        self.interrupted = False


_OF_THREAD = _OfThread()


def is_interruption(error: BaseException) -> bool:
    """Whether an error is Ctrl-C, by itself or as the cause of what a compiled loop raised.

    Args:
        error: that was caught.
    """
    return isinstance(error, KeyboardInterrupt) or (
        isinstance(error, SystemError) and isinstance(error.__cause__ or error.__context__, KeyboardInterrupt)
    )


@contextmanager
def best_kept(known: Callable[[], bool]) -> Generator[None]:
    """Ends what is inside at Ctrl-C where there is a best so far, else lets it pass.

    Args:
        known: whether there is a path already.
    """
    try:
        yield
    except (KeyboardInterrupt, SystemError) as error:
        if not is_interruption(error) or not known():
            raise
        _OF_THREAD.interrupted = True


def tells_of_interruption(search: Callable[P, Answered]) -> Callable[P, Answered]:
    """The same search, whose answer says where Ctrl-C ended it.

    Args:
        search: gives a plan or a placement.
    """

    @wraps(search)
    def answered(*args: P.args, **kwargs: P.kwargs) -> Answered:
        _OF_THREAD.interrupted = False
        try:
            found = search(*args, **kwargs)
        except SystemError as error:
            if is_interruption(error):
                raise KeyboardInterrupt from error
            raise
        return replace(found, interrupted=True) if _OF_THREAD.interrupted else found

    return answered
