"""`mafsil completion`: a script that completes commands, options, choices and robots in a shell."""

from __future__ import annotations

from shlex import quote

from mafsil.cli.answer import Answer, Laid
from mafsil.cli.operation import Operation
from mafsil.cli.registry import COMMON, OPERATIONS, robot_options
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
