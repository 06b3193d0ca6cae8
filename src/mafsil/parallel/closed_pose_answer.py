"""The answer of inverse kinematics of a mechanism with loops."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, JointVector
from mafsil.messages.quantities import quantity
from mafsil.messages.tables import on_screen


class ClosedPoseStatus(Status):
    """Whether configurations with closed loops reach a pose."""

    FOUND = ("parallel.pose_found", True)
    FAMILY = ("parallel.pose_family", True)
    OUTSIDE = ("parallel.pose_outside", False)
    NOT_FOUND = ("parallel.pose_not_found", False)


@dataclass(frozen=True, eq=False, repr=False)
class ClosedPoses(Answer):
    """Configurations that close all loops with the tip at a pose; true if one is within the limits, iterable.

    Attributes:
        q: (k, n) those that were found, those within the limits first [rad | m].
        within: (k,) whether the limits are kept.
        freedom: dimension of the families that they belong to; 0 where each stands alone.
        starts: of the search.
        nearest: (n,) with closed loops and the least miss.
        position_error: of the nearest [m].
        rotation_error: of the nearest [rad].
        gap: of the loops there [rad | m]; infinite where none could be closed.
    """

    q: JointVector
    within: Booleans
    freedom: int
    starts: int
    nearest: JointVector
    position_error: float
    rotation_error: float
    gap: float

    @property
    def status(self) -> ClosedPoseStatus:
        """By what was found, and where the limits are."""
        if not len(self.q):
            return ClosedPoseStatus.NOT_FOUND
        if not self.within.any():
            return ClosedPoseStatus.OUTSIDE
        return ClosedPoseStatus.FAMILY if self.freedom else ClosedPoseStatus.FOUND

    def __bool__(self) -> bool:
        return self.status.succeeded

    def __len__(self) -> int:
        return len(self.q)

    def __iter__(self) -> Iterator[JointVector]:
        return iter(self.q)

    def __repr__(self) -> str:
        return on_screen(self.explain())

    def explain(self, language: str | None = None) -> str:
        """How many were found and how, or how near the nearest comes."""
        return self.status.sentence(
            language, count=len(self), within=int(self.within.sum()), freedom=self.freedom, starts=self.starts,
            position=quantity(self.position_error, "m"), angle=quantity(self.rotation_error, "rad"), gap=self.gap,
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "status": self.status.name.lower(), "q": self.q, "within": self.within, "freedom": self.freedom,
            "starts": self.starts, "nearest": self.nearest, "position_error": self.position_error,
            "rotation_error": self.rotation_error, "gap": self.gap,
        }  # fmt: skip
