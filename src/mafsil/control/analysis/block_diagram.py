"""The block diagram of a law, generated from the law itself: its terms, the drive, the arm, the sensors, and arrows."""

from __future__ import annotations

import itertools
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, cast

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.control.contact.admittance import AdmittanceControl, ImpedanceByForce
from mafsil.control.contact.force import ForceControl, apply_gain
from mafsil.control.contact.hybrid import HybridControl
from mafsil.control.contact.impedance import ImpedanceControl
from mafsil.control.contact.tip_sensor import ContactFeedforward, ContactSwitch, TipDamping
from mafsil.control.joints.friction_compensation import FrictionCompensation
from mafsil.control.joints.hardware_around import CurrentLoopLaw, Delayed, EncoderLoop
from mafsil.control.laws.adaptive import AdaptiveControl
from mafsil.control.laws.feedback import pd
from mafsil.control.laws.joint_feedback import ComputedTorque, Feedforward, JointFeedback, feedforward
from mafsil.control.laws.law import Combined, Law, as_law
from mafsil.control.laws.optimal import LinearQuadratic, ModelPredictive
from mafsil.control.laws.sliding_mode import MinMax, SlidingMode
from mafsil.control.laws.task_coordinates import NullSpaceFeedback
from mafsil.control.laws.tip_motion import TaskComputedTorque
from mafsil.mechanics.friction import has_friction
from mafsil.robot import Robot
from mafsil.trajectory import Motion

Effort = Callable[[float, JointVector, JointVector, Motion], Floats]


@dataclass(frozen=True, eq=False, slots=True)
class Term:
    """One summand of a law.

    Attributes:
        text: its formula.
        inputs: blocks whose signals it takes: `trajectory`, `sensors`.
        effort: (t, q, qd, reference) -> (*batch, n), without integrals; None where the summands share their parts.
    """

    text: str
    inputs: tuple[str, ...]
    effort: Effort | None = None


@dataclass(frozen=True, slots=True)
class Block:
    """A box of a diagram.

    Attributes:
        name: by which arrows know it: `trajectory`, `term 1`, `sum`, `delay`, `amplifier`, `actuator`, `arm`,
            `sensors`.
        text: what stands in it; empty where the name says it, in the reader's language.
        column, row: where it stands.
    """

    name: str
    text: str
    column: int
    row: int = 0


@dataclass(frozen=True, slots=True)
class Arrow:
    """A signal from one block to another."""

    start: str
    end: str
    signal: str = ""


@dataclass(frozen=True, eq=False, slots=True)
class BlockDiagram:
    """Blocks and arrows of a closed loop.

    Attributes:
        blocks, arrows: of the loop.
        terms: the summands of the law.
    """

    blocks: tuple[Block, ...]
    arrows: tuple[Arrow, ...]
    terms: tuple[Term, ...]

    def followers(self, name: str) -> tuple[str, ...]:
        """Blocks to which arrows lead from one."""
        return tuple(arrow.end for arrow in self.arrows if arrow.start == name)

    def effort(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> Floats | None:
        """What the sum block gives out, integrals left out; None where a term stands for itself only on paper.

        Args:
            t: time [s].
            q, qd: (*batch, n) state.
            reference: of the joints.
        """
        values = [None if term.effort is None else term.effort(t, q, qd, reference) for term in self.terms]
        known = [value for value in values if value is not None]
        return sum(known[1:], known[0]) if len(known) == len(values) else None


@dataclass(slots=True)
class _Parts:
    terms: list[Term] = field(default_factory=list[Term])
    delay: float = 0.0
    inner: float | None = None
    resolution: float | None = None


BOTH = ("trajectory", "sensors")


def block_diagram(law: Law, *, idealised: bool = False) -> BlockDiagram:
    """The loop that a law closes.

    The whole form has a power amplifier with an inner current loop, actuator and transmission; in the idealised one the
    law's torque acts on the arm, and the sensors are perfect.

    Args:
        law: any law; sums, delays and inner loops are taken apart.
        idealised: which form.

    Raises:
        InputError: no law.

    Reference: Lynch and Park, Modern Robotics, fig. 11.1, 11.10, 11.18.
    """
    parts = _Parts()
    _take_apart(as_law(law), parts)
    blocks, arrows = [Block("trajectory", "u, v, a", 0)], list[Arrow]()
    for k, term in enumerate(parts.terms):
        name = f"term {k + 1}"
        blocks.append(Block(name, term.text, 1, k))
        arrows += [Arrow(one, name, {"trajectory": "u, v, a", "sensors": "q, q̇"}[one]) for one in term.inputs]
        arrows.append(Arrow(name, "sum"))
    chain = [Block("sum", "Σ", 2)]
    if parts.delay:
        chain.append(Block("delay", f"{parts.delay:g} s", 3))
    if not idealised:
        inner = "" if parts.inner is None else f"ω = {parts.inner:g} rad/s"
        chain.append(Block("amplifier", inner, len(chain) + 2))
        chain.append(Block("actuator", "", len(chain) + 2))
    chain.append(Block("arm", "M q̈ + c + g + J'F = τ", len(chain) + 2))
    steps = "" if parts.resolution is None else f"Δq = {parts.resolution:g}"
    chain.append(Block("sensors", "q, q̇" if idealised else steps, len(chain) + 1, 1))
    signals = {"amplifier": "i", "actuator": "τ", "arm": "q, q̇"}
    blocks += chain
    for before, after in itertools.pairwise(chain):
        last = "τ" if idealised or after.name in ("amplifier", "delay") else ""
        arrows.append(Arrow(before.name, after.name, signals.get(before.name, last)))
    if not idealised:
        arrows.append(Arrow("actuator", "amplifier", "i"))
    return BlockDiagram(tuple(blocks), tuple(arrows), tuple(parts.terms))


def _take_apart(law: Any, parts: _Parts) -> None:
    if isinstance(law, Combined):
        for part in law.laws:
            _take_apart(part, parts)
    elif isinstance(law, Delayed):
        parts.delay += law.delay
        _take_apart(law.law, parts)
    elif isinstance(law, CurrentLoopLaw):
        parts.inner = law.bandwidth
        _take_apart(law.law, parts)
    elif isinstance(law, EncoderLoop):
        parts.resolution = float(law.resolution.max())
        _take_apart(law.law, parts)
    elif isinstance(law, ContactSwitch):
        _take_apart(law.free, parts)
        _take_apart(law.touching, parts)
    else:
        parts.terms += _terms(law)


def _terms(law: object) -> list[Term]:
    reader = READERS.get(type(law))
    if reader is not None:
        return reader(law)
    own = cast("Law", law)
    return [Term(f"{type(own).__name__}(t, q, q̇)", BOTH, own)]


def _joint_feedback(law: JointFeedback) -> list[Term]:
    kp, kd, ki = law.gains.kp, law.gains.kd, law.gains.ki
    terms = [
        Term("Kp (u - q)", BOTH, lambda t, q, qd, reference: kp * (reference.u - q)),
        Term("Kd (v - q̇)", BOTH, lambda t, q, qd, reference: kd * (reference.v - qd)),
    ]
    if ki.any():
        terms.append(Term("Ki ∫(u - q) dt", BOTH, lambda t, q, qd, reference: 0.0 * q))
    model = law.model
    if model is not None:
        terms.append(Term("g(q)", ("sensors",), lambda t, q, qd, reference: model.gravity_torque(q)))
        terms += _rubbing(model, law.friction)
    return terms


def _rubbing(model: Robot, compensated: bool) -> list[Term]:
    """The friction of the model, where it has any and the law compensates it."""
    if not compensated or not has_friction(model.mechanism):
        return []
    return [Term("f(v)", ("trajectory",), FrictionCompensation(model))]


def _computed_torque(law: ComputedTorque) -> list[Term]:
    robot, gains = law.robot, law.gains
    wanted = "a + Kp (u - q) + Kd (v - q̇)" + (" + Ki ∫(u - q) dt" if gains.integrates else "")

    def driven(t: float, q: JointVector, qd: JointVector, reference: Motion) -> Floats:
        acceleration = reference.a + pd(gains, q, qd, reference)
        return (robot.mass_matrix(q) @ acceleration[..., None])[..., 0]

    def bias(t: float, q: JointVector, qd: JointVector, reference: Motion) -> Floats:
        return robot.velocity_torque(q, qd) + robot.gravity_torque(q)

    terms = [Term(f"M(q) [{wanted}]", BOTH, driven), Term("c(q, q̇) + g(q)", ("sensors",), bias)]
    return terms + _rubbing(robot, law.friction)


def _feedforward(law: Feedforward) -> list[Term]:
    alone = Term("M(u) a + c(u, v) + g(u)", ("trajectory",), feedforward(law.robot, friction=False))
    return [alone, *_rubbing(law.robot, law.friction)]


def _force(law: ForceControl) -> list[Term]:
    def pressed(t: float, q: JointVector, qd: JointVector, reference: Motion) -> Floats:
        force = law.wrench + apply_gain(law.kp, law.error(q, qd))
        return (np.swapaxes(law.robot.jacobian_body(q), -1, -2) @ force[..., None])[..., 0]

    def damped(t: float, q: JointVector, qd: JointVector, reference: Motion) -> Floats:
        J = law.robot.jacobian_body(q)
        return -(np.swapaxes(J, -1, -2) @ apply_gain(law.damping, (J @ qd[..., None])[..., 0])[..., None])[..., 0]

    integral = " + Kfi ∫F_e dt" if law.ki.any() else ""
    return [
        Term(f"J' (F_d + Kfp F_e{integral})", ("sensors",), pressed),
        Term("-J' Kdamp V", ("sensors",), damped),
        Term("g(q)", ("sensors",), lambda t, q, qd, reference: law.robot.gravity_torque(q)),
    ]


def _as_written(*texts: str) -> Callable[[Any], list[Term]]:
    """Terms that share their parts: only what stands in the boxes."""
    return lambda law: [Term(text, BOTH) for text in texts]


def _whole(text: str) -> Callable[[Any], list[Term]]:
    """A law that is one term."""
    return lambda law: [Term(text, BOTH, law)]


READERS: dict[type, Callable[[Any], list[Term]]] = {
    JointFeedback: _joint_feedback,
    ComputedTorque: _computed_torque,
    Feedforward: _feedforward,
    FrictionCompensation: _whole("f(v)"),
    ForceControl: _force,
    ContactFeedforward: _whole("M(u) a + c(u, v) + g(u) - J(u)' F(u, v)"),
    SlidingMode: _as_written("M q̈_r + C q̇_r + g", "Kd s", "k sat(s / φ)"),
    MinMax: _as_written("M q̈_r + C q̇_r + g", "Kd s", "Y w"),
    ModelPredictive: _whole("M (a + w) + c + g, best over the horizon"),
    AdaptiveControl: _as_written("M q̈_r + C q̇_r + g", "Y a", "Kd s"),
    LinearQuadratic: _whole("M(u) a + c(u, v) + g(u) + K (u - q, v - q̇)"),
    TaskComputedTorque: _as_written("J' Λ (A_d + Kp X_e + Kd V_e)", "J' (γ + η)"),
    ImpedanceControl: _as_written("J' (Λ dV/dt + γ + η)", "J' (K X_e + B V_e)"),
    ImpedanceByForce: _as_written("J' (Λ dV/dt + γ + η)", "J' F_cmd", "J' (Kfp F_e + Kfi ∫F_e dt)"),
    AdmittanceControl: _as_written("J' Λ D^-1 (F - B V - K X)", "J' (γ + η - F)"),
    HybridControl: _as_written(
        "J' P Λ (A_d + Kp X_e + Kd V_e)", "J' (I - P) (F_d + Kfp F_e + Kfi ∫F_e dt)", "J' (γ + η)"
    ),
    NullSpaceFeedback: _whole("(I - J' Jbar') M (a + Kp (u - q) + Kd (v - q̇))"),
    TipDamping: _whole("-J' B V"),
}
"""What stands in the boxes of each law."""
