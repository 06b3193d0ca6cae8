"""Why an arm is not where it should be: its error, split exactly into what the law did not know."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from mafsil.arrays import Floats
from mafsil.control import ComputedTorque, JointFeedback
from mafsil.job.arrival import INSTANT, Arrival
from mafsil.job.remark import said
from mafsil.job.run import Run
from mafsil.job.stretch import Driven
from mafsil.messages import say
from mafsil.messages.quantities import digits, quantity
from mafsil.messages.visible import visible
from mafsil.model import JointKind
from mafsil.simulation.disturbance import push_at
from mafsil.trajectory import Motion

MAIN_PART = 0.5
"""Part of an error from which on its cause is named."""
UNSTABLE = 1.01
"""Growth of an error from tick to tick from which on the gains are called too hard for the rate."""
OBSERVED, TURNS = 100, 4
"""Ticks before a miss in which so many changes of sense show that the joint oscillates."""


@dataclass(frozen=True, slots=True)
class Cause:
    """What a miss comes from; `key` and `details` as in Remark, `joint` the coordinate that shows it."""

    key: str
    joint: int
    details: Mapping[str, object] = field(default_factory=dict[str, object])

    def explain(self, *, language: str | None = None) -> str:
        """The cause in words, with the number that shows it."""
        return say(self.key, language=language, **{name: said(value, language) for name, value in self.details.items()})


@dataclass(frozen=True, eq=False, slots=True)
class Split:
    """The error of every joint at a tick, as the sum of its causes; arrays are (n,) [rad | m].

    With the law and the equations of the true arm written out, the error e = u - q obeys exactly

        K e = (commanded - applied) + friction - J' (push + touch) + (true - model) + (model - modelled) - integral

    K is the stiffness of the law (Kp, or M Kp for computed torque); `commanded - applied` is what the effort limit
    took; `true - model` the effort by which the real masses differ from the model's in the recorded motion;
    `model - modelled` what the law lacks because the arm does not follow the reference's rate and acceleration;
    `integral` what the law has stored of earlier errors.

    Attributes:
        error: u - q.
        limit, friction, push, contact, model, lag, integral, noise: the parts.
    """

    error: Floats
    limit: Floats
    friction: Floats
    push: Floats
    contact: Floats
    model: Floats
    lag: Floats
    integral: Floats
    noise: Floats

    def parts(self) -> dict[str, Floats]:
        """All parts by name; their sum is the error."""
        names = ("limit", "friction", "push", "contact", "model", "lag", "integral", "noise")
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
    kp, kd, stored = law.gains.kp, law.gains.kd, _stored(run, driven, law, row)
    if isinstance(law, ComputedTorque):
        model = np.asarray(law.robot.inverse_dynamics(q, qd, qdd))
        M = np.asarray(law.robot.mass_matrix(q))
        stiffness = M * kp
        lag = M @ (qdd - tape.qdd_ref[row] - kd * de)
        modelled = np.asarray(law.robot.inverse_dynamics(q, qd, tape.qdd_ref[row] + kp * e + kd * de + stored))
        stored = M @ stored
    else:
        known = law.model
        model = moving if known is None else np.asarray(known.inverse_dynamics(q, qd, qdd))
        gravity = np.zeros(len(q)) if known is None else np.asarray(known.gravity_torque(q))
        stiffness, lag = np.diag(kp), model - gravity - kd * de
        modelled = kp * e + kd * de + gravity + stored
    parts = {
        "limit": commanded - applied,
        "friction": friction,
        "push": -pushed,
        "contact": -touched,
        "model": moving - model,
        "lag": lag,
        "integral": -stored,
        "noise": modelled - commanded,
    }
    try:
        inverse = np.asarray(np.linalg.inv(stiffness), dtype=np.float64)
    except np.linalg.LinAlgError:
        return None
    return Split(e, **{name: inverse @ part for name, part in parts.items()})


def _stored(run: Run, driven: Driven, law: ComputedTorque | JointFeedback, row: int) -> Floats:
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


def cause(run: Run, judged: Arrival) -> Cause | None:
    """The main cause of the error of an arrival, if one can be named.

    Args:
        run: what happened.
        judged: a leg's end.
    """
    # The last tick before the end: from the end on, the tool may hold something else.
    row = max(int(np.searchsorted(run.recording.t, judged.time - INSTANT)) - 1, 0)
    driven = max((one for one in run.driven if one.stretch.first <= judged.leg), key=lambda one: one.stretch.first)
    parts = split(run, driven, row)
    if parts is None:
        return None
    joint = worst_joint(run, judged)
    e = float(parts.error[joint])
    name, part = max(parts.parts().items(), key=lambda item: float(item[1][joint]) * np.sign(e))
    named = e != 0.0 and float(part[joint]) * np.sign(e) >= MAIN_PART * abs(e)
    growth = error_growth(driven, judged.q)
    if growth > UNSTABLE and ((named and name == "limit") or _oscillates(run, row, joint)):
        # Where the limits hold a loop that would run away, it is the gains that bring it there.
        rate = f"{digits(1.0 / driven.scenario.control_period)} Hz"
        key = "gains_limit" if named and name == "limit" else "gains"
        return _named(run, key, joint, rate=rate, growth=digits(growth))
    if not named:
        return None
    prismatic = run.robot.mechanism.coordinates[joint].kind is JointKind.PRISMATIC
    amount = quantity(abs(float(part[joint])), "m" if prismatic else "rad")
    if name == "model":
        return _named(run, name, joint, amount=amount, what=f"@job.{_unknown(run, driven)}")
    if name == "limit":
        limited = _limited(run, row)
        time = quantity(_at_limit(run, judged, limited), "s")
        return _named(run, name, joint, amount=amount, limited=visible(run.robot.joint_names[limited]), time=time)
    return _named(run, name, joint, amount=amount)


def worst_joint(run: Run, judged: Arrival) -> int:
    """The coordinate to which most of the judged error belongs."""
    allowed = judged.tolerances
    if judged.goal == "joints":
        return int((judged.joint_errors / allowed.joints).argmax())
    J = np.abs(np.asarray(run.plan.legs[judged.leg].load.robot.jacobian_body(judged.q)))
    turn, way = np.linalg.norm(J[:3], axis=0) / allowed.orientation, np.linalg.norm(J[3:], axis=0) / allowed.position
    return int((judged.joint_errors * (turn + way)).argmax())


def _named(run: Run, name: str, joint: int, **details: object) -> Cause:
    return Cause(f"job.cause_{name}", joint, {"joint": visible(run.robot.joint_names[joint]), **details})


def _unknown(run: Run, driven: Driven) -> str:
    """What the model does not know: a text of the catalogue."""
    carried = driven.stretch.carried
    part = carried is not None and (not driven.gripped if carried.known else driven.gripped)
    if part and run.job.simulation.mass_error != 0.0:
        return "unknown_both"
    if part:
        return "unknown_part" if driven.gripped else "missing_part"
    return "unknown_masses"


def _limited(run: Run, row: int) -> int:
    """The joint of which the law asks most beyond its limit at a tick."""
    tape, limit = run.recording, run.robot.limits.effort
    beyond = np.abs(tape.tau_commanded[row] - tape.tau[row])
    return int((beyond / np.where(limit > 0.0, limit, 1.0)).argmax())


def _at_limit(run: Run, judged: Arrival, joint: int) -> float:
    """How long the law asked a joint for more than its limit during the leg [s]."""
    tape = run.recording
    inside = (tape.t > run.plan.starts[judged.leg] - INSTANT) & (tape.t < judged.time - INSTANT)
    beyond = (tape.tau != tape.tau_commanded)[:, joint] & inside
    return float((beyond[:-1] * np.diff(tape.t)).sum())


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


def _oscillates(run: Run, row: int, joint: int) -> bool:
    """Whether the effort asked of a joint went to and fro just before a tick."""
    commanded = run.recording.tau_commanded[max(row - OBSERVED, 0) : row + 1, joint]
    return int((np.diff(np.sign(np.diff(commanded))) != 0).sum()) >= TURNS
