"""R17: random scenes around arms: no crash, no path in collision, no "no" without a reason.

`python -m tests.reliability.planning_scenes --problems 10000 --resume DIR`

Every path is looked at densely (0.003 rad) and its ends compared; each refusal has to name what it claims: an end that
collides has to collide, one beyond a limit has to be beyond it. "Not found" is counted, not judged.
"""

from __future__ import annotations

import sys
import tempfile
from functools import cache
from itertools import pairwise
from pathlib import Path

import numpy as np

import mafsil as mf
from mafsil.collision import Checker
from mafsil.planning import ArmPlan
from mafsil.planning.outcome import PlanningStatus
from tests.collision.arms import arm, scene
from tests.reliability import figures

STEP = 0.003
"""Largest change of a coordinate between states that are looked at [rad]."""


@cache
def arms() -> tuple[Checker, ...]:
    """Arms of primitives, of meshless tables, with and without checks against themselves."""
    with tempfile.TemporaryDirectory() as folder:
        own = Checker(arm(Path(folder)))
    return (
        own,
        Checker("panda", radius=0.05, self_collision=False),
        Checker("scara_rrrp", radius=0.03, self_collision=False),
    )


def is_wrong(checker: Checker, start: np.ndarray, goal: np.ndarray, found: ArmPlan) -> str:
    """What an answer gets wrong; empty if nothing."""
    limits = checker.robot.limits
    if found:
        if not (np.array_equal(found.path[0], start) and np.array_equal(found.path[-1], goal)):
            return "bad_ends"
        for a, b in pairwise(found.path):
            states = a + np.linspace(0, 1, int(np.abs(b - a).max() / STEP) + 2)[:, None] * (b - a)
            if not checker.free(states).all():
                return "bad_collision"
        return "" if ((found.path >= limits.lower) & (found.path <= limits.upper)).all() else "bad_limits"
    claims = {
        PlanningStatus.START_BLOCKED: not checker.free(start),
        PlanningStatus.GOAL_BLOCKED: not checker.free(goal),
        PlanningStatus.START_OUTSIDE: bool(((start < limits.lower) | (start > limits.upper)).any()),
        PlanningStatus.GOAL_OUTSIDE: bool(((goal < limits.lower) | (goal > limits.upper)).any()),
        PlanningStatus.NOT_FOUND: True,
    }
    return "" if claims.get(found.status, False) and found.explain("en") else "bad_reason"


def work(seed: int, problems: int) -> dict[str, int]:
    """Counts of one shard."""
    rng = np.random.default_rng([12, seed])
    names = ("problems", "found", "straight", "ends", "not_found")
    counts = dict.fromkeys((*names, "bad_ends", "bad_collision", "bad_limits", "bad_reason"), 0)
    for k in range(problems):
        base = arms()[k % len(arms())]
        checker = base.with_scene(scene(int(rng.integers(2**31)), int(rng.integers(0, 12))))
        q = checker.random_configurations(40)[rng.permutation(40)[:8]] * rng.choice([1.0, 1.0, 1.0, 1.3])
        free = q[checker.free(q)]
        start, goal = free[:2] if len(free) > 1 and rng.random() < 0.8 else q[:2]
        found = mf.plan(checker, None, start, goal, seed=k, max_nodes=3000, seconds=20.0, shortcut_iterations=20)
        counts["problems"] += 1
        counts["found"] += bool(found)
        counts["straight"] += bool(found) and len(found.path) == 2
        counts["not_found"] += found.status is PlanningStatus.NOT_FOUND
        counts["ends"] += not found and found.status is not PlanningStatus.NOT_FOUND
        if wrong := is_wrong(checker, start, goal, found):
            counts[wrong] += 1
    return {name: int(value) for name, value in counts.items()}


if __name__ == "__main__":
    options = figures.arguments(__doc__ or "", "problems", 2_000, 500)
    sys.exit(not figures.run("R17", options, work)["passed"])
