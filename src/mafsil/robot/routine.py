"""Call signatures of a robot's quantities: what editors show and type checkers read."""

from __future__ import annotations

from typing import Protocol

from numpy.typing import ArrayLike

from mafsil.arrays import Floats


class OfPosition(Protocol):
    """A quantity of the joint coordinates."""

    def __call__(self, q: ArrayLike, *, out: Floats | None = None, threads: int | None = None) -> Floats: ...


class OfPositionInFrame(Protocol):
    """A quantity of the joint coordinates, for the tip frame or a named link's frame."""

    def __call__(
        self, q: ArrayLike, *, frame: str | None = None, out: Floats | None = None, threads: int | None = None
    ) -> Floats: ...


class OfVelocity(Protocol):
    """A quantity of joint coordinates and rates."""

    def __call__(
        self, q: ArrayLike, qd: ArrayLike, *, out: Floats | None = None, threads: int | None = None
    ) -> Floats: ...


class OfVelocityInFrame(Protocol):
    """A quantity of joint coordinates and rates, for the tip frame or a named link's frame."""

    def __call__(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        *,
        frame: str | None = None,
        out: Floats | None = None,
        threads: int | None = None,
    ) -> Floats: ...


class InverseDynamics(Protocol):
    """Joint efforts from a motion."""

    def __call__(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        tip_wrench: ArrayLike | None = None,
        *,
        out: Floats | None = None,
        threads: int | None = None,
    ) -> Floats: ...


class ForwardDynamics(Protocol):
    """Joint accelerations from joint efforts."""

    def __call__(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        tau: ArrayLike,
        tip_wrench: ArrayLike | None = None,
        *,
        out: Floats | None = None,
        threads: int | None = None,
    ) -> Floats: ...


class InverseDynamicsOfCarried(Protocol):
    """Efforts or wrenches from a motion, on a base that may be carried."""

    def __call__(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        tip_wrench: ArrayLike | None = None,
        base_twist: ArrayLike | None = None,
        base_acceleration: ArrayLike | None = None,
        *,
        out: Floats | None = None,
        threads: int | None = None,
    ) -> Floats: ...


class OfMotion(Protocol):
    """A quantity of joint coordinates, rates and accelerations."""

    def __call__(
        self, q: ArrayLike, qd: ArrayLike, qdd: ArrayLike, *, out: Floats | None = None, threads: int | None = None
    ) -> Floats: ...


class OfMotionInFrame(Protocol):
    """A quantity of a motion, for the tip frame or a named link's frame."""

    def __call__(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        *,
        frame: str | None = None,
        out: Floats | None = None,
        threads: int | None = None,
    ) -> Floats: ...


class OfLinkVelocity(Protocol):
    """Twists of all links, on a base that may be carried."""

    def __call__(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        base_twist: ArrayLike | None = None,
        *,
        out: Floats | None = None,
        threads: int | None = None,
    ) -> Floats: ...


class OfLinkAcceleration(Protocol):
    """Accelerations of all links, on a base that may be carried."""

    def __call__(
        self,
        q: ArrayLike,
        qd: ArrayLike,
        qdd: ArrayLike,
        base_twist: ArrayLike | None = None,
        base_acceleration: ArrayLike | None = None,
        *,
        out: Floats | None = None,
        threads: int | None = None,
    ) -> Floats: ...


class Together(Protocol):
    """Several quantities of one state: inputs in the order of `kernel.signature`, one result for each quantity."""

    def __call__(
        self, *inputs: ArrayLike, out: tuple[Floats, ...] | None = None, threads: int | None = None
    ) -> tuple[Floats, ...]: ...
