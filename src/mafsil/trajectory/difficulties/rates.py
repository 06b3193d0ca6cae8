"""Joint rates along a path: how singular the arm is on the way, and where the tip goes if rates cannot keep up."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.performance import generic_rank, singular_values
from mafsil.performance.singularities.axis_cases import SingularityCause
from mafsil.performance.singularities.singular_configuration import default_task, singularity
from mafsil.robot import Robot
from mafsil.trajectory.paths import TipPath
from mafsil.trajectory.paths.path_task import PathTask

STEPS = 2000
"""Steps in time of an arm whose rates stay within their limits."""

PLACES = 2001
"""Places of the path to which distances are measured."""
AT_ONCE = 256
"""Points that are compared with all places of a way at once, in 12 MB."""

SLACK = 1.01
"""Factor on the conditioning of a configuration at which it counts as singular, to ask for the cause."""


def judged_task(robot: Robot, task: PathTask) -> str | None:
    """The rows by which performance judges a task; None where a path's task is none of them.

    Args:
        robot: any arm.
        task: of a path.
    """
    if task == "axis":
        return None
    own = default_task(robot)
    flat = {"position": ("planar_position",), "pose": ("planar", "schoenflies")}[task]
    return own if own in flat else task


def redundant(robot: Robot, task: PathTask) -> bool:
    """Whether the arm has more joints than what counts needs.

    Args:
        robot: any arm.
        task: of a path.
    """
    rows = judged_task(robot, task)
    return robot.n > (5 if rows is None else generic_rank(robot, task=rows))


def conditioning(robot: Robot, q: JointVector, task: PathTask) -> Floats:
    """(*batch,) smallest over largest singular value of what counts, without units; NaN for the task `axis`.

    Args:
        robot: any arm.
        q: (*batch, n) configurations.
        task: what counts.
    """
    rows = judged_task(robot, task)
    if rows is None:
        return np.full(q.shape[:-1], np.nan)
    values, rank = singular_values(robot, q, task=rows), generic_rank(robot, task=rows)
    return values[..., rank - 1] / values[..., 0]


def singular_causes(robot: Robot, q: JointVector, task: PathTask) -> tuple[SingularityCause, ...]:
    """Which axes become dependent near a configuration, and their geometry.

    Args:
        robot: any arm.
        q: (n,) nearly singular.
        task: what counts.
    """
    rows, near = judged_task(robot, task), float(conditioning(robot, q, task))
    if rows is None or not near < 1.0 / SLACK:
        return ()
    return singularity(robot, q, task=rows, tolerance=max(SLACK * near, 1e-9)).causes


def distance_from_path(robot: Robot, path: TipPath, q: JointVector) -> Floats:
    """(k,) distances of the tip from the way of the path's origin [m].

    Args:
        robot: whose tip.
        path: of the tip.
        q: (k, n) configurations.
    """
    tip = robot.forward_kinematics(q)[:, :3, 3]
    way = path.poses(np.linspace(0.0, 1.0, PLACES))[:, :3, 3]
    near = np.concatenate(
        [
            ((way - some[:, None]) ** 2).sum(axis=-1).argmin(axis=1)
            for some in np.array_split(tip, len(tip) // AT_ONCE + 1)
        ]
    )
    sides = [_to_segments(tip, way[np.maximum(near - 1, 0)], way[near])]
    sides.append(_to_segments(tip, way[near], way[np.minimum(near + 1, len(way) - 1)]))
    return np.minimum(*sides)


def _to_segments(points: Floats, a: Floats, b: Floats) -> Floats:
    """(k,) distances of points from the segments from a to b, (k, 3) each."""
    along, since = b - a, points - a
    share = (since * along).sum(axis=1) / np.maximum((along * along).sum(axis=1), LEAST_DIVISOR)
    return np.linalg.norm(since - np.clip(share, 0.0, 1.0)[:, None] * along, axis=1)


def at_limited_rates(robot: Robot, s: Floats, q: JointVector, rates: Floats, duration: float) -> Floats:
    """(steps, n) configurations of an arm that goes after a joint path at constant ds/dt, no joint beyond its rate.

    Args:
        robot: gives the limits of velocity.
        s: (k,) increasing places.
        q, rates: (k, n) coordinates there, and their derivatives by s.
        duration: of the whole path, s from 0 to 1 [s].
    """
    places: Floats = np.linspace(float(s[0]), float(s[-1]), STEPS + 1)
    aim = _hermite(s, q, rates, places)
    most = robot.limits.velocity * duration * float(places[1] - places[0])
    found = aim.copy()
    for k in range(1, len(places)):
        found[k] = found[k - 1] + np.clip(aim[k] - found[k - 1], -most, most)
    return found


def _hermite(s: Floats, q: JointVector, rates: Floats, at: Floats) -> Floats:
    """Cubics between samples."""
    i = np.clip(np.searchsorted(s, at, side="right") - 1, 0, len(s) - 2)
    h = s[i + 1] - s[i]
    x = ((at - s[i]) / h)[:, None]
    h = h[:, None]
    return (
        (1 + 2 * x) * (1 - x) ** 2 * q[i]
        + x**2 * (3 - 2 * x) * q[i + 1]
        + h * x * (1 - x) * ((1 - x) * rates[i] - x * rates[i + 1])
    )
