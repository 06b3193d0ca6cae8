"""What was not checked of a job: a check that did not run never reads like one that passed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from mafsil.collision import Checker
from mafsil.collision.pairs import SkipReason
from mafsil.job.description import Job
from mafsil.job.equipment import Load
from mafsil.job.plan import Leg
from mafsil.job.remark import Remark
from mafsil.job.surroundings import OFF, Surroundings, why_not_itself
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible
from mafsil.robot import Robot

SAMPLED = (SkipReason.ALWAYS, SkipReason.OFTEN)
"""Why pairs are left out that neither a joint nor a file nor the user names."""
BARE = 1e-3
"""A tool's tip farther from the flange than this has something between that takes room [m]."""


def unchecked_remarks(job: Job, first: Load, legs: Sequence[Leg], around: Surroundings | None) -> list[Remark]:
    """What nobody looked at: the robot against itself or anything else, bare tools, the ends of joints.

    Args:
        job: the job.
        first: what hangs on the flange at the start.
        legs: planned so far.
        around: what the arm may meet; None if nothing was looked at.
    """
    checker = None if around is None else around.checker(first)
    return [*_of_itself(job, first.robot, checker), *_of_surroundings(job, legs, around), *_endless(first.robot)]


def meets_others(around: Surroundings, legs: Sequence[Leg]) -> bool:
    """Whether there is anything but the robot itself that it may meet."""
    return bool(len(around.scene) or around.neighbours or any(leg.parts for leg in legs))


def _of_itself(job: Job, robot: Robot, checker: Checker | None) -> list[Remark]:
    """Why the robot is not checked against itself; else the pairs that are not, or keep less than the clearance."""
    why = why_not_itself(job.collision, robot.mechanism)
    if why is not None:
        return [Remark("warning" if why == OFF else "good", why)]
    assert checker is not None
    if not len(checker.arm.pairs):
        return [Remark("good", "job.unchecked_itself_pairs")]
    left_out = [visible(str(each)) for each in checker.skipped if each.reason in SAMPLED]
    near = [f"{visible(a)} - {visible(b)} ({quantity(kept, 'm')})" for (a, b), kept in checker.always_near.items()]
    found = [Remark("good", "job.unchecked_pairs", {"pairs": ", ".join(left_out)})] if left_out else []
    details = {"pairs": ", ".join(near), "wanted": quantity(checker.clearance, "m")}
    return [*found, Remark("good", "job.always_near", details)] if near else found


def _of_surroundings(job: Job, legs: Sequence[Leg], around: Surroundings | None) -> list[Remark]:
    """That nothing stands around, which matters more where a clearance was asked for; tools without a size."""
    if around is None or not meets_others(around, legs):
        wanted = max([0.0 if job.collision is None else job.collision.clearance, *(leg.clearance for leg in legs)])
        if wanted > 0.0:
            return [Remark("warning", "job.unchecked_clearance", {"wanted": quantity(wanted, "m")})]
        return [Remark("good", "job.unchecked_surroundings")]
    bare = dict.fromkeys(
        visible(leg.load.equipment.name or "") for leg in legs
        if leg.load.equipment.tool.size is None and leg.load.equipment.tool.offset is not None
        and np.linalg.norm(leg.load.equipment.tool.offset.position) > BARE
    )  # fmt: skip
    return [Remark("good", "job.unchecked_tool", {"tool": name or "@job.unnamed_tool"}) for name in bare]


def _endless(robot: Robot) -> list[Remark]:
    """Joints whose ranges nobody described: that they end somewhere was not checked."""
    free = robot.mechanism.endless
    joints = ", ".join(map(visible, free)) if len(free) < robot.n else "@job.all_joints"
    return [Remark("good", "collision.unchecked_range", {"joints": joints})] if free else []
