"""Whether what a move keeps makes sense."""

from __future__ import annotations

import math
from typing import Any

from mafsil.job.constraint_table import CONSTRAINED_PLANNER, DIRECTIONS, KINDS, PathConstraints, PlacedConstraints
from mafsil.job.description import QUICKEST, TIP_PATHS, Job, Move
from mafsil.job.language.frames import Complaint
from mafsil.job.language.units import angle_unit
from mafsil.job.lines import Path

SHORTEST_DIRECTION = 1e-6
"""Length of a vector that is taken as a direction."""
OF: dict[str, tuple[str, ...]] = {"tolerance": DIRECTIONS, "frame": DIRECTIONS, "angle": ("orientation",)}
"""Keys that say something of others."""


def check_constraints(constraints: PlacedConstraints, path: Path, data: dict[str, Any], error: Complaint) -> None:
    """Refuse a table that keeps nothing, directions without a length, and keys without effect."""
    given = [name for name in KINDS if getattr(constraints, name) not in (None, False)]
    if not given:
        raise error("job.constraint_empty", path, known=", ".join(KINDS))
    for name in DIRECTIONS:
        if name in given and math.hypot(*getattr(constraints, name)) < SHORTEST_DIRECTION:
            raise error("job.no_normal", (*path, name), given=name)
    for name, owners in OF.items():
        if name in data and not set(owners) & set(given):
            raise error("job.constraint_key", (*path, name), known=", ".join(owners))


def require_keepable(job: Job, error: Complaint) -> None:
    """Refuse moves that cannot keep anything, and angles that keep nothing.

    Args:
        job: its moves, one after the other.
        error: makes the complaint about a key of a move of the job.

    Raises:
        JobError: a path of the tip, points on the way, a law of time, another planner, an angle of half a turn or more.
    """
    for k, move in enumerate(job.move):
        if move.constraints is not None:
            _check_move(move, ("move", k), error)
            _check_angles(move.constraints, ("move", k, "constraints"), angle_unit(job), error)


def _check_move(move: Move, path: Path, error: Complaint) -> None:
    """Only a way that is planned keeps something."""
    if move.path in TIP_PATHS:
        raise error("job.constraint_path", (*path, "constraints"), kind=move.path)
    if move.via:
        raise error("job.constraint_via", (*path, "via"))
    if move.profile not in (None, *QUICKEST):
        raise error("job.constraint_profile", (*path, "profile"), known=", ".join(QUICKEST))
    if move.planner not in (None, CONSTRAINED_PLANNER):
        raise error("job.constraint_planner", (*path, "planner"), planner=CONSTRAINED_PLANNER)
    if move.avoid is False:
        raise error("job.constraint_avoid", (*path, "avoid"))


def _check_angles(constraints: PathConstraints, path: Path, unit: float, error: Complaint) -> None:
    """Angles below half a turn."""
    for name in ("upright", "angle"):
        angle = getattr(constraints, name)
        if angle is not None and unit * angle >= math.pi:
            raise error("job.constraint_angle", (*path, name), value=f"{angle:g}", limit=f"{math.pi / unit:.4g}")
