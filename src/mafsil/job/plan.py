"""Moves of a job into trajectories: goals by inverse kinematics, motion within the limits, a reason for every no."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.errors import JobError
from mafsil.ik import solve_ik
from mafsil.job.description import Grasp, Job, Move
from mafsil.job.poses import pose_matrix
from mafsil.job.remark import Refusal, Refused, Remark
from mafsil.job.resting import resting_place
from mafsil.job.straight import straight_line
from mafsil.messages import say
from mafsil.messages.visible import visible
from mafsil.model import JointKind, JointLimits
from mafsil.robot import Robot
from mafsil.trajectory import Trajectory, check, cubic_through, quintic, rest, trapezoid

QUINTIC_SPEED = 15 / 8
"""Peak speed of a quintic from rest to rest over its mean speed."""
QUINTIC_ACCELERATION = 10 / 3**0.5
"""Peak acceleration of a quintic from rest to rest, times duration^2 over distance."""
TIGHT = 0.02
"""Distance to a position limit, as share of the range, below which a remark is made."""


@dataclass(frozen=True, eq=False, slots=True)
class Leg:
    """One move, planned.

    Attributes:
        index: of the move in the job; -1 for the rest at the end.
        name: in the job, or empty.
        kind: joint, line, pick, place, pause or settle.
        trajectory: of the joints.
        held: what the tool holds while it moves.
        target: (4, 4) pose it ends at, if the job names a pose.
    """

    index: int
    name: str
    kind: str
    trajectory: Trajectory
    held: Grasp | None = None
    target: PoseMatrix | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Plan:
    """All moves, one after the other, each starting at rest where the one before ends."""

    start: JointVector
    legs: tuple[Leg, ...]
    remarks: tuple[Remark, ...]

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return float(sum(leg.trajectory.duration for leg in self.legs))

    @property
    def starts(self) -> Floats:
        """(legs + 1,) beginning of each leg, and the end [s]."""
        return np.concatenate([[0.0], np.cumsum([leg.trajectory.duration for leg in self.legs])])


def plan(job: Job, robot: Robot, progress: Callable[[float], None] = lambda share: None) -> Plan | Refusal:
    """The motion that a job asks for, or why there is none.

    Args:
        job: the job.
        robot: with its tool.
        progress: told the share of moves done.

    Raises:
        JobError: a number of the job does not fit the robot.
    """
    planner = _Planner(job, robot)
    try:
        planner.walk(progress)
    except Refused as no:
        return no.refusal
    return Plan(planner.origin, tuple(planner.legs), tuple(planner.remarks))


def label(index: int, move: Move, language: str | None = None) -> str:
    """`move 3 'lift'`: how errors call a move."""
    if move.name:
        return say("job.move_named", language=language, number=index + 1, name=visible(move.name))
    return say("job.move", language=language, number=index + 1)


class _Planner:
    """Walks through the moves, remembering where the robot is and what it holds."""

    def __init__(self, job: Job, robot: Robot) -> None:
        self.job = job
        self.robot = robot
        self.degrees = job.angles == "degrees"
        self.limits, self.remarks = _driving_limits(job, robot)
        self.legs: list[Leg] = []
        self.held: Grasp | None = None
        self.q: JointVector = np.zeros(robot.n)
        self.origin = self.q

    def walk(self, progress: Callable[[float], None]) -> None:
        """The start, all moves, the rest at the end."""
        job = self.job
        self.start()
        for k, move in enumerate(job.move):
            progress(k / len(job.move))
            self.add(k, move)
        if job.simulation.settle > 0.0:
            self.append(-1, "", "settle", rest(self.q, job.simulation.settle))

    def start(self) -> None:
        """Where the robot begins."""
        given = self.job.start
        if given.joints is not None:
            self.q = self.coordinates(given.joints, say("job.start"), "start.joints")
        else:
            self.q = resting_place(self.robot.limits)
            if given.pose is not None:
                self.q = self.solved(pose_matrix(given.pose, degrees=self.degrees), say("job.start"))
        self.origin = self.q

    def add(self, index: int, move: Move) -> None:
        """Plan one move and append it."""
        name = visible(move.name)
        where = label(index, move)
        if move.pause is not None:
            self.append(index, name, "pause", rest(self.q, move.pause))
        elif move.pick is not None:
            self.pick(index, name, where, move)
        elif move.place:
            self.place(index, name, where, move)
        else:
            self.travel(index, name, where, move)

    def pick(self, index: int, name: str, where: str, move: Move) -> None:
        if self.held is not None:
            raise JobError("job.already_held", move=where, held=visible(self.held.name))
        self.append(index, name, "pick", rest(self.q, self.on_tick(move.hold)))
        self.held = move.pick

    def place(self, index: int, name: str, where: str, move: Move) -> None:
        if self.held is None:
            raise JobError("job.nothing_held", move=where)
        self.append(index, name, "place", rest(self.q, self.on_tick(move.hold)))
        self.held = None

    def on_tick(self, hold: float) -> float:
        """A rest at least this long that ends on a tick of the controller: there the load of the tool changes [s]."""
        rate, step = self.job.controller.rate, self.job.simulation.step
        period = step if rate is None else 1.0 / rate
        past = sum(leg.trajectory.duration for leg in self.legs)
        return float(np.ceil((past + max(hold, period)) / period - 1e-9) * period - past)

    def travel(self, index: int, name: str, where: str, move: Move) -> None:
        """A joint motion or a straight line."""
        target = None
        if move.pose is not None:
            here = np.asarray(self.robot.forward_kinematics(self.q))
            target = pose_matrix(move.pose, degrees=self.degrees, orientation=here[:3, :3])
        if target is not None and move.path == "line":
            trajectory = straight_line(self.robot, self.q, target, self.job.limits, move, self.scaled(move), where)
        else:
            goal = (
                self.coordinates(move.joints or (), where, "joints") if target is None else self.solved(target, where)
            )
            trajectory = self.joint_motion(move, goal, where)
        self.append(index, name, move.path, trajectory, target)
        self.judge(trajectory, where)

    def append(
        self, index: int, name: str, kind: str, trajectory: Trajectory, target: PoseMatrix | None = None
    ) -> None:
        self.legs.append(Leg(index, name, kind, trajectory, self.held, target))
        self.q = trajectory.at(trajectory.duration).u

    def joint_motion(self, move: Move, goal: JointVector, where: str) -> Trajectory:
        """From here to the goal, all joints together."""
        limits = self.scaled(move)
        if move.via:
            points = [self.q, *(self.coordinates(via, where, "via") for via in move.via), goal]
            return self.held_to(_through(_without_repeats(np.array(points)), limits), move, limits, where)
        if move.profile == "trapezoid":
            outcome = trapezoid(
                self.q, goal, velocity=limits.velocity, acceleration=limits.acceleration, duration=move.duration
            )
            if not outcome.succeeded:
                raise Refused("job.no_path", move=where, reason=outcome)
            return outcome.value if outcome.value.duration > 0.0 else rest(self.q, 1e-3)
        shortest = max(quintic_duration(goal - self.q, limits.velocity, limits.acceleration), 1e-3)
        return self.held_to(quintic(self.q, goal, move.duration or shortest), move, limits, where)

    def held_to(self, trajectory: Trajectory, move: Move, limits: JointLimits, where: str) -> Trajectory:
        """The trajectory, if a duration that the job insists on keeps the limits."""
        verdict = check(trajectory, limits, self.robot.joint_names, tolerance=1e-6)
        if not verdict.ok:
            raise Refused("job.no_path", move=where, reason=verdict.violations[0])
        return trajectory

    def solved(self, target: PoseMatrix, where: str) -> JointVector:
        """Joint coordinates that reach a pose, near the present ones."""
        answer = solve_ik(self.robot, target, self.q)
        if not answer.all_solved:
            raise Refused("job.unreachable", move=where, reason=answer)
        return np.asarray(answer.q)

    def coordinates(self, values: tuple[float, ...], where: str, name: str) -> JointVector:
        """Coordinates of the job in radians, within the limits."""
        robot = self.robot
        if len(values) != robot.n:
            joints = ", ".join(visible(joint) for joint in robot.joint_names)
            facts = {"move": where, "name": name, "robot": visible(robot.name), "joints": joints}
            raise JobError("job.joint_count", **facts, expected=robot.n, got=len(values))
        q = np.array(values, dtype=np.float64)
        if self.degrees:
            turning = [joint.kind is not JointKind.PRISMATIC for joint in robot.mechanism.coordinates]
            q = np.where(turning, np.radians(q), q)
        for joint, x, low, high in zip(robot.joint_names, q, robot.limits.lower, robot.limits.upper, strict=True):
            # A limit typed in degrees is a limit kept, whatever its last digit.
            if not low - 1e-9 <= x <= high + 1e-9:
                raise JobError("job.outside_limits", move=where, joint=visible(joint), value=x, lower=low, upper=high)
        return q

    def scaled(self, move: Move) -> JointLimits:
        """The limits for one move: slower if it says so."""
        return replace(
            self.limits,
            velocity=self.limits.velocity * move.speed,
            acceleration=self.limits.acceleration * move.speed**2,
        )

    def judge(self, trajectory: Trajectory, where: str) -> None:
        """Remark on joints that come close to a position limit."""
        q = trajectory.at(np.linspace(0.0, trajectory.duration, 200)).u
        lower, upper = self.robot.limits.lower, self.robot.limits.upper
        for k, joint in enumerate(self.robot.joint_names):
            span = upper[k] - lower[k]
            if not np.isfinite(span) or span <= 0.0:
                continue
            for side, gap in (("lower", q[:, k].min() - lower[k]), ("upper", upper[k] - q[:, k].max())):
                if gap < TIGHT * span:
                    facts = {"move": where, "joint": visible(joint), "share": 100 * max(gap / span, 0.0)}
                    self.remarks.append(Remark("warning", "job.tight_limit", {**facts, "side": f"@job.{side}"}))


def quintic_duration(distance: Floats, velocity: Floats, acceleration: Floats) -> float:
    """Shortest duration of a quintic from rest to rest of all joints [s].

    Args:
        distance: (n,) to go [rad | m].
        velocity, acceleration: (n,) largest magnitudes.
    """
    way = np.abs(distance)
    each = np.maximum(QUINTIC_SPEED * way / velocity, np.sqrt(QUINTIC_ACCELERATION * way / acceleration))
    # The peak equals the limit only up to rounding: stay a hair below it.
    return float(each.max(initial=0.0)) * (1 + 1e-9)


def _without_repeats(points: Floats) -> Floats:
    """Points (k, n) less those that do not differ from the one before; two are always left."""
    moved = np.abs(np.diff(points, axis=0)).max(axis=1) > 1e-12
    kept = points[np.concatenate([[True], moved])]
    return kept if len(kept) > 1 else points[:2]


def _through(points: Floats, limits: JointLimits) -> Trajectory:
    """A smooth curve through points, stretched until it keeps the limits."""
    steps = np.diff(points, axis=0)
    durations = [max(quintic_duration(step, limits.velocity, limits.acceleration), 1e-3) for step in steps]
    curve = cubic_through(points, durations)
    t = np.linspace(0.0, curve.duration, 2000)
    motion = curve.at(t)
    fast = (np.abs(motion.v) / limits.velocity).max()
    hard = np.sqrt((np.abs(motion.a) / limits.acceleration).max())
    stretch = float(max(fast, hard)) * 1.001
    return curve.stretched(stretch) if stretch > 0.0 else curve


def _driving_limits(job: Job, robot: Robot) -> tuple[JointLimits, list[Remark]]:
    """Limits as the job wants them, finite wherever motion needs them, with a remark on what was assumed."""
    own, bounds = robot.limits, job.limits
    remarks: list[Remark] = []
    values: dict[str, Floats] = {}
    for name, share in (("velocity", bounds.speed_share), ("acceleration", bounds.acceleration_share)):
        known: Floats = getattr(own, name)
        assumed = ~(np.isfinite(known) & (known > 0.0))
        values[name] = np.where(assumed, getattr(bounds, name), np.where(assumed, 1.0, known) * share)
        if assumed.any():
            facts = {"joints": _listed(robot, assumed), "value": getattr(bounds, name)}
            remarks.append(Remark("good", f"job.{name}_assumed", facts))
    if not np.isfinite(own.effort).all():
        remarks.append(Remark("good", "job.effort_unknown", {"joints": _listed(robot, ~np.isfinite(own.effort))}))
    return replace(own, **values, jerk=np.full(robot.n, np.inf)), remarks


def _listed(robot: Robot, chosen: NDArray[np.bool_]) -> str:
    names = [visible(name) for name, yes in zip(robot.joint_names, chosen, strict=True) if yes]
    return ", ".join(names) if len(names) < robot.n else "@job.all_joints"
