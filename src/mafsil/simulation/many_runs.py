"""Many runs of one scenario whose plants, gains, delays and starts are drawn: how robust a law is, as numbers.

1. Run k is drawn from the seed and k alone, whatever runs beside it and wherever.
2. Runs go in chunks of equal size, as many side by side as memory is given for; a chunk is one call, here or on any
   executor, and leaves a few numbers for each run.
3. What remains of a run can be run again with its recording: `again(k)`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, positive, require_function, require_kind, whole
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.messages.tables import number, on_screen, table
from mafsil.simulation.fused import can_fuse
from mafsil.simulation.loop import simulate
from mafsil.simulation.recording import Recording
from mafsil.simulation.run import FusedRun, Progress
from mafsil.simulation.scenario import Scenario
from mafsil.simulation.variation import Variants, Variation, drawn
from mafsil.simulation.varied_run import VariedRun, runaway_of

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
MOST_RUNS = 1_000_000
CONFIDENCE = 1.959963984540054
"""Standard deviations of a confidence of 95 %."""


class Future(Protocol):
    """Work that was given away."""

    def result(self) -> Any:
        """What came out, as soon as it has."""
        ...


class Executor(Protocol):
    """Who works: an executor of `concurrent.futures`, or a `dask.distributed.Client`."""

    def submit(self, fn: Callable[..., Any], /, *args: Any) -> Future:
        """Begin a call."""
        ...


class MonteCarloStatus(Status):
    """Whether all runs reached their end."""

    ALL_FINISHED = ("simulation.all_finished", True)
    SOME_FAILED = ("simulation.some_failed", False)


@dataclass(frozen=True, eq=False, slots=True)
class Outcomes:
    """What is kept of b runs.

    Attributes:
        end: (b,) when the run ended [s].
        finished: (b,) whether it reached its end with finite numbers.
        tip_error, tip_rotation: (b,) largest on the way, infinite where it did not [m], [rad].
        tip_rms: (b,) root mean square over time [m].
        joint_rms: (b, n) of the error of each joint [rad | m].
        effort: (b, n) largest magnitude [N m | N].
        saturated: (b,) share of the ticks at which an effort was clipped.
        work: (b,) sum of the magnitudes of power times time [J].
    """

    end: Floats
    finished: NDArray[np.bool_]
    tip_error: Floats
    tip_rotation: Floats
    tip_rms: Floats
    joint_rms: Floats
    effort: Floats
    saturated: Floats
    work: Floats

    def arrays(self) -> dict[str, Any]:
        """By name."""
        return {name: getattr(self, name) for name in Outcomes.__slots__}


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class MonteCarlo(Answer):
    """All runs; true if each reached its end; iterable over the numbers of runs from the worst tip error on.

    Attributes:
        scenario, variation, seed: what was run.
        variants: what was drawn.
        outcomes: of the runs.
        bound: of the tip's error that counts as good, or None [m].
    """

    scenario: Scenario
    variation: Variation
    seed: int
    variants: Variants
    outcomes: Outcomes
    bound: float | None

    @property
    def status(self) -> MonteCarloStatus:
        """Whether all runs reached their end."""
        return MonteCarloStatus.ALL_FINISHED if self.outcomes.finished.all() else MonteCarloStatus.SOME_FAILED

    def __bool__(self) -> bool:
        return self.status.succeeded

    def __len__(self) -> int:
        return self.variants.count

    def __iter__(self) -> Iterator[int]:
        return iter(np.argsort(-self.outcomes.tip_error, kind="stable").tolist())

    @property
    def share_within(self) -> tuple[float, float, float]:
        """Share of runs within the bound (all that finished, without one), and its interval of 95 % confidence.

        Reference: E. B. Wilson, Probable inference, the law of succession, and statistical inference, JASA 22, 1927.
        """
        good = self.outcomes.finished if self.bound is None else self.outcomes.tip_error <= self.bound
        return wilson(int(good.sum()), len(self))

    def quantile(self, share: float) -> float:
        """Tip error that this share of the runs does not exceed [m]; infinite where so many did not finish."""
        if not 0.0 <= share <= 1.0:
            raise InputError("input.range", name="share", value=share, low=0.0, high=1.0)
        errors = np.sort(self.outcomes.tip_error)
        return float(errors[max(0, int(np.ceil(share * len(self))) - 1)])

    @property
    def influence(self) -> dict[str, float]:
        """Rank correlation (Spearman) of each drawn number with the tip error, strongest first, in -1..1."""
        errors = _standard(_ranks(self.outcomes.tip_error))
        found: dict[str, float] = {}
        for name, column in self.variants.columns().items():
            ranks = _standard(_ranks(column))
            if ranks.any() and errors.any():
                found[name] = float(ranks @ errors)
        return dict(sorted(found.items(), key=lambda item: -abs(item[1])))

    def again(self, run: int) -> Recording:
        """The recording of one run.

        Args:
            run: its number.
        """
        k = whole("run", run, 0, len(self) - 1)
        scenario = replace(self.scenario, variants=self.variants.rows(k, k + 1))
        (only,) = simulate(scenario, fused=can_fuse(scenario))
        return only

    def explain(self, language: str | None = None) -> str:
        """How many ended well, how far off the tip was, what mattered most."""
        share, low, high = (100.0 * x for x in self.share_within)
        worst = next(iter(self))
        details = {
            "runs": len(self), "finished": int(self.outcomes.finished.sum()), "median": 1e3 * self.quantile(0.5),
            "most": 1e3 * self.quantile(0.95), "largest": 1e3 * float(self.outcomes.tip_error[worst]), "worst": worst,
        }  # fmt: skip
        sentences = [self.status.sentence(language, **details)]
        if self.bound is not None:
            within = {"share": share, "low": low, "high": high, "bound": 1e3 * self.bound}
            sentences.append(say("simulation.share_within", language=language, **within))
        strongest = next(iter(self.influence.items()), None)
        if strongest is not None:
            named = {"name": strongest[0], "correlation": strongest[1]}
            sentences.append(say("simulation.influence", language=language, **named))
        return ". ".join(sentences)

    def __repr__(self) -> str:
        head = ("", "max", "rms", *self.variants.columns())
        errors = self.outcomes
        rows = [
            (str(k), number(1e3 * errors.tip_error[k]), number(1e3 * errors.tip_rms[k]),
             *(number(column[k]) for column in self.variants.columns().values()))
            for k in list(self)[:5]
        ]  # fmt: skip
        return "\n".join([on_screen(self.explain()), *table(head, rows)])

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "status": self.status.name, "seed": self.seed, "bound": self.bound, "share_within": self.share_within,
            "influence": self.influence, "drawn": self.variants.columns(), **self.outcomes.arrays(),
        }  # fmt: skip


def monte_carlo(
    scenario: Scenario,
    variation: Variation,
    runs: int = 1000,
    *,
    seed: int = 0,
    bound: float | None = None,
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> MonteCarlo:
    """Run a scenario many times with drawn payloads, inertias, friction, gains, delays and starts.

    Laws that are expressions run as one compiled loop with all runs of a chunk side by side, on all cores; other laws
    are asked for a whole chunk at each tick, and a chunk takes about 130 MB.

    Args:
        scenario: one run; its plant is what the drawn numbers change.
        variation: what differs from run to run.
        runs: how many.
        seed: of the draws.
        bound: tip error [m] whose share of runs is reported.
        executor: where chunks are worked on, such as a `concurrent.futures.ProcessPoolExecutor` or a
            `dask.distributed.Client` (`pip install mafsil[distributed]`); None for this process. The numbers are the
            same to the last bit.
        progress: called with the fraction done; False ends it with the runs done so far.

    Raises:
        InputError: a scenario that has variants or a batch already, numbers out of their range, drawn numbers that make
            no sense (a negative mass), a variation of gains for a law without known gains.
    """
    require_kind("scenario", scenario, "Scenario", "trajectory", "law", "ticks")
    require_kind("variation", variation, "Variation", "payload", "gains")
    count, seed = whole("runs", runs, 1, MOST_RUNS), whole("seed", seed)
    if bound is not None:
        positive("bound", bound)
    if progress is not None:
        require_function("progress", progress, "function of the fraction done", 1)
    if executor is not None:
        require_kind("executor", executor, "Executor", "submit")
    if scenario.variants is not None or scenario.start()[0].ndim != 1:
        raise InputError("simulation.varied_batch", shape=scenario.start()[0].shape)
    variants = drawn(variation, scenario.true_plant.robot, scenario.control_period, count, seed)
    size = chunk_size(scenario)
    edges = [(first, min(first + size, count)) for first in range(0, count, size)]
    parts: list[Outcomes] = []
    for part in _worked(scenario, variants, edges, executor):
        parts.append(part)
        done = edges[len(parts) - 1][1]
        if progress is not None and progress(done / count) is False:
            break
    done = edges[len(parts) - 1][1]
    return MonteCarlo(scenario, variation, seed, variants.rows(0, done), _joined(parts), bound)


def chunk_size(scenario: Scenario) -> int:
    """Runs in a chunk: decided by the scenario alone, so that chunks are the same everywhere."""
    if can_fuse(scenario):
        return MOST_IN_CHUNK
    numbers = len(scenario.ticks()) * (8 * scenario.robot.n + 8)
    return max(1, min(MOST_IN_CHUNK, CHUNK_NUMBERS // numbers))


def chunk_outcomes(scenario: Scenario, variants: Variants) -> Outcomes:
    """What is kept of the runs of one chunk.

    Args:
        scenario: one run.
        variants: what differs between them.
    """
    varied = replace(scenario, variants=variants)
    if can_fuse(varied):
        return _outcomes(_Passing(varied).tally(), varied)
    run = VariedRun(varied)
    run.to_the_end(None)
    return _outcomes(_tally(run), varied)


def wilson(good: int, count: int) -> tuple[float, float, float]:
    """A share and its interval of 95 % confidence.

    Args:
        good: how many did it.
        count: of so many.
    """
    z, share = CONFIDENCE, good / count
    middle = (share + z * z / (2 * count)) / (1 + z * z / count)
    half = z * np.sqrt(share * (1 - share) / count + z * z / (4 * count * count)) / (1 + z * z / count)
    return share, max(0.0, min(share, float(middle - half))), min(1.0, max(share, float(middle + half)))


def _worked(
    scenario: Scenario, variants: Variants, edges: list[tuple[int, int]], executor: Executor | None
) -> Iterator[Outcomes]:
    parts = (variants.rows(*edge) for edge in edges)
    if executor is None:
        yield from (chunk_outcomes(scenario, part) for part in parts)
        return
    for future in [executor.submit(chunk_outcomes, scenario, part) for part in parts]:
        yield future.result()


class _Passing(FusedRun):
    """Runs of which only sums and peaks are kept: ticks pass in windows that fit into the processor's cache."""

    def __init__(self, scenario: Scenario) -> None:
        rows = scenario.start()[0].size
        self.window = max(8, WINDOW_NUMBERS // rows)
        super().__init__(scenario)

    def tally(self) -> Tally:
        """All ticks."""
        loop, total, n = self.loop, len(self.t), self.scenario.robot.n
        tally = tally_loops.tally_of(np.full(loop.states.shape[1], total), n)
        reference = np.ascontiguousarray(self.reference.u)[:, None]
        for first in range(0, total, loop.window):
            last = min(first + loop.window, total)
            loop.advance(first, last)
            q, qd = (loop.states[: last - first, :, part] for part in (0, 1))
            tau, command, tip = (x[: last - first] for x in (loop.effort, loop.command, loop.tip_errors))
            tally_loops.add(tally, first, q, qd, tau, command, reference[first:last], tip, runaway_of(n))
        return tally


def _tally(run: VariedRun) -> Tally:
    """Of runs that were recorded."""
    n, u = run.q.shape[-1], np.ascontiguousarray(run.reference.u)[:, None]
    tally = tally_loops.tally_of(run.ends.copy(), n)
    tip = np.stack(run.tip_errors(slice(None), run.q, u), axis=-1)
    tally_loops.add(tally, 0, run.q, run.qd, run.tau, run.commanded, u, tip, runaway_of(n))
    return tally


def _outcomes(tally: Tally, scenario: Scenario) -> Outcomes:
    times, ends = scenario.ticks(), tally.ends
    finished, ticks = ends == len(times), np.maximum(ends, 1)
    return Outcomes(
        end=times[ticks - 1],
        finished=finished,
        tip_error=np.where(finished, tally.tip[:, 0], np.inf),
        tip_rotation=np.where(finished, tally.tip[:, 1], np.inf),
        tip_rms=np.where(finished, np.sqrt(tally.tip_squares / ticks), np.inf),
        joint_rms=np.sqrt(tally.joint_squares / ticks[:, None]),
        effort=tally.effort,
        saturated=tally.clipped / ticks,
        work=tally.power * scenario.control_period,
    )


def _ranks(values: Floats) -> Floats:
    """Places in order, equal values at their mean."""
    _, place, counts = np.unique(values, return_inverse=True, return_counts=True)
    last = np.cumsum(counts)
    return (last - (counts - 1) / 2.0)[place]


def _standard(values: Floats) -> Floats:
    """Values less their mean, as a vector of length one; zeros where they are all equal."""
    away = values - values.mean()
    length = float(np.linalg.norm(away))
    return away / length if length > 0.0 else away


def _joined(parts: list[Outcomes]) -> Outcomes:
    return Outcomes(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in Outcomes.__slots__})
