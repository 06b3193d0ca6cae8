"""Encoders between an arm and its law: positions in steps, and rates that are differenced from them and filtered."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, as_batch, frozen, real_array, single
from mafsil.control.laws.feedback import take_over
from mafsil.control.laws.law import Law, LawFunction, LawWrapper, as_law
from mafsil.errors import InputError
from mafsil.trajectory import Motion


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
