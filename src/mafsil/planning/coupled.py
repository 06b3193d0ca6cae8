"""Several arms planned at once: one search in the coordinates of all of them."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import JointVector
from mafsil.collision import MultiArmCell
from mafsil.geometry import Pose
from mafsil.planning.arm_plan import ArmPlan
from mafsil.planning.arm_planning import configurations_of, plan

MOST_GOALS = 256
"""Combinations of the arms' goals that are tried, the nearest to the start first."""


def plan_coupled(
    cell: MultiArmCell,
    start: Mapping[str, ArrayLike],
    goal: Mapping[str, ArrayLike | Pose],
    *,
    planner: str = "rrt_connect",
    seed: int = 0,
    seconds: float = 10.0,
    max_nodes: int = 200_000,
    shortcut_iterations: int = 100,
) -> ArmPlan:
    """A path of all arms at once, each straight motion of all their joints proved free.

    Any arm may move, also one that ends where it starts: it makes way. Of poses all solutions of the inverse kinematics
    that are free without the other arms are combined. Loops of mechanisms stay closed, as in `mf.plan`.

    Args:
        cell: the arms in their scene.
        start: for each arm (n of the arm) [rad | m].
        goal: for each arm its configuration, several of which any will do, or poses of its tip, as for `mf.plan`;
            an arm that is not named ends where it starts.
        planner, seed, seconds, max_nodes, shortcut_iterations: as for `mf.plan`.

    Returns:
        Rows of the path are coordinates of all arms: `cell.split(plan.path)` has those of each.

    Raises:
        InputError: an unknown arm, a start that is missing, a wrong shape.
    """
    q = cell.join(start)
    goals = _combine(cell, cell.split(q), goal)
    return plan(
        cell, None, q, goals, planner=planner, seed=seed, seconds=seconds, max_nodes=max_nodes,
        shortcut_iterations=shortcut_iterations,
    )  # fmt: skip


def _combine(cell: MultiArmCell, start: Mapping[str, JointVector], goal: Mapping[str, ArrayLike | Pose]) -> JointVector:
    """(k, n) goals of all arms, the nearest to the start first."""
    for name in goal:
        cell.alone(name)
    each = [
        configurations_of(cell.alone(name), goal[name], q) if name in goal else q[None] for name, q in start.items()
    ]
    open_rows = [_open(cell, name, rows) for name, rows in zip(cell.names, each, strict=True)]
    away = [np.linalg.norm(rows - q, axis=1) for rows, q in zip(open_rows, start.values(), strict=True)]
    sorted_rows = [rows[np.argsort(far, kind="stable")] for rows, far in zip(open_rows, away, strict=True)]
    per_arm = max(int(MOST_GOALS ** (1.0 / len(cell.names))), 1)
    rows = [np.concatenate(parts) for parts in product(*(rows[:per_arm] for rows in sorted_rows))]
    return np.stack(rows) if rows else np.zeros((0, cell.robot.n))


def _open(cell: MultiArmCell, name: str, rows: JointVector) -> JointVector:
    """Of some configurations of one arm those that are free without the others; all if none is, so that it is said."""
    free = cell.alone(name).free(rows) if len(rows) else np.zeros(0, np.bool_)
    return rows[free] if np.any(free) else rows
