"""How planning of an arm ended: a path of proved motions, or what stands in the way and where."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector
from mafsil.collision import Check, Checker, Clearance
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.planning.outcome import Plan, PlanningStatus
from mafsil.planning.rounding import rounded
from mafsil.trajectory import JointPath, MotionLimits, TimeOptimal, time_optimal


@dataclass(frozen=True, eq=False, repr=False)
class ArmPlan(Plan):
    """A path of an arm among obstacles, each of its motions proved free; or why there is none.

    Attributes:
        checker: the arm in its scene.
        ends: what the start or the goals meet, where that is the reason.
        proofs: motions that were proved or tried to be.
        goal: which of the goals the path leads to; -1 where there is no path.
    """

    checker: Checker | None = None
    ends: tuple[Check, ...] = ()
    proofs: int = 0
    goal: int = -1

    def at(self, s: ArrayLike) -> JointVector:
        """(*batch, n) configurations at shares 0..1 of the length of the path.

        Args:
            s: (*batch).
        """
        lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.path, axis=0), axis=1))])
        places = np.asarray(s, dtype=np.float64) * lengths[-1]
        columns: list[Floats] = [np.interp(places, lengths, self.path[:, k]) for k in range(self.path.shape[1])]
        return np.stack(columns, axis=-1)

    def clearance(self, count: int = 200) -> Clearance:
        """Smallest distances at places evenly along the path.

        Args:
            count: how many places.
        """
        assert self.checker is not None
        return self.checker.distance(self.at(np.linspace(0.0, 1.0, count)))

    def joint_path(self, *, share: float = 0.5) -> JointPath:
        """The path with corners rounded as far as that is proved free; motions stop at corners that stay.

        Args:
            share: of the shorter leg that a corner may take, 0 to 0.5.

        Raises:
            InputError: there is no path; a share out of range.
        """
        if not self or self.checker is None:
            raise InputError("planning.no_path", why=self.explain())
        if not 0.0 <= share <= 0.5:
            raise InputError("input.range", name="share", value=share, low=0.0, high=0.5)
        return rounded(self.checker, self.path, share)

    def timed(self, limits: MotionLimits, *, share: float = 0.5) -> TimeOptimal:
        """The rounded path in the shortest time within limits: free at every moment, for it is the same path.

        Args:
            limits: of the joints; with a finite jerk, limited jerk.
            share: as for `joint_path`.

        Raises:
            InputError: there is no path; limits that do not fit.
        """
        return time_optimal(self.joint_path(share=share), limits)

    def explain(self, language: str | None = None) -> str:
        """The status, what the ends meet, and the account."""
        more = say("planning.proofs", language=language, proofs=self.proofs)
        lines = [super().explain(language) + more]
        for k, check in enumerate(self.ends):
            at_start = self.status is PlanningStatus.START_BLOCKED
            which = say("planning.start_itself" if at_start else "planning.goal_number", language=language, number=k)
            contacts = "; ".join(each.sentence(language) for each in check.contacts)
            lines.append(say("planning.end_meets", language=language, which=which, contacts=contacts))
        return "\n".join(lines)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        ends = [check.to_dict() for check in self.ends]
        return super().to_dict() | {"proofs": self.proofs, "goal": self.goal, "ends": ends}
