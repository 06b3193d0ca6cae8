"""How planning a jerk-limited motion ended."""

from __future__ import annotations

from mafsil.answer import Status


class JerkStatus(Status):
    """How planning a jerk-limited motion ended; in the order of the codes of `plan_loops`."""

    PLANNED = ("jerk.planned", True)
    TARGET_OUTSIDE = ("jerk.target_outside", False)
    FROZEN = ("jerk.frozen", False)
    UNREACHABLE = ("jerk.unreachable", False)
    NO_COMMON_DURATION = ("jerk.no_common_duration", False)
    BEYOND_NUMBERS = ("jerk.beyond_numbers", False)


STATUSES = tuple(JerkStatus)
