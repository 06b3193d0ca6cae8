"""R19: two and three arms on one table: no motion in collision at 0.001 rad, limits kept, deadlocks real.

`python -m tests.reliability.several_arms --problems 1000 --resume DIR`

Random scenes around them. Each problem is planned together, in turn and, for two arms, on the straight paths of both by
the coordination diagram. What is returned is looked at densely over time; a deadlock is held against a search over
60 x 60 places of both paths, which must find no way; every "no" has to name what it claims. "Not found" is counted,
not judged.
"""

from __future__ import annotations

import sys
import tempfile
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np

import mafsil as mf
from mafsil.collision import ArmMount, MultiArmCell
from mafsil.model.placement import rotation_z
from mafsil.planning import coordinate_arms, plan_coupled, plan_prioritized
from mafsil.planning.outcome import PlanningStatus
from mafsil.trajectory import MotionLimits
from tests.collision.arms import scene, urdf
from tests.reliability import figures

STEP = 1e-3
"""Largest change of a coordinate between states that are looked at [rad]."""
VELOCITY, ACCELERATION = 2.0, 8.0


@cache
def cells() -> tuple[MultiArmCell, ...]:
    """Tables with two and three arms, near and far."""
    with tempfile.TemporaryDirectory() as folder:
        file = Path(folder) / "arm.urdf"
        file.write_text(urdf())
        robot = mf.load(str(file))
    found = []
    for count, radius in ((2, 0.5), (2, 0.7), (3, 0.7)):
        mounted = []
        for k in range(count):
            T = rotation_z(2.0 * np.pi * k / count)
            T[:3, 3] = -radius * T[:3, 0]
            mounted.append(ArmMount(f"arm{k}", robot, T))
        found.append(MultiArmCell(mounted))
    return tuple(found)


def dense(at, duration: float) -> np.ndarray:
    """States of a motion in time, no coordinate more than STEP apart."""
    t = np.linspace(0.0, duration, 300)
    way = np.abs(np.diff(at(t), axis=0)).max(axis=1)
    parts = [np.linspace(a, b, int(1.2 * w / STEP) + 2) for (a, b), w in zip(pairwise(t), way, strict=True)]
    return at(np.concatenate(parts))


def is_wrong(cell: MultiArmCell, at, duration: float, ends: np.ndarray) -> str:
    """What a motion gets wrong; empty if nothing."""
    if np.abs(at(np.array([0.0, duration])) - ends).max() > 1e-8:
        return "bad_ends"
    if not cell.free(dense(at, duration)).all():
        return "bad_collision"
    t = np.linspace(0.0, duration, 3000)
    velocity = np.diff(at(t), axis=0) / np.diff(t)[:, None]
    acceleration = np.diff(velocity, axis=0) / np.diff(t)[1:, None]
    fast = np.abs(velocity).max(initial=0.0) > VELOCITY * (1.0 + 1e-6)
    hard = np.abs(acceleration).max(initial=0.0) > ACCELERATION * (1.0 + 1e-3)
    return "bad_limits" if fast or hard else ""


def has_way(cell: MultiArmCell, a: np.ndarray, b: np.ndarray, count: int = 60) -> bool:
    """Whether a search over places of both straight paths finds a way on which neither goes back."""
    shares = np.linspace(0.0, 1.0, count + 1)
    first, second = (rows[0] + shares[:, None] * (rows[1] - rows[0]) for rows in (a, b))
    names = cell.names
    free = cell.free(cell.join({names[0]: first[:, None], names[1]: second[None]}))
    reached = np.zeros_like(free)
    for i, j in np.ndindex(free.shape):
        before = [(i - 1, j), (i, j - 1), (i - 1, j - 1)]
        came = i == j == 0 or any(reached[x, y] for x, y in before if x >= 0 and y >= 0)
        reached[i, j] = free[i, j] and came
    return bool(reached[-1, -1])


def work(seed: int, problems: int) -> dict[str, int]:
    """Counts of one shard."""
    rng = np.random.default_rng([19, seed])
    names = ("problems", "together", "in_turn", "coordinated", "deadlocks", "not_found", "ends")
    wrong = ("bad_ends", "bad_collision", "bad_limits", "bad_deadlock", "bad_reason", "bad_proof")
    counts = dict.fromkeys((*names, *wrong), 0)
    for k in range(problems):
        cell = cells()[k % len(cells())]
        cell = cell.with_scene(scene(int(rng.integers(2**31)), int(rng.integers(0, 5))))
        q = cell.random_configurations(600)[rng.permutation(600)]
        free = q[cell.free(q)]
        if len(free) < 2:
            continue
        a, b = (free if rng.random() < 0.9 else q)[:2]
        start, goal = cell.split(a), cell.split(b)
        limits = MotionLimits.of(cell.robot.n, velocity=VELOCITY, acceleration=ACCELERATION)
        counts["problems"] += 1
        blocked = not (cell.free(a) and cell.free(b))
        together = plan_coupled(cell, start, goal, seed=k, max_nodes=4000, shortcut_iterations=20)
        turns = plan_prioritized(cell, start, goal, limits, seed=k, seconds=6.0)
        for name, answer in (("together", together), ("in_turn", turns)):
            counts[name] += bool(answer)
            ended = answer.status in (PlanningStatus.START_BLOCKED, PlanningStatus.GOAL_BLOCKED)
            counts["ends"] += ended
            counts["not_found"] += answer.status is PlanningStatus.NOT_FOUND
            counts["bad_reason"] += bool(ended != blocked or not answer.explain("en"))
        if together:
            counts["bad_proof"] += not cell.check_path(together.path)
            motion = together.time_optimal(limits)
            bad = is_wrong(cell, lambda t, m=motion: m.trajectory.at(t).u, motion.duration, np.stack([a, b]))
            if bad:
                counts[bad] += 1
        if turns:
            bad = is_wrong(cell, turns.at, turns.duration, np.stack([a, b]))
            if bad:
                counts[bad] += 1
        if len(cell.names) == 2:
            paths = {name: np.stack([start[name], goal[name]]) for name in cell.names}
            found = coordinate_arms(cell, paths, cells=60)
            counts["coordinated"] += bool(found)
            counts["deadlocks"] += found.status is PlanningStatus.DEADLOCK
            if found:
                counts["bad_proof"] += not cell.check_path(found.path)
            if found.status is PlanningStatus.DEADLOCK:
                counts["bad_deadlock"] += has_way(cell, *(paths[name] for name in cell.names))
    return {name: int(value) for name, value in counts.items() if name}


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "problems", 1_000, 100)
    sys.exit(not figures.run("R19", options, work)["passed"])
