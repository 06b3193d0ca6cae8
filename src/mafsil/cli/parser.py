"""The command line's grammar, generated from the registry of operations; every word of it can be Arabic.

The words come in the order of that grammar, though options stand anywhere and lists are written in any usual way:

1. Cut off what stands before the command.
2. Sort the words behind it into options with their values and words without a name; refuse an option that is not known.
3. Split lists of numbers at commas and brackets.
4. Exchange two words without a name that only fit the other way round.

`-` in the place of a file is what standard input holds, kept as a file as long as a command runs.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections.abc import Collection, Generator, Iterable
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NoReturn

from mafsil import other_words
from mafsil.cli.registry import COMMON, OPERATIONS, REPEATED, Operation, Parameter, robot_options
from mafsil.errors import FileError, InputError
from mafsil.messages import in_line, say, template
from mafsil.messages.visible import visible

STANDARD_INPUT = "-"
LARGEST = 200_000_000
"""Bytes; the readers behind it have narrower limits of their own."""
_ROOTS = {b"mujoco": ".xml", b"sdf": ".sdf"}
_ROOT = re.compile(rb"<\s*([a-z]\w*)", re.IGNORECASE)
_PROLOGUE = re.compile(rb"<\?.*?\?>|<!--.*?-->|<!.*?>", re.DOTALL)
_HELP = Parameter("help", "flag")
NEGATIVE = re.compile(r"^-(?:\.?\d|pi|inf|nan)")
_NUMERIC = re.compile(r"[\[(]*[+-]?(?:\.?\d|pi|inf|nan)(?!.*\.[a-z])[^/\\]*", re.IGNORECASE)
"""What may stand in a list of numbers: not a file such as `3r.toml`."""
_BETWEEN = re.compile(r"[,;،\s]+")
_SENTENCES = {
    "usage: ": "argparse_usage",
    "positional arguments": "argparse_positionals",
    "options": "argparse_options",
    "show this help message and exit": "argparse_help",
    "argument %(argument_name)s: %(message)s": "argparse_argument",
    "the following arguments are required: %s": "argparse_required",
    "unrecognized arguments: %s": "argparse_unrecognized",
    "invalid choice: %(value)r (choose from %(choices)s)": "argparse_choice",
    "expected one argument": "argparse_one",
    "expected at least one argument": "argparse_at_least_one",
    "ambiguous option: %(option)s could match %(matches)s": "argparse_ambiguous",
    "ignored explicit argument %r": "argparse_explicit",
}


class Parser(argparse.ArgumentParser):
    """argparse that raises instead of leaving, and takes `-0.2`, `-1e-3` and `-pi/2` for numbers."""

    def __init__(self, **options: Any) -> None:
        super().__init__(allow_abbrev=False, **options)
        self._negative_number_matcher = NEGATIVE

    def _check_value(self, action: argparse.Action, value: Any) -> None:
        """Refuse what is not among the choices, and offer what looks like it."""
        choices = list(map(str, action.choices or ()))
        named_elsewhere = [word for word in other_words.COMMANDS.get(str(value).casefold(), ()) if word in choices]
        close = named_elsewhere or get_close_matches(str(value)[:80], choices, n=3, cutoff=0.5)
        if action.choices is not None and value not in choices and close:
            raise argparse.ArgumentError(
                action, say("cli.argparse_choice_close", value=str(value), close=", ".join(close))
            )
        super()._check_value(action, value)

    def format_help(self) -> str:
        """The help, every line of it readable in a terminal of either direction."""
        return "\n".join(in_line(line) for line in super().format_help().split("\n"))

    def error(self, message: str) -> NoReturn:
        """Raise what argparse has to say.

        Raises:
            UsageError: always.
        """
        raise UsageError("cli.usage", message=visible(message), command=self.prog)


def parser(version: str, typed: Collection[str]) -> Parser:
    """The grammar, in the language now in force.

    Args:
        version: of the package.
        typed: the words; a command that is not among them has its name alone, as nothing of it will be read.
    """
    _translate()
    main = Parser(
        prog="mafsil",
        description=say("cli.description"),
        epilog=say("cli.epilog"),
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    main.add_argument("--version", action="version", version=f"mafsil {version}", help=say("cli.version"))
    _add_common(main)
    commands = main.add_subparsers(dest="command", metavar=say("cli.command"), title=say("cli.commands"))
    for operation in OPERATIONS:
        words = _escape(say(operation.help_key))
        command = commands.add_parser(operation.name, help=words, description=words)
        if operation.name in typed:
            _add_parameters(command, operation)
            _add_common(command)
    return main


def _add_common(command: Parser) -> None:
    """Options of every command; SUPPRESS keeps what was said before the command."""
    for option in COMMON:
        command.add_argument(option.option, default=argparse.SUPPRESS, help=say(option.explained), **_rules(option))


def _add_parameters(command: Parser, operation: Operation) -> None:
    for parameter in operation.parameters:
        words = _escape(say(operation.parameter_key(parameter)))
        if _is_long(parameter):
            words += f": {', '.join(parameter.choices)}"
        flag = parameter.name if parameter.positional else parameter.option
        command.add_argument(flag, help=words, **_rules(parameter))
    for option in robot_options(operation):
        rules: dict[str, Any] = _rules(option) | ({"action": "append"} if option.name in REPEATED else {})
        words = _escape(say(f"cli.{option.name}"))
        command.add_argument(option.option, dest=f"robot_{option.name}", default=argparse.SUPPRESS, help=words, **rules)


def _rules(parameter: Parameter) -> dict[str, Any]:
    if parameter.kind == "flag":
        return {"action": "store_true"}
    rules: dict[str, Any] = {"metavar": parameter.metavar or parameter.name.upper(), "type": str}
    if parameter.choices:
        rules["choices"] = parameter.choices
        rules["metavar"] = rules["metavar"] if parameter.positional or _is_long(parameter) else None
    if parameter.many:
        rules["nargs"] = "*" if parameter.positional else "+"
    elif parameter.positional and not parameter.required:
        rules["nargs"] = "?"
    if not parameter.positional:
        rules["required"] = parameter.required
    return rules


def _is_long(parameter: Parameter) -> bool:
    """Whether an option has too many choices for the usage: the help lists them instead."""
    return not parameter.positional and len(parameter.choices) > 5


def _escape(words: str) -> str:
    """Argparse formats help with %: a lone one would be an error."""
    return words.replace("%", "%%")


def _translate() -> None:
    """Give argparse our sentences: it asks `_` for each of its own."""

    def ours(message: str) -> str:
        return template(f"cli.{_SENTENCES[message]}") if message in _SENTENCES else message

    argparse._ = ours  # pyright: ignore[reportAttributeAccessIssue]


def known_sentences() -> Iterable[str]:
    """Names of the messages that replace argparse's own."""
    return _SENTENCES.values()


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


@contextmanager
def as_files(operation: Operation, given: dict[str, Any]) -> Generator[dict[str, Any], None, None]:
    """The arguments with a file in the place of `-`.

    Args:
        operation: that is called.
        given: its arguments by name.

    Raises:
        FileError: nothing comes, or too much, or two arguments ask for it.
    """
    asking = [one.name for one in operation.parameters if one.reads and given.get(one.name) == STANDARD_INPUT]
    if not asking:
        yield given
        return
    if len(asking) > 1:
        raise FileError("cli.stdin_twice", names=", ".join(asking))
    data = sys.stdin.buffer.read(LARGEST + 1)
    if not data.strip() or len(data) > LARGEST:
        raise FileError("cli.stdin_empty" if not data.strip() else "cli.stdin_large", limit=LARGEST)
    with TemporaryDirectory(prefix="mafsil-") as folder:
        path = Path(folder) / f"stdin{_ending(operation, asking[0], data)}"
        path.write_bytes(data)
        yield {**given, asking[0]: str(path)}


def _ending(operation: Operation, name: str, data: bytes) -> str:
    """The ending that tells a reader what the data are: by their first element or sign, else the argument's own."""
    start = _PROLOGUE.sub(b"", data[:100_000]).lstrip(b"\xef\xbb\xbf \t\r\n")
    if start.startswith(b"<"):
        root = _ROOT.match(start)
        return _ROOTS.get(root.group(1).lower() if root else b"", ".urdf")
    if start.startswith(b"{"):
        return ".json"
    endings = next(one.endings for one in operation.parameters if one.name == name)
    return endings[0] if endings else ".toml"
