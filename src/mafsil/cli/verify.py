"""`mafsil verify`: every routine of a robot held against independent roads to the same numbers."""

from __future__ import annotations

from typing import Literal, cast

from mafsil.cli.answer import Answer
from mafsil.cli.table import table
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.messages.visible import visible
from mafsil.robot import load
from mafsil.verification import verify as verified

STATES = 8


def verify(robot: str, tip: str | None, against: str | None, states: str | None, seed: str | None) -> Answer:
    """A table of routines, roads and errors.

    Args:
        robot: name or file.
        tip: another tip link.
        against: a peer that is installed, `pinocchio` or `mujoco`.
        states: how many random states, as typed; 8 if None.
        seed: of the states, as typed; 0 if None.

    Raises:
        MafsilError: no such robot, no such peer.
    """
    peer = cast("Literal['pinocchio', 'mujoco'] | None", against)
    report = verified(load(robot, tip=tip), peer, states=_whole("states", states, STATES), seed=_whole("seed", seed, 0))
    head = [say(f"verification.{name}") for name in ("routine", "road", "error", "limit", "verdict")]
    lines = [*table(head, report.table()), "", *report.explain().split("\n")]
    return Answer(report.as_dict(), tuple(lines), None if report.ok else report.explain().split("\n")[0])


def _whole(name: str, text: str | None, default: int) -> int:
    """A count that was typed, or the default.

    Raises:
        InputError: it is no whole number from 0 on.
    """
    if text is None:
        return default
    if not (text.isascii() and text.isdigit() and len(text) < 10):
        raise InputError("cli.whole", name=name, text=visible(text))
    return int(text)
