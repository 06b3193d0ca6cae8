"""Planning with something to be kept, beside OMPL's RRT-Connect in its ProjectedStateSpace, in one run.

python benchmarks/constrained_planning.py [--count 20] [--seconds 10]        (pip install ompl for the peer)

A Panda of capsules among three obstacles; starts and goals are free and keep what is to be kept: the tool upright
within 0.05 rad, the tip within a millimetre of a plane, or of a line. Both sides ask the same checker whether a state
is free; OMPL's projections get kinematics and Jacobian of the same kernels through Python. Ours is the whole call, its
path proved free and proved to keep; both paths are looked at 0.001 rad apart.
"""

from __future__ import annotations

import argparse
import os
import sys
import warnings
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from time import perf_counter
from typing import Any

ROOT = Path(__file__).parents[1]
sys.path.insert(0, str(ROOT))
os.environ.setdefault("MAFSIL_THREADS", "1")

import numpy as np  # noqa: E402

import mafsil as mf  # noqa: E402
from mafsil import planning  # noqa: E402
from mafsil.arrays import Floats, JointVector, PoseMatrix  # noqa: E402
from mafsil.collision import Box, Checker, Obstacle, Sphere  # noqa: E402
from mafsil.geometry import rotation  # noqa: E402

ANGLE, DISTANCE = 0.05, 0.001
"""That are kept [rad, m]."""
SCENE = [
    Obstacle(Box((0.4, 0.04, 0.4)), (0.6, 0.0, 0.2), "wall"),
    Obstacle(Sphere(0.12), (-0.4, 0.4, 0.5), "ball"),
    Obstacle(Box((0.2, 0.2, 0.3)), (0.0, -0.6, 0.15), "block"),
]
NORMAL, LINE = np.array([0.0, 0.0, 1.0]), np.array([0.0, 1.0, 0.0])


@dataclass(frozen=True)
class Case:
    """Something to be kept.

    Attributes:
        name: of it.
        keep: as ours.
        residual: of poses (..., 4, 4) beside that of the start, (..., m).
        rate: (m, n) its Jacobian from that of the tip in space, of a pose and that of the start.
        tolerance: of the norm of the residual.
        goal: a pose that keeps it.
    """

    name: str
    keep: Any
    residual: Callable[[PoseMatrix, PoseMatrix], Floats]
    rate: Callable[[Floats, PoseMatrix, PoseMatrix], Floats]
    tolerance: float
    goal: Callable[[np.random.Generator, PoseMatrix], PoseMatrix]


def _turned(rng: np.random.Generator, T: PoseMatrix) -> PoseMatrix:
    found = np.array(T)
    w = rng.normal(size=3)
    found[:3, :3] = T[:3, :3] @ rotation.exp(rng.uniform(0.0, 1.0) * w / np.linalg.norm(w))
    return found


def _upright_goal(rng: np.random.Generator, T: PoseMatrix) -> PoseMatrix:
    found = np.array(T)
    found[:3, :3] = T[:3, :3] @ rotation.exp(np.array([0.0, 0.0, rng.uniform(-2.0, 2.0)]))
    found[:3, 3] = rng.uniform([-0.6, -0.6, 0.2], [0.6, 0.6, 0.7])
    return found


def _plane_goal(rng: np.random.Generator, T: PoseMatrix) -> PoseMatrix:
    found = _turned(rng, T)
    found[:2, 3] = rng.uniform(-0.6, 0.6, 2)
    return found


def _line_goal(rng: np.random.Generator, T: PoseMatrix) -> PoseMatrix:
    found = _turned(rng, T)
    found[1, 3] = rng.uniform(-0.6, 0.6)
    return found


def _point_rate(J: Floats, T: PoseMatrix) -> Floats:
    """(3, n) rate of the tip from the Jacobian in space, angular part first."""
    return J[3:] + np.cross(J[:3].T, T[:3, 3]).T


CASES = (
    Case(
        "upright", planning.Upright(ANGLE),
        lambda T, T_0: np.einsum("ki,...i->...k", T_0[:3, :2].T, T[..., :3, 2]),
        lambda J, T, T_0: T_0[:3, :2].T @ np.cross(J[:3].T, T[:3, 2]).T, float(np.sin(ANGLE)), _upright_goal,
    ),
    Case(
        "in a plane", planning.InPlane(NORMAL, tolerance=DISTANCE),
        lambda T, T_0: (T[..., :3, 3] - T_0[:3, 3])[..., 2:],
        lambda J, T, T_0: _point_rate(J, T)[2:], DISTANCE, _plane_goal,
    ),
    Case(
        "on a line", planning.OnLine(LINE, tolerance=DISTANCE),
        lambda T, T_0: (T[..., :3, 3] - T_0[:3, 3])[..., [0, 2]],
        lambda J, T, T_0: _point_rate(J, T)[[0, 2]], DISTANCE, _line_goal,
    ),
)  # fmt: skip


def problems(checker: Checker, case: Case, count: int) -> Iterator[tuple[JointVector, JointVector]]:
    """Free starts and goals that keep what is to be kept, whose straight motion does not do."""
    rng = np.random.default_rng(50)
    found = 0
    while found < count:
        q = rng.uniform(*_limits(checker))
        T = np.asarray(checker.robot.forward_kinematics(q))
        if not checker.free(q) or not 0.1 < T[2, 3] < 0.8 or T[2, 2] > -0.3:
            continue
        solutions = mf.inverse_kinematics(checker.robot, case.goal(rng, T), q0=q)
        goals = [row for row in np.asarray(solutions.q)[np.asarray(solutions.within, bool)] if checker.free(row)]
        if goals:
            goal = min(goals, key=lambda row: float(np.linalg.norm(row - q)))
            found += 1
            yield q, goal


def _limits(checker: Checker) -> tuple[Floats, Floats]:
    return checker.robot.limits.lower, checker.robot.limits.upper


def examined(checker: Checker, case: Case, path: JointVector) -> tuple[float, bool]:
    """Largest residual over the tolerance along a path at 0.001 rad, and whether all of it is free."""
    rows = [a + np.linspace(0, 1, int(np.abs(b - a).max() / 0.001) + 2)[:, None] * (b - a) for a, b in pairwise(path)]
    q = np.concatenate(rows)
    T = np.asarray(checker.robot.forward_kinematics(q))
    off = np.linalg.norm(case.residual(T, np.asarray(checker.robot.forward_kinematics(path[0]))), axis=-1)
    return float(off.max()) / case.tolerance, bool(checker.free(q).all())


def theirs(checker: Checker, case: Case, q: JointVector, goal: JointVector, seconds: float) -> JointVector | None:
    """OMPL's path; None if none was found in time."""
    from ompl import base, geometric, util  # pyright: ignore

    util.noOutputHandler()
    robot, n = checker.robot, checker.robot.n
    T_0 = np.asarray(robot.forward_kinematics(q))
    rows = len(np.atleast_1d(case.residual(T_0, T_0)))

    class Kept(base.Constraint):  # pyright: ignore
        def __init__(self) -> None:
            super().__init__(n, rows, case.tolerance)

        def function(self, x: Floats, out: Floats) -> None:
            out[:] = case.residual(robot.forward_kinematics(np.array(x)), T_0)

        def jacobian(self, x: Floats, out: Floats) -> None:
            at = np.array(x)
            out[:] = case.rate(robot.jacobian_space(at), robot.forward_kinematics(at), T_0)

    ambient, bounds = base.RealVectorStateSpace(n), base.RealVectorBounds(n)
    for k in range(n):
        bounds.setLow(k, float(robot.limits.lower[k]))
        bounds.setHigh(k, float(robot.limits.upper[k]))
    ambient.setBounds(bounds)
    kept = Kept()
    space = base.ProjectedStateSpace(ambient, kept)
    information = base.ConstrainedSpaceInformation(space)
    setup = geometric.SimpleSetup(information)
    setup.setStateValidityChecker(lambda state: bool(checker.free([state[k] for k in range(n)])))
    ends = [space.allocState(), space.allocState()]
    for state, values in zip(ends, (q, goal), strict=True):
        state.copy(values.tolist())
    setup.setStartAndGoalStates(*ends)
    setup.setPlanner(geometric.RRTConnect(information))
    solved = setup.solve(seconds)
    if "Exact" not in str(solved):
        return None
    path = setup.getSolutionPath()
    path.interpolate()
    return np.array([[path.getState(i)[k] for k in range(n)] for i in range(path.getStateCount())])


def main() -> None:
    """Print a line for each case."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--count", type=int, default=20)
    parser.add_argument("--seconds", type=float, default=10.0, help="after which each side gives up")
    given = parser.parse_args()
    warnings.simplefilter("ignore")
    try:
        import ompl  # pyright: ignore  # noqa: F401

        peer = True
    except ImportError:
        peer = False
    checker = Checker("panda", SCENE, radius=0.05, self_collision=False)
    for case in CASES:
        mf.plan(checker, None, *next(problems(checker, case, 1)), constraints=case.keep)
        rows: dict[str, list[tuple[float, float, bool]]] = {"ours": [], "OMPL": []}
        asked = 0
        for q, goal in problems(checker, case, given.count):
            asked += 1
            begun = perf_counter()
            plan = mf.plan(checker, None, q, goal, constraints=case.keep, seconds=given.seconds)
            if plan:
                rows["ours"].append((perf_counter() - begun, *examined(checker, case, plan.path)))
            if peer:
                begun = perf_counter()
                path = theirs(checker, case, q, goal, given.seconds)
                if path is not None:
                    rows["OMPL"].append((perf_counter() - begun, *examined(checker, case, path)))
        for name, found in rows.items():
            if found:
                seconds, off, free = (np.array(each) for each in zip(*found, strict=True))
                print(
                    f"{case.name:11} {name:5} {len(found)} of {asked} found, median {1e3 * np.median(seconds):8.2f} ms"
                    f", 95 % {1e3 * np.quantile(seconds, 0.95):9.1f} ms; largest deviation {off.max():7.3f} of what is "
                    f"allowed, {int((off > 1.0).sum())} paths beyond it, {int((~free).sum())} in collision"
                )
        if rows["OMPL"] and rows["ours"]:
            ratio = np.median([row[0] for row in rows["OMPL"]]) / np.median([row[0] for row in rows["ours"]])
            print(f"{case.name:11} ratio of medians {ratio:.1f}", flush=True)


if __name__ == "__main__":
    main()
