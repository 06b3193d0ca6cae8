"""The journal that all windows share: named lines in one order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from mafsil.errors import InputError
from mafsil.page.arm import Arm
from mafsil.page.session import Session
from mafsil.studio.broadcast import Broadcast
from mafsil.studio.protocol import Drop, Put, action

MOST_LINES = 20_000
MOST_AT_ONCE = 600_000
"""Steps of 1 ms by which one message may drive the loop on: ten minutes, some seconds of work for every window."""


class Journal:
    """What has been done, line after line.

    Args:
        arm: whose actions they are.
        broadcast: who hears of every change.
    """

    def __init__(self, arm: Arm, broadcast: Broadcast) -> None:
        self._arm = arm
        self._broadcast = broadcast
        self._lines: dict[str, dict[str, Any]] = {}

    def change(self, changes: Sequence[Put | Drop]) -> None:
        """Take changes of a window: all of them, or none.

        Args:
            changes: lines put in the journal or taken back; a line that is there already is done in its place.

        Raises:
            InputError: one of them cannot be done or drives too far, or the journal is full.
        """
        checked = [(one.id, None if isinstance(one, Drop) else action(one, self._arm)) for one in changes]
        with self._broadcast.lock:
            new = {name for name, done in checked if done is not None and name not in self._lines}
            if len(self._lines) + len(new) > MOST_LINES:
                raise InputError("studio.journal_full", most=MOST_LINES)
            for name, done in checked:
                if done is not None:
                    self._require_short(name, done)
            for name, done in checked:
                self._apply(name, done)

    def lines(self) -> list[dict[str, Any]]:
        """Every line with its name."""
        with self._broadcast.lock:
            return [{"id": name, **done} for name, done in self._lines.items()]

    def replayed(self) -> Session:
        """The arm as the windows show it, to the last bit."""
        session = Session(self._arm.robot)
        session.do([{"do": one["do"], "with": one["with"]} for one in self.lines()])
        return session

    def _require_short(self, name: str, done: Mapping[str, Any]) -> None:
        """Refuse a drive that would hold every window for long; a line that grows is driven on by what it grew."""
        before = self._lines.get(name, {}).get("with", {})
        steps = done["with"].get("ticks", 0) - before.get("ticks", 0)
        if steps > MOST_AT_ONCE:
            raise InputError("studio.ticks", steps=steps, most=MOST_AT_ONCE)

    def _apply(self, name: str, done: Mapping[str, Any] | None) -> None:
        if done is not None:
            self._lines[name] = dict(done)
            self._broadcast.send({"kind": "put", "id": name, **done})
        elif self._lines.pop(name, None) is not None:
            self._broadcast.send({"kind": "drop", "id": name})
