"""The loops of the pseudo-code for joints that are really there: readings in, torques out, once a period."""

from __future__ import annotations

from collections.abc import Callable
from math import exp
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, require_finite, require_function, require_kind, whole
from mafsil.errors import InputError
from mafsil.one_joint.arguments import above_zero, finite, magnitude

Bias = Callable[[Floats, Floats], ArrayLike]
"""h(theta, theta'): torques (n,) besides acceleration."""
Inertia = Callable[[Floats], ArrayLike]
"""M(theta): (n, n), or (n,) if it is diagonal."""


class Desired(NamedTuple):
    """The reference at one time, each (n,) or a number."""

    theta: ArrayLike
    speed: ArrayLike = 0.0
    acceleration: ArrayLike = 0.0


class DiscreteLoop:
    """Feedback, feedforward or computed torque of n joints, in the order of the book's pseudo-code.

    Sense, difference (zero at the first reading), filter, update the integral, then use it. Units of the gains are
    those of the torque, for computed torque those of the acceleration.
    """

    def __init__(
        self,
        period: float,
        kp: ArrayLike = 0.0,
        ki: ArrayLike = 0.0,
        kd: ArrayLike = 0.0,
        *,
        inertia: Inertia | None = None,
        bias: Bias | None = None,
        feedforward: bool = False,
        filter_time: float = 0.0,
    ) -> None:
        """A loop at rest.

        Args:
            period: of the loop [s].
            kp, ki, kd: a number or (n,).
            inertia, bias: the model, both or none. With a model the loop is computed torque.
            feedforward: evaluate the model at what is wanted instead, and add the feedback as torque.
            filter_time: time constant of the filter on the differences [s].

        Raises:
            InputError: a negative gain, half a model, feedforward without a model.
        """
        self.period = float(above_zero("period", period))
        self.gains = tuple(magnitude(name, value) for name, value in (("kp", kp), ("ki", ki), ("kd", kd)))
        if (inertia is None) != (bias is None) or (feedforward and inertia is None):
            raise InputError("one_joint.half_a_model")
        if inertia is not None and bias is not None:
            require_function("inertia", inertia, "function M(theta)", 1)
            require_function("bias", bias, "function h(theta, theta')", 2)
        self.model = None if inertia is None or bias is None else (inertia, bias)
        self.feedforward = feedforward
        lag = float(magnitude("filter_time", filter_time))
        self.keep = exp(-self.period / lag) if lag else 0.0
        self.integral: Floats | float = 0.0
        self.speed: Floats | float = 0.0
        self._last: Floats | None = None

    def reset(self) -> None:
        """Forget readings and integral."""
        self.integral, self.speed, self._last = 0.0, 0.0, None

    def update(self, reading: ArrayLike, desired: Desired) -> Floats:
        """Torques (n,) for a reading of the positions (n,).

        Raises:
            InputError: a reading that is not finite or of another shape than the last one: nothing is remembered of it.
        """
        theta = finite("reading", reading)
        if self._last is not None and theta.shape != self._last.shape:
            raise InputError("input.shape", name="reading", expected=self._last.shape, got=theta.shape, hint="")
        require_kind("desired", desired, "Desired", "__len__", "__getitem__")
        if len(desired) != 3:
            raise InputError("input.shape", name="desired", expected=(3,), got=(len(desired),), hint="")
        u, v, a = (finite(f"desired[{k}]", part) for k, part in enumerate(desired))
        kp, ki, kd = self.gains
        # 1. Differences of the readings, filtered; zero at the first.
        if self._last is not None:
            self.speed = self.keep * self.speed + (1.0 - self.keep) * (theta - self._last) / self.period
        self._last = theta.copy()
        # 2. The integral, updated before it is used.
        e = u - theta
        self.integral = self.integral + e * self.period
        feedback = kp * e + ki * self.integral + kd * (v - self.speed)
        # 3. Torque.
        if self.model is None:
            return np.asarray(feedback)
        if self.feedforward:
            still = np.zeros_like(theta)
            return feedback + self._model(u + still, v + still, a + still)
        return self._model(theta, np.asarray(self.speed + np.zeros_like(theta)), a + feedback)

    def _model(self, theta: Floats, speed: Floats, acceleration: Floats) -> Floats:
        assert self.model is not None
        M, h = (np.asarray(each, dtype=np.float64) for each in (self.model[0](theta), self.model[1](theta, speed)))
        product = M @ acceleration if M.ndim == 2 else M * acceleration
        return require_finite("model", product + h)


def run_loop(
    loop: DiscreteLoop,
    sense: Callable[[], ArrayLike],
    command: Callable[[Floats], object],
    desired: Callable[[float], Desired],
    ticks: int,
) -> None:
    """Sense, update, command, `ticks` times; waiting for the next period is up to `command` or `sense`.

    Args:
        loop: the law with its memory.
        sense: gives the positions (n,) [rad | m].
        command: takes the torques (n,) [N m | N].
        desired: of time [s].
        ticks: how many.

    Raises:
        InputError: a callback that cannot be called so, or a reading that is not finite: no torque follows it.
    """
    require_kind("loop", loop, "DiscreteLoop", "update", "period")
    for name, function, count in (("sense", sense, 0), ("command", command, 1), ("desired", desired, 1)):
        require_function(name, function, f"function of {count} arguments", count)
    for k in range(whole("ticks", ticks)):
        command(loop.update(sense(), desired(k * loop.period)))
