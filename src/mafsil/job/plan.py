"""Moves of a job into trajectories: goals by inverse kinematics, motion within the limits, a reason for every no."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import msgspec
import numpy as np

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.collision import Contact
from mafsil.job.called import Where
from mafsil.job.closed_moves import ClosedMoves
from mafsil.job.description import QUICKEST, TIP_PATHS, Bounds, BranchChoice, Goal, Job, Move, Task
from mafsil.job.equipment import Equipment, Load
from mafsil.job.fitting import coordinates, unit_remarks
from mafsil.job.goals import FIXES, Goals
from mafsil.job.joint_motion import JointMove, joint_motion, motion_on_path
from mafsil.job.lines import Places
from mafsil.job.neighbours import Neighbour, NeighbourMotion
from mafsil.job.planned_remarks import SLOW, decided_by, driving_limits, near_limits, nearly_met, slowed
from mafsil.job.poses import goal_matrix, pose_matrix
from mafsil.job.remark import Refusal, Refused, Remark
from mafsil.job.resting import starting_place
from mafsil.job.surroundings import RESTS, Surroundings, said_of
from mafsil.job.timing import Timing
from mafsil.job.tip_motion import TipMotion, motion_along, tip_motion
from mafsil.job.tip_paths import path_or_refusal
from mafsil.job.tolerance import tolerances
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible
from mafsil.model import JointLimits
from mafsil.robot import Robot
from mafsil.trajectory import JointPath, Trajectory, rest

MOST_CONFIGURATIONS = 6
"""Other configurations of which the lines that follow are tried."""


@dataclass(frozen=True, eq=False, slots=True)
class Leg:
    """One move, planned.

    Attributes:
        index: of the move in the job, the last of several without a stop between; -1 for the rest at the end.
        name: in the job, or empty.
        kind: joint, line, arc, spline, screw, blended, pick, place, tool, pause or settle.
        trajectory: of the joints.
        load: what hangs on the flange while it moves.
        target: (4, 4) pose it ends at, if the job names a pose.
        task: what of that pose counts.
        timing: what limits it; None of rests.
    """

    index: int
    name: str
    kind: str
    trajectory: Trajectory
    load: Load
    target: PoseMatrix | None = None
    task: Task = "pose"
    timing: Timing | None = None


@dataclass(frozen=True, eq=False, slots=True)
class Plan:
    """All moves, one after the other, each starting at rest where the one before ends.

    Attributes:
        start: (n,) configuration.
        legs: in order.
        remarks: what the reader should know.
        surroundings: what the arm may meet; None where the job names nothing.
        neighbours: what other robots do meanwhile.
    """

    start: JointVector
    legs: tuple[Leg, ...]
    remarks: tuple[Remark, ...]
    surroundings: Surroundings | None = None
    neighbours: tuple[NeighbourMotion, ...] = ()

    @property
    def duration(self) -> float:
        """Length in time [s]."""
        return float(sum(leg.trajectory.duration for leg in self.legs))

    @property
    def cycle(self) -> float:
        """Until the last move ends, without the rest after it [s]."""
        moves = self.legs[:-1] if self.legs and self.legs[-1].kind == "settle" else self.legs
        return float(sum(leg.trajectory.duration for leg in moves))

    @property
    def starts(self) -> Floats:
        """(legs + 1,) beginning of each leg, and the end [s]."""
        return np.concatenate([[0.0], np.cumsum([leg.trajectory.duration for leg in self.legs])])

    def tips(self, t: Floats, q: Floats) -> PoseMatrix:
        """(k, 4, 4) poses in {s} of the tip of the tool that is mounted at times (k,), at configurations (k, n)."""
        legs = np.clip(np.searchsorted(self.starts, t, side="right") - 1, 0, len(self.legs) - 1)
        robots = [leg.load.robot for leg in self.legs]
        found = np.empty((len(t), 4, 4))
        for robot in dict.fromkeys(robots):
            rows = np.array([each is robot for each in robots])[legs]
            found[rows] = robot.forward_kinematics(q[rows])
        return found


def plan(
    job: Job, tools: tuple[Equipment, ...], progress: Callable[[float], None] = lambda share: None, text: str = "",
    neighbours: tuple[Neighbour, ...] = (),
) -> Plan | Refusal:  # fmt: skip
    """The motion that a job asks for, or why there is none.

    Args:
        job: the job; its numbers fit the robot.
        tools: the robot with each of its tools, that of the start first.
        progress: called with the share of moves done.
        text: of the job file, for the lines of its moves.
        neighbours: other robots around.
    """
    planner = _Planner(job, tools, Places(text).of(job), neighbours)
    try:
        planner.walk(progress)
    except Refused as no:
        return no.refusal
    return Plan(
        planner.origin, tuple(planner.legs), tuple(planner.remarks), planner.surroundings, planner.beside
    )  # fmt: skip


class _Planner:
    """Walks through the moves, remembering where the robot is and what it carries."""

    def __init__(
        self, job: Job, tools: tuple[Equipment, ...], places: Places, neighbours: tuple[Neighbour, ...]
    ) -> None:
        self.job = job
        self.tools = {each.name: each for each in tools}
        self.load = Load(tools[0])
        robot = tools[0].robot
        self.places = places
        self.degrees = job.angles == "degrees"
        self.limits, self.remarks = driving_limits(job, robot)
        self.remarks += unit_remarks(job, robot, places)
        self.goals_of = {name: Goals(each.robot) for name, each in self.tools.items()}
        self.loops = ClosedMoves(robot) if robot.mechanism.loops else None
        meets = job.obstacle or neighbours or job.collision is not None
        self.surroundings = Surroundings(job, robot, neighbours) if meets else None
        self.beside: tuple[NeighbourMotion, ...] = ()
        self.lines: dict[tuple[object, ...], TipMotion] = {}
        self.legs: list[Leg] = []
        self.q: JointVector = np.zeros(robot.n)
        self.origin = self.q

    @property
    def robot(self) -> Robot:
        """With the tool that is mounted."""
        return self.load.robot

    @property
    def goals(self) -> Goals:
        """Configurations for poses of the tool that is mounted."""
        return self.goals_of[self.load.equipment.name]

    def walk(self, progress: Callable[[float], None]) -> None:
        """The start, all moves, the rest at the end."""
        job = self.job
        self.start()
        k = 0
        while k < len(job.move):
            progress(k / len(job.move))
            k = self.add(k, job.move[k])
        self.past_neighbours()
        if job.simulation.settle > 0.0:
            self.append(-1, "", "settle", rest(self.q, job.simulation.settle))

    def past_neighbours(self) -> None:
        """What other robots do past the motion planned so far; at its end the robot waits until all have arrived."""
        if self.surroundings is None:
            return
        loads = list(dict.fromkeys(leg.load for leg in self.legs))
        self.beside, said = self.surroundings.neighbours_past(self.legs, self.limits.acceleration, loads)
        self.remarks += said
        past = sum(leg.trajectory.duration for leg in self.legs)
        last = max((each.motion.duration for each in self.beside), default=0.0)
        if last > past:
            self.append(-1, "", "settle", rest(self.q, last - past))

    def where(self, index: int) -> Where:
        """How sentences call a move; the start is -1."""
        if index < 0:
            return Where(index, None, self.places.line(("start",)))
        return Where(index, self.job.move[index], self.places.line(("move", index)))

    def start(self) -> None:
        """Where the robot begins."""
        given = self.job.start
        if self.loops is not None:
            place = starting_place(self.robot)
            values = place if given.joints is None else coordinates(self.job, self.robot, given.joints)
            if given.pose is None:
                self.q = self.loops.closed(values, place, self.where(-1))
            else:
                T = pose_matrix(given.pose, degrees=self.degrees)
                self.q = self.closed_configurations(self.loops, -1, given.pose.task, T, place)[0]
        elif given.joints is not None:
            self.q = coordinates(self.job, self.robot, given.joints)
        else:
            self.q = starting_place(self.robot)
            if given.pose is not None:
                self.q = self.configuration(-1, given.pose, pose_matrix(given.pose, degrees=self.degrees))
        self.origin = self.q
        if self.surroundings is not None and not self.surroundings.is_free(self.q, self.load):
            contact = self.surroundings.checker(self.load).check(self.q).contacts[0]
            raise Refused("job.start_meets", move=self.where(-1), contact=said_of(contact))

    def add(self, index: int, move: Move) -> int:
        """Plan one move, or several without a stop between, and append it; the index of the next."""
        name = visible(move.name)
        if move.pause is not None:
            self.append(index, name, "pause", rest(self.q, move.pause))
        elif move.pick is not None:
            self.append(index, name, "pick", rest(self.q, self.on_tick(move.hold)))
            self.load = replace(self.load, carried=move.pick)
        elif move.place:
            self.append(index, name, "place", rest(self.q, self.on_tick(move.hold)))
            self.load = replace(self.load, carried=None)
        elif move.tool is not None:
            self.append(index, name, "tool", rest(self.q, self.on_tick(move.hold)))
            self.load = Load(self.tools[move.tool])
            self.require_mounted(index)
        elif move.path in TIP_PATHS:
            return self.along(index)
        elif move.pose is not None and self.loops is not None:
            self.reach_closed(self.loops, index, name, move.pose)
        elif move.pose is not None:
            self.reach(index, name, move.pose)
        elif self.loops is not None:
            self.goals.forget()
            goal = coordinates(self.job, self.robot, move.joints or ())
            self.append(index, name, "joint", self.closed_motion(self.loops, index, goal))
        else:
            self.goals.forget()
            goal = coordinates(self.job, self.robot, move.joints or ())
            self.append(index, name, "joint", *self.joint_motion(index, goal))
        return index + 1

    def require_mounted(self, index: int) -> None:
        """A tool that meets something as soon as it is mounted is refused."""
        if self.surroundings is not None and not self.surroundings.is_free(self.q, self.load):
            contact = self.surroundings.checker(self.load).check(self.q).contacts[0]
            raise Refused("job.tool_meets", move=self.where(index), contact=said_of(contact))

    def on_tick(self, hold: float) -> float:
        """A rest at least this long that ends on a tick of the controller: there the load of the tool changes [s]."""
        rate, step = self.job.controller.rate, self.job.simulation.step
        period = step if rate is None else 1.0 / rate
        past = sum(leg.trajectory.duration for leg in self.legs)
        return float(np.ceil((past + max(hold, period)) / period - 1e-9) * period - past)

    def reach(self, index: int, name: str, goal: Goal) -> None:
        """To a pose, all joints together."""
        target = self.target(goal, self.q)
        configuration = self.configuration(index, goal, target)
        self.append(index, name, "joint", *self.joint_motion(index, configuration), target, goal.task)
        self.q = configuration
        self.arrived(index, goal, target)

    def along(self, first: int) -> int:
        """On a path of the tip, and on those after it as long as corners are rounded; the index of the next move."""
        moves = self.job.move
        last = first
        while moves[last].blend > 0.0:
            last += 1
        planned = self.line(first, last, self.q)
        if isinstance(planned, Refused):
            raise planned
        goal, where = moves[last].pose, self.where(last)
        assert goal is not None
        self.remarks += slowed(self.robot, planned, where)
        self.remarks += decided_by(self.robot, planned.binding, where)
        target = self.targets(first, last, self.q)[-1]
        kind = moves[last].path if first == last else "blended"
        name, timing = visible(moves[last].name), self.timing_on_path(first, last, planned)
        self.append(last, name, kind, planned.trajectory, timing, target, goal.task)
        self.arrived(last, goal, target)
        return last + 1

    def arrived(self, index: int, goal: Goal, target: PoseMatrix) -> None:
        """Where the arm is at a pose is remembered, and how nearly it is met."""
        self.goals.take(target, goal.task, self.q)
        self.remarks += nearly_met(self.robot, self.q, target, goal.task, self.where(index))

    def targets(self, first: int, last: int, q: JointVector) -> list[PoseMatrix]:
        """Poses at the ends of some moves from q; one that names no orientation has that of the one before."""
        here = np.asarray(self.robot.forward_kinematics(q))
        found: list[PoseMatrix] = []
        for move in self.job.move[first : last + 1]:
            assert move.pose is not None
            here = goal_matrix(move.pose, here, degrees=self.degrees)
            found.append(here)
        return found

    def target(self, goal: Goal, q: JointVector) -> PoseMatrix:
        """The pose of a goal, from q on where it is relative; its orientation that at q if it names none."""
        return goal_matrix(goal, np.asarray(self.robot.forward_kinematics(q)), degrees=self.degrees)

    def configuration(self, index: int, goal: Goal, target: PoseMatrix) -> JointVector:
        """Where the joints go for a pose: as before for the same pose, nearby, or so that the lines after it run.

        1. The configuration in which the pose was taken before.
        2. The configuration near the present one, if the lines that follow from there are possible and not slowed.
        3. Of other configurations, the nearest that is better in that; the best one if none is good.
        """
        if goal.branch is not None:
            return self.on_branch(index, goal.branch, target)
        known = self.goals.taken(target, goal.task)
        if known is not None:
            return known
        allowed = tolerances(self.job, self.robot, None if index < 0 else index)
        nearest = self.goals.configuration(target, goal.task, self.q, allowed, self.where(index))
        best, least = nearest, self.trouble(index, nearest)
        if least <= SLOW:
            return nearest
        for other in self.goals.others(target, goal.task, self.q)[:MOST_CONFIGURATIONS]:
            trouble = self.trouble(index, other)
            if trouble < least:
                best, least = other, trouble
            if least <= SLOW:
                break
        return best

    def on_branch(self, index: int, branch: BranchChoice, target: PoseMatrix) -> JointVector:
        """The nearest configuration of a branch that is free, if one of them is."""
        found = self.goals.on_branch(target, branch, self.q, self.where(index))
        free = [q for q in found if self.surroundings is None or self.surroundings.is_free(q, self.load)]
        return (free or found)[0]

    def trouble(self, index: int, q: JointVector) -> float:
        """How many times longer than the tip's bounds ask for the worst line after a move takes; inf if impossible."""
        worst = 1.0
        if self.surroundings is not None and not self.surroundings.is_free(q, self.load):
            return np.inf
        for k in range(index + 1, len(self.job.move)):
            move = self.job.move[k]
            if move.pause is not None or move.pick is not None or move.place:
                continue
            if move.path not in TIP_PATHS or move.pose is None:
                # A change of tools, too: from there on other poses count.
                break
            planned = self.line(k, k, q)
            if isinstance(planned, Refused):
                return np.inf
            if self.surroundings is not None and self.surroundings.first_hit(planned.trajectory, self.load):
                return np.inf
            worst = max(worst, planned.factor)
            q = planned.trajectory.at(planned.trajectory.duration).u
        return worst

    def line(self, first: int, last: int, q: JointVector) -> TipMotion | Refused:
        """The motion along the paths of some moves from q; planned once."""
        moves, targets = self.job.move[first : last + 1], self.targets(first, last, q)
        asked = self.asked(first, last)
        key = (
            self.load.equipment,
            q.tobytes(),
            *(target.tobytes() for target in targets),
            *(_asked(move) for move in moves),
        )
        if key not in self.lines:
            where = self.where(last)
            start = np.asarray(self.robot.forward_kinematics(q))
            try:
                path = path_or_refusal(start, moves, targets, self.degrees, where)
                self.lines[key] = tip_motion(
                    self.robot, q, path, self.job.limits, asked, self.scaled(asked), self.slack(last), where
                )
            except Refused as no:
                return no
        return self.lines[key]

    def asked(self, first: int, last: int) -> Move:
        """Some moves without a stop between as one: the slowest of their speeds, limited jerk if one asks for it."""
        moves = self.job.move[first : last + 1]
        smooth = any(move.profile == "jerk_limited" for move in moves)
        profile = "jerk_limited" if smooth else moves[-1].profile
        return msgspec.structs.replace(moves[-1], speed=min(move.speed for move in moves), profile=profile)

    def timing_on_path(self, first: int, last: int, planned: TipMotion) -> Timing | None:
        """What limits a motion along a path of the tip; None where the path leads nowhere."""
        along, asked, where = planned.along, self.asked(first, last), self.where(last)
        if along is None:
            return None

        def again(limits: JointLimits, bounds: Bounds) -> float:
            return motion_along(self.robot, *along, bounds, asked, limits, where).trajectory.duration

        return Timing(self.scaled(asked), self.job.limits, asked.speed, again)

    def slack(self, index: int) -> float:
        """How far from what it can reach a line may lead an arm that has fewer joints than its task needs."""
        goal = self.job.move[index].pose
        if goal is None or self.robot.n >= FIXES[goal.task]:
            return 0.0
        allowed = tolerances(self.job, self.robot, index)
        return min(allowed.position, allowed.orientation)

    def append(
        self,
        index: int,
        name: str,
        kind: str,
        trajectory: Trajectory,
        timing: Timing | None = None,
        target: PoseMatrix | None = None,
        task: Task = "pose",
    ) -> None:
        self.legs.append(Leg(index, name, kind, trajectory, self.load, target, task, timing))
        if kind not in RESTS:
            self.require_free(index, kind, trajectory)
            self.remarks += near_limits(self.robot, trajectory, self.where(index))
        self.q = trajectory.at(trajectory.duration).u

    def joint_motion(self, index: int, goal: JointVector) -> tuple[Trajectory, Timing]:
        """All joints together to a goal, through the points on the way, or round what stands in it; and what limits."""
        move, robot, where = self.job.move[index], self.robot, self.where(index)
        around = self.way_round(index, goal)
        ways = [coordinates(self.job, robot, via) for via in move.via if isinstance(via, tuple)]
        points = [self.q, *ways, goal]

        def within(limits: JointLimits) -> JointMove:
            if around is not None:
                return motion_on_path(robot, around, move, limits, where)
            return joint_motion(robot, points, move, limits, where)

        limits = self.scaled(move)
        planned = within(limits)
        self.remarks += decided_by(robot, planned.binding, where)

        def again(limits: JointLimits, bounds: Bounds) -> float:
            return within(limits).trajectory.duration

        return planned.trajectory, Timing(limits, self.job.limits, None, again)

    def reach_closed(self, loops: ClosedMoves, index: int, name: str, goal: Goal) -> None:
        """To a pose with closed loops: of its configurations the nearest to which there is a motion."""
        target = self.target(goal, self.q)
        known = self.goals.taken(target, goal.task)
        found = [known] if known is not None else self.closed_configurations(loops, index, goal.task, target, self.q)
        refusals: list[Refused] = []
        for q in found[: MOST_CONFIGURATIONS + 1]:
            try:
                trajectory = self.closed_motion(loops, index, q)
                loops.require_at(trajectory, q, self.where(index))
                self.require_free(index, "joint", trajectory)
            except Refused as no:
                refusals.append(no)
                continue
            self.append(index, name, "joint", trajectory, None, target, goal.task)
            return self.arrived(index, goal, target)
        raise refusals[0]

    def closed_configurations(
        self, loops: ClosedMoves, index: int, task: Task, target: PoseMatrix, near: JointVector
    ) -> list[JointVector]:
        """Configurations with closed loops for a pose, those that meet nothing first, then the nearest."""
        allowed = tolerances(self.job, self.robot, None if index < 0 else index)
        found = loops.at_pose(self.robot, target, task, near, allowed, self.where(index))
        around = self.surroundings
        return found if around is None else sorted(found, key=lambda q: not around.is_free(q, self.load))

    def closed_motion(self, loops: ClosedMoves, index: int, goal: JointVector) -> Trajectory:
        """The driven joints of a mechanism with loops to a goal, through the points on the way, or round obstacles."""
        move, where, limits = self.job.move[index], self.where(index), self.scaled(self.job.move[index])
        ways = [coordinates(self.job, self.robot, via) for via in move.via if isinstance(via, tuple)]
        straight = loops.motion(self.q, [*ways, goal], move, limits, where)
        if not self.goes_round(move) or self.surroundings is None:
            return straight
        hit = self.surroundings.first_hit(straight, self.load)
        if hit is None:
            return straight
        around = self.path_round(index, straight.at(straight.duration).u, hit.contact)
        return loops.along(self.q, around, move, limits, where)

    def goes_round(self, move: Move) -> bool:
        """Whether a move may leave the straight way of its joints for one round obstacles."""
        around = self.surroundings
        if around is None or move.via or move.profile not in (None, *QUICKEST):
            return False
        return around.rule.avoid if move.avoid is None else move.avoid

    def way_round(self, index: int, goal: JointVector) -> JointPath | None:
        """A path round obstacles; None where the move does not ask for one, or where the straight way is free."""
        around = self.surroundings
        if around is None or not self.goes_round(self.job.move[index]):
            return None
        straight = around.checker(self.load).check_path(self.q, goal)
        if straight:
            return None
        return self.path_round(index, goal, straight.contacts[0] if straight.contacts else None)

    def path_round(self, index: int, goal: JointVector, contact: Contact | None) -> JointPath:
        """A path round what stands in the way, or the refusal; the remark names what would have been met."""
        assert self.surroundings is not None
        found = self.surroundings.way_round(self.q, goal, self.load)
        if not found:
            raise Refused("job.no_way_round", move=self.where(index), reason=found)
        details = {"move": self.where(index), "count": len(found.path) - 2, "states": found.configurations}
        if contact is not None:
            details |= {"first": visible(contact.first), "second": visible(contact.second)}
            self.remarks.append(Remark("good", "job.went_round", details))
        return found.joint_path()

    def require_free(self, index: int, kind: str, trajectory: Trajectory) -> None:
        """A motion that meets something is refused, with the place and what helps."""
        if self.surroundings is None:
            return
        hit = self.surroundings.first_hit(trajectory, self.load)
        if hit is None:
            return
        key = "job.meets_avoidable" if kind == "joint" else "job.meets"
        raise Refused(key, move=self.where(index), time=quantity(hit.time, "s"), contact=said_of(hit.contact))

    def scaled(self, move: Move) -> JointLimits:
        """The limits for one move: slower if it says so."""
        return replace(
            self.limits,
            velocity=self.limits.velocity * move.speed,
            acceleration=self.limits.acceleration * move.speed**2,
            jerk=self.limits.jerk * (move.speed**3 if move.profile == "jerk_limited" else np.inf),
        )


def _asked(move: Move) -> tuple[object, ...]:
    """What of a move its motion along a path depends on, besides its goal."""
    return move.path, move.via, move.blend, move.speed, move.profile, move.duration, move.pose and move.pose.task
