"""Runs of arms whose joints are elastic: links and motors, under a law of both."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from math import ceil
from typing import TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer
from mafsil.arrays import Floats, JointVector, as_batch, positive, real_array, require_function, spread
from mafsil.control.joints import ElasticArm, ElasticLaw, ElasticState
from mafsil.control.laws import FunctionLaw
from mafsil.errors import InputError
from mafsil.simulation.faults import Stopped, law_efforts, law_name
from mafsil.simulation.recording import SimulationStatus
from mafsil.simulation.tolerances import PART_OF_STEP
from mafsil.trajectory import Motion, Trajectory

ElasticLawFunction: TypeAlias = Callable[[float, ElasticState, Motion], JointVector]
"""(t, state, reference) -> efforts of the motors (*batch, n): a law without memory."""

RUNAWAY = 1e6
"""Rate [rad/s | m/s] beyond which a run counts as blown up."""
MOST_TICKS = 5_000_000


@dataclass(frozen=True, eq=False, repr=False)
class ElasticRun(Answer, data="t q qd motor motor_rate tau q_ref"):
    """A run of links and motors; true if it reached its end.

    Attributes:
        status: how it ended.
        t: (k,) times [s].
        q, qd: (k, *batch, n) of the links [rad | m] and per second.
        motor, motor_rate: (k, *batch, n) of the motors, at the joint.
        tau: (k, *batch, n) efforts after each time [N m | N].
        q_ref: (k, n) the reference.
        end, step: of the request [s].
        law: its name.
        fault: what the law did wrong, in a few words; empty if nothing.
    """

    status: SimulationStatus
    t: Floats
    q: Floats
    qd: Floats
    motor: Floats
    motor_rate: Floats
    tau: Floats
    q_ref: Floats
    end: float
    step: float
    law: str
    fault: str

    def explain(self, language: str | None = None) -> str:
        """How the run ended."""
        details = {"end": self.end, "step": self.step, "law": self.law, "fault": self.fault}
        return self.status.sentence(language, time=float(self.t[-1]), **details)

    def state(self, k: int) -> ElasticState:
        """At the k-th time."""
        return ElasticState(self.q[k], self.qd[k], self.motor[k], self.motor_rate[k])


def _limit(value: ArrayLike) -> Floats:
    limit = real_array("effort_limit", value)
    if not (limit >= 0.0).all():
        raise InputError("input.range", name="effort_limit", value=float(limit.min()), low=0.0, high=np.inf)
    return limit


def simulate_elastic(
    arm: ElasticArm,
    law: ElasticLaw | ElasticLawFunction,
    trajectory: Trajectory,
    *,
    start: ElasticState | None = None,
    duration: float | None = None,
    step: float = 2e-4,
    effort_limit: ArrayLike = np.inf,
) -> ElasticRun:
    """Run a law on an arm with elastic joints: Runge and Kutta's step of fourth order, efforts constant within each.

    Args:
        arm: that moves; the law's model may be another.
        law: called once a step; a plain function of (t, state, reference) is a law without memory.
        trajectory: of the links.
        start: state, (*batch, n) each; at rest at the trajectory's start if None.
        duration: that of the trajectory if None [s].
        step: short against the springs' swing: below 2.8 / sqrt(K (1/M + 1/B)) [s].
        effort_limit: of the motors at the joint, a number or (n,) [N m | N].

    Raises:
        InputError: wrong shapes, a step or duration that is not positive, more than five million steps, no law.

    A law that raises, or returns what are no efforts, ends the run; its status says so, and what was recorded is kept.
    """
    session = _begun(law, step)
    length = trajectory.duration if duration is None else duration
    positive("duration", length)
    positive("step", step)
    count = ceil(length / step - PART_OF_STEP)
    if count > MOST_TICKS:
        raise InputError("input.range", name="step", value=step, low=length / MOST_TICKS, high=length)
    first = arm.at_rest(trajectory.at(0.0).u) if start is None else start
    given = [as_batch(name, x, (arm.n,), finite=True) for name, x in zip(ElasticState._fields, first, strict=True)]
    rows = np.zeros((count + 1, 4, *np.broadcast_shapes(*(x.shape for x in given))))
    rows[0] = np.stack(np.broadcast_arrays(*given))
    tau = np.zeros((count + 1, *rows.shape[2:]))
    t, limit = step * np.arange(count + 1.0), spread("effort_limit", _limit(effort_limit), tau.shape[1:], finite=False)
    wanted, status, fault, k = trajectory.at(t), SimulationStatus.COMPLETED, "", 0
    for k in range(count + 1):
        reference = type(wanted)(*(each[k] for each in wanted))
        try:
            command = law_efforts(_at_motors(session, rows[k]), float(t[k]), rows[k, 0], rows[k, 1], reference, law)
        except Stopped as stop:
            status, fault = stop.status, stop.fault
            break
        tau[k] = np.clip(command, -limit, limit)
        if not np.isfinite(tau[k]).all():
            status = SimulationStatus.NOT_FINITE
        elif k < count:
            rows[k + 1] = _step(arm, rows[k], tau[k], step)
            if not (np.abs(rows[k + 1]) < RUNAWAY).all():
                status = SimulationStatus.BLOWN_UP
        if status is not SimulationStatus.COMPLETED:
            break
    kept = slice(0, k + 1)
    q, qd, motor, motor_rate = np.moveaxis(rows[kept], 1, 0)
    return ElasticRun(
        status, t[kept], q, qd, motor, motor_rate, tau[kept], wanted.u[kept], float(length), step, law_name(law), fault
    )


def _begun(law: ElasticLaw | ElasticLawFunction, step: float) -> ElasticLawFunction:
    """What is asked in one run."""
    if isinstance(law, type) or not hasattr(law, "session"):
        require_function("law", law, "function law(t, state, reference), or an ElasticLaw", 3)
        return law
    positive("step", step)
    return cast("ElasticLaw", law).session(step)


def _at_motors(session: ElasticLawFunction, row: Floats) -> FunctionLaw:
    """A law of the links alone: the motors' state is filled in."""
    return FunctionLaw(lambda t, q, qd, reference: session(t, ElasticState(q, qd, *row[2:]), reference))


def _step(arm: ElasticArm, row: Floats, tau: Floats, h: float) -> Floats:
    """(4, *batch, n) one step later."""

    def slope(x: Floats) -> Floats:
        links, motors = arm.accelerations(ElasticState(*x), tau)
        return np.stack([x[1], links, x[3], motors])

    a = slope(row)
    b = slope(row + 0.5 * h * a)
    c = slope(row + 0.5 * h * b)
    d = slope(row + h * c)
    return row + h / 6.0 * (a + 2.0 * b + 2.0 * c + d)
