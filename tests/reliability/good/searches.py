"""Answers of searches: ways, waits, poses that are singular or round; each with what it lacks, recomputed."""

from __future__ import annotations

from functools import cache
from itertools import pairwise

import numpy as np

import mafsil as mf
from mafsil import parallel, performance, planning
from mafsil.model import JointKind
from mafsil.parallel import ClosedChain
from tests.parallel.closed_chains import random_chain
from tests.reliability.good.arms import Claims, sized_arm
from tests.reliability.good.mechanisms import near_home, platform


def _beside(points: np.ndarray, centres: np.ndarray, half: np.ndarray) -> np.ndarray:
    """(k,) distance of points from the nearest box, negative inside."""
    return (np.abs(points[:, None] - centres) - half).max(axis=-1).min(axis=-1)


def ways(rng: np.random.Generator, length: float) -> Claims:
    centres, half = length * rng.uniform(0.1, 0.9, (5, 2)), length * rng.uniform(0.02, 0.15, (5, 2))
    step = 0.01 * length
    lower, upper = np.zeros(2), np.full(2, length)
    problem = planning.Problem(lower, upper, free=lambda q: _beside(q, centres, half) > 0, resolution=step)
    ends = length * rng.uniform(0, 1, (2, 2))
    planner = str(rng.choice(list(planning.PLANNERS)))
    found = planning.find_path(problem, *ends, planner=planner, seconds=0.3)
    if found:
        path = np.asarray(found.path)
        fine = np.concatenate([np.linspace(a, b, 200) for a, b in pairwise(path)])
        yield True, float(max(0.0, -_beside(fine, centres, half).min()) / step)
        yield True, float(np.abs(path[[0, -1]] - ends).max() / (1e-9 * length))
        yield True, float(max((lower - fine).max(), (fine - upper).max()) / (1e-9 * length))
    yield bool(found), 0.0


def round_corners(rng: np.random.Generator, length: float) -> Claims:
    centres = length * np.array([[0.25, 0.3], [0.6, 0.4], [0.45, 0.75]]) + 0.05 * length * rng.normal(size=(3, 2))
    half = length * rng.uniform(0.03, 0.08, (3, 2))
    square = np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
    world = planning.PolygonWorld(
        np.zeros(2), np.full(2, length), tuple(c + square * h for c, h in zip(centres, half, strict=True))
    )
    ends = length * np.array([[0.02, 0.05], [0.97, 0.95]])
    found = planning.visibility_path(world, *ends)
    if found:
        path = np.asarray(found.path)
        fine = np.concatenate([np.linspace(a, b, 500) for a, b in pairwise(path)])
        yield True, float(max(0.0, -_beside(fine, centres, half).min()) / (1e-8 * length))
        yield True, float(np.abs(path[[0, -1]] - ends).max() / (1e-9 * length))
    yield bool(found), 0.0


def waits(rng: np.random.Generator, length: float) -> Claims:
    durations = length * rng.uniform(0.5, 2.0, 2)
    centre, radius = rng.uniform(0.3, 0.7, 2), rng.uniform(0.05, 0.3)

    def meet(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return (a - centre[0]) ** 2 + (b - centre[1]) ** 2 < radius**2

    found = planning.coordinate_robots(meet, (durations[0], durations[1]), cells=100)
    if found:
        shares = np.asarray(found.shares)
        depth = radius - np.hypot(*(shares - centre).T)
        yield True, float(max(0.0, depth.max()) / 1e-9)
        faster = np.diff(shares, axis=0) * durations / np.diff(found.t)[:, None]
        yield True, float(max(faster.max() / (1 + 1e-9), 0.0 if faster.min() >= -1e-12 else np.inf))
        yield True, float(np.abs(shares[[0, -1]] - [[0, 0], [1, 1]]).max() / 1e-12)
    yield bool(found), 0.0


def _det(robot: parallel.StewartPlatform, T: np.ndarray, length: float) -> float:
    """Determinant of the leg lines' coordinates, moments in units of the size."""
    ends = robot.platform @ T[:3, :3].T + T[:3, 3]
    u = (ends - robot.base) / np.linalg.norm(ends - robot.base, axis=1)[:, None]
    return float(np.linalg.det(np.hstack([np.cross(robot.base, u) / length, u])))


def singular_poses(rng: np.random.Generator, length: float) -> Claims:
    robot = platform(length)
    T_0, T_1 = near_home(rng, length), near_home(rng, length)
    nearest = parallel.nearest_singularity(robot, T_0, starts=16)
    if nearest and nearest.x is not None:
        usual = max(abs(_det(robot, T_0, length)), 1e-3)
        yield True, abs(_det(robot, np.asarray(nearest.x), length)) / (1e-6 * usual)
    yield bool(nearest), 0.0
    way = parallel.mode_path(robot, T_0, T_1, tries=200)
    signs = [np.sign(_det(robot, T, length)) for T in way.x]
    yield bool(way), 0.0 if len(signs) and np.ptp(signs) == 0 else np.inf


@cache
def _closed(seed: int) -> tuple[ClosedChain, np.ndarray]:
    tree, q = random_chain(np.random.default_rng(seed), JointKind.REVOLUTE)
    return ClosedChain(mf.Robot(tree)), q


def closed_poses(rng: np.random.Generator, length: float) -> Claims:
    chain, q = _closed(int(rng.integers(2)))
    near = chain.close_loops(q + 0.3 * rng.normal(size=len(q)))
    T = chain.robot.forward_kinematics(near.q)
    if rng.random() < 0.3:
        T = T @ mf.geometry.pose.exp(rng.normal(size=6))
    found = parallel.closed_inverse_kinematics(chain, T, starts=8)
    for q in found.q:
        reached = chain.robot.forward_kinematics(q)
        yield bool(found), float(max(np.abs(reached - T).max() / 1e-8, np.abs(chain.error(q)).max() / 1e-8))
    yield bool(found), 0.0


def round_ellipsoids(rng: np.random.Generator, length: float) -> Claims:
    robot = sized_arm(rng, length)
    found = performance.isotropic_configurations(robot, starts=16, iterations=40, seed=int(rng.integers(100)))
    for q in np.atleast_2d(found.q) if found else []:
        J = robot.jacobian_body(q)[3:]
        yield True, float((np.linalg.cond(J) - 1.0) / 1e-4)
    yield bool(found), 0.0


ROWS = {
    "Plan": ways,
    "Plan of polygons": round_corners,
    "Coordination": waits,
    "NearestSingularity, ModePath": singular_poses,
    "ClosedPoses": closed_poses,
    "IsotropySearch": round_ellipsoids,
}
