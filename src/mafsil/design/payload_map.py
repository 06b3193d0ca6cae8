"""What an arm can hold at each point of a slice of its workspace, with the tool turned as asked."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Literal, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, JointVector, as_batch, number, positive
from mafsil.design.arm import ArmDesign
from mafsil.errors import InputError
from mafsil.geometry import rotation
from mafsil.ik import SolutionBatch, inverse_kinematics, solve_ik
from mafsil.model.appearance import reach
from mafsil.model.loading import RobotLike
from mafsil.performance.statics import largest_payload
from mafsil.robot import Robot

MOST_CELLS = 100_000
PLANES: dict[str, tuple[int, int]] = {"xy": (0, 1), "xz": (0, 2), "yz": (1, 2)}


class PayloadMapStatus(Status):
    """Whether the arm holds something wherever it reaches."""

    HOLDS = ("design.map_holds", True)
    TOO_WEAK = ("design.map_too_weak", False)
    """At some points its own weight exceeds the effort limits."""
    NOT_REACHED = ("design.map_not_reached", False)


@dataclass(frozen=True, eq=False, repr=False)
class PayloadMap(Answer, data="robot plane at cell x y rpy payload limiting_joint least least_at reached"):
    """The largest mass at each cell of a slice, for K orientations of the tool; true if above zero wherever reached.

    Attributes:
        robot: name.
        plane: `xy`, `xz` or `yz`: the axes of {s} along x and y.
        at: the third coordinate [m].
        cell: edge of a cell [m].
        x, y: (X,), (Y,) middles of the cells [m].
        rpy: (K, 3) orientations of the tool in {s}; (0, 3) where any orientation counts, K = 1 then [rad].
        payload: (X, Y, K) of the configuration that holds most [kg]; infinite where no limited joint feels it, zero
            where the arm's own weight exceeds the limits in every configuration, NaN where none was found.
        limiting_joint: (X, Y, K) which limit binds; -1 where none does or none was found.
        q: (X, Y, K, n) that configuration [rad | m]; NaN where none was found.
    """

    robot: str
    plane: str
    at: float
    cell: float
    x: Floats
    y: Floats
    rpy: Floats
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
    if plane not in PLANES:
        raise InputError("input.choice", name="plane", value=plane, known=", ".join(PLANES))
    robot, at = ArmDesign.of(design).robot, number("at", at)
    if not np.isfinite(robot.limits.effort).any():
        raise InputError("performance.no_limit", robot=robot.name, joint=robot.joint_names[0], what="effort")
    size = reach(robot.mechanism)
    cell = size / 25.0 if cell is None else positive("cell", cell)
    base, axes = robot.mechanism.T_sb[:3, 3], PLANES[plane]
    if (2.0 * size / cell) ** 2 > MOST_CELLS:
        raise InputError("performance.too_many_cells", count=(2.0 * size / cell) ** 2, limit=MOST_CELLS)
    x, y = (_middles(float(base[k]), size, cell) for k in axes)
    turns = np.zeros((0, 3)) if rpy is None else as_batch("rpy", rpy, (3,), finite=True).reshape(-1, 3)
    T = np.tile(np.eye(4), (len(x), len(y), max(len(turns), 1), 1, 1))
    T[..., axes[0], 3], T[..., axes[1], 3] = x[:, None, None], y[:, None]
    T[..., 3 - sum(axes), 3] = at
    if len(turns):
        T[..., :3, :3] = rotation.from_rpy(turns)
    q, held, joint = _best(robot, T.reshape(-1, 4, 4), centre, turned=bool(len(turns)))
    shape = T.shape[:3]
    return PayloadMap(
        robot.name, plane, at, cell, x, y, turns, held.reshape(shape), joint.reshape(shape), q.reshape(*shape, robot.n)
    )


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
