"""Search among the designs of a parametric arm: several goals, limits first, every point proved by the whole model.

Each point of the front is the least of a weighted Chebyshev sum max_j w_j (f_j - ideal_j) / range_j, which reaches
fronts that bend either way, by SciPy's differential evolution; a population is one batch of the family's kernels.
Limits come first: a design that breaks them, or misses poses, is judged by how far alone.

Reference: Storn & Price, Differential evolution, J. Global Optimization 11, 1997; Miettinen, Nonlinear Multiobjective
Optimization, 1999, sec. 3.4.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields, replace
from hashlib import sha256
from os import PathLike
from pathlib import Path
from typing import Any, cast

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import differential_evolution

from mafsil.answer import Answer, Status
from mafsil.arrays import Booleans, Floats, JointVector, as_batch, number, whole
from mafsil.design.arm import Design, ParametricArm
from mafsil.design.elastic import FlexibleArm
from mafsil.design.platform import ParametricPlatform, evaluate, measure_designs, require_measures
from mafsil.design.tasks import IN_CYCLE, MEASURES, Evaluation, TaskSet
from mafsil.errors import FileError, InputError, MafsilError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.simulation.many_runs import Executor
from mafsil.simulation.stored_arrays import read as read_arrays
from mafsil.version import __version__
from mafsil.whole_file import write_whole

BROKEN = 1e3
"""Added to the sum of a design that breaks limits: more than any that keeps them, in ranges of the goals."""
AGREES = 1e-4
"""Share by which a measure of the whole model may differ from that of the search."""
CHUNK = 8
"""Designs that an executor measures at once."""
ADDED = 1e-3
"""Weight of the plain sum beside the largest term: of equal largest terms the better others win."""


class FrontStatus(Status):
    """Whether designs were found that keep the limits."""

    FOUND = ("design.front_found", True)
    NOT_FOUND = ("design.front_not_found", False)


@dataclass(frozen=True, eq=False, slots=True)
class FrontPoint:
    """One design of a front.

    Attributes:
        values: of the parameters.
        measures: of the search, goals and limits by name.
        evaluation: of the whole model.
        proved: whether that serves, keeps the limits and gives the same goals.
    """

    values: dict[str, float]
    measures: dict[str, float]
    evaluation: Evaluation
    proved: bool

    @property
    def design(self) -> Design:
        """The arm or platform itself."""
        return self.evaluation.design


@dataclass(frozen=True, eq=False, repr=False)
class Front(Answer, entries="points", data="goals designs evaluated=count"):
    """Designs of which none is better than another in all goals; iterated over them, true if there are some.

    Attributes:
        goals: names of the goals.
        points: by the first goal, the best at first.
        count: designs that the search looked at.
    """

    goals: tuple[str, ...]
    points: tuple[FrontPoint, ...]
    count: int

    @property
    def status(self) -> FrontStatus:
        """Found, if there is a point at all."""
        return FrontStatus.FOUND if self.points else FrontStatus.NOT_FOUND

    @property
    def designs(self) -> list[dict[str, Any]]:
        """Values, goals and proof of each point as plain data."""
        return [
            {**one.values, **{goal: one.measures[goal] for goal in self.goals}, "proved": one.proved}
            for one in self.points
        ]

    def explain(self, language: str | None = None) -> str:
        """How many points there are and how many are proved, then each."""
        proved = sum(one.proved for one in self.points)
        details = {"points": len(self.points), "count": self.count, "proved": proved}
        lines = [self.status.sentence(language, **details)]
        for row in self.designs:
            numbers = ", ".join(f"{name} {value:.4g}" for name, value in row.items() if name != "proved")
            key = "design.point_proved" if row["proved"] else "design.point_not_proved"
            lines.append(say(key, language=language, numbers=numbers))
        return "\n".join(lines)


def optimise(
    arm: ParametricArm | ParametricPlatform,
    tasks: TaskSet,
    goals: Sequence[str],
    limits: Mapping[str, float] | None = None,
    *,
    points: int = 5,
    population: int = 24,
    generations: int = 40,
    starts: int = 1,
    seed: int = 0,
    resume: str | PathLike[str] | None = None,
    executor: Executor | None = None,
) -> Front:
    """Designs of an arm that do their tasks best: the least of one goal, or a front of several.

    Args:
        arm: an arm or a platform with free parameters.
        tasks: what it shall do.
        goals: names of `MEASURES`, of arms but `payload`, of platforms but `reach` and `void`; each is driven in its
            good sense.
        limits: by measure, the most it may be, or the least where more is better.
        points: of the front; one goal has one.
        population, generations: of each search.
        starts: of the inverse kinematics for every pose, the best conditioned configuration is kept: more than one
            where the elbow matters.
        seed: equal seeds give equal results.
        resume: file (.npz) in which every design that was looked at is kept: a search that was stopped, begun again
            with it, takes what it has from there and ends with the same result.
        executor: where designs are measured, such as a `concurrent.futures.ProcessPoolExecutor` or a
            `dask.distributed.Client`; None for this process. The result is the same to the last bit.

    Raises:
        InputError: no free parameter, an unknown goal or limit, numbers out of range.
        FileError: `resume` names a file that is damaged or of another search.
    """
    bounds = {} if limits is None else {name: number(f"limits.{name}", value) for name, value in limits.items()}
    names = tuple(goals) if not isinstance(goals, str) else (goals,)
    require_measures((*names, *bounds), type(arm), "goals")
    if not arm.free:
        raise InputError("design.nothing_free", name=arm.name)
    if not names:
        raise InputError("input.choice", name="goals", value="", known=", ".join(MEASURES))
    asked = {*names, *bounds}
    if tasks.period is None and asked & set(IN_CYCLE):
        raise InputError("design.needs_period", name=", ".join(sorted(asked & set(IN_CYCLE))))
    if "frequency" in asked and isinstance(arm, ParametricArm) and not FlexibleArm(arm.at()).freedoms:
        raise InputError("design.all_rigid", name=arm.name)
    search = _Search(
        arm, tasks, names, bounds, whole("population", population, least=5, most=10_000),
        whole("generations", generations, least=1, most=100_000), whole("seed", seed, least=0),
        whole("starts", starts, least=1, most=1000), executor,
    )  # fmt: skip
    if resume is not None:
        search.recall(Path(resume))
    for k in range(len(names)):
        search.least(np.eye(len(names))[k])
    if len(names) > 1:
        for weights in _weights(len(names), whole("points", points, least=1, most=1000) - len(names)):
            search.least(weights)
    return search.front()


class _Search:
    """Runs of differential evolution over one arm; every design that was looked at is remembered."""

    def __init__(
        self, arm: ParametricArm | ParametricPlatform, tasks: TaskSet, goals: tuple[str, ...],
        limits: Mapping[str, float], population: int, generations: int, seed: int, starts: int,
        executor: Executor | None,
    ) -> None:  # fmt: skip
        self.arm, self.tasks, self.goals, self.limits = arm, tasks, goals, limits
        self.population, self.generations, self.seed, self.starts = population, generations, seed, starts
        self.executor = executor
        self.file: Path | None = None
        # What is known of designs before they are looked at: (goals..., excess) by their numbers as bytes.
        self.known = dict[bytes, Floats]()
        self.names = tuple(dict.fromkeys((*goals, *limits, "reached")))
        free = [arm.parameters[name] for name in arm.free]
        self.bounds = [(one.low, one.high) for one in free]
        self.signs = np.array([-1.0 if MEASURES[name] else 1.0 for name in goals])
        # Designs (D, free), goals to be made small (D, goals), how far limits are broken (D,).
        self.x, self.f, self.excess = np.zeros((0, len(free))), np.zeros((0, len(goals))), np.zeros(0)
        self.runs = 0

    def least(self, weights: Floats) -> None:
        """One run: the design with the least weighted sum of goals."""
        kept = self.f[self.excess == 0.0]
        ideal = kept.min(axis=0) if len(kept) else np.zeros(len(self.goals))
        span = np.maximum(np.ptp(kept, axis=0), 1e-12) if len(kept) else np.ones(len(self.goals))

        def value(rows: Floats) -> Floats:
            f, excess = self._look(np.atleast_2d(rows.T))
            terms = weights * (np.nan_to_num(f, nan=0.0) - ideal) / span
            sums: Floats = np.asarray(terms.sum(axis=1))
            if (weights > 0).sum() > 1:
                sums = terms.max(axis=1) + ADDED * sums
            worst = BROKEN * (1.0 + float(np.abs(sums).max(initial=0.0)))
            return np.where(excess > 0.0, worst * (1.0 + excess), sums)

        self.runs += 1
        rng = np.random.default_rng([self.seed, self.runs])
        low, high = np.array(self.bounds).T
        start = low + rng.uniform(size=(self.population, len(low))) * (high - low)
        best = self._best(weights, ideal, span)
        start[: len(best)] = best
        try:
            differential_evolution(
                value, self.bounds, init=start, maxiter=self.generations, vectorized=True, updating="deferred", rng=rng,
                polish=False, tol=1e-10, atol=0.0,
            )  # fmt: skip
        except RuntimeError as fault:
            # SciPy takes every ValueError of a function for one of its own.
            if isinstance(fault.__cause__, MafsilError):
                raise fault.__cause__ from None
            raise

    def _best(self, weights: Floats, ideal: Floats, span: Floats) -> Floats:
        """A few designs of earlier runs to start from."""
        kept = self.excess == 0.0
        sums = (weights * (self.f[kept] - ideal) / span).max(axis=1, initial=-np.inf)
        return self.x[kept][np.argsort(sums, kind="stable")[: self.population // 4]]

    def recall(self, file: Path) -> None:
        """Know what an earlier search has kept in a file, and keep there what this one looks at.

        Raises:
            FileError: a damaged file, or one of another arm, other tasks, goals, limits or seeds.
        """
        self.file = file
        if not file.exists():
            return
        about, stored = read_arrays(file, ("x", "f", "excess"), ())
        if about.get("search") != self.fingerprint:
            raise FileError("design.other_search", path=str(file))
        for row, f, excess in zip(stored["x"], stored["f"], stored["excess"], strict=True):
            self.known[row.tobytes()] = np.array([*f, excess])

    @property
    def fingerprint(self) -> str:
        """Of all that the measures of a design depend on."""
        tasks = {one.name: getattr(self.tasks, one.name) for one in fields(self.tasks) if one.name != "scene"}
        parts = (
            __version__,
            self.arm.table,
            self.arm.parameters,
            tasks,
            self.names,
            self.limits,
            self.seed,
            self.starts,
        )
        with np.printoptions(threshold=sys.maxsize, precision=17):
            return sha256(repr((__version__, *parts)).encode()).hexdigest()

    def _look(self, rows: Floats) -> tuple[Floats, Floats]:
        """(D, goals) to be made small, and (D,) how far limits are broken, of designs (D, free)."""
        new = np.array([row for row in rows if row.tobytes() not in self.known]).reshape(-1, rows.shape[1])
        if len(new):
            self.known |= {row.tobytes(): value for row, value in zip(new, self._judge(new), strict=True)}
        values = np.array([self.known[row.tobytes()] for row in rows])
        f, excess = values[:, :-1], values[:, -1]
        self.x, self.f = np.concatenate([self.x, rows]), np.concatenate([self.f, f])
        self.excess = np.concatenate([self.excess, excess])
        if self.file is not None and len(new):
            self._keep(self.file)
        return f, excess

    def _keep(self, file: Path) -> None:
        x = np.frombuffer(b"".join(self.known), dtype=np.float64).reshape(-1, len(self.bounds))
        values, about = np.array(list(self.known.values())), np.array(json.dumps({"search": self.fingerprint}))
        write_whole(file, lambda stream: np.savez(stream, about=about, x=x, f=values[:, :-1], excess=values[:, -1]))

    def _judge(self, rows: Floats) -> Floats:
        """(D, goals + 1) goals to be made small and how far limits are broken, of designs (D, free)."""
        values = [self._name_values(row) for row in np.clip(rows, *np.array(self.bounds).T)]
        arguments = (self.arm, replace(self.tasks, scene=None), self.names, self.seed, self.starts)
        if self.executor is None:
            parts = [_measure(values, *arguments)]
        else:
            edges = range(0, len(values), CHUNK)
            futures = [self.executor.submit(_measure, values[k : k + CHUNK], *arguments) for k in edges]
            parts = [future.result() for future in futures]
        measured = dict(zip(self.names, np.hstack(parts), strict=True))
        f = self.signs * np.stack([measured[name] for name in self.goals], axis=1)
        excess = 1.0 - measured["reached"]
        for name, bound in self.limits.items():
            over = (bound - measured[name] if MEASURES[name] else measured[name] - bound) / max(abs(bound), 1e-12)
            excess = excess + np.maximum(np.nan_to_num(over, nan=0.0), 0.0)
        excess = np.where((excess == 0.0) & ~np.isfinite(f).all(axis=1), 1.0, excess)
        return np.column_stack([f, excess])

    def _name_values(self, row: Floats) -> dict[str, float]:
        return dict(zip(self.arm.free, cast("list[float]", row.tolist()), strict=True))

    def front(self) -> Front:
        """The designs that none is better than, thinned to the best of each run's kind, proved one by one."""
        kept = np.flatnonzero(self.excess == 0.0)
        best = kept[is_undominated(self.f[kept])] if len(kept) else kept
        best = best[_apart(self.f[best], max(self.runs, 1))] if len(best) else best
        proved = [self._prove(self.x[k], self.f[k]) for k in best[np.argsort(self.f[best][:, 0], kind="stable")]]
        return Front(self.goals, tuple(proved), len(self.x))

    def _prove(self, row: Floats, f: Floats) -> FrontPoint:
        values = self._name_values(row)
        design: Any = self.arm.at(**values)
        _, q = measure_designs([design], self.tasks, ("reached",), seed=self.seed, starts=self.starts)
        judged = evaluate(design, self.tasks, q0=cast("JointVector", q[0]), seed=self.seed)
        found = dict(zip(self.goals, cast("list[float]", (self.signs * f).tolist()), strict=True))
        own = judged.measures
        same = all(abs(own[name] - value) <= AGREES * max(abs(value), 1e-12) for name, value in found.items())
        keeps = all(
            own[name] >= bound * (1.0 - AGREES) if MEASURES[name] else own[name] <= bound * (1.0 + AGREES)
            for name, bound in self.limits.items()
        )
        return FrontPoint(values, found, judged, same and keeps and bool(judged))


def _measure(
    values: Sequence[Mapping[str, float]], arm: ParametricArm | ParametricPlatform, tasks: TaskSet,
    names: Sequence[str], seed: int, starts: int,
) -> Floats:  # fmt: skip
    """(names, D) measures of the designs of an arm or platform with these values."""
    designs: Any = [arm.at(**one) for one in values]
    measured, _ = measure_designs(designs, tasks, names, seed=seed, starts=starts)
    return np.array([measured[name] for name in names])


def hypervolume(f: ArrayLike, reference: ArrayLike) -> float:
    """Volume between goals (D, goals), small ones being good, and a reference that bounds them: that they dominate.

    Slices along the first goal: between two values of it the rest is the volume of the rows up to there.

    Args:
        f: rows of goals; rows beyond the reference do not count.
        reference: (goals,) the worst that counts.

    Reference: While et al., A faster algorithm for calculating hypervolume, IEEE Trans. Evolutionary Computation, 2006.
    """
    worst = as_batch("reference", reference, (np.asarray(reference).size,), finite=True)
    rows = as_batch("f", f, (len(worst),), finite=True).reshape(-1, len(worst))
    rows = rows[(rows < worst).all(axis=1)]
    if len(worst) == 1 or not len(rows):
        return float(worst[0] - rows.min()) if len(rows) else 0.0
    rows = rows[np.argsort(rows[:, 0], kind="stable")]
    widths = np.diff(np.append(rows[:, 0], worst[0]))
    return float(sum(
        width * hypervolume(rows[: k + 1, 1:], worst[1:]) for k, width in enumerate(widths.tolist()) if width > 0.0
    ))  # fmt: skip


def is_undominated(f: ArrayLike) -> Booleans:
    """(D,) which rows of goals (D, goals), small ones being good, no other row is better than; of equal rows one."""
    rows = np.asarray(f, dtype=np.float64)
    keep = np.ones(len(rows), dtype=np.bool_)
    for k in range(len(rows)):
        beaten = (rows <= rows[k]).all(axis=1) & ((rows < rows[k]).any(axis=1) | (np.arange(len(rows)) < k))
        keep[k] = not beaten.any()
    return keep


def _apart(f: Floats, most: int) -> Any:
    """At most so many rows of goals, each as far from those before it as can be, the best of each goal at first."""
    span = np.maximum(np.ptp(f, axis=0), LEAST_DIVISOR)
    chosen = list(dict.fromkeys(int(k) for k in f.argmin(axis=0)))
    while len(chosen) < min(most, len(f)):
        away = np.min([np.linalg.norm((f - f[k]) / span, axis=1) for k in chosen], axis=0)
        if not away.max() > 0.0:
            break
        chosen.append(int(away.argmax()))
    return np.array(chosen)


def _weights(goals: int, count: int) -> Floats:
    """(count, goals) weights between the goals: evenly spaced for two, a low-discrepancy sequence for more."""
    if goals == 2:
        share = (np.arange(count) + 1.0) / (count + 1.0)
        return np.asarray(np.stack([share, 1.0 - share], axis=1), dtype=np.float64)
    roots = np.sqrt(np.array([2.0, 3.0, 5.0, 7.0, 11.0, 13.0]))[np.arange(goals) % 6]
    spread = ((np.arange(max(count, 0)) + 0.5)[:, None] * roots) % 1.0
    rows: Floats = -np.log(np.asarray(spread + 1e-3, dtype=np.float64))
    return np.asarray(rows / np.asarray(rows.sum(axis=1, keepdims=True)), dtype=np.float64)
