"""What another robot of a job does, move by move, as it was planned."""

from __future__ import annotations

from dataclasses import dataclass

from mafsil.arrays import JointVector
from mafsil.job.decision import Decision
from mafsil.planning import TimedArm


@dataclass(frozen=True, eq=False, slots=True)
class OtherStep:
    """One move of another robot.

    Attributes:
        number: of the entry of its table, from 1.
        kind: joint, pause, set, wait or if.
        text: what it sets, waits for or looks at.
        start, end: on the clock of the job [s].
        part: of its motion; None where it is there already.
        q: (n,) where it is at the end [rad | m].
        index: of the move.
        after: index of the next move.
        decision: of a choice: which way it went, and why.
    """

    number: int
    kind: str
    text: str
    start: float
    end: float
    part: TimedArm | None
    q: JointVector
    index: int
    after: int
    decision: Decision | None = None

    def to_dict(self) -> dict[str, object]:
        """Plain data."""
        choice = None if self.decision is None else self.decision.to_dict()
        where: dict[str, object] = {"number": self.number, "kind": self.kind, "text": self.text, "choice": choice}
        return where | {"start": self.start, "end": self.end}
