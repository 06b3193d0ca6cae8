"""`mafsil man`: the manual page, in the language in force, from the registry of commands."""

from __future__ import annotations

from mafsil import __version__
from mafsil.cli.answer import Answer, Laid
from mafsil.cli.operation import Operation, Parameter
from mafsil.cli.registry import COMMON, OPERATIONS, ROBOT_OPTIONS, robot_options
from mafsil.messages import say


def manual() -> Answer:
    """A page for `man`, in roff: `mafsil man > mafsil.1`, then `man ./mafsil.1`."""
    page = [
        f'.TH MAFSIL 1 "" "mafsil {__version__}"',
        f".SH {say('cli.man_name')}",
        f"mafsil \\- {_escape(say('cli.description'))}",
        f".SH {say('cli.man_synopsis')}",
        f".B mafsil\n{_escape(say('cli.command'))} ...",
        f".SH {say('cli.commands').upper()}",
        *(line for operation in OPERATIONS for line in _command(operation)),
        f".SH {say('cli.man_robot_options')}",
        *(line for option in ROBOT_OPTIONS for line in _entry(option, f"cli.{option.name}")),
        f".SH {say('cli.man_common_options')}",
        *(line for option in COMMON for line in _entry(option, option.explained)),
        f".SH {say('cli.man_notes')}",
        ".nf",
        *map(_escape, say("cli.epilog").strip().split("\n")),
        ".fi",
    ]
    lines = "\n".join(page).split("\n")
    return Answer({"page": "\n".join(lines)}, tuple(map(Laid, lines)))


def _command(operation: Operation) -> list[str]:
    words = [operation.name, *(_usage(parameter) for parameter in operation.parameters if parameter.positional)]
    lines = [f".SS {_escape(' '.join(words))}", _escape(say(operation.help_key))]
    for parameter in operation.parameters:
        lines += _entry(parameter, operation.parameter_key(parameter))
    if robot_options(operation):
        lines += [".PP", _escape(say("cli.man_see_robot_options"))]
    return lines


def _entry(parameter: Parameter, key: str) -> list[str]:
    """A tagged paragraph: the argument, what it means, and the words that it takes."""
    values = "|".join(parameter.choices) if parameter.choices else parameter.metavar or parameter.name.upper()
    shown = "" if parameter.kind == "flag" else f" {values}{' ...' if parameter.many else ''}"
    tag = _usage(parameter) if parameter.positional else f"{parameter.option}{shown}"
    return [".TP", f".B {_escape(tag)}", _escape(say(key))]


def _usage(parameter: Parameter) -> str:
    """A word without a name, in brackets if it may be left out."""
    word = (parameter.metavar or parameter.name.upper()) + (" ..." if parameter.many else "")
    return word if parameter.required else f"[{word}]"


def _escape(text: str) -> str:
    """Text that roff prints as it is: dashes that can be copied, no escapes, no line that begins a request."""
    plain = text.replace("\\", "\\e").replace("-", "\\-").replace("'", "\\(aq")
    return f"\\&{plain}" if plain.startswith((".", "\\(aq")) else plain
