"""Numerical inverse kinematics for whole batches: damped least squares in the body frame, bounded, with restarts."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix, gate, require_finite, require_kind
from mafsil.errors import InputError
from mafsil.geometry import pose
from mafsil.ik.problem import ORTHOGONALITY, PoseProblem, clean_poses, reach_bound
from mafsil.ik.result import STATUSES, IKResult, IKStatus
from mafsil.ik.search import Search
from mafsil.ik.seeds import SeedPool
from mafsil.robot import Robot

FREE_RESTARTS = 7
"""Restarts for poses proven out of reach, and for asking whether the limits are what forbids a pose."""


def solve_ik(
    robot: Robot,
    T_sd: ArrayLike,
    seed: ArrayLike | None = None,
    *,
    frame: str | None = None,
    tolerance: float = 1e-10,
    restarts: int = 255,
    limits: bool = True,
    rng: int = 0,
) -> IKResult:
    """Joint vectors that bring a frame to wanted poses.

    dq = J' (J J' + lambda I)^-1 e,  e = log(T_sf(q)^-1 T_sd),  lambda ~ |e|^2

    Joints at a bound that the step would push further are held. Poses that resist are tried again from sampled starts,
    twice as many each time. Every answer is checked by forward kinematics. The result for a pose does not depend on the
    other poses of the batch.

    Args:
        robot: whose tip or `frame` is to be moved.
        T_sd: (*batch, 4, 4) wanted poses in {s}; rotations printed to six digits or more are repaired.
        seed: (*batch, n) where to start first [rad | m]; sampled starts if None.
        frame: name of a link; the tip if None.
        tolerance: largest position error [m] and rotation error [rad].
        restarts: how many more starts are tried after the first.
        limits: whether the joints' position limits hold.
        rng: seed of the sampled starts; equal seeds give equal results.

    Returns:
        Solutions with a status for each pose. Rows of a batch that are no poses are marked and hold NaN.

    Raises:
        InputError: a wrong shape, an unknown frame, a seed that is not finite, a single pose that is no pose.

    Reference: Chan and Lawrence, General inverse kinematics with the error damped pseudoinverse, ICRA 1988.
    """
    require_kind("robot", robot, "Robot", "mechanism", "forward_kinematics")
    wanted = gate("T_sd", T_sd, (4, 4))
    batch = wanted.shape[:-2]
    target, valid = clean_poses(wanted.reshape(-1, 4, 4))
    if not batch and not valid[0]:
        raise InputError("ik.no_pose", name="T_sd", limit=ORTHOGONALITY)
    _require_settings(tolerance, restarts)
    problem = _problem(robot, frame, limits)
    first = _first_starts(robot, seed, batch)
    pool = SeedPool(problem, rng)
    centre, radius = reach_bound(robot.mechanism, frame)
    distance = np.linalg.norm(target[:, :3, 3] - centre, axis=1)
    beyond = distance > radius * (1.0 + 1e-12)
    search = Search(problem, target, pool, first, tolerance)
    search.run(np.flatnonzero(valid & ~beyond), restarts)
    search.run(np.flatnonzero(valid & beyond), min(restarts, FREE_RESTARTS))
    q = problem.wound(search.q, np.zeros(robot.n) if first is None else first)
    return _judged(problem, search, q, target, valid, beyond, (distance, radius), batch)


def _problem(robot: Robot, frame: str | None, limits: bool) -> PoseProblem:
    if frame is not None:
        robot.mechanism.link(frame)
    free = np.full(robot.n, np.inf)
    lower, upper = (robot.limits.lower, robot.limits.upper) if limits else (-free, free)
    _, radius = reach_bound(robot.mechanism, frame)
    length = radius if np.isfinite(radius) and radius > 0.0 else 1.0
    return PoseProblem(robot, frame, lower, upper, length)


def _require_settings(tolerance: float, restarts: int) -> None:
    if not (np.isfinite(tolerance) and tolerance > 0.0):
        raise InputError("input.positive", name="tolerance", value=tolerance)
    if restarts < 0:
        raise InputError("input.range", name="restarts", value=restarts, low=0, high=np.inf)


def _first_starts(robot: Robot, seed: ArrayLike | None, batch: tuple[int, ...]) -> JointVector | None:
    """(k, n) the user's starts, or None."""
    if seed is None:
        return None
    given = require_finite("seed", gate("seed", seed, (robot.n,)))
    try:
        return np.broadcast_to(given, (*batch, robot.n)).reshape(-1, robot.n)
    except ValueError:
        raise InputError("input.shape", name="seed", expected=(*batch, robot.n), got=given.shape, hint="") from None


def _judged(
    problem: PoseProblem,
    search: Search,
    q: JointVector,
    target: PoseMatrix,
    valid: NDArray[np.bool_],
    beyond: NDArray[np.bool_],
    bound: tuple[Floats, float],
    batch: tuple[int, ...],
) -> IKResult:
    """The verdict of every row, from its forward kinematics alone."""
    distance, radius = bound
    T = np.full_like(target, np.nan)
    T[valid] = problem.poses(q[valid])
    twist = np.full((len(q), 6), np.nan)
    twist[valid] = pose.error(T[valid], target[valid])
    rotation = np.linalg.norm(twist[:, :3], axis=1)
    position = np.linalg.norm(T[:, :3, 3] - target[:, :3, 3], axis=1)
    reached = (rotation <= search.tolerance) & (position <= search.tolerance)
    within = ((q >= problem.lower) & (q <= problem.upper)).all(axis=1)
    codes = np.full(len(q), STATUSES.index(IKStatus.BUDGET_SPENT), dtype=np.int8)
    codes[beyond] = STATUSES.index(IKStatus.OUT_OF_REACH)
    codes[reached & within] = STATUSES.index(IKStatus.SOLVED)
    codes[~valid] = STATUSES.index(IKStatus.NOT_A_POSE)
    worst = _exceeded_without_limits(problem, search, target, codes)
    codes[worst != ""] = STATUSES.index(IKStatus.BEYOND_LIMITS)
    return IKResult(
        q=q.reshape(*batch, problem.robot.n),
        codes=codes.reshape(batch),
        T_reached=T.reshape(*batch, 4, 4),
        position_error=position.reshape(batch),
        rotation_error=rotation.reshape(batch),
        iterations=search.iterations.reshape(batch),
        attempts=search.attempts.reshape(batch),
        reach=np.full(batch, radius),
        distance=distance.reshape(batch),
        worst_joint=worst.reshape(batch),
    )


def _exceeded_without_limits(
    problem: PoseProblem, search: Search, target: PoseMatrix, codes: NDArray[np.int8]
) -> NDArray[np.str_]:
    """For poses that were not found, the joint that a solution without limits exceeds most; empty if there is none."""
    names = np.array(problem.robot.joint_names)
    worst = np.full(len(target), "", dtype=names.dtype)
    open_rows = np.flatnonzero(codes == STATUSES.index(IKStatus.BUDGET_SPENT))
    if not len(open_rows) or not problem.bounded:
        return worst
    free = problem.unbounded()
    again = Search(free, target[open_rows], SeedPool(free, search.pool.rng), None, search.tolerance)
    again.run(np.arange(len(open_rows)), FREE_RESTARTS)
    q = free.wound(again.q, problem.middle)
    excess = np.maximum(problem.lower - q, q - problem.upper)
    worst[open_rows[again.solved]] = names[excess.argmax(axis=1)][again.solved]
    return worst
