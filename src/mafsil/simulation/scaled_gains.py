"""Laws whose gains differ from run to run: side by side where their arrays allow it, else each run its own law."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, cast

import numpy as np

from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.control import Gains, Impedance, Law
from mafsil.control.analysis import MinMax
from mafsil.control.contact import (
    AdmittanceControl,
    ContactSwitch,
    ForceControl,
    HybridControl,
    ImpedanceByForce,
    ImpedanceControl,
    TipDamping,
)
from mafsil.control.laws import (
    AdaptiveControl,
    ClosedComputedTorque,
    ClosedGravityCompensation,
    Combined,
    ComputedTorque,
    JointFeedback,
    LawWrapper,
    LinearQuadratic,
    ModelPredictive,
    NullSpaceFeedback,
    SlidingMode,
    TaskComputedTorque,
)
from mafsil.control.laws.feedback import take_over
from mafsil.errors import InputError
from mafsil.trajectory import Motion


def with_scaled_gains(law: Law, factors: Floats) -> Law:
    """A law whose gains differ from run to run.

    1. Laws of the joints take a row of gains for each run.
    2. Of others each run has a law of its own, called one after the other.

    Args:
        law: with gains.
        factors: (b,) of all gains: of position, rate, integral and force, of a virtual spring and damper; limits,
            layers and masses that are wished for stay as they are.

    Raises:
        InputError: a law without gains that are known here.
    """
    # 1
    if all(type(part) in SIDE_BY_SIDE or type(part) not in SCALED for part in parts_of(law)):
        return scale_gains(law, factors[:, None])
    # 2
    return RowLaws(tuple(scale_gains(law, np.array(factor)) for factor in factors.tolist()))


def in_rows(law: Law, count: int) -> Law:
    """The law for so many runs: itself, or one for each of them where it knows only one state at a time.

    Args:
        law: of one run.
        count: of runs.
    """
    single = any(type(part) in ONE_STATE for part in parts_of(law))
    return RowLaws((law,) * count) if single else law


def parts_of(law: Law) -> Iterator[Law]:
    """A law's parts: of sums, of laws behind a delay or an inner loop, of those that a contact parts, and itself.

    Args:
        law: to be taken apart.
    """
    yield law
    inside: tuple[Law, ...] = ()
    if isinstance(law, Combined):
        inside = law.laws
    elif isinstance(law, LawWrapper):
        inside = (law.law,)
    elif isinstance(law, ContactSwitch):
        inside = (law.free, law.touching)
    for part in inside:
        yield from parts_of(part)


@dataclass(frozen=True, eq=False, slots=True)
class RowLaws:
    """A law for each run of a batch.

    Attributes:
        laws: (b) of single states.
    """

    laws: tuple[Law, ...]

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (b, n) [N m | N]."""
        u, v, a = (np.broadcast_to(part, q.shape) for part in reference)
        return np.stack([law(t, q[k], qd[k], Motion(u[k], v[k], a[k])) for k, law in enumerate(self.laws)])

    def session(self, period: float) -> Law:
        """All laws with fresh memory."""
        return RowLaws(tuple(law.session(period) for law in self.laws))

    def go_on(self, before: RowLaws) -> None:
        """Take over what earlier sessions know, row by row.

        Args:
            before: which have ended.
        """
        for law, earlier in zip(self.laws, before.laws, strict=False):
            take_over(law, earlier)


def scale_gains(law: Law, factor: Floats) -> Law:
    """A law with all its gains times a factor.

    Args:
        law: with gains.
        factor: a number, or (b, 1) for laws that take a row of gains for each run.

    Raises:
        InputError: a law without gains that are known here.
    """
    if isinstance(law, LawWrapper):
        return replace(law, law=scale_gains(law.law, factor))
    if isinstance(law, ContactSwitch):
        return replace(law, free=scale_gains(law.free, factor), touching=scale_gains(law.touching, factor))
    if isinstance(law, Combined) and any(type(part) in SCALED for part in parts_of(law)):
        return Combined(tuple(scale_gains(part, factor) if _has_gains(part) else part for part in law.laws))
    if type(law) not in SCALED:
        raise InputError("simulation.no_gains", law=type(law).__name__)
    return SCALED[type(law)](law, factor)


def _has_gains(law: Law) -> bool:
    return any(type(part) in SCALED for part in parts_of(law))


def _gains(*names: str) -> Callable[[Any, Floats], Law]:
    """Of laws with gains under these names: as `Gains`, arrays or impedances."""

    def changed(law: Any, factor: Floats) -> Law:
        return replace(law, **{name: _times(getattr(law, name), factor) for name in names})

    return changed


def _times(value: Any, factor: Floats) -> Any:
    if isinstance(value, Gains):
        return Gains(factor * value.kp, factor * value.kd, factor * value.ki)
    if isinstance(value, Impedance):
        return replace(value, damping=factor * value.damping, stiffness=factor * value.stiffness)
    if callable(value):
        return partial(_times_there, cast("Callable[[PoseMatrix], Floats]", value), factor)
    return factor * value


def _times_there(value: Callable[[PoseMatrix], Floats], factor: Floats, T: PoseMatrix) -> Floats:
    return factor * value(T)


SCALED: dict[type, Callable[[Any, Floats], Law]] = {
    ComputedTorque: _gains("gains"),
    JointFeedback: _gains("gains"),
    SlidingMode: _gains("rates", "damping"),
    MinMax: _gains("rates", "damping"),
    AdaptiveControl: _gains("rates", "damping"),
    LinearQuadratic: _gains("gain"),
    ModelPredictive: _gains("slope", "gain"),
    TaskComputedTorque: _gains("gains", "rest_gains"),
    NullSpaceFeedback: _gains("gains"),
    ImpedanceControl: _gains("impedance"),
    ImpedanceByForce: _gains("impedance", "gains"),
    AdmittanceControl: _gains("impedance", "gains"),
    HybridControl: _gains("gains", "force_gains"),
    ForceControl: _gains("kp", "ki", "damping"),
    TipDamping: _gains("damping"),
    ClosedComputedTorque: _gains("gains"),
    ClosedGravityCompensation: _gains("gains"),
}
"""How the gains of each law are scaled."""
SIDE_BY_SIDE = (
    ComputedTorque, JointFeedback, SlidingMode, MinMax, AdaptiveControl,
    ClosedComputedTorque, ClosedGravityCompensation,
)  # fmt: skip
"""Laws that take a row of gains for each run."""
ONE_STATE = (ContactSwitch, HybridControl)
"""Laws that know one state at a time."""
