"""What the package tells the logger `mafsil` while a command runs, such as that loops are compiled: lines on stderr."""

from __future__ import annotations

import logging
import sys
from collections.abc import Callable, Generator
from contextlib import contextmanager


class _Lines(logging.Handler):
    """Each record is one line; a bar of progress that stands there is wiped away and comes back by itself."""

    def __init__(self, write: Callable[[str], None]) -> None:
        super().__init__()
        self._line = write

    def emit(self, record: logging.LogRecord) -> None:
        if sys.stderr.isatty():
            sys.stderr.write("\r\x1b[K")
        self._line(record.getMessage())


@contextmanager
def shown(write: Callable[[str], None]) -> Generator[None, None, None]:
    """While this lasts, notices are written.

    Args:
        write: takes one sentence.
    """
    logger, lines = logging.getLogger("mafsil"), _Lines(write)
    before = logger.level
    logger.addHandler(lines)
    logger.setLevel(logging.INFO)
    try:
        yield
    finally:
        logger.setLevel(before)
        logger.removeHandler(lines)
