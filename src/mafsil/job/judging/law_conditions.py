"""Conditions that make laws stable, each held against a job: the number that proves it, and the limit it must keep."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats
from mafsil.control import Gains, Law, sliding_certificate, task_dynamics
from mafsil.control.analysis import MinMax
from mafsil.control.contact import AdmittanceControl, ContactSwitch, HybridControl, ImpedanceControl, admittance_radius
from mafsil.control.laws import (
    AdaptiveControl,
    Combined,
    ComputedTorque,
    JointFeedback,
    LawWrapper,
    LinearQuadratic,
    SlidingMode,
    TaskComputedTorque,
)
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.job.driving.run import Run
from mafsil.job.driving.tip_laws import Face, shape_of
from mafsil.job.judging.law_stability import PLACES, growth_along
from mafsil.job.planning.stretch import Driven
from mafsil.job.remark import Remark
from mafsil.messages import say
from mafsil.messages.quantities import digits, quantity

LONGEST = 2000
"""Ticks of a run that are looked at."""
MOST_PLACES = 12
"""Of a number that is nearly its limit."""


@dataclass(frozen=True, slots=True)
class Condition:
    """A number that has to stay below a limit.

    Attributes:
        name: of the condition; what it says is `job.condition_<name>`.
        value: the number, at worst.
        limit: it keeps below this.
        time: when it was worst [s]; NaN of what does not change with time.
    """

    name: str
    value: float
    limit: float
    time: float = float("nan")

    @property
    def holds(self) -> bool:
        """Whether the number keeps its limit; false for NaN."""
        return self.value < self.limit

    def explain(self, *, language: str | None = None) -> str:
        """What is asked, the number, and when it was worst."""
        details = {"value": beside(self.value, self.limit), "limit": digits(self.limit)}
        said = say(f"job.condition_{self.name}", language=language, **details)
        if not np.isfinite(self.time):
            return said
        return said + say("job.condition_when", language=language, time=quantity(self.time, "s"))

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        return {
            "name": self.name, "holds": self.holds, "value": _plain(self.value), "limit": self.limit,
            "time": _plain(self.time),
        }  # fmt: skip


def beside(value: float, limit: float) -> str:
    """A number beside its limit: with as many digits as show on which side of it it is.

    Args:
        value: the number.
        limit: that it is held against.
    """
    text = digits(value)
    if text != digits(limit) or value == limit or not np.isfinite(value):
        return text
    places = min(1 - int(np.floor(np.log10(abs(value - limit)))), MOST_PLACES)
    return f"{value:.{places}f}"


def conditions(run: Run) -> tuple[Condition, ...]:
    """The conditions of a run's law, each at its worst over all stretches; the step from tick to tick comes first.

    Args:
        run: a job, driven.
    """
    worst: dict[str, Condition] = {}
    for driven in run.driven:
        for found in (*_sample(run, driven), *_own(run, driven)):
            if found.name not in worst or not found.value <= worst[found.name].value:
                worst[found.name] = found
    return tuple(worst.values())


def stability_remarks(run: Run) -> list[Remark]:
    """Conditions of the law that do not hold, of a run that failed or stood at its limits: why it may have done so.

    Args:
        run: with its other remarks.
    """
    if not any(each.level == "failure" or each.key == "job.at_saturation" for each in run.remarks):
        return []
    return [Remark("warning", "job.law_unstable", {"reason": each}) for each in conditions(run) if not each.holds]


def _sample(run: Run, driven: Driven) -> Iterator[Condition]:
    """Small errors from tick to tick."""
    factor, time = growth_along(run.job, driven)
    if np.isfinite(factor):
        yield Condition("sampled", factor, 1.0, driven.stretch.start + time)


def _own(run: Run, driven: Driven) -> Iterator[Condition]:
    """What is asked of the law itself and of its parts."""
    for part in parts_of(driven.scenario.law):
        test = _TESTS.get(type(part))
        if test is not None:
            yield from test(part, run, driven)


def parts_of(law: Law) -> Iterator[Law]:
    """A law's parts: of sums, of laws behind a delay or an inner loop, of those that a contact parts."""
    if isinstance(law, LawWrapper):
        yield from parts_of(law.law)
    elif isinstance(law, Combined):
        for part in law.laws:
            yield from parts_of(part)
    elif isinstance(law, ContactSwitch):
        yield from (*parts_of(law.free), *parts_of(law.touching))
    else:
        yield law


def _error_equation(law: ComputedTorque | TaskComputedTorque, run: Run, driven: Driven) -> Iterator[Condition]:
    yield from _equation_of(law.gains)


def _equation_of(gains: Gains) -> Iterator[Condition]:
    """e'' + Kd e' + Kp e + Ki int e = 0: the largest real part of its roots."""
    rows = np.stack([np.ones_like(gains.kp), gains.kd, gains.kp], axis=-1)
    found = [np.roots([*row, ki] if ki else row) for row, ki in zip(rows, gains.ki, strict=True)]
    yield Condition("error_equation", max(float(roots.real.max()) for roots in found), 0.0)


def _integral(law: JointFeedback, run: Run, driven: Driven) -> Iterator[Condition]:
    """Ki below Kp (Kd + viscous) / M of each joint by itself, as a share of it, where the inertia is largest."""
    gains, trajectory, true = law.gains, driven.stretch.trajectory, driven.scenario.true_plant
    if not gains.integrates:
        return
    times = np.linspace(0.0, trajectory.duration, PLACES)
    M = np.diagonal(np.asarray(true.robot.mass_matrix(trajectory.at(times).u)), axis1=-2, axis2=-1)
    kd = gains.kd
    if true.has_friction:
        friction = true.friction_law
        kd = kd + np.diagonal(friction.gain.T @ (friction.viscous[:, None] * friction.gain))
    shares = (gains.ki * M / np.maximum(gains.kp * kd, LEAST_DIVISOR)).max(axis=-1)
    k = int(shares.argmax())
    yield Condition("integral", float(shares[k]), 1.0, driven.stretch.start + float(times[k]))


def _sliding(law: SlidingMode, run: Run, driven: Driven) -> Iterator[Condition]:
    """The bound covers what the true arm needs beyond the model, at every moment of the run."""
    t, q, qd = _record(run, driven)
    if len(t):
        found = sliding_certificate(
            law, driven.scenario.true_plant.robot, driven.stretch.trajectory, t - driven.stretch.start, q, qd
        )
        share = (np.abs(found.needed) / np.maximum(found.bound, LEAST_DIVISOR)).max(axis=-1)
        yield _worst("bound", share, t)


def _min_max(law: MinMax, run: Run, driven: Driven) -> Iterator[Condition]:
    """Errors keep below the bound that follows from the width of the boundary layer."""
    t, q, _ = _record(run, driven)
    if len(t):
        bound = law.error_bound(q, driven.scenario.true_plant.robot)
        error = np.abs(driven.stretch.trajectory.at(t - driven.stretch.start).u - q)
        yield _worst("error_bound", (error / bound).max(axis=-1), t)


def _learn(law: AdaptiveControl, run: Run, driven: Driven) -> Iterator[Condition]:
    """Efforts of contact, which no inertia explains: the law learns them as a payload, and its proof asks for none."""
    wrench, t = run.recording.contact_wrench, run.recording.t
    if wrench is None:
        return
    rows = _rows(run, driven)
    efforts = law.robot.jacobian_body(run.recording.q[rows]).swapaxes(-1, -2) @ wrench[rows][..., None]
    size = np.abs(efforts[..., 0]).max(axis=-1)
    if size.any():
        k = int(size.argmax())
        yield Condition("learned", float(size[k]), 0.0, float(t[rows][k]))


def _force_loop(law: HybridControl, run: Run, driven: Driven) -> Iterator[Condition]:
    """On a rigid wall with one period of delay z^2 + (Kfp + Kfi dt - 1) z - Kfp has to have its roots inside."""
    yield from _equation_of(law.gains)
    if law.sensor is not None:
        kp, ki = float(law.force_gains.kp.max()), float(law.force_gains.ki.max())
        roots = np.roots([1.0, kp + ki * driven.scenario.control_period - 1.0, -kp])
        yield Condition("force_loop", float(np.abs(roots).max()), 1.0)


def _virtual_motion(law: ImpedanceControl | AdmittanceControl, run: Run, driven: Driven) -> Iterator[Condition]:
    """The tip's motion about its reference: the largest real part of the roots of D, B and K.

    A direction in which nothing pulls back has a root at zero: there the tip stays where it was led.
    """
    roots, led = np.sort(law.impedance.roots.real), int((np.diagonal(law.impedance.stiffness) == 0.0).sum())
    yield Condition("virtual_motion", float(roots[-1 - led]), 0.0)


def _virtual_step(law: AdmittanceControl, run: Run, driven: Driven) -> Iterator[Condition]:
    """The step of the virtual mass, held by its own spring and by the stiffest thing that it may touch."""
    yield from _virtual_motion(law, run, driven)
    own, period = law.impedance, driven.scenario.control_period
    stiffest = max((one.stiffness or 0.0 for one in run.job.surface), default=0.0)
    shifts = [k for k, row in enumerate(law.coordinates.rows) if row >= 3]
    radii = [
        admittance_radius(own.inertia[k, k], own.damping[k, k], stiffness, period)
        if (stiffness := float(own.stiffness[k, k]) + stiffest) > 0.0
        else abs(1.0 - float(own.damping[k, k] / own.inertia[k, k]) * period)
        for k in shifts
    ]
    if radii:
        yield Condition("virtual_step", max(radii), 1.0)
    yield from _rigid_step(law, run, driven)


def _rigid_step(law: AdmittanceControl, run: Run, driven: Driven) -> Iterator[Condition]:
    """On a rigid surface, one period late, f(k + 1) = f(k) (1 - n D^-1 n / n Lambda^-1 n) + ...: that factor."""
    trajectory = driven.stretch.trajectory
    times = np.linspace(0.0, trajectory.duration, PLACES)
    for one in (one for one in run.job.surface if one.rigid):
        face, factors = Face(shape_of(one), law.coordinates.rows), np.zeros(PLACES)
        for k, q in enumerate(trajectory.at(times).u):
            n = face.along(law.coordinates.pose(law.robot, q))
            inertia = task_dynamics(law.robot, q, coordinates=law.coordinates).inertia
            factors[k] = abs(1.0 - (n @ np.linalg.solve(law.impedance.inertia, n)) / (n @ np.linalg.solve(inertia, n)))
        yield _worst("rigid_step", factors, driven.stretch.start + times)


def _about_pose(law: LinearQuadratic, run: Run, driven: Driven) -> Iterator[Condition]:
    """The roots of the errors at the pose for which the gains are the cheapest."""
    yield Condition("about_pose", float(law.roots[0].real), 0.0)


def _record(run: Run, driven: Driven) -> tuple[Floats, Floats, Floats]:
    """Times (k,), positions and rates (k, n) of a stretch."""
    tape, rows = run.recording, _rows(run, driven)
    return tape.t[rows], tape.q[rows], tape.qd[rows]


def _rows(run: Run, driven: Driven) -> NDArray[np.int64]:
    """Those of the recording that belong to a stretch, at most some thousands."""
    t, stretch = run.recording.t, driven.stretch
    inside = np.flatnonzero((t >= stretch.start) & (t <= stretch.start + stretch.trajectory.duration))
    return inside[:: max(1, len(inside) // LONGEST)]


def _worst(name: str, shares: Floats, t: Floats) -> Condition:
    k = int(shares.argmax())
    return Condition(name, float(shares[k]), 1.0, float(t[k]))


def _plain(value: float) -> float | None:
    return value if np.isfinite(value) else None


_TESTS: dict[type, Callable[[Any, Run, Driven], Iterator[Condition]]] = {
    AdaptiveControl: _learn,
    ComputedTorque: _error_equation,
    TaskComputedTorque: _error_equation,
    JointFeedback: _integral,
    SlidingMode: _sliding,
    MinMax: _min_max,
    HybridControl: _force_loop,
    ImpedanceControl: _virtual_motion,
    AdmittanceControl: _virtual_step,
    LinearQuadratic: _about_pose,
}
