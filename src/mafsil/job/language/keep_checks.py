"""Whether what a move keeps makes sense."""

from __future__ import annotations

import math
from typing import Any

from mafsil.job.description import QUICKEST, TIP_PATHS, Job, Move
from mafsil.job.keep_table import DIRECTIONS, KEEPER, KINDS, Keep, PlacedKeep
from mafsil.job.language.frames import Complaint
from mafsil.job.language.units import angle_unit
from mafsil.job.lines import Path

SHORTEST_DIRECTION = 1e-6
"""Length of a vector that is taken as a direction."""
OF: dict[str, tuple[str, ...]] = {"tolerance": DIRECTIONS, "frame": DIRECTIONS, "angle": ("orientation",)}
"""Keys that say something of others."""


def check_keep(keep: PlacedKeep, path: Path, data: dict[str, Any], error: Complaint) -> None:
    """Refuse a table that keeps nothing, directions without a length, and keys without effect."""
    given = [name for name in KINDS if getattr(keep, name) not in (None, False)]
    if not given:
        raise error("job.keep_empty", path, known=", ".join(KINDS))
    for name in DIRECTIONS:
        if name in given and math.hypot(*getattr(keep, name)) < SHORTEST_DIRECTION:
            raise error("job.no_normal", (*path, name), given=name)
    for name, owners in OF.items():
        if name in data and not set(owners) & set(given):
            raise error("job.keep_key", (*path, name), known=", ".join(owners))


def require_keepable(job: Job, error: Complaint) -> None:
    """Refuse moves that cannot keep anything, and angles that keep nothing.

    Args:
        job: its moves, one after the other.
        error: makes the complaint about a key of a move of the job.

    Raises:
        JobError: a path of the tip, points on the way, a law of time, another planner, an angle of half a turn or more.
    """
    for k, move in enumerate(job.move):
        if move.keep is not None:
            _check_move(move, ("move", k), error)
            _check_angles(move.keep, ("move", k, "keep"), angle_unit(job), error)


def _check_move(move: Move, path: Path, error: Complaint) -> None:
    """Only a way that is planned keeps something."""
    if move.path in TIP_PATHS:
        raise error("job.keep_path", (*path, "keep"), kind=move.path)
    if move.via:
        raise error("job.keep_via", (*path, "via"))
    if move.profile not in (None, *QUICKEST):
        raise error("job.keep_profile", (*path, "profile"), known=", ".join(QUICKEST))
    if move.planner not in (None, KEEPER):
        raise error("job.keep_planner", (*path, "planner"), planner=KEEPER)
    if move.avoid is False:
        raise error("job.keep_avoid", (*path, "avoid"))


def _check_angles(keep: Keep, path: Path, unit: float, error: Complaint) -> None:
    """Angles below half a turn."""
    for name in ("upright", "angle"):
        angle = getattr(keep, name)
        if angle is not None and unit * angle >= math.pi:
            raise error("job.keep_angle", (*path, name), value=f"{angle:g}", limit=f"{math.pi / unit:.4g}")
