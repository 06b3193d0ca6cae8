"""What is being compiled, for whoever watches: one record of the logger `mafsil.compiling` as each piece begins."""

from __future__ import annotations

import itertools
import logging
import time
from collections.abc import Generator
from contextlib import contextmanager

from mafsil.messages import say

LOGGER = "mafsil.compiling"
"""Its records have the level DEBUG: a program that uses the package stays silent; the command line shows the latest."""
_number = itertools.count(1).__next__
_seconds: list[float] = []


@contextmanager
def compilation(name: str) -> Generator[None, None, None]:
    """Announce what is compiled while this lasts: its name, how many pieces it makes with it, the seconds so far.

    Args:
        name: for people: a quantity, a module of loops.
    """
    logger, number, began = logging.getLogger(LOGGER), _number(), time.monotonic()
    if logger.isEnabledFor(logging.DEBUG):
        logger.debug(say("cache.compiling", name=name, number=number, seconds=f"{sum(_seconds):.0f}"))
    try:
        yield
    finally:
        _seconds.append(time.monotonic() - began)
