"""Two arms on given paths: the coordination diagram with proved cells, the quickest way through, deadlocks named."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from itertools import pairwise
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, as_batch, whole
from mafsil.collision import ContactPair, MultiArmCell
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.planning.arm_plan import ArmPlan
from mafsil.planning.outcome import Named, PlanningStatus, Reason

if TYPE_CHECKING:
    import mafsil.planning.diagram_loops as diagram_loops
else:
    diagram_loops = lazily("mafsil.planning.diagram_loops")

UNKNOWN_SPEED = 1.0
"""Speed of a joint whose limit is not known [rad/s | m/s]: only ratios of durations matter."""


@dataclass(frozen=True, eq=False, slots=True)
class BlockedArm:
    """An arm in a deadlock.

    Attributes:
        arm: its name.
        share: of its path where it waits, 0..1.
        contact: what it would meet next; None at the end of its path.
    """

    arm: str
    share: float
    contact: ContactPair | None

    def sentence(self, language: str | None = None) -> str:
        """Where it waits, and for what."""
        if self.contact is None:
            return say("planning.arm_arrived", language=language, arm=self.arm)
        next_one = self.contact.sentence(language)
        return say("planning.arm_waits", language=language, arm=self.arm, share=self.share, contact=next_one)


@dataclass(frozen=True, eq=False, repr=False)
class CoordinatedPlan(ArmPlan):
    """A verified path of all coordinates on which each arm keeps to its own path; or why there is none.

    Attributes:
        names: of the two arms; rows of the diagram belong to the first.
        diagram: (k, m) of cells: 0 proved free, 1 neither, 2 a state that meets, 3 proved that every state meets.
        shares: for each arm the shares of the length of its path at which cells end, (k + 1,) and (m + 1,).
        places: (p, 2) shares of both paths at the points of the path.
        waits: of a deadlock, where each arm stands and what it would meet.
    """

    names: tuple[str, ...] = ()
    diagram: NDArray[np.int8] | None = None
    shares: tuple[Floats, ...] = ()
    places: Floats | None = None
    waits: tuple[BlockedArm, ...] = ()

    def explain(self, language: str | None = None) -> str:
        """The status, and who waits where."""
        return "\n".join([super().explain(language), *(each.sentence(language) for each in self.waits)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        waits = [{"arm": each.arm, "share": each.share, "explanation": each.sentence("en")} for each in self.waits]
        return super().to_dict() | {"names": self.names, "places": self.places, "waits": waits}


@dataclass(frozen=True, eq=False, slots=True)
class _Pieces:
    """A path cut into pieces.

    Attributes:
        points: (k + 1, n of the arm) ends of the pieces.
        rows: the same in the columns of all arms, zero elsewhere.
        seconds: (k,) of each piece at full speed.
        shares: (k + 1,) of the length.
    """

    points: JointVector
    rows: JointVector
    seconds: Floats
    shares: Floats


def coordinate_arms(
    cell: MultiArmCell, paths: Mapping[str, ArrayLike | ArmPlan], *, cells: int = 100, shortcut_iterations: bool = True
) -> CoordinatedPlan:
    """Coordination of two arms on fixed paths without backing up: which waits where, or the deadlock.

    1. Each path has to be free without the other arm; it is cut into pieces of about equal time at full speed.
    2. Cells of the diagram are proved free or full where they can be.
    3. The quickest way through free cells is the answer; staircases become straight where that is proved.
    4. Without one: if even what is not proved full leaves no way, that is a proven deadlock.

    `.time_optimal(limits)` gives the motion in the shortest time on the path: corners rounded as far as that is proved.

    Args:
        cell: two arms in their scene.
        paths: for each arm's name the points (k, n of the arm) of its path, or an ArmPlan.
        cells: pieces of the slower path; memory is a byte for each cell.
        shortcut_iterations: whether staircases are made straight.

    Raises:
        InputError: not two arms, a path that is none, a wrong shape.

    Reference:
        P. O'Donnell, T. Lozano-Perez, Deadlock-free and collision-free coordination of two robot manipulators,
        ICRA 1989. T. Simeon, S. Leroy, J.-P. Laumond, Path coordination for multiple mobile robots, IEEE T-RA 2002.
    """
    begun, count = perf_counter(), whole("cells", cells, least=1)
    if len(cell.names) != 2:
        raise InputError("planning.two_arms", count=len(cell.names))
    for name in paths:
        cell.alone(name)
    points = {name: _points(cell, name, paths) for name in cell.names}
    # 1.
    start = cell.join({name: rows[0] for name, rows in points.items()})
    refused = _refuse(cell, points, start, begun)
    if refused is not None:
        return refused
    step = max(_seconds(cell, name, rows).sum() for name, rows in points.items()) / count
    pieces = [_cut(cell, name, rows, step) for name, rows in points.items()]
    # 2.
    codes, states = _classify(cell, pieces)
    # 3.
    shares = tuple(each.shares for each in pieces)
    way = _way(codes, diagram_loops.FREE, pieces)
    if way is not None:
        places = _straighten(cell, pieces, way) if shortcut_iterations else way
        path = np.stack([_at(pieces[0], x) + _at(pieces[1], y) for x, y in _with_corners(pieces, places)])
        along = np.stack([np.interp(places[:, k], np.arange(len(s)), s) for k, s in enumerate(shares)], axis=1)
        return CoordinatedPlan(
            PlanningStatus.FOUND, path, "coordination", states, 0, codes.size, perf_counter() - begun, "", cell,
            goal=0, places=along, names=cell.names, diagram=codes, shares=shares,
        )  # fmt: skip
    # 4.
    cost, _ = _costs(codes, diagram_loops.MEETING, pieces)
    proved = not np.isfinite(cost[-1, -1])
    status = PlanningStatus.DEADLOCK if proved else PlanningStatus.NOT_COORDINATED
    reached = cost if proved else _costs(codes, diagram_loops.FREE, pieces)[0]
    return CoordinatedPlan(
        status, start[None], "coordination", states, 0, codes.size, perf_counter() - begun, "", cell,
        waits=_waits(cell, pieces, reached), names=cell.names, diagram=codes, shares=shares,
    )  # fmt: skip


def _points(cell: MultiArmCell, name: str, paths: Mapping[str, ArrayLike | ArmPlan]) -> JointVector:
    """(k, n of the arm) points of the path of one arm, without repetitions."""
    given = paths.get(name)
    if given is None:
        raise InputError("collision.no_coordinates_of", name=name)
    if isinstance(given, ArmPlan):
        if not given:
            raise InputError("planning.no_path", why=given.explain())
        given = given.path
    n = cell.robots[name].n
    rows = as_batch(name, given, (n,), finite=True)
    if rows.ndim != 2 or not len(rows):
        raise InputError("input.shape", name=name, expected=("k", n), got=rows.shape, hint="")
    moved = np.abs(np.diff(rows, axis=0)).max(axis=1) > 0.0
    return np.asarray(rows[np.concatenate([[True], moved])])


def _refuse(
    cell: MultiArmCell, points: Mapping[str, JointVector], start: JointVector, begun: float
) -> CoordinatedPlan | None:
    """A path that is not free by itself, or arms that meet at the starts or the ends."""

    def ended(status: PlanningStatus, reason: str, at: JointVector | None = None) -> CoordinatedPlan:
        checks = () if at is None else (cell.check(at),)
        seconds = perf_counter() - begun
        return CoordinatedPlan(
            status, start[None], "coordination", 0, 0, 0, seconds, reason, cell, checks, names=cell.names
        )

    for name, rows in points.items():
        alone = cell.alone(name)
        found = alone.check_path(rows) if len(rows) > 1 else alone.check(rows[0])
        if not found:
            return ended(PlanningStatus.PATH_BLOCKED, Reason(Named(name, found)))
    if not cell.free(start):
        return ended(PlanningStatus.START_BLOCKED, "", start)
    goal = cell.join({name: rows[-1] for name, rows in points.items()})
    return None if cell.free(goal) else ended(PlanningStatus.GOAL_BLOCKED, "", goal)


def _seconds(cell: MultiArmCell, name: str, rows: JointVector) -> Floats:
    """(k - 1,) least times of the legs of a path by the velocities of the joints."""
    velocity = cell.robots[name].limits.velocity
    speed = np.where(np.isfinite(velocity) & (velocity > 0.0), velocity, UNKNOWN_SPEED)
    return (np.abs(np.diff(rows, axis=0)) / speed).max(axis=1, initial=0.0)


def _cut(cell: MultiArmCell, name: str, rows: JointVector, step: float) -> _Pieces:
    """A path in pieces that take about a step of time each; one that stands still is a piece without length."""
    if len(rows) == 1:
        rows = np.repeat(rows, 2, axis=0)
    seconds = _seconds(cell, name, rows)
    counts = [max(int(np.ceil(each / step - 1e-9)), 1) if step > 0.0 else 1 for each in seconds]
    parts = [
        a + np.linspace(0.0, 1.0, count, endpoint=False)[:, None] * (b - a)
        for (a, b), count in zip(pairwise(rows), counts, strict=True)
    ]
    points = np.concatenate([*parts, rows[-1:]])
    full = np.zeros((len(points), cell.robot.n))
    full[:, cell.columns[name]] = points
    lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    shares = lengths / lengths[-1] if lengths[-1] > 0.0 else np.linspace(0.0, 1.0, len(points))
    return _Pieces(points, full, np.repeat(seconds / counts, counts), shares)


def _classify(cell: MultiArmCell, pieces: list[_Pieces]) -> tuple[NDArray[np.int8], int]:
    """The cells of the diagram, and how many states were looked at."""
    world = cell.world()._replace(arm=cell.between, clearance=np.full(1 + len(cell.between.pairs), cell.clearance))
    largest = sum((np.abs(each.rows).max(axis=0) for each in pieces), np.zeros(cell.robot.n))
    reach = np.ascontiguousarray(world.motion.reach + world.motion.stretch @ largest)
    codes = np.zeros((len(pieces[0].seconds), len(pieces[1].seconds)), np.int8)
    states = diagram_loops.classify_cells(world, pieces[0].rows, pieces[1].rows, reach, codes)
    return codes, int(states)


def _costs(codes: NDArray[np.int8], most: int, pieces: list[_Pieces]) -> tuple[Floats, NDArray[np.int8]]:
    shape = (codes.shape[0] + 1, codes.shape[1] + 1)
    cost, before = np.empty(shape), np.zeros(shape, np.int8)
    diagram_loops.quickest(codes, most, pieces[0].seconds, pieces[1].seconds, cost, before)
    return cost, before


def _way(codes: NDArray[np.int8], most: int, pieces: list[_Pieces]) -> Floats | None:
    """(p, 2) corners of the quickest way, in numbers of pieces; None where there is none."""
    cost, before = _costs(codes, most, pieces)
    if not np.isfinite(cost[-1, -1]):
        return None
    i, j = codes.shape
    corners, last = [(i, j)], diagram_loops.START
    while (move := int(before[i, j])) != diagram_loops.START:
        i -= move in (diagram_loops.BOTH, diagram_loops.FIRST)
        j -= move in (diagram_loops.BOTH, diagram_loops.SECOND)
        if move == last:
            corners[-1] = (i, j)
        else:
            corners.append((i, j))
        last = move
    return np.array(corners[::-1], dtype=np.float64)


def _straighten(cell: MultiArmCell, pieces: list[_Pieces], way: Floats) -> Floats:
    """The way with straight lines for staircases, where they are proved free and take no longer."""
    rows, k = list(way), 0
    while k + 2 < len(rows):
        for j in range(len(rows) - 1, k + 1, -1):
            if _lasts(pieces, rows[k : j + 1]) < _lasts(pieces, [rows[k], rows[j]]) * (1.0 - 1e-9):
                continue
            points = _with_corners(pieces, np.stack([rows[k], rows[j]]))
            q = np.stack([_at(pieces[0], x) + _at(pieces[1], y) for x, y in points])
            if np.all(cell.free_segment(q[:-1], q[1:])):
                rows[k + 1 : j] = []
                break
        k += 1
    return np.stack(rows)


def _lasts(pieces: list[_Pieces], way: list[Floats]) -> float:
    """How long a way through the diagram takes at full speed [s]."""
    clocks = [np.concatenate([[0.0], np.cumsum(each.seconds)]) for each in pieces]
    points = _with_corners(pieces, np.stack(way))
    t = np.stack([np.interp(points[:, k], np.arange(len(c)), c) for k, c in enumerate(clocks)], axis=1)
    return float(np.diff(t, axis=0).max(axis=1).sum())


def _with_corners(pieces: list[_Pieces], way: Floats) -> Floats:
    """The way with a point wherever one of the arms passes a corner of its path."""
    found = [way[0]]
    corners = [_corners(each) for each in pieces]
    for a, b in pairwise(way):
        shares = [
            (corner - a[k]) / (b[k] - a[k])
            for k in range(2)
            if b[k] > a[k]
            for corner in corners[k][(corners[k] > a[k]) & (corners[k] < b[k])]
        ]
        for share in sorted({round(float(share), 12) for share in shares}):
            found.append(a + share * (b - a))
        found.append(b)
    return np.stack(found)


def _corners(pieces: _Pieces) -> NDArray[np.intp]:
    """Numbers of pieces at which the direction of a path changes."""
    steps = np.diff(pieces.points, axis=0)
    turned = np.abs(np.diff(steps / np.maximum(pieces.seconds, LEAST_DIVISOR)[:, None], axis=0)).max(
        axis=1, initial=0.0
    )
    return np.flatnonzero(turned > 1e-9) + 1


def _at(pieces: _Pieces, place: float) -> JointVector:
    """The configuration (n,) at a place given in numbers of pieces, zero in the columns of the other arm."""
    k = min(int(place), len(pieces.seconds) - 1)
    return pieces.rows[k] + (place - k) * (pieces.rows[k + 1] - pieces.rows[k])


def _waits(cell: MultiArmCell, pieces: list[_Pieces], cost: Floats) -> tuple[BlockedArm, ...]:
    """Where both arms are furthest on the whole, and what each would meet next."""
    i, j = np.meshgrid(pieces[0].shares, pieces[1].shares, indexing="ij")
    place = np.unravel_index(int(np.where(np.isfinite(cost), i + j, -1.0).argmax()), cost.shape)
    found = list[BlockedArm]()
    for k, name in enumerate(cell.names):
        at = [int(place[0]), int(place[1])]
        share, last = float(pieces[k].shares[at[k]]), len(pieces[k].seconds)
        contact = None
        while contact is None and at[k] < last:
            at[k] += 1
            check = cell.check(pieces[0].rows[at[0]] + pieces[1].rows[at[1]])
            contact = None if check else check.contacts[0]
        found.append(BlockedArm(name, share, contact))
    return tuple(found)
