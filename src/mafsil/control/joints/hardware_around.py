"""Real hardware around a law: encoders before it, the time that it takes, the current loop behind it.

Positions come in steps and rates are differenced from them; efforts come late by what sensors, computing and amplifiers
take; motors follow the commanded torque with a bandwidth, not at once.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, as_batch, frozen, positive, real_array, single
from mafsil.control.laws.feedback import take_over
from mafsil.control.laws.law import Law, LawFunction, LawWrapper, as_law
from mafsil.errors import InputError
from mafsil.trajectory import Motion

WHOLE = 1e-6
"""How far a delay may be from a whole number of periods."""


@dataclass(frozen=True, eq=False, slots=True)
class Delayed(LawWrapper):
    """A law whose efforts act a while after the state that they answer.

    Attributes:
        law: the law itself.
        delay: from the measurement to the effort [s]; a whole number of the periods of a run.
    """

    delay: float

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Efforts (*batch, n) of the law without delay; a session keeps them back [N m | N]."""
        return self.law(t, q, qd, reference)

    def session(self, period: float) -> Law:
        """One run.

        Raises:
            InputError: the delay is no whole number of periods.
        """
        count = round(self.delay / period)
        if abs(count * period - self.delay) > WHOLE * period:
            raise InputError("control.delay", delay=self.delay, period=period)
        return _Queue(self, period, count) if count else self.law.session(period)


class _Queue:
    """One run of a delayed law: efforts wait in a queue; until the first comes, it acts already."""

    def __init__(self, law: Delayed, period: float, count: int) -> None:
        self._whole, self._law = law, law.law.session(period)
        self._count = count
        self._waiting: tuple[JointVector, ...] | None = None
        self._earlier: tuple[JointVector, ...] | None = None

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """The efforts that were asked for a delay ago (*batch, n) [N m | N]."""
        effort = self._law(t, q, qd, reference)
        before = (effort,) * (self._count + 1) if self._waiting is None else self._waiting
        self._earlier, self._waiting = self._waiting, (*before[1:], effort)
        return self._waiting[0]

    def go_on(self, before: _Queue) -> None:
        # The state at which two runs meet is seen by both.
        self._waiting = before._earlier
        take_over(self._law, before._law)

    def session(self, period: float) -> Law:
        """A new run."""
        return self._whole.session(period)


def add_delay(law: Law | LawFunction, delay: float) -> Delayed:
    """A law whose efforts act a delay after the measurement.

    Args:
        law: without delay; a function of (t, q, qd, reference) too.
        delay: a whole number of the periods of the run [s].

    Raises:
        InputError: a negative or infinite delay, or no law.
    """
    late = float(single("delay", delay, ()))
    if not 0.0 <= late < float("inf"):
        raise InputError("input.range", name="delay", value=late, low=0.0, high=float("inf"))
    return Delayed(as_law(law), late)


@dataclass(frozen=True, eq=False, slots=True)
class CurrentLoopLaw(LawWrapper):
    """A law behind an inner loop: tau' = w (commanded - tau); without it (w endless) the commanded torque acts at once.

    Attributes:
        law: that commands torques.
        bandwidth: w of the inner loop [rad/s].
    """

    bandwidth: float

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Commanded efforts (*batch, n); a session lets them pass the inner loop [N m | N]."""
        return self.law(t, q, qd, reference)

    def session(self, period: float) -> Law:
        """One run, whose inner loop begins at the first commanded efforts."""
        return _Following(self, period)


class _Following:
    """One run: the torque at the end of each period, exactly, of a first-order loop under a constant command."""

    def __init__(self, law: CurrentLoopLaw, period: float) -> None:
        self._whole, self._law = law, law.law.session(period)
        self._share = -np.expm1(-law.bandwidth * period)
        self._torque: JointVector | None = None
        self._earlier: JointVector | None = None

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        wanted = self._law(t, q, qd, reference)
        before = wanted if self._torque is None else self._torque
        torque = before + self._share * (wanted - before)
        self._earlier, self._torque = self._torque, torque
        return torque

    def go_on(self, before: _Following) -> None:
        # The state at which two runs meet is seen by both.
        self._torque = before._earlier
        take_over(self._law, before._law)

    def session(self, period: float) -> Law:
        return self._whole.session(period)


def current_loop(law: Law | LawFunction, bandwidth: float) -> CurrentLoopLaw:
    """A law whose torques pass through an inner current loop.

    Args:
        law: that commands torques; a function of (t, q, qd, reference) too.
        bandwidth: of the inner loop [rad/s]; some thousands for usual drives.

    Raises:
        InputError: a bandwidth that is not positive, or no law.

    Reference: Lynch and Park, Modern Robotics, sec. 11.1 and 8.9.
    """
    return CurrentLoopLaw(as_law(law), positive("bandwidth", bandwidth))


@dataclass(frozen=True, eq=False, slots=True)
class EncoderLoop(LawWrapper):
    """A law that measures its joints by encoders alone.

    q_k = resolution round(q / resolution),  v_k = a v_{k-1} + (1 - a) (q_k - q_{k-1}) / dt,  a = exp(-dt / filter_time)

    Attributes:
        law: that sees q_k and v_k; the first rate is zero.
        resolution: (n,) or a number, step of each encoder at the joint; zero for none [rad | m].
        filter_time: time constant of the filter of the rates [s].
    """

    resolution: Floats
    filter_time: float

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Efforts (*batch, n) at the positions that the encoders show; a session differences the rates [N m | N]."""
        return self.law(t, self.shown(q), qd, reference)

    def shown(self, q: JointVector) -> JointVector:
        """(*batch, n) the nearest step of each encoder."""
        step = np.where(self.resolution > 0.0, self.resolution, 1.0)
        return np.where(self.resolution > 0.0, step * np.round(q / step), q)

    def session(self, period: float) -> Law:
        """One run, whose rates begin at zero."""
        return _Differencing(self, period)


class _Differencing:
    """One run of a law behind encoders."""

    def __init__(self, law: EncoderLoop, period: float) -> None:
        self._whole, self._law, self._period = law, law.law.session(period), period
        self._kept = float(np.exp(-period / law.filter_time)) if law.filter_time > 0.0 else 0.0
        self._last: tuple[JointVector, JointVector] | None = None
        self._earlier: tuple[JointVector, JointVector] | None = None

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """The efforts at what the encoders show (*batch, n) [N m | N]."""
        seen = self._whole.shown(q)
        before, rate = (seen, np.zeros_like(seen)) if self._last is None else self._last
        rate = self._kept * rate + (1.0 - self._kept) * (seen - before) / self._period
        self._earlier, self._last = self._last, (seen, rate)
        return self._law(t, seen, rate, reference)

    def go_on(self, before: _Differencing) -> None:
        # The state at which two runs meet is seen by both.
        self._last = before._earlier
        take_over(self._law, before._law)

    def session(self, period: float) -> Law:
        return self._whole.session(period)


def encoder_loop(law: Law | LawFunction, resolution: ArrayLike, *, filter_time: float = 0.0) -> EncoderLoop:
    """A law whose joints have encoders and no tachometers.

    Args:
        law: any law, or a function of (t, q, qd, reference).
        resolution: step of the encoders at the joints, a number or (n,), such as 2 pi / 8192 / gear ratio; zero
            differences exact positions [rad | m].
        filter_time: time constant of a first-order filter of the rates; none if zero [s].

    Raises:
        InputError: no law, a negative or infinite number.

    Reference: Lynch and Park, Modern Robotics, sec. 11.1 and fig. 11.8.
    """
    step = real_array("resolution", resolution)
    step = as_batch("resolution", step, step.shape[-1:], finite=True)
    lag = float(single("filter_time", filter_time, ()))
    for name, value in (("resolution", float(step.min(initial=0.0))), ("filter_time", lag)):
        if not 0.0 <= value < np.inf:
            raise InputError("input.range", name=name, value=value, low=0.0, high=np.inf)
    return EncoderLoop(as_law(law), frozen(step), lag)
