"""Slices of a workspace with the tool turned as asked: what an arm holds at each point, where it reaches, its voids.

Without an orientation the distance from every cell to the nearest place of the tool is searched; with one the inverse
kinematics decides. A void is a connected region of cells out of reach that reached cells enclose.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, JointVector, PoseMatrix, as_batch, number, positive
from mafsil.design.arm import ArmDesign
from mafsil.design.family import ArmNumbers, configurations, extreme_distances, reach_and_void
from mafsil.errors import InputError
from mafsil.geometry import rotation
from mafsil.ik import SolutionBatch, inverse_kinematics, solve_ik
from mafsil.messages import say
from mafsil.model.appearance import reach
from mafsil.model.loading import RobotLike
from mafsil.performance.statics import largest_payload
from mafsil.performance.velocity.scaling import ranges
from mafsil.robot import Robot

MOST_CELLS = 100_000
REACHED_WITHIN, STARTS, SETTLED = 1e-2, 4, 1e-6
"""Share of a cell that counts as no distance; starts, and share of a distance that ends the search for the nearest."""
PLANES: dict[str, tuple[int, int]] = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}


class ReachMapStatus(Status):
    """Whether the tool reaches a slice, and whether that encloses voids."""

    NO_VOIDS = ("design.reach_without_voids", True)
    HAS_VOIDS = ("design.reach_with_voids", True)
    NOT_REACHED = ("design.map_not_reached", False)


class PayloadMapStatus(Status):
    """Whether the arm holds something wherever it reaches."""

    HOLDS = ("design.map_holds", True)
    TOO_WEAK = ("design.map_too_weak", False)
    """At some points its own weight exceeds the effort limits."""
    NOT_REACHED = ("design.map_not_reached", False)


@dataclass(frozen=True, eq=False, repr=False)
class SliceMap(Answer, data="robot plane at cell x y rpy"):
    """Where the cells of a slice of a workspace lie, and how the tool is turned in them.

    Attributes:
        robot: name.
        plane: `xy`, `xz` or `yz`: the axes of {s} along x and y.
        at: the third coordinate [m].
        cell: edge of a cell [m].
        x, y: (X,), (Y,) middles of the cells [m].
        rpy: (K, 3) orientations of the tool in {s}; (0, 3) where any orientation counts, K = 1 then [rad].
    """

    robot: str
    plane: str
    at: float
    cell: float
    x: Floats
    y: Floats
    rpy: Floats


@dataclass(frozen=True, eq=False, repr=False)
class PayloadMap(SliceMap, data="payload limiting_joint least least_at reached"):
    """The largest mass at each cell of a slice, for K orientations of the tool; true if above zero wherever reached.

    Attributes:
        payload: (X, Y, K) of the configuration that holds most [kg]; infinite where no limited joint feels it, zero
            where the arm's own weight exceeds the limits in every configuration, NaN where none was found.
        limiting_joint: (X, Y, K) which limit binds; -1 where none does or none was found.
        q: (X, Y, K, n) that configuration [rad | m]; NaN where none was found.
    """

    payload: Floats
    limiting_joint: Any
    q: JointVector

    @property
    def status(self) -> PayloadMapStatus:
        """Whether it holds something wherever it reaches."""
        if not self.reached:
            return PayloadMapStatus.NOT_REACHED
        return PayloadMapStatus.HOLDS if self.least > 0.0 else PayloadMapStatus.TOO_WEAK

    @property
    def reached(self) -> float:
        """Share of the cells, over all orientations, at which a configuration was found."""
        return float(np.isfinite(self.q[..., 0]).mean())

    @property
    def least(self) -> float:
        """The payload that the arm holds wherever it reaches, however turned [kg]; NaN where it reaches nothing."""
        return float(np.nanmin(self.payload)) if self.reached else float("nan")

    @property
    def least_at(self) -> tuple[float, float]:
        """The cell where that is [m]."""
        if not self.reached:
            return float("nan"), float("nan")
        i, j, _ = np.unravel_index(int(np.nanargmin(self.payload)), self.payload.shape)
        return float(self.x[i]), float(self.y[j])

    @property
    def largest(self) -> float:
        """The most that it holds in any cell [kg]; NaN where it reaches nothing."""
        return float(np.nanmax(self.payload)) if self.reached else float("nan")

    def explain(self, language: str | None = None) -> str:
        """How much it holds wherever it reaches, and where least."""
        x, y = self.least_at
        details = {"axis": self.plane[0], "second": self.plane[1], "x": x, "y": y, "share": 100.0 * self.reached}
        return self.status.sentence(
            language, robot=self.robot, plane=self.plane, least=self.least, most=self.largest, **details
        )


def payload_map(
    design: ArmDesign | RobotLike,
    plane: Literal["xy", "xz", "yz"] = "xz",
    *,
    at: float = 0.0,
    cell: float | None = None,
    rpy: ArrayLike | None = None,
    centre: ArrayLike = (0.0, 0.0, 0.0),
) -> PayloadMap:
    """The largest payload that an arm holds still over a slice of its workspace, at each orientation of the tool.

    Of all configurations within the joint limits that inverse kinematics gives the one counts that holds most: of a
    redundant arm those at its usual value of the free joint. Without orientations one configuration is searched.

    Args:
        design: of a `ParametricArm`, or any robot with effort limits.
        plane: of the slice, axes of {s}.
        at: its coordinate along the third axis [m].
        cell: edge of a cell [m]; a twenty-fifth of the arm's reach if None.
        rpy: (K, 3) orientations of the tool in {s}; any orientation if None [rad].
        centre: (3,) of mass of the payload in the tip frame [m].

    Raises:
        InputError: an unknown plane, too fine a grid, no gravity, or an arm without effort limits.
    """
    robot = ArmDesign.of(design).robot
    if not np.isfinite(robot.limits.effort).any():
        raise InputError("performance.no_limit", robot=robot.name, joint=robot.joint_names[0], what="effort")
    grid = _Slice.of(robot, plane, at, cell, rpy)
    q, held, joint = _best(robot, grid.poses.reshape(-1, 4, 4), centre, turned=bool(len(grid.rpy)))
    shape = grid.poses.shape[:3]
    return PayloadMap(
        robot.name, plane, grid.at, grid.cell, grid.x, grid.y, grid.rpy, held.reshape(shape), joint.reshape(shape),
        q.reshape(*shape, robot.n),
    )  # fmt: skip


@dataclass(frozen=True, eq=False, repr=False)
class ReachMap(SliceMap, data="distance reached voids"):
    """Which cells of a slice the tool reaches, for K orientations of it; true if it reaches any.

    Attributes:
        distance: (X, Y, K) from the middle of the cell to the nearest place of the tool that was found, zero
            where it gets there, to the sphere of the reach from beyond it [m]; of a given orientation infinite where no
            configuration was found.
    """

    distance: Floats

    @property
    def status(self) -> ReachMapStatus:
        """Whether it reaches the slice, and all of what it encloses."""
        if not self.reached:
            return ReachMapStatus.NOT_REACHED
        return ReachMapStatus.HAS_VOIDS if any(self.voids) else ReachMapStatus.NO_VOIDS

    @property
    def reached(self) -> float:
        """Share of the cells, over all orientations, that the tool reaches."""
        return float((self.distance == 0.0).mean())

    @property
    def area(self) -> Floats:
        """(K,) of the cells that the tool reaches [m^2]."""
        return np.asarray((self.distance == 0.0).sum(axis=(0, 1)) * self.cell**2)

    @property
    def voids(self) -> list[list[tuple[float, float, float, float]]]:
        """For each orientation the voids, the largest first: x, y of the cell deepest inside, radius, area.

        The radius is the distance from there to the nearest place of the tool [m]; infinite, for unknown, where an
        orientation is given.
        """
        return [self._voids_of(self.distance[..., k]) for k in range(self.distance.shape[2])]

    def _voids_of(self, distance: Floats) -> list[tuple[float, float, float, float]]:
        import scipy.ndimage

        label: Any = scipy.ndimage.label  # carries no types
        regions: Any = label(np.pad(distance > 0.0, 1, constant_values=True))[0]
        inner, outside = regions[1:-1, 1:-1], regions[0, 0]
        found: list[tuple[float, float, float, float]] = []
        for region in set(np.unique(inner).tolist()) - {0, int(outside)}:
            rows, columns = np.nonzero(inner == region)
            deepest = int(distance[rows, columns].argmax())
            place = float(self.x[rows[deepest]]), float(self.y[columns[deepest]])
            found.append((*place, float(distance[rows, columns].max()), len(rows) * self.cell**2))
        return sorted(found, key=lambda void: -void[3])

    def explain(self, language: str | None = None) -> str:
        """How much of the slice is reached, and the largest void at each orientation."""
        area = ", ".join(f"{value:.4g}" for value in self.area)
        lines = [self.status.sentence(language, robot=self.robot, plane=self.plane, area=area)]
        for k, voids in enumerate(self.voids):
            for x, y, radius, size in voids:
                details = {"x": x, "y": y, "radius": radius, "area": size, "number": k + 1}
                key = "design.void_of_any" if not len(self.rpy) else "design.void_of_orientation"
                lines.append(say(key, language=language, **details))
        return "\n".join(lines)


def reach_map(
    design: ArmDesign | RobotLike,
    plane: Literal["xy", "xz", "yz"] = "xz",
    *,
    at: float = 0.0,
    cell: float | None = None,
    rpy: ArrayLike | None = None,
) -> ReachMap:
    """Where the tool gets in a slice of the workspace, at each orientation of it, and what it cannot enter.

    Args:
        design: of a `ParametricArm`, or any robot.
        plane: of the slice, axes of {s}.
        at: its coordinate along the third axis [m].
        cell: edge of a cell [m]; a twenty-fifth of the arm's reach if None.
        rpy: (K, 3) orientations of the tool in {s}; any orientation if None [rad].

    Raises:
        InputError: an unknown plane, too fine a grid, no chain of revolute and prismatic joints.
    """
    robot = ArmDesign.of(design).robot
    grid = _Slice.of(robot, plane, at, cell, rpy)
    shape, poses = grid.poses.shape[:3], grid.poses.reshape(-1, 4, 4)
    if len(grid.rpy):
        found = cast("SolutionBatch", inverse_kinematics(robot, poses))
        reached: Booleans = np.asarray((found.valid & found.within).any(axis=1))
        distance = np.where(reached, 0.0, np.inf)
    else:
        distance = _distances(robot, poses, grid.cell)
    return ReachMap(robot.name, plane, grid.at, grid.cell, grid.x, grid.y, grid.rpy, distance.reshape(shape))


def _distances(robot: Robot, poses: PoseMatrix, cell: float) -> Floats:
    """(P,) distances to the nearest place of the tool that was found, zero where it gets to the pose's place [m].

    Beyond the reach it is the way to its sphere. Newton's method finds most places that are reached; the slower search
    for the least distance judges the others.
    """
    arm, (low, high), near = ArmNumbers.of(robot), ranges(robot), cell * REACHED_WITHIN
    one, points = ArmNumbers.stack([arm]), poses[:, :3, 3]
    (far,), _ = reach_and_void(one, low[None], high[None])
    distance = np.maximum(np.linalg.norm(points - arm.shoulder, axis=1) - far, 0.0)
    within = np.flatnonzero(distance <= near)
    q = configurations(
        one.spread(), poses[within], "position", low[None], high[None], 0, 1, lambda T, J: np.zeros(len(T))
    )[0]
    distance[within], missed = 0.0, within[np.isnan(q[:, 0])]
    found, _ = extreme_distances(
        arm, points[missed], low, high, farthest=False, starts=STARTS, enough=near, settled=SETTLED
    )
    distance[missed] = np.where(found <= near, 0.0, found)
    return distance


@dataclass(frozen=True, eq=False, slots=True)
class _Slice:
    """Cells of a plane and the poses of the tool in them: `at`, `cell`, `x`, `y`, `rpy` as of `ReachMap`.

    Attributes:
        poses: (X, Y, K, 4, 4).
    """

    at: float
    cell: float
    x: Floats
    y: Floats
    rpy: Floats
    poses: PoseMatrix

    @classmethod
    def of(cls, robot: Robot, plane: str, at: float, cell: float | None, rpy: ArrayLike | None) -> _Slice:
        """That around an arm's base, as wide as its links allow."""
        if plane not in PLANES:
            raise InputError("input.choice", name="plane", value=plane, known=", ".join(PLANES))
        at, size = number("at", at), reach(robot.mechanism)
        width = size / 25.0 if cell is None else positive("cell", cell)
        base, axes = robot.mechanism.T_sb[:3, 3], PLANES[plane]
        if (2.0 * size / width) ** 2 > MOST_CELLS:
            raise InputError("performance.too_many_cells", count=(2.0 * size / width) ** 2, limit=MOST_CELLS)
        x, y = (_middles(float(base[k]), size, width) for k in axes)
        turns = np.zeros((0, 3)) if rpy is None else as_batch("rpy", rpy, (3,), finite=True).reshape(-1, 3)
        T = np.tile(np.eye(4), (len(x), len(y), max(len(turns), 1), 1, 1))
        T[..., axes[0], 3], T[..., axes[1], 3] = x[:, None, None], y[:, None]
        T[..., 3 - sum(axes), 3] = at
        if len(turns):
            T[..., :3, :3] = rotation.from_rpy(turns)
        return cls(at, width, x, y, turns, T)


def _middles(base: float, size: float, cell: float) -> Floats:
    """Multiples of the cell's edge around the base, so that cells of other slices lie in the same rows."""
    first, last = int(np.floor((base - size) / cell)), int(np.ceil((base + size) / cell))
    return cell * np.linspace(first, last, last - first + 1)


def _best(robot: Robot, T: Floats, centre: ArrayLike, *, turned: bool) -> tuple[JointVector, Floats, Any]:
    """(P, n) configurations that hold most at poses (P, 4, 4), what they hold (P,), and the joint that limits it."""
    if turned:
        found = cast("SolutionBatch", inverse_kinematics(robot, T))
        q, good = np.asarray(found.q), np.asarray(found.valid & found.within)
    else:
        one = solve_ik(robot, T, task="position")
        q, good = np.asarray(one.nearest)[:, None], np.asarray(one.solved)[:, None]
    capacity = largest_payload(robot, np.where(good[..., None], q, 0.0), centre)
    # Own weight beyond the limits holds nothing, which is less than any payload and more than no configuration.
    held = np.where(good, np.nan_to_num(capacity.largest, nan=0.0, posinf=np.inf), -1.0)
    best, row = held.argmax(axis=1), np.arange(len(T))
    reached: Booleans = np.asarray(good.any(axis=1))
    return (
        np.where(reached[:, None], q[row, best], np.nan),
        np.where(reached, held[row, best], np.nan),
        np.where(reached, capacity.limiting_joint[row, best], -1),
    )
