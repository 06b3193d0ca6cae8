"""Every exception of mafsil. Each carries its facts and builds its own sentence, in the language of the reader."""

from __future__ import annotations

from mafsil.messages import say


class MafsilError(Exception):
    """Base of all errors raised by mafsil.

    Attributes:
        key: name of the sentence in the message catalogue, `area.name`; stable, usable as an error code.
        facts: the values that the sentence mentions.
    """

    def __init__(self, key: str, **facts: object) -> None:
        super().__init__(key)
        self.key = key
        self.facts = facts

    def __str__(self) -> str:
        return self.message()

    def message(self, language: str | None = None) -> str:
        """The sentence, in the given language (`en`, `ar`) or the current one."""
        return say(self.key, language=language, **self.facts)

    def __reduce__(self) -> tuple[object, ...]:
        return (_rebuild, (type(self), self.key, self.facts))


class InputError(MafsilError, ValueError):
    """An argument is wrong: its name, the place, the value, the limit and what to do stand in the sentence."""


class ModelError(MafsilError, ValueError):
    """A robot description contradicts itself or cannot be a mechanism."""


class FileError(MafsilError, ValueError):
    """A file is missing, unreadable, malformed or hostile."""


class JobError(MafsilError, ValueError):
    """A job or scenario asks for something impossible or incomplete."""


class KernelError(MafsilError, RuntimeError):
    """Machine code could not be made or failed its self-test."""


def _rebuild(kind: type[MafsilError], key: str, facts: dict[str, object]) -> MafsilError:
    return kind(key, **facts)
