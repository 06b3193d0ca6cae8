"""`mafsil verify`: every routine of a robot compared with independent methods for the same numbers."""

from __future__ import annotations

from typing import cast

from mafsil.cli.answer import Answer, Toned
from mafsil.cli.numerals import count
from mafsil.cli.table import table
from mafsil.messages import say
from mafsil.robot import load
from mafsil.verification import verify as verified
from mafsil.verification.verify import Peer

STATES = 8


def verify(robot: str, tip: str | None, against: list[str] | None, states: str | None, seed: str | None) -> Answer:
    """A table of routines, methods and errors.

    Args:
        robot: name or file.
        tip: another tip link.
        against: peers that are installed, `pinocchio`, `mujoco` or both.
        states: how many random states, as typed; 8 if None.
        seed: of the states, as typed; 0 if None.

    Raises:
        MafsilError: no such robot, no such peer.
    """
    peers = cast("list[Peer]", against or [])
    report = verified(
        load(robot, tip=tip),
        peers,
        states=STATES if states is None else count("states", states),
        seed=0 if seed is None else count("seed", seed),
    )
    head = [say(f"verification.{name}") for name in ("routine", "method", "error", "limit", "verdict")]
    first, *rest = report.explain().split("\n")
    lines = [*table(head, report.table()), "", Toned(first, "good" if report else "bad"), *rest]
    return Answer(report.to_dict(), tuple(lines), None if report else first)
