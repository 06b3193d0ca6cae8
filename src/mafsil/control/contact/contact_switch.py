"""Two laws and the contact that decides between them: motion in the free, force where something is touched."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from mafsil.arrays import Floats, JointVector, PoseMatrix, Vector3
from mafsil.control.contact.tip_sensor import TaskForceSensor
from mafsil.control.laws.law import Law
from mafsil.control.laws.law_memory import take_over
from mafsil.control.laws.task_coordinates import TaskCoordinates
from mafsil.robot import Robot
from mafsil.trajectory import Motion


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
