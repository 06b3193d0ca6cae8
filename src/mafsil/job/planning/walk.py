"""What is known on the way through the moves of a job: where the robot is, what it carries, what is planned so far."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace

import numpy as np
from msgspec import structs

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.job.language.description import TIP_BOUNDS, Bounds, Goal, Job, Move, Task
from mafsil.job.language.driving_tables import WITHOUT_INERTIA
from mafsil.job.language.text import Places
from mafsil.job.language.units import goal_matrix, pose_matrix
from mafsil.job.planning.beside import Beside
from mafsil.job.planning.cell_signals import CellSignals, Decision
from mafsil.job.planning.equipment import Equipment, Load
from mafsil.job.planning.fitting import coordinates, unit_remarks
from mafsil.job.planning.goals import Goals
from mafsil.job.planning.neighbours import Neighbour, NeighbourMotion
from mafsil.job.planning.placed_parts import PlacedPart, PlacedParts
from mafsil.job.planning.plan import Leg, Plan, Timing, unchecked_remarks
from mafsil.job.planning.planned_remarks import Tight, driving_limits, long_way, near_limits, nearly_met, tight_limits
from mafsil.job.planning.surroundings import RESTS, Surroundings, WayRound, why_not_itself
from mafsil.job.remark import Refused, Remark, Where, said_of
from mafsil.messages.quantities import quantity
from mafsil.model import JointLimits
from mafsil.planning import TimedArm
from mafsil.planning.waiting_places import standing
from mafsil.robot import Robot
from mafsil.simulation.stored_arrays import KINEMATIC
from mafsil.trajectory import MotionLimits, Trajectory

CORNER_SAMPLES = 513
"""Moments of moves without a stop between at which is looked which of them is under way."""


class Walk:
    """Where the robot is after the moves planned so far, and what it carries.

    Args:
        job: the job; its numbers fit the robot.
        tools: the robot with each of its tools, that of the start first.
        places: of the keys, for the lines of moves.
        neighbours: other robots around.
    """

    def __init__(
        self, job: Job, tools: tuple[Equipment, ...], places: Places, neighbours: tuple[Neighbour, ...]
    ) -> None:
        self.job = job
        self.tools = {each.name: each for each in tools}
        self.load, self.neighbours = Load(tools[0]), neighbours
        robot = tools[0].robot
        self.places = places
        self.degrees = job.angles == "degrees"
        self.limits, self.remarks = driving_limits(job, robot)
        self.remarks += unit_remarks(job, robot, places)
        self.goals_of = {name: Goals(each.robot) for name, each in self.tools.items()}
        meets = job.obstacle or neighbours or job.collision is not None
        meets = meets or any(move.clearance is not None or move.constraints is not None for move in job.move)
        looks = bool(meets) or why_not_itself(job.collision, robot.mechanism) is None
        self.surroundings = Surroundings(job, robot, neighbours) if looks else None
        self._counts_parts = bool(meets)
        self.beside: tuple[NeighbourMotion, ...] = ()
        self.signals = CellSignals(job, job.control_period)
        self.legs: list[Leg] = []
        lies = [(part, pose_matrix(place, degrees=self.degrees), carrier) for part, place, carrier in job.lying]
        names = () if self.surroundings is None else self.surroundings.scene.names
        self.parts = PlacedParts(names, ((part, T) for part, T, carrier in lies if carrier is None))
        self.riding = {
            name: PlacedParts((), ((part, T) for part, T, carrier in lies if carrier == name)) for name in job.moving
        }
        self.past = 0.0
        self.made = 0
        self.stops: tuple[float, ...] = ()
        self.searches = 0
        self.tight: list[Tight] = []
        self._others: Beside | None = None
        self.q: JointVector = np.zeros(robot.n)
        self.origin = self.q

    def plan(self) -> Plan:
        """What is planned so far."""
        return Plan(
            start=self.origin,
            legs=tuple(self.legs),
            remarks=(*self.remarks, *tight_limits(self.tight), *self.unchecked_remarks()),
            made=self.made,
            surroundings=self.surroundings,
            neighbours=self.beside,
            signals=self.signals if self.signals.names else None,
        )

    def unchecked_remarks(self) -> list[Remark]:
        """What nobody looked at."""
        first = next(iter(self.tools.values()))
        return unchecked_remarks(self.job, Load(first), self.legs, self.surroundings)

    @property
    def robot(self) -> Robot:
        """With the tool that is mounted."""
        return self.load.robot

    @property
    def goals(self) -> Goals:
        """Configurations for poses of the tool that is mounted."""
        return self.goals_of[self.load.equipment.name]

    def where(self, index: int) -> Where:
        """How sentences call a move; the start is -1."""
        if index < 0:
            return Where(index, None, self.places.line(("start",)))
        return Where(index, self.job.move[index], self.places.line(("move", index)))

    def motion(self) -> TimedArm:
        """What is planned so far, in time; the robot stands afterwards."""
        rests = tuple(leg.kind in RESTS and not leg.frame for leg in self.legs)
        starts = np.concatenate([[0.0], np.cumsum([leg.trajectory.duration for leg in self.legs])])
        if not self.legs:
            return standing(self.q, MotionLimits.of(self.robot.n, acceleration=self.limits.acceleration))
        return TimedArm(tuple(leg.trajectory for leg in self.legs), starts, rests, self.limits.acceleration)

    def others_that_set(self, names: Iterable[str]) -> Beside | None:
        """The other robots, where one of them sets a signal or the output that it follows."""
        inputs = self.job.input
        sources = {(inputs[name].follows or name) if name in inputs else name for name in names}
        foreign = {name for each in self.job.other_robot for move in each.move for name in move.set}
        return self.others() if sources & foreign else None

    def others(self) -> Beside | None:
        """The other robots that move, planned as far as they have come; None where there are none."""
        if self._others is None and self.surroundings is not None and any(each.move for each in self.job.other_robot):
            talks = any(move.set or move.wait or move.fork for each in self.job.other_robot for move in each.move)
            loads = [leg.load for leg in self.legs]
            if talks:
                # What is carried later is not known yet: whatever some way of the job may carry.
                parts = [None, *(move.pick for move in self.job.move if move.pick is not None)]
                loads = [Load(tool, part) for tool in self.tools.values() for part in parts]
            around = self.surroundings.neighbourhood(list(dict.fromkeys(loads)))
            self._others = Beside(around, self.signals, self.surroundings.rule.seed, self.parts)
        return self._others

    def on_tick(self, hold: float) -> float:
        """A rest at least this long that ends on a tick of the controller: there the load of the tool changes [s]."""
        return self.signals.tick_after(self.past, hold) - self.past

    def target(self, goal: Goal, q: JointVector) -> PoseMatrix:
        """The pose of a goal, from q on where it is relative; its orientation that at q if it names none."""
        return goal_matrix(goal, np.asarray(self.robot.forward_kinematics(q)), degrees=self.degrees)

    def targets(self, first: int, last: int, q: JointVector) -> list[PoseMatrix]:
        """Poses at the ends of some moves from q; one that names no orientation has that of the one before."""
        here = np.asarray(self.robot.forward_kinematics(q))
        found: list[PoseMatrix] = []
        for move in self.job.move[first : last + 1]:
            if move.pose is None:
                here = np.asarray(self.robot.forward_kinematics(coordinates(self.job, self.robot, move.joints or ())))
            else:
                here = goal_matrix(move.pose, here, degrees=self.degrees)
            found.append(here)
        return found

    def is_free(self, q: JointVector, index: int) -> bool:
        """Whether a configuration keeps the clearance of a move."""
        around = self.surroundings
        return around is None or around.is_free(
            q, self.load, self.clearance(index, index), self.parts_in_the_way(index, q)
        )

    def is_blocked(self, index: int, q: JointVector) -> bool:
        """Whether a move of all joints straight to q meets something that it is not to go round."""
        around, move = self.surroundings, self.job.move[index]
        if index < 0 or around is None or move.path != "joint" or move.via or move.constraints or self.avoids(index):
            return False
        checker = around.checker(self.load, self.clearance(index, index), self.parts_in_the_way(index, q))
        return not checker.check_path(self.q, q)

    def parts_in_the_way(self, index: int, q: JointVector) -> tuple[PlacedPart, ...]:
        """The parts put down before that a motion of move `index` to q has to keep away from.

        Only where the job speaks of what the robot may meet: a few sizes of parts do not describe a cell.
        """
        if not self.parts.standing or not self._counts_parts:
            return ()
        k = index + 1 + (self.job.move[index].skip if index >= 0 else 0)
        while k < len(self.job.move) and (move := self.job.move[k]).stays and not (move.pick or move.place):
            k += 1 + move.skip
        coming = self.job.move[k].pick if k < len(self.job.move) else None
        return self.parts.counted_parts(coming, np.asarray(self.robot.forward_kinematics(q)))

    def meets(self, first: int, last: int, trajectory: Trajectory) -> bool:
        """Whether a motion of some moves without a stop between does not keep their clearance."""
        around, kept = self.surroundings, self.clearance(first, last)
        parts = self.parts_in_the_way(last, trajectory.at(trajectory.duration).u)
        return around is not None and around.first_hit(trajectory, self.load, kept, parts) is not None

    def clearance(self, first: int, last: int) -> float:
        """What some moves without a stop between keep: the largest of their clearances [m]."""
        usual = 0.0 if self.surroundings is None else self.surroundings.rule.clearance
        own = [self.job.move[k].clearance for k in range(max(first, 0), last + 1)]
        return max((usual if each is None else each for each in own), default=usual)

    def scaled_limits(self, move: Move) -> JointLimits:
        """The limits of the joints for one move: slower if it says so."""
        velocity, acceleration = self.limits.velocity * move.speed, self.limits.acceleration * move.speed**2
        turns = self.robot.mechanism.angular
        return replace(
            self.limits,
            velocity=np.minimum(velocity, np.where(turns, move.joint_speed or np.inf, np.inf)),
            acceleration=np.minimum(acceleration, np.where(turns, move.joint_acceleration or np.inf, np.inf)),
            jerk=np.minimum(self._jerk(move) * move.speed**3, np.where(turns, move.joint_jerk or np.inf, np.inf)),
        )

    def _jerk(self, move: Move) -> Floats:
        """(n,) limits of jerk of a move: those of the description where it names no profile."""
        if move.profile == "jerk_limited":
            return self.limits.jerk
        own = self.robot.limits.jerk
        known = (own > 0.0) & (move.profile is None)
        return np.where(known, own * self.job.limits.acceleration_scale, np.inf)

    def with_profile(self, move: Move) -> Move:
        """A move whose controller lags behind accelerations as a quintic if it names no profile, else as it is."""
        lags = self.job.controller.kind in WITHOUT_INERTIA and self.job.simulation.plant != KINEMATIC
        lags = lags and move.joint_jerk is None and self.bounds(move).tip_jerk is None
        return structs.replace(move, profile="quintic") if lags and move.profile is None else move

    def bounds(self, move: Move) -> Bounds:
        """The bounds of the tip for one move: its own where it names them."""
        own = {name: getattr(move, name) for name in TIP_BOUNDS}
        return structs.replace(self.job.limits, **{name: value for name, value in own.items() if value is not None})

    def note_arrival(self, index: int, goal: Goal, target: PoseMatrix) -> None:
        """Where the arm is at a pose is remembered, and how nearly it is met."""
        self.goals.take(target, goal.task, self.q)
        self.remarks += nearly_met(self.robot, self.q, target, goal.task, self.where(index))

    def avoids(self, index: int) -> bool:
        """Whether a move is to go round what stands in its way."""
        own = self.job.move[index].avoid
        return (self.surroundings is not None and self.surroundings.rule.avoid) if own is None else own

    def require_free(
        self, index: int, kind: str, trajectory: Trajectory, clearance: float, first: int | None = None
    ) -> None:
        """A motion, of moves from `first` on, that meets something is refused, with the place and what helps."""
        if self.surroundings is None:
            return
        parts = self.parts_in_the_way(index, trajectory.at(trajectory.duration).u)
        hit = self.surroundings.first_hit(trajectory, self.load, clearance, parts)
        if hit is None:
            return
        if first is not None:
            index = self._move_at(first, index, trajectory, hit.time)
        move = self.job.move[index]
        avoidable = kind == "joint" and not self.avoids(index) and not move.via and move.constraints is None
        key = "job.meets_avoidable" if avoidable else "job.meets"
        contact = said_of(hit.contact, clearance)
        raise Refused(key, move=self.where(index), time=quantity(hit.time, "s"), contact=contact)

    def _move_at(self, first: int, last: int, trajectory: Trajectory, time: float) -> int:
        """Which of the moves without a stop between is under way at a time of their motion [s]."""
        t = np.linspace(0.0, trajectory.duration, CORNER_SAMPLES)
        tips = np.asarray(self.robot.forward_kinematics(trajectory.at(t).u))
        corners = corner_rows(tips, self.targets(first, last, trajectory.at(0.0).u)[:-1])
        return first + sum(bool(t[row] < time) for row in corners)

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
        decision: Decision | None = None,
        thing: int = -1,
        frame: str = "",
        targets: Sequence[PoseMatrix] = (),
        goals: Sequence[JointVector] = (),
    ) -> None:
        """One more leg: it is free, or refused; the robot is at its end then, that of move `index`."""
        moves, around = kind not in RESTS or frame != "", self.surroundings
        past = self.legs[-1].clearance if self.legs else self.clearance(-1, -1)
        kept = self.clearance(index if first is None else first, index) if moves else past
        end = trajectory.at(trajectory.duration).u
        parts = self.parts_in_the_way(index, end) if moves else self.legs[-1].parts if self.legs else ()
        self.legs.append(
            Leg(
                index, name, kind, trajectory, self.load, target, task, timing, kept, way, decision, parts, thing,
                targets=tuple(targets), goals=tuple(goals), frame=frame,
            )
        )  # fmt: skip
        self.past += trajectory.duration
        if moves:
            self.require_free(index, kind, trajectory, kept, first)
            if kind == "joint" and not frame:
                self.remarks += long_way(self.robot, trajectory, way is not None, self.where(index))
            self.tight += near_limits(self.robot, trajectory, self.where(index))
            left = self.parts.left
            if left is not None and (around is None or around.is_free(end, self.load, kept, (left,))):
                self.parts.left = None
        self.q = end


def corner_rows(tips: PoseMatrix, targets: Sequence[PoseMatrix]) -> list[int]:
    """Rows of a tip's path that pass rounded corners, one after the other.

    Args:
        tips: (k, 4, 4) of the tip.
        targets: (4, 4) corners, in their order.
    """
    found = [0]
    for target in targets:
        away = np.linalg.norm(tips[found[-1] :, :3, 3] - target[:3, 3], axis=1)
        found.append(found[-1] + int(away.argmin()))
    return found[1:]
