"""What went wrong in a run, each as a number that another run of the same job can be held against.

The error of an arm is split exactly into what its law did not know, at one tick; what is left over has no name.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

from mafsil.arrays import Floats
from mafsil.control.laws import ComputedTorque, JointFeedback
from mafsil.job.driving.arrival import INSTANT, Arrival, arrival, arrivals
from mafsil.job.driving.run import Run
from mafsil.job.planning.stretch import Driven
from mafsil.messages.quantities import quantity
from mafsil.model import JointKind
from mafsil.simulation.variation import push_at
from mafsil.trajectory import Motion

GIVES_WAY = (np.pi / 2, 0.5)
"""How far beyond everything planned a revolute or a prismatic joint is when the arm has given way [rad, m]."""
MOST_FAILURES = 5
"""Misses that get a sentence each; the rest are counted."""
BROKEN = 1.02
"""Share of a limit of speed or acceleration beyond which it is broken; what lies between is a warning."""
RATES = {"speed": ("qd", "velocity", "/s"), "acceleration": ("qdd", "acceleration", "/s²")}
"""Of each rate: its array in a recording, its limit, its unit."""


class Symptom(Protocol):
    """Something that went wrong."""

    @property
    def leg(self) -> int:
        """Until the end of which it shows."""
        ...

    def amount(self, run: Run) -> float:
        """How much of it there is in a run of the same job: at most 1 is allowed; inf where the run has no end there.

        Args:
            run: with at least the moves up to `leg`.
        """
        ...

    def measure(self, run: Run) -> str:
        """The same in words, or a key of the catalogue.

        Args:
            run: likewise.
        """
        ...


@dataclass(frozen=True, slots=True)
class EndedEarly:
    """The simulation stopped."""

    leg: int

    def amount(self, run: Run) -> float:
        """Nothing or everything."""
        return 0.0 if run.recording.status.succeeded else float("inf")

    def measure(self, run: Run) -> str:
        """Whether it came to its end."""
        return "@job.run_ends" if run.recording.status.succeeded else "@job.run_stops"


@dataclass(frozen=True, slots=True)
class GivenWay:
    """A joint beyond everything planned, by more than a quarter turn or half a metre."""

    leg: int
    joint: int

    def amount(self, run: Run) -> float:
        """As share of what counts as giving way."""
        return float(beyond_plan(run)[self.joint] / _way(run)[self.joint])

    def measure(self, run: Run) -> str:
        """How far beyond."""
        return joint_quantity(run, self.joint, float(beyond_plan(run)[self.joint]))


@dataclass(frozen=True, slots=True)
class Missed:
    """A target that was not reached.

    Attributes:
        leg: whose end it is.
        by: what is told of it: `position`, `orientation`, or the index of a joint.
    """

    leg: int
    by: Literal["position", "orientation"] | int

    def amount(self, run: Run) -> float:
        """As share of its tolerance."""
        judged = self._judge(run)
        return float("inf") if judged is None else judged.share

    def measure(self, run: Run) -> str:
        """The error that was the largest share of its tolerance in the run that missed."""
        judged = self._judge(run)
        if judged is None:
            return "@job.run_stops"
        if isinstance(self.by, int):
            return joint_quantity(run, self.by, float(judged.joint_errors[self.by]))
        if self.by == "position":
            return quantity(judged.position_error, "m")
        return quantity(judged.orientation_error, "rad")

    def _judge(self, run: Run) -> Arrival | None:
        return arrival(run.job, run.plan, self.leg, run.recording)


@dataclass(frozen=True, slots=True)
class LimitBroken:
    """A joint beyond 102 % of its speed or acceleration limit.

    Attributes:
        leg: in which it is worst.
        joint: which one.
        rate: `speed` or `acceleration`.
    """

    leg: int
    joint: int
    rate: str

    def amount(self, run: Run) -> float:
        """The excess over the limit, as share of what makes it a failure."""
        return (self._share(run) - 1.0) / (BROKEN - 1.0)

    def measure(self, run: Run) -> str:
        """The excess in per cent of the limit."""
        return quantity(max(self._share(run) - 1.0, 0.0), "share")

    def _share(self, run: Run) -> float:
        array, limit, _ = RATES[self.rate]
        peak = float(np.abs(getattr(run.recording, array)[:, self.joint]).max())
        return peak / float(getattr(run.robot.limits, limit)[self.joint])


def symptoms(run: Run) -> tuple[Symptom, ...]:
    """What went wrong in a run: that it stopped, that the arm gave way, the first misses, the limits it broke worst.

    Args:
        run: of a whole job.
    """
    missed = [missed_by(one) for one in arrivals(run.job, run.plan, run.recording) if not one.reached]
    return (*_ends(run), *missed[:MOST_FAILURES], *_broken(run))


def missed_by(judged: Arrival) -> Missed:
    """A miss, with the error that is the largest share of its tolerance."""
    allowed = judged.tolerances
    if judged.goal == "joints":
        return Missed(judged.leg, int((judged.joint_errors / allowed.joints).argmax()))
    way, turn = judged.position_error / allowed.position, judged.orientation_error / allowed.orientation
    return Missed(judged.leg, "position" if way >= turn else "orientation")


def beyond_plan(run: Run) -> Floats:
    """(n,) how far each joint was beyond everything planned, at most [rad | m]."""
    tape = run.recording
    beyond = np.maximum(tape.q_ref.min(axis=0) - tape.q, tape.q - tape.q_ref.max(axis=0))
    return np.asarray(beyond.max(axis=0))


def gave_way(run: Run) -> tuple[int, float] | None:
    """The joint that is farthest beyond everything planned, and since when [s], if the arm has given way.

    An arm that is led by hand where nothing pulls it back has not.
    """
    tape = run.recording
    if run.job.controller.guides:
        return None
    beyond = np.maximum(tape.q_ref.min(axis=0) - tape.q, tape.q - tape.q_ref.max(axis=0))
    share = beyond / _way(run)
    if not share.max() > 1.0:
        return None
    joint = int(share.max(axis=0).argmax())
    return joint, float(tape.t[int((share[:, joint] > 1.0).argmax())])


def joint_quantity(run: Run, joint: int, value: float, per: str = "") -> str:
    """A coordinate, or with `per` its rate, for people."""
    prismatic = run.robot.mechanism.coordinates[joint].kind is JointKind.PRISMATIC
    return quantity(value, ("m" if prismatic else "rad") + per)


def _ends(run: Run) -> Iterator[Symptom]:
    last = len(run.plan.legs) - 1
    if not run.recording.status.succeeded:
        yield EndedEarly(last)
    fallen = gave_way(run)
    if fallen is not None:
        yield GivenWay(last, fallen[0])


def _broken(run: Run) -> Iterator[Symptom]:
    """For speed and for acceleration the joint that is worst."""
    for rate, (array, limit, _) in RATES.items():
        allowed: Floats = getattr(run.robot.limits, limit)
        values: Floats = np.abs(getattr(run.recording, array))
        shares: Floats = values / np.where(allowed > 0.0, allowed, np.inf)
        if shares.max(initial=0.0) > BROKEN:
            row, joint = divmod(int(shares.argmax()), shares.shape[1])
            time = float(run.recording.t[row])
            leg = int(np.searchsorted(run.plan.starts, time, side="right")) - 1
            yield LimitBroken(min(leg, len(run.plan.legs) - 1), joint, rate)


def _way(run: Run) -> Floats:
    """(n,) [rad | m]."""
    revolute = run.robot.mechanism.angular
    return np.where(revolute, *GIVES_WAY)


@dataclass(frozen=True, eq=False, slots=True)
class Split:
    """The error of every joint at a tick, as the sum of its causes; arrays are (n,) [rad | m].

    With the law and the equations of the true arm written out, the error e = u - q obeys exactly

        K e = (commanded - applied) + friction - J' (push + touch) + (true - model) + (model - modelled) - integral
              + rest

    K is the stiffness of the law (Kp, or M Kp for computed torque); `commanded - applied` is what the effort limit
    took; `friction` that which the law does not compensate; `true - model` the effort by which the real masses differ
    from the model's in the recorded motion; `model - modelled` what the law lacks because the arm does not follow the
    reference's rate and acceleration; `integral` what the law has stored of earlier errors.

    Attributes:
        error: u - q.
        limit, friction, push, contact, model, lag, integral, rest: the parts; the rest is what the law commanded beside
            all that: by noise, delay and whatever else changes its measurements and efforts.
    """

    error: Floats
    limit: Floats
    friction: Floats
    push: Floats
    contact: Floats
    model: Floats
    lag: Floats
    integral: Floats
    rest: Floats

    def parts(self) -> dict[str, Floats]:
        """All parts by name; their sum is the error."""
        names = ("limit", "friction", "push", "contact", "model", "lag", "integral", "rest")
        return {name: getattr(self, name) for name in names}


def split(run: Run, driven: Driven, row: int) -> Split | None:
    """The causes of the error at a tick; None for laws that are not split, and where numbers have run away.

    Args:
        run: what happened.
        driven: the stretch to which the tick belongs.
        row: of the recording.
    """
    tape, scenario = run.recording, driven.scenario
    law, true = scenario.law, scenario.true_plant.robot
    if not isinstance(law, ComputedTorque | JointFeedback):
        return None
    q, qd, qdd, commanded, applied = (x[row] for x in (tape.q, tape.qd, tape.qdd, tape.tau_commanded, tape.tau))
    e, de = tape.q_ref[row] - q, tape.qd_ref[row] - qd
    if not all(np.isfinite(x).all() for x in (q, qd, qdd, commanded, applied)):
        return None
    # As the simulation does: the push of a tick is the one that acts at its beginning, in the clock of the stretch.
    tick = round((tape.t[row] - driven.stretch.start) / scenario.control_period)
    pulse = push_at(scenario.disturbances, np.array([tick * scenario.control_period]))[0]
    J = np.asarray(true.jacobian_body(q))
    pushed = np.zeros(len(q)) if pulse is None else J.T @ pulse
    touched = np.zeros(len(q)) if tape.contact_wrench is None else J.T @ tape.contact_wrench[row]
    moving = np.asarray(true.inverse_dynamics(q, qd, qdd))
    friction = applied + pushed + touched - moving
    kp, kd, stored = law.gains.kp, law.gains.kd, _store(run, driven, law, row)
    if isinstance(law, ComputedTorque):
        model = np.asarray(law.robot.inverse_dynamics(q, qd, qdd))
        M = np.asarray(law.robot.mass_matrix(q))
        stiffness = M * kp
        lag = M @ (qdd - tape.qdd_ref[row] - kd * de)
        modelled = np.asarray(law.robot.inverse_dynamics(q, qd, tape.qdd_ref[row] + kp * e + kd * de + stored))
        stored = M @ stored
        compensated = law.robot.friction_torque(tape.qd_ref[row]) * law.friction
    else:
        known = law.model
        model = moving if known is None else np.asarray(known.inverse_dynamics(q, qd, qdd))
        gravity = np.zeros(len(q)) if known is None else np.asarray(known.gravity_torque(q))
        stiffness, lag = np.diag(kp), model - gravity - kd * de
        modelled = kp * e + kd * de + gravity + stored
        compensated = 0.0 * q if known is None else known.friction_torque(tape.qd_ref[row]) * law.friction
    parts = {
        "limit": commanded - applied,
        "friction": friction - compensated,
        "push": -pushed,
        "contact": -touched,
        "model": moving - model,
        "lag": lag,
        "integral": -stored,
        "rest": modelled + compensated - commanded,
    }
    try:
        inverse = np.asarray(np.linalg.inv(stiffness), dtype=np.float64)
    except np.linalg.LinAlgError:
        return None
    return Split(e, **{name: inverse @ part for name, part in parts.items()})


def _store(run: Run, driven: Driven, law: ComputedTorque | JointFeedback, row: int) -> Floats:
    """(n,) what an integral has summed up from the beginning of a stretch to a tick, by the rectangle rule."""
    tape, start = run.recording, driven.stretch.start
    ticks = slice(int(np.searchsorted(tape.t, start - INSTANT)), row + 1)
    growth = law.gains.ki * driven.scenario.control_period * (tape.q_ref[ticks] - tape.q[ticks])
    if isinstance(law, ComputedTorque) or law.effort_limit is None:
        return np.asarray(growth.sum(axis=0))
    reference = Motion(tape.q_ref[ticks], tape.qd_ref[ticks], tape.qdd_ref[ticks])
    stored = np.zeros(growth.shape[1])
    for effort, grown in zip(law(0.0, tape.q[ticks], tape.qd[ticks], reference), growth, strict=True):
        ahead = effort + stored + grown
        stored = stored + np.where((np.abs(ahead) > law.effort_limit) & (ahead * grown > 0.0), 0.0, grown)
    return stored


def worst_joint(run: Run, judged: Arrival) -> int:
    """The coordinate to which most of the judged error belongs."""
    allowed = judged.tolerances
    if judged.goal == "joints":
        return int((judged.joint_errors / allowed.joints).argmax())
    J = np.abs(np.asarray(run.plan.legs[judged.leg].load.robot.jacobian_body(judged.q)))
    turn, way = np.linalg.norm(J[:3], axis=0) / allowed.orientation, np.linalg.norm(J[3:], axis=0) / allowed.position
    return int((judged.joint_errors * (turn + way)).argmax())


def error_growth(driven: Driven, q: Floats) -> float:
    """Largest factor by which small errors change from tick to tick: the spectral radius of the sampled loop at rest.

    x+ = x + h v + h^2/2 a,  v+ = v + h a,  M a = -K x - (D + viscous) v,  K and D those of the law.

    Args:
        driven: a stretch under its law.
        q: (n,) where the arm is [rad | m].

    Returns:
        Zero for laws that are not split.
    """
    scenario = driven.scenario
    law, plant, h = scenario.law, scenario.true_plant, scenario.control_period
    if not isinstance(law, ComputedTorque | JointFeedback):
        return 0.0
    n = len(q)
    M = np.asarray(plant.robot.mass_matrix(q))
    weight = np.asarray(law.robot.mass_matrix(q)) if isinstance(law, ComputedTorque) else np.eye(n)
    damping = weight * law.gains.kd
    if plant.has_friction:
        friction = plant.friction_law
        damping = damping + friction.gain.T @ (friction.viscous[:, None] * friction.gain)
    try:
        pull, drag = np.linalg.solve(M, weight * law.gains.kp), np.linalg.solve(M, damping)
    except np.linalg.LinAlgError:
        return 0.0
    one = np.eye(n)
    step = np.block([[one - h * h / 2 * pull, h * one - h * h / 2 * drag], [-h * pull, one - h * drag]])
    return float(np.abs(np.linalg.eigvals(step)).max())
