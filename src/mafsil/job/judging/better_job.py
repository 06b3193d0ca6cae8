"""A better job from a controller's log: the load as it was identified, and limits that the drives hold.

1. Late and yielding joints give a model of the arm as it drove: it has to miss the very targets that the log missed.
2. The job is planned again with lower shares of its limits, until that model reaches every target.
3. What the model cannot reach so is not offered: a wrong zero is no matter of the job.
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats
from mafsil.job.judging.log_comparison import STEP, LogComparison, missed_targets, model_efforts, positions
from mafsil.job.language.description import Job
from mafsil.job.language.units import angle_unit, length_unit
from mafsil.job.planning.fitting import assumed_limits
from mafsil.job.planning.plan import Plan
from mafsil.job.remark import Remark
from mafsil.messages.quantities import quantity
from mafsil.robot import Robot

SHARES = (0.9, 0.8, 0.7, 0.6, 0.5, 0.4, 0.3, 0.2)
"""Of the limits of the job that are tried, one after the other."""
Replan: TypeAlias = Callable[[str], tuple[Job, Plan] | None]
"""Reads and plans the text of a job; None where that is refused."""
LEAST_MASS = 0.02
"""Identified load that is worth a line [kg]."""
HEADER = r"(?m)^\s*\[\s*{table}\s*\][^\n]*\n"


@dataclass(frozen=True, eq=False, slots=True)
class BetterJob:
    """A job that holds what the log shows.

    Attributes:
        text: of it; empty where none is offered.
        remarks: what was changed and what that brings, or why there is none.
    """

    text: str
    remarks: tuple[Remark, ...]


def better_job(job: Job, text: str, plan: Plan, found: LogComparison, replan: Replan) -> BetterJob:
    """The job with what its log taught.

    Args:
        job, text, plan: that were driven.
        found: what the log says.
        replan: reads and plans a changed job.
    """
    remarks, missed = list[Remark](), [one for one in found.remarks if one.key == "job.log_missed"]
    changed = _with_load(job, text, found, remarks) if abs(found.payload) >= LEAST_MASS else text
    if missed:
        ours = missed_targets(job, plan, *_predict_tracking(plan, found))
        if [one.details["move"] for one in ours] != [one.details["move"] for one in missed]:
            return BetterJob("", (Remark("warning", "job.better_unknown", {"count": len(missed)}),))
        slower = _slower(job, changed, plan.legs[0].load.robot, found, replan)
        if slower is None:
            return BetterJob("", (Remark("warning", "job.better_none", {"share": quantity(SHARES[-1], "share")}),))
        changed, share, cycle = slower
        details = {"share": quantity(share, "share"), "count": len(missed)}
        times = {"before": quantity(plan.cycle, "s"), "after": quantity(cycle, "s")}
        remarks.append(Remark("good", "job.better_slower", {**details, **times}))
    if changed == text:
        return BetterJob("", (Remark("good", "job.better_same", {}),))
    return BetterJob(changed, tuple(remarks))


def _slower(job: Job, text: str, robot: Robot, found: LogComparison, replan: Replan) -> tuple[str, float, float] | None:
    """The quickest of the slower jobs with which the arm, as it drove, reaches all targets; share and cycle of it."""
    for share in SHARES:
        changed = _with_share(job, text, robot, share)
        planned = replan(changed)
        if planned is not None and not missed_targets(*planned, *_predict_tracking(planned[1], found)):
            return changed, share, planned[1].cycle
    return None


def _with_share(job: Job, text: str, robot: Robot, share: float) -> str:
    """The job with a share of its limits: those of the description, and those that are assumed."""
    units = np.where(robot.mechanism.angular, angle_unit(job), length_unit(job))
    for name, scale in (("velocity", "speed_scale"), ("acceleration", "acceleration_scale")):
        text = with_key(text, "limits", scale, f"{share * getattr(job.limits, scale):.6g}")
        own = getattr(robot.limits, name)
        if not (np.isfinite(own) & (own > 0.0)).all():
            assumed = share * assumed_limits(job, robot, name) / units
            text = with_key(text, "limits", name, f"[{', '.join(f'{value:.6g}' for value in assumed)}]")
    return text


def _predict_tracking(plan: Plan, found: LogComparison) -> tuple[Floats, Floats]:
    """Times (k,) and coordinates (k, n) of the arm on a plan, late, yielding and displaced as in the log."""
    t = np.unique(np.concatenate([np.arange(0.0, plan.duration, 4e-3), plan.starts]))
    at = {shift: positions(plan, np.clip(t + shift, 0.0, plan.duration)) for shift in (-STEP, 0.0, STEP)}
    q = np.stack([positions(plan, np.maximum(t - late, 0.0))[:, k] for k, late in enumerate(found.lags)], axis=1)
    q += found.zeros
    if found.compliances.any():
        rates = (at[STEP] - at[-STEP]) / (2.0 * STEP), (at[STEP] - 2.0 * at[0.0] + at[-STEP]) / STEP**2
        q -= found.compliances * model_efforts(plan, t, (at[0.0], *rates))[0]
    return t, q


def _with_load(job: Job, text: str, found: LogComparison, remarks: list[Remark]) -> str:
    """The tool heavier by the identified load at the TCP; the same where the job has other tools."""
    tool, mass = job.tool, job.tool.mass + found.payload
    if job.tools or mass <= 0.0:
        return text
    at = np.zeros(3) if tool.offset is None else np.asarray(tool.offset.position)
    com = (tool.mass * np.asarray(tool.com) + found.payload * at) / mass / length_unit(job)
    remarks.append(Remark("good", "job.better_load", {"mass": quantity(mass, "kg")}))
    values = ", ".join(f"{value:.6g}" for value in com)
    return with_key(with_key(text, "tool", "com", f"[{values}]"), "tool", "mass", f"{mass:.6g}")


def with_key(text: str, table: str, key: str, value: str) -> str:
    """A job file with another value of a key of one of its tables, which is added where it is missing.

    Args:
        text: of the file.
        table, key: of the value.
        value: as it stands in the file, on one line.
    """
    head = re.search(HEADER.format(table=re.escape(table)), text)
    if head is None:
        return f"{text.rstrip()}\n\n[{table}]\n{key} = {value}\n"
    end = re.compile(r"(?m)^\s*\[").search(text, head.end())
    body = text[head.end() : len(text) if end is None else end.start()]
    body, count = re.subn(rf"(?m)^(\s*{re.escape(key)}\s*=)[^\n#]*", rf"\g<1> {value}", body, count=1)
    body = body if count else f"{key} = {value}\n{body}"
    return text[: head.end()] + body + ("" if end is None else text[end.start() :])
