"""The questions that a job puts to planners: its moves of the joints among its obstacles."""

from __future__ import annotations

import numpy as np

from mafsil.errors import JobError
from mafsil.job.joint_motion import STILL
from mafsil.job.plan import Plan
from mafsil.planning import Query


def queries_of(plan: Plan) -> tuple[Query, ...]:
    """Each move of the joints, from where it begins to where it ends, with what the tool carries then.

    Args:
        plan: of the job.

    Raises:
        JobError: there are no such moves, or nothing stands around the arm.
    """
    found: list[Query] = []
    for leg in plan.legs if plan.surroundings is not None else ():
        q = leg.trajectory.at(np.array([0.0, leg.trajectory.duration])).u
        if leg.kind == "joint" and np.abs(q[1] - q[0]).max() > STILL:
            assert plan.surroundings is not None
            checker = plan.surroundings.checker(leg.load, leg.clearance, leg.parts)
            found.append(Query(leg.name or str(leg.index + 1), checker, q[0], q[1]))
    if not found:
        raise JobError("job.no_free_moves")
    return tuple(found)
