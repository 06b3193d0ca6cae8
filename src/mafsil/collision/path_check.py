"""Whether a motion along straight lines of the joints is free, as an answer."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import SingleAnswer, Status
from mafsil.arrays import Floats, as_batch
from mafsil.collision.status import ContactPair, named
from mafsil.errors import InputError
from mafsil.messages import say


class PathStatus(Status):
    """What is known of a motion."""

    FREE = ("collision.path_free", True)
    COLLIDING = ("collision.path_colliding", False)
    TOUCHING = ("collision.path_touching", False)


@dataclass(frozen=True, eq=False, repr=False)
class PathCheck(SingleAnswer):
    """A motion and what it meets; true if it is proved free, every moment of it.

    Attributes:
        status: free; colliding; touching: something comes within a micrometre of the clearance, which is not called
        free. points: (k, n) of the path.
        at: where along the path it stopped: the number of the segment plus the share of it; k - 1 if free.
        q: (n,) the configuration there.
        contacts: what it meets there, deepest first.
        states: configurations that were looked at.
        unchecked: keys of sentences about what was not looked at.
    """

    status: PathStatus
    points: Floats
    at: float
    q: Floats
    contacts: tuple[ContactPair, ...]
    states: int
    unchecked: tuple[str, ...] = ()

    def explain(self, language: str | None = None) -> str:
        """The verdict, where it shows, and a sentence for each contact."""
        head = self.status.sentence(language, at=self.at, segments=len(self.points) - 1, states=self.states)
        lines = [head, *(each.sentence(language) for each in self.contacts)]
        return "\n".join([*lines, *(say(key, language=language) for key in self.unchecked if self)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "status": self.status.name.lower(), "at": self.at, "q": self.q.tolist(), "states": self.states,
            "contacts": [each.to_dict() for each in self.contacts], "unchecked": named(self.unchecked),
        }  # fmt: skip


def path_points(n: int, q_a: ArrayLike, q_b: ArrayLike | None) -> Floats:
    """(k, n) points of a path, from a start and an end or from all of them.

    Raises:
        InputError: a wrong shape, fewer than two points, NaN or infinities.
    """
    if q_b is None:
        points = as_batch("q_a", q_a, (n,), finite=True)
        if points.ndim != 2 or len(points) < 2:
            raise InputError("collision.path_points", got=points.shape, n=n)
        return points
    ends = [as_batch(name, x, (n,), finite=True) for name, x in (("q_a", q_a), ("q_b", q_b))]
    for name, end in zip(("q_a", "q_b"), ends, strict=True):
        if end.ndim != 1:
            raise InputError("input.shape", name=name, expected=(n,), got=end.shape, hint="")
    return np.stack(ends)
