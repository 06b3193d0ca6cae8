"""What can be taken away from a job to see whether a failure goes with it: only what the job really has."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from msgspec import structs

from mafsil.arrays import Floats
from mafsil.job.driving.arrival import INSTANT, arrival
from mafsil.job.driving.plan_simulation import AS_ASKED, Difference
from mafsil.job.driving.run import Run
from mafsil.job.judging.law_stability import growth_along
from mafsil.job.judging.symptoms import LimitBroken, Missed, Symptom, split, worst_joint
from mafsil.job.language.description import Controller, Job, Noise
from mafsil.job.language.driving_tables import WITHOUT_INERTIA
from mafsil.job.language.table_checks import GAINS
from mafsil.job.planning.plan import Plan
from mafsil.messages.quantities import digits, quantity
from mafsil.messages.visible import visible

STIFFER = 4.0
"""Factor of all gains, to see whether they are too soft."""
FASTER = 4
"""Times as often is the law evaluated, to see whether its gains are too hard for the rate."""
UNSTABLE = 1.0
"""Growth of small errors from tick to tick above which gains may be too hard."""
PARTS = {
    "friction": "friction", "push": "push", "model": "model", "contact": "contact", "noise": "rest", "delay": "rest",
    "law": "lag", "integral": "integral",
}  # fmt: skip
"""Removals that are tried in the order of a part in the exact split of the error, where there is one: which part."""
ROOTS = ("noise", "delay", "push")
"""What may bring a law to its effort limits."""

Details = Callable[[Run, Run, Symptom], dict[str, object]]
"""From the run, the run without it, and what went wrong, to more details of the sentence."""


def _none(run: Run, without: Run, wrong: Symptom) -> dict[str, object]:
    return {}


def _with_words(words: Mapping[str, object]) -> Details:
    """Details that are known before anything is driven."""

    def details(run: Run, without: Run, wrong: Symptom) -> dict[str, object]:
        return dict(words)

    return details


@dataclass(frozen=True, eq=False, slots=True)
class Removal:
    """A job without one thing.

    Attributes:
        name: of what is gone; sentences are `job.cause_<name>` and `job.removed_<name>`.
        job: without it.
        difference: from what that job says.
        details: of the sentence, beside what went wrong before and after.
        plan: another motion; None for the same.
    """

    name: str
    job: Job
    difference: Difference = AS_ASKED
    details: Details = field(default=_none)
    plan: Plan | None = None

    @property
    def period(self) -> float:
        """Of its law [s]."""
        return self.job.control_period


def removals(run: Run, wrong: Sequence[Symptom]) -> Iterator[Removal]:
    """What can be taken away, the likeliest first; what the job does not have is not there to be named.

    Sampling, where small errors grow from tick to tick; effort limits that were reached, after noise, delay and pushes,
    which may have led there; friction of surfaces; then by their part in the error friction, pushes, masses that the
    model does not know, contact, noise, delay, a law without inertia and the integral of PID; softness; gains that the
    job gives, which are left to us then.

    Args:
        run: a whole job, driven.
        wrong: what went wrong in it.
    """
    job = run.job
    growth = max((growth_along(job, driven).factor for driven in run.driven), default=0.0)
    if growth > UNSTABLE:
        # Where effort limits hold a loop that would run away, it is not they that it fails by.
        yield _faster(job, growth)
    there = {name: removal for name in PARTS if (removal := _OF_PARTS[name](run)) is not None}
    if (run.recording.tau != run.recording.tau_commanded).any():
        # What makes a law ask for too much comes before the limit that it meets.
        yield from (there.pop(name) for name in ROOTS if name in there)
        yield Removal("limit", job, Difference(unlimited=True), _effort_needed)
    if any(one.friction for one in job.surface):
        smooth = tuple(structs.replace(one, friction=0.0) for one in job.surface)
        yield Removal("surface_friction", structs.replace(job, surface=smooth))
    yield from (there[name] for name in _by_size(run, wrong) if name in there)
    yield Removal("soft", job, Difference(gain=STIFFER), _with_words({"factor": digits(STIFFER)}))
    given = given_gains(job)
    if given:
        fitting = with_controller(job, **dict.fromkeys(given))
        yield Removal("gains", fitting, details=_with_words({"given": ", ".join(given)}))


def given_gains(job: Job) -> tuple[str, ...]:
    """Names of the gains that a job gives to its law."""
    return tuple(name for name in GAINS[job.controller.kind] if getattr(job.controller, name) is not None)


def up_to(plan: Plan, last: int) -> Plan:
    """The moves of a plan up to one of its legs."""
    return replace(plan, legs=plan.legs[: last + 1])


def with_simulation(job: Job, **changes: object) -> Job:
    """The job with other values in [simulation]."""
    return structs.replace(job, simulation=structs.replace(job.simulation, **changes))


def with_controller(job: Job, **changes: object) -> Job:
    """The job with other values in [controller]."""
    return structs.replace(job, controller=structs.replace(job.controller, **changes))


def _friction(run: Run) -> Removal | None:
    if not any(driven.scenario.true_plant.has_friction for driven in run.driven):
        return None
    # What is not there is not compensated either.
    return Removal("friction", with_controller(with_simulation(run.job, friction=False), friction=False))


def _push(run: Run) -> Removal | None:
    job = run.job
    begun = any(one.start < run.recording.duration for one in job.disturbance)
    if not begun and not any(move.process_wrench for move in job.move):
        return None
    moves = tuple(structs.replace(move, process_wrench=None) for move in job.move)
    return Removal("push", structs.replace(job, disturbance=(), move=moves))


def _model(run: Run) -> Removal | None:
    """Masses that the law's model does not have; the law is given those of the true arm."""
    settings = run.job.simulation
    part = [one for one in run.driven if one.stretch.carried is not None and one.gripped != one.stretch.carried.known]
    hidden = [one for one in part if one.gripped]
    masses = settings.mass_error != 0.0 or settings.payload != 0.0
    if not part and not masses:
        return None
    what = "unknown_both" if part and masses else "unknown_masses" if masses else "unknown_part"
    what = "missing_part" if part and not hidden and not masses else what
    return Removal("model", run.job, Difference(knows_arm=True), _with_words({"what": f"@job.{what}"}))


def _contact(run: Run) -> Removal | None:
    wrench = run.recording.contact_wrench
    if wrench is None or not np.any(wrench):
        return None
    return Removal("contact", structs.replace(run.job, surface=(), hole=(), door=(), guide=()), details=_when_touching)


def _noise(run: Run) -> Removal | None:
    noise = run.job.simulation.noise
    noisy = noise.position or noise.velocity or noise.force or noise.resolution
    return Removal("noise", with_simulation(run.job, noise=Noise())) if noisy else None


def _delay(run: Run) -> Removal | None:
    delay = run.job.controller.delay
    words = {"delay": quantity(delay, "s")}
    return Removal("delay", with_controller(run.job, delay=0.0), details=_with_words(words)) if delay else None


def _law(run: Run) -> Removal | None:
    """A law that knows the inertia, too."""
    own = run.job.controller
    if own.kind not in WITHOUT_INERTIA:
        return None
    whole = Controller(kind="computed_torque", rate=own.rate, delay=own.delay)
    return Removal("law", structs.replace(run.job, controller=whole), details=_with_words({"law": own.kind}))


def _integral(run: Run) -> Removal | None:
    own = run.job.controller
    return (
        Removal("integral", with_controller(run.job, integral=0.0)) if own.kind == "pid" and own.integral != 0 else None
    )


_OF_PARTS: dict[str, Callable[[Run], Removal | None]] = {
    "friction": _friction, "push": _push, "model": _model, "contact": _contact, "noise": _noise, "delay": _delay,
    "law": _law, "integral": _integral,
}  # fmt: skip


def _faster(job: Job, growth: float) -> Removal:
    """The law evaluated several times as often, with shorter steps where they would be longer than its period."""
    period = job.control_period / FASTER
    step = period / max(1, round(period / job.simulation.step))
    fast = with_controller(with_simulation(job, step=step), rate=1.0 / period)
    words = {
        "rate": f"{digits(1.0 / job.control_period)} Hz",
        "faster": f"{digits(1.0 / period)} Hz",
        "growth": digits(growth),
    }
    return Removal("rate", fast, details=_with_words(words))


def _by_size(run: Run, wrong: Sequence[Symptom]) -> list[str]:
    """The parts of the error of the first miss, the largest first; as they stand where it is not split."""
    missed = next((one for one in wrong if isinstance(one, Missed)), None)
    judged = None if missed is None else arrival(run.job, run.plan, missed.leg, run.recording)
    if judged is None:
        return list(PARTS)
    # The last tick before the end: from the end on, the tool may hold something else.
    row = max(int(np.searchsorted(run.recording.t, judged.time - INSTANT)) - 1, 0)
    driven = max((one for one in run.driven if one.stretch.first <= judged.leg), key=lambda one: one.stretch.first)
    parts = split(run, driven, row)
    if parts is None:
        return list(PARTS)
    joint, sizes = worst_joint(run, judged), parts.parts()
    side = float(np.sign(parts.error[joint]))
    return sorted(PARTS, key=lambda name: -side * float(sizes[PARTS[name]][joint]))


def _effort_needed(run: Run, without: Run, wrong: Symptom) -> dict[str, object]:
    """The joint that needs most of its effort limit until something went wrong, by the run that has none."""
    rows = _until(without, wrong)
    limit = run.robot.limits.effort
    most: Floats = np.abs(without.recording.tau[rows]).max(axis=0)
    share: Floats = most / np.where(limit > 0.0, limit, np.inf)
    joint = int(np.argmax(share))
    return {"limited": visible(run.robot.joint_names[joint]), "share": quantity(float(share[joint]), "share")}


def _until(run: Run, wrong: Symptom) -> slice:
    """The ticks up to the end of the leg at which something is seen; all of them of what the whole run shows."""
    if not isinstance(wrong, Missed | LimitBroken):
        return slice(None)
    end = float(run.plan.starts[wrong.leg + 1]) - INSTANT
    return slice(0, int(np.searchsorted(run.recording.t, end)))


def _when_touching(run: Run, without: Run, wrong: Symptom) -> dict[str, object]:
    """When the contact began or ended last before something was seen, and how hard it was at most until then."""
    wrench = run.recording.contact_wrench
    assert wrench is not None
    force = np.linalg.norm(wrench[: _until(run, wrong).stop, 3:], axis=-1)
    changes = np.flatnonzero(np.diff(force > 0.0))
    last = int(changes[-1]) + 1 if len(changes) else 0
    made = bool(force[last] > 0.0)
    when = quantity(float(run.recording.t[last]), "s")
    change, most = "@job.contact_made" if made else "@job.contact_lost", quantity(float(force.max()), "N")
    return {"change": change, "time": when, "force": most}
