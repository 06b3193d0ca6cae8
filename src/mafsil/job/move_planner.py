"""Moves of a job into trajectories: goals by inverse kinematics, motion within the limits, a reason for every no."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import msgspec
import numpy as np

from mafsil.arrays import JointVector, PoseMatrix
from mafsil.collision import Contact
from mafsil.job.called import Where
from mafsil.job.cell_signals import CellSignals, assignments, conditions
from mafsil.job.closed_moves import ClosedMoves
from mafsil.job.description import QUICKEST, TIP_PATHS, Bounds, BranchChoice, Goal, Job, Move, Task
from mafsil.job.equipment import Equipment, Load
from mafsil.job.fitting import coordinates, unit_remarks
from mafsil.job.goals import FIXES, Goals
from mafsil.job.joint_motion import JointMove, joint_motion, motion_on_path
from mafsil.job.laws import control_period
from mafsil.job.lines import Places
from mafsil.job.neighbours import Neighbour, NeighbourMotion
from mafsil.job.plan import Leg, Plan
from mafsil.job.planned_remarks import SLOW, decided_by, driving_limits, near_limits, nearly_met, slowed
from mafsil.job.poses import goal_matrix, pose_matrix
from mafsil.job.remark import Refusal, Refused, Remark
from mafsil.job.resting import starting_place
from mafsil.job.surroundings import RESTS, Surroundings, WayRound, said_of
from mafsil.job.timing import Timing
from mafsil.job.tip_motion import TipMotion, motion_along, tip_motion
from mafsil.job.tip_paths import path_or_refusal
from mafsil.job.tolerance import tolerances
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible
from mafsil.model import JointLimits
from mafsil.robot import Robot
from mafsil.trajectory import Trajectory, rest

MOST_CONFIGURATIONS = 6
"""Other configurations of which the lines that follow are tried."""


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
        start=planner.origin,
        legs=tuple(planner.legs),
        remarks=tuple(planner.remarks),
        surroundings=planner.surroundings,
        neighbours=planner.beside,
        signals=planner.signals if planner.signals.names else None,
    )


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
        meets = meets or any(move.clearance is not None for move in job.move)
        self.surroundings = Surroundings(job, robot, neighbours) if meets else None
        self.beside: tuple[NeighbourMotion, ...] = ()
        self.signals = CellSignals(job, control_period(job))
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
        self.remarks += self.waited()
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
        elif move.set:
            self.append(index, name or assignments(move.set), "set", rest(self.q, self.on_tick(0.0)))
            self.signals.put(self.past, move.set)
        elif move.wait:
            self.wait(index, name, move)
        elif move.path in TIP_PATHS:
            return self.along(index)
        elif move.pose is not None and self.loops is not None:
            self.reach_closed(self.loops, index, name, move.pose)
        elif move.pose is not None:
            self.reach(index, name, move.pose)
        elif self.loops is not None:
            self.goals.forget()
            goal = coordinates(self.job, self.robot, move.joints or ())
            trajectory, way = self.closed_motion(self.loops, index, goal)
            self.append(index, name, "joint", trajectory, way=way)
        else:
            self.goals.forget()
            goal = coordinates(self.job, self.robot, move.joints or ())
            trajectory, timing, way = self.joint_motion(index, goal)
            self.append(index, name, "joint", trajectory, timing, way=way)
        return index + 1

    def require_mounted(self, index: int) -> None:
        """A tool that meets something as soon as it is mounted is refused."""
        if self.surroundings is not None and not self.surroundings.is_free(self.q, self.load):
            contact = self.surroundings.checker(self.load).check(self.q).contacts[0]
            raise Refused("job.tool_meets", move=self.where(index), contact=said_of(contact))

    def on_tick(self, hold: float) -> float:
        """A rest at least this long that ends on a tick of the controller: there the load of the tool changes [s]."""
        return self.signals.tick_after(self.past, hold) - self.past

    @property
    def past(self) -> float:
        """End of what is planned so far [s]."""
        return float(sum(leg.trajectory.duration for leg in self.legs))

    def waited(self) -> tuple[Remark, ...]:
        """How long the arm waits for signals, if it does."""
        waits = [leg for leg in self.legs if leg.kind == "wait"]
        if not waits:
            return ()
        longest = max(waits, key=lambda leg: leg.trajectory.duration)
        details = {
            "total": quantity(sum(leg.trajectory.duration for leg in waits), "s"),
            "longest": quantity(longest.trajectory.duration, "s"),
            "move": self.where(longest.index),
            "wanted": conditions(self.job.move[longest.index].wait),
        }
        return (Remark("good", "job.waited", details),)

    def wait(self, index: int, name: str, move: Move) -> None:
        """A rest until all conditions hold; one that never ends, or too late, is refused."""
        past, wanted = self.past, conditions(move.wait)
        end = self.signals.end_of_wait(past, move)
        if end is not None:
            self.append(index, name or wanted, "wait", rest(self.q, end - past))
            return
        details = {"move": self.where(index), "time": quantity(past, "s"), "wanted": wanted}
        forgiving = msgspec.structs.replace(move, timeout=None)
        late = None if move.timeout is None else self.signals.end_of_wait(past, forgiving)
        if late is not None and move.timeout is not None:
            times = {"limit": quantity(move.timeout, "s"), "needed": quantity(late - past, "s")}
            raise Refused("job.wait_late", **details, **times)
        raise Refused("job.wait_never", **details, state=self.signals.states(tuple(move.wait), past))

    def reach(self, index: int, name: str, goal: Goal) -> None:
        """To a pose, all joints together."""
        target = self.target(goal, self.q)
        configuration = self.configuration(index, goal, target)
        trajectory, timing, way = self.joint_motion(index, configuration)
        self.append(index, name, "joint", trajectory, timing, target, goal.task, way=way)
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
        self.append(last, name, kind, planned.trajectory, timing, target, goal.task, first=first)
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
        free = [q for q in found if self.is_free(q, index)]
        return (free or found)[0]

    def trouble(self, index: int, q: JointVector) -> float:
        """How many times longer than the tip's bounds ask for the worst line after a move takes; inf if impossible."""
        worst = 1.0
        if not self.is_free(q, index):
            return np.inf
        for k in range(index + 1, len(self.job.move)):
            move = self.job.move[k]
            if move.stays:
                continue
            if move.path not in TIP_PATHS or move.pose is None:
                # A change of tools, too: from there on other poses count.
                break
            planned = self.line(k, k, q)
            if isinstance(planned, Refused):
                return np.inf
            if self.meets(planned.trajectory, self.clearance(k, k)):
                return np.inf
            worst = max(worst, planned.factor)
            q = planned.trajectory.at(planned.trajectory.duration).u
        return worst

    def is_free(self, q: JointVector, index: int) -> bool:
        """Whether a configuration keeps the clearance of a move."""
        return self.surroundings is None or self.surroundings.is_free(q, self.load, self.clearance(index, index))

    def meets(self, trajectory: Trajectory, clearance: float) -> bool:
        """Whether a motion does not keep a clearance."""
        around = self.surroundings
        return around is not None and around.first_hit(trajectory, self.load, clearance) is not None

    def clearance(self, first: int, last: int) -> float:
        """What some moves without a stop between keep: the largest of their clearances [m]."""
        usual = 0.0 if self.surroundings is None else self.surroundings.rule.clearance
        own = [self.job.move[k].clearance for k in range(max(first, 0), last + 1)]
        return max((usual if each is None else each for each in own), default=usual)

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
                planned = tip_motion if self.loops is None else self.loops.on_tip_path
                self.lines[key] = planned(
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
        *,
        first: int | None = None,
        way: WayRound | None = None,
    ) -> None:
        moves = kind not in RESTS
        past = self.legs[-1].clearance if self.legs else self.clearance(-1, -1)
        kept = self.clearance(index if first is None else first, index) if moves else past
        self.legs.append(Leg(index, name, kind, trajectory, self.load, target, task, timing, kept, way))
        if moves:
            self.require_free(index, kind, trajectory, kept)
            self.remarks += near_limits(self.robot, trajectory, self.where(index))
        self.q = trajectory.at(trajectory.duration).u

    def joint_motion(self, index: int, goal: JointVector) -> tuple[Trajectory, Timing, WayRound | None]:
        """All joints together to a goal, through points on the way or round what stands in it; what limits that."""
        move, robot, where = self.job.move[index], self.robot, self.where(index)
        way = self.way_round(index, goal)
        around = None if way is None else way.plan.joint_path()
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

        return planned.trajectory, Timing(limits, self.job.limits, None, again), way

    def reach_closed(self, loops: ClosedMoves, index: int, name: str, goal: Goal) -> None:
        """To a pose with closed loops: of its configurations the nearest to which there is a motion."""
        target = self.target(goal, self.q)
        known = self.goals.taken(target, goal.task)
        found = [known] if known is not None else self.closed_configurations(loops, index, goal.task, target, self.q)
        refusals: list[Refused] = []
        for q in found[: MOST_CONFIGURATIONS + 1]:
            try:
                trajectory, way = self.closed_motion(loops, index, q)
                loops.require_at(trajectory, q, self.where(index))
                self.require_free(index, "joint", trajectory, self.clearance(index, index))
            except Refused as no:
                refusals.append(no)
                continue
            self.append(index, name, "joint", trajectory, None, target, goal.task, way=way)
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

    def closed_motion(
        self, loops: ClosedMoves, index: int, goal: JointVector
    ) -> tuple[Trajectory, WayRound | None]:  # fmt: skip
        """The driven joints of a mechanism with loops to a goal, through the points on the way, or round obstacles."""
        move, where, limits = self.job.move[index], self.where(index), self.scaled(self.job.move[index])
        ways = [coordinates(self.job, self.robot, via) for via in move.via if isinstance(via, tuple)]
        straight = loops.motion(self.q, [*ways, goal], move, limits, where)
        around = self.surroundings
        if around is None or not self.goes_round(index):
            return straight, None
        hit = around.first_hit(straight, self.load, self.clearance(index, index))
        if hit is None:
            return straight, None
        way = self.way_round(index, straight.at(straight.duration).u, hit.contact)
        assert way is not None
        return loops.along(self.q, way.plan.joint_path(), move, limits, where), way

    def goes_round(self, index: int) -> bool:
        """Whether a move may leave the straight way of its joints for one round obstacles."""
        move = self.job.move[index]
        return not move.via and move.profile in (None, *QUICKEST) and self.avoids(index)

    def way_round(self, index: int, goal: JointVector, met: Contact | None = None) -> WayRound | None:
        """A way round obstacles; None where the move does not ask for one, or where the straight way is free.

        Args:
            index: of the move.
            goal: (n,) where it ends.
            met: what the way without it meets, where that is no straight way of the joints.
        """
        move, around = self.job.move[index], self.surroundings
        if around is None or not self.goes_round(index):
            return None
        found = around.way_round(self.q, goal, self.load, self.clearance(index, index), move.planner, met)
        if found is None:
            return None
        if not found.plan:
            raise Refused("job.no_way_round", move=self.where(index), reason=found.plan)
        self.remarks.append(Remark("good", "job.went_round", {"move": self.where(index)} | found.details()))
        return found

    def avoids(self, index: int) -> bool:
        """Whether a move is to go round what stands in its way."""
        own = self.job.move[index].avoid
        return (self.surroundings is not None and self.surroundings.rule.avoid) if own is None else own

    def require_free(self, index: int, kind: str, trajectory: Trajectory, clearance: float) -> None:
        """A motion that meets something is refused, with the place and what helps."""
        if self.surroundings is None:
            return
        hit = self.surroundings.first_hit(trajectory, self.load, clearance)
        if hit is None:
            return
        avoidable = kind == "joint" and not self.avoids(index) and not self.job.move[index].via
        key = "job.meets_avoidable" if avoidable else "job.meets"
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
