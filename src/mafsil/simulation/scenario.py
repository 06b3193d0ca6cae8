"""A run as data: plant, reference, law, start, disturbances, clocks."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, JointVector, as_batch, positive, real_array, require_finite, require_kind
from mafsil.control import as_law
from mafsil.errors import InputError, InputWarning, warn
from mafsil.kernels.lazy import lazy
from mafsil.lazy_module import lazily
from mafsil.robot import as_open_tree
from mafsil.robot.degrees import remark_on_degrees
from mafsil.simulation.closed_plant import ClosedPlant, plant_of
from mafsil.simulation.plant import Plant
from mafsil.simulation.rigid_plant import RigidPlant
from mafsil.simulation.stepping import (
    DEFAULT,
    IMPLICIT_FRICTION,
    STIFF,
    Stepper,
    friction_stiffness,
    require_integrator,
)
from mafsil.simulation.tolerances import PART_OF_STEP, PERIOD
from mafsil.simulation.variation import SensorNoise, WrenchPulse

if TYPE_CHECKING:
    import mafsil.simulation.scaled_gains as scaled_gains
else:
    scaled_gains = lazily("mafsil.simulation.scaled_gains")

if TYPE_CHECKING:
    from mafsil.control import Law
    from mafsil.robot import Robot
    from mafsil.simulation.variation import Variants
    from mafsil.trajectory import Trajectory

MOST_NUMBERS = 400_000_000
"""Memory of one run, in numbers of eight bytes: what is recorded, and the reference at each tick."""
RIGID = "rk4"
"""Integrator of plants that meet a rigid surface."""
PLACES = 9
"""Places along the reference at which the stiffness of friction is looked at."""
NUMBERS_PER_TICK, NUMBERS_PER_COORDINATE = 60, 16


@dataclass(frozen=True, eq=False, kw_only=True)
class Scenario:
    """Everything that decides a run; equal scenarios give equal recordings.

    Attributes:
        robot: the arm as its model knows it.
        trajectory: the reference, of robot.n coordinates.
        law: the controller; a plain function of (t, q, qd, reference) becomes a law (`mafsil.control.as_law`).
        plant: the true arm; the robot itself, with its friction and its loops, if None.
        q, qd: (*batch, n) initial state; the start of the trajectory, at its velocity, if None [rad | m], [.../s].
        disturbances: pushes at the tip.
        noise: of the sensors, or None.
        duration: of the run; that of the trajectory if None [s].
        step: of the integration [s].
        period: between two calls of the law, a whole number of steps; one step if None [s].
        integrator: a name of `mafsil.simulation.INTEGRATORS`. If None, semi-implicit Euler; where the friction of light
            links is too stiff for the step, the same with implicit friction; a `RigidPlant` takes rk4 instead of the
            first.
        saturate: whether efforts are clipped at the limits of the joints.
        variants: what differs between runs side by side, one row each, or None; see `monte_carlo`.

    Raises:
        InputError: a wrong shape, a number that is not finite or not positive, an unknown integrator, a period that is
            not a whole number of steps, a trajectory of another width.
    """

    robot: Robot
    trajectory: Trajectory
    law: Law
    plant: Plant | None = None
    q: ArrayLike | None = None
    qd: ArrayLike | None = None
    disturbances: tuple[WrenchPulse, ...] = ()
    noise: SensorNoise | None = None
    duration: float | None = None
    step: float = 1e-3
    period: float | None = None
    integrator: str | None = None
    saturate: bool = True
    variants: Variants | None = None

    def __post_init__(self) -> None:
        object.__setattr__(self, "robot", as_open_tree(self.robot))
        require_kind("trajectory", self.trajectory, "Trajectory", "n", "duration", "at")
        object.__setattr__(self, "law", as_law(self.law))
        self._require_own_law()
        require_kind("plant", self.true_plant, "Plant", "acceleration")
        if self.noise is not None:
            require_kind("noise", self.noise, "SensorNoise", "drawn")
        require_kind("disturbances", self.disturbances, "tuple", "__len__", "__iter__")
        for push in self.disturbances:
            require_kind("disturbances", push, "WrenchPulse", "push", "duration")
        if self.trajectory.n != self.robot.n:
            details = {"expected": f"n = {self.robot.n}", "got": f"n = {self.trajectory.n}", "hint": ""}
            raise InputError("input.shape", name="trajectory", **details)
        for name in ("step", "period", "duration"):
            value = getattr(self, name)
            if value is not None or name == "step":
                positive(name, value)
        if self.integrator is not None:
            require_integrator(self.integrator)
        if abs(self.substeps * self.step - self.control_period) > PERIOD * self.control_period:
            raise InputError("simulation.period", period=self.control_period, step=self.step)
        if self.variants is not None and self.true_plant.environment is not None and not self._asks_once:
            raise InputError("simulation.varied_environment", integrator=self.chosen_integrator)
        size = max(real_array("q", x).size for x in (self.q, self.qd, np.zeros(self.robot.n)) if x is not None)
        ticks = max(self.ends_at / self.control_period, 1.0)
        if ticks * (NUMBERS_PER_TICK + NUMBERS_PER_COORDINATE * size) > MOST_NUMBERS:
            limit = MOST_NUMBERS / (NUMBERS_PER_TICK + NUMBERS_PER_COORDINATE * size)
            details = {"duration": self.ends_at, "ticks": ticks, "limit": limit}
            raise InputError("simulation.too_long", **details, period=self.control_period)
        start = self.start()[0]
        plant = self.true_plant
        if isinstance(plant, ClosedPlant):
            if self.variants is not None and plant.chain.holding(start) is None:
                raise InputError("simulation.varied_loops")
            plant.require_closed(start)
        if isinstance(plant, RigidPlant):
            if self.variants is not None:
                raise InputError("simulation.varied_rigid")
            plant.require_outside(start)

    @property
    def ends_at(self) -> float:
        """Time at which the run ends [s]."""
        return self.trajectory.duration if self.duration is None else self.duration

    @property
    def acting_law(self) -> Law:
        """The law with the gains of each run."""
        if self.variants is None:
            return self.law
        if self.variants.gains is None:
            return scaled_gains.in_rows(self.law, self.variants.count)
        return scaled_gains.with_scaled_gains(self.law, self.variants.gains)

    @property
    def true_plant(self) -> Plant:
        """The plant that moves."""
        return self.plant or plant_of(self.robot)

    @property
    def control_period(self) -> float:
        """Time between two calls of the law [s]."""
        return self.step if self.period is None else self.period

    @property
    def substeps(self) -> int:
        """Integration steps per control period."""
        return max(1, round(self.control_period / self.step))

    @lazy
    def stiffness(self) -> float:
        """Step times the fastest decay by friction along the reference; explicit methods need less than two."""
        plant = self.true_plant
        if not plant.has_friction:
            return 0.0
        u = self.trajectory.at(np.linspace(0.0, self.ends_at, PLACES)).u.reshape(-1, self.robot.n)
        q = self._initial[0].reshape(-1, self.robot.n)
        places = np.concatenate([u[:: max(1, len(u) // PLACES)], q[:: max(1, len(q) // PLACES)]])
        return self.step * friction_stiffness(plant, places) * self._stiffer()

    def _stiffer(self) -> float:
        """How much faster friction may decay in a variant than in the plant, at most."""
        if self.variants is None:
            return 1.0
        most = 1.0 if self.variants.friction is None else float(self.variants.friction.max(initial=1.0))
        least = 1.0 if self.variants.inertia is None else float(self.variants.inertia.min(initial=1.0))
        return most / least

    @property
    def _asks_once(self) -> bool:
        """Whether forces are asked for once a step."""
        stepper = Stepper(self.true_plant, self.chosen_integrator, self.step)
        return stepper.name == IMPLICIT_FRICTION or stepper.evaluations() == 1

    @property
    def chosen_integrator(self) -> str:
        """The integrator that the run uses."""
        if self.integrator is not None:
            return self.integrator
        default = RIGID if isinstance(self.true_plant, RigidPlant) else DEFAULT
        return IMPLICIT_FRICTION if self.stiffness > STIFF else default

    def ticks(self) -> Floats:
        """(k + 1,) times at which the law is called, the first 0, the last at or just after the end [s]."""
        return np.arange(ceil(self.ends_at / self.control_period - PART_OF_STEP) + 1.0) * self.control_period

    def start(self) -> tuple[JointVector, JointVector]:
        """Initial positions and rates, (*batch, n)."""
        q, qd = self._initial
        return q.copy(), qd.copy()

    def _require_own_law(self) -> None:
        """Refuse a law of a robot, or of gains, with another number of joints; laws of closed chains have motors."""
        if self.robot.mechanism.loops:
            return
        law: Any = self.law
        gains = np.shape(law.gains.kp) if hasattr(law, "gains") else ()
        n = law.robot.n if hasattr(law, "robot") else gains[-1] if gains else self.robot.n
        if n != self.robot.n:
            raise InputError("input.shape", name="law", expected=f"n = {self.robot.n}", got=f"n = {n}", hint="")

    def _remark_on_friction(self) -> None:
        """Warn of friction in joints that close loops, which the plant leaves out."""
        loops = [joint.name for joint in self.true_plant.robot.mechanism.loops if joint.friction is not None]
        if loops and self.true_plant.friction:
            warn(InputWarning("simulation.loop_friction", joints=", ".join(loops)))

    def _remark_on_start(self, q: JointVector) -> None:
        """Warn of a start in degrees, or beyond the joint limits."""
        remark_on_degrees(self.robot, "q", q.tolist())
        limits = self.robot.limits
        outside = ~limits.within(q)
        if outside.any():
            joint = int(np.argwhere(outside)[0][-1])
            names = {"joint": self.robot.joint_names[joint], "value": float(q[outside][0])}
            bounds = {"lower": float(limits.lower[joint]), "upper": float(limits.upper[joint])}
            warn(InputWarning("simulation.start_beyond", **names, **bounds))

    @lazy
    def _initial(self) -> tuple[JointVector, JointVector]:
        if self.q is None or self.qd is None:
            reference = self.trajectory.at(0.0)
            given = [reference.u if self.q is None else self.q, reference.v if self.qd is None else self.qd]
        else:
            given = [self.q, self.qd]
        q, qd = (
            require_finite(name, as_batch(name, x, (self.robot.n,))) for name, x in zip(("q", "qd"), given, strict=True)
        )
        self._remark_on_start(q)
        self._remark_on_friction()
        shape = np.broadcast_shapes(q.shape, qd.shape)
        if self.variants is not None:
            shape = (self.variants.count, self.robot.n)
            if q.shape[:-1] not in ((), shape[:1]) or qd.shape[:-1] not in ((), shape[:1]):
                raise InputError("input.shape", name="q", expected=shape, got=q.shape, hint="")
            if self.variants.start is not None:
                q = q + self.variants.start
                if isinstance(self.true_plant, ClosedPlant):
                    q, qd = self.true_plant.closed_start(q, np.broadcast_to(qd, shape))
        return np.broadcast_to(q, shape), np.broadcast_to(qd, shape)
