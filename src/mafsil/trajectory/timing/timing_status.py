"""How the search for the shortest time along a path ended."""

from __future__ import annotations

from mafsil.answer import Status


class TimingStatus(Status):
    """Whether a path has a time law within the limits."""

    TIMED = ("trajectory.timed", True)
    POSITION = ("trajectory.path_outside", False)
    START_VELOCITY = ("trajectory.start_velocity", False)
    END_VELOCITY = ("trajectory.end_velocity", False)
    NO_REST = ("trajectory.no_rest", False)
    NO_MOTION = ("trajectory.no_motion", False)
    BLOCKED = ("trajectory.blocked", False)
    EXCEEDED = ("trajectory.between_places", False)
