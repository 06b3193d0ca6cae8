"""How planning ended: a path with its account, or the reason why there is none."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from mafsil.answer import SingleAnswer, Status
from mafsil.arrays import JointVector
from mafsil.messages import say
from mafsil.planning.problem import length_of
from mafsil.planning.reasons import reason_text


class PlanningStatus(Status):
    """Whether there is a path."""

    FOUND = ("planning.found", True)
    START_BLOCKED = ("planning.start_blocked", False)
    GOAL_BLOCKED = ("planning.goal_blocked", False)
    START_OUTSIDE = ("planning.start_outside", False)
    GOAL_OUTSIDE = ("planning.goal_outside", False)
    START_OFF = ("planning.start_off", False)
    GOAL_OFF = ("planning.goal_off", False)
    UNREACHABLE = ("planning.unreachable", False)
    SEPARATED = ("planning.separated", False)
    LOCAL_MINIMUM = ("planning.local_minimum", False)
    NOT_FOUND = ("planning.not_found", False)
    PATH_BLOCKED = ("planning.path_blocked", False)
    FINE_BLOCKED = ("planning.fine_blocked", False)
    DEADLOCK = ("planning.deadlock_proved", False)
    NOT_COORDINATED = ("planning.not_coordinated", False)


@dataclass(frozen=True, eq=False, repr=False)
class Plan(SingleAnswer):
    """A path, or why there is none; true if there is one.

    `SEPARATED` is said by exact methods only, which looked at everything; searches say `NOT_FOUND` in their budget.

    Attributes:
        status: how it ended.
        path: (k, n) from start to goal; where there is none, what was reached [rad | m].
        planner: its name.
        configurations, segments: how many were looked at.
        nodes: of the graph or trees.
        seconds: that it took.
        reason: what stands in the way, in words, where that is known.
        interrupted: whether Ctrl-C ended the search, which gave its best so far.
    """

    status: PlanningStatus
    path: JointVector
    planner: str
    configurations: int
    segments: int
    nodes: int
    seconds: float
    reason: str = ""
    interrupted: bool = field(default=False, kw_only=True)

    @property
    def length(self) -> float:
        """Of the path; infinite where there is none [rad | m]."""
        return length_of(self.path) if self else np.inf

    def explain(self, language: str | None = None) -> str:
        """The status, the reason, and the account."""
        reason = reason_text(self.reason, language)
        first = self.status.sentence(language) + (f" ({reason})" if reason else "")
        details = {"planner": self.planner, "nodes": self.nodes, "configurations": self.configurations}
        more = {"segments": self.segments, "seconds": self.seconds, "points": len(self.path), "length": self.length}
        account = "planning.account" if self else "planning.account_no_path"
        lines = [first, say(account, language=language, **details, **more)]
        if self.interrupted:
            lines.insert(1, say("planning.interrupted", language=language))
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        account = {name: getattr(self, name) for name in ("planner", "configurations", "segments", "nodes", "seconds")}
        return {
            "status": self.status.name, "path": self.path, "length": self.length, "reason": self.reason,
            "interrupted": self.interrupted, **account,
        }  # fmt: skip
