"""Whether the arm was where a move ends when it ended, and kept on the way what the move was to keep, as recorded."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, TypeAlias

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.geometry import rotation
from mafsil.job.driving.run import Run
from mafsil.job.language.description import Job, Task
from mafsil.job.language.units import Tolerances, tolerances
from mafsil.job.planning.plan import Leg, Plan
from mafsil.job.remark import Remark, Where
from mafsil.planning.kept_planning import Measured
from mafsil.simulation import Recording

INSTANT = 1e-9
"""Times closer than this are the same [s]."""
Goal: TypeAlias = Literal["pose", "joints", "pick", "place"]


@dataclass(frozen=True, eq=False, slots=True)
class Arrival:
    """Where the arm was at the end of a leg that has a target.

    Attributes:
        leg: index in the plan.
        goal: what is judged: the tip for `pose`, `pick` and `place` (its planned pose), coordinates for `joints`.
        time: end of the leg [s].
        q: (n,) configuration at that time [rad | m].
        position_error, orientation_error: of the tip, as far as its target names them [m, rad].
        joint_errors: (n,) magnitudes [rad | m].
        tolerances: what is allowed.
    """

    leg: int
    goal: Goal
    time: float
    q: JointVector
    position_error: float
    orientation_error: float
    joint_errors: Floats
    tolerances: Tolerances

    @property
    def share(self) -> float:
        """The largest of the judged errors over its tolerance: at most 1 where the target is reached."""
        if self.goal == "joints":
            return float((self.joint_errors / self.tolerances.joints).max())
        allowed = self.tolerances
        return max(self.position_error / allowed.position, self.orientation_error / allowed.orientation)

    @property
    def reached(self) -> bool:
        """Whether all that the target names is within its tolerance; never with NaN."""
        return self.share <= 1.0


def goal_of(leg: Leg) -> Goal | None:
    """What is judged at the end of a leg; None where it goes nowhere."""
    if leg.target is not None:
        return "pose"
    kinds: dict[str, Goal] = {"joint": "joints", "blended": "joints", "line": "pose", "pick": "pick", "place": "place"}
    return kinds.get(leg.kind)


def arrival(job: Job, plan: Plan, index: int, tape: Recording, start: float = 0.0) -> Arrival | None:
    """The judgement of one leg; None where there is no target, or the recording ends before.

    Args:
        job, plan: what was asked.
        index: of the leg.
        tape: what happened.
        start: when the recording begins, in the time of the plan [s].
    """
    leg, end = plan.legs[index], float(plan.starts[index + 1])
    goal = goal_of(leg)
    if goal is None or not len(tape.t) or end - start > tape.t[-1] + INSTANT:
        return None
    q = configuration(tape, end - start)
    position, turn, joints = errors_of(leg, q)
    return Arrival(
        leg=index,
        goal=goal,
        time=end,
        q=q,
        position_error=float(position),
        orientation_error=float(turn),
        joint_errors=joints,
        tolerances=tolerances(job, leg.load.robot, leg.index),
    )


def errors_of(leg: Leg, q: JointVector) -> tuple[Floats, Floats, Floats]:
    """Where the arm is off the end of a leg: the tip (*batch) [m], (*batch) [rad], and joints (*batch, n) [rad | m].

    Args:
        leg: with a target.
        q: (*batch, n) where the arm is.
    """
    planned = leg.trajectory.at(leg.trajectory.duration).u
    robot = leg.load.robot
    T = np.asarray(robot.forward_kinematics(q))
    T_planned = np.asarray(robot.forward_kinematics(planned)) if leg.target is None else leg.target
    position = np.linalg.norm(T[..., :3, 3] - T_planned[:3, 3], axis=-1)
    return np.asarray(position), _turn(T[..., :3, :3], T_planned[:3, :3], leg.task), np.abs(q - planned)


def _turn(R: Floats, R_planned: Floats, task: Task) -> Floats:
    """How far the tip is turned from what counts: the whole orientation, the direction of its z axis, or nothing."""
    if task == "pose":
        return np.asarray(rotation.angle_between(R, R_planned))
    z, planned = R[..., 2], R_planned[:, 2]
    angle = np.arctan2(np.linalg.norm(np.cross(z, planned), axis=-1), z @ planned)
    return np.asarray(angle if task == "axis" else np.zeros_like(angle))


def arrivals(job: Job, plan: Plan, tape: Recording) -> tuple[Arrival, ...]:
    """The judgements of all legs that have a target and came to their end."""
    found = (arrival(job, plan, k, tape) for k in range(len(plan.legs)))
    return tuple(one for one in found if one is not None)


def configuration(tape: Recording, time: float) -> JointVector:
    """(n,) where the arm was at a time: between two ticks, the cubic that has their positions and rates."""
    last = len(tape.t) - 1
    k = int(np.clip(np.searchsorted(tape.t, time + INSTANT, side="right") - 1, 0, last))
    step = float(tape.t[k + 1] - tape.t[k]) if k < last else 0.0
    u = (time - float(tape.t[k])) / step if step > 0.0 else 0.0
    if u <= 0.0:
        return tape.q[k]
    a, b, va, vb = tape.q[k], tape.q[k + 1], step * tape.qd[k], step * tape.qd[k + 1]
    rise = u * u * (3.0 - 2.0 * u)
    return np.asarray(a + rise * (b - a) + u * (1.0 - u) ** 2 * va + u * u * (u - 1.0) * vb)


def worst_kept(run: Run, leg: int) -> Measured | None:
    """How far the driven arm left what a leg keeps; None of one that keeps nothing, or was never come to.

    Args:
        run: what happened.
        leg: its number.
    """
    way = run.plan.legs[leg].way
    if way is None or way.plan.kept is None or not way.plan.kept.asked or way.plan.checker is None:
        return None
    t, begun, end = run.recording.t, run.plan.starts[leg], run.plan.starts[leg + 1]
    rows = np.flatnonzero((t >= begun) & (t <= end))
    if not len(rows):
        return None
    return Measured(way.plan.kept, way.plan.kept.measures(way.plan.checker, run.recording.q[rows]).max(axis=0))


def keeping_remarks(run: Run) -> list[Remark]:
    """Whether each move kept what it was to keep, measured on the recorded motion."""
    found: list[Remark] = []
    for k, leg in enumerate(run.plan.legs):
        measured = worst_kept(run, k)
        if measured is None:
            continue
        level, key = ("good", "job.kept_driven") if measured.holds else ("failure", "job.constraint_violated")
        found.append(Remark(level, key, {"move": Where(leg.index, run.job.move[leg.index]), "kept": measured}))
    return found
