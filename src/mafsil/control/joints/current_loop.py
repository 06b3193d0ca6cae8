"""The inner loop of a drive: amplifier and motor follow the commanded torque with a bandwidth, not at once."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import JointVector, positive
from mafsil.control.laws.feedback import take_over
from mafsil.control.laws.law import Law, LawFunction, LawWrapper, as_law
from mafsil.trajectory import Motion


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
