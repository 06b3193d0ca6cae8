"""Runs of one-joint arms under their laws: without sampling, or as loops with period, delay, limits and sensors."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from importlib import import_module
from math import exp, pi
from typing import Any, ClassVar, Literal, cast

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.answer import Status
from mafsil.arrays import Floats, not_negative, positive, require_function, require_kind, whole
from mafsil.errors import InputError
from mafsil.fields import check_fields
from mafsil.one_joint.joint_law import JointArm, JointLaw
from mafsil.one_joint.rows import RowAnswer, above_zero, above_zero_or_unbounded, finite, magnitude, row, together
from mafsil.one_joint.tolerances import WHOLE_STEPS

Reference = Callable[[Floats], tuple[ArrayLike, ArrayLike, ArrayLike]]
"""theta_d, theta_d', theta_d'' at times (k,), each (k,) or (*batch, k)."""

AntiWindup = Literal["off", "hold", "back_calculation"]
KINDS = ("off", "hold", "back_calculation")


class RunStatus(Status):
    """How a run ended."""

    COMPLETED = ("one_joint.completed", True)
    BLOWN_UP = ("one_joint.blown_up", False)


@dataclass(frozen=True, eq=False, repr=False)
class JointRun(RowAnswer):
    """A simulated motion of a joint; true if every row was completed.

    Attributes:
        verdict: (*batch) which of `statuses`.
        t: (*batch, k) [s].
        theta, speed: (*batch, k) [rad], [rad/s]; NaN after a row blew up.
        error: (*batch, k) theta_d - theta [rad].
        torque: (*batch, k) that acts [N m].
        parts: (*batch, k, 3) the P, I and D parts of the feedback.
    """

    statuses: ClassVar[tuple[Status, ...]] = tuple(RunStatus)
    verdict: NDArray[np.int8]
    t: Floats
    theta: Floats
    speed: Floats
    error: Floats
    torque: Floats
    parts: Floats

    @property
    def rms_error(self) -> Floats:
        """(*batch) root of the mean squared error over the run, by the trapezoidal rule [rad]."""
        return np.sqrt(np.trapezoid(self.error**2, self.t) / (self.t[..., -1] - self.t[..., 0]))

    @property
    def effort(self) -> Floats:
        """(*batch) integral of the squared torque, by the trapezoidal rule [N^2 m^2 s]."""
        return np.asarray(np.trapezoid(self.torque**2, self.t))

    @property
    def largest_error(self) -> Floats:
        """(*batch) largest |error| [rad]."""
        return np.asarray(np.abs(self.error).max(axis=-1))

    def error_at(self, times: ArrayLike) -> Floats:
        """(*batch, m) errors at the ticks nearest to times (m,) [s]."""
        wanted = row("times", times)
        if wanted.ndim != 1:
            raise InputError("input.shape", name="times", expected="(m,)", got=wanted.shape, hint="")
        first, step = self.t[..., :1], self.t[..., 1:2] - self.t[..., :1]
        index = np.clip(np.rint((wanted - first) / step).astype(np.intp), 0, self.t.shape[-1] - 1)
        return np.take_along_axis(self.error, index, axis=-1)

    def details(self) -> dict[str, object]:
        """Last time and error before anything blew up."""
        good = int(np.isfinite(self.theta).sum()) - 1
        return {"time": float(self.t[good]), "error": float(self.error[good])}


@dataclass(frozen=True)
class LoopConditions:
    """Sampling, delay and sensing between a law and its joint.

    Attributes:
        torque_limit: of the drive, a number or (*batch) [N m].
        anti_windup: what the integral does while the torque is at its limit: "off" (the book's loop), "hold" (it does
            not grow further), "back_calculation" (it is led back within `tracking_time`).
        tracking_time: of back-calculation, a number or (*batch) [s].
        delay: whole periods from a reading to the torque that follows from it.
        quantum: step of the position sensor, a number or (*batch) [rad]; 0 for none.
        filter_time: time constant T of the filter on the differenced position [s], v = a v + (1 - a) dq/dt,
            a = exp(-period / T); 0 for none.
        tachometer: whether the speed is measured instead.
        dither: amplitude of a sine on the torque that acts, to loosen friction, a number or (*batch) [N m].
        dither_frequency: w of that sine, below half a tick's turn pi / period, a number or (*batch) [rad/s].
    """

    torque_limit: ArrayLike = np.inf
    anti_windup: AntiWindup = "off"
    tracking_time: ArrayLike = 0.1
    delay: int = 0
    quantum: ArrayLike = 0.0
    filter_time: float = 0.0
    tachometer: bool = False
    dither: ArrayLike = 0.0
    dither_frequency: ArrayLike = 0.0
    _numbers = check_fields(
        torque_limit=above_zero_or_unbounded, tracking_time=above_zero, quantum=magnitude, filter_time=not_negative,
        dither=magnitude, dither_frequency=magnitude,
    )  # fmt: skip

    def __post_init__(self) -> None:
        self._numbers()
        if self.anti_windup not in KINDS:
            raise InputError("input.choice", name="anti_windup", value=self.anti_windup, known=", ".join(KINDS))
        whole("delay", self.delay, most=100_000)

    def numbers(self, period: float, batch: tuple[int, ...]) -> Floats:
        """(*batch, 9) as the compiled loop takes them."""
        lag = self.filter_time
        coefficient = exp(-period / lag) if lag else 0.0
        turn = np.asarray(self.dither_frequency)
        if (turn * period >= pi).any():
            raise InputError("input.range", name="dither_frequency", value=float(turn.max()), low=0.0, high=pi / period)
        columns = (
            self.torque_limit, float(KINDS.index(self.anti_windup)), self.tracking_time, float(self.delay),
            self.quantum, coefficient, float(self.tachometer), self.dither, turn,
        )  # fmt: skip
        return np.stack([np.broadcast_to(column, batch) for column in columns], axis=-1)


IDEAL = LoopConditions()
"""Differenced position, no limit, no delay."""


def simulate_joint(
    arm: JointArm,
    law: JointLaw,
    reference: Reference | ArrayLike,
    duration: float,
    *,
    start: ArrayLike = 0.0,
    speed: ArrayLike = 0.0,
    step: float = 1e-3,
) -> JointRun:
    """An arm under a law in continuous time: feedback at every instant, no sampling.

    Args:
        arm: with viscous friction only: dry friction needs `simulate_sampled`.
        law: of any kind, with gains (*batch).
        reference: a set point (*batch) [rad], or a function of times (k,) to theta_d, theta_d', theta_d''.
        duration: [s].
        start, speed: (*batch) [rad], [rad/s].
        step: of the Runge-Kutta method of order 4 [s].

    Returns:
        States at multiples of the step. Memory: 80 bytes for each tick of each row, besides the reference.

    Raises:
        InputError: dry friction, a number out of its range, shapes that do not go together.
    """
    require_kind("arm", arm, "JointArm", "gravity_moment", "friction")
    if arm.friction.dry:
        raise InputError("one_joint.dry_friction")
    ticks, h = _ticks(duration, step)
    rows = _Rows(arm, law, start, speed)
    wanted = rows.reference(reference, np.arange(2.0 * ticks - 1.0) * (0.5 * h))
    out = np.empty((rows.count, ticks, 7))
    _loops().run_continuous(*rows.numbers, h, wanted, rows.start, out)
    return rows.as_run(out, h)


def simulate_sampled(
    arm: JointArm,
    law: JointLaw,
    reference: Reference | ArrayLike,
    duration: float,
    *,
    period: float,
    start: ArrayLike = 0.0,
    speed: ArrayLike = 0.0,
    conditions: LoopConditions = IDEAL,
    substeps: int = 10,
) -> JointRun:
    """An arm under a sampled loop: the torque is computed once a period and kept.

    The order is that of the pseudo-code: sense, difference (zero at the first reading), update the integral, then use
    it, command. Between commands the plant moves by Runge-Kutta steps; where the joint stops, the instant is found and
    stiction asked, as the set-valued law that it is.

    Args:
        arm: with any friction.
        law: of any kind, with gains (*batch).
        reference: a set point (*batch) [rad], or a function of times (k,) to theta_d, theta_d', theta_d''.
        duration: [s].
        period: of the loop [s].
        start, speed: (*batch) [rad], [rad/s].
        conditions: limits, delay, sensors.
        substeps: of the plant in each period.

    Returns:
        States at the ticks. Memory: 80 bytes for each tick of each row, besides the reference.

    Raises:
        InputError: a number out of its range, shapes that do not go together.

    Reference: Lynch and Park, Modern Robotics, sec. 11.4.1 (pseudo-code of the PID, feedforward and computed torque
    loops).
    """
    require_kind("arm", arm, "JointArm", "gravity_moment", "friction")
    require_kind("conditions", conditions, "LoopConditions", "anti_windup", "numbers")
    ticks, h = _ticks(duration, period)
    rows = _Rows(
        arm,
        law,
        start,
        speed,
        *(np.asarray(x) for x in (conditions.torque_limit, conditions.quantum, conditions.dither)),
    )
    wanted = rows.reference(reference, np.arange(float(ticks)) * h)
    between = conditions.numbers(h, rows.batch).reshape(rows.count, 9)
    out = np.empty((rows.count, ticks, 7))
    pieces = whole("substeps", substeps, least=1)
    _loops().run_sampled(*rows.numbers, between, h, pieces, wanted, rows.start, out)
    return rows.as_run(out, h)


def _list(value: object) -> Sequence[ArrayLike]:
    """The parts of a tuple or list; anything else is one part."""
    return cast("Sequence[ArrayLike]", value if isinstance(value, tuple | list) else (value,))


def _loops() -> Any:
    """The compiled loops, loaded at the first run."""
    return import_module("mafsil.one_joint.arm_loops")


def _ticks(duration: float, step: float) -> tuple[int, float]:
    """Number of ticks, both ends included, and their distance."""
    T, h = positive("duration", duration), positive("step", step)
    count = int(min(np.rint(T / h), 1e9))
    if count < 1 or count > 10**8 or abs(count * h - T) > WHOLE_STEPS * h * max(count, 1):
        raise InputError("one_joint.ticks", duration=T, step=h)
    return count + 1, h


class _Rows:
    """The batch, flat, as the loops take it."""

    def __init__(self, arm: JointArm, law: JointLaw, start: ArrayLike, speed: ArrayLike, *others: Floats) -> None:
        require_kind("law", law, "JointLaw", "kind", "model")
        q, w = finite("start", start), finite("speed", speed)
        parts = {"arm": arm.inertia, "law": law.kp, "model": law.model.inertia, "start": q, "speed": w}
        parts |= {f"conditions[{k}]": other for k, other in enumerate(others)}
        self.batch = together(**parts)[0].shape
        self.count = int(np.prod(self.batch, dtype=np.int64))
        kind = np.asarray(float(law.kind))
        self.numbers = (self._flat(*_arm(arm)), self._flat(*_arm(law.model)), self._flat(kind, law.kp, law.ki, law.kd))
        self.start = self._flat(q, w)

    def _flat(self, *columns: Floats) -> Floats:
        wide = [np.broadcast_to(column, self.batch) for column in columns]
        return np.ascontiguousarray(np.stack(wide, axis=-1).reshape(self.count, len(columns)))

    def reference(self, wanted: Reference | ArrayLike, t: Floats) -> Floats:
        """(rows, k, 3); a reference that all rows share is not copied."""
        if callable(wanted):
            require_function("reference", wanted, "function of times to theta_d, theta_d', theta_d''", 1)
            found = tuple(_list(wanted(t)))
            if len(found) != 3:
                raise InputError("one_joint.reference", got=f"{len(found)} values")
            parts = [finite(f"reference[{k}]", part) for k, part in enumerate(found)]
        else:
            goal = finite("reference", wanted)[..., None]
            parts = [goal, np.zeros(1), np.zeros(1)]
        shape = (*np.broadcast_shapes(*(part.shape[:-1] for part in parts)), len(t))
        try:
            stacked = np.stack([np.broadcast_to(part, shape) for part in parts], axis=-1)
            wide = np.broadcast_to(stacked, (*self.batch, len(t), 3))
        except ValueError:
            raise InputError(
                "input.shape", name="reference", expected=(*self.batch, len(t)), got=shape, hint=""
            ) from None
        return wide.reshape(self.count, len(t), 3)

    def as_run(self, out: Floats, h: float) -> JointRun:
        """The run, in the shape of the batch."""
        ticks = out.shape[1]
        rows = out.reshape(*self.batch, ticks, 7)
        verdict = np.where(np.isfinite(rows).all(axis=(-1, -2)), 0, 1).astype(np.int8)
        t: Floats = np.broadcast_to(np.arange(float(ticks)) * h, (*self.batch, ticks))
        theta, speed, error, torque = (rows[..., k] for k in range(4))
        return JointRun(np.asarray(verdict), t, theta, speed, error, torque, rows[..., 4:])


def _arm(arm: JointArm) -> tuple[Floats, ...]:
    f = arm.friction
    return arm.inertia, arm.gravity_moment, f.static, f.kinetic, f.viscous, f.stribeck_speed, f.exponent
