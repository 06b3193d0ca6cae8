"""Inverse kinematics of mechanisms with loops: configurations that close all loops and bring the tip to a pose.

The equations of the loops and of the tip are solved together, from many starts at once:

1. Starts: the given one; each solution of the tree's own chain to the tip, if there are finitely many, with the other
   joints as given and at random; configurations at random within the limits.
2. Levenberg's method on all rows. If none reaches the pose, once more with the loops weighing more than the task: it
   ends at the nearest that the loops allow.
3. Loops are closed to rounding; what is left of the task is measured.
4. Configurations that differ by less than SAME are one; those within the limits come first, the nearest first of all.

The answer of inverse kinematics of a mechanism with loops.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, JointVector, PoseMatrix, positive, single, whole
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.geometry import Pose, pose
from mafsil.ik import inverse_kinematics
from mafsil.messages.quantities import quantity
from mafsil.model import JointKind
from mafsil.model.exponentials import chain_to_tip
from mafsil.model.loading import RobotLike
from mafsil.parallel.closed_answers import ClosedConfigurations
from mafsil.parallel.closed_chain import ClosedChain
from mafsil.robot import Robot

Task: TypeAlias = Literal["pose", "axis", "position"]
STEPS = 80
ENOUGH = 1e-13
"""Residual, lengths over the size, at which steps end."""
LEAST, MOST = 1e-12, 1e3
"""Of the damping over the mean square of the derivatives: from what float64 can still solve to a standstill."""
LONGEST = 0.5
"""Of one coordinate in a step [rad | sizes]."""
CLOSING = 1e3
"""Weight of the loops against the task: where both cannot be met, loops stay closed."""
SAME = 1e-5
"""Configurations whose coordinates differ by less are one [rad | sizes]."""
UNBOUNDED = np.pi
"""Where a coordinate without limits is started, to both sides of the given one [rad | sizes]."""
SEEDED = 3
"""Starts with the same solution of the chain to the tip."""
FULL = 6
"""Joints of a chain that reaches poses in finitely many ways."""
RANK = 1e-7
"""Singular value over the largest below which a motion is free: SAME squared leaves more of one that is not."""


def closed_inverse_kinematics(
    robot: RobotLike | ClosedChain,
    T: ArrayLike | Pose,
    q_0: ArrayLike | None = None,
    *,
    task: Task = "pose",
    tolerance: float = 1e-9,
    rotation_tolerance: float = 1e-9,
    starts: int = 48,
    seed: int = 0,
) -> ClosedPoses:
    """Configurations of a mechanism with loops whose tip is at a pose, found from many starts.

    Args:
        robot: a ClosedChain, or a robot or file with loops.
        T: (4, 4) pose of the tip in {s}.
        q_0: (n,) where the search begins, to which the answers are near; the middle of the limits if None.
        task: what of the pose counts: all of it, place and z axis, or the place.
        tolerance: distance that may be left [m].
        rotation_tolerance: angle that may be left [rad].
        starts: at random, besides those from the chain to the tip.
        seed: of the starts.

    Returns:
        The configurations, those within the limits first, the nearest to `q_0` first; of none the nearest miss. A
        search: others may exist, and nothing is proved where none was found.

    Raises:
        InputError: no pose, wrong shapes, numbers that are not finite, an unknown task.
        ModelError: a mechanism without loops.
    """
    chain = robot if isinstance(robot, ClosedChain) else ClosedChain(robot)
    if task not in ("pose", "axis", "position"):
        raise InputError("input.choice", name="task", value=task, known="pose, axis, position")
    wanted = pose.check(single("T", T, (4, 4)))
    start = middle(chain) if q_0 is None else np.array(single("q_0", q_0, (chain.n,)))
    count = whole("starts", starts, 0, 100_000)
    limits = positive("tolerance", tolerance), positive("rotation_tolerance", rotation_tolerance)
    # 1.
    rows = search_starts(chain, wanted, start, task, count, whole("seed", seed, 0))
    for weight in (1.0, CLOSING):
        # 2.
        q = _solve(chain, wanted, rows, task, weight)
        # 3.
        closed = chain.close_loops(q, tries=1)
        place, turn = pose_miss(chain, wanted, closed.q, task)
        good = closed.found & (place <= limits[0]) & (turn <= limits[1])
        if good.any():
            break
    # 4.
    found = _distinct(chain, _wind(chain, closed.q[good], start), start)
    within = _within(chain, found)
    order = np.argsort(~within, kind="stable")
    open_ = np.where(closed.found, place / chain.size + turn, np.inf)
    best = int(open_.argmin())
    return ClosedPoses(
        found[order], within[order], _freedom(chain, found[order], task), len(rows), closed.q[best],
        float(place[best]), float(turn[best]), float(closed.error[best]),
    )  # fmt: skip


def closed_pose_near(
    chain: ClosedChain, T: PoseMatrix, q: JointVector, task: Task, *, nearest: bool = False
) -> ClosedConfigurations:
    """The configuration with closed loops near a given one whose tip is at a pose, as a motion passes it.

    Args:
        chain: a mechanism with loops.
        T: (4, 4) pose of the tip in {s}.
        q: (n,) where the search begins, the only one.
        task: what of the pose counts.
        nearest: where loops and task cannot be met together, the loops count more.
    """
    found = _solve(chain, T, q[None], task, CLOSING if nearest else 1.0)
    return chain.close_loops(found[0], tries=1)


def middle(chain: ClosedChain) -> JointVector:
    """(n,) the middle of the limits, zero where there are none."""
    limits = chain.robot.limits
    bounded = np.isfinite(limits.lower) & np.isfinite(limits.upper)
    low, high = np.where(bounded, limits.lower, 0.0), np.where(bounded, limits.upper, 0.0)
    return (low + high) / 2


def search_starts(
    chain: ClosedChain, T: PoseMatrix, q_0: JointVector, task: Task, count: int, seed: int
) -> JointVector:
    """(k, n) where the search begins."""
    rng, limits, n = np.random.default_rng(seed), chain.robot.limits, chain.n
    reach = UNBOUNDED * np.where(_prismatic(chain), chain.size, 1.0)
    low = np.where(np.isfinite(limits.lower), limits.lower, q_0 - reach)
    high = np.where(np.isfinite(limits.upper), limits.upper, q_0 + reach)
    random = low + rng.random((count, n)) * (high - low)
    random[::2] = q_0 + (random[::2] - q_0) / 4
    rows = [q_0[None], random]
    mechanism = chain.robot.mechanism
    names = [joint.name for joint in chain_to_tip(mechanism) if joint.moves and joint.mimic is None]
    if task == "pose" and len(names) == FULL:
        columns = [chain.robot.joint_names.index(name) for name in names]
        tree = Robot(replace(mechanism, loops=()))
        branches = np.asarray(inverse_kinematics(tree, T, q0=q_0).q).reshape(-1, n)
        for branch in branches:
            seeded = low + rng.random((SEEDED, n)) * (high - low)
            seeded[0] = q_0
            seeded[:, columns] = branch[columns]
            rows.append(seeded)
    return np.concatenate(rows)


def pose_miss(chain: ClosedChain, T: PoseMatrix, q: JointVector, task: Task) -> tuple[Floats, Floats]:
    """(k,) distance [m] and angle [rad] by which the tip misses what a task asks."""
    here = np.asarray(chain.robot.forward_kinematics(q))
    place = np.linalg.norm(here[..., :3, 3] - T[:3, 3], axis=-1)
    if task == "position":
        return place, np.zeros_like(place)
    if task == "axis":
        z, wanted = here[..., :3, 2], T[:3, 2]
        return place, np.arctan2(np.linalg.norm(np.cross(z, wanted), axis=-1), z @ wanted)
    twist = np.asarray(pose.log(np.asarray(pose.inverse(here)) @ T))
    return place, np.linalg.norm(twist[..., :3], axis=-1)


def _equations(
    chain: ClosedChain, T: PoseMatrix, q: JointVector, task: Task, weight: float = 1.0
) -> tuple[Floats, Floats]:
    """(k, m + t) what is left of loops, by weight, and task, lengths over the size; (k, m + t, n) its derivative."""
    terms, here = chain.terms(q), np.asarray(chain.robot.forward_kinematics(q))
    J = np.asarray(chain.robot.jacobian_space(q))
    places = here[..., :3, 3]
    of_point = J[..., 3:, :] + np.cross(J[..., :3, :], places[..., :, None], axis=-2)
    parts, rows = [weight * terms.gap, (places - T[:3, 3]) / chain.size], [weight * terms.J, of_point / chain.size]
    if task == "axis":
        parts.append(here[..., :3, 2] - T[:3, 2])
        rows.append(np.cross(J[..., :3, :], here[..., :3, 2][..., :, None], axis=-2))
    elif task == "pose":
        # The three axes: nine numbers of rank three, whose derivative is plain and which vanish nowhere else.
        parts.append((here[..., :3, :3] - T[:3, :3]).swapaxes(-1, -2).reshape(*here.shape[:-2], 9))
        turned = [np.cross(J[..., :3, :], here[..., :3, k][..., :, None], axis=-2) for k in range(3)]
        rows.append(np.concatenate(turned, axis=-2))
    return np.concatenate(parts, axis=-1), np.concatenate(rows, axis=-2)


def _solve(chain: ClosedChain, T: PoseMatrix, q: JointVector, task: Task, weight: float) -> JointVector:
    """(k, n) Levenberg's method from each row: the damping falls where a step helps and grows where not.

    1. The normal equations with damping, in units of the coordinates.
    2. A step that is shorter than LONGEST in each coordinate.
    3. Rows whose residual did not fall go back and try again more carefully.
    """
    unit = np.where(_prismatic(chain), chain.size, 1.0)
    q, damping = q.copy(), np.full(len(q), 1e-3)
    r, J = _equations(chain, T, q, task, weight)
    cost = np.linalg.norm(r, axis=1)
    going = np.arange(len(q))
    for _ in range(STEPS):
        # 1.
        A = J[going] * unit
        normal = A.swapaxes(-1, -2) @ A
        trace = np.trace(normal, axis1=1, axis2=2)
        normal += (damping[going] * trace)[:, None, None] * np.eye(chain.n) / chain.n
        slope = A.swapaxes(-1, -2) @ r[going][..., None]
        step: Floats = -np.asarray(np.linalg.solve(normal, slope), dtype=np.float64)[..., 0]
        # 2.
        longest = np.abs(step).max(axis=1, initial=0.0)
        step *= np.minimum(1.0, LONGEST / np.maximum(longest, LEAST_DIVISOR))[:, None]
        tried = q[going] + step * unit
        # 3.
        new_r, new_J = _equations(chain, T, tried, task, weight)
        new_cost = np.linalg.norm(new_r, axis=1)
        better = new_cost < cost[going]
        kept = going[better]
        q[kept], r[kept], J[kept], cost[kept] = tried[better], new_r[better], new_J[better], new_cost[better]
        damping[going] = np.clip(damping[going] * np.where(better, 0.1, 8.0), LEAST, MOST)
        going = going[(cost[going] > ENOUGH * weight) & (damping[going] < MOST) & (longest > 1e-15)]
        if not len(going):
            break
    return q


def _prismatic(chain: ClosedChain) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    return np.array([joint.kind is JointKind.PRISMATIC for joint in chain.robot.mechanism.coordinates])


def _wind(chain: ClosedChain, q: JointVector, near: JointVector) -> JointVector:
    """Angles in the turn within the limits that is nearest to those given."""
    limits, turns = chain.robot.limits, 2 * np.pi * ~_prismatic(chain)
    ways = np.round((near - q) / (2 * np.pi))
    wound = q + turns * ways
    low = np.maximum(np.ceil((limits.lower - wound) / (2 * np.pi) - 1e-9), 0.0)
    high = np.maximum(np.ceil((wound - limits.upper) / (2 * np.pi) - 1e-9), 0.0)
    back = wound + turns * (np.where(np.isfinite(low), low, 0.0) - np.where(np.isfinite(high), high, 0.0))
    return np.where(limits.within(back), back, wound)


def _within(chain: ClosedChain, q: JointVector) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
    return np.asarray(chain.robot.limits.within(q).all(axis=-1), dtype=np.bool_)


def _distinct(chain: ClosedChain, q: JointVector, near: JointVector) -> JointVector:
    """Rows that differ, the nearest to one of them first."""
    unit = np.where(_prismatic(chain), chain.size, 1.0)
    rows = q[np.argsort(np.abs((q - near) / unit).max(axis=1, initial=0.0), kind="stable")]
    kept: list[JointVector] = []
    for row in rows:
        if all(np.abs((row - other) / unit).max(initial=0.0) > SAME for other in kept):
            kept.append(row)
    return np.reshape(kept, (len(kept), chain.n))


def _freedom(chain: ClosedChain, q: JointVector, task: Task) -> int:
    """Dimension of the set of configurations around the found ones, to first order: 0 if they are isolated."""
    if not len(q):
        return 0
    _, J = _equations(chain, np.eye(4), q, task)
    s = np.linalg.svd(J / np.maximum(np.linalg.norm(J, axis=2, keepdims=True), 1e-12), compute_uv=False)
    return int(chain.n - (s > RANK * s[:, :1]).sum(axis=1).max())


class ClosedPoseStatus(Status):
    """Whether configurations with closed loops reach a pose."""

    FOUND = ("parallel.pose_found", True)
    FAMILY = ("parallel.pose_family", True)
    OUTSIDE = ("parallel.pose_outside", False)
    NOT_FOUND = ("parallel.pose_not_found", False)


@dataclass(frozen=True, eq=False, repr=False)
class ClosedPoses(Answer, data="q within freedom starts nearest position_error rotation_error gap", entries="q"):
    """Configurations that close all loops with the tip at a pose; true if one is within the limits, iterable.

    Attributes:
        q: (k, n) those that were found, those within the limits first [rad | m].
        within: (k,) whether the limits are kept.
        freedom: dimension of the families that they belong to; 0 where each stands alone.
        starts: of the search.
        nearest: (n,) with closed loops and the least miss.
        position_error: of the nearest [m].
        rotation_error: of the nearest [rad].
        gap: of the loops there [rad | m]; infinite where none could be closed.
    """

    q: JointVector
    within: Booleans
    freedom: int
    starts: int
    nearest: JointVector
    position_error: float
    rotation_error: float
    gap: float

    @property
    def status(self) -> ClosedPoseStatus:
        """By what was found, and where the limits are."""
        if not len(self.q):
            return ClosedPoseStatus.NOT_FOUND
        if not self.within.any():
            return ClosedPoseStatus.OUTSIDE
        return ClosedPoseStatus.FAMILY if self.freedom else ClosedPoseStatus.FOUND

    def explain(self, language: str | None = None) -> str:
        """How many were found and how, or how near the nearest comes."""
        return self.status.sentence(
            language, count=len(self), within=int(self.within.sum()), freedom=self.freedom, starts=self.starts,
            position=quantity(self.position_error, "m"), angle=quantity(self.rotation_error, "rad"), gap=self.gap,
        )  # fmt: skip
