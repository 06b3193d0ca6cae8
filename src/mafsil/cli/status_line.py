"""What a terminal shows while a command runs, in its last line: a bar, what is being compiled, or the seconds so far.

The bar has stage, share and time left, and is silent when nobody watches. What the package tells its logger stands on
lines of its own.
"""

from __future__ import annotations

import logging
import shutil
import sys
import threading
import time
from collections.abc import Callable, Generator
from contextlib import contextmanager, suppress
from types import TracebackType

from mafsil.code_store import LOGGER
from mafsil.messages import say

QUIET = 1.0
"""Seconds without another word on the line after which it counts them."""
_WIPED = "\r\x1b[K"


class StatusLine:
    """One line on stderr that replaces itself; nothing where stderr is no terminal.

    Attributes:
        text: of the bar of the stage that is running; empty if there is none.
        written: when the line was last written [s].
    """

    def __init__(self) -> None:
        self.text = ""
        self.written = 0.0

    def show(self, text: str) -> None:
        """Replace the line, cut to the width of the terminal."""
        self.written = time.monotonic()
        self._put(text[: shutil.get_terminal_size().columns - 1])

    def wipe(self) -> None:
        """Clear it: an answer or a sentence comes."""
        self.text = ""
        self._put("")

    def _put(self, text: str) -> None:
        # A terminal that has gone is no reason to end the work.
        if sys.stderr.isatty():
            with suppress(OSError):
                print(f"{_WIPED}{text}", end="", file=sys.stderr, flush=True)

    @contextmanager
    def counting(self) -> Generator[None, None, None]:
        """While this lasts, seconds are counted wherever nothing else is written for a second."""
        if not sys.stderr.isatty():
            yield
            return
        done, began = threading.Event(), time.monotonic()

        def count() -> None:
            while not done.wait(QUIET):
                if time.monotonic() - self.written >= QUIET:
                    seconds = say("cli.working", seconds=f"{time.monotonic() - began:.0f}")
                    self.show(f"{self.text}  {seconds}" if self.text else seconds)

        clock = threading.Thread(target=count, daemon=True)
        clock.start()
        try:
            yield
        finally:
            done.set()
            clock.join()
            self.wipe()


LINE = StatusLine()
"""That of this process."""
_WIDTH = 26
_PAUSE = 0.1


class Progress:
    """Prints how far a run is; as a context it cleans up behind itself.

    Args:
        always: print even when stderr is no terminal.
    """

    def __init__(self, always: bool = False) -> None:
        self.terminal = sys.stderr.isatty()
        self.awake = always or self.terminal
        self.stage = ""
        self.began = self.printed = 0.0

    def __enter__(self) -> Progress:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self.awake:
            LINE.wipe()

    def enter(self, stage: str) -> None:
        """A new stage begins; `stage` is a key of the catalogue area `cli`."""
        self.stage, self.began, self.printed = stage, time.monotonic(), 0.0
        if self.awake and not self.terminal:
            print(say(f"cli.{stage}"), file=sys.stderr, flush=True)
        self.update(0.0)

    def show_plan(self, plan: object) -> None:
        """A line has no room for it."""

    def update(self, share: float) -> None:
        """The stage is done to this share, 0 .. 1."""
        now = time.monotonic()
        if not (self.awake and self.terminal) or (now - self.printed < _PAUSE and 0.0 < share < 1.0):
            return
        self.printed = now
        full = round(_WIDTH * min(max(share, 0.0), 1.0))
        left = (now - self.began) * (1 - share) / share if share > 0.02 else None
        eta = "" if left is None or share >= 1.0 else say("cli.time_left", seconds=f"{left:.0f}")
        bar = "━" * full + "╌" * (_WIDTH - full)
        LINE.text = f"{bar} {100 * share:3.0f} %  {say('cli.' + self.stage)}"
        LINE.show(f"{LINE.text}  {eta}")


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
