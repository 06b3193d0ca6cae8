"""Other robots while the robot of a job is planned: each as far as it has come, with the signals that it sets.

While the robot of the job waits for a signal of another one it stands, and the others go on: the earliest first, each
as far as signals let it. When the signal has come they are taken back to that moment, and go on from there once it is
known what the robot of the job does next. Where robots wait for each other, that is said.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from mafsil.arrays import JointVector, PoseMatrix
from mafsil.job.language.part import Condition
from mafsil.job.language.surrounding_tables import OtherMove
from mafsil.job.planning.cell_signals import (
    INSTANT,
    LONGEST_WAIT,
    CellSignals,
    Decision,
    assignments,
    conditions,
    decide_fork,
)
from mafsil.job.planning.neighbours import MAIN, SECONDS, Neighbour, Neighbourhood, OtherStep
from mafsil.job.planning.placed_parts import PlacedParts
from mafsil.job.remark import Refused, said_of
from mafsil.messages import say
from mafsil.messages.quantities import quantity
from mafsil.planning import TimedArm, plan_around_moving
from mafsil.planning.waiting_places import standing
from mafsil.trajectory.profiles import rest


@dataclass(eq=False, slots=True)
class _Program:
    """What one of the other robots has done so far.

    Attributes:
        neighbour: the robot.
        still: it, standing where it begins.
        steps: its moves so far.
        known: its motion so far, if that has been put together.
    """

    neighbour: Neighbour
    still: TimedArm
    steps: list[OtherStep] = field(default_factory=list[OtherStep])
    known: TimedArm | None = None

    @property
    def moves(self) -> tuple[OtherMove, ...]:
        return self.neighbour.asked.move

    @property
    def clock(self) -> float:
        """When what it has done ends [s]."""
        return self.steps[-1].end if self.steps else 0.0

    @property
    def q(self) -> JointVector:
        """Where it is then."""
        return self.steps[-1].q if self.steps else self.neighbour.start

    @property
    def index(self) -> int:
        """Of its next move."""
        return self.steps[-1].after if self.steps else 0

    @property
    def motion(self) -> TimedArm:
        """What it has done; it stands afterwards."""
        if self.known is None:
            done = [step.part for step in self.steps if step.part is not None]
            starts = np.cumsum([0.0, *(each.duration for each in done)])
            parts = tuple(part for each in done for part in each.parts)
            inner = [begin + each.starts[:-1] for begin, each in zip(starts, done, strict=False)]
            rests = tuple(each for one in done for each in one.rests)
            times = np.concatenate([*inner, starts[-1:]])
            self.known = TimedArm(parts, times, rests, done[0].acceleration) if done else self.still
        return self.known

    @property
    def next(self) -> OtherMove | None:
        """Its next move; None where it has done all."""
        return self.moves[self.index] if self.index < len(self.moves) else None


class Beside:
    """The other robots of a job that move.

    Args:
        around: the robot of the job among them.
        signals: of the job.
        seed: of the searches.
        parts: what the robot of the job has put down so far, and takes again.
    """

    def __init__(self, around: Neighbourhood, signals: CellSignals, seed: int, parts: PlacedParts) -> None:
        self.around, self.signals, self.seed, self.parts = around, signals, seed, parts
        self.programs = {
            each.asked.name: _Program(each, standing(each.start, around.own_limits(each.asked.name, signals.job, 1.0)))
            for each in around.moving
        }

    def owners(self, names: Iterable[str]) -> list[str]:
        """The robots that set signals, or the outputs that they follow."""
        inputs = self.signals.job.input
        sources = {(inputs[name].follows or name) if name in inputs else name for name in names}
        return [
            name for name, program in self.programs.items()
            if any(sources & set(move.set) for move in program.moves)
        ]  # fmt: skip

    def end_of_wait(
        self, main: TimedArm, past: float, wanted: Mapping[str, Condition], timeout: float | None
    ) -> float | None:
        """When the robot of the job, standing since `past`, goes on; None where what it waits for does not come.

        Args:
            main: its motion up to `past`.
            past: when its wait begins [s].
            wanted: what it waits for.
            timeout: longest wait [s].
        """
        owners = self.owners(wanted)
        limit = past + (LONGEST_WAIT if timeout is None else timeout)
        found = self.signals.end_of_wait(past, wanted, timeout)
        while owners and (found is None or found > self._known_until(owners) + INSTANT):
            if not self._go_on(main, limit):
                break
            found = self.signals.end_of_wait(past, wanted, timeout)
        if found is not None:
            self._take_back(found)
        return found

    def settle(self, main: TimedArm, names: Iterable[str], moment: float) -> None:
        """Others go on until it is known what signals are at a moment, then are taken back to it [s]."""
        owners = self.owners(names)
        while owners and self._known_until(owners) < moment - INSTANT and self._go_on(main, moment):
            pass
        self._take_back(moment)

    def stand(self, name: str, main: TimedArm, moment: float) -> JointVector:
        """(n,) where one of the robots stands at a moment [s], or begins the move that it is making then.

        Args:
            name: of the robot.
            main: motion of the robot of the job up to that moment.
            moment: up to which the others go on.
        """
        program = self.programs[name]
        while program.next is not None and program.clock < moment - INSTANT and self._go_on(main, moment):
            pass
        self._take_back(moment)
        return program.q

    def finish(self, main: TimedArm) -> dict[str, TimedArm]:
        """All that the others have to do past the whole motion of the robot of the job; the motions of all.

        Raises:
            Refused: a move for which no way was found, a wait that never ends, a rest that is in the way, a part that
                was put down there.
        """
        while self._go_on(main, np.inf):
            pass
        waiting = self.waiting()
        if waiting:
            first, *others = waiting
            details = {"name": first.name, "number": first.number, "wanted": first.wanted}
            details |= {"time": quantity(first.since, "s")}
            if others:
                raise Refused("job.other_standstill", **details, others=Standstill(tuple(others)))
            move = self.programs[first.robot].next
            assert move is not None
            late = None if move.timeout is None else self.signals.end_of_wait(first.since, move.wait)
            if late is not None and move.timeout is not None:
                details |= {"limit": quantity(move.timeout, "s"), "needed": quantity(late - first.since, "s")}
                raise Refused("job.other_wait_late", **details)
            raise Refused("job.other_wait_never", **details, state=self.signals.states(tuple(move.wait), first.since))
        motions = {MAIN: main, **{name: program.motion for name, program in self.programs.items()}}
        self._require_proved(motions)
        return motions

    def steps(self, name: str) -> tuple[OtherStep, ...]:
        """The moves of one of the robots, as far as they are planned."""
        return tuple(self.programs[name].steps)

    def waiting(self, names: Iterable[str] | None = None) -> list[Standing]:
        """The robots, all or some, that wait for signals that do not come."""
        return [
            Standing(
                name, program.neighbour.name, move.number, conditions(move.wait), program.clock
            )
            for name, program in self.programs.items()
            if (names is None or name in names) and (move := program.next) is not None and move.wait
        ]  # fmt: skip

    def _known_until(self, owners: Iterable[str]) -> float:
        """Up to when the signals of robots are known [s]."""
        clocks = [np.inf if self.programs[each].next is None else self.programs[each].clock for each in owners]
        return min(clocks, default=np.inf)

    def _go_on(self, main: TimedArm, limit: float) -> bool:
        """One move of one robot, that which begins first; False where all are done, wait, or are beyond a moment.

        1. Moves that need no signal; waits that end, and choices that are made, while all that they look at is known.
        2. If there is none, the wait or choice that ends first: until then no signal changes.
        """
        left = [(each, each.next) for each in self.programs.values() if each.clock <= limit + INSTANT]
        ends: list[tuple[float, _Program, OtherMove]] = []
        for program, move in sorted(left, key=lambda each: each[0].clock):
            if move is None:
                continue
            if not move.wait and move.fork is None:
                self._move(program, move, main)
                return True
            if move.fork is not None:
                looked_at, end = [*move.fork.tests], self.signals.tick_after(program.clock)
            else:
                looked_at, end = [*move.wait], self.signals.end_of_wait(program.clock, move.wait, move.timeout)
            others = [name for name in self.owners(looked_at) if self.programs[name] is not program]
            if end is not None and end <= self._known_until(others or ()) + INSTANT:
                self._rest(program, move, end - program.clock)
                return True
            if end is not None:
                ends.append((end, program, move))
        if not ends:
            return False
        end, program, move = min(ends, key=lambda each: each[0])
        self._rest(program, move, end - program.clock)
        return True

    def _take_back(self, moment: float) -> None:
        """What ends later than a moment is not yet done."""
        for program in self.programs.values():
            while program.steps and program.steps[-1].end > moment + INSTANT:
                undone, program.known = program.steps.pop(), None
                self.signals.take_back(program.moves[undone.index].set, moment)

    def _rest(self, program: _Program, move: OtherMove, length: float) -> None:
        name = program.neighbour.asked.name
        limits = self.around.own_limits(name, self.signals.job, move.speed)
        most = standing(program.q, limits).acceleration
        part = TimedArm((rest(program.q, length),), np.array([0.0, length]), (True,), most)
        if move.fork is not None:
            decision = decide_fork(self.signals.job, move.fork, self.signals, program.clock + length)
            return self._add(program, "if", conditions(move.fork.tests), part, program.q, decision)
        kind = "pause" if move.pause is not None else "set" if move.set else "wait"
        text = assignments(move.set) or conditions(move.wait)
        return self._add(program, kind, text, part, program.q)

    def _add(
        self, program: _Program, kind: str, text: str, part: TimedArm | None, q: JointVector,
        decision: Decision | None = None,
    ) -> None:  # fmt: skip
        begin, index = program.clock, program.index
        move = program.moves[index]
        passed = move.fork.skip if decision is not None and move.fork is not None and not decision.holds else 0
        end = begin + (0.0 if part is None else part.duration)
        program.known = None
        after = index + 1 + move.skip + passed
        program.steps.append(OtherStep(move.number, kind, text, begin, end, part, q, index, after, decision))

    def _move(self, program: _Program, move: OtherMove, main: TimedArm) -> None:
        """One move but a wait."""
        each, clock = program.neighbour, program.clock
        if move.pause is not None:
            return self._rest(program, move, move.pause)
        if move.set:
            self._rest(program, move, self.signals.tick_after(clock) - clock)
            return self.signals.put(program.clock, move.set)
        index = program.index
        goal = each.goal(index, program.q)
        if each.goals[index] is not None and np.array_equal(goal, program.q):
            return self._add(program, "joint", "", None, program.q)
        part, within = self._way(program, move, goal, main), each.robot.limits
        known = each.goals[index]
        q = np.clip(part.at(part.duration), within.lower, within.upper) if known is None else known
        return self._add(program, "joint", "", part, q)

    def _way(self, program: _Program, move: OtherMove, goal: JointVector | PoseMatrix, main: TimedArm) -> TimedArm:
        """Its motion to a goal, past all that is settled and the parts that lie in its way."""
        each, clock, name = program.neighbour, program.clock, program.neighbour.asked.name
        settled = {MAIN: main} | {
            other: one.motion for other, one in self.programs.items() if one is not program and one.steps
        }
        others = {other: motion.later(clock) for other, motion in settled.items()}
        starts = {other: one.neighbour.start for other, one in self.programs.items()}
        start = starts | {other: motion.at(0.0) for other, motion in others.items()} | {name: program.q}
        limits = self.around.limits(self.signals.job, move.speed)
        # Parts that are put down later count only where the way that is found without them would meet them.
        here = [stay for stay in self.parts.stays if stay.put <= clock < stay.taken]
        later = [stay for stay in self.parts.stays if stay.put > clock]
        for stays in (here, [*here, *later]):
            cell = self.around.among_parts([stay.body for stay in stays])
            found = plan_around_moving(cell, name, start, goal, limits, others, seed=self.seed, seconds=SECONDS)
            if not found:
                raise Refused("job.other_no_way", name=each.name, number=move.number, reason=found)
            part = found.motions[name]
            soon = [stay for stay in later if stay.put < clock + part.duration]
            if not any(self.around.near_part(name, part.later(-clock), stay) for stay in soon):
                break
        return part

    def _require_proved(self, motions: Mapping[str, TimedArm]) -> None:
        """Where a robot rests while others move, the whole is proved once more; all of it beside parts put down."""
        rests = any(
            step.kind in ("pause", "set", "wait", "if") for each in self.programs.values() for step in each.steps
        )
        moment = self.around.unproved_from(motions) if rests else None
        if moment is not None:
            contact = self.around.contact(motions, moment)
            raise Refused("job.other_meets", time=quantity(moment, "s"), contact=said_of(contact))
        for name, program in self.programs.items():
            for stay in self.parts.stays:
                near = self.around.near_part(name, motions[name], stay)
                if near is not None:
                    time, contact = near
                    details = {"name": program.neighbour.name, "time": quantity(time, "s"), "contact": said_of(contact)}
                    raise Refused("job.other_meets_part", **details, part=stay.body.name)


@dataclass(frozen=True, slots=True)
class Standing:
    """A robot that waits for what does not come.

    Attributes:
        robot: its name in the file.
        name: as sentences call it.
        number: of the move at which it waits, from 1.
        wanted: what for.
        since: when the wait begins [s].
    """

    robot: str
    name: str
    number: int
    wanted: str
    since: float


@dataclass(frozen=True, slots=True)
class Standstill:
    """Robots that wait, for sentences in any language."""

    robots: tuple[Standing, ...]

    def explain(self, *, language: str | None = None) -> str:
        """`right, move 2, waits from 1.2 s on for a = true`."""
        words = [
            say(
                "job.stands", language=language, name=one.name, number=one.number, wanted=one.wanted,
                time=quantity(one.since, "s"),
            )
            for one in self.robots
        ]  # fmt: skip
        return say("job.list_separator", language=language).join(words)
