"""The laws that a job can choose, with gains that fit the arm where the job names none."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from mafsil.arrays import Floats
from mafsil.control import (
    Gains,
    Law,
    adaptive_control,
    add_delay,
    combine,
    computed_torque,
    encoder_loop,
    feedforward,
    friction_compensation,
    gravity_compensation,
    inertia_gains,
    linear_quadratic,
    model_predictive,
    pid,
    sliding_mode,
)
from mafsil.control.analysis import min_max
from mafsil.control.laws import LinearQuadratic, SlidingMode
from mafsil.job.driving.tip_laws import tip_law
from mafsil.job.language.description import TIP_LAWS, Job
from mafsil.job.planning.closed_moves import closed_law
from mafsil.robot import Robot
from mafsil.simulation import Plant
from mafsil.simulation.closed_plant import plant_of
from mafsil.trajectory import Trajectory

FREQUENCY, DAMPING = 20.0, 1.0
"""Of the error dynamics, where the job names none [rad/s, 1]."""
COMPENSATING = ("computed_torque", "pd_gravity", "feedforward")
"""Laws that compensate friction unless they are told not to; others where they are told to."""
PLACES = 24
"""Along a stretch, where inertia and friction are looked at."""
INTEGRAL_SHARE = 0.1
"""Of the integral gain at which a joint by itself would become unstable."""
MASS_SHARE, MARGIN, WIDTH, LEARNING = 0.2, 1.0, 0.02, 1.0
"""Of sliding mode and of the adaptive law, where the job names none."""
MOST_HALVINGS = 12
"""Of defaults that the sampling does not bear."""
LAYER, AHEAD, INTERVAL, STIFFNESS, ABOUT_POSE = 1.0, 20, 0.005, 80.0, 40.0
"""Of min-max, model-predictive and linear-quadratic control, where the job names none [N m/s, 1, s, rad/s, rad/s]."""


def law_of(job: Job, model: Robot, trajectory: Trajectory, plant: Plant) -> Law:
    """The law of a job for a stretch of its motion.

    Args:
        job: whose controller it is.
        model: the arm as the controller knows it.
        trajectory: of the stretch: gains that the job leaves out fit the inertia along it.
        plant: the arm that moves, at whose tip forces are measured.
    """
    if model.mechanism.loops:
        law = closed_law(job, model, trajectory)
    elif job.controller.kind in TIP_LAWS:
        law = tip_law(job, model, trajectory, plant)
    else:
        law = _MAKERS[job.controller.kind](job, model, trajectory)
    if job.controller.friction and job.controller.kind not in COMPENSATING:
        law = combine(law, friction_compensation(model))
    seen = job.simulation.noise
    if seen.resolution or seen.filter_time:
        law = encoder_loop(law, seen.resolution, filter_time=seen.filter_time)
    return add_delay(law, job.controller.delay) if job.controller.delay else law


def compensates_friction(job: Job) -> bool:
    """Whether the law of a job compensates the friction of the description: as the job says, else what acts."""
    given = job.controller.friction
    if given is not None:
        return given
    return job.simulation.friction and job.controller.kind in COMPENSATING


def _computed_torque(job: Job, model: Robot, trajectory: Trajectory) -> Law:
    own = job.controller
    frequency = FREQUENCY if own.frequency is None else own.frequency
    return computed_torque(
        model, natural_frequency=frequency, damping_ratio=DAMPING if own.damping is None else own.damping,
        friction=compensates_friction(job),
    )  # fmt: skip


def _pd_gravity(job: Job, model: Robot, trajectory: Trajectory) -> Law:
    kp, kd = _pd(job, model, trajectory)
    return gravity_compensation(model, kp, kd, friction=compensates_friction(job))


def _pid(job: Job, model: Robot, trajectory: Trajectory) -> Law:
    kp, kd = _pd(job, model, trajectory)
    given = job.controller.integral
    # A joint of inertia M alone is stable below ki = kp kd / M; M = kp / w^2 of its own gains.
    inertia = np.diagonal(np.asarray(model.mass_matrix(_places(trajectory))), axis1=-2, axis2=-1).max(axis=0)
    ki = INTEGRAL_SHARE * kp * kd / inertia if given is None else _row(given, model)
    return pid(model.n, kp, kd, ki, effort_limit=model.limits.effort)


def _feedforward(job: Job, model: Robot, trajectory: Trajectory) -> Law:
    kp, kd = _pd(job, model, trajectory)
    return combine(feedforward(model, friction=compensates_friction(job)), pid(model.n, kp, kd))


def _sliding_mode(job: Job, model: Robot, trajectory: Trajectory) -> Law:
    own = job.controller
    share = MASS_SHARE if own.mass_uncertainty is None else own.mass_uncertainty
    margin = _friction(job, model) + MARGIN if own.margin is None else _row(own.margin, model)
    gains = _gains(job, model, trajectory)
    law = sliding_mode(
        model, share=share, rate=gains.kp / gains.kd, damping=gains.kd, margin=margin,
        width=WIDTH if own.width is None else own.width,
    )  # fmt: skip
    return law if own.width is not None else _wide_enough(job, law, trajectory)


def _wide_enough(job: Job, law: SlidingMode, trajectory: Trajectory) -> SlidingMode:
    """With a boundary layer in which the sampling does not make the bound chatter: twice as wide until it does not."""
    places = trajectory.at(np.linspace(0.0, trajectory.duration, PLACES))
    bound = law.parts(places.u, places.v, places)[1]
    M = np.asarray(law.robot.mass_matrix(places.u))
    for _ in range(MOST_HALVINGS):
        damping = law.damping + bound / law.width
        if _bears_sampling(M, _diagonals(damping * law.rates), _diagonals(damping), job.control_period):
            break
        law = replace(law, width=2.0 * law.width)
    return law


def _min_max(job: Job, model: Robot, trajectory: Trajectory) -> Law:
    own, gains = job.controller, _gains(job, model, trajectory)
    share = MASS_SHARE if own.mass_uncertainty is None else own.mass_uncertainty
    layer = LAYER if own.width is None else own.width
    return min_max(model, share=share, rate=gains.kp / gains.kd, damping=gains.kd, width=layer)


def _model_predictive(job: Job, model: Robot, trajectory: Trajectory) -> Law:
    own = job.controller
    w = STIFFNESS if own.frequency is None else own.frequency
    # Without limits and with short intervals these weights make e'' + 2 w e' + w^2 e = 0.
    return model_predictive(
        model, horizon=AHEAD if own.horizon is None else own.horizon,
        interval=INTERVAL if own.interval is None else own.interval,
        position=w**4, rate=2.0 * w**2, acceleration=1.0,
    )  # fmt: skip


def _linear_quadratic(job: Job, model: Robot, trajectory: Trajectory) -> Law:
    w, given = ABOUT_POSE, job.controller.frequency
    pose, M = trajectory.at(trajectory.duration / 2.0).u, np.asarray(model.mass_matrix(_places(trajectory)))
    law = _about_pose(model, pose, w if given is None else given)
    for _ in range(MOST_HALVINGS if given is None else 0):
        if _bears_sampling(M, law.gain[:, : model.n], law.gain[:, model.n :], job.control_period):
            break
        w /= 2.0
        law = _about_pose(model, pose, w)
    return law


def _about_pose(model: Robot, pose: Floats, w: float) -> LinearQuadratic:
    """The law whose weights of one joint of inertia M make e'' + 2 w e' + w^2 e = 0."""
    M = np.diagonal(np.asarray(model.mass_matrix(pose)))
    return linear_quadratic(model, pose, position=(M * w**2) ** 2, rate=2.0 * (M * w) ** 2, effort=1.0)


def _bears_sampling(M: Floats, stiffness: Floats, damping: Floats, period: float) -> bool:
    """Whether M a = -K x - D v is stable from sample to sample, even half as often, wherever the arm comes.

    Args:
        M: (k, n, n) of the places.
        stiffness, damping: (n, n), or (k, n, n) K and D.
        period: of the law [s].
    """
    h, one = 2.0 * period, np.eye(M.shape[-1])
    pull, drag = (np.linalg.solve(M, np.broadcast_to(each, M.shape)) for each in (stiffness, damping))
    above = np.concatenate([one - h * h / 2.0 * pull, h * one - h * h / 2.0 * drag], axis=-1)
    step = np.concatenate([above, np.concatenate([-h * pull, one - h * drag], axis=-1)], axis=-2)
    return bool(np.abs(np.linalg.eigvals(step)).max() < 1.0)


def _diagonals(rows: Floats) -> Floats:
    """(k, n, n) from rows (k, n)."""
    return rows[..., None] * np.eye(rows.shape[-1])


def _adaptive(job: Job, model: Robot, trajectory: Trajectory) -> Law:
    gains, learning = _gains(job, model, trajectory), job.controller.learning
    return adaptive_control(
        model, rate=gains.kp / gains.kd, damping=gains.kd, learning=LEARNING if learning is None else learning
    )


_MAKERS: dict[str, Callable[[Job, Robot, Trajectory], Law]] = {
    "computed_torque": _computed_torque,
    "pd_gravity": _pd_gravity,
    "pid": _pid,
    "feedforward": _feedforward,
    "sliding_mode": _sliding_mode,
    "min_max": _min_max,
    "model_predictive": _model_predictive,
    "linear_quadratic": _linear_quadratic,
    "adaptive": _adaptive,
}
KINDS = (*_MAKERS, *TIP_LAWS)
"""All laws that a job can choose."""


def kinds_for(job: Job) -> tuple[str, ...]:
    """The laws that are compared on a job if none are named: those of the tip too where it touches something."""
    if job.surface:
        return KINDS
    touches = job.hole or job.door or job.guide
    return tuple(kind for kind in KINDS if kind != "hybrid") if touches else tuple(_MAKERS)


def _places(trajectory: Trajectory) -> Floats:
    return trajectory.at(np.linspace(0.0, trajectory.duration, PLACES)).u


def _gains(job: Job, model: Robot, trajectory: Trajectory) -> Gains:
    """Of the natural frequency that the sampling allows each joint."""
    return inertia_gains(model, _places(trajectory), job.control_period)


def _pd(job: Job, model: Robot, trajectory: Trajectory) -> tuple[Floats, Floats]:
    """Stiffness and rate gain; a stiffness without a rate gain keeps the damping ratio of our own gains."""
    own, given = _gains(job, model, trajectory), job.controller
    kp = own.kp if given.kp is None else _row(given.kp, model)
    kd = own.kd * np.sqrt(kp / own.kp) if given.kd is None else _row(given.kd, model)
    return kp, kd


def _friction(job: Job, model: Robot) -> Floats:
    """(n,) efforts of dry friction of the description [N m | N]."""
    plant = replace(plant_of(model), friction=job.simulation.friction)
    if not plant.has_friction:
        return np.zeros(model.n)
    law = plant.friction_law
    return np.abs(law.gain.T) @ (np.maximum(law.positive, law.negative) + np.abs(law.offset))


def _row(value: float | tuple[float, ...], model: Robot) -> Floats:
    return np.broadcast_to(np.array(value, dtype=np.float64), (model.n,)).copy()
