"""Parts that a job put down: they stand there for later moves, until they are taken again."""

from __future__ import annotations

from collections import Counter
from collections.abc import Container, Iterable
from dataclasses import dataclass, replace

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.collision import Box
from mafsil.collision import Obstacle as Body
from mafsil.geometry import pose
from mafsil.job.language.description import UNNAMED, Grasp
from mafsil.job.language.units import box_in_tip
from mafsil.messages.visible import visible


@dataclass(frozen=True, eq=False, slots=True)
class PlacedPart:
    """A part where it was put down.

    Attributes:
        body: its box in {s}.
        pick: index of the leg at which it was taken first: the same thing all the time; -1 before that.
        kind: name of the part in the job.
    """

    body: Body
    pick: int
    kind: str

    def holds(self, point: Floats) -> bool:
        """Whether a point (3,) in {s} lies inside its box."""
        box = self.body.geometry
        assert isinstance(box, Box)
        inside = pose.act(pose.inverse(self.body.T_so), point)
        return bool((np.abs(inside) <= np.array(box.size) / 2.0).all())


@dataclass(frozen=True, eq=False, slots=True)
class Stay:
    """How long a part stands where it was put down.

    Attributes:
        body: its box in {s}.
        put, taken: when the tool opens, and when it has been taken again; infinite if it stays there [s].
    """

    body: Body
    put: float
    taken: float = np.inf


class PlacedParts:
    """The parts that stand somewhere after the moves planned so far.

    A part that was just put down does not count until a motion has left it, nor does one for the motion at whose end it
    is taken: there the tool is at it.

    Attributes:
        standing: all of them.
        left: the one that was put down last, as long as the arm has not left it.
        stays: all that ever stood somewhere, with the times: for robots that do not handle them.
        new: how often a part of each name was taken where none lay although another of that name stood elsewhere.

    Args:
        names: of other bodies, that parts cannot have.
        lying: parts with places, and the poses (4, 4) of their boxes: there are no others of their names.
    """

    def __init__(self, names: Container[str] = (), lying: Iterable[tuple[Grasp, PoseMatrix]] = ()) -> None:
        self._names = names
        self.standing: tuple[PlacedPart, ...] = ()
        self.left: PlacedPart | None = None
        self.stays: tuple[Stay, ...] = ()
        self.new: Counter[str] = Counter()
        self._count = 0
        self._held = -1
        self._counted_kinds: set[str] = set()
        for part, T in lying:
            self._counted_kinds.add(part.name)
            self._stand(part, T, 0.0)

    def miss(self, part: Grasp, T_tip: PoseMatrix) -> float | None:
        """Distance from the grip to the nearest part of that name [m]; infinite if none is left, None without places.

        Args:
            part: as the move describes it.
            T_tip: (4, 4) pose of the tip.
        """
        if part.name not in self._counted_kinds:
            return None
        centre = (T_tip @ box_in_tip(part))[:3, 3]
        places = [each.body.T_so[:3, 3] for each in self.standing if each.kind == part.name]
        return min((float(np.linalg.norm(place - centre)) for place in places), default=np.inf)

    def put(self, part: Grasp, T_tip: PoseMatrix, time: float) -> None:
        """What is carried is let go of.

        Args:
            part: that is carried.
            T_tip: (4, 4) pose of the tip.
            time: when the tool begins to open [s].
        """
        self.left = self._stand(part, T_tip @ box_in_tip(part), time)

    def _stand(self, part: Grasp, T: PoseMatrix, time: float) -> PlacedPart:
        """One more part stands somewhere."""
        self._count += 1
        while (name := f"{visible(part.name)} {self._count}") in self._names:
            self._count += 1
        one = PlacedPart(Body(Box(part.size), T, name), self._held, part.name)
        self.standing = (*self.standing, one)
        self.stays = (*self.stays, Stay(one.body, time))
        return one

    def take(self, part: Grasp, T_tip: PoseMatrix, leg: int, time: float, *, brought: bool = False) -> int:
        """Something is taken: a part that stands there, or a new one; the leg at which it was taken first.

        Args:
            part: as the move describes it.
            T_tip: (4, 4) pose of the tip.
            leg: index of the leg.
            time: when it has been taken [s].
            brought: a moving frame brought it here.
        """
        here = self._there(part, T_tip)
        if (
            here is None
            and not brought
            and part.name != UNNAMED
            and any(each.kind == part.name for each in self.standing)
        ):
            self.new[part.name] += 1
        self._held = leg if here is None or here.pick < 0 else here.pick
        self.standing = tuple(each for each in self.standing if each is not here)
        if here is not None:
            self.stays = tuple(replace(each, taken=time) if each.body is here.body else each for each in self.stays)
        return self._held

    def counted_parts(self, coming: Grasp | None = None, T_tip: PoseMatrix | None = None) -> tuple[PlacedPart, ...]:
        """The parts that count for the next motion.

        Args:
            coming: what is taken at its end, if anything.
            T_tip: (4, 4) pose of the tip at its end.
        """
        there = None if coming is None or T_tip is None else self._there(coming, T_tip)
        return tuple(each for each in self.standing if each is not self.left and each is not there)

    def _there(self, part: Grasp, T_tip: PoseMatrix) -> PlacedPart | None:
        """The part in whose box the centre of what is taken lies; of several one of its name, the last one put down."""
        centre = (T_tip @ box_in_tip(part))[:3, 3]
        there = [each for each in self.standing if each.holds(centre)]
        return max(enumerate(there), key=lambda one: (one[1].kind == part.name, one[0]), default=(0, None))[1]
