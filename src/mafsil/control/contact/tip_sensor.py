"""A force and torque sensor at the tip: what an environment does to it, in the axes of a task, with noise.

Two laws and the contact that decides between them: motion in the free, force where something is touched.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np

from mafsil.arrays import Floats, JointVector, PoseMatrix, Vector3, Vector6
from mafsil.control.contact.environment import Environment, tip_wrench_of
from mafsil.control.laws.feedback import take_over
from mafsil.control.laws.law import Law
from mafsil.control.laws.task_coordinates import TaskCoordinates
from mafsil.errors import InputError
from mafsil.robot import Robot
from mafsil.trajectory import Motion

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


@dataclass(frozen=True, eq=False, slots=True)
class TipDamping:
    """tau = -J' B V: what slows the tip, along some directions or all.

    Attributes:
        robot: the model.
        coordinates: of the tip.
        damping: (m, m) B, or as a function of the pose (*batch, 4, 4) of the tip.
    """

    robot: Robot
    coordinates: TaskCoordinates
    damping: Floats | Callable[[PoseMatrix], Floats]

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]."""
        J = self.coordinates.jacobian(self.robot, q)
        B = self.damping(self.coordinates.pose(self.robot, q)) if callable(self.damping) else self.damping
        force = B @ (J @ qd[..., None])
        return -(np.swapaxes(J, -1, -2) @ force)[..., 0]

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self


@dataclass(frozen=True, eq=False, slots=True)
class ContactSwitch:
    """One law until the tip touches what it should, another one until the plan lets go.

    Attributes:
        free: the law without contact.
        touching: the law in contact; it begins with fresh memory at each contact.
        intended: whether the plan wants contact at a time [s].
        sensor: force that the tip exerts, (q, qd) -> (m,).
        direction: along which it presses at a time [s], in the axes of the last coordinates: (3,), or (2,) in a plane;
            (k, 3) of several contacts, of which all have to be there.
        least: force from which on the tip counts as touching [N].
    """

    free: Law
    touching: Law
    intended: Callable[[float], bool]
    sensor: TaskForceSensor
    direction: Callable[[float], Vector3]
    least: float

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Efforts (n,) by what is touched now; only a session remembers a contact [N m | N]."""
        return (self.touching if self.touches(t, q, qd) else self.free)(t, q, qd, reference)

    def touches(self, t: float, q: JointVector, qd: JointVector) -> bool:
        """Whether contact is wanted and there."""
        if not self.intended(t):
            return False
        along = np.asarray(self.direction(t))
        return bool((along @ self.sensor(q, qd)[-along.shape[-1] :] > self.least).all())

    def session(self, period: float) -> Law:
        """A run, which stays in contact until the plan lets go."""
        return _Switching(self, period)


class _Switching:
    """One run: which of the laws acts."""

    def __init__(self, law: ContactSwitch, period: float) -> None:
        self._law, self._period = law, period
        self._free = law.free.session(period)
        self._touching: Law | None = None

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        if self._touching is None and self._law.touches(t, q, qd):
            self._touching = self._law.touching.session(self._period)
        elif self._touching is not None and not self._law.intended(t):
            self._touching, self._free = None, self._law.free.session(self._period)
        return (self._touching or self._free)(t, q, qd, reference)

    def go_on(self, before: _Switching) -> None:
        take_over(self._free, before._free)
        if before._touching is not None:
            self._touching = self._law.touching.session(self._period)
            take_over(self._touching, before._touching)

    def session(self, period: float) -> Law:
        return self._law.session(period)
