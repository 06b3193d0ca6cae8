"""One order of messages for all windows: each has a queue, and a window that does not keep up begins anew."""

from __future__ import annotations

import json
import queue
import threading
from collections.abc import Callable, Mapping
from typing import Any

from mafsil.messages import LANGUAGES
from mafsil.messages.isolates import in_sentence

MOST_WAITING = 2000
"""Messages that wait for one window; then its connection ends, and it asks for everything again."""
MOST_WINDOWS = 32


class Full(Exception):
    """There are as many windows as there may be."""


class Broadcast:
    """Messages to every window, in one order.

    Args:
        everything: what a window is told first.
    """

    def __init__(self, everything: Callable[[], Mapping[str, Any]]) -> None:
        self.lock = threading.RLock()
        self._everything = everything
        self._windows: list[queue.SimpleQueue[bytes | None]] = []
        self._closed = False

    @property
    def windows(self) -> int:
        """How many listen."""
        return len(self._windows)

    def join(self) -> queue.SimpleQueue[bytes | None]:
        """A new window; its queue begins with everything, and ends with None.

        Raises:
            Full: there are too many.
        """
        with self.lock:
            if len(self._windows) >= MOST_WINDOWS or self._closed:
                raise Full
            window: queue.SimpleQueue[bytes | None] = queue.SimpleQueue()
            window.put(encode(self._everything()))
            self._windows.append(window)
            self.send({"kind": "windows", "count": len(self._windows)})
            return window

    def leave(self, window: queue.SimpleQueue[bytes | None]) -> None:
        """A window is gone."""
        with self.lock:
            if window in self._windows:
                self._windows.remove(window)
                self.send({"kind": "windows", "count": len(self._windows)})

    def send(self, message: Mapping[str, Any]) -> None:
        """Tell all windows."""
        text = encode(message)
        with self.lock:
            for window in list(self._windows):
                if window.qsize() >= MOST_WAITING:
                    self._windows.remove(window)
                    window.put(None)
                else:
                    window.put(text)

    def close(self) -> None:
        """Tell all that it is over."""
        with self.lock:
            self._closed = True
            for window in self._windows:
                window.put(None)
            self._windows.clear()


def encode(message: Mapping[str, Any]) -> bytes:
    """JSON on one line."""
    return json.dumps(message, ensure_ascii=False, allow_nan=False, separators=(",", ":")).encode()


def in_all_languages(said: Callable[[str], str]) -> dict[str, str]:
    """A sentence by language.

    Args:
        said: from the code of a language to the sentence.
    """
    return {code: in_sentence(said(code), code) for code in LANGUAGES}
