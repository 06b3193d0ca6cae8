"""What a planned job is: its legs, one after the other, how they are timed, what is around them, what went unchecked.

A check that did not run never reads like one that passed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.collision import Checker
from mafsil.collision.pairs import SkipReason
from mafsil.job.language.description import Bounds, Job, Task
from mafsil.job.language.part import SignalValue
from mafsil.job.planning.cell_signals import CellSignals, Decision, decide_fork
from mafsil.job.planning.equipment import Load
from mafsil.job.planning.neighbours import NeighbourMotion
from mafsil.job.planning.placed_parts import PlacedPart
from mafsil.job.planning.surroundings import OFF, Surroundings, WayRound, why_not_itself
from mafsil.job.remark import Remark
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible
from mafsil.model import JointLimits
from mafsil.robot import Robot
from mafsil.trajectory import Trajectory


@dataclass(frozen=True, eq=False, slots=True)
class Leg:
    """One move, planned.

    Attributes:
        index: of the move in the job, the last of several without a stop between; -1 for the rest at the end.
        name: in the job, or empty.
        kind: joint, line, arc, spline, screw, blended, pick, place, tool, pause, set, wait, if or settle.
        trajectory: of the joints.
        load: what hangs on the flange while it moves.
        target: (4, 4) pose it ends at, if the job names a pose.
        task: what of that pose counts.
        timing: what limits it; None of rests.
        clearance: that it keeps [m].
        parts: that were put down before, and stand in the scene meanwhile.
        thing: of a pick: the leg at which its part was taken first; -1 of what is no pick.
        way: how it goes round what stands in its way, if it does.
        decision: which way the job goes from here, and why; None of what is no choice.
        ends: of each move in it, the last one is `index`; times from its beginning [s].
        outputs: times from its beginning at which outputs take values while it is under way, and the values.
        targets: (4, 4) poses at which its moves along paths of the tip end, one after the other.
        goals: (n,) configurations at those ends, where moves of the joints are among them.
        stopped: when contact ended it early; None of what is no search, or found nothing yet [s].
        frame: name of the moving frame on which the arm is at its end.
    """

    index: int
    name: str
    kind: str
    trajectory: Trajectory
    load: Load
    target: PoseMatrix | None = None
    task: Task = "pose"
    timing: Timing | None = None
    clearance: float = 0.0
    way: WayRound | None = None
    decision: Decision | None = None
    parts: tuple[PlacedPart, ...] = ()
    thing: int = -1
    ends: tuple[float, ...] = ()
    outputs: tuple[tuple[float, dict[str, SignalValue]], ...] = ()
    targets: tuple[PoseMatrix, ...] = ()
    goals: tuple[JointVector, ...] = ()
    stopped: float | None = None
    frame: str = ""


@dataclass(frozen=True, eq=False, slots=True)
class Plan:
    """All moves, one after the other, each starting at rest where the one before ends.

    Attributes:
        start: (n,) configuration.
        legs: in order.
        remarks: what the reader should know.
        made: moves of the job that are made; the others are on ways that are not taken.
        surroundings: what the arm may meet; None where the job names nothing.
        neighbours: what other robots do meanwhile.
        signals: between the arm and its cell; None where the job names none.
        kinematic: whether the arm follows it exactly, without masses and forces.
    """

    start: JointVector
    legs: tuple[Leg, ...]
    remarks: tuple[Remark, ...]
    made: int = 0
    surroundings: Surroundings | None = None
    neighbours: tuple[NeighbourMotion, ...] = ()
    signals: CellSignals | None = None
    kinematic: bool = False

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return float(sum(leg.trajectory.duration for leg in self.legs))

    @property
    def cycle(self) -> float:
        """Until the last move ends, without the rest after it [s]."""
        moves = self.legs[:-1] if self.legs and self.legs[-1].kind == "settle" else self.legs
        return float(sum(leg.trajectory.duration for leg in moves))

    def lasting(self, durations: Floats) -> float:
        """How long it takes if its legs take other times: waits end when their signals come [s].

        NaN where one never comes, where the job would go another way, or where other robots set signals at other times.

        Args:
            durations: (legs,) of its legs, those of waits aside [s].
        """
        if any(leg.frame for leg in self.legs):
            return float("nan")
        if not any(leg.kind in ("wait", "if") for leg in self.legs) or self.signals is None:
            return float(durations.sum())
        if any(step.kind == "set" for each in self.neighbours for step in each.steps):
            return float("nan")
        signals, time = CellSignals(self.signals.job, self.signals.period), 0.0
        for leg, duration in zip(self.legs, durations, strict=True):
            if leg.kind == "wait":
                move = signals.job.move[leg.index]
                end = signals.end_of_wait(time, move.wait, move.timeout)
                if end is None:
                    return float("nan")
                time = end
                continue
            for after, values in leg.outputs:
                signals.put(time + after * float(duration) / leg.trajectory.duration, values)
            time += float(duration)
            if leg.decision is not None:
                again = decide_fork(signals.job, leg.decision.fork, signals, time)
                if again.holds is not leg.decision.holds:
                    return float("nan")
            if leg.kind == "set":
                signals.put(time, signals.job.move[leg.index].set)
        return time

    @property
    def starts(self) -> Floats:
        """(legs + 1,) beginning of each leg, and the end [s]."""
        return np.concatenate([[0.0], np.cumsum([leg.trajectory.duration for leg in self.legs])])

    def legs_at(self, t: Floats) -> NDArray[np.intp]:
        """(k,) index of the leg under way at times (k,); the first and the last also beyond the plan."""
        return np.clip(np.searchsorted(self.starts, t, side="right") - 1, 0, len(self.legs) - 1)

    def tips(self, t: Floats, q: Floats) -> PoseMatrix:
        """(k, 4, 4) poses in {s} of the tip of the tool that is mounted at times (k,), at configurations (k, n)."""
        legs = self.legs_at(t)
        robots = [leg.load.robot for leg in self.legs]
        found = np.empty((len(t), 4, 4))
        for robot in dict.fromkeys(robots):
            rows = np.array([each is robot for each in robots])[legs]
            found[rows] = robot.forward_kinematics(q[rows])
        return found


@dataclass(frozen=True, eq=False, slots=True)
class Timing:
    """What a planned leg keeps, and how to time it again.

    Attributes:
        limits: of the joints, for this move.
        bounds: of the job.
        speed: share of the tip's bounds; None where they do not count.
        again: the duration of the leg with other limits and bounds [s]; raises Refused where there is no motion.
    """

    limits: JointLimits
    bounds: Bounds
    speed: float | None
    again: Callable[[JointLimits, Bounds], float]


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
