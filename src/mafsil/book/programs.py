"""The programs of figures 10.8, 10.9 and 10.13, as they are printed in the figures and run there."""

from __future__ import annotations

from collections.abc import Callable
from inspect import getsource
from textwrap import dedent

import numpy as np

from mafsil.arrays import Floats
from mafsil.one_joint import JointArm

Reference = Callable[[float], tuple[float, float, float]]
Sense = Callable[[], float]
Command = Callable[[float], None]


def pid_loop(sense: Sense, command: Command, reference: Reference, K: Floats, dt: float, ticks: int) -> None:
    """PID: difference, integral before its use, torque."""
    q_last, integral = sense(), 0.0
    for k in range(ticks):
        q_d, qd_d, _ = reference(k * dt)
        q = sense()
        qd = (q - q_last) / dt
        e, ed = q_d - q, qd_d - qd
        integral = integral + e * dt
        command(float(K @ [e, integral, ed]))
        q_last = q


def feedforward_loop(command: Command, reference: Reference, model: JointArm, dt: float, ticks: int) -> None:
    """Feedforward: nothing is measured."""
    for k in range(ticks):
        q_d, qd_d, qdd_d = reference(k * dt)
        command(float(model.torque(q_d, qd_d, qdd_d)))


def computed_torque_loop(
    sense: Sense, command: Command, reference: Reference, model: JointArm, K: Floats, dt: float, ticks: int
) -> None:
    """Computed torque: PID gives an acceleration, the model the torque."""
    q_last, integral = sense(), 0.0
    for k in range(ticks):
        q_d, qd_d, qdd_d = reference(k * dt)
        q = sense()
        qd = (q - q_last) / dt
        e, ed = q_d - q, qd_d - qd
        integral = integral + e * dt
        command(float(model.torque(q, qd, qdd_d + K @ [e, integral, ed])))
        q_last = q


def listing(program: Callable[..., None]) -> str:
    """The lines of a program without types and description."""
    lines = dedent(getsource(program)).split("\n")
    first = next(k for k, line in enumerate(lines) if line.strip().startswith('"""'))
    return "\n".join(line[4:] for line in lines[first + 1 :]).rstrip()


class Bench:
    """A one-joint arm that a program senses and drives: a torque is kept for a period.

    Args:
        arm: the arm that is really there, with viscous friction.
        theta: where it starts at rest [rad].
        dt: period of the program [s].
    """

    def __init__(self, arm: JointArm, theta: float, dt: float) -> None:
        self.arm, self.dt = arm, dt
        self.states = [np.array([theta, 0.0])]

    @property
    def theta(self) -> Floats:
        """(ticks + 1,) angles at the periods [rad]."""
        return np.array(self.states)[:, 0]

    def sense(self) -> float:
        """The angle now [rad]."""
        return float(self.states[-1][0])

    def command(self, torque: float) -> None:
        """Drive with a torque for a period [N m]."""
        x, h = self.states[-1], self.dt / 10
        for _ in range(10):
            k1 = self._rate(x, torque)
            k2 = self._rate(x + h / 2 * k1, torque)
            k3 = self._rate(x + h / 2 * k2, torque)
            x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + self._rate(x + h * k3, torque))
        self.states.append(x)

    def _rate(self, x: Floats, torque: float) -> Floats:
        return np.array([x[1], float(self.arm.acceleration(x[0], x[1], torque))])
