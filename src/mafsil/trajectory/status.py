"""Why a trajectory could or could not be planned."""

from __future__ import annotations

from mafsil.answer import Status


class PlanStatus(Status):
    """How planning a trajectory ended."""

    PLANNED = ("trajectory.planned", True)
    FOLLOWED = ("trajectory.followed", True)
    STRETCHED = ("trajectory.stretched", True)
    TOO_SHORT = ("trajectory.too_short", False)
    UNREACHABLE = ("trajectory.unreachable", False)
    SINGULAR = ("trajectory.singular", False)
    JOINT_LIMIT = ("trajectory.joint_limit", False)
    DEVIATES = ("trajectory.deviates", False)
    RATE_LIMIT = ("trajectory.rate_limit", False)


class LimitStatus(Status):
    """Whether a trajectory keeps the limits of its joints."""

    KEPT = ("trajectory.within_limits", True)
    EXCEEDED = ("trajectory.exceeded", False)
