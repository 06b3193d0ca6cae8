"""The protocol of control laws: from a measured state and a reference to joint efforts."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Protocol, TypeAlias, runtime_checkable

import numpy as np

from mafsil.arrays import Floats, JointVector, real_array, require_function
from mafsil.errors import InputError
from mafsil.trajectory import Motion


@runtime_checkable
class Law(Protocol):
    """Maps time, state and reference to efforts: `law(t, q, qd, reference)`.

    A law itself holds no memory, so that one law serves many runs; `session` starts the memory that one run needs.
    """

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N].

        Args:
            t: time [s].
            q, qd: (*batch, n) measured positions and rates [rad | m] and per second.
            reference: desired positions, rates and accelerations, (*batch, n) or (n,).
        """
        ...

    def session(self, period: float) -> Law:
        """The law with fresh memory, to be called once every `period` [s]; the law itself if it needs none."""
        ...


LawFunction: TypeAlias = Callable[[float, JointVector, JointVector, Motion], JointVector]
"""(t, q, qd, reference) -> efforts (*batch, n): a law without memory."""


@dataclass(frozen=True, eq=False, slots=True)
class FunctionLaw:
    """A plain function as a law.

    Attributes:
        function: (t, q, qd, reference) -> efforts.
    """

    function: LawFunction

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """What the function says (*batch, n) [N m | N]."""
        return self.function(t, q, qd, reference)

    def session(self, period: float) -> Law:
        """The law itself: a function has no memory that a run could begin."""
        return self


def as_law(law: Law | LawFunction, name: str = "law") -> Law:
    """The law itself; a plain function of (t, q, qd, reference) becomes one.

    Args:
        law: either.
        name: of the argument, for the sentence.

    Raises:
        InputError: neither a law nor a function of four arguments.
    """
    if isinstance(law, type):
        raise InputError("input.kind", name=name, expected="Law", got=law.__name__)
    if isinstance(law, Law):
        return law
    require_function(name, law, "Law, or a function law(t, q, qd, reference)", 4)
    return FunctionLaw(law)


@dataclass(frozen=True, eq=False, slots=True)
class LawWrapper:
    """A law around another one, whose efforts or measured states it changes.

    Attributes:
        law: inside.
    """

    law: Law


@dataclass(frozen=True, slots=True)
class Combined:
    """The sum of several laws, such as feedforward and feedback."""

    laws: tuple[Law, ...]

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """The sum of the efforts (*batch, n) [N m | N]."""
        first, *others = self.laws
        effort = first(t, q, qd, reference)
        for law in others:
            effort = effort + law(t, q, qd, reference)
        return effort

    def session(self, period: float) -> Law:
        """All laws with fresh memory."""
        return Combined(tuple(law.session(period) for law in self.laws))


def combine(*laws: Law | LawFunction) -> Combined:
    """The sum of several laws, such as feedforward and feedback.

    Args:
        laws: at least one; functions of (t, q, qd, reference) too.

    Raises:
        InputError: no law at all, or something that is none.
    """
    if not laws:
        raise InputError("input.kind", name="laws", expected="Law", got="nothing")
    return Combined(tuple(as_law(law, f"laws[{k}]") for k, law in enumerate(laws)))


def saturate(effort: JointVector, limit: Floats) -> JointVector:
    """Efforts within their limits: elementwise clipped to -limit .. limit, infinite limits clip nothing.

    Args:
        effort: (*batch, n) commanded [N m | N].
        limit: (n,) magnitudes.
    """
    tau, most = real_array("effort", effort), real_array("limit", limit)
    return np.minimum(np.maximum(tau, -most), most)
