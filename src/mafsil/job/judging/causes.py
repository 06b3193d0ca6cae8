"""Why a run failed: the job is driven again without one thing at a time, and what the failure goes with is named.

A cause is proved, not guessed: it is named if, with that one thing gone and all else alike (seeds too), what went wrong
is allowed or at most half as large. What no single removal explains stays unknown, with its number. So do the remedies:
ways to change the job that are cheap to prove are driven once, and said to help only if they do; the others are words
for what to try.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from msgspec import structs

from mafsil.arrays import Floats
from mafsil.errors import MafsilError
from mafsil.job.driving.laws import compensates_friction
from mafsil.job.driving.plan_simulation import Difference, simulate_plan
from mafsil.job.driving.run import Run
from mafsil.job.judging.holding import overloads
from mafsil.job.judging.removals import STIFFER, Removal, given_gains, removals, up_to, with_controller
from mafsil.job.judging.symptoms import Symptom, symptoms
from mafsil.job.planning.plan import Leg, Plan
from mafsil.job.remark import detail_text, say_with
from mafsil.messages import say
from mafsil.messages.quantities import digits, quantity
from mafsil.messages.visible import visible
from mafsil.simulation import Plant
from mafsil.simulation.fused import can_fuse
from mafsil.simulation.recording import SimulationStatus
from mafsil.trajectory.motion import Stretchable

SLOWER = (1.25, 1.6, 2.0, 3.0, 5.0)
"""Times as slow, of which the smallest is taken at which efforts keep within their limits."""
ROOM = 0.95
"""Share of an effort limit that a slower motion may need."""
PLACES = 200
"""Of a leg, at which its efforts are looked at."""
MAIN_PART = 0.5
"""Share of what went wrong that may be left without a cause, at most."""
MOST_AGAIN = 6
"""Simulations of one job in search of causes and remedies, beyond the first."""
MOST_TICKS, INTERPRETED = 400_000, 10
"""Ticks of all of them together; those of loops that are not compiled count so many times."""


@dataclass(frozen=True, slots=True)
class Remedy:
    """What helps against a cause.

    Attributes:
        key, details: of the words.
        left: what is left with it, of a remedy that was driven; None of one that is only worth trying.
    """

    key: str
    details: Mapping[str, object] = field(default_factory=dict[str, object])
    left: str | None = None

    def explain(self, *, language: str | None = None) -> str:
        """What to write or to change, and what came of it."""
        what = say_with(self.key, self.details, language)
        if self.left is None:
            return say("job.remedy_untried", language=language, what=what)
        return say("job.remedy_proved", language=language, what=what, left=detail_text(self.left, language))


@dataclass(frozen=True, slots=True)
class Cause:
    """What something comes from.

    Attributes:
        key, details: of the words, as in `Remark`; `before` and `after` are what went wrong with it and without it.
        remedy: what helps; None where nothing is known to.
    """

    key: str
    details: Mapping[str, object] = field(default_factory=dict[str, object])
    remedy: Remedy | None = None

    def explain(self, *, language: str | None = None) -> str:
        """The cause in words, with the numbers that prove it, and the remedy."""
        words = say_with(self.key, self.details, language)
        return words if self.remedy is None else f"{words}; {self.remedy.explain(language=language)}"


class _Again:
    """Drives a job again, as often as it may."""

    def __init__(self, run: Run, last: int, progress: Callable[[float], None]) -> None:
        self.run, self.plan, self._progress = run, up_to(run.plan, last), progress
        compiled = all(can_fuse(driven.scenario) for driven in run.driven)
        self.count, self.ticks, self._weight = 0, 0, 1 if compiled else INTERPRETED

    def __call__(self, removal: Removal) -> Run | None:
        """The run without something; None where it cannot be driven, or not any more."""
        plan = self.plan if removal.plan is None else removal.plan
        ticks = self._weight * plan.duration / min(removal.period, self.run.driven[0].scenario.control_period)
        if self.count >= MOST_AGAIN or self.ticks + ticks > MOST_TICKS:
            return None
        self._progress(self.count / MOST_AGAIN)
        self.count, self.ticks = self.count + 1, self.ticks + int(ticks)
        job = structs.replace(removal.job, simulation=structs.replace(removal.job.simulation, real_time=False))
        try:
            found = simulate_plan(
                job, self.run.text, self.run.robot, plan, difference=replace(removal.difference, compiled=True)
            )
        except MafsilError:
            return None
        if found.recording.status is SimulationStatus.INTERRUPTED:
            raise KeyboardInterrupt
        return found


def causes_of(run: Run, progress: Callable[[float], None] = lambda share: None) -> dict[Symptom, Cause]:
    """The cause of everything that went wrong in a run; nothing is driven again where nothing did.

    1. Without one thing after the other, as long as something is unexplained: what is allowed then, or at most half as
       large, has that cause.
    2. For each cause a remedy, driven too.
    3. The rest is unknown, with what is left at best.

    Args:
        run: of a whole job.
        progress: called with the share of the work that is done.
    """
    wrong = symptoms(run)
    if not wrong or run.recording.status is SimulationStatus.INTERRUPTED:
        return {}
    again = _Again(run, max(one.leg for one in wrong), progress)
    before = {one: one.amount(run) for one in wrong}
    least: dict[Symptom, tuple[float, Run]] = {}
    found: dict[Symptom, Cause] = {}
    tried: list[str] = []
    # 1.
    for removal in removals(run, wrong):
        without = again(removal)
        if without is None:
            continue
        tried.append(f"@job.removed_{removal.name}")
        explained = [one for one in wrong if one not in found and _is_gone(one.amount(without), before[one])]
        # 2.
        remedy = _tried_remedy(removal, explained, run, without, again) if explained else None
        for one in explained:
            details = {**removal.details(run, without, one), **_both(one, run, without)}
            found[one] = Cause(f"job.cause_{removal.name}", details, remedy)
        for one in wrong:
            if one not in least or one.amount(without) < least[one][0]:
                least[one] = (one.amount(without), without)
        if len(found) == len(wrong):
            break
    # 3.
    for one in wrong:
        if one not in found:
            found[one] = _unknown(one, run, least.get(one), tried)
    progress(1.0)
    return found


def _is_gone(after: float, before: float) -> bool:
    """Whether what went wrong is allowed, or its main part gone."""
    return after <= 1.0 or (np.isfinite(before) and after <= MAIN_PART * before)


def _both(one: Symptom, run: Run, without: Run) -> dict[str, object]:
    return {"before": one.measure(run), "after": one.measure(without)}


def _unknown(one: Symptom, run: Run, best: tuple[float, Run] | None, tried: list[str]) -> Cause:
    if best is None:
        return Cause("job.cause_not_sought", {"before": one.measure(run)})
    return Cause("job.cause_unknown", {**_both(one, run, best[1]), "tried": Listed(tuple(tried))})


def _tried_remedy(removal: Removal, explained: list[Symptom], run: Run, without: Run, again: _Again) -> Remedy | None:
    """The first remedy with which all that a cause explains is allowed; else what is worth trying."""
    worst = max(explained, key=lambda one: one.amount(run))
    for option in remedy_for(removal, run, again.plan):
        if option.removal is None:
            return Remedy(option.key, option.details)
        driven = without if option.removal is removal else again(option.removal)
        if driven is not None and all(one.amount(driven) <= 1.0 for one in explained):
            return Remedy(option.key, option.details, worst.measure(driven))
    return None


@dataclass(frozen=True, slots=True)
class Listed:
    """Keys of the catalogue as a list in a sentence."""

    keys: tuple[str, ...]

    def explain(self, *, language: str | None = None) -> str:
        """Separated by commas."""
        words = (str(detail_text(key, language)) for key in self.keys)
        return say("job.list_separator", language=language).join(words)


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


def _against_push(removal: Removal, run: Run, plan: Plan) -> Iterator[Option]:
    """Gains help against a force that the motors can hold."""
    if not any(overload.pressed for overload in overloads(run)):
        yield _stiffer(run)
    yield Option("job.remedy_less_push")


def _against_force(removal: Removal, run: Run, plan: Plan) -> Iterator[Option]:
    yield _stiffer(run)
    yield Option("job.remedy_force")


_REMEDIES: dict[str, Callable[[Removal, Run, Plan], Iterator[Option]]] = {
    "limit": _against_limit,
    "surface_friction": _against_force,
    "friction": _against_friction,
    "push": _against_push,
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
