"""The numbers that sum up a run, and what in them deserves a remark."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.job.plan import Plan
from mafsil.job.remark import Remark
from mafsil.job.run import Run
from mafsil.messages.visible import visible
from mafsil.model import JointLimits

NEAR_EFFORT, NEAR_SPEED = 0.9, 1.0
"""Shares of a limit from which on a remark is made."""
LARGE_ERROR = 5e-3
"""Distance of the tip from its path from which on a remark is made [m]."""


@dataclass(frozen=True, eq=False, slots=True)
class Summary:
    """Numbers of a run; arrays are (n,), one entry per joint.

    Attributes:
        duration: of the run [s].
        cycle: until the last move ends, without the rest after it [s].
        joint_error: largest deviation of each joint [rad | m].
        tip_error, tip_error_time: largest distance of the tip from its path [m], and when [s].
        final_errors: distance of the tip from the target of each leg that has one, at its end [m].
        peak_effort, peak_effort_time: largest effort [N m | N], and when [s].
        rms_effort: root mean square.
        peak_speed, peak_speed_time: [rad/s | m/s], and when [s].
        lowest, highest: range of motion [rad | m].
        energy: mechanical work put in by the joints, braking not recovered [J].
        saturated: time during which the law asked for more than the limit [s].
        excess_share: largest demand over the limit; 0 where there is no limit.
    """

    duration: float
    cycle: float
    joint_error: Floats
    tip_error: float
    tip_error_time: float
    final_errors: Floats
    peak_effort: Floats
    peak_effort_time: Floats
    rms_effort: Floats
    peak_speed: Floats
    peak_speed_time: Floats
    lowest: Floats
    highest: Floats
    energy: float
    saturated: Floats
    excess_share: Floats


def summary(run: Run) -> Summary:
    """The numbers of a run."""
    tape, limit = run.recording, run.robot.limits.effort
    t = tape.t
    step = np.diff(t, prepend=t[0])
    actual, wanted = run.tips()
    astray = np.linalg.norm(actual[:, :3, 3] - wanted[:, :3, 3], axis=1)
    power = np.maximum(tape.tau * tape.qd, 0.0).sum(axis=1)
    demand = np.where(np.isfinite(limit), np.abs(tape.tau_commanded) / np.where(limit > 0, limit, 1.0), 0.0)
    settled = [leg.kind == "settle" for leg in run.plan.legs]
    rest = run.plan.legs[-1].trajectory.duration if settled and settled[-1] else 0.0
    peak, speed = np.abs(tape.tau).argmax(axis=0), np.abs(tape.qd).argmax(axis=0)
    return Summary(
        duration=float(t[-1]),
        cycle=min(run.plan.duration - rest, float(t[-1])),
        joint_error=np.abs(tape.q - tape.q_ref).max(axis=0),
        tip_error=float(astray.max()),
        tip_error_time=float(t[astray.argmax()]),
        final_errors=_final_errors(run.plan, t, actual),
        peak_effort=np.abs(tape.tau).max(axis=0),
        peak_effort_time=t[peak],
        rms_effort=np.sqrt((tape.tau**2).mean(axis=0)),
        peak_speed=np.abs(tape.qd).max(axis=0),
        peak_speed_time=t[speed],
        lowest=tape.q.min(axis=0),
        highest=tape.q.max(axis=0),
        energy=float((power * step).sum()),
        saturated=((demand > 1.0 + 1e-9) * step[:, None]).sum(axis=0),
        excess_share=demand.max(axis=0),
    )


def remarks(run: Run, numbers: Summary) -> tuple[Remark, ...]:
    """What the reader should know, the worst first."""
    found = [] if run.stopped is None else [run.stopped]
    found += _effort_remarks(run, numbers) + _motion_remarks(run, numbers)
    found += [remark for remark in run.plan.remarks if remark.level != "good"]
    found += _late_pushes(run, numbers)
    if run.stopped is None and len(numbers.final_errors):
        facts = {"count": len(numbers.final_errors), "error": 1e3 * float(numbers.final_errors.max())}
        found.append(Remark("good", "job.all_reached", facts))
    return (*found, *(remark for remark in run.plan.remarks if remark.level == "good"))


def _effort_remarks(run: Run, numbers: Summary) -> list[Remark]:
    found: list[Remark] = []
    for k, joint in enumerate(map(visible, run.robot.joint_names)):
        share = 100 * float(numbers.excess_share[k])
        if numbers.saturated[k] > 0.0:
            facts = {"joint": joint, "time": float(numbers.saturated[k]), "share": share}
            found.append(Remark("failure", "job.at_saturation", facts))
        elif share > 100 * NEAR_EFFORT:
            facts = {"joint": joint, "time": float(numbers.peak_effort_time[k]), "share": share}
            found.append(Remark("warning", "job.near_saturation", facts))
    return found


def _motion_remarks(run: Run, numbers: Summary) -> list[Remark]:
    """Joints beyond their range or speed, a tip that strays."""
    found: list[Remark] = []
    limits: JointLimits = run.robot.limits
    tape = run.recording
    for k, joint in enumerate(map(visible, run.robot.joint_names)):
        beyond = np.maximum(limits.lower[k] - tape.q[:, k], tape.q[:, k] - limits.upper[k])
        if beyond.max() > 1e-9:
            facts = {"joint": joint, "excess": float(beyond.max()), "time": float(tape.t[beyond.argmax()])}
            found.append(Remark("failure", "job.limit_crossed", facts))
        share = float(numbers.peak_speed[k] / limits.velocity[k]) if limits.velocity[k] > 0 else 0.0
        if share > NEAR_SPEED:
            facts = {"joint": joint, "share": 100 * share, "time": float(numbers.peak_speed_time[k])}
            found.append(Remark("warning", "job.speed_crossed", facts))
    if numbers.tip_error > LARGE_ERROR:
        facts = {"error": 1e3 * numbers.tip_error, "time": numbers.tip_error_time}
        found.append(Remark("warning", "job.large_error", facts))
    return found


def _late_pushes(run: Run, numbers: Summary) -> list[Remark]:
    late = [push for push in run.job.disturbance if push.start >= numbers.duration]
    return [Remark("warning", "job.late_disturbance", {"start": push.start, "end": numbers.duration}) for push in late]


def _final_errors(plan: Plan, t: Floats, actual: PoseMatrix) -> Floats:
    """Distance from each target, at the end of the leg that leads there [m]."""
    errors: list[float] = []
    for leg, end in zip(plan.legs, plan.starts[1:], strict=True):
        row = min(int(np.searchsorted(t, end)), len(t) - 1)
        if leg.target is not None and end <= t[-1] + 1e-9:
            errors.append(float(np.linalg.norm(actual[row, :3, 3] - leg.target[:3, 3])))
    return np.array(errors)
