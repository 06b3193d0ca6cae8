"""The entry of the command line: language, grammar, one clear sentence on error, an exit code that tells."""

from __future__ import annotations

import io
import json
import os
import sys
import warnings
from contextlib import AbstractContextManager, nullcontext
from math import isfinite
from shutil import get_terminal_size
from typing import Any, cast

from mafsil import __version__
from mafsil.cli.answer import Answer, Laid, Tone, allow_colours, paint, tone_of
from mafsil.errors import FileError, InputError, JobError, MafsilError, ModelError
from mafsil.messages import LANGUAGES, clauses, in_line, language, say
from mafsil.messages.tables import wrap_line
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
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # A terminal that knows only ASCII gets codes instead of letters, not a failure.
            stream.reconfigure(errors="backslashreplace")
    allow_colours(allowed="--no-color" not in words)
    warnings.showwarning = _warn
    if "--debug" not in words:
        # NumPy's remarks about overflow: what comes of it is said in the answer, in the reader's language.
        warnings.filterwarnings("ignore", category=RuntimeWarning)
    try:
        with _notices(words):
            return _run(words)
    except MafsilError as error:
        if "--debug" in words:
            raise
        if "--json" in words:
            _print_error(error)
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
        if isinstance(error, SystemError) and isinstance(error.__cause__, KeyboardInterrupt):
            # Ctrl-C just when a compiled loop gave its result.
            _complain(say("cli.interrupted"))
            return INTERRUPTED
        if "--debug" in words:
            raise
        _complain(say("cli.internal", kind=type(error).__name__, reason=str(error)))
        return FAILED


def _run(words: list[str]) -> int:
    _choose_language(words)
    from mafsil.cli.parser import as_files, parser, put_options_first
    from mafsil.cli.registry import COMMON, operation
    from mafsil.cli.status_line import LINE

    grammar = parser(__version__, words)
    try:
        given = vars(grammar.parse_args(put_options_first(words)))
    except SystemExit as leaving:
        # --help and --version have printed what they had to say.
        sys.stdout.flush()
        return int(leaving.code or 0)
    name = given.pop("command")
    as_json = bool({common.name: given.pop(common.name, None) for common in COMMON}["json"])
    if name is None:
        grammar.print_help()
        return DONE
    with as_files(operation(name), given) as arguments:
        if "robot" in arguments:
            from mafsil.cli.equipment import equip_robot

            arguments["robot"] = equip_robot(arguments["robot"], arguments)
        with nullcontext() if operation(name).serves else LINE.counting():
            answer = operation(name)(**arguments)
    _print(answer, as_json=as_json)
    if answer.interrupted:
        return INTERRUPTED
    return DONE if answer.refusal is None else FAILED


def _notices(words: list[str]) -> AbstractContextManager[None]:
    """What the package tells its logger about work of seconds, shown where somebody watches."""
    if not (sys.stderr.isatty() or "--progress" in words):
        return nullcontext()
    from mafsil.cli.status_line import shown

    return shown(lambda sentence: _complain(sentence, "plain"))


def _choose_language(words: list[str]) -> None:
    """Before the grammar exists, because its words are in that language; a wrong code is left to the grammar."""
    for k, word in enumerate(words):
        code = word.partition("=")[2] if word.startswith("--lang=") else ""
        if word == "--lang":
            code = words[k + 1] if k + 1 < len(words) else ""
        if code in LANGUAGES:
            language(code)


def _print(answer: Answer, *, as_json: bool) -> None:
    lines = [piece for line in answer.lines for piece in _shown(line, refused=line == answer.refusal)]
    if as_json:
        lines = [json.dumps(_plain(answer.data), ensure_ascii=False, indent=2, allow_nan=False)]
    if lines:
        print("\n".join(lines), flush=True)
    # On one screen the reason is read once; in a pipe each stream has it.
    said = not as_json and answer.refusal in answer.lines and sys.stdout.isatty() and sys.stderr.isatty()
    if answer.refusal is not None and not said:
        _complain(answer.refusal)


def _shown(line: str, *, refused: bool) -> list[str]:
    """A line of an answer as it is printed; the reason of a no is bad."""
    pieces = [line] if isinstance(line, Laid) else _fit(visible(line))
    return [paint(piece, "bad" if refused else tone_of(line), sys.stdout) for piece in pieces]


def _fit(line: str) -> list[str]:
    """A line as it is printed: wrapped between words where somebody watches a terminal that is narrower."""
    columns = get_terminal_size().columns
    if not sys.stdout.isatty() or len(line) <= columns:
        return [in_line(line)]
    return [in_line(piece) for piece in wrap_line(line, columns)]


def _print_error(error: MafsilError) -> None:
    """The error for machines: its code, and its sentence in all languages."""
    sentences = {code: visible(error.message(code)) for code in LANGUAGES}
    print(json.dumps({"error": {"code": error.key, "sentence": sentences}}, ensure_ascii=False, indent=2), flush=True)


def _plain(value: Any) -> Any:
    """Arrays as lists; numbers that are not finite, which JSON does not know, as null."""
    if hasattr(value, "tolist"):
        return _plain(value.tolist())
    if isinstance(value, dict):
        return {str(key): _plain(inner) for key, inner in cast("dict[Any, Any]", value).items()}
    if isinstance(value, list | tuple):
        return [_plain(inner) for inner in cast("list[Any]", value)]
    if isinstance(value, float):
        return value if isfinite(value) else None
    return value if isinstance(value, bool | int | str) or value is None else str(value)


def _complain(sentence: str, tone: Tone = "bad") -> None:
    """One line on stderr; lines of longer answers are clauses of it."""
    lines = [" ".join(line.split()) for line in sentence.splitlines() if line.strip()]
    joined = clauses([*(each.rstrip(".") for each in lines[:-1]), *lines[-1:]]).replace(":" + clauses(["", ""]), ": ")
    line = in_line(visible(joined))
    print(f"{paint('mafsil:', tone, sys.stderr)} {line}", file=sys.stderr, flush=True)


def _warn(message: Warning | str, *where: object, **more: object) -> None:
    """A warning is a sentence; the line of our source that gave it helps nobody."""
    _complain(str(message), "warning")


if __name__ == "__main__":
    sys.exit(main())
