"""Ends of a search for an arm: joints within their limits, and goals that leave room, any pose of the tip in a box."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, PoseMatrix, Truth, as_batch, frozen, real_array, require_finite, whole
from mafsil.errors import InputError
from mafsil.fields import between
from mafsil.geometry import rotation
from mafsil.model.placement import checked_pose
from mafsil.planning.outcome import Reason

if TYPE_CHECKING:
    from mafsil.collision import Checker


MOST_POSES = 10_000
Moving: TypeAlias = tuple[str, ...] | None
UNBOUNDED = np.pi
"""Where a joint without limits is searched, to both sides of start and goals [rad | m]."""


def beyond_limits(checker: Checker, q: JointVector) -> Reason:
    """A sentence for the joint that is furthest beyond its limits; empty if none is."""
    limits = checker.robot.limits
    beyond = np.maximum(limits.lower - q, q - limits.upper)
    k = int(beyond.argmax())
    if not beyond[k] > 0.0:
        return Reason()
    joint = checker.robot.mechanism.coordinates[k].name
    lower, upper = float(limits.lower[k]), float(limits.upper[k])
    details = {"joint": joint, "value": float(q[k]), "lower": lower, "upper": upper, "far": float(beyond[k])}
    return Reason(("planning.beyond_limit", details))


def endless_joints(checker: Checker, held: Truth) -> Reason:
    """A sentence for joints that turn without end, whose goals may be meant up to whole turns; empty if none does.

    Args:
        checker: the arm.
        held: (n,) which coordinates do not move.
    """
    limits, coordinates = checker.robot.limits, checker.robot.mechanism.coordinates
    endless = ~held & np.isinf(limits.lower) & np.isinf(limits.upper)
    names = [each.name for each, free in zip(coordinates, endless, strict=True) if free and each.screw[:3].any()]
    return Reason(("planning.endless", {"joints": ", ".join(names)})) if names else Reason()


class MotionRule(NamedTuple):
    """Which coordinates may move though they end where they start.

    Attributes:
        moves: (n,) whether a coordinate moves the tip.
        limb: (n, n) whether coordinate i may move where j ends elsewhere than it starts.
        behind: (n, n) whether it may do so where all that does moves the tip.
    """

    moves: Truth
    limb: Truth
    behind: Truth


def rule_for(checker: Checker, moving: Moving = None) -> MotionRule:
    """The rest of the limbs of what changes may move; where all of that moves the tip, what follows on the way to it.

    Args:
        checker: the arm.
        moving: names of coordinates that may move in place of that.

    Raises:
        InputError: a name that no coordinate has.
    """
    limb, carries = checker.kinship
    if moving is None:
        moves = checker.moves_tip
        return MotionRule(moves, limb, np.ascontiguousarray(carries.T & moves[:, None]))
    names = [each.name for each in checker.robot.mechanism.coordinates]
    for name in moving:
        if name not in names:
            raise InputError("input.choice", name="moving", value=name, known=", ".join(names))
    listed = np.array([name in moving for name in names], np.bool_)
    return MotionRule(listed, np.repeat(listed[:, None], len(names), axis=1), np.zeros_like(limb))


def held_of(checker: Checker, ends: JointVector, moving: Moving = None) -> Truth:
    """(n,) which coordinates stay where they are at all ends; where nothing changes, all that do not move the tip.

    Args:
        checker: the arm.
        ends: (k, n) start and goals.
        moving: as for `rule_for`.
    """
    changes, rule = np.ptp(ends, axis=0) > 0.0, rule_for(checker, moving)
    if not changes.any():
        return ~rule.moves
    may = changes | rule.limb[:, changes].any(axis=1)
    return ~(may | rule.behind[:, changes].any(axis=1)) if rule.moves[changes].all() else ~may


def with_carriers(checker: Checker, ends: JointVector) -> Moving:
    """Names of what may move by the rule and of what carries it, such as a torso; None if that is nothing more."""
    held = held_of(checker, ends)
    carriers = held & checker.kinship.carries[:, ~held].any(axis=1)
    if not carriers.any():
        return None
    may_move = ~held | carriers
    return tuple(each.name for each, may in zip(checker.robot.mechanism.coordinates, may_move, strict=True) if may)


def held_joints(checker: Checker, held: Truth) -> Reason:
    """A sentence for the coordinates that were held (n,); empty if none was."""
    names = [each.name for each, still in zip(checker.robot.mechanism.coordinates, held, strict=True) if still]
    return Reason(("planning.held", {"joints": ", ".join(names)})) if names else Reason()


def bounds_of(checker: Checker, ends: JointVector, moving: Moving = None) -> tuple[Floats, Floats]:
    """(n,) between which to search: the limits, or around the ends where there are none; one value for what is held.

    Args:
        checker: the arm.
        ends: (k, n) start and goals.
        moving: as for `rule_for`.
    """
    limits = checker.robot.limits
    lower = np.where(np.isfinite(limits.lower), limits.lower, ends.min(axis=0) - UNBOUNDED)
    upper = np.where(np.isfinite(limits.upper), limits.upper, ends.max(axis=0) + UNBOUNDED)
    still = held_of(checker, ends, moving)
    return np.where(still, ends[0], lower), np.where(still, ends[0], upper)


@dataclass(frozen=True, eq=False, slots=True)
class GoalRegion:
    """A goal region: poses of the tip near a nominal one.

    Attributes:
        T: (4, 4) the pose in the middle, in {s}.
        box: (3,) how far the tip may be from it along each axis of that pose, to both sides [m]; one number for all.
        angle: by how much it may be turned from it, about any axis [rad]; pi for any orientation.
        axis: about which alone it may be turned, in the frame of the pose, such as (0, 0, 1) for a round tool; None for
            any axis.
        count: poses that are tried, that in the middle first.
        seed: of the others.

    Raises:
        InputError: no pose, a negative length or angle, an angle above pi.
    """

    T: PoseMatrix
    box: Floats | float = 0.0
    angle: float = 0.0
    axis: ArrayLike | None = None
    count: int = 64
    seed: int = 0

    def __post_init__(self) -> None:
        object.__setattr__(self, "T", frozen(checked_pose("T", self.T)))
        box = require_finite("box", real_array("box", self.box))
        if box.shape not in ((), (3,)) or (box < 0.0).any():
            raise InputError("planning.region_box", value=self.box)
        object.__setattr__(self, "box", frozen(np.broadcast_to(box, (3,))))
        object.__setattr__(self, "angle", between(0.0, np.pi + 1e-12)("angle", self.angle))
        if self.axis is not None:
            axis = require_finite("axis", real_array("axis", self.axis))
            if axis.shape != (3,) or not axis.any():
                raise InputError("planning.constraint_direction", name="axis")
            object.__setattr__(self, "axis", frozen(axis / np.linalg.norm(axis)))
        whole("count", self.count, 1, MOST_POSES)
        whole("seed", self.seed)

    def poses(self) -> PoseMatrix:
        """(count, 4, 4) the pose in the middle, then others evenly within the region; equal seeds give equal poses."""
        rng = np.random.default_rng(self.seed)
        poses = np.tile(self.T, (self.count, 1, 1))
        places = rng.uniform(-1.0, 1.0, (self.count, 3)) * self.box
        vectors = self._turns(rng)
        places[0], vectors[0] = 0.0, 0.0
        poses[:, :3, 3] += places @ self.T[:3, :3].T
        poses[:, :3, :3] = self.T[:3, :3] @ rotation.exp(vectors)
        return poses

    def contains(self, T: ArrayLike, tolerance: float = 1e-6) -> np.ndarray[tuple[int, ...], np.dtype[np.bool_]]:
        """(*batch,) whether poses (*batch, 4, 4) lie in the region, up to a tolerance [m, rad]."""
        poses = as_batch("T", T, (4, 4), finite=True)
        away = (poses[..., :3, 3] - self.T[:3, 3]) @ self.T[:3, :3]
        turns = rotation.log(np.swapaxes(self.T[:3, :3], -1, -2) @ poses[..., :3, :3])
        if self.axis is not None:
            along = np.asarray(turns @ np.asarray(self.axis))[..., None] * np.asarray(self.axis)
            off = np.linalg.norm(turns - along, axis=-1)
            turned = (off <= tolerance) & (np.linalg.norm(along, axis=-1) <= self.angle + tolerance)
        else:
            turned = np.linalg.norm(turns, axis=-1) <= self.angle + tolerance
        return np.asarray((np.abs(away) <= self.box + tolerance).all(axis=-1) & turned)

    def _turns(self, rng: np.random.Generator) -> Floats:
        """(count, 3) rotation vectors: even over the ball of rotations, or over the angle about the axis."""
        if self.axis is not None:
            return rng.uniform(-self.angle, self.angle, (self.count, 1)) * np.asarray(self.axis)
        ways = rng.standard_normal((self.count, 3))
        ways /= np.linalg.norm(ways, axis=1, keepdims=True)
        return _angles(rng.random(self.count), self.angle)[:, None] * ways


def _angles(shares: Floats, most: float) -> Floats:
    """Angles of rotations that are even by Haar's measure: (a - sin a) / (A - sin A) = share, by bisection."""
    low, high = np.zeros_like(shares), np.full_like(shares, most)
    for _ in range(60):
        middle = 0.5 * (low + high)
        above = middle - np.sin(middle) > shares * (most - np.sin(most))
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return 0.5 * (low + high)
