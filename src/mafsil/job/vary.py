"""A job driven many times: payloads, friction, gains, delays and noise are drawn, each run is judged as the job is."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.job.arrival import errors_of, goal_of
from mafsil.job.description import Job
from mafsil.job.plan import Plan
from mafsil.job.run import Run
from mafsil.job.tolerance import tolerances
from mafsil.job.variation import JobVariation
from mafsil.job.variation_table import SPREADS, Normal, VariationTable
from mafsil.simulation import Normal as DrawnNormal
from mafsil.simulation import Scenario, Variation, cluster_of, monte_carlo
from mafsil.simulation.run import Progress
from mafsil.simulation.stepping import DEFAULT, IMPLICIT_FRICTION, STIFF


def vary(run: Run, *, cluster: str | None = None, progress: Progress | None = None) -> JobVariation:
    """Drive the motion of a job many times, as its `[variation]` says.

    1. All stretches of the plan follow each other in each run, with the same drawn numbers; what the job itself
       gripped is gripped in every run.
    2. Each run is judged where its moves end, as the run of the job is.

    Args:
        run: of the job, come to its end.
        cluster: a number of worker processes here, or the address of a dask scheduler; this process if None.
        progress: called with the share that is done; False ends it with the runs done so far.

    Raises:
        InputError: what is drawn makes no sense; MuJoCo's arm, which is not varied; dask is not installed.
    """
    asked = run.job.variation
    assert asked is not None
    scenarios = [driven.scenario for driven in run.driven]
    variation = Variation(**{name: _spread(getattr(asked, name)) for name in SPREADS})
    legs = [k for k, leg in enumerate(run.plan.legs) if goal_of(leg) is not None]
    marks = np.minimum([float(run.plan.starts[k + 1]) for k in legs], sum(each.ticks()[-1] for each in scenarios))
    with cluster_of(cluster) as executor:
        drawn = monte_carlo(
            _stable(run.job, scenarios, asked), variation, asked.runs, seed=asked.seed, bound=asked.bound,
            marks=marks, executor=executor, progress=progress,
        )  # fmt: skip
    names = tuple(leg.name or str(leg.index + 1) for leg in run.plan.legs)
    return JobVariation(drawn, asked, _missed(run.job, run.plan, legs, drawn.outcomes.marked), names)


def _stable(job: Job, scenarios: list[Scenario], asked: VariationTable) -> list[Scenario]:
    """With an integrator that no drawn friction makes unstable, unless the job names one."""
    if job.simulation.method is not None:
        return scenarios
    stiff = False
    if asked.friction is not None or asked.inertia is not None:
        most, least = _largest(asked.friction), _smallest(asked.inertia)
        stiff = any(scenario.stiffness * most / least > STIFF for scenario in scenarios)
    if stiff or any(scenario.integrator == IMPLICIT_FRICTION for scenario in scenarios):
        return [replace(each, integrator=IMPLICIT_FRICTION) for each in scenarios]
    # Forces of contact are asked for once a step, for all runs together.
    touches = any(scenario.true_plant.environment is not None for scenario in scenarios)
    return [replace(each, integrator=DEFAULT) for each in scenarios] if touches else scenarios


def _largest(spread: tuple[float, float] | Normal | None) -> float:
    if spread is None:
        return 1.0
    return spread.mean + 4.0 * spread.deviation if isinstance(spread, Normal) else spread[1]


def _smallest(spread: tuple[float, float] | Normal | None) -> float:
    if spread is None:
        return 1.0
    low = spread.mean - 4.0 * spread.deviation if isinstance(spread, Normal) else spread[0]
    return max(low, 1e-3)


def _spread(given: tuple[float, float] | Normal | None) -> DrawnNormal | tuple[float, float] | None:
    return DrawnNormal(given.mean, given.deviation) if isinstance(given, Normal) else given


def _missed(job: Job, plan: Plan, legs: list[int], q: Floats) -> NDArray[np.int64]:
    """(b,) the first leg whose target each run missed, from its positions (b, m, n) where they end; -1 for none."""
    first = np.full(len(q), -1, dtype=np.int64)
    for m, k in reversed(list(enumerate(legs))):
        leg = plan.legs[k]
        allowed = tolerances(job, leg.load.robot, leg.index)
        position, turn, joints = errors_of(leg, q[:, m])
        if goal_of(leg) == "joints":
            share = (joints / allowed.joints).max(axis=-1)
        else:
            share = np.maximum(position / allowed.position, turn / allowed.orientation)
        first[share > 1.0] = k
    return first
