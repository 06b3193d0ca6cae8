"""Every exception of mafsil. Each carries its details and builds its own sentence, in the language of the reader.

    InputError         an argument of a call is wrong (a ValueError)
    OperandError       two values do not go together under an operator (a TypeError too)
    ArgumentError      an argument is missing, unknown or of another kind (a TypeError too)
    UnknownNameError   no such attribute, with those that look like it (an AttributeError)
    ModelError         a robot description contradicts itself
    FileError          a file is missing, malformed or hostile
    JobError           a job asks for something impossible
    KernelError        machine code could not be made (a RuntimeError)

All are MafsilError. What a computation cannot find is no exception but an answer that is false (`mafsil.answer`).
"""

from __future__ import annotations

import sys
import warnings
from collections.abc import Iterable, Mapping
from difflib import get_close_matches
from typing import TYPE_CHECKING

from mafsil.lazy_module import lazily
from mafsil.messages import LANGUAGES, say
from mafsil.messages import language as chosen_language

if TYPE_CHECKING:
    import mafsil.other_words as other_words
else:
    other_words = lazily("mafsil.other_words")


class MafsilError(Exception):
    """Base of all errors raised by mafsil.

    Attributes:
        key: name of the sentence in the message catalogue, `area.name`; stable, usable as an error code.
        details: the values that the sentence mentions.
    """

    def __init__(self, key: str, **details: object) -> None:
        super().__init__(key)
        self.key = key
        self.details = details

    def __str__(self) -> str:
        return self.message()

    def message(self, language: str | None = None) -> str:
        """The sentence, in the given language (`en`, `ar`) or the current one."""
        return say(self.key, language=language, **self.details)

    def spoken(self, language: str | None = None) -> str:
        """The sentence, as the reason inside another one."""
        return self.message(language)

    def __reduce__(self) -> tuple[object, ...]:
        return (_rebuild, (type(self), self.key, self.details))


class InputError(MafsilError, ValueError):
    """An argument is wrong: its name, the place, the value, the limit and what to do stand in the sentence."""


class OperandError(InputError, TypeError):
    """Two values are joined by an operator that means nothing for them, such as a point added to a point."""


class ArgumentError(InputError, TypeError):
    """An argument is missing, unknown, or of another kind than its annotation: for Python's own callers a TypeError."""


class UnknownNameError(MafsilError, AttributeError):
    """An object of mafsil has no attribute of that name; the sentence says what to write, or which look like it."""

    def __init__(self, owner: str, name: str, known: Iterable[str]) -> None:
        """Args: what has no such attribute, the attribute, and the names that there are, `mf.x` those elsewhere."""
        public = [(letters_of(each.rpartition(".")[2]), each) for each in known if not each.startswith("_")]
        same = [each for key, each in public if key == letters_of(name)]
        within = owner.replace("mafsil", "mf", 1) + "."
        here = any(each.startswith(within) and each.endswith(f".{name}") for each in same)
        other = None if here else other_words.attribute(name)
        close = sorted(same, key=lambda each: each.rpartition(".")[2] != name) or _look_alike(letters_of(name), public)
        key = "attribute" if not (other or close) else "attribute_other" if other else "attribute_close"
        super().__init__(f"input.{key}", owner=owner, name=name, close=other or ", ".join(close[:5]))

    def __reduce__(self) -> tuple[object, ...]:
        return (_unknown_name, (self.details,))


def _look_alike(plain: str, public: list[tuple[str, str]]) -> list[str]:
    """The names that begin with the letters asked for; without any, those that differ from them by a slip."""
    longer = [each for key, each in public if plain and key.startswith(plain)]
    near = [] if longer else get_close_matches(plain, {key for key, _ in public}, n=3)
    return longer + [each for key in near for word, each in public if word == key]


class ModelError(MafsilError, ValueError):
    """A robot description contradicts itself or cannot be a mechanism."""


class FileError(MafsilError, ValueError):
    """A file is missing, unreadable, malformed or hostile."""


class JobError(MafsilError, ValueError):
    """A job or scenario asks for something impossible or incomplete."""


class KernelError(MafsilError, RuntimeError):
    """Machine code could not be made or failed its self-test."""


class MafsilWarning(UserWarning):
    """Base of all warnings given by mafsil: something was guessed, or looks wrong, and the work went on.

    Attributes:
        key: name of the sentence in the message catalogue, `area.name`; stable.
        details: the values that the sentence mentions.
    """

    def __init__(self, key: str, rebuilt: Mapping[str, object] | None = None, /, **details: object) -> None:
        self.key = key
        self.details = {**(rebuilt or {}), **details}
        # Whoever carries a warning to another process makes it again from its arguments alone.
        super().__init__(key, self.details)

    def __str__(self) -> str:
        return self.message()

    def message(self, language: str | None = None) -> str:
        """The sentence, in the given language (`en`, `ar`) or the current one."""
        return say(self.key, language=language, **self.details)


class ModelWarning(MafsilWarning):
    """A robot description was read, and something in it was guessed, changed or looks wrong."""


class InputWarning(MafsilWarning):
    """An argument is possible but looks wrong, such as degrees where radians are taken."""


def language(code: str | None = None) -> str:
    """Choose the language of all messages of this process, or return the current one.

    Args:
        code: `en` or `ar`; None changes nothing. The environment variable MAFSIL_LANG sets the language at start.

    Returns:
        The language now in force.

    Raises:
        InputError: another language; the sentence lists those there are.
    """
    if code is not None and code not in LANGUAGES:
        raise InputError("messages.language", code=code, known=", ".join(LANGUAGES))
    return chosen_language(code)


def warn(warning: MafsilWarning) -> None:
    """Give a warning at the line of the caller's own code, the nearest one outside this package."""
    level, frame = 2, sys._getframe(1)  # pyright: ignore[reportPrivateUsage]
    while frame.f_back is not None and str(frame.f_globals.get("__name__", "")).partition(".")[0] == "mafsil":
        level, frame = level + 1, frame.f_back
    warnings.warn(warning, stacklevel=level)


def letters_of(name: str) -> str:
    """Letters and digits of a name in small letters: names that differ in nothing else are taken for the same.

    Args:
        name: as typed.
    """
    return "".join(c for c in name.casefold() if c.isalnum())


def _unknown_name(details: dict[str, object]) -> UnknownNameError:
    known = str(details["close"]).split(", ")
    return UnknownNameError(str(details["owner"]), str(details["name"]), known)


def _rebuild(kind: type[MafsilError], key: str, details: dict[str, object]) -> MafsilError:
    return kind(key, **details)
