"""What the package tells its logger while a command runs: lines on stderr, and on a terminal what is being compiled."""

from __future__ import annotations

import logging
import shutil
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager

from mafsil.code_store import LOGGER

_WIPED = "\r\x1b[K"


class _Lines(logging.Handler):
    """Each record is one line, which wipes away what stands there for the moment: a bar of progress, a compilation."""

    def __init__(self, write: Callable[[str], None]) -> None:
        super().__init__()
        self._line = write

    def emit(self, record: logging.LogRecord) -> None:
        if record.name != LOGGER:
            wipe()
            self._line(record.getMessage())
        elif sys.stderr.isatty():
            line = record.getMessage()[: shutil.get_terminal_size().columns - 1]
            print(f"{_WIPED}{line}", end="", file=sys.stderr, flush=True)


def wipe() -> None:
    """Clear the line of a terminal that says what is going on: an answer comes."""
    if sys.stderr.isatty():
        print(_WIPED, end="", file=sys.stderr, flush=True)


@contextmanager
def shown(write: Callable[[str], None]) -> Generator[None, None, None]:
    """While this lasts, notices are written.

    Args:
        write: takes one sentence.
    """
    loggers, lines = (logging.getLogger("mafsil"), logging.getLogger(LOGGER)), _Lines(write)
    before = [logger.level for logger in loggers]
    loggers[0].addHandler(lines)
    for logger, level in zip(loggers, (logging.INFO, logging.DEBUG), strict=True):
        logger.setLevel(level)
    try:
        yield
    finally:
        wipe()
        for logger, level in zip(loggers, before, strict=True):
            logger.setLevel(level)
        loggers[0].removeHandler(lines)
