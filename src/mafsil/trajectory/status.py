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
    VELOCITY_JUMPS = ("trajectory.velocity_jumps", False)


class LimitStatus(Status):
    """Whether a trajectory keeps the limits of its joints."""

    KEPT = ("trajectory.within_limits", True)
    EXCEEDED = ("trajectory.exceeded", False)


class BlendStatus(Status):
    """Whether straight lines hold their blends."""

    PLANNED = ("trajectory.planned", True)
    TOO_SHORT_TO_BLEND = ("trajectory.too_short_to_blend", False)
    BLENDS_OVERLAP = ("trajectory.blends_overlap", False)


class ContinuityStatus(Status):
    """Whether an arm can follow a trajectory as it is."""

    CONTROLLABLE = ("trajectory.controllable", True)
    NOT_CONTROLLABLE = ("trajectory.not_controllable", False)
