"""A chunk of drawn runs, side by side: through one scenario after the other, and what is kept of each run."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from time import perf_counter
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.control.laws import LawMemory
from mafsil.lazy_module import lazily
from mafsil.simulation.fused import can_fuse
from mafsil.simulation.recording import Recording
from mafsil.simulation.run import Run
from mafsil.simulation.scenario import Scenario
from mafsil.simulation.tolerances import PART_OF_STEP
from mafsil.simulation.variation import Variants
from mafsil.simulation.varied_run import VariedFusedRun, VariedRun, runaway_of

if TYPE_CHECKING:
    import mafsil.simulation.tally_loops as tally_loops
    from mafsil.simulation.tally_loops import Tally
else:
    tally_loops = lazily("mafsil.simulation.tally_loops")

WINDOW_NUMBERS = 40_000
"""Numbers of each kind that pass through the processor's cache at a time."""
CHUNK_NUMBERS = 16_000_000
"""Numbers of eight bytes that the recordings of a chunk hold, about."""
MOST_IN_CHUNK = 256


@dataclass(frozen=True, eq=False, slots=True)
class Outcomes:
    """What is kept of b runs.

    Attributes:
        end: (b,) when the run ended [s].
        finished: (b,) whether it reached its end with finite numbers.
        lost: (b,) whether it ended where its loops could not be followed: near lost rank, or torn by its efforts.
        tip_error, tip_rotation: (b,) largest on the way, infinite where it did not [m], [rad].
        tip_rms: (b,) root mean square over time [m].
        joint_rms: (b, n) of the error of each joint [rad | m].
        effort: (b, n) largest magnitude [N m | N].
        saturated: (b,) share of the ticks at which an effort was clipped.
        work: (b,) sum of the magnitudes of power times time [J].
        marked: (b, m, n) positions at the marked times, NaN where a run ended before [rad | m].
    """

    end: Floats
    finished: NDArray[np.bool_]
    lost: NDArray[np.bool_]
    tip_error: Floats
    tip_rotation: Floats
    tip_rms: Floats
    joint_rms: Floats
    effort: Floats
    saturated: Floats
    work: Floats
    marked: Floats

    def arrays(self) -> dict[str, Any]:
        """By name."""
        return {name: getattr(self, name) for name in Outcomes.__slots__}


@dataclass(frozen=True, eq=False, slots=True)
class _Part:
    """What one scenario made of b runs.

    Attributes:
        tally: sums and peaks.
        q, qd: (b, n) the state at its last tick.
        marked: (b, m, n) positions at its marks.
        lost: (b,) runs whose loops could not be followed.
    """

    tally: Tally
    q: Floats
    qd: Floats
    marked: Floats
    lost: NDArray[np.bool_]


def chunk_size(scenarios: Sequence[Scenario]) -> int:
    """Runs in a chunk: decided by the scenarios alone, so that chunks are the same everywhere."""
    if all(map(can_fuse, scenarios)):
        return MOST_IN_CHUNK
    numbers = max(len(scenario.ticks()) * (8 * scenario.robot.n + 8) for scenario in scenarios)
    return max(1, min(MOST_IN_CHUNK, CHUNK_NUMBERS // numbers))


def chunk_outcomes(scenarios: Sequence[Scenario], marks: Sequence[Floats], variants: Variants) -> Outcomes:
    """What is kept of the runs of one chunk.

    1. Each scenario begins where the one before ended, its law with what that remembers; a run that did not come to
       its end waits at rest, uncounted.
    2. The last tick of a scenario is the first one of the next, and is counted there.

    Args:
        scenarios: one run, as motions that follow each other.
        marks: for each, times at which positions are kept [s].
        variants: what differs between the runs.
    """
    alive = np.ones(variants.count, np.bool_)
    start: tuple[Floats, Floats] | None = None
    parts: list[_Part] = []
    memory = LawMemory()
    for k, scenario in enumerate(scenarios):  # 1
        part = _part(_from(scenario, variants, start, alive), marks[k], memory, last=k == len(scenarios) - 1)  # 2
        part.tally.ends[~alive] = 0
        whole = part.tally.ends == part_ticks(scenario, last=k == len(scenarios) - 1)
        ended = scenario.ticks()[np.maximum(part.tally.ends - 1, 0)]
        part.marked[~whole[:, None] & (marks[k] > ended[:, None] + PART_OF_STEP)] = np.nan
        part.marked[~alive] = np.nan
        part.lost[~alive] = False
        alive = alive & whole
        alive &= np.isfinite(part.q).all(axis=1) & np.isfinite(part.qd).all(axis=1)
        start = part.q, part.qd
        parts.append(part)
    return _outcomes(parts, scenarios, alive)


def part_ticks(scenario: Scenario, *, last: bool) -> int:
    """Ticks of a scenario that are counted; all but the last one where another scenario follows."""
    return len(scenario.ticks()) - (not last)


def _from(
    scenario: Scenario, variants: Variants, start: tuple[Floats, Floats] | None, alive: NDArray[np.bool_]
) -> Scenario:
    """The scenario from where the runs are; those that are no longer counted begin at its reference."""
    if start is None:
        return replace(scenario, variants=variants)
    u = scenario.trajectory.at(0.0).u
    q, qd = np.where(alive[:, None], start[0], u), np.where(alive[:, None], start[1], 0.0)
    return replace(scenario, variants=replace(variants, start=None), q=q, qd=qd)


def _part(scenario: Scenario, marks: Floats, memory: LawMemory, *, last: bool) -> _Part:
    count = part_ticks(scenario, last=last)
    if can_fuse(scenario):
        passing = _Passing(scenario)
        passing.memory = memory
        return passing.part(marks, count)
    run = VariedRun(scenario)
    run.memory = memory
    run.to_the_end(None)
    return _record(run, marks, count)


def recorded_alone(scenario: Scenario, memory: LawMemory) -> Recording:
    """The recording of a chunk's run by itself; a run whose loops are lost goes on with numbers that mean nothing.

    Args:
        scenario: with the variants of one run.
        memory: of what its law remembers, from scenario to scenario.
    """
    run = (VariedFusedRun if can_fuse(scenario) else VariedRun)(scenario)
    run.memory = memory
    began = perf_counter()
    status = run.to_the_end(None)
    return run.recording(status, perf_counter() - began)


class _Marks:
    """States at the ticks before and after each marked time."""

    def __init__(self, run: Run, times: Floats, b: int) -> None:
        ticks, n = run.t, run.scenario.robot.n
        self.k = np.clip(np.searchsorted(ticks, times + PART_OF_STEP, side="right") - 1, 0, max(len(ticks) - 2, 0))
        step = run.scenario.control_period
        self.step, self.u = step, np.clip((times - ticks[self.k]) / step, 0.0, 1.0)
        self.states = np.full((len(times), 2, b, 2, n), np.nan)

    def see(self, first: int, states: Floats) -> None:
        """The states (k, b, 2, n) of some ticks, from tick `first` on."""
        for m, k in enumerate(self.k):
            for side in (0, 1):
                if 0 <= k + side - first < len(states):
                    self.states[m, side] = states[k + side - first]

    def positions(self) -> Floats:
        """(b, m, n) by the cubic that has positions and rates of both ticks."""
        (a, va), (b, vb) = (np.moveaxis(self.states[:, side], 2, 0) for side in (0, 1))
        u = self.u[:, None, None]
        rise = u * u * (3.0 - 2.0 * u)
        found = a + rise * (b - a) + self.step * (u * (1.0 - u) ** 2 * va + u * u * (u - 1.0) * vb)
        return np.swapaxes(found, 0, 1)


class _Passing(VariedFusedRun):
    """Runs of which only sums and peaks are kept: ticks pass in windows that fit into the processor's cache."""

    def __init__(self, scenario: Scenario) -> None:
        rows = scenario.start()[0].size
        self.window = max(8, WINDOW_NUMBERS // rows)
        super().__init__(scenario)

    def part(self, marks: Floats, count: int) -> _Part:
        """All ticks, of which `count` are counted."""
        loop, total, n = self.loop, len(self.t), self.scenario.robot.n
        b = loop.states.shape[1]
        tally = tally_loops.tally_of(np.full(b, count), n)
        reference, marked = np.ascontiguousarray(self.reference.u)[:, None], _Marks(self, marks, b)
        state = loop.closed[0]
        self._begin_memory()
        for first in range(0, total, loop.window):
            last = min(first + loop.window, total)
            loop.advance(first, last)
            self.see_lost(first, loop.doubt[: last - first], loop.states[: last - first])
            np.minimum(tally.ends, self.ends, out=tally.ends)
            marked.see(first, loop.closed[: last - first])
            q, qd = (loop.closed[: last - first, :, part] for part in (0, 1))
            tau, command, tip = (x[: last - first] for x in (loop.effort, loop.command, loop.tip_errors))
            tally_loops.add(tally, first, q, qd, tau, command, reference[first:last], tip, runaway_of(n))
            state = loop.closed[last - first - 1]
        self._end_memory(total - 1)
        return _Part(tally, state[:, 0].copy(), state[:, 1].copy(), marked.positions(), self.lost)


def _record(run: VariedRun, marks: Floats, count: int) -> _Part:
    """Of runs that were recorded."""
    n, u = run.q.shape[-1], np.ascontiguousarray(run.reference.u)[:, None]
    tally = tally_loops.tally_of(np.minimum(run.ends, count), n)
    tip = np.stack(run.tip_errors(slice(None), run.q, u), axis=-1)
    tally_loops.add(tally, 0, run.q, run.qd, run.tau, run.commanded, u, tip, runaway_of(n))
    marked = _Marks(run, marks, len(run.ends))
    marked.see(0, np.stack([run.q, run.qd], axis=2))
    # A run that blew up at the very last tick still has its ticks before.
    q, qd = run.q[-1].copy(), run.qd[-1].copy()
    qd[run.ends < len(run.t)] = np.nan
    return _Part(tally, q, qd, marked.positions(), run.lost)


def _outcomes(parts: list[_Part], scenarios: Sequence[Scenario], finished: NDArray[np.bool_]) -> Outcomes:
    tallies = [part.tally for part in parts]
    counted = np.stack([tally.ends for tally in tallies])
    ticks = np.maximum(counted.sum(axis=0), 1)
    tip = np.max([tally.tip for tally in tallies], axis=0)
    squares = sum((tally.tip_squares for tally in tallies[1:]), tallies[0].tip_squares)
    joints = sum((tally.joint_squares for tally in tallies[1:]), tallies[0].joint_squares)
    clipped = sum((tally.clipped for tally in tallies[1:]), tallies[0].clipped)
    periods = [scenario.control_period for scenario in scenarios]
    marked = np.concatenate([part.marked for part in parts], axis=1)
    end = _ends(counted, scenarios, finished)
    return Outcomes(
        end=end,
        finished=finished,
        lost=np.logical_or.reduce([part.lost for part in parts]),
        tip_error=np.where(finished, tip[:, 0], np.inf),
        tip_rotation=np.where(finished, tip[:, 1], np.inf),
        tip_rms=np.where(finished, np.sqrt(squares / ticks), np.inf),
        joint_rms=np.sqrt(joints / ticks[:, None]),
        effort=np.max([tally.effort for tally in tallies], axis=0),
        saturated=clipped / ticks,
        work=np.sum([tally.power * period for tally, period in zip(tallies, periods, strict=True)], axis=0),
        marked=marked,
    )


def _ends(counted: NDArray[np.int64], scenarios: Sequence[Scenario], finished: NDArray[np.bool_]) -> Floats:
    """(b,) when each run ended, in the time of all scenarios [s]."""
    times = [scenario.ticks() for scenario in scenarios]
    begins = np.concatenate([[0.0], np.cumsum([t[-1] for t in times])])
    end = np.full(len(finished), begins[-1])
    for k in range(len(scenarios) - 1, -1, -1):
        short = counted[k] < part_ticks(scenarios[k], last=k == len(scenarios) - 1)
        end = np.where(short, begins[k] + times[k][np.maximum(counted[k] - 1, 0)], end)
    return end
