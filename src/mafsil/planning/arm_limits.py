"""Limits of an arm: which joint is beyond its own, and between which coordinates a search goes."""

from __future__ import annotations

from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats, JointVector, Truth
from mafsil.collision import Checker
from mafsil.errors import InputError
from mafsil.messages import say

Moving: TypeAlias = tuple[str, ...] | None
UNBOUNDED = np.pi
"""Where a joint without limits is searched, to both sides of start and goals [rad | m]."""


def beyond_limits(checker: Checker, q: JointVector) -> str:
    """A sentence for the joint that is furthest beyond its limits; empty if none is."""
    limits = checker.robot.limits
    beyond = np.maximum(limits.lower - q, q - limits.upper)
    k = int(beyond.argmax())
    if not beyond[k] > 0.0:
        return ""
    joint = checker.robot.mechanism.coordinates[k].name
    lower, upper = float(limits.lower[k]), float(limits.upper[k])
    far = float(beyond[k])
    return say("planning.beyond_limit", joint=joint, value=float(q[k]), lower=lower, upper=upper, far=far)


def endless_joints(checker: Checker) -> str:
    """A sentence for joints that turn without end, whose goals may be meant up to whole turns; empty if none does."""
    limits, coordinates = checker.robot.limits, checker.robot.mechanism.coordinates
    endless = checker.moves_tip & np.isinf(limits.lower) & np.isinf(limits.upper)
    names = [each.name for each, free in zip(coordinates, endless, strict=True) if free and each.screw[:3].any()]
    return say("planning.endless", joints=", ".join(names)) if names else ""


def held_of(checker: Checker, ends: JointVector, moving: Moving = None) -> Truth:
    """(n,) which coordinates stay where they are at all ends, because nothing that changes needs them.

    What changes frees what carries it and the rest of its limb (`Checker.freed_by`); where all that changes moves the
    tip, it frees all that does.

    Args:
        checker: the arm.
        ends: (k, n) start and goals.
        moving: coordinates that may move beside those that change; None for the rule above.
    """
    changes = np.ptp(ends, axis=0) > 0.0
    moves, freed = motion_rule(checker, moving)
    may = freed[:, changes].any(axis=1)
    return ~(changes | may | moves if moves[changes].all() else changes | may)


def motion_rule(checker: Checker, moving: Moving = None) -> tuple[Truth, Truth]:
    """(n,), (n, n) which coordinates move the tip, and which free each other; arguments as `held_of`.

    Raises:
        InputError: a name that no coordinate has.
    """
    if moving is None:
        return checker.moves_tip, checker.freed_by
    names = [each.name for each in checker.robot.mechanism.coordinates]
    for name in moving:
        if name not in names:
            raise InputError("input.choice", name="moving", value=name, known=", ".join(names))
    listed = np.array([name in moving for name in names], np.bool_)
    return listed, np.repeat(listed[:, None], len(names), axis=1)


def held_joints(checker: Checker, ends: JointVector, moving: Moving) -> str:
    """A sentence for the coordinates that were held; empty if none was."""
    held = held_of(checker, ends, moving)
    names = [each.name for each, still in zip(checker.robot.mechanism.coordinates, held, strict=True) if still]
    return say("planning.held", joints=", ".join(names)) if names else ""


def bounds_of(checker: Checker, ends: JointVector, moving: Moving = None) -> tuple[Floats, Floats]:
    """(n,) between which to search: the limits, or around the ends where there are none; one value for what is held.

    Args:
        checker: the arm.
        ends: (k, n) start and goals.
        moving: as for `held_of`.
    """
    limits = checker.robot.limits
    lower = np.where(np.isfinite(limits.lower), limits.lower, ends.min(axis=0) - UNBOUNDED)
    upper = np.where(np.isfinite(limits.upper), limits.upper, ends.max(axis=0) + UNBOUNDED)
    still = held_of(checker, ends, moving)
    return np.where(still, ends[0], lower), np.where(still, ends[0], upper)
