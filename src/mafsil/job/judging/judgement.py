"""The numbers that sum up a run, and what in them deserves a remark: every word computed from the recording."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats
from mafsil.control.laws import JointFeedback
from mafsil.job.driving.arrival import INSTANT, Arrival, arrivals, goal_of, keeping_remarks
from mafsil.job.driving.run import Run
from mafsil.job.judging.causes import Cause
from mafsil.job.judging.clearances import (
    Clearances,
    Touching,
    brief_contact_remarks,
    clearance_remarks,
    clearances,
    contact_remarks,
    rigid_remarks,
    touching,
    touching_remarks,
)
from mafsil.job.judging.holding import overload_remarks, overloads
from mafsil.job.judging.law_conditions import parts_of
from mafsil.job.judging.symptoms import (
    BROKEN,
    MOST_FAILURES,
    EndedEarly,
    GivenWay,
    LimitBroken,
    Symptom,
    beyond_plan,
    gave_way,
    joint_quantity,
    missed_by,
)
from mafsil.job.language.description import Job
from mafsil.job.language.units import tolerances
from mafsil.job.planning.limiting import would_save
from mafsil.job.planning.plan import Plan
from mafsil.job.remark import Level, Remark, Where
from mafsil.messages.quantities import digits, quantity
from mafsil.messages.visible import visible
from mafsil.model import JointLimits
from mafsil.model.limits import MEASURED
from mafsil.simulation.findings import alternating_efforts

NEAR_EFFORT = 0.9
"""Share of the effort limit from which on a remark is made."""
TOUCHED = 1.0 + 1e-9
"""Share of a limit up to which it is kept, whatever rounding does."""
LARGE_ERROR = 5e-3
"""Distance of the tip from its path from which on a remark is made [m]."""
REMAINING = 0.25
"""Share of a tolerance from which on a remaining error is named."""
Causes: TypeAlias = Mapping[Symptom, Cause]
"""Of what went wrong in a run."""


@dataclass(frozen=True, eq=False, slots=True)
class Summary:
    """Numbers of a run; arrays are (n,), one entry per joint.

    Attributes:
        duration: of the run [s].
        cycle: until the last move ends, without the rest after it [s].
        joint_error: largest deviation of each joint [rad | m].
        tip_error, tip_error_time: largest distance of the tip from its path [m], and when [s].
        tip_turn, tip_turn_time: largest angle between the tip and its planned orientation [rad], and when [s].
        arrivals: of each leg that has a target and came to its end.
        targets: how many legs have one.
        peak_effort, peak_effort_time: largest effort [N m | N], and when [s].
        rms_effort: root mean square.
        peak_speed, peak_speed_time: [rad/s | m/s], and when [s].
        peak_acceleration, peak_acceleration_time: [rad/s^2 | m/s^2], and when [s].
        lowest, highest: range of motion [rad | m].
        energy: mechanical work put in by the joints, braking not recovered [J].
        saturated: time during which the law asked for more than the limit [s].
        excess_share: largest demand over the limit; 0 where there is no limit.
        clearances: how near the arm came to things; None where the job names none.
        touching: what it pressed on; None where the job names no surface.
    """

    duration: float
    cycle: float
    joint_error: Floats
    tip_error: float
    tip_error_time: float
    tip_turn: float
    tip_turn_time: float
    arrivals: tuple[Arrival, ...]
    targets: int
    peak_effort: Floats
    peak_effort_time: Floats
    rms_effort: Floats
    peak_speed: Floats
    peak_speed_time: Floats
    peak_acceleration: Floats
    peak_acceleration_time: Floats
    lowest: Floats
    highest: Floats
    energy: float
    saturated: Floats
    excess_share: Floats
    clearances: Clearances | None = None
    touching: Touching | None = None

    @property
    def not_reached(self) -> tuple[Arrival, ...]:
        """Targets that were not reached when their moves ended."""
        return tuple(one for one in self.arrivals if not one.reached)


def summary(run: Run) -> Summary:
    """The numbers of a run."""
    tape, limit = run.recording, run.robot.limits.effort
    t = tape.t
    step = np.diff(t, prepend=t[0])
    # The effort of a tick acts until the next one; that of the last tick counts as long as the one before.
    interval = np.append(step[1:], step[-1])
    astray, turned = tape.tip_position_error, tape.tip_rotation_error
    power = np.maximum(tape.tau * tape.qd, 0.0).sum(axis=1)
    demand = np.where(np.isfinite(limit), np.abs(tape.tau_commanded) / np.where(limit > 0, limit, 1.0), 0.0)
    peak, speed, hardest = (np.abs(x).argmax(axis=0) for x in (tape.tau, tape.qd, tape.qdd))
    return Summary(
        duration=float(t[-1]),
        cycle=min(run.plan.cycle, float(t[-1])),
        joint_error=np.abs(tape.q - tape.q_ref).max(axis=0),
        tip_error=float(astray.max()),
        tip_error_time=float(t[astray.argmax()]),
        tip_turn=float(turned.max()),
        tip_turn_time=float(t[turned.argmax()]),
        arrivals=arrivals(run.job, run.plan, tape),
        targets=targets(run.plan),
        peak_effort=np.abs(tape.tau).max(axis=0),
        peak_effort_time=t[peak],
        rms_effort=np.sqrt((tape.tau**2).mean(axis=0)),
        peak_speed=np.abs(tape.qd).max(axis=0),
        peak_speed_time=t[speed],
        peak_acceleration=np.abs(tape.qdd).max(axis=0),
        peak_acceleration_time=t[hardest],
        lowest=tape.q.min(axis=0),
        highest=tape.q.max(axis=0),
        energy=float((power * step).sum()),
        saturated=((demand > TOUCHED) * interval[:, None]).sum(axis=0),
        excess_share=demand.max(axis=0),
        clearances=clearances(run),
        touching=touching(run),
    )


def judge_run(run: Run, numbers: Summary, causes: Causes | None = None) -> tuple[Remark, ...]:
    """What the reader should know, the worst first.

    Args:
        run: what happened.
        numbers: of it.
        causes: of what went wrong, as far as they were looked for.
    """
    known: Causes = {} if causes is None else causes
    found = [] if run.stopped is None else [_explain(run.stopped, known, EndedEarly)]
    collapse = [_explain(remark, known, GivenWay) for remark in _collapse(run)]
    found += collapse + _failure_remarks(run, numbers, known) + overload_remarks(overloads(run), run.robot)
    near = clearance_remarks(numbers.clearances, 0.0 if run.job.controller.guides else numbers.tip_error)
    kept = keeping_remarks(run)
    found += [*_bad(near), *_bad(kept)]
    rigid = rigid_remarks(run)
    pressed = [*touching_remarks(numbers.touching, struck=bool(rigid)), *rigid]
    pressed += [*brief_contact_remarks(run), *contact_remarks(run)]
    found += [*_bad(pressed), *_effort_remarks(run, numbers), *_alternating_remarks(run)]
    # Limits that an arm breaks while it falls are no news of their own.
    found += [] if collapse else [*_limit_remarks(run, numbers, known), *_gravity_remarks(run, numbers)]
    found += _stray_remarks(run, numbers) + _guided_remarks(run)
    found += [*_bad(run.plan.remarks), *late_pushes(run.job, numbers.duration), *_kept_parts(run)]
    found.sort(key=lambda remark: remark.level != "failure")
    saving = would_save(run.robot, run.limits, numbers.cycle)
    good = (*_good_news(run, numbers), *_good(near), *_good(kept), *_good(pressed), *saving, *_good(run.plan.remarks))
    return (*found, *good)


def _bad(remarks: Iterable[Remark]) -> list[Remark]:
    return [remark for remark in remarks if remark.level != "good"]


def _good(remarks: Iterable[Remark]) -> list[Remark]:
    return [remark for remark in remarks if remark.level == "good"]


def targets(plan: Plan) -> int:
    """How many legs of a plan have a target."""
    return sum(goal_of(leg) is not None for leg in plan.legs)


def not_reached(found: tuple[Remark, ...]) -> int:
    """How many targets were not reached, by the remarks of a run."""
    single = sum(remark.key.startswith("job.not_reached_") for remark in found)
    return single + sum(int(str(remark.details["count"])) for remark in found if remark.key == "job.more_not_reached")


def where(run: Run, leg: int) -> Where:
    """How remarks call the move of a leg."""
    index = run.plan.legs[leg].index
    return Where(index, run.job.move[index])


def error_details(run: Run, judged: Arrival) -> dict[str, object]:
    """How far off an arrival was, for sentences: the tip for poses, the worst joint for joint goals."""
    joint = int((judged.joint_errors / judged.tolerances.joints).argmax())
    return {
        "position": quantity(judged.position_error, "m"),
        "angle": quantity(judged.orientation_error, "rad"),
        "allowed_position": quantity(judged.tolerances.position, "m"),
        "allowed_angle": quantity(judged.tolerances.orientation, "rad"),
        "joint": visible(run.robot.joint_names[joint]),
        "error": joint_quantity(run, joint, float(judged.joint_errors[joint])),
        "allowed": joint_quantity(run, joint, float(judged.tolerances.joints[joint])),
    }


def _explain(remark: Remark, causes: Causes, kind: type) -> Remark:
    """A remark with its cause, where that was found."""
    return replace(remark, cause=next((cause for one, cause in causes.items() if isinstance(one, kind)), None))


def _failure_remarks(run: Run, numbers: Summary, causes: Causes) -> list[Remark]:
    """Every target that was not reached, by how much and why; a part that was not gripped."""
    found: list[Remark] = []
    for judged in numbers.not_reached[:MOST_FAILURES]:
        details = {"move": where(run, judged.leg), **error_details(run, judged)}
        found.append(Remark("failure", f"job.not_reached_{judged.goal}", details, causes.get(missed_by(judged))))
    if len(numbers.not_reached) > MOST_FAILURES:
        found.append(Remark("failure", "job.more_not_reached", {"count": len(numbers.not_reached) - MOST_FAILURES}))
    return found


def _collapse(run: Run) -> list[Remark]:
    """The joint that is farthest beyond everything planned, if the arm has given way."""
    fallen = gave_way(run)
    if fallen is None:
        return []
    joint, begin = fallen
    details = {
        "joint": visible(run.robot.joint_names[joint]),
        "excess": joint_quantity(run, joint, float(beyond_plan(run)[joint])),
        "time": quantity(begin, "s"),
    }
    return [Remark("failure", "job.gives_way", details)]


def _guided_remarks(run: Run) -> list[Remark]:
    """How far the arm was led away, where nothing pulls it back."""
    if not run.job.controller.guides:
        return []
    tips, planned = run.tips()
    way = np.linalg.norm((tips - planned)[:, :3, 3], axis=1).max()
    return [Remark("good", "job.guided", {"way": quantity(float(way), "m")})]


def _effort_remarks(run: Run, numbers: Summary) -> list[Remark]:
    """Joints at their effort limits: a failure where a target was not reached, a warning where all were reached."""
    found: list[Remark] = []
    level: Level = "failure" if numbers.not_reached or run.stopped is not None else "warning"
    for k, joint in enumerate(map(visible, run.robot.joint_names)):
        share = float(numbers.excess_share[k])
        details = {"joint": joint, "share": quantity(share, "share")}
        if numbers.saturated[k] > 0.0:
            time = quantity(float(numbers.saturated[k]), "s")
            found.append(Remark(level, "job.at_saturation", details | {"time": time}))
        elif share > NEAR_EFFORT:
            time = quantity(float(numbers.peak_effort_time[k]), "s")
            found.append(Remark("warning", "job.near_saturation", details | {"time": time}))
    return found


def _alternating_remarks(run: Run) -> list[Remark]:
    """An effort that goes up and down from tick to tick."""
    found = alternating_efforts(run.recording.t, run.recording.tau)
    if found is None:
        return []
    joint, swing, begin, lasted = found
    details = {"joint": visible(run.robot.joint_names[joint]), "step": digits(swing)}
    details |= {"time": quantity(begin, "s"), "lasted": quantity(lasted, "s")}
    return [Remark("warning", "simulation.alternates", details)]


def _limit_remarks(run: Run, numbers: Summary, causes: Causes) -> list[Remark]:
    """Joints beyond their range, speed or acceleration; the worst of each rate with its cause."""
    reasons = {(one.rate, one.joint): reason for one, reason in causes.items() if isinstance(one, LimitBroken)}
    found: list[Remark] = []
    limits: JointLimits = run.robot.limits
    tape = run.recording
    allowed = tolerances(run.job, run.robot).joints
    for k, joint in enumerate(map(visible, run.robot.joint_names)):
        beyond = np.maximum(limits.lower[k] - tape.q[:, k], tape.q[:, k] - limits.upper[k])
        excess = float(beyond.max())
        if excess > MEASURED:
            details = {"joint": joint, "excess": joint_quantity(run, k, excess)}
            level: Level = "failure" if excess > allowed[k] else "warning"
            time = quantity(float(tape.t[beyond.argmax()]), "s")
            found.append(Remark(level, "job.limit_crossed", details | {"time": time}))
        for name, peaks, times, limit, per in (
            ("speed", numbers.peak_speed, numbers.peak_speed_time, limits.velocity, "/s"),
            ("acceleration", numbers.peak_acceleration, numbers.peak_acceleration_time, limits.acceleration, "/s²"),
        ):
            share = float(peaks[k] / limit[k]) if limit[k] > 0 else 0.0
            if share > TOUCHED:
                details = {"joint": joint, "limit": joint_quantity(run, k, float(limit[k]), per)}
                details |= {"over": quantity(share - 1.0, "share"), "time": quantity(float(times[k]), "s")}
                level = "failure" if share > BROKEN else "warning"
                found.append(Remark(level, f"job.{name}_crossed", details, reasons.get((name, k))))
    return found


def _gravity_remarks(run: Run, numbers: Summary) -> list[Remark]:
    """Where a law without a model begins with an empty integral, and gravity alone explains a crossed acceleration."""
    tape, limit = run.recording, run.robot.limits.acceleration
    for driven in run.driven[:1]:  # later stretches go on with the integral
        if not any(isinstance(part, JointFeedback) and part.model is None for part in parts_of(driven.scenario.law)):
            continue
        start = int(np.searchsorted(tape.t, driven.stretch.start - INSTANT))
        begun = np.abs(numbers.peak_acceleration_time - driven.stretch.start) <= INSTANT
        true, q = driven.scenario.true_plant.robot, tape.q[min(start, len(tape.t) - 1)]
        drop = -np.linalg.solve(true.mass_matrix(q), true.gravity_torque(q))
        share = np.where(begun & (limit > 0.0), np.abs(drop) / np.where(limit > 0.0, limit, 1.0), 0.0)
        k = int(share.argmax())
        if share[k] > TOUCHED and numbers.peak_acceleration[k] > limit[k] * TOUCHED:
            amount = joint_quantity(run, k, abs(float(drop[k])), "/s²")
            details = {"joint": visible(run.robot.joint_names[k]), "amount": amount}
            time = quantity(driven.stretch.start, "s")
            return [Remark("warning", "job.empty_integral", details | {"time": time})]
    return []


def _stray_remarks(run: Run, numbers: Summary) -> list[Remark]:
    if numbers.tip_error <= LARGE_ERROR or run.job.controller.guides:
        return []
    details = {"error": quantity(numbers.tip_error, "m"), "time": quantity(numbers.tip_error_time, "s")}
    return [Remark("warning", "job.large_error", details)]


def late_pushes(job: Job, duration: float) -> list[Remark]:
    """Disturbances that begin after the end of the motion [s]."""
    late, end = [push for push in job.disturbance if push.start >= duration], quantity(duration, "s")
    return [
        Remark("warning", "job.late_disturbance", {"start": quantity(push.start, "s"), "end": end}) for push in late
    ]


def _kept_parts(run: Run) -> list[Remark]:
    """A part that the job picks and never places."""
    actions = [move for move in run.job.move if move.place or move.pick is not None]
    kept = actions[-1].pick if actions else None
    return [] if kept is None else [Remark("warning", "job.part_kept", {"part": visible(kept.name)})]


def _good_news(run: Run, numbers: Summary) -> list[Remark]:
    """All targets reached, if they were; what is left of the error."""
    if run.stopped is not None or not numbers.targets or len(numbers.arrivals) < numbers.targets or numbers.not_reached:
        return []
    details = {
        "count": numbers.targets,
        "position": quantity(max(one.position_error for one in numbers.arrivals), "m"),
        "angle": quantity(max(one.orientation_error for one in numbers.arrivals), "rad"),
    }
    found = [Remark("good", "job.all_reached", details)]
    worst = max(numbers.arrivals, key=lambda one: one.share)
    if worst.share > REMAINING:
        rest = {"move": where(run, worst.leg), "share": quantity(worst.share, "share")}
        found.append(Remark("good", "job.remaining", rest))
    return found
