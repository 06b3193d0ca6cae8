"""What a move keeps on its way, as typed data. Field names are the keys of the file."""

from __future__ import annotations

from mafsil.job.part import Part, Positive, Three


class PathConstraints(Part, frozen=True, kw_only=True):
    """What the tip keeps from where the move begins: one or several.

    Attributes:
        upright: largest angle between its z axis and where that pointed [rad, or degrees].
        orientation: its orientation.
        line: direction of the straight line through its place on which it stays, in {s}.
        plane: normal of the plane through its place in which it stays, in {s}.
        tolerance: of line and plane [m].
        angle: of the orientation [rad, or degrees].
    """

    upright: Positive | None = None
    orientation: bool = False
    line: Three | None = None
    plane: Three | None = None
    tolerance: Positive | None = None
    angle: Positive | None = None


class PlacedConstraints(PathConstraints, frozen=True, kw_only=True):
    """The same along the axes of a frame.

    Attributes:
        frame: of line and plane; {s} if None.
    """

    frame: str | None = None


CONSTRAINED_PLANNER = "rrt_connect"
"""The planner that keeps something."""
KINDS = ("upright", "orientation", "line", "plane")
"""Keys of which at least one is given."""
DIRECTIONS = ("line", "plane")
