"""A robot under efforts and wrenches over time as a first-order system, in rates or in momenta.

What acts over time: nothing, a constant, a function of time or state, or samples that are held or joined.
"""

from __future__ import annotations

import inspect
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from math import isfinite
from typing import TYPE_CHECKING, Any, TypeAlias, cast

import numpy as np
from numpy.typing import ArrayLike

from mafsil import kernels
from mafsil.arrays import (
    Floats,
    JointVector,
    as_batch,
    frozen,
    positive,
    real_array,
    require_finite,
    require_function,
    single,
)
from mafsil.errors import InputError
from mafsil.floating_point import EPS
from mafsil.kernels import Kernel, Port, Signature
from mafsil.lazy_module import lazily
from mafsil.model import Mechanism
from mafsil.model.fingerprint import fingerprint
from mafsil.robot import Robot

if TYPE_CHECKING:
    import mafsil.mechanics.hamiltonian as hamiltonian
else:
    hamiltonian = lazily("mafsil.mechanics.hamiltonian")


Source: TypeAlias = "ArrayLike | Sampled | Callable[..., ArrayLike] | None"
"""None, an array, `Sampled`, f(t) or f(t, q, qd)."""
Signal: TypeAlias = Callable[[float, JointVector, JointVector], Floats]
"""Value at a time and state."""
ROUNDING = 8 * EPS
"""Relative error of a time that is still the time of a sample; less than `solvers.adaptive.EDGE`."""
Rates: TypeAlias = Callable[[float, Floats], Floats]


class DrivenRobot:
    """Joint efforts, friction and tip wrench over time acting on a robot.

    Args:
        robot: the arm.
        tau: efforts of the motors, or None.
        tip_wrench: what the tip exerts on the world, or None.
        friction: whether the joints' friction acts.
    """

    def __init__(self, robot: Robot, tau: Signal | None, tip_wrench: Signal | None, friction: bool) -> None:
        self.robot, self.n = robot, robot.n
        self._tau, self._wrench, self._none = tau, tip_wrench, np.zeros(robot.n)
        self._friction = friction and any(j.moves and j.friction is not None for j in robot.mechanism.joints)

    @property
    def unloaded(self) -> bool:
        """Whether nothing but gravity acts."""
        return self._tau is None and self._wrench is None and not self._friction

    def motor_efforts(self, t: float, q: JointVector, qd: JointVector) -> JointVector:
        """Tau (*batch, n)."""
        return np.zeros_like(q) if self._tau is None else spread("tau", self._tau(t, q, qd), q.shape)

    def tip_wrench(self, t: float, q: JointVector, qd: JointVector) -> Floats | None:
        """(*batch, 6) the tip exerts on the world, or None."""
        return None if self._wrench is None else spread("tip_wrench", self._wrench(t, q, qd), (*q.shape[:-1], 6))

    def batch(self, q: JointVector, qd: JointVector) -> tuple[int, ...]:
        """Batch shape of states (*batch, n) together with the efforts and wrenches that act at time zero."""
        shape = q.shape[:-1]
        for name, source in (("tau", self._tau), ("tip_wrench", self._wrench)):
            if source is not None:
                given = source(0.0, q, qd).shape
                shape = common_shape(name, given[:-1], shape)
        return shape

    def load(self, t: float, q: JointVector, qd: JointVector) -> JointVector:
        """Generalized forces (*batch, n) besides gravity: motors, friction, tip wrench."""
        load = self._joint_load(t, q, qd)
        wrench = self.tip_wrench(t, q, qd)
        if wrench is None:
            return load
        J = self.robot.jacobian_body(q)
        return load - np.einsum("...ji,...j->...i", J, wrench)

    def acceleration(self, t: float, q: JointVector, qd: JointVector) -> JointVector:
        """Qdd (*batch, n); NaN where the state is not finite."""
        if q.ndim == 1 and not isfinite(q.dot(q) + qd.dot(qd)):
            return np.full_like(q, np.nan)
        if self.unloaded:
            return self.robot.forward_dynamics(q, qd, self._none)
        load, wrench = self._joint_load(t, q, qd), self.tip_wrench(t, q, qd)
        if q.ndim == 1 and not isfinite(load.dot(load)):
            return np.full_like(q, np.nan)
        if wrench is None:
            return self.robot.forward_dynamics(q, qd, load)
        return self.robot.forward_dynamics(q, qd, load, wrench)

    def _joint_load(self, t: float, q: JointVector, qd: JointVector) -> JointVector:
        load = self.motor_efforts(t, q, qd)
        return load - self.robot.friction_torque(qd) if self._friction else load

    def rates(self, t: float, y: Floats) -> Floats:
        """Derivative (*batch, 2 n) of y = (q, qd)."""
        q, qd = y[..., : self.n], y[..., self.n :]
        return np.concatenate([qd, self.acceleration(t, q, qd)], axis=-1)

    def momentum_rates(self, t: float, y: Floats) -> Floats:
        """Derivative (*batch, 2 n) of y = (q, p), p = M qd: Hamilton's equations."""
        n = self.n
        q, p = np.ascontiguousarray(y[..., :n]), np.ascontiguousarray(y[..., n:])
        if y.ndim == 1 and not isfinite(y.dot(y)):
            return np.full_like(y, np.nan)
        slope = hamiltonian_kernel(self.robot.mechanism)(q, p)
        if self.unloaded:
            return slope
        return slope + np.concatenate([0.0 * q, self.load(t, q, slope[..., :n])], axis=-1)

    def momentum(self, q: JointVector, qd: JointVector) -> JointVector:
        """P (*batch, n) = M qd."""
        return (self.robot.mass_matrix(q) @ qd[..., None])[..., 0]

    def rate_of(self, q: JointVector, p: JointVector) -> JointVector:
        """Qd (*batch, n) = M^-1 p."""
        return np.asarray(np.linalg.solve(self.robot.mass_matrix(q), p[..., None])[..., 0], dtype=np.float64)


def common_shape(name: str, given: tuple[int, ...], shape: tuple[int, ...]) -> tuple[int, ...]:
    """Batch shape of both.

    Raises:
        InputError: they do not broadcast.
    """
    try:
        return np.broadcast_shapes(given, shape)
    except ValueError:
        details = {"expected": (*shape, "..."), "got": (*given, "...")}
        raise InputError("input.shape", name=name, **details, hint="") from None


def spread(name: str, value: Floats, shape: tuple[int, ...]) -> Floats:
    """A value for each state of the batch."""
    if value.shape == shape:
        return value
    try:
        return np.broadcast_to(value, shape)
    except ValueError:
        raise InputError("input.shape", name=name, expected=shape, got=value.shape, hint="") from None


BUILDERS = {"hamiltonian_field": "function", "variational_step": "discrete_function"}
"""Functions of `mechanics.hamiltonian` that make the kernels; their names are part of the keys in the store."""


@lru_cache(maxsize=64)
def hamiltonian_kernel(mechanism: Mechanism) -> Kernel:
    """(q, p) to (qd, pd), 2 n numbers, without outside efforts."""
    n = mechanism.n
    return _compile("hamiltonian_field", mechanism, (Port("q", (n,)), Port("p", (n,))), 2 * n, hamiltonian_kernel)


@lru_cache(maxsize=64)
def variational_kernel(mechanism: Mechanism) -> Kernel:
    """(q0, p0, v, load, h) to 3 n numbers; see `mechanics.hamiltonian.discrete_function`."""
    n = mechanism.n
    inputs = (*(Port(name, (n,)) for name in ("q0", "p0", "v", "load")), Port("h"))
    return _compile("variational_step", mechanism, inputs, 3 * n, variational_kernel)


def _compile(name: str, mechanism: Mechanism, inputs: tuple[Port, ...], size: int, recipe: Any) -> Kernel:
    return kernels.compile(
        Signature(name, inputs, (Port(name, (size,)),)),
        partial(_build, name, mechanism),
        key=f"{fingerprint(mechanism)} {BUILDERS[name]}",
        fingerprints=(kernels.fingerprint("mafsil.algebra", "mafsil.mechanics"),),
        recipe=(recipe, (mechanism,)),
    )


def _build(name: str, mechanism: Mechanism) -> Any:
    """The function; its expressions are loaded only when a kernel has to be made."""
    return getattr(hamiltonian, BUILDERS[name])(mechanism)


@dataclass(frozen=True, eq=False)
class Sampled:
    """Values on an even time grid that begins at zero; before and after it the first and last value hold.

    Attributes:
        values: (k, *batch, m) at the times 0, step, 2 step, ...
        step: of the grid [s].
        joined: straight lines between the samples; otherwise each value holds until the next (zero-order hold).

    Raises:
        InputError: no samples, a number that is not finite, a step that is not positive.
    """

    values: ArrayLike
    step: float
    joined: bool = False

    def __post_init__(self) -> None:
        values = require_finite("values", real_array("values", self.values))
        if values.ndim < 2 or not len(values):
            raise InputError("input.shape", name="values", expected="(k, *batch, m)", got=values.shape, hint="")
        object.__setattr__(self, "values", frozen(values))
        positive("step", self.step)

    def at(self, t: float) -> Floats:
        """Value (*batch, m) at a time."""
        values, t = cast(Floats, self.values), float(single("t", t, ()))
        place = min(max(t / self.step, 0.0), len(values) - 1.0)
        if not self.joined:
            # A time that rounding puts just before a sample belongs to it.
            return values[int(place * (1.0 + ROUNDING))]
        k = min(int(place), len(values) - 2) if len(values) > 1 else 0
        share = place - k
        return (1.0 - share) * values[k] + share * values[min(k + 1, len(values) - 1)]

    @property
    def breaks(self) -> Floats:
        """Times at which the value or its slope jumps [s]."""
        return np.arange(1.0, len(cast(Floats, self.values))) * self.step


def signal(name: str, source: Source, width: int) -> Signal | None:
    """A source as a function of time and state, checked at every call; None for none.

    Args:
        name: of the argument, for errors.
        source: what the user gave.
        width: length of the last axis.

    Raises:
        InputError: a wrong shape or kind.
    """
    if source is None:
        return None
    if isinstance(source, Sampled):
        as_batch(name, cast(Floats, source.values), (width,))
        return lambda t, q, qd: source.at(t)
    if callable(source):
        function = _of_time_and_state(name, source)
        return lambda t, q, qd: as_batch(name, function(t, q, qd), (width,))
    constant = require_finite(name, as_batch(name, source, (width,)))
    return lambda t, q, qd: constant


def breaks_of(*sources: Source) -> tuple[float, ...]:
    """All times at which samples jump."""
    found: set[float] = set()
    for source in sources:
        if isinstance(source, Sampled):
            found.update(source.breaks.tolist())
    return tuple(sorted(found))


def _of_time_and_state(name: str, function: Callable[..., Any]) -> Callable[..., Any]:
    """f(t, q, qd), also of a function that takes the time alone."""
    try:
        parameters = inspect.signature(function).parameters.values()
    except (TypeError, ValueError):
        return function
    needed = [p for p in parameters if p.kind in (p.POSITIONAL_ONLY, p.POSITIONAL_OR_KEYWORD) and p.default is p.empty]
    alone = len(needed) <= 1 and not any(p.kind is p.VAR_POSITIONAL for p in parameters)
    require_function(name, function, "function of t or of (t, q, qd)", 1 if alone else 3)
    if not alone:
        return function

    def of_time(t: float, q: Any, qd: Any) -> Any:
        return function(t)

    return of_time
