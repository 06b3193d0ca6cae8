"""The error of an arm split exactly into what its law did not know, at one tick; what is left over has no name."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats
from mafsil.control.laws import ComputedTorque, JointFeedback
from mafsil.job.arrival import INSTANT, Arrival
from mafsil.job.run import Run
from mafsil.job.stretch import Driven
from mafsil.simulation.variation import push_at
from mafsil.trajectory import Motion


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
