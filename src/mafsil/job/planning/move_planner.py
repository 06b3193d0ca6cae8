"""Moves of a job into trajectories: goals by inverse kinematics, motion within the limits, a reason for every no.

Moves of a job by which arm and cell talk: outputs, waits, and choices by what signals are.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import pairwise

import numpy as np

from mafsil.arrays import Floats, PoseMatrix
from mafsil.job.language.description import TIP_PATHS, Goal, Grasp, Job, Move
from mafsil.job.language.part import Fork, PathOutput, SignalValue
from mafsil.job.language.text import Places
from mafsil.job.language.units import pose_matrix, tolerances
from mafsil.job.planning.beside import Standstill
from mafsil.job.planning.cell_signals import Decision, assignments, conditions, decide_fork
from mafsil.job.planning.equipment import Equipment, Load
from mafsil.job.planning.fitting import coordinates, hand_fault
from mafsil.job.planning.joint_moves import ClosedSteps, Configurations, JointMoves
from mafsil.job.planning.moving_frames import FrameMoves
from mafsil.job.planning.neighbours import Neighbour
from mafsil.job.planning.plan import Plan
from mafsil.job.planning.resting import starting_place
from mafsil.job.planning.rounded_moves import RoundedMoves
from mafsil.job.planning.searching import search_remarks, stop_by_force, stop_by_signal
from mafsil.job.planning.tip_frames import TipFrames
from mafsil.job.planning.tip_moves import TipMoves
from mafsil.job.planning.walk import Walk, corner_rows
from mafsil.job.remark import Refusal, Refused, Remark, said_of
from mafsil.messages.quantities import quantity
from mafsil.messages.visible import visible
from mafsil.trajectory.profiles import rest

PATH_SAMPLES = 2_001
"""Moments of a move at which its tip is looked at, to place outputs on its path."""
STILL = 1e-6
"""Length of a tip's path that counts as none; lengths beyond its ends by less count as the ends [m]."""


def plan_moves(
    job: Job, tools: tuple[Equipment, ...], progress: Callable[[float], None] = lambda share: None, text: str = "",
    neighbours: tuple[Neighbour, ...] = (), stops: tuple[float, ...] = (),
) -> Plan | Refusal:  # fmt: skip
    """The motion that a job asks for, or why there is none.

    Args:
        job: the job; its numbers fit the robot.
        tools: the robot with each of its tools, that of the start first.
        progress: called with the share of moves done.
        text: of the job file, for the lines of its moves.
        neighbours: other robots around.
        stops: when contact ends the first searches, after each of them begins [s].
    """
    walk = Walk(job, tools, Places(text).of(job), neighbours)
    walk.stops = stops
    try:
        _Planner(walk).go(progress)
    except Refused as no:
        return no.refusal
    found = walk.plan()
    return replace(found, remarks=(*found.remarks, *search_remarks(job, found)))


class _Planner:
    """Goes through the moves, each planned by what knows its kind.

    Args:
        walk: at the beginning.
    """

    def __init__(self, walk: Walk) -> None:
        self.walk = walk
        self.joint_moves, self.signals = JointMoves(walk), SignalMoves(walk)
        self.closed = ClosedSteps(walk, self.joint_moves) if walk.robot.mechanism.loops else None
        self.tip_moves = TipMoves(walk, None if self.closed is None else self.closed.loops)
        self.configurations = Configurations(walk, self.tip_moves)
        self.rounded = RoundedMoves(walk, self.tip_moves, self.configurations)
        self.on_frames, self.on_robots = self.signals.on_frames, TipFrames(walk)

    @property
    def job(self) -> Job:
        """With the poses that are known by now."""
        return self.walk.job

    def go(self, progress: Callable[[float], None]) -> None:
        """The start, all moves that the signals let it make, the rest at the end."""
        walk, count = self.walk, len(self.job.move)
        self.start()
        k = 0
        while k < count:
            progress(k / count)
            self.on_robots.settle(k)
            k = self.add(k, self.job.move[k])
        if self.on_frames.frame is not None:
            raise Refused("job.frame_end", move=walk.where(count - 1), frame=visible(self.on_frames.name))
        self.past_neighbours()
        self.on_robots.require_still()
        walk.remarks += self.signals.remarks()
        walk.remarks += [
            Remark("good", "job.new_parts", {"part": visible(name), "count": count})
            for name, count in walk.parts.new.items()
        ]
        if self.job.simulation.settle > 0.0:
            walk.append(-1, "", "settle", rest(walk.q, self.job.simulation.settle))

    def past_neighbours(self) -> None:
        """What other robots do past the motion planned so far; at its end the robot waits until all have arrived."""
        walk = self.walk
        if walk.surroundings is None:
            return
        walk.beside = walk.surroundings.settle(walk.others(), walk.motion())
        moving = [each for each in walk.beside if not each.neighbour.stands]
        walk.remarks += [each.arrival() for each in moving]
        walk.remarks += [remark for each in moving for remark in each.never_made()]
        last = max((each.motion.duration for each in walk.beside), default=0.0)
        if last > walk.past:
            walk.append(-1, "", "settle", rest(walk.q, last - walk.past))

    def start(self) -> None:
        """Where the robot begins."""
        walk, given = self.walk, self.job.start
        if self.closed is not None:
            place = starting_place(walk.robot)
            values = place if given.joints is None else coordinates(self.job, walk.robot, given.joints)
            if given.pose is None:
                walk.q = self.closed.loops.closed_configuration(values, place, walk.where(-1))
            else:
                T = pose_matrix(given.pose, degrees=walk.degrees)
                walk.q = self.closed.closed_configurations(-1, given.pose.task, T, place)[0]
        elif given.joints is not None:
            walk.q = coordinates(self.job, walk.robot, given.joints)
        else:
            walk.q = starting_place(walk.robot)
            if given.pose is not None:
                T = pose_matrix(given.pose, degrees=walk.degrees)
                walk.q = self.configurations.configuration(-1, given.pose, T)
        walk.origin = walk.q
        if walk.surroundings is not None and walk.surroundings.rule.known_free:
            walk.remarks += walk.surroundings.rests_at(walk.q, walk.load)
        self.require_standing("job.start_meets", -1)

    def add(self, index: int, move: Move) -> int:
        """Plan one move, or several without a stop between, and append it; the index of the next."""
        walk, name = self.walk, visible(move.name)
        if move.fork is not None:
            return self.signals.decide(index, name, move.fork)
        last = self._plan(index, name, move)
        self.on_robots.note(index, last)
        searches = [one for one in self.job.move[index : last + 1] if one.until or one.until_force]
        if searches and (last > index or walk.legs[-1].frame):
            raise Refused("job.search_where", move=walk.where(index))
        if move.until:
            stop_by_signal(walk, index, move)
        elif move.until_force is not None:
            stop_by_force(walk, index)
        if any(one.outputs or one.process_wrench for one in self.job.move[index : last + 1]):
            self.signals.put_on_path(index, last)
        walk.made += last + 1 - index
        return last + 1 + self.job.move[last].skip

    def _plan(self, index: int, name: str, move: Move) -> int:
        """Append a move as its kind is planned, and those that follow without a stop; the index of the last."""
        walk = self.walk
        if move.pause is not None:
            self.signals.rest(index, name, "pause", move.pause)
        elif move.pick is not None or move.place or move.tool is not None:
            self.handle(index, name, move)
        elif move.set:
            self.signals.put(index, name, move)
        elif move.wait:
            self.signals.wait(index, name, move)
        elif self.on_frames.concerns(move):
            if self.closed is not None:
                raise Refused("job.frame_loops", move=walk.where(index))
            self.on_frames.go(index, name, move)
        elif (last := self.rounded.last(index)) is not None:
            if self.closed is not None:
                raise Refused("job.blend_loops", move=walk.where(index))
            self.rounded.along(index, last)
            return last
        elif move.path in TIP_PATHS:
            return self.tip_moves.along(index)
        elif self.closed is not None:
            self.closed.go(index, name, move)
        elif move.pose is not None:
            self.reach(index, name, move.pose)
        else:
            walk.goals.forget()
            goal = coordinates(self.job, walk.robot, move.joints or ())
            trajectory, timing, way = self.joint_moves.joint_motion(index, goal)
            walk.append(index, name, "joint", trajectory, timing, way=way)
        return index

    def handle(self, index: int, name: str, move: Move) -> None:
        """Take a part, let go of it, or change tools, as far as the hand is empty or full on this way."""
        walk = self.walk
        if (fault := hand_fault(move, walk.load.carried)) is not None:
            raise fault.complaint(walk.places, index)
        kind = "pick" if move.pick is not None else "place" if move.place else "tool"
        tip, carried = np.asarray(walk.robot.forward_kinematics(walk.q)), walk.load.carried
        begun, hold = walk.past, walk.on_tick(move.hold)
        if move.pick is not None:
            self.require_part(index, move.pick, tip)
            self.on_frames.take(move.pick, tip)
            self.on_robots.take(move.pick, tip)
        thing, rides = -1, self.on_frames.frame is not None
        if move.pick is not None:
            thing = walk.parts.take(move.pick, tip, len(walk.legs), begun + hold, brought=rides)
        self.signals.rest(index, name, kind, hold, thing=thing)
        if move.place and carried is not None and self.on_frames.frame is None:
            walk.parts.put(carried, tip, begun)
        if move.tool is None:
            walk.load = replace(walk.load, carried=move.pick)
            return
        walk.load = Load(walk.tools[move.tool])
        self.require_standing("job.tool_meets", index)

    def require_part(self, index: int, part: Grasp, tip: PoseMatrix) -> None:
        """A pick at a place where no such part lies is refused, as far as the job says where its parts lie."""
        walk = self.walk
        riding, allowed = self.on_robots.miss(part, tip), tolerances(self.job, walk.robot, index).position
        riding = self.on_frames.miss(part, tip) if riding is None else riding
        miss = walk.parts.miss(part, tip) if riding is None else riding
        if miss is None or miss <= allowed:
            return
        key, far = ("job.none_left", {}) if np.isinf(miss) else ("job.none_here", {"distance": quantity(miss, "m")})
        details = {"part": visible(part.name), "allowed": quantity(allowed, "m"), **far}
        raise Refused(key, move=walk.where(index), **details)

    def require_standing(self, key: str, index: int) -> None:
        """A start, or a tool, that meets something as soon as it is there is refused."""
        walk, around = self.walk, self.walk.surroundings
        parts = walk.parts_in_the_way(index, walk.q)
        if around is not None and not around.is_free(walk.q, walk.load, None, parts):
            checker = around.checker(walk.load, None, parts)
            contact = checker.check(walk.q).contacts[0]
            if contact.distance > 0.0 and checker.never_apart(contact.first, contact.second):
                key = "job.never_apart"
            raise Refused(key, move=walk.where(index), contact=said_of(contact, checker.clearance))

    def reach(self, index: int, name: str, goal: Goal) -> None:
        """To a pose, all joints together."""
        walk = self.walk
        target = walk.target(goal, walk.q)
        configuration = self.configurations.configuration(index, goal, target)
        trajectory, timing, way = self.joint_moves.joint_motion(
            index, configuration, lambda: self.configurations.others(index, goal, target)
        )
        configuration = configuration if way is None else way.plan.path[-1]
        walk.append(index, name, "joint", trajectory, timing, target, goal.task, way=way)
        walk.q = configuration
        walk.note_arrival(index, goal, target)


class SignalMoves:
    """Plans sets, waits and forks.

    Args:
        walk: where the robot is.
    """

    def __init__(self, walk: Walk) -> None:
        self.walk, self.on_frames = walk, FrameMoves(walk)

    def rest(
        self, index: int, name: str, kind: str, duration: float, *, decision: Decision | None = None, thing: int = -1
    ) -> None:
        """The arm stands still, or stays on the frame that carries it [s]."""
        carried = self.on_frames.name if self.on_frames.frame else ""
        still = self.on_frames.stay(index, duration)
        self.walk.append(index, name, kind, still, decision=decision, thing=thing, frame=carried)

    def put(self, index: int, name: str, move: Move) -> None:
        """Outputs take values at the next tick."""
        walk = self.walk
        self.rest(index, name or assignments(move.set), "set", walk.on_tick(0.0))
        walk.signals.put(walk.past, move.set)

    def put_on_path(self, first: int, last: int) -> None:
        """Outputs take values at ticks while moves first .. last, made without a stop between, are under way."""
        walk, leg = self.walk, self.walk.legs[-1]
        start, t = walk.past - leg.trajectory.duration, np.linspace(0.0, leg.trajectory.duration, PATH_SAMPLES)
        tips = np.asarray(walk.robot.forward_kinematics(leg.trajectory.at(t).u))
        corners = [
            0,
            *corner_rows(tips, walk.targets(first, last, leg.trajectory.at(0.0).u)[:-1] if first < last else []),
        ]
        corners.append(len(t) - 1)
        found: list[tuple[float, dict[str, SignalValue]]] = []
        for index, (low, high) in zip(range(first, last + 1), pairwise(corners), strict=True):
            way = np.append(0.0, np.cumsum(np.linalg.norm(np.diff(tips[low : high + 1, :3, 3], axis=0), axis=1)))
            for output in walk.job.move[index].outputs:
                after = _moment(output, t[low : high + 1], way)
                if after is None:
                    details = {"length": quantity(float(way[-1]), "m"), "duration": quantity(t[high] - t[low], "s")}
                    raise Refused("job.output_beyond", move=walk.where(index), **details)
                found.append((walk.signals.tick_at(start + after) - start, output.set))
        found.sort(key=lambda one: one[0])
        for after, values in found:
            walk.signals.put(start + after, values)
        walk.legs[-1] = replace(leg, ends=tuple(t[corners[1:]].tolist()), outputs=tuple(found))

    def wait(self, index: int, name: str, move: Move) -> None:
        """A rest until all conditions hold; one that never ends, or too late, is refused."""
        walk = self.walk
        past, wanted = walk.past, conditions(move.wait)
        others = walk.others_that_set(move.wait)
        if others is not None and self.on_frames.frame is not None:
            raise Refused("job.frame_waits", move=walk.where(index), frame=visible(self.on_frames.name))
        if others is None:
            end = walk.signals.end_of_wait(past, move.wait, move.timeout)
        else:
            end = others.end_of_wait(walk.motion(), past, move.wait, move.timeout)
        if end is not None:
            self.rest(index, name or wanted, "wait", end - past)
            return
        details = {"move": walk.where(index), "time": quantity(past, "s"), "wanted": wanted}
        if others is not None and (standing := others.waiting(others.owners(move.wait))):
            raise Refused("job.deadlock", **details, others=Standstill(tuple(standing)))
        late = None if move.timeout is None else walk.signals.end_of_wait(past, move.wait)
        if late is not None and move.timeout is not None:
            times = {"limit": quantity(move.timeout, "s"), "needed": quantity(late - past, "s")}
            raise Refused("job.wait_late", **details, **times)
        raise Refused("job.wait_never", **details, state=walk.signals.states(tuple(move.wait), past))

    def decide(self, index: int, name: str, fork: Fork) -> int:
        """Signals are looked at at the next tick; the index of the next move."""
        walk = self.walk
        pause = walk.on_tick(0.0)
        others = walk.others_that_set(fork.tests)
        if others is not None and self.on_frames.frame is not None:
            raise Refused("job.frame_waits", move=walk.where(index), frame=visible(self.on_frames.name))
        if others is not None:
            others.settle(walk.motion(), fork.tests, walk.past + pause)
        decision = decide_fork(walk.job, fork, walk.signals, walk.past + pause)
        self.rest(index, name or conditions(fork.tests), "if", pause, decision=decision)
        return index + 1 + (0 if decision.holds else fork.skip)

    def remarks(self) -> list[Remark]:
        """How long the arm waits for signals, if it does; which moves no signal let it make."""
        return [*self._wait(), *self._never_made()]

    def _wait(self) -> list[Remark]:
        waits = [leg for leg in self.walk.legs if leg.kind == "wait"]
        if not waits:
            return []
        longest = max(waits, key=lambda leg: leg.trajectory.duration)
        details = {
            "total": quantity(sum(leg.trajectory.duration for leg in waits), "s"),
            "longest": quantity(longest.trajectory.duration, "s"),
            "move": self.walk.where(longest.index),
            "wanted": conditions(self.walk.job.move[longest.index].wait),
        }
        return [Remark("good", "job.waited", details)]

    def _never_made(self) -> list[Remark]:
        """For each choice of the file that was come to: the way that was never taken."""
        walk, job = self.walk, self.walk.job
        taken: dict[object, set[bool]] = {}
        first: dict[object, int] = {}
        for leg in walk.legs:
            if leg.decision is not None:
                place = job.origins[leg.index] if job.origins else leg.index
                taken.setdefault(place, set()).add(leg.decision.holds)
                first.setdefault(place, leg.index)
        found: list[Remark] = []
        for place, ways in taken.items():
            fork = job.move[first[place]].fork
            assert fork is not None
            details = {"move": walk.where(first[place]), "tests": conditions(fork.tests)}
            if ways == {False}:
                found.append(Remark("good", "job.loop_never" if fork.loop else "job.then_never", details))
            elif ways == {True} and fork.other:
                found.append(Remark("good", "job.else_never", details))
        return found


def _moment(output: PathOutput, t: Floats, way: Floats) -> float | None:
    """When an output on the way takes its value, the tip at times (k,) at lengths (k,) of its path; None if never."""
    if output.after is not None:
        return float(t[0]) + output.after if output.after <= t[-1] - t[0] else None
    if output.share is not None and way[-1] <= STILL:
        return float(t[0] + output.share * (t[-1] - t[0]))
    place = way[-1] * output.share if output.share is not None else output.distance or 0.0
    place += way[-1] if place < 0.0 else 0.0
    if not -STILL <= place <= way[-1] + STILL:
        return None
    return float(np.interp(place, way, t))
