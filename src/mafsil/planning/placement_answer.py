"""The answer of base placement: a base with configurations for all targets, or which of them are missed and why."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from enum import IntEnum
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.collision import ContactPair
from mafsil.ik.result import reach_bound
from mafsil.messages import say

if TYPE_CHECKING:
    from mafsil.robot import Robot

MEASURES = ("limits", "dexterity", "clearance")
"""Shares by which a configuration is judged."""
FEW = 12
"""Targets that are named in words; all are in the arrays."""


class PlacementStatus(Status):
    """Whether one base pose reaches all targets."""

    FOUND = ("planning.placed", True)
    NOT_FOUND = ("planning.not_placed", False)


class PlacementFailure(IntEnum):
    """Why a target is not reached; the later ones got further."""

    BASE = 0
    REACH = 1
    LIMITS = 2
    COLLISION = 3
    NONE = 4


@dataclass(frozen=True, eq=False, repr=False)
class BasePlacement(Answer, data="T_sb configurations interrupted"):
    """Base poses that were tried, what each reaches, and the best; true if that reaches all targets.

    Attributes:
        status: found, or not found among the poses that were tried.
        robot: the arm.
        targets: (m, 4, 4) in {s}.
        bases: (k, 4) x, y, z [m], yaw [rad]; the grid first, then refinements.
        misses: (k, m) a `PlacementFailure` each; NONE where it is reached.
        quality: (k, m, 3) shares of the best solution, by MEASURES; -1 where there is none.
        q: (k, m, n) that solution; NaN where there is none.
        grid: how many of the bases are of the grid.
        contacts: for targets that the best base misses by a collision, what the arm meets.
        interrupted: whether Ctrl-C ended the search; the bases are those that were looked at till then.
    """

    status: PlacementStatus
    robot: Robot
    targets: PoseMatrix
    bases: Floats
    misses: NDArray[np.int8]
    quality: Floats
    q: JointVector
    grid: int
    contacts: Mapping[int, ContactPair | None] = field(default_factory=dict[int, ContactPair | None])
    interrupted: bool = False

    @property
    def reached(self) -> NDArray[np.bool_]:
        """(k, m) which targets are reached from which base."""
        return np.asarray(self.misses == PlacementFailure.NONE)

    @property
    def score(self) -> Floats:
        """(k,) of each base: the worst share of its worst target; 0 where a target is missed."""
        return np.where(self.reached.all(axis=1), self.quality.min(axis=(1, 2)), 0.0)

    @property
    def best(self) -> int:
        """The base that reaches most targets; of these the one with the largest worst share among those it reaches."""
        worst = np.where(self.reached, self.quality.min(axis=2), 1.0).min(axis=1)
        return int(np.lexsort((-worst, -self.reached.sum(axis=1)))[0])

    @property
    def T_sb(self) -> PoseMatrix:
        """(4, 4) pose of the best base in {s}."""
        x, y, z, yaw = self.bases[self.best]
        c, s = np.cos(yaw), np.sin(yaw)
        return np.array([[c, -s, 0.0, x], [s, c, 0.0, y], [0.0, 0.0, 1.0, z], [0.0, 0.0, 0.0, 1.0]])

    @property
    def configurations(self) -> JointVector:
        """(m, n) of the best base, one for each target; NaN for targets that it misses."""
        return self.q[self.best]

    def score_map(self) -> tuple[Floats, Floats, Floats, Floats]:
        """The grid seen from above: x (a,), y (b,), and for each the best over heights and yaws.

        Returns:
            x, y, share of the targets that are reached (a, b), score (a, b).
        """
        rows = self.bases[: self.grid]
        (x, i), (y, j) = (np.unique(rows[:, k], return_inverse=True) for k in range(2))
        share, score = np.zeros((2, len(x), len(y)))
        np.maximum.at(share, (i, j), self.reached[: self.grid].mean(axis=1))
        np.maximum.at(score, (i, j), self.score[: self.grid])
        return x, y, share, score

    def with_more(self, other: BasePlacement) -> BasePlacement:
        """With further base poses after these."""
        names = ("bases", "misses", "quality", "q")
        return replace(self, **{each: np.concatenate([getattr(self, each), getattr(other, each)]) for each in names})

    def with_verdict(self, contacts: Mapping[int, ContactPair | None]) -> BasePlacement:
        """With the status that the bases say, and what the arm meets where the best base misses targets."""
        found = bool(self.reached[self.best].all())
        status = PlacementStatus.FOUND if found else PlacementStatus.NOT_FOUND
        return replace(self, status=status, contacts=contacts)

    def explain(self, language: str | None = None) -> str:
        """The best base and how good it is; else which targets it misses and why, and which no base reaches."""
        x, y, z, yaw = (float(value) for value in self.bases[self.best])
        reached = self.reached[self.best]
        lines = [
            self.status.sentence(language, count=len(self.bases), targets=len(reached)),
            say(
                "planning.best_base", language=language, x=x, y=y, z=z, yaw=np.degrees(yaw), reached=int(reached.sum()),
                targets=len(reached),
            ),
        ]  # fmt: skip
        if self.interrupted:
            lines.insert(1, say("planning.placing_interrupted", language=language))
        if reached.any():
            worst = self.quality[self.best][reached].min(axis=0)
            lines.append(say("planning.worst_shares", language=language, **dict(zip(MEASURES, worst, strict=True))))
        for j in np.flatnonzero(~reached)[:FEW].tolist():
            lines.append(self._missed(j, language))
        return "\n".join(lines)

    def _missed(self, j: int, language: str | None) -> str:
        """Why a target is missed from the best base, and from how many it is reached."""
        miss = PlacementFailure(int(self.misses[self.best, j]))
        contact = self.contacts.get(j)
        far = self._beyond_reach(j) if miss is PlacementFailure.REACH else None
        key = f"planning.miss_{miss.name.lower()}" if far is None else "planning.miss_far"
        why = say(key, language=language, **(far or {}))
        if contact is not None:
            why += f" ({contact.sentence(language)})"
        elsewhere = int(self.reached[:, j].sum())
        return say("planning.target_missed", language=language, number=j, why=why, elsewhere=elsewhere)

    def _beyond_reach(self, j: int) -> dict[str, str] | None:
        """How far a target is from the best base, and how far the arm reaches from there; None where that is enough."""
        mechanism = self.robot.mechanism
        centre, radius = reach_bound(mechanism, None)
        reach = radius + float(np.linalg.norm(centre - mechanism.T_sb[:3, 3]))
        away = float(np.linalg.norm(self.targets[j, :3, 3] - self.bases[self.best, :3]))
        return {"distance": f"{away:.3g}", "reach": f"{reach:.3g}"} if away > reach else None

    def to_dict(self) -> dict[str, Any]:
        """Plain data of the best base; all bases are in the arrays."""
        misses = [PlacementFailure(int(each)).name.lower() for each in self.misses[self.best]]
        return Answer.to_dict(self) | {
            "base": self.bases[self.best],
            "tried": len(self.bases),
            "score": float(self.score[self.best]),
            "targets": misses,
            "reached_from": self.reached.sum(axis=0),
        }
