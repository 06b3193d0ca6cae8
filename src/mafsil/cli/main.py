"""The entry of the command line: language, grammar, one clear sentence on error, an exit code that tells."""

from __future__ import annotations

import json
import os
import sys
from typing import Any

from mafsil import __version__
from mafsil.cli.answer import Answer
from mafsil.errors import FileError, InputError, JobError, MafsilError, ModelError
from mafsil.messages import LANGUAGES, language, say
from mafsil.messages.visible import visible

DONE, FAILED, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 130
"""Exit codes: yes; an honest no, or a failure of ours or the machine's; the input is wrong; Ctrl-C."""


def main(arguments: list[str] | None = None) -> int:
    """Run one command.

    Args:
        arguments: the words after `mafsil`; those of the process if None.

    Returns:
        The exit code.
    """
    words = sys.argv[1:] if arguments is None else arguments
    try:
        return _run(words)
    except MafsilError as error:
        if "--debug" in words:
            raise
        _complain(error.message())
        return WRONG_INPUT if isinstance(error, InputError | ModelError | FileError | JobError) else FAILED
    except KeyboardInterrupt:
        _complain(say("cli.interrupted"))
        return INTERRUPTED
    except BrokenPipeError:
        # The reader has gone (`mafsil show panda | head`): nothing is wrong; keep the interpreter from flushing again.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return DONE
    except (OSError, MemoryError) as error:
        if "--debug" in words:
            raise
        _complain(say("cli.machine", reason=str(error) or type(error).__name__))
        return FAILED
    except Exception as error:
        if "--debug" in words:
            raise
        _complain(say("cli.internal", kind=type(error).__name__, reason=str(error)))
        return FAILED


def _run(words: list[str]) -> int:
    _choose_language(words)
    from mafsil.cli.parser import parser
    from mafsil.cli.registry import operation

    grammar = parser(__version__)
    try:
        given = vars(grammar.parse_args(words))
    except SystemExit as leaving:
        # --help and --version have printed what they had to say.
        sys.stdout.flush()
        return int(leaving.code or 0)
    name = given.pop("command")
    as_json, _, _ = (given.pop(common, None) for common in ("json", "lang", "debug"))
    if name is None:
        grammar.print_help()
        return DONE
    answer = operation(name)(**given)
    _print(answer, as_json=bool(as_json))
    return DONE if answer.refusal is None else FAILED


def _choose_language(words: list[str]) -> None:
    """Before the grammar exists, because its words are in that language; a wrong code is left to the grammar."""
    for k, word in enumerate(words):
        code = word.partition("=")[2] if word.startswith("--lang=") else ""
        if word == "--lang":
            code = words[k + 1] if k + 1 < len(words) else ""
        if code in LANGUAGES:
            language(code)


def _print(answer: Answer, *, as_json: bool) -> None:
    if as_json:
        text = json.dumps(answer.data, ensure_ascii=False, indent=2, default=_plain)
    else:
        text = "\n".join(visible(line) for line in answer.lines)
    if text:
        print(text, flush=True)
    if answer.refusal is not None:
        _complain(answer.refusal)


def _plain(value: Any) -> Any:
    """Arrays and NumPy numbers as lists and numbers."""
    if hasattr(value, "tolist"):
        return value.tolist()
    return str(value)


def _complain(sentence: str) -> None:
    """One line on stderr."""
    line = visible(" ".join(sentence.split()))
    try:
        print(f"mafsil: {line}", file=sys.stderr, flush=True)
    except UnicodeEncodeError:
        print(f"mafsil: {line.encode('ascii', 'backslashreplace').decode()}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
