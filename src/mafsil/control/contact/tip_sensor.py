"""Force and torque at the tip: their sensor, and what is learned and decided by what it feels.

A sensor measures what an environment does to the tip, in the axes of a task, with noise. By force a tip learns which
directions are blocked and which efforts a known contact takes; a switch goes from motion in the free to force in touch.
"""

from __future__ import annotations

from collections.abc import Callable, Generator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, PoseMatrix, Vector3, Vector6, real_array, require_finite, require_kind
from mafsil.control.contact.environment import Environment, tip_wrench_of
from mafsil.control.laws.feedback import take_over
from mafsil.control.laws.law import Law
from mafsil.control.laws.task_coordinates import TaskCoordinates
from mafsil.errors import InputError
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion

SPARE = 4.0
"""Added to sqrt(k) + sqrt(m), above which noise alone gets with a probability below exp(-8)."""
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


class EstimatedConstraintStatus(Status):
    """Whether any direction is blocked."""

    BLOCKED = ("control.felt_blocked", True)
    NOTHING = ("control.felt_nothing", False)


@dataclass(frozen=True, eq=False, repr=False)
class EstimatedConstraint(Answer, data="A sizes samples"):
    """The directions along which forces were felt; true if there are some.

    Attributes:
        status: BLOCKED or NOTHING.
        A: (r, m) rows of unit length that span the forces that were felt: A V = 0 for what moves without friction.
        sizes: (m,) decreasing: how far the forces stand out along each principal direction, as share of what noise
            alone could do.
        samples: how many forces were seen.
    """

    status: EstimatedConstraintStatus
    A: Floats
    sizes: Floats
    samples: int

    def explain(self, language: str | None = None) -> str:
        """How many directions, and how clearly."""
        r = len(self.A)
        clear = float(self.sizes[r - 1]) if r else float(self.sizes[0])
        return self.status.sentence(language, count=r, of=len(self.sizes), clear=clear, samples=self.samples)


def estimate_contact_constraint(forces: ArrayLike, noise: ArrayLike) -> EstimatedConstraint:
    """The blocked directions of a contact without friction, from forces that a sensor measured.

    Algorithm:
        1. Forces are divided by the noise of their components, so that newtons and newton metres compare.
        2. The singular values of all of them are held against what noise alone gives, sqrt(k) + sqrt(m) and a margin.
        3. The directions above are what the environment pushes along. One that was never pressed is not found.

    Args:
        forces: (k, m) measured, k samples along a motion, without the weight of the tool.
        noise: standard deviations, a number or (m,), above zero.

    Raises:
        InputError: a wrong shape, a number that is not finite, noise that is not positive.

    Reference: Davidson and Silverstein, Local operator theory, random matrices and Banach spaces, 2001, th. II.13, for
        the bound; Bruyninckx and De Schutter, IEEE Trans. Robotics and Automation 12(4), 1996, for the task.
    """
    given = require_finite("forces", real_array("forces", forces))
    if given.ndim != 2 or not given.size:
        raise InputError("input.shape", name="forces", expected="(k, m)", got=given.shape, hint="")
    k, m = given.shape
    spread = require_finite("noise", real_array("noise", noise))
    if spread.shape not in ((), (m,)):
        raise InputError("input.shape", name="noise", expected=(m,), got=spread.shape, hint="")
    if not (spread > 0.0).all():
        raise InputError("input.positive", name="noise", value=float(spread.min()))
    # 1
    _, values, rows = np.linalg.svd(given / spread, full_matrices=False)
    # 2
    sizes = np.zeros(m)
    sizes[: len(values)] = values / (np.sqrt(k) + np.sqrt(m) + SPARE)
    # 3
    A = rows[: int((sizes > 1.0).sum())] * spread
    A = A / np.linalg.norm(A, axis=1, keepdims=True)
    return EstimatedConstraint(
        EstimatedConstraintStatus.BLOCKED if len(A) else EstimatedConstraintStatus.NOTHING, A, sizes, k
    )


@dataclass(frozen=True, eq=False, slots=True)
class ContactFeedforward:
    """tau = M(u) a + c(u, v) + g(u) - J(u)' F(u, v): the efforts of the reference, what it touches included.

    Attributes:
        robot: the model.
        environment: the model of what the tip touches.
    """

    robot: Robot
    environment: Environment

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]."""
        u, v, a = reference
        wrench = tip_wrench_of(self.robot, self.environment, u, v)
        return self.robot.inverse_dynamics(u, v, a, -wrench) + 0.0 * q

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self


@of_robot
def contact_feedforward(robot: Robot, environment: Environment) -> ContactFeedforward:
    """The efforts that a model of arm and environment needs for a reference; combine it with feedback.

    Args:
        robot: the model.
        environment: what the tip touches, such as a `Wall` or a `SpringDamper`.

    Reference: Lynch and Park, Modern Robotics, sec. 11.4.1.
    """
    require_kind("environment", environment, "Environment", "wrench")
    return ContactFeedforward(robot, environment)
