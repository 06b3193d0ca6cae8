"""A bar on stderr: stage, share, time left. Silent when nobody watches."""

from __future__ import annotations

import sys
import time
from types import TracebackType

from mafsil.cli.status_line import LINE
from mafsil.messages import say

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
