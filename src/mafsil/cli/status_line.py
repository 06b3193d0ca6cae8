"""The last line of a terminal while a command runs: a bar, what is being compiled, or the seconds so far."""

from __future__ import annotations

import shutil
import sys
import threading
import time
from collections.abc import Generator
from contextlib import contextmanager, suppress

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
