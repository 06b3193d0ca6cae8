"""A planned job driven and judged: simulated, its numbers held against what was asked, its failures explained."""

from __future__ import annotations

import os
from collections.abc import Callable
from dataclasses import replace

from mafsil.job import judgement
from mafsil.job.causes import causes_of
from mafsil.job.description import Job
from mafsil.job.law_conditions import stability_remarks
from mafsil.job.limiting import limits_of_cycle
from mafsil.job.plan import Plan
from mafsil.job.plan_simulation import simulate_plan
from mafsil.job.run import Run
from mafsil.job.searching import search_remarks
from mafsil.robot import Robot
from mafsil.simulation.live_log import RunListener


def drive(
    job: Job,
    text: str,
    robot: Robot,
    plan: Plan,
    progress: Callable[[float], None] = lambda share: None,
    *,
    explained: bool = True,
    again: Callable[[float], None] = lambda share: None,
    log: str | os.PathLike[str] | RunListener | None = None,
) -> Run:
    """Simulate a plan and judge the run.

    Args:
        job, text: what is asked, and its file.
        robot: with its tool.
        plan: the motion.
        progress: called with the share of the time that has been simulated.
        explained: whether a job that failed is driven again, to find the causes.
        again: called with the share of that which is done.
        log: path of a live log, `.mcap`, or what else hears of the ticks; none if None.

    Raises:
        JobError: friction is too stiff for the integrator that is asked
            for, or the motion is too long to be simulated.
        MafsilError: the log cannot be written.
    """
    run = replace(simulate_plan(job, text, robot, plan, progress, log=log), limits=limits_of_cycle(plan))
    causes = causes_of(run, again) if explained and not plan.kinematic else {}
    searches = search_remarks(job, plan, simulated=True)
    found = replace(run, remarks=(*searches, *judgement.remarks(run, judgement.summary(run), causes), *run.remarks))
    return replace(found, remarks=(*found.remarks, *stability_remarks(found)))
