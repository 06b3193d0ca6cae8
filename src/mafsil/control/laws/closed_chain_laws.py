"""Laws as expressions: what a closed loop of an open arm or of a closed chain is compiled from, and what is exported.

The laws of closed chains give efforts of the driven joints alone, by the dynamics with the forces of the loops: one
kernel of the feedback of the driven joints and the dynamics behind it.

Reference: Nakamura and Ghodoussi, Dynamics computation of closed-link robot mechanisms with nonredundant and redundant
actuators, IEEE Trans. Rob. Autom. 5, 1989.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil import kernels
from mafsil.arrays import Floats, JointVector, require_kind
from mafsil.control.joints.friction_compensation import FrictionCompensation
from mafsil.control.laws.feedback import Gains
from mafsil.control.laws.joint_feedback import ComputedTorque, Feedforward, JointFeedback
from mafsil.control.laws.law import Combined, Law
from mafsil.kernels import Kernel, Port, Signature
from mafsil.lazy_module import lazily
from mafsil.mechanics.friction import has_friction
from mafsil.mechanics.loop_terms import Loop, Term, input_sizes
from mafsil.model import Mechanism
from mafsil.model.fingerprint import fingerprint
from mafsil.model.loading import require_no_loops
from mafsil.parallel import ClosedChain
from mafsil.parallel.closed_compiled import is_certain
from mafsil.robot import Robot
from mafsil.trajectory import Motion

if TYPE_CHECKING:
    import mafsil.mechanics.closed_loop as steps
else:
    steps = lazily("mafsil.mechanics.closed_loop")


Run = Callable[..., Any]


@dataclass(frozen=True, eq=False, slots=True)
class LawTerms:
    """A control law as data: its terms, the gains of those that have some, the limits of those whose integral waits."""

    terms: tuple[Term, ...]
    gains: tuple[Gains, ...]
    limits: tuple[Floats, ...] = ()


def _computed_torque(law: ComputedTorque) -> LawTerms:
    return LawTerms((_of_model("computed_torque", law.robot, law.friction),), (law.gains,))


def _of_model(kind: str, robot: Robot, friction: bool, waits: bool = False) -> Term:
    """A term that believes in a robot without loops; it compensates friction where the robot has any."""
    mechanism = require_no_loops(robot.mechanism)
    return Term(kind, mechanism, waits=waits, friction=friction and has_friction(mechanism))


def _joint_feedback(law: JointFeedback) -> LawTerms | None:
    if law.effort_limit is not None and law.gains.integrates:
        waiting = Term("feedback", waits=True)
        if law.model is not None:
            waiting = _of_model("feedback", law.model, law.friction, waits=True)
        return LawTerms((waiting,), (law.gains,), (law.effort_limit,))
    gravity = () if law.model is None else (_of_model("gravity", law.model, law.friction),)
    return LawTerms((Term("feedback"), *gravity), (law.gains,))


def _feedforward(law: Feedforward) -> LawTerms:
    return LawTerms((_of_model("feedforward", law.robot, law.friction),), ())


def _friction_compensation(law: FrictionCompensation) -> LawTerms:
    return LawTerms((_of_model("friction", law.robot, True),), ())


def _combine(law: Combined) -> LawTerms | None:
    return all_together([law_terms(part) for part in law.laws])


def all_together(parts: Sequence[LawTerms | None]) -> LawTerms | None:
    """The sum of laws as data; None if there is none, or if one of them is no data.

    Args:
        parts: laws as data.
    """
    known = [part for part in parts if part is not None]
    if not known or len(known) < len(parts):
        return None
    return LawTerms(
        sum((part.terms for part in known), ()),
        sum((part.gains for part in known), ()),
        sum((part.limits for part in known), ()),
    )


LAWS: dict[type, Callable[[Any], LawTerms | None]] = {
    ComputedTorque: _computed_torque,
    JointFeedback: _joint_feedback,
    Feedforward: _feedforward,
    FrictionCompensation: _friction_compensation,
    Combined: _combine,
}
"""Laws that are expressions, and how they are read."""


def law_terms(law: Law) -> LawTerms | None:
    """A law as data, or None if it is Python that only Python can run."""
    reader = LAWS.get(type(law))
    return None if reader is None else reader(law)


class _Compiled:
    """A law as one kernel, made at its first call; it travels to other processes without it."""

    __slots__ = ("gains", "looked", "run")

    def __init__(self) -> None:
        self.looked, self.gains = False, np.zeros(0)
        self.run: Run | None = None

    def efforts(
        self, law: ClosedComputedTorque | ClosedGravityCompensation, q: JointVector, qd: JointVector, reference: Motion
    ) -> JointVector | None:
        """Efforts (*batch, n) that hold, or None: the careful way remains.

        Args:
            law: whose kernel it is.
            q, qd, reference: as for a law.
        """
        if not self.looked:
            found = law.as_terms(q)
            if found is not None:
                self.run = law_kernel(law.chain.robot.mechanism, found.terms).call
                self.gains = np.stack([np.stack([g.kp, g.kd, g.ki], axis=-2) for g in found.gains], axis=-3)
            self.looked = True
        if self.run is None:
            return None
        effort, doubt = self.run(q, qd, reference.u, reference.v, reference.a, self.gains)
        return effort if is_certain(doubt) else None

    def __reduce__(self) -> tuple[type[_Compiled], tuple[()]]:
        return _Compiled, ()


@dataclass(frozen=True, eq=False, slots=True)
class ClosedComputedTorque:
    """Efforts of the driven joints that give them the acceleration a + Kd (v - qd) + Kp (u - q) with closed loops.

    Attributes:
        chain: the model; it may differ from the plant.
        gains: of the driven joints, in units of acceleration.
    """

    chain: ClosedChain
    gains: Gains
    _kept: _Compiled = field(default_factory=_Compiled, init=False, repr=False)

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Efforts (*batch, n), zero for joints that are not driven [N m | N]."""
        effort = self._kept.efforts(self, q, qd, reference)
        if effort is not None:
            return effort
        driven = reference.a[..., self.chain.actuated] + _feedback(self.chain, self.gains, q, qd, reference)
        acceleration = self.chain.accelerations(q, qd, driven)
        return _of_all(self.chain, self.chain.inverse_dynamics(q, qd, acceleration).tau)

    def session(self, period: float) -> Law:
        """The law itself: it needs no memory."""
        return self

    def as_terms(self, q: ArrayLike) -> LawTerms | None:
        """The law as data, or None if its efforts cannot be compiled.

        Args:
            q: (*batch, n) configurations that close the loops.
        """
        return _as_terms(self.chain, self.gains, (), "closed_computed_torque", q)


@dataclass(frozen=True, eq=False, slots=True)
class ClosedGravityCompensation:
    """Springs and dampers at the driven joints, and the efforts that hold the mechanism up where it is.

    Attributes:
        chain: the model.
        gains: of the driven joints, in units of effort.
    """

    chain: ClosedChain
    gains: Gains
    _kept: _Compiled = field(default_factory=_Compiled, init=False, repr=False)

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Efforts (*batch, n), zero for joints that are not driven [N m | N]."""
        effort = self._kept.efforts(self, q, qd, reference)
        if effort is not None:
            return effort
        still = np.zeros(q.shape)
        holding = self.chain.inverse_dynamics(q, still, still).tau
        return _of_all(self.chain, holding + _feedback(self.chain, self.gains, q, qd, reference))

    def session(self, period: float) -> Law:
        """The law itself: it needs no memory."""
        return self

    def as_terms(self, q: ArrayLike) -> LawTerms | None:
        """The law as data, or None if its efforts cannot be compiled.

        Args:
            q: (*batch, n) configurations that close the loops.
        """
        return _as_terms(self.chain, self.gains, (Term("feedback"),), "closed_gravity", q)


def closed_computed_torque(
    chain: ClosedChain, *, natural_frequency: ArrayLike = 20.0, damping_ratio: ArrayLike = 1.0
) -> ClosedComputedTorque:
    """Computed torque of a closed chain; the errors of the driven joints obey e'' + 2 zeta w e' + w^2 e = 0.

    Args:
        chain: the model.
        natural_frequency: w, a number or one per driven joint [rad/s].
        damping_ratio: zeta, a number or one per driven joint; 1 is critical damping.

    Raises:
        InputError: a wrong shape, a negative number.
    """
    require_kind("chain", chain, "ClosedChain", "inverse_dynamics", "actuated")
    gains = Gains.from_natural_frequency(len(chain.actuated), natural_frequency, damping_ratio, 0.0)
    return ClosedComputedTorque(chain, gains)


def closed_gravity_compensation(chain: ClosedChain, kp: ArrayLike, kd: ArrayLike) -> ClosedGravityCompensation:
    """PD control of the driven joints of a closed chain, with gravity compensation.

    Args:
        chain: the model.
        kp: stiffness, a number or one per driven joint [N m/rad | N/m].
        kd: damping, likewise [N m s/rad | N s/m].

    Raises:
        InputError: a wrong shape, a negative number.
    """
    require_kind("chain", chain, "ClosedChain", "inverse_dynamics", "actuated")
    return ClosedGravityCompensation(chain, Gains.of(len(chain.actuated), kp, kd))


def _feedback(chain: ClosedChain, gains: Gains, q: JointVector, qd: JointVector, reference: Motion) -> Floats:
    """(*batch, a) Kp (u - q) + Kd (v - qd) of the driven joints."""
    a = chain.actuated
    return gains.kp * (reference.u - q).take(a, axis=-1) + gains.kd * (reference.v - qd).take(a, axis=-1)


def _of_all(chain: ClosedChain, driven: Floats) -> JointVector:
    """(*batch, n) efforts of all joints."""
    effort = np.zeros((*driven.shape[:-1], chain.n))
    effort[..., chain.actuated] = driven
    return effort


def _as_terms(chain: ClosedChain, gains: Gains, before: tuple[Term, ...], kind: str, q: ArrayLike) -> LawTerms | None:
    """One term of the chain behind others, with the gains of all joints: zero where none drives."""
    holding = chain.holding(q)
    if holding is None or not holding.deciding:
        return None
    whole = Gains(*(_of_all(chain, part) for part in (gains.kp, gains.kd, gains.ki)))
    return LawTerms((*before, Term(kind, chain.robot.mechanism, holding)), (whole,))


def closed_law_terms(law: Law, q: ArrayLike) -> LawTerms | None:
    """A law as data; None if it is Python that only Python can run, or if its efforts cannot be compiled.

    Args:
        law: of a closed chain, or any other.
        q: (*batch, n) configurations that close the loops.
    """
    if isinstance(law, Combined):
        return all_together([closed_law_terms(part, q) for part in law.laws])
    if not isinstance(law, ClosedComputedTorque | ClosedGravityCompensation):
        return law_terms(law)
    return law.as_terms(q)


def law_kernel(mechanism: Mechanism, terms: tuple[Term, ...]) -> Kernel:
    """The kernel of `mafsil.mechanics.closed_loop.closed_law`.

    Args:
        mechanism: with loops.
        terms: of the law.
    """
    loop = Loop(
        plant=mechanism, terms=terms, shown=mechanism, scheme=(), substeps=1, friction=None, pushed=False,
        noisy=False, saturated=False, integrates=False,
    )  # fmt: skip
    n = mechanism.n
    inputs = (*(Port(name, (n,)) for name in ("q", "qd", "u", "v", "a")), Port("gains", input_sizes(loop)["gains"]))
    parts = [
        (term.kind, None if term.model is None else fingerprint(term.model), term.holding, term.waits) for term in terms
    ]
    return kernels.compile(
        Signature("closed_law", inputs, (Port("effort", (n,)), Port("doubt", ()))),
        partial(_build, loop),
        key=f"closed_law {fingerprint(mechanism)} {parts}",
        fingerprints=(kernels.fingerprint("mafsil.algebra", "mafsil.mechanics"),),
    )


# Its expressions are loaded only when a kernel has to be made.
def _build(loop: Loop) -> Any:
    return steps.closed_law(loop)
