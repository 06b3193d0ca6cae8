"""Many runs of one scenario whose plants, gains, delays and starts are drawn: how robust a law is, as numbers.

1. Run k is drawn from the seed and k alone, whatever runs beside it and wherever.
2. Runs go in chunks of equal size, as many side by side as memory is given for; a chunk is one call, here or on any
   executor, and leaves a few numbers for each run.
3. What remains of a run can be run again with its recording: `again(k)`.

Who works on many runs: this process, some processes here, or a cluster that dask knows.
"""

from __future__ import annotations

from collections.abc import Callable, Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from importlib import import_module
from typing import Any, Protocol

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, positive, real_array, require_finite, require_function, require_kind, single, whole
from mafsil.control.laws import LawMemory
from mafsil.errors import InputError
from mafsil.messages import say
from mafsil.messages.tables import number, table
from mafsil.simulation.chunk_runs import Outcomes, chunk_outcomes, chunk_size, recorded_alone
from mafsil.simulation.recording import Recording, SimulationStatus, join_recordings
from mafsil.simulation.run import Progress
from mafsil.simulation.scenario import Scenario
from mafsil.simulation.variation import Variants, Variation, drawn, drawn_name

INSTANT = 1e-9
"""Times closer than this are the same [s]."""
MOST_RUNS = 1_000_000
NAMED = 5
"""Runs that are named where many could be."""
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


@dataclass(frozen=True, eq=False, repr=False, slots=True)
class MonteCarlo(Answer, data="seed bound share_within influence"):
    """All runs; true if each reached its end; iterable over the numbers of runs from the worst tip error on.

    Attributes:
        scenarios: what was run, one after the other.
        variation, seed: of the draws.
        variants: what was drawn.
        outcomes: of the runs.
        bound: of the tip's error that counts as good, or None [m].
    """

    scenarios: tuple[Scenario, ...]
    variation: Variation
    seed: int
    variants: Variants
    outcomes: Outcomes
    bound: float | None

    @property
    def status(self) -> MonteCarloStatus:
        """Whether all runs reached their end."""
        return MonteCarloStatus.ALL_FINISHED if self.outcomes.finished.all() else MonteCarloStatus.SOME_FAILED

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
        share = float(single("share", share, ()))
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
        """The recording of one run, up to its end: that of one that blew up or lost its loops says so.

        Args:
            run: its number.
        """
        k, memory = whole("run", run, 0, len(self) - 1), LawMemory()
        variants, parts = self.variants.rows(k, k + 1), list[Recording]()
        for scenario in self.scenarios:
            if parts:
                q, qd = (x[-1:] for x in (parts[-1].q, parts[-1].qd))
                scenario, variants = replace(scenario, q=q, qd=qd), replace(variants, start=None)
            scenario = replace(scenario, variants=variants)
            (only,) = recorded_alone(scenario, memory)
            parts.append(only)
            if sum(part.duration for part in parts) > self.outcomes.end[k] + INSTANT:
                break
        tape = join_recordings(parts)
        if self.outcomes.finished[k]:
            return tape
        status = SimulationStatus.LOOPS_LOST if self.outcomes.lost[k] else SimulationStatus.BLOWN_UP
        return _broken_off(tape, float(self.outcomes.end[k]), status)

    def explain(self, language: str | None = None) -> str:
        """How many ended well, how far off the tip was, what mattered most."""
        share, low, high = (100.0 * x for x in self.share_within)
        worst = next(iter(self))
        details = {
            "runs": len(self), "finished": int(self.outcomes.finished.sum()), "median": 1e3 * self.quantile(0.5),
            "most": 1e3 * self.quantile(0.95), "largest": 1e3 * float(self.outcomes.tip_error[worst]), "worst": worst,
        }  # fmt: skip
        sentences = [self.status.sentence(language, **details)]
        if self.outcomes.lost.any():
            which = np.flatnonzero(self.outcomes.lost)
            named = {"count": len(which), "first": ", ".join(map(str, which[:NAMED].tolist()))}
            sentences.append(say("simulation.runs_lost_loops", language=language, **named))
        if self.bound is not None:
            within = {"share": share, "low": low, "high": high, "bound": 1e3 * self.bound}
            sentences.append(say("simulation.share_within", language=language, **within))
        strongest = next(iter(self.influence.items()), None)
        if strongest is not None:
            named = {"name": drawn_name(strongest[0], language), "correlation": strongest[1]}
            sentences.append(say("simulation.influence", language=language, **named))
        return ". ".join(sentences)

    def _table(self) -> list[str]:
        head = ("", "max", "rms", *self.variants.columns())
        errors = self.outcomes
        rows = [
            (str(k), number(1e3 * errors.tip_error[k]), number(1e3 * errors.tip_rms[k]),
             *(number(column[k]) for column in self.variants.columns().values()))
            for k in list(self)[:5]
        ]  # fmt: skip
        return table(head, rows)

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return Answer.to_dict(self) | {"drawn": self.variants.columns(), **self.outcomes.arrays()}


def monte_carlo(
    scenario: Scenario | Sequence[Scenario],
    variation: Variation,
    runs: int = 1000,
    *,
    seed: int = 0,
    bound: float | None = None,
    marks: ArrayLike = (),
    executor: Executor | None = None,
    progress: Progress | None = None,
) -> MonteCarlo:
    """Run a scenario many times with drawn payloads, inertias, friction, gains, delays, noise and starts.

    Laws that are expressions run as one compiled loop with all runs of a chunk side by side, on all cores; other laws
    are asked for a whole chunk at each tick, and a chunk takes about 130 MB.

    Args:
        scenario: one run; its plant is what the drawn numbers change. Several follow each other: each begins where the
            one before ended, with the same numbers, its law with what that remembers.
        variation: what differs from run to run.
        runs: how many.
        seed: of the draws.
        bound: tip error [m] whose share of runs is reported.
        marks: (m,) times at which the positions of each run are kept, in order [s].
        executor: where chunks are worked on, such as a `concurrent.futures.ProcessPoolExecutor` or a
            `dask.distributed.Client` (`pip install mafsil[distributed]`); None for this process. The numbers are the
            same to the last bit.
        progress: called with the fraction done; False ends it with the runs done so far.

    A run of a mechanism with loops that cannot be followed, near lost rank or torn by its efforts, ends there.

    Raises:
        InputError: a scenario that has variants or a batch already, numbers out of their range, drawn numbers that make
            no sense (a negative mass), a variation of gains for a law without known gains.
    """
    scenarios = _sequence(scenario)
    require_kind("variation", variation, "Variation", "payload", "gains")
    count, seed = whole("runs", runs, 1, MOST_RUNS), whole("seed", seed)
    if bound is not None:
        positive("bound", bound)
    if progress is not None:
        require_function("progress", progress, "function of the fraction done", 1)
    if executor is not None:
        require_kind("executor", executor, "Executor", "submit")
    if variation.noise is not None and all(each.noise is None for each in scenarios):
        raise InputError("simulation.no_noise")
    marked = _marks(scenarios, marks)
    variants = drawn(variation, scenarios[0].true_plant.robot, scenarios[0].control_period, count, seed)
    # Chosen once for all runs, so that each moves alike in any company.
    methods = (replace(each, variants=variants).chosen_integrator for each in scenarios)
    scenarios = tuple(replace(each, integrator=method) for each, method in zip(scenarios, methods, strict=True))
    size = chunk_size(scenarios)
    edges = [(first, min(first + size, count)) for first in range(0, count, size)]
    work = [(scenarios, marked, variants.rows(*edge)) for edge in edges]
    parts: list[Outcomes] = []
    for part in _work(work, executor):
        parts.append(part)
        done = edges[len(parts) - 1][1]
        if progress is not None and progress(done / count) is False:
            break
    done = edges[len(parts) - 1][1]
    return MonteCarlo(scenarios, variation, seed, variants.rows(0, done), _join(parts), bound)


def _sequence(given: Scenario | Sequence[Scenario]) -> tuple[Scenario, ...]:
    """The scenarios that follow each other.

    Raises:
        InputError: none, other things, scenarios with a batch, of different coordinates or links.
    """
    several = tuple(given) if isinstance(given, Sequence) else (given,)
    if not several:
        raise InputError("input.kind", name="scenario", expected="Scenario", got="()")
    for each in several:
        require_kind("scenario", each, "Scenario", "trajectory", "law", "ticks")
        if each.variants is not None or each.start()[0].ndim != 1:
            raise InputError("simulation.varied_batch", shape=each.start()[0].shape)
        robot, first = each.true_plant.robot, several[0].true_plant.robot
        if robot.n != first.n or len(robot.mechanism.links) != len(first.mechanism.links):
            raise InputError("simulation.varied_arms")
    return several


def _marks(scenarios: Sequence[Scenario], marks: ArrayLike) -> tuple[Floats, ...]:
    """The marked times of each scenario, from its own start on."""
    times = require_finite("marks", real_array("marks", marks)).reshape(-1)
    ends = np.cumsum([scenario.ticks()[-1] for scenario in scenarios])
    if len(times) and (times[0] < 0.0 or times[-1] > ends[-1] + INSTANT or (np.diff(times) < 0.0).any()):
        raise InputError("simulation.marks", end=float(ends[-1]))
    place = np.minimum(np.searchsorted(ends + INSTANT, times), len(ends) - 1)
    begins = np.concatenate([[0.0], ends[:-1]])
    return tuple(times[place == k] - begin for k, begin in enumerate(begins))


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


def _broken_off(tape: Recording, end: float, status: SimulationStatus) -> Recording:
    """The ticks of a run before it broke off."""
    kept = {name: array[tape.t <= end + INSTANT] for name, array in tape.arrays().items()}
    fault = say("simulation.loops_not_followed") if status is SimulationStatus.LOOPS_LOST else ""
    return replace(tape, **kept, status=status, metadata=tape.metadata | {"fault": fault})


def _work(
    work: Sequence[tuple[Sequence[Scenario], Sequence[Floats], Variants]], executor: Executor | None
) -> Iterator[Outcomes]:
    if executor is None:
        yield from (chunk_outcomes(*each) for each in work)
        return
    for future in [executor.submit(chunk_outcomes, *each) for each in work]:
        yield future.result()


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


def _join(parts: list[Outcomes]) -> Outcomes:
    return Outcomes(**{name: np.concatenate([getattr(part, name) for part in parts]) for name in Outcomes.__slots__})


MOST_WORKERS = 1024


@contextmanager
def cluster_executor(where: str | None) -> Generator[Executor | None]:
    """An executor for `monte_carlo`, closed at the end; None for this process.

    Args:
        where: a number of worker processes, or the address of a dask scheduler such as `tcp://10.0.0.5:8786`.

    Raises:
        InputError: dask's `distributed` is not installed, too many workers, nobody answers at the address.
    """
    if where is None:
        yield None
        return
    try:
        distributed: Any = import_module("distributed")
    except ImportError:
        raise InputError("simulation.no_distributed") from None
    if where.strip().isdigit():
        count = int(where)
        if not 1 <= count <= MOST_WORKERS:
            raise InputError("input.range", name="cluster", value=count, low=1, high=MOST_WORKERS)
        options = {"processes": True, "threads_per_worker": 1, "dashboard_address": None, "silence_logs": 40}
        with distributed.LocalCluster(n_workers=count, **options) as local, distributed.Client(local) as client:
            yield client
        return
    try:
        client = distributed.Client(where, timeout="10s")
    except (OSError, ValueError, TypeError) as fault:
        raise InputError("simulation.no_cluster", address=where, fault=str(fault) or type(fault).__name__) from None
    with client:
        yield client
