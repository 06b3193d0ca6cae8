"""The words of a command line in the order of the grammar: options stand anywhere, lists are written in any usual way.

1. Cut off what stands before the command.
2. Sort the words behind it into options with their values and words without a name; refuse an option that is not known.
3. Split lists of numbers at commas and brackets.
4. Exchange two words without a name that only fit the other way round.
"""

from __future__ import annotations

import re
from difflib import get_close_matches

from mafsil.cli.operation import Operation, Parameter
from mafsil.cli.registry import COMMON, OPERATIONS, robot_options
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.messages.visible import visible

_HELP = Parameter("help", "flag")
NEGATIVE = re.compile(r"^-(?:\.?\d|pi|inf|nan)")
_NUMERIC = re.compile(r"[\[(]*[+-]?(?:\.?\d|pi|inf|nan)(?!.*\.[a-z])[^/\\]*", re.IGNORECASE)
"""What may stand in a list of numbers: not a file such as `3r.toml`."""
_BETWEEN = re.compile(r"[,;،\s]+")


class UsageError(InputError):
    """The command line itself is wrong."""


def put_options_first(words: list[str]) -> list[str]:
    """The same command line with its options in front of the words without a name.

    Args:
        words: those after `mafsil`.

    Raises:
        UsageError: an option is not known, or there are more words than the command takes.
    """
    start = _command_at(words)
    operation = next((item for item in OPERATIONS if start is not None and item.name == words[start]), None)
    if start is None or operation is None:
        return words
    options, places = _sort(operation, words[start + 1 :])
    places = _place(operation, places)
    return [*words[: start + 1], *options, *(["--", *places] if places else [])]


def _command_at(words: list[str]) -> int | None:
    """Index of the command; options of every command may stand before it."""
    k = 0
    while k < len(words) and words[k].startswith("-"):
        k += 2 if words[k] == "--lang" else 1
    return k if k < len(words) else None


def _sort(operation: Operation, words: list[str]) -> tuple[list[str], list[str]]:
    """Options with their values; words without a name."""
    known = (*operation.parameters, *robot_options(operation), *COMMON, _HELP)
    named = {parameter.option: parameter for parameter in known if not parameter.positional}
    singles = sum(one.positional and one.required and not one.many for one in operation.parameters)
    options: list[str] = []
    places: list[str] = []
    k = 0
    while k < len(words):
        word = words[k]
        k += 1
        if word == "--":
            return options, [*places, *words[k:]]
        if not _is_option(word):
            places.append(word)
            continue
        options.append(word)
        name, _, attached = word.partition("=")
        parameter = _known(operation, named, name)
        if parameter is None or parameter.kind == "flag" or attached:
            continue
        end = _end_of_values(parameter, words, k, missing=singles - len(places))
        options += _numbers(parameter, words[k:end])
        k = end
    return options, places


def _is_option(word: str) -> bool:
    """Whether a word names an option; one with blanks, such as a row of a table, does not."""
    return word.startswith("-") and word != "-" and " " not in word and NEGATIVE.match(word) is None


def _known(operation: Operation, named: dict[str, Parameter], name: str) -> Parameter | None:
    if name == "-h":
        return None
    if name not in named:
        close = get_close_matches("--" + name.lstrip("-").lower()[:80], named, n=3, cutoff=0.6)
        key = "cli.unknown_option_close" if close else "cli.unknown_option"
        details = {"option": visible(name), "close": ", ".join(close)}
        raise UsageError("cli.usage", message=say(key, **details), command=f"mafsil {operation.name}")
    return named[name]


def _end_of_values(parameter: Parameter, words: list[str], start: int, *, missing: int) -> int:
    """Index behind the values of an option: one; or all, but for the words without a name that are still missing.

    Of a list of numbers those begin where a word is none; of a list of texts they are the last ones.
    """
    if not parameter.many:
        return min(start + 1, len(words)) if start < len(words) and not _is_option(words[start]) else start
    end, numbers = start, parameter.kind in ("number", "angle")
    while end < len(words) and not _is_option(words[end]):
        if numbers and end > start and missing > 0 and _NUMERIC.fullmatch(words[end]) is None:
            break
        end += 1
    return end if numbers else max(start + 1, end - max(missing, 0))


def _numbers(parameter: Parameter, words: list[str]) -> list[str]:
    """The words of a list, written with blanks, commas or in brackets."""
    if not parameter.many or parameter.kind not in ("number", "angle"):
        return words
    pieces = (piece for word in words for piece in _BETWEEN.split(word.strip().strip("[]()")))
    return [piece for piece in pieces if piece]


def _place(operation: Operation, words: list[str]) -> list[str]:
    """Words without a name in the order of the grammar."""
    taken = [parameter for parameter in operation.parameters if parameter.positional]
    if taken and taken[-1].many:
        singles = len(taken) - 1
        return [*words[:singles], *_numbers(taken[-1], words[singles:])]
    if len(words) > len(taken):
        extra = " ".join(visible(word) for word in words[len(taken) :])
        raise UsageError(
            "cli.usage", message=say("cli.too_many_words", words=extra), command=f"mafsil {operation.name}"
        )
    if len(words) == len(taken) == 2 and taken[1].recognises(words[0]) and not taken[1].recognises(words[1]):
        return words[::-1]
    return words
