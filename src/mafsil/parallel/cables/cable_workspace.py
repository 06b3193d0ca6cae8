"""Where cables can hold a platform: against every wrench, or against given loads, on a grid of places.

Reference: Gouttefarde, Daney and Merlet, Interval-analysis-based determination of the wrench-feasible workspace of
parallel cable-driven robots, IEEE Trans. Robotics 27 (2011), for the terms.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, as_batch, single, whole
from mafsil.errors import InputError
from mafsil.geometry import rotation
from mafsil.parallel.cables.cable_robot import CableRobot
from mafsil.parallel.cables.cable_tensions import cable_margins, facets, platform_wrenches
from mafsil.parallel.platforms.platform_workspace import grid_volume

BLOCK = 65536
"""Poses that are judged at once: some 50 MB."""
TOUCHING = 1e-9
"""Pull along a direction below which it counts as none."""


class ClosureStatus(Status):
    """Whether cables enclose a platform."""

    CLOSED = ("parallel.cables_closed", True)
    OPEN = ("parallel.cables_open", False)


@dataclass(frozen=True, eq=False, repr=False)
class CableClosure(Answer, data="measure direction"):
    """Whether cables of any strength hold every wrench; true if they do in every row, iterable over the rows.

    Attributes:
        measure: (*batch) of the directions normal to n - 1 cables, which decide, the least of the strongest pulls of a
            unit tension; not above zero where no cable pulls along some direction.
        direction: (*batch, n) that direction, as a wrench about the middle of the platform's ends, moments over `size`.
    """

    measure: Floats
    direction: Floats

    @property
    def closed(self) -> Booleans:
        """(*batch) whether every direction has a cable that pulls along it."""
        return np.asarray(self.measure > TOUCHING, dtype=np.bool_)

    @property
    def status(self) -> ClosureStatus:
        """CLOSED if all rows are."""
        return ClosureStatus.CLOSED if self.closed.all() else ClosureStatus.OPEN

    def __bool__(self) -> bool:
        return self.status.succeeded and self.measure.size > 0

    def __len__(self) -> int:
        return self.measure.size

    def __iter__(self) -> Iterator[CableClosure]:
        for row in np.ndindex(self.measure.shape):
            yield CableClosure(self.measure[row], self.direction[row])

    def explain(self, language: str | None = None) -> str:
        """The weakest direction, or the first one along which no cable pulls."""
        if not self.measure.size:
            return ClosureStatus.CLOSED.sentence(language, closed=0, count=0, measure=0.0)
        row = np.unravel_index(int(np.argmax(~self.closed)), self.measure.shape)
        return self.status.sentence(
            language, closed=int(self.closed.sum()), count=len(self), measure=float(self.measure.min()),
            direction=", ".join(f"{each:.3g}" for each in self.direction[row]),
        )  # fmt: skip


def cable_closure(robot: CableRobot, x: ArrayLike) -> CableClosure:
    """Whether the cables at poses can make every wrench if they are strong enough (wrench closure).

    Args:
        robot: its cables.
        x: poses T_sb (*batch, 4, 4), in the plane (x, y, phi) (*batch, 3).

    Raises:
        InputError: x is no pose, a cable has length zero.
    """
    W, wanted, shape = platform_wrenches(robot, x, np.zeros(3 if robot.planar else 6))
    found = facets(robot, W, wanted)
    measure = np.where(np.isfinite(found.closure), found.closure, 0.0)
    return CableClosure(measure.reshape(shape), found.loose.reshape(*shape, wanted.shape[1]))


class CableWorkspaceStatus(Status):
    """Whether loads can be held anywhere."""

    SOME = ("parallel.cable_workspace_some", True)
    EMPTY = ("parallel.cable_workspace_empty", False)


@dataclass(frozen=True, eq=False, repr=False)
class CableWorkspace(Answer, data="axes margin"):
    """Where cables hold all given loads, on a grid; true if they do anywhere, iterable over the orientations.

    Attributes:
        axes: places of the grid along x, y and, in space, z [m].
        margin: (k, nx, ny[, nz]) least margin of all loads in each of k orientations [N]; negative: not held.
    """

    axes: tuple[Floats, ...]
    margin: Floats

    @property
    def feasible(self) -> Booleans:
        """(k, nx, ny[, nz]) where all loads are held."""
        return np.asarray(self.margin >= 0.0, dtype=np.bool_)

    def volume(self, places: Booleans) -> tuple[float, float]:
        """Volume, in the plane area, of places (nx, ny[, nz]) and how far it may be wrong [m^3 | m^2]."""
        return grid_volume(self.axes, places)

    @property
    def status(self) -> CableWorkspaceStatus:
        """Some or none."""
        return CableWorkspaceStatus.SOME if self.feasible.any() else CableWorkspaceStatus.EMPTY

    def __len__(self) -> int:
        return len(self.margin)

    def __iter__(self) -> Iterator[Booleans]:
        return iter(self.feasible)

    def explain(self, language: str | None = None) -> str:
        """Volumes with their errors, and the best margin with its place."""
        every, some = (
            self.volume(np.asarray(places)) for places in (self.feasible.all(axis=0), self.feasible.any(axis=0))
        )
        best = np.unravel_index(int(self.margin.argmax()), self.margin.shape)
        place = ", ".join(f"{axis[k]:.4g}" for axis, k in zip(self.axes, best[1:], strict=True))
        return self.status.sentence(
            language, all=every[0], all_error=every[1], some=some[0], some_error=some[1], orientations=len(self),
            best=float(self.margin.max()), place=place, unit=f"m^{len(self.axes)}",
        )  # fmt: skip


def cable_workspace(
    robot: CableRobot, loads: ArrayLike, lower: ArrayLike, upper: ArrayLike, cells: int = 41,
    orientations: ArrayLike | None = None,
) -> CableWorkspace:  # fmt: skip
    """Where the cables hold all given loads (wrench-feasible workspace), at the middles of the cells of a box.

    Args:
        robot: its cables.
        loads: (k, 6 | 3) wrenches from outside about the origin of the platform, axes of {s} [N m, N]; the corners of a
            body of loads stand for all of it.
        lower, upper: (3,) or (2,) corners of the box [m].
        cells: along each side.
        orientations: (k, 3, 3) of the platform, in the plane angles (k,); one without rotation if None.

    Raises:
        InputError: wrong shapes, no box; a place of the grid where a cable has length zero.
    """
    d = robot.base.shape[1]
    low, high, n = single("lower", lower, (d,)), single("upper", upper, (d,)), whole("cells", cells, 1, 2000)
    if not (low < high).all():
        raise InputError("parallel.box", low=low.tolist(), high=high.tolist())
    wrenches = as_batch("loads", loads, (3 if robot.planar else 6,), finite=True).reshape(-1, 3 if robot.planar else 6)
    if not len(wrenches):
        raise InputError("input.shape", name="loads", expected="(k, 6) or (k, 3), k >= 1", got=wrenches.shape, hint="")
    steps = (np.arange(n) + 0.5) / n
    axes = tuple(low[k] + (high[k] - low[k]) * steps for k in range(d))
    places = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, d)
    poses = [_poses(robot, places, turn) for turn in _orientations(robot, orientations)]
    margin = np.empty((len(poses), len(places)))
    for k, rows in enumerate(poses):
        for first in range(0, len(rows), BLOCK):
            part = slice(first, first + BLOCK)
            margin[k, part] = np.min([_margins(robot, rows[part], places[part], F) for F in wrenches], axis=0)
    return CableWorkspace(axes, margin.reshape(len(poses), *(n,) * d))


def _margins(robot: CableRobot, x: Floats, places: Floats, load: Floats) -> Floats:
    """(rows,) margins of a load about the platform's origin; minus infinity where cables depend on each other."""
    found = np.tile(load, (len(x), 1))
    if robot.planar:
        found[:, 0] += places[:, 0] * load[2] - places[:, 1] * load[1]
    else:
        found[:, :3] += np.cross(places, load[3:])
    return cable_margins(robot, x, found)


def _orientations(robot: CableRobot, given: ArrayLike | None) -> Floats:
    """(k, 3, 3) rotations, in the plane (k,) angles."""
    if robot.planar:
        return np.zeros(1) if given is None else as_batch("orientations", given, (), finite=True).reshape(-1)
    R = np.eye(3)[None] if given is None else as_batch("orientations", given, (3, 3))
    return rotation.check(R).reshape(-1, 3, 3)


def _poses(robot: CableRobot, places: Floats, turn: Floats) -> Floats:
    """Poses of one orientation at places (rows, 3 | 2)."""
    if robot.planar:
        return np.column_stack([places, np.broadcast_to(turn, len(places))])
    T = np.broadcast_to(np.eye(4), (len(places), 4, 4)).copy()
    T[:, :3, :3], T[:, :3, 3] = turn, places
    return T
