"""Whether hybrid control did along a motion what its two parts promise: each error obeys an equation of its own."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, as_batch, not_negative, require_kind, single
from mafsil.control.contact.force import sampled_force_radius
from mafsil.control.contact.hybrid import HybridControl
from mafsil.control.laws.gains import Gains
from mafsil.control.laws.task_dynamics import task_dynamics
from mafsil.errors import InputError
from mafsil.one_joint import roots


class HybridStatus(Status):
    """Whether both errors obeyed their equations, and whether these die out."""

    OBEYED = ("control.hybrid_obeyed", True)
    DEPARTED = ("control.hybrid_departed", False)
    UNSTABLE = ("control.hybrid_unstable", False)


@dataclass(frozen=True, eq=False, repr=False)
class HybridCertificate(Answer, data="t motion force motion_share force_share slowest_root force_radius"):
    """Residuals of the error equations of hybrid control along a motion; true if the errors obeyed stable ones.

    Attributes:
        status: OBEYED, DEPARTED or UNSTABLE.
        t: (k,) times [s].
        motion: (k - 1, m) what the equation of the motion's error lacks, within the freedoms of motion, from each time
            to the next [rad/s^2 | m/s^2].
        force: (k - 1, m) what that of the force's error lacks, along the constraint [N m | N]; zero without forces.
        motion_share, force_share: largest of each, as share of the largest acceleration that is asked for within the
            freedoms, and of the largest force.
        slowest_root: largest real part of the roots of the motion's equation [1/s].
        force_radius: factor by which the slowest force error changes from tick to tick; 0 without feedback of force.
    """

    status: HybridStatus
    t: Floats = field(repr=False)
    motion: Floats = field(repr=False)
    force: Floats = field(repr=False)
    motion_share: float
    force_share: float
    slowest_root: float
    force_radius: float

    def explain(self, language: str | None = None) -> str:
        """The status with both shares and what makes the equations stable."""
        names = ("motion_share", "force_share", "slowest_root", "force_radius")
        return self.status.sentence(language, **{name: getattr(self, name) for name in names})


def hybrid_certificate(
    law: HybridControl, t: ArrayLike, q: ArrayLike, qd: ArrayLike, wrench: ArrayLike | None = None, *,
    allowed: float = 0.05,
) -> HybridCertificate:  # fmt: skip
    """Hybrid control held against a motion: with the right model two equations hold that know nothing of each other.

        motion, within the freedoms:  dV_e/dt + Kd V_e + Kp X_e + Ki int X_e = 0
        force, along the constraint:  F_e + Kfp F_e' + Kfi int F_e' = 0, with F_e' what was read a period before

    A wrong model, efforts at their limits, friction, a surface that gives way, or a reference that does not keep the
    constraint leave a rest. The second equation is that of a rigid surface.

    Args:
        law: of the motion.
        t: (k,) times at which it was called, evenly spaced [s].
        q, qd: (k, n) measured motion, such as that of a recording.
        wrench: (k, 6) of the world on the tip in the tip frame, such as `contact_wrench` of a recording; the force's
            equation is left out if None.
        allowed: shares up to which rests count as those of the sampling.

    Raises:
        InputError: another law, a wrong shape, a number that is not finite, fewer than three times, uneven ones.

    Reference: Lynch and Park, Modern Robotics, sec. 11.6.
    """
    allowed = not_negative("allowed", allowed)
    require_kind("law", law, "HybridControl", "constraint", "force_gains")
    n = law.robot.n
    times = single("t", t, (np.size(t),))
    if len(times) < 3 or np.ptp(np.diff(times)) > 1e-6 * (times[1] - times[0]):
        raise InputError("control.uneven_times", count=len(times))
    q, qd = (as_batch(name, x, (len(times), n), finite=True) for name, x in (("q", q), ("qd", qd)))
    period = float(times[1] - times[0])
    errors = (_errors(law, *moment) for moment in zip(times.tolist(), q, qd, strict=True))
    along, X_e, V_e, ahead, F_d = (np.stack(part) for part in zip(*errors, strict=True))
    free = np.eye(along.shape[-1]) - along
    motion = _motion_rest(law.gains, period, free, X_e, V_e)
    force, force_share = np.zeros_like(motion), 0.0
    if wrench is not None:
        W = as_batch("wrench", wrench, (len(times), 6), finite=True)
        F_e = _times(along, F_d - _exert(law, q, W))
        force = _force_rest(law.force_gains, period, F_e, _times(along, F_d))
        force_share = _share(force, _times(along, F_d), F_e)
    motion_share = _share(motion, _times(free, ahead), _times(free, law.gains.kp * X_e))
    root, radius = _slowest_root(law.gains), _radius(law, period)
    status = HybridStatus.OBEYED if max(motion_share, force_share) <= allowed else HybridStatus.DEPARTED
    if not (root < 0.0 and radius < 1.0):
        status = HybridStatus.UNSTABLE
    return HybridCertificate(status, times, motion, force, motion_share, force_share, root, radius)


def _errors(law: HybridControl, t: float, q: Floats, qd: Floats) -> tuple[Floats, ...]:
    """Projection on the constraint, X_e, V_e, acceleration of the reference, and F_d."""
    task = law.coordinates
    T, V = task.pose(law.robot, q), task_dynamics(law.robot, q, qd, task).V
    A = law.constraint(T, V)[0]
    return (
        np.linalg.pinv(A) @ A,
        *task.error(T, law.reference(t), V),
        law.force(T) if callable(law.force) else law.force,
    )


def _motion_rest(gains: Gains, period: float, free: Floats, X_e: Floats, V_e: Floats) -> Floats:
    """(k - 1, m) what dV_e/dt + Kd V_e + Kp X_e + Ki int X_e is, within the freedoms."""
    X_e, V_e = _times(free, X_e), _times(free, V_e)
    stored = np.cumsum(gains.ki * period * X_e, axis=0)
    return _times(free[:-1], np.diff(V_e, axis=0) / period + (gains.kp * X_e + gains.kd * V_e + stored)[:-1])


def _force_rest(gains: Gains, period: float, F_e: Floats, F_d: Floats) -> Floats:
    """(k - 1, m) what F_e + Kfp F_e' + Kfi int F_e' is; the first reading F_e' is of a force that is zero."""
    read = np.concatenate([F_d[:1], F_e[:-1]])
    return (F_e + gains.kp * read + np.cumsum(gains.ki * period * read, axis=0))[1:]


def _share(rest: Floats, *sizes: Floats) -> float:
    """The largest rest as share of the largest of what it is held against."""
    largest = max(float(np.abs(each).max()) for each in sizes)
    return float(np.abs(rest).max()) / largest if largest > 0.0 else 0.0


def _exert(law: HybridControl, q: Floats, wrench: Floats) -> Floats:
    """(k, m) what the tip exerts, in the coordinates of the task."""
    R = law.coordinates.pose(law.robot, q)[:, :3, :3]
    both = -np.concatenate([_times(R, wrench[:, :3]), _times(R, wrench[:, 3:])], axis=-1)
    return both[:, list(law.coordinates.rows)]


def _slowest_root(gains: Gains) -> float:
    rows = np.stack([np.ones_like(gains.kp), gains.kd, gains.kp, gains.ki], axis=-1)
    return max(float(roots(row if row[-1] else row[:-1]).real.max()) for row in rows)


def _radius(law: HybridControl, period: float) -> float:
    """Of the order that is closed: without an integral F_e = -Kfp F_e', and nothing without a gain."""
    kp, step = law.force_gains.kp, law.force_gains.ki * period
    return float(np.where(step > 0.0, sampled_force_radius(kp, step), kp).max())


def _times(A: Floats, x: Floats) -> Floats:
    return (A @ x[..., None])[..., 0]
