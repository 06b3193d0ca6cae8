"""The command line's grammar, generated from the registry of operations; every word of it can be Arabic."""

from __future__ import annotations

import argparse
from collections.abc import Collection, Iterable
from difflib import get_close_matches
from typing import Any, NoReturn

from mafsil import other_words
from mafsil.cli.operation import Operation, Parameter
from mafsil.cli.registry import COMMON, OPERATIONS, REPEATED, robot_options
from mafsil.cli.words import NEGATIVE, UsageError
from mafsil.messages import in_line, say, template
from mafsil.messages.visible import visible

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
