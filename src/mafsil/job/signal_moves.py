"""Moves of a job by which arm and cell talk: outputs, waits, and choices by what signals are."""

from __future__ import annotations

from mafsil.job.cell_signals import assignments, conditions
from mafsil.job.decision import decided
from mafsil.job.description import Move
from mafsil.job.remark import Refused, Remark
from mafsil.job.signals import Fork
from mafsil.job.standstill import Standstill
from mafsil.job.walk import Walk
from mafsil.messages.quantities import quantity
from mafsil.trajectory.profiles import rest


class SignalMoves:
    """Plans sets, waits and forks.

    Args:
        walk: where the robot is.
    """

    def __init__(self, walk: Walk) -> None:
        self.walk = walk

    def put(self, index: int, name: str, move: Move) -> None:
        """Outputs take values at the next tick."""
        walk = self.walk
        walk.append(index, name or assignments(move.set), "set", rest(walk.q, walk.on_tick(0.0)))
        walk.signals.put(walk.past, move.set)

    def wait(self, index: int, name: str, move: Move) -> None:
        """A rest until all conditions hold; one that never ends, or too late, is refused."""
        walk = self.walk
        past, wanted = walk.past, conditions(move.wait)
        others = walk.others_that_set(move.wait)
        if others is None:
            end = walk.signals.end_of_wait(past, move.wait, move.timeout)
        else:
            end = others.end_of_wait(walk.motion(), past, move.wait, move.timeout)
        if end is not None:
            walk.append(index, name or wanted, "wait", rest(walk.q, end - past))
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
        if others is not None:
            others.settle(walk.motion(), fork.tests, walk.past + pause)
        decision = decided(walk.job, fork, walk.signals, walk.past + pause)
        walk.append(index, name or conditions(fork.tests), "if", rest(walk.q, pause), decision=decision)
        return index + 1 + (0 if decision.holds else fork.skip)

    def remarks(self) -> list[Remark]:
        """How long the arm waits for signals, if it does; which moves no signal let it make."""
        return [*self._waited(), *self._never_made()]

    def _waited(self) -> list[Remark]:
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
