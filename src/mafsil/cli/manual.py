"""What the registry of commands writes: `mafsil man`, in the language in force, and `mafsil completion` for a shell."""

from __future__ import annotations

from shlex import quote

from mafsil import __version__
from mafsil.cli.answer import Answer, Laid
from mafsil.cli.registry import COMMON, OPERATIONS, ROBOT_OPTIONS, Operation, Parameter, robot_options
from mafsil.messages import LANGUAGES, say
from mafsil.model import library

BASH = """_mafsil() {{
    local current="${{COMP_WORDS[COMP_CWORD]}}" previous="${{COMP_WORDS[COMP_CWORD-1]}}" words
    case "${{COMP_WORDS[1]}}" in
{cases}
    esac
    [ "$COMP_CWORD" -eq 1 ] && words={commands}
    [ "$previous" = --lang ] && words={languages}
    COMPREPLY=($(compgen -W "$words" -- "$current") $([ "$COMP_CWORD" -gt 1 ] && compgen -f -- "$current"))
}}
complete -o filenames -F _mafsil mafsil"""
ZSH = "autoload -U +X bashcompinit && bashcompinit"


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


def completion(shell: str) -> Answer:
    """The script, to be read by the shell at its start: `eval "$(mafsil completion bash)"`.

    Args:
        shell: `bash`, `zsh` or `fish`.
    """
    lines = _fish() if shell == "fish" else [*([ZSH] if shell == "zsh" else []), *_bash()]
    return Answer({"shell": shell, "script": "\n".join(lines)}, tuple(map(Laid, lines)))


def _options(operation: Operation) -> list[str]:
    own = (*operation.parameters, *robot_options(operation), *COMMON)
    return [*(parameter.option for parameter in own if not parameter.positional), "--help"]


def _values(operation: Operation) -> list[str]:
    """Words that may stand by themselves or behind an option: choices, and names of robots."""
    choices = [choice for parameter in operation.parameters for choice in parameter.choices]
    takes_robot = any(parameter.name == "robot" for parameter in operation.parameters)
    return [*dict.fromkeys([*choices, *(library.robots() if takes_robot else ())])]


def _bash() -> list[str]:
    cases = [
        f"        {operation.name}) words={quote(' '.join([*_options(operation), *_values(operation)]))} ;;"
        for operation in OPERATIONS
    ]
    commands = quote(" ".join([*(operation.name for operation in OPERATIONS), "--version", "--help", "--lang"]))
    return BASH.format(cases="\n".join(cases), commands=commands, languages=quote(" ".join(LANGUAGES))).split("\n")


def _fish() -> list[str]:
    lines: list[str] = []
    for operation in OPERATIONS:
        lines.append(
            f"complete -c mafsil -n __fish_use_subcommand -a {operation.name} -d {quote(say(operation.help_key))}"
        )
        seen = f"complete -c mafsil -n '__fish_seen_subcommand_from {operation.name}'"
        lines += [f"{seen} -l {option[2:]}" for option in _options(operation)]
        if values := _values(operation):
            lines.append(f"{seen} -a {quote(' '.join(values))}")
    return lines
