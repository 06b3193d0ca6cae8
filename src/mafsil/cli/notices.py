"""What the package tells its logger while a command runs: lines on stderr, and on a terminal what is being compiled."""

from __future__ import annotations

import logging
from collections.abc import Callable, Generator
from contextlib import contextmanager

from mafsil.cli.status_line import LINE
from mafsil.code_store import LOGGER


class _Lines(logging.Handler):
    """Each record is one line, which wipes away what stands there for the moment: a bar of progress, a compilation."""

    def __init__(self, write: Callable[[str], None]) -> None:
        super().__init__()
        self._line = write

    def emit(self, record: logging.LogRecord) -> None:
        if record.name == LOGGER:
            LINE.show(record.getMessage())
        else:
            LINE.wipe()
            self._line(record.getMessage())


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
        LINE.wipe()
        for logger, level in zip(loggers, before, strict=True):
            logger.setLevel(level)
        loggers[0].removeHandler(lines)
