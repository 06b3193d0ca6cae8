"""Limits of an arm: which joint is beyond its own, and between which coordinates a search goes."""

from __future__ import annotations

from typing import TYPE_CHECKING, NamedTuple, TypeAlias

import numpy as np

from mafsil.arrays import Floats, JointVector, Truth
from mafsil.errors import InputError
from mafsil.planning.outcome import Reason

if TYPE_CHECKING:
    from mafsil.collision import Checker

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
