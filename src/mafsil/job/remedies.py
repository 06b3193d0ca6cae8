"""What helps against a cause: ways to change a job, cheap to prove by driving again, or words for what to try."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from mafsil.arrays import Floats
from mafsil.job.laws import compensates_friction
from mafsil.job.plan import Leg, Plan
from mafsil.job.plan_simulation import Difference
from mafsil.job.removals import STIFFER, Removal, given_gains, with_controller
from mafsil.job.run import Run
from mafsil.messages.quantities import digits, quantity
from mafsil.messages.visible import visible
from mafsil.simulation import Plant
from mafsil.trajectory.motion import Stretchable

SLOWER = (1.25, 1.6, 2.0, 3.0, 5.0)
"""Times as slow, of which the smallest is taken at which efforts keep within their limits."""
ROOM = 0.95
"""Share of an effort limit that a slower motion may need."""
PLACES = 200
"""Of a leg, at which its efforts are looked at."""


@dataclass(frozen=True, eq=False, slots=True)
class Option:
    """A remedy.

    Attributes:
        key, details: of its words.
        removal: the job with it, to be driven; None of what is only worth trying.
    """

    key: str
    details: Mapping[str, object] = field(default_factory=dict[str, object])
    removal: Removal | None = None


def remedy_for(removal: Removal, run: Run, plan: Plan) -> Iterator[Option]:
    """Remedies of a cause, the best first; the last needs no proof, as it claims nothing.

    Args:
        removal: with which the failure went.
        run: that failed.
        plan: of its moves, as far as they count.
    """
    return _REMEDIES[removal.name](removal, run, plan)


def _against_limit(removal: Removal, run: Run, plan: Plan) -> Iterator[Option]:
    """Slower, where that brings the efforts within their limits; where holding alone takes more, nothing like that."""
    shares = [_effort_share(run, plan, factor) for factor in SLOWER]
    factor = next((k for k, share in zip(SLOWER, shares, strict=True) if share[1] <= ROOM), None)
    if factor is not None:
        words = {"share": quantity(1.0 / factor, "share")}
        slow = slow_moves(plan, factor)
        yield Option("job.remedy_slower", words, None if slow is None else Removal("slower", run.job, plan=slow))
    joint, still = _effort_share(run, plan, np.inf)
    if still > 1.0:
        held = {"joint": visible(run.robot.joint_names[joint]), "share": quantity(still, "share")}
        yield Option("job.remedy_lighter", held)
    yield Option("job.remedy_less_effort")


def _against_friction(removal: Removal, run: Run, plan: Plan) -> Iterator[Option]:
    if not compensates_friction(run.job) and not run.robot.mechanism.loops:
        yield Option("job.remedy_friction", {}, Removal("compensated", with_controller(run.job, friction=True)))
    yield _stiffer(run)
    yield Option("job.remedy_integral")


def _against_noise(removal: Removal, run: Run, plan: Plan) -> Iterator[Option]:
    yield _softer(run)
    yield Option("job.remedy_filter")


def _against_delay(removal: Removal, run: Run, plan: Plan) -> Iterator[Option]:
    yield _softer(run)
    yield Option("job.remedy_less_delay")


def _against_rate(removal: Removal, run: Run, plan: Plan) -> Iterator[Option]:
    yield Option(
        "job.remedy_rate",
        {"rate": f"{1.0 / removal.period:.6g}", "step": f"{removal.job.simulation.step:.6g}"},
        removal,
    )
    yield _softer(run)


def _against_softness(removal: Removal, run: Run, plan: Plan) -> Iterator[Option]:
    yield Option("job.remedy_stiffer", {"factor": digits(STIFFER)}, removal)
    yield Option("job.remedy_better_law")


def _against_gains(removal: Removal, run: Run, plan: Plan) -> Iterator[Option]:
    yield Option("job.remedy_gains", {"given": ", ".join(given_gains(run.job))}, removal)


def _against_integral(removal: Removal, run: Run, plan: Plan) -> Iterator[Option]:
    yield Option("job.remedy_less_integral")


def _against_law(removal: Removal, run: Run, plan: Plan) -> Iterator[Option]:
    yield Option("job.remedy_law", {}, removal)
    yield Option("job.remedy_less_effort")


def _against_model(removal: Removal, run: Run, plan: Plan) -> Iterator[Option]:
    yield Option("job.remedy_model", {}, removal)
    yield Option("job.remedy_integral")


def _against_force(removal: Removal, run: Run, plan: Plan) -> Iterator[Option]:
    yield _stiffer(run)
    yield Option("job.remedy_force")


_REMEDIES: dict[str, Callable[[Removal, Run, Plan], Iterator[Option]]] = {
    "limit": _against_limit,
    "surface_friction": _against_force,
    "friction": _against_friction,
    "push": _against_force,
    "model": _against_model,
    "contact": _against_force,
    "noise": _against_noise,
    "delay": _against_delay,
    "rate": _against_rate,
    "soft": _against_softness,
    "gains": _against_gains,
    "integral": _against_integral,
    "law": _against_law,
}


def _stiffer(run: Run) -> Option:
    stiff = Removal("stiffer", run.job, Difference(gain=STIFFER))
    return Option("job.remedy_stiffer", {"factor": digits(STIFFER)}, stiff)


def _softer(run: Run) -> Option:
    soft = Removal("softer", run.job, Difference(gain=1.0 / STIFFER))
    return Option("job.remedy_softer", {"share": quantity(1.0 / STIFFER, "share")}, soft)


def slow_moves(plan: Plan, factor: float) -> Plan | None:
    """The plan with moves so many times as slow; None where one of them cannot be stretched.

    Args:
        plan: of a job.
        factor: above one.
    """
    legs: list[Leg] = []
    for leg in plan.legs:
        if leg.timing is None:
            legs.append(leg)
        elif isinstance(leg.trajectory, Stretchable):
            legs.append(replace(leg, trajectory=leg.trajectory.scale_time(factor)))
        else:
            return None
    return replace(plan, legs=tuple(legs))


def _effort_share(run: Run, plan: Plan, factor: float) -> tuple[int, float]:
    """The joint that needs most of its effort limit if the plan is so many times as slow, and the share.

    Efforts of the arm as it moved, with what it carried and its friction; at rest for an infinite factor.
    """
    limit = run.robot.limits.effort
    most = np.zeros(len(limit))
    for k, leg in enumerate(plan.legs):
        driven = max((one for one in run.driven if one.stretch.first <= k), key=lambda one: one.stretch.first)
        most = np.maximum(most, np.abs(_efforts(driven.scenario.true_plant, leg, factor)).max(axis=0))
    share = most / np.where(limit > 0.0, limit, np.inf)
    return int(share.argmax()), float(share.max())


def _efforts(plant: Plant, leg: Leg, factor: float) -> Floats:
    """(k, n) [N m | N]."""
    u, v, a = leg.trajectory.at(np.linspace(0.0, leg.trajectory.duration, PLACES))
    tau = np.asarray(plant.robot.inverse_dynamics(u, v / factor, a / factor**2))
    # At rest friction takes nothing; it may even hold.
    return tau + plant.robot.friction_torque(v / factor) if plant.has_friction else tau
