"""A force and torque sensor at the tip: what an environment does to it, in the axes of a task, with noise."""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from contextvars import ContextVar
from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats, JointVector, Vector6
from mafsil.control.contact.environment import Environment, tip_wrench_of
from mafsil.control.laws.task_coordinates import TaskCoordinates
from mafsil.errors import InputError
from mafsil.robot import Robot

TaskForceSensor: TypeAlias = Callable[[JointVector, JointVector], Floats]
"""(q, qd) -> (m,) force at the tip, in the coordinates of the task; of a `TipForceSensor` that which the tip exerts."""

_MEASURING: ContextVar[Callable[[], Vector6] | None] = ContextVar("measuring", default=None)
"""What the run that goes on measures at its tip."""


_PUSHED: ContextVar[Callable[[], Vector6 | None] | None] = ContextVar("pushed", default=None)
"""How the run that goes on pushes its tip."""


@contextmanager
def pushed_by(read: Callable[[], Vector6 | None]) -> Generator[None, None, None]:
    """Let sensors feel the pushes of a run beside what the tip touches.

    Args:
        read: the wrench (6,) of the pushes on the tip now, in the tip frame [N m, N]; None without any.
    """
    token = _PUSHED.set(read)
    try:
        yield
    finally:
        _PUSHED.reset(token)


@contextmanager
def measured_by(read: Callable[[], Vector6]) -> Generator[None, None, None]:
    """Let sensors without an environment read what a run measures.

    Args:
        read: the wrench (6,) of the world on the tip now, in the tip frame [N m, N].
    """
    token = _MEASURING.set(read)
    try:
        yield
    finally:
        _MEASURING.reset(token)


class TipForceSensor:
    """(q, qd) -> (m,) force that the tip exerts on the world, in the axes of {s}.

    Several readings of one measured state are the same; noise is reproducible by the seed. The force of what gives way
    follows from the state. That of rigid surfaces follows from the efforts too: there a run measures it, at each tick
    under the efforts that have acted until then; the first reading is zero. Pushes of a run are felt as well.

    Args:
        robot: the true arm.
        environment: what its tip touches; None for what the run of a `RigidPlant` measures.
        coordinates: of the task, decoupled ones.
        noise: standard deviation of forces [N]; of moments a tenth of it [N m].
        seed: of the noise.
    """

    def __init__(
        self,
        robot: Robot,
        environment: Environment | None,
        coordinates: TaskCoordinates,
        noise: float = 0.0,
        seed: int = 0,
    ) -> None:
        self._robot, self._environment, self._coordinates = robot, environment, coordinates
        self._noise, self._random = noise, np.random.default_rng(seed)
        self._state: JointVector | None = None
        self._reading: Floats = np.zeros(0)

    def __call__(self, q: JointVector, qd: JointVector) -> Floats:
        """The reading (*batch, m) [N m, N].

        Raises:
            InputError: a sensor without an environment, and no run that measures.
        """
        if q is self._state:
            return self._reading
        pushed = _PUSHED.get()
        push = None if pushed is None else pushed()
        wrench = self._wrench(q, qd) if push is None else self._wrench(q, qd) + push
        R = self._coordinates.pose(self._robot, q)[..., :3, :3]
        halves = [(R @ part[..., None])[..., 0] for part in (wrench[..., :3], wrench[..., 3:])]
        exerted: Floats = -np.concatenate(halves, axis=-1)
        if self._noise:
            exerted = exerted + self._noise * np.repeat([0.1, 1.0], 3) * self._random.standard_normal(exerted.shape)
        self._state, self._reading = q, exerted[..., list(self._coordinates.rows)]
        return self._reading

    def outside(self, q: JointVector, qd: JointVector) -> Floats:
        """What the world exerts on the tip: the same reading (*batch, m) with the other sign [N m, N]."""
        return -self(q, qd)

    def _wrench(self, q: JointVector, qd: JointVector) -> Vector6:
        """(*batch, 6) on the tip, in the tip frame."""
        if self._environment is not None:
            return tip_wrench_of(self._robot, self._environment, q, qd)
        read = _MEASURING.get()
        if read is None:
            raise InputError("control.nothing_measured")
        return read()


def from_outside(sensor: TaskForceSensor) -> TaskForceSensor:
    """(q, qd) -> (m,) force of the world on the tip.

    Args:
        sensor: a `TipForceSensor`, which says what the tip exerts; or a function of that force itself.
    """
    return sensor.outside if isinstance(sensor, TipForceSensor) else sensor
