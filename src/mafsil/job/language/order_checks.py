"""Whether the moves of a job fit those after them: rounded corners, branches, ways round."""

from __future__ import annotations

from mafsil.job.description import QUICKEST, TIP_PATHS, Job, Move
from mafsil.job.language.frames import Complaint
from mafsil.messages.visible import visible


def require_order(job: Job, error: Complaint) -> None:
    """Refuse moves that do not fit those after them.

    Args:
        job: its moves, one after the other.
        error: makes the complaint about a key of a move of the job.

    Raises:
        JobError: a corner that cannot be rounded, a branch on a path of the tip, a way round where there is none.
    """
    for k in range(len(job.move)):
        _check_blend(job.move, k, error)
        goal = job.move[k].pose
        if goal is not None and goal.branch is not None and job.move[k].path in TIP_PATHS:
            raise error("job.branch_path", ("move", k, "pose", "branch"), kind=job.move[k].path)
    _check_avoiding(job, error)


def _check_blend(moves: tuple[Move, ...], k: int, error: Complaint) -> None:
    """A corner is rounded between two paths of the tip whose time is not ruled otherwise."""
    move = moves[k]
    if not move.blend:
        return
    then = moves[k + 1] if k + 1 < len(moves) and not move.skip else None
    if move.path not in TIP_PATHS or then is None or then.path not in TIP_PATHS or then.pose is None:
        raise error("job.blend_next", ("move", k, "blend"), known=", ".join(TIP_PATHS))
    for index, one in ((k, move), (k + 1, then)):
        if one.profile not in (None, *QUICKEST):
            raise error("job.blend_profile", ("move", index, "profile"))
        if one.duration is not None:
            raise error("job.blend_duration", ("move", index, "duration"))
    assert move.pose is not None
    if move.pose.task != then.pose.task:
        raise error("job.blend_task", ("move", k + 1, "pose", "task"), task=move.pose.task)


def _check_avoiding(job: Job, error: Complaint) -> None:
    """Only moves of the joints without points on the way go round, and only they have a planner."""
    usual = job.collision is not None and job.collision.avoid
    for k, move in enumerate(job.move):
        goes_round = (usual if move.avoid is None else move.avoid) and move.path == "joint" and not move.via
        goes_round = goes_round or move.constraints is not None
        if move.planner is not None and not goes_round:
            raise error("job.planner_avoid", ("move", k, "planner"))
        if not move.avoid:
            continue
        if move.path in TIP_PATHS:
            raise error("job.avoid_path", ("move", k, "avoid"), kind=move.path)
        if move.via:
            raise error("job.avoid_via", ("move", k, "via"))
        if move.profile not in (None, *QUICKEST):
            raise error("job.avoid_profile", ("move", k, "profile"), known=", ".join(QUICKEST))


def require_grips(job: Job, error: Complaint) -> None:
    """The moves with which doors are taken and let go exist, in this order.

    Args:
        job: all moves, in the order of the file.
        error: how a complaint is made.

    Raises:
        JobError: no such move, or the door is let go before it is taken.
    """
    names = [move.name for move in job.move]
    for k, door in enumerate(job.door):
        for key in ("grip", "release"):
            name = getattr(door, key)
            if name and name not in names:
                raise error("job.door_move", ("door", k, key), given=visible(name))
        begun = names.index(door.grip) if door.grip else 0
        if door.release and door.release not in names[begun:]:
            raise error("job.door_order", ("door", k, "release"))
