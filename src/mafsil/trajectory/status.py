"""Why a trajectory could or could not be planned."""

from __future__ import annotations

from mafsil.answer import Status


class PlanStatus(Status):
    """How planning a trajectory ended."""

    PLANNED = ("trajectory.planned", True)
    FOLLOWED = ("trajectory.followed", True)
    STRETCHED = ("trajectory.stretched", True)
    TOO_SHORT = ("trajectory.too_short", False)
    NOT_FOUND = ("trajectory.not_followed", False)
    ORIENTATION_NOT_FOUND = ("trajectory.orientation_not_followed", False)
    SINGULAR = ("trajectory.singular", False)
    JOINT_LIMIT = ("trajectory.joint_limit", False)
    DEVIATES = ("trajectory.deviates", False)
    RATE_LIMIT = ("trajectory.rate_limit", False)
    VELOCITY_JUMPS = ("trajectory.velocity_jumps", False)


class ComparisonStatus(Status):
    """Whether one of the profiles that are compared keeps all limits."""

    COMPARED = ("trajectory.compared", True)
    TOO_WEAK = ("trajectory.compared_weak", False)
    NONE_KEEPS = ("trajectory.compared_none_keeps", False)


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


class ViaRateStatus(Status):
    """How well joint rates at a via point make the tip's velocity."""

    EXACT = ("trajectory.rates_exact", True)
    DAMPED = ("trajectory.rates_damped", False)
    NOT_POSSIBLE = ("trajectory.rates_not_possible", False)


class ProofStatus(Status):
    """Whether a motion is proven to keep its limits."""

    PROVEN = ("trajectory.proven", True)
    EXCEEDED = ("trajectory.exceeded", False)
    IN_DOUBT = ("trajectory.in_doubt", False)


class TickStatus(Status):
    """Whether a generator keeps up with its update rate."""

    ON_TIME = ("trajectory.on_time", True)
    OVERRUN = ("trajectory.overrun", False)


class RequirementStatus(Status):
    """Whether a trajectory does what it must."""

    MET = ("trajectory.met", True)
    NOT_MET = ("trajectory.not_met", False)
