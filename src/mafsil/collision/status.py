"""Statuses of collision checks and the answers that carry them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

from mafsil.answer import Answer, SingleAnswer, Status
from mafsil.arrays import Floats, JointVector, Scalar, Truth, Vector3
from mafsil.collision.separation import place_of
from mafsil.messages import say
from mafsil.messages.tables import on_screen


class CheckStatus(Status):
    """Whether an arm is free at a configuration."""

    FREE = ("collision.free", True)
    ALONE = ("collision.alone", True)
    COLLIDING = ("collision.colliding", False)


SMALLEST_GAP = 1e-3
"""Distance below which nothing counts as safely passed where no error of the motion is known [m].

Arms are mounted, measured and driven within about a millimetre; a smaller gap in a model is none in a cell.
"""


@dataclass(frozen=True, eq=False, slots=True)
class ContactPair:
    """A body of the arm and what it meets, or comes nearest to.

    Attributes:
        first: name of the body.
        second: name of the obstacle or of the other body.
        distance: [m]; minus the depth where they overlap.
        point_first, point_second: (3,) the points nearest to each other, in {s} [m].
        normal: (3,) unit direction in which the first one leaves the second.
    """

    first: str
    second: str
    distance: float
    point_first: Vector3
    point_second: Vector3
    normal: Vector3

    @property
    def place(self) -> Vector3:
        """(3,) the middle between the two points, in {s} [m]."""
        return (self.point_first + self.point_second) / 2

    def sentence(self, language: str | None = None) -> str:
        """What meets what, by how much, where."""
        key = "collision.hits" if self.distance <= 0.0 else "collision.near"
        return say(
            key, language=language, first=self.first, second=self.second,
            millimetres=1e3 * abs(self.distance), place=place_of(self.place),
        )  # fmt: skip

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "first": self.first, "second": self.second, "distance": self.distance,
            "point_first": self.point_first.tolist(), "point_second": self.point_second.tolist(),
            "normal": self.normal.tolist(),
        }  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class CollisionCheck(SingleAnswer):
    """What an arm meets at a configuration; true if it is free.

    Attributes:
        status: free; alone (there is nothing to meet); colliding.
        q: (n,) the configuration.
        clearance: the clearance that was asked for [m].
        contacts: every pair within the clearance, deepest first; of a free configuration the nearest pair.
        unchecked: keys of sentences about what was not looked at.
    """

    status: CheckStatus
    q: Floats
    clearance: float
    contacts: tuple[ContactPair, ...]
    unchecked: tuple[str, ...] = ()

    def explain(self, language: str | None = None) -> str:
        """A sentence for the verdict, one for each contact; if free, what was not looked at."""
        head = self.status.sentence(language, count=len(self.contacts), millimetres=1e3 * self.clearance)
        lines = [head, *(each.sentence(language) for each in self.contacts)]
        return "\n".join([*lines, *(say(key, language=language) for key in self.unchecked if self)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "status": self.status.name.lower(), "q": self.q.tolist(), "clearance": self.clearance,
            "contacts": [each.to_dict() for each in self.contacts], "unchecked": unchecked_as_data(self.unchecked),
        }  # fmt: skip


def unchecked_as_data(unchecked: tuple[str, ...]) -> list[str]:
    """What was not looked at, as plain data: itself, around."""
    return [key.rpartition("_")[2] for key in unchecked]


@dataclass(frozen=True, eq=False, repr=False)
class Clearance(Answer):
    """Smallest distance of an arm at each of many configurations; true where all are free.

    Attributes:
        q: (*batch, n).
        clearance: clearance that makes a configuration free [m].
        distance: (*batch) [m]; minus the depth of the deepest pair, infinite where there is nothing to meet.
        point_first, point_second: (*batch, 3) the points nearest to each other, in {s}.
        normal: (*batch, 3) unit direction in which the first body leaves the second.
        gradient: (*batch, n) of the distance by q [m/rad | 1], as far as one pair stays the nearest.
        first, second: (*batch) names of the nearest pair.
        verdict: (*batch) whether each is free, where another clearance counts between bodies of the arm.
    """

    q: JointVector
    clearance: float
    distance: Scalar
    point_first: Vector3
    point_second: Vector3
    normal: Vector3
    gradient: JointVector
    first: Any
    second: Any
    verdict: Truth | None = None

    @property
    def free(self) -> Any:
        """(*batch) whether each configuration is free."""
        return self.distance > self.clearance if self.verdict is None else self.verdict

    @property
    def status(self) -> Any:
        """A CheckStatus, or an array (*batch) of them."""
        members = np.array([CheckStatus.COLLIDING, CheckStatus.FREE, CheckStatus.ALONE])
        return members[np.where(np.isinf(self.distance), 2, np.asarray(self.free).astype(int))]

    def __bool__(self) -> bool:
        return bool(np.all(self.free))

    def __len__(self) -> int:
        return self.distance.size

    def __iter__(self) -> Iterator[ContactPair]:
        rows = (x.reshape(-1, 3) for x in (self.point_first, self.point_second, self.normal))
        names = (np.reshape(self.first, -1), np.reshape(self.second, -1))
        for first, second, distance, a, b, n in zip(*names, self.distance.reshape(-1), *rows, strict=True):
            yield ContactPair(str(first), str(second), float(distance), a, b, n)

    def __repr__(self) -> str:
        return on_screen(self.explain())

    def explain(self, language: str | None = None) -> str:
        """A sentence for each configuration."""
        alone = CheckStatus.ALONE.sentence(language)
        return "\n".join(alone if np.isinf(each.distance) else each.sentence(language) for each in self)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "distance": self.distance.tolist(), "free": np.asarray(self.free).tolist(),
            "point_first": self.point_first.tolist(), "point_second": self.point_second.tolist(),
            "normal": self.normal.tolist(), "gradient": self.gradient.tolist(),
            "first": np.asarray(self.first).tolist(), "second": np.asarray(self.second).tolist(),
        }  # fmt: skip
