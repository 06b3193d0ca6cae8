"""A configuration to begin with, or to be drawn in."""

from __future__ import annotations

from collections.abc import Iterable
from functools import cache
from itertools import product
from math import prod
from typing import TYPE_CHECKING

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.code_store import digest_of, kept_array
from mafsil.errors import MafsilError, ModelError
from mafsil.job.tolerances import LEAST_DEXTERITY, MOVES_TIP
from mafsil.kernels.identity import code_hash
from mafsil.lazy_module import lazily
from mafsil.model import JointKind, JointLimits, Mechanism
from mafsil.model.appearance import reach
from mafsil.model.fingerprint import fingerprint
from mafsil.robot import Robot

if TYPE_CHECKING:
    import mafsil.collision as collision
    import mafsil.parallel as parallel
else:
    collision = lazily("mafsil.collision")
    parallel = lazily("mafsil.parallel")

MARGIN = 0.15
"""Distance to each bound, as share of the range."""
REGULAR = 0.03
"""Smallest singular value of the Jacobian from which on a start is regular."""
BENDS = (0.2, 0.4, 0.8)
"""How far a start that is singular is bent [rad | m]."""

ROUND_ANGLES = np.deg2rad([0.0, -45, 45, -90, 90, -135, 135])
SHARES = (0.5, 0.3, 0.7)
"""Coordinates that home configurations are made of: angles [rad], and shares of the range of a prismatic joint."""
MOST_CANDIDATES = 12_000
"""That are compared; of more combinations some are drawn."""
KEPT = 200
"""The best of them, of which every joint is turned to all of its coordinates, twice around."""
FORWARD, HIGH = (0.28, 0.55), (0.12, 0.45)
"""Where the tip of a home configuration is in front of the base and above it, as shares of the reach."""
CLEAR = 0.01
"""Least gap between two parts of the arm in a home configuration, where there are such [m]."""


def resting_place(limits: JointLimits) -> JointVector:
    """(n,) zero, moved into the middle 70 % of each range where it has bounds [rad | m]."""
    return _inside(limits, np.zeros(len(limits.lower)))


def resting_configuration(mechanism: Mechanism) -> JointVector:
    """(n,) the resting place; of a robot with loops the nearest that was found with all loops closed.

    Args:
        mechanism: any.

    Raises:
        ModelError: none was found.
    """
    q = resting_place(mechanism.limits)
    if not mechanism.loops:
        return q
    found = parallel.ClosedChain(mechanism).close_loops(q)
    if not found:
        raise ModelError("robot.loops_never", robot=mechanism.name, why=found.explain())
    return np.asarray(found.q)


def starting_place(robot: Robot) -> JointVector:
    """(n,) the resting place; the most regular of some bent configurations around it where the arm is singular there.

    The configurations bend neighbouring joints to one or to alternating sides, in the middle 70 % of their ranges; of
    equally good ones the first, which is the nearest.
    """
    q = resting_place(robot.limits)
    if robot.n == 0 or _margin(robot, q) >= REGULAR:
        return q
    k = np.arange(robot.n)
    patterns = [(-1.0) ** (k // period + shift) for period in (1, 2, 3) for shift in (0, 1)]
    bent = [_inside(robot.limits, q + bend * pattern) for bend in BENDS for pattern in patterns]
    return max([q, *bent], key=lambda configuration: round(_margin(robot, configuration), 9))


def home_configuration(robot: Robot) -> JointVector:
    """(n,) round coordinates in which the arm is dextrous, free of itself, and good to look at [rad | m].

    The tip is in front of the base and neither low nor high, a tool with six joints points down, the joints are away
    from their limits. Joints that do not move the tip rest; an arm without joints that do rests altogether. What is
    chosen from is kept on disk: thousands of singular values for each robot.
    """
    rest = starting_place(robot)
    if robot.n == 0:
        return rest
    words = "home", _grading(), fingerprint(robot.mechanism), robot.limits.lower, robot.limits.upper, rest
    best = kept_array(digest_of(*words), lambda: _home_candidates(robot, rest))
    return next(iter(_free_of_itself(robot, best)), rest)


@cache
def _grading() -> str:
    """The code and the numbers by which homes are graded."""
    functions = _home_candidates, _round_coordinates, _grade, _dexterity, _outside
    numbers = ROUND_ANGLES, SHARES, MARGIN, FORWARD, HIGH, MOST_CANDIDATES, KEPT, LEAST_DEXTERITY, MOVES_TIP
    return repr([*(code_hash(each.__code__, set()) for each in functions), *numbers])


def _home_candidates(robot: Robot, rest: JointVector) -> Floats:
    """(k, n) configurations of dextrous homes, the best first; the resting place alone where no joint moves the tip."""
    moving = np.flatnonzero(np.abs(robot.jacobian_body(rest + 0.1)).max(axis=0) > MOVES_TIP)
    if not len(moving):
        return rest[None]
    choices = {int(k): _round_coordinates(robot, int(k)) for k in moving}
    configurations = np.tile(rest, (min(prod(map(len, choices.values())), MOST_CANDIDATES), 1))
    if len(configurations) < MOST_CANDIDATES:
        configurations[:, moving] = list(product(*choices.values()))
    else:
        draw = np.random.default_rng(0)
        for k, values in choices.items():
            configurations[:, k] = draw.choice(values, MOST_CANDIDATES)
    for k, values in (*choices.items(), *choices.items()):
        best = configurations[np.argsort(-_grade(robot, configurations), kind="stable")[:KEPT]]
        extra = np.repeat(best, len(values), axis=0)
        extra[:, k] = np.tile(values, len(best))
        configurations = np.unique(np.concatenate([best, extra]), axis=0)
    return configurations[np.argsort(-_grade(robot, configurations), kind="stable")]


def _round_coordinates(robot: Robot, k: int) -> Floats:
    """Coordinates of one joint to choose from, inside its bounds."""
    lower, upper = float(robot.limits.lower[k]), float(robot.limits.upper[k])
    span = upper - lower
    if robot.mechanism.coordinates[k].kind is JointKind.PRISMATIC:
        return lower + np.array(SHARES) * span if np.isfinite(span) else np.zeros(1)
    margin = MARGIN / 3.0 * span if np.isfinite(span) else 0.0
    inside = ROUND_ANGLES[(ROUND_ANGLES >= lower + margin) & (ROUND_ANGLES <= upper - margin)]
    return inside if len(inside) else np.array([(lower + upper) / 2.0])


def _grade(robot: Robot, q: Floats) -> Floats:
    """(k,) how good they are: dexterity first, then where the tip is and points, heights, bounds, small angles."""
    mechanism, limits = robot.mechanism, robot.limits
    size, gravity = reach(mechanism), np.asarray(mechanism.gravity)
    up = -gravity / np.linalg.norm(gravity) if np.any(gravity) else np.array([0.0, 0.0, 1.0])
    poses, T = np.asarray(robot.link_poses(q)), np.asarray(robot.forward_kinematics(q))
    J = np.asarray(robot.jacobian_body(q)) / np.array([1.0] * 3 + [size] * 3)[:, None]
    dexterity = _dexterity(J if robot.n >= 6 else J[:, 3:])
    tip = (T[:, :3, 3] - mechanism.T_sb[:3, 3]) / size
    heights = (poses[:, :, :3, 3] - mechanism.T_sb[:3, 3]) @ up / size
    bounded = np.isfinite(limits.upper - limits.lower)
    room = np.minimum(q - limits.lower, limits.upper - q)[:, bounded] / (limits.upper - limits.lower)[bounded]
    room = room.min(axis=1, initial=MARGIN) / MARGIN
    down = -(T[:, :3, 2] @ up) if robot.n >= 6 else 0.0
    grade: Floats = 2.0 * dexterity / max(float(dexterity.max()), LEAST_DEXTERITY) + 0.7 * room + 0.9 * down
    grade -= 4.0 * (_outside(tip[:, 0], FORWARD) + _outside(tip @ up, HIGH) + np.abs(tip[:, 1] * (1.0 - abs(up[1]))))
    grade += 3.0 * np.minimum(heights.min(axis=1), 0.0)
    grade -= 0.08 * np.abs(q).sum(axis=1)
    return grade.round(9)


def _dexterity(J: Floats) -> Floats:
    """(k,) ratio of the least and the largest singular value of Jacobians; a seventh joint is locked in turn."""
    rows, columns = J.shape[1:]
    if columns > rows == 6:
        return np.mean([_dexterity(np.delete(J, k, axis=2)) for k in range(columns)], axis=0)
    values = np.linalg.svd(J, compute_uv=False)
    rank = max(1, int((values.max(axis=0) > MOVES_TIP).sum()))
    return values[:, rank - 1] / np.maximum(values[:, 0], LEAST_DEXTERITY)


def _outside(values: Floats, band: tuple[float, float]) -> Floats:
    """How far values are outside a band."""
    return np.maximum(np.maximum(band[0] - values, values - band[1]), 0.0)


def _free_of_itself(robot: Robot, configurations: Floats) -> Iterable[JointVector]:
    """Those of some configurations in which no part of the arm is near another; all of them where that is not known."""
    try:
        return configurations[np.asarray(collision.Checker(robot, clearance=CLEAR).free(configurations))]
    except MafsilError:
        return configurations


def _inside(limits: JointLimits, q: JointVector) -> JointVector:
    span = limits.upper - limits.lower
    margin = np.where(np.isfinite(span), MARGIN * span, 0.0)
    return np.clip(q, limits.lower + margin, limits.upper - margin)


def _margin(robot: Robot, q: JointVector) -> float:
    """Smallest singular value of the body Jacobian."""
    return float(np.linalg.svd(robot.jacobian_body(q), compute_uv=False)[-1])
