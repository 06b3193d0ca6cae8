"""Answers of inverse kinematics and of motions, each with what it lacks, recomputed from the numbers it gives."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

import numpy as np

import mafsil as mf
from mafsil import ik, performance, trajectory
from mafsil.geometry import pose, rotation
from mafsil.trajectory import MotionLimits
from tests.reliability.arm_families import FAMILIES

Claims = Iterator[tuple[bool, float]]
"""Whether an answer, or a row of it, is true, and what it lacks in units of what its documentation allows."""
ROUNDING = 1e-12


@cache
def _arm(family: str, length: float) -> mf.Robot:
    chain = FAMILIES[family](np.random.default_rng(7), False)
    screws = chain.screws * np.repeat([1.0, length], 3)
    home = chain.home.copy()
    home[:3, 3] *= length
    return mf.Robot.from_screws(screws, home)


def sized_arm(rng: np.random.Generator, length: float) -> mf.Robot:
    """One of three arms, so that few are compiled: in closed form with and without a wrist, and of three joints."""
    return _arm(str(rng.choice(["puma", "ur", "planar"])), length)


def missed(robot: mf.Robot, q: np.ndarray, T: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Angle and distance by which forward kinematics misses poses."""
    reached = robot.forward_kinematics(q)
    turn = rotation.log(np.swapaxes(reached[..., :3, :3], -1, -2) @ T[..., :3, :3])
    return np.linalg.norm(turn, axis=-1), np.linalg.norm(reached[..., :3, 3] - T[..., :3, 3], axis=-1)


def inverse_kinematics(rng: np.random.Generator, length: float) -> Claims:
    robot = sized_arm(rng, length)
    if rng.random() < 0.7:
        T = robot.forward_kinematics(rng.uniform(-3, 3, robot.n))
    else:
        T = pose.exp(np.concatenate([rng.normal(size=3), length * rng.normal(size=3)]))
    tolerance = 10.0 ** rng.uniform(-10, -4)
    one = ik.solve_ik(robot, T, np.zeros(robot.n), tolerance=tolerance, limits=False, restarts=15)
    angle, distance = missed(robot, one.nearest, T)
    yield bool(one), float(max(angle / (tolerance + ROUNDING), distance / (tolerance + ROUNDING * length)))
    every = mf.inverse_kinematics(robot, T)
    angle, distance = missed(robot, every.q, T) if len(every.q) else (np.zeros(1), np.zeros(1))
    yield bool(every), float(max(angle.max(), distance.max() / length) / 1e-9)
    yield bool(every), 0.0 if len(every.q) else np.inf


def newton(rng: np.random.Generator, length: float) -> Claims:
    robot = sized_arm(rng, length)
    start = rng.uniform(-2, 2, robot.n)
    T = robot.forward_kinematics(start + rng.normal(size=robot.n) * rng.choice([0.01, 0.3, 3.0]))
    turn, way = 10.0 ** rng.uniform(-9, -3), length * 10.0 ** rng.uniform(-9, -3)
    found = ik.newton_ik(robot, T, start, rotation_tolerance=turn, position_tolerance=way, max_steps=20)
    angle, distance = missed(robot, found.q, T)
    yield bool(found), float(max(angle / (turn + ROUNDING), distance / (way + ROUNDING * length)))


def root(rng: np.random.Generator, length: float) -> Claims:
    A, b = rng.normal(size=(3, 3)), length * rng.normal(size=3)
    tolerance = length * 10.0 ** rng.uniform(-10, -3)

    def f(x: np.ndarray) -> np.ndarray:
        return length * (A @ np.sin(x / length)) + x - b

    variant = str(rng.choice(["newton", "damped", "broyden", "levenberg"]))
    found = ik.find_root(f, length * 0.3 * rng.normal(size=3), variant=variant, tolerance=tolerance)  # type: ignore[arg-type]
    yield bool(found), float(np.linalg.norm(f(found.x)) / tolerance)


def rates(rng: np.random.Generator, length: float) -> Claims:
    robot = sized_arm(rng, length)
    q = rng.uniform(-3, 3, (5, robot.n)) * rng.choice([0.0, 1.0], p=[0.2, 0.8])
    V = rng.normal(size=(5, 6)) * np.repeat([1.0, length], 3)
    J = robot.jacobian_body(q)
    units = np.repeat([1.0, length], 3)
    exact = ik.joint_rates(robot, q, V)
    bounded = ik.bounded_rates(robot, q, V, limits=np.full(robot.n, 2.0))
    for found, scale in ((exact, np.ones(5)), (bounded, bounded.scale)):
        for k in range(5):
            lacks = (J[k] @ found.qd[k] - scale[k] * V[k]) / units
            size = 1.0 + np.abs(J[k] / units[:, None]).max() * np.abs(found.qd[k]).max()
            yield bool(found), float(np.abs(lacks).max() / (1e-8 * size))
    yield bool(bounded), float(np.abs(bounded.qd).max() / (2.0 + ROUNDING))


def tracking(rng: np.random.Generator, length: float) -> Claims:
    robot = sized_arm(rng, length)
    q = rng.uniform(-1, 1, robot.n) + np.linspace(0, rng.choice([0.2, 1.5]), 9)[:, None] * rng.normal(size=robot.n)
    T = robot.forward_kinematics(q)
    found = ik.track(robot, T, q[0], tolerance=1e-9)
    angle, distance = missed(robot, np.nan_to_num(found.q), T)
    whole = bool(np.isfinite(found.q).all())
    lacks = max(angle.max() / 1e-9, distance.max() / (1e-9 + ROUNDING * length)) if whole else np.inf
    yield bool(found), float(lacks)
    if found:
        yield True, 0.0 if np.abs(np.diff(found.q, axis=0)).max() < 4.0 else np.inf


def tip_wrenches(rng: np.random.Generator, length: float) -> Claims:
    robot = sized_arm(rng, length)
    q, tau = rng.uniform(-3, 3, robot.n), rng.normal(size=robot.n) * length
    found = performance.tip_wrench(robot, q, tau)
    T, J = robot.forward_kinematics(q), robot.jacobian_body(q)
    R = T[:3, :3]
    at_tip = np.concatenate([R.T @ found.F[:3], R.T @ found.F[3:]])
    size = np.abs(J.T * at_tip).sum(axis=1).max() + np.abs(tau).max()
    yield bool(found), float(np.abs(J.T @ at_tip - tau).max() / (1e-6 * size))


def via_points(rng: np.random.Generator, length: float) -> Claims:
    robot = sized_arm(rng, length)
    q = rng.uniform(-2, 2, (4, robot.n))
    linear = length * rng.normal(size=(4, 3))
    found = trajectory.via_rates(robot, q, linear=linear)
    T, J = robot.forward_kinematics(q), robot.jacobian_body(q)
    made = np.einsum("kij,kjn,kn->ki", T[:, :3, :3], J[:, 3:], found.qd)
    yield bool(found), float(np.abs(made - linear).max() / (1e-8 * length * (1 + np.abs(found.qd).max())))


def lines(rng: np.random.Generator, length: float) -> Claims:
    robot = sized_arm(rng, length)
    start = rng.uniform(-1.5, 1.5, robot.n)
    T = robot.forward_kinematics(start)
    goal = T @ pose.exp(np.concatenate([0.3 * rng.normal(size=3), 0.2 * length * rng.normal(size=3)]))
    found = trajectory.cartesian_line(robot, start, goal, duration=float(10.0 ** rng.uniform(-2, 2)))
    if not found:
        yield False, 0.0
        return
    motion = found.value
    assert motion is not None
    q = motion.at(np.linspace(0.0, motion.duration, 30)).u
    along, way = robot.forward_kinematics(q)[:, :3, 3] - T[:3, 3], goal[:3, 3] - T[:3, 3]
    direction = way / np.linalg.norm(way)
    aside = along - np.outer(along @ direction, direction)
    angle, distance = missed(robot, q[-1], goal)
    allowed = 1e-6 * max(1.0, length)
    yield True, float(max(np.abs(aside).max(), distance) / allowed)
    yield True, float(angle / 1e-6)


def route(rng: np.random.Generator, length: float) -> Claims:
    robot = sized_arm(rng, length)
    start = rng.uniform(-1.5, 1.5, robot.n)
    T = robot.forward_kinematics(start)
    goal = T @ pose.exp(np.concatenate([0.3 * rng.normal(size=3), 0.2 * length * rng.normal(size=3)]))
    path = trajectory.line_path(T, goal)
    found = trajectory.joint_motion(robot, path, start, 2.0, rate=100.0)
    if found:
        angle, distance = missed(robot, found.q[-1], goal)
        yield True, float(max(angle / 1e-8, distance / (1e-8 * length)))
    yield bool(found), 0.0


def blends(rng: np.random.Generator, length: float) -> Claims:
    points = length * rng.normal(size=(5, 2))
    duration = 10.0 ** rng.uniform(-3, 3)
    peak = length / duration**2 * 10.0 ** rng.uniform(0, 2)
    found = trajectory.linear_blends(points, duration, acceleration=peak)
    if not found:
        yield False, 0.0
        return
    motion = found.trajectory
    assert motion is not None
    t = np.linspace(0.0, motion.duration, 400)
    seen = motion.at(t)
    ends = np.abs(seen.u[[0, -1]] - points[[0, -1]]).max() / (1e-9 * length)
    yield True, float(max(ends, np.abs(seen.a).max() / (peak * (1 + 1e-9))))
    yield True, 0.0 if found.straight.min() >= 0 else np.inf


def jerky(rng: np.random.Generator, length: float) -> Claims:
    """States to states at all scales of length, time and cycle; what `R11` draws at one scale."""
    time = 10.0 ** rng.uniform(-6, 6)
    v, a, j = (length / time**k * 10.0 ** rng.uniform(-1, 1) for k in (1, 2, 3))
    limits = MotionLimits.of(2, velocity=v, acceleration=a, jerk=j)
    start, goal = length * rng.normal(size=(2, 2))
    first, last = rng.uniform(-0.7, 0.7, (2, 2)) * v
    cycle = float(rng.choice([0.0, 1e-3, 1.0])) * time
    found = trajectory.jerk_limited(start, goal, limits, start_velocity=first, goal_velocity=last, cycle=cycle)
    if not found:
        yield False, 0.0
        return
    seen = found.at(np.linspace(0.0, float(found.duration), 500))
    ends = np.abs(seen.u[[0, -1]] - [start, goal]).max() / (1e-8 * length)
    speeds = np.abs(seen.v[[0, -1]] - [first, last]).max() / (1e-8 * v)
    kept = max(np.abs(seen.v).max() / (v * (1 + 1e-8)), np.abs(seen.a).max() / (a * (1 + 1e-8)))
    yield True, float(max(ends, speeds, kept if kept > 1 else 0.0))
    yield True, 0.0 if found.duration >= 0 else np.inf
    if cycle:
        yield True, float(abs(found.duration / cycle - np.rint(found.duration / cycle)) / 1e-6)


def timed(rng: np.random.Generator, length: float) -> Claims:
    time = 10.0 ** rng.uniform(-4, 4)
    limits = MotionLimits.of(2, velocity=length / time, acceleration=length / time**2 * 10.0 ** rng.uniform(-1, 1))
    points = length * rng.normal(size=(4, 2))
    found = trajectory.time_optimal(trajectory.JointPath.through(points), limits)
    if not found:
        yield False, 0.0
        return
    motion = found.trajectory
    seen = motion.at(np.linspace(0.0, float(found.duration), 600))
    ends = np.abs(seen.u[[0, -1]] - points[[0, -1]]).max() / (1e-8 * length)
    over = (np.abs(seen.v) * time / length).max()
    yield True, float(max(ends, over if over > 1 + 1e-6 else 0.0))


ROWS = {
    "IKResult, AnalyticIK": inverse_kinematics,
    "NewtonRecord": newton,
    "RootRecord": root,
    "Rates, BoundedRates": rates,
    "Track": tracking,
    "TipWrench": tip_wrenches,
    "ViaRates": via_points,
    "PathMotion": lines,
    "JointMotion": route,
    "BlendPlan": blends,
    "JerkLimitedMotion": jerky,
    "TimeOptimal": timed,
}
