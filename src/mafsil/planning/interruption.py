"""Ctrl-C while a path gets shorter: the best so far is given, and the answer says so; without one it goes on to you.

Where Ctrl-C comes just when a compiled loop gives its result, Python raises a SystemError whose cause it is.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from dataclasses import replace
from functools import wraps
from threading import local
from typing import ParamSpec, TypeVar

from mafsil.planning.outcome import Plan
from mafsil.planning.placement_answer import BasePlacement

P = ParamSpec("P")
Answered = TypeVar("Answered", bound=Plan | BasePlacement)


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
