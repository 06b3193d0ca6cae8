"""Limits of an arm: which joint is beyond its own, and between which coordinates a search goes."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.collision import Checker
from mafsil.messages import say

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


def bounds_of(checker: Checker, ends: JointVector) -> tuple[Floats, Floats]:
    """(n,) between which to search: the limits, or around the ends where there are none.

    Coordinates that move neither tip nor loops and have one value at all ends, such as those of a gripper, keep it.
    """
    limits = checker.robot.limits
    lower = np.where(np.isfinite(limits.lower), limits.lower, ends.min(axis=0) - UNBOUNDED)
    upper = np.where(np.isfinite(limits.upper), limits.upper, ends.max(axis=0) + UNBOUNDED)
    still = ~checker.moves_tip & (np.ptp(ends, axis=0) == 0.0)
    return np.where(still, ends[0], lower), np.where(still, ends[0], upper)
