"""What another robot of a job does, move by move, as it was planned."""

from __future__ import annotations

from dataclasses import dataclass

from mafsil.arrays import JointVector
from mafsil.planning import TimedArm


@dataclass(frozen=True, eq=False, slots=True)
class OtherStep:
    """One move of another robot.

    Attributes:
        number: of the move in its table, from 1.
        kind: joint, pause, set or wait.
        text: what it sets or waits for.
        start, end: on the clock of the job [s].
        part: of its motion; None where it is there already.
        q: (n,) where it is at the end [rad | m].
    """

    number: int
    kind: str
    text: str
    start: float
    end: float
    part: TimedArm | None
    q: JointVector

    def to_dict(self) -> dict[str, object]:
        """Plain data."""
        return {"number": self.number, "kind": self.kind, "text": self.text, "start": self.start, "end": self.end}
