"""Laws, measures and plots of control for readers who know nothing of them: a formula and a paragraph each."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import require_kind
from mafsil.control.analysis.citation import Citation, citation
from mafsil.control.analysis.worst_case import MinMax
from mafsil.control.contact.admittance import AdmittanceControl
from mafsil.control.contact.force import ForceControl
from mafsil.control.contact.hybrid import HybridControl
from mafsil.control.contact.impedance import ImpedanceControl
from mafsil.control.contact.impedance_by_force import ImpedanceByForce
from mafsil.control.contact.tip_sensor import ContactSwitch
from mafsil.control.joints.current_loop import CurrentLoopLaw
from mafsil.control.joints.delayed import Delayed
from mafsil.control.joints.encoder_loop import EncoderLoop
from mafsil.control.joints.friction_compensation import FrictionCompensation
from mafsil.control.laws.adaptive import AdaptiveControl
from mafsil.control.laws.computed_torque import ComputedTorque
from mafsil.control.laws.joint_feedback import Feedforward, JointFeedback
from mafsil.control.laws.linear_quadratic import LinearQuadratic
from mafsil.control.laws.matrix_feedback import MatrixFeedback
from mafsil.control.laws.receding_horizon import ModelPredictive
from mafsil.control.laws.sliding_mode import SlidingMode
from mafsil.control.laws.task_coordinates import TaskCoordinates
from mafsil.control.laws.tip_motion import TaskComputedTorque
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.messages.quantities import digits, quantity
from mafsil.messages.visible import visible
from mafsil.robot import Robot, as_robot
from mafsil.trajectory import Trajectory

FORMULAS: dict[str, tuple[str, tuple[str, ...]]] = {
    "pid": ("τ = Kp (u - q) + Kd (v - q̇) + Ki ∫(u - q) dt", ("lynch2017",)),
    "pd_gravity": ("τ = Kp (u - q) + Kd (v - q̇) + g(q) + f(v)", ("takegaki1981", "lynch2017")),
    "computed_torque": ("τ = M(q) (a + Kp e + Kd ė) + c(q, q̇) + g(q) + f(v),  ë + Kd ė + Kp e = 0", ("lynch2017",)),
    "feedforward": ("τ = M(u) a + c(u, v) + g(u) + f(v)", ("lynch2017",)),
    "friction_compensation": ("τ = f(v) = b v + c sign(v)", ("lynch2017",)),
    "sliding_mode": ("τ = M q̈_r + C q̇_r + g + Kd s + k sat(s/φ),  s = ė + L e", ("slotine1987",)),
    "min_max": ("τ = Y (p + w) + Kd s,  w = ρ D x / max(|x|, φ),  x = D Y' s", ("spong1992",)),
    "model_predictive": ("min Σ (Q e² + R ė² + r w²) + x_N' P x_N,  |M (a + w) + c + g| <= τ_max", ("mayne2000",)),
    "adaptive": ("τ = M q̈_r + C q̇_r + g + Y a + Kd s,  ȧ = G Y' s,  s = ė + L e", ("slotine1987",)),
    "task_computed_torque": ("τ = J' (Λ (A_d + Kp X_e + Kd V_e) + γ + η)", ("khatib1987", "lynch2017")),
    "impedance": ("τ = J' (Λ A_d + γ + η + K X_e + B V_e)", ("hogan1985",)),
    "admittance": ("D V̇ + B V + K X = F", ("hogan1985",)),
    "hybrid": ("τ = J' (P Λ (A_d + Kp X_e + Kd V_e) + (I - P) (F_d + Kfp F_e + Kfi ∫F_e dt) + γ + η)",
               ("raibert1981", "khatib1987")),
    "force": ("τ = g + J' (F_d + Kfp F_e + Kfi ∫F_e dt - Kdamp V)", ("lynch2017",)),
    "impedance_by_force": ("τ = J' (Λ V̇ + γ + η + F_cmd + Kfp F_e + Kfi ∫F_e dt),  F_cmd = -(D V̇ + B V + K X)",
                           ("lynch2017", "hogan1985")),
    "linear_quadratic": ("min ∫ (x' Q x + δτ' R δτ) dt,  δτ = K x", ()),
    "delayed": ("τ(t) = law(t - T)", ()),
    "current_loop": ("τ' = ω (τ_commanded - τ)", ("lynch2017",)),
    "encoder_loop": ("q_k = Δq round(q / Δq);  v_k = a v_{k-1} + (1 - a) (q_k - q_{k-1}) / dt", ("lynch2017",)),
    "tip_error": ("max |p_d(t) - p(t)|", ()),
    "joint_error": ("sqrt(mean (u - q)²)", ()),
    "rms_effort": ("sqrt(mean τ²)", ()),
    "energy": ("∫ max(τ q̇, 0) dt", ()),
    "saturation": ("time with |τ_commanded| > τ_max", ()),
    "growth": ("max |eigenvalue| of x(k + 1) = A x(k)", ()),
    "overshoot": ("exp(-π ζ / sqrt(1 - ζ²))", ("lynch2017",)),
    "settling_time": ("|e(t) - e_end| <= 0.02 |e(0) - e_end| from then on;  about 4 / (ζ ω)", ("lynch2017",)),
    "steady_error": ("e_end = load / Kp", ("lynch2017",)),
    "contact_force": ("f = max(0, k d - b ḋ)", ("lynch2017",)),
    "deadlines": ("end of tick k <= due + T", ()),
    "response_plot": ("q(t), u(t)", ()),
    "effort_plot": ("τ(t), ±τ_max", ()),
    "root_locus": ("1 + K G(s) = 0", ("lynch2017",)),
    "frequency_response": ("|L(jω)|, arg L(jω)", ()),
    "phase_plane": ("(x, ẋ)", ("lynch2017",)),
    "joint_space": ("e = u - q", ("lynch2017",)),
    "task_space": ("X_e = log(T^-1 T_d)", ("khatib1987", "lynch2017")),
}  # fmt: skip
"""Of each law, measure, plot and space: its formula and the works behind it."""
CLASSES: dict[type, str] = {
    ComputedTorque: "computed_torque",
    Feedforward: "feedforward",
    FrictionCompensation: "friction_compensation",
    SlidingMode: "sliding_mode",
    MinMax: "min_max",
    ModelPredictive: "model_predictive",
    AdaptiveControl: "adaptive",
    TaskComputedTorque: "task_computed_torque",
    ImpedanceControl: "impedance",
    ImpedanceByForce: "impedance_by_force",
    AdmittanceControl: "admittance",
    HybridControl: "hybrid",
    ForceControl: "force",
    LinearQuadratic: "linear_quadratic",
    ContactSwitch: "hybrid",
    Delayed: "delayed",
    CurrentLoopLaw: "current_loop",
    EncoderLoop: "encoder_loop",
}
PLACES, NEAR_SINGULAR, NEAR_LIMIT = 100, 0.05, 0.02
"""Where a motion is looked at; singular values and shares of a range from which on they decide."""


@dataclass(frozen=True, slots=True)
class Words:
    """A formula and a paragraph.

    Attributes:
        name: of the law, measure, plot or space.
        formula: in signs that need no translation.
        works: behind it.
    """

    name: str
    formula: str
    works: tuple[Citation, ...]

    def paragraph(self, language: str | None = None) -> str:
        """What it is, in `en` or `ar` or the current language."""
        return say(f"explanation.{self.name}", language=language)

    def __str__(self) -> str:
        return f"{self.formula}\n{self.paragraph()}"


def words_for(what: object) -> Words:
    """The words for a law, a measure, a plot or a space.

    Args:
        what: a law itself, or a name: of a law as jobs call it, such as `hybrid`; of a measure, such as `overshoot`; of
            a plot, such as `root_locus`; `joint_space` or `task_space`.

    Raises:
        InputError: nothing of that name; the sentence lists what there is.
    """
    name = what if isinstance(what, str) else CLASSES.get(type(what), type(what).__name__)
    if isinstance(what, JointFeedback):
        name = "pid" if what.model is None else "pd_gravity"
    if isinstance(what, MatrixFeedback):
        name = "computed_torque" if what.whole_model else "pid" if what.model is None else "pd_gravity"
    if name not in FORMULAS:
        raise InputError("input.choice", name="what", value=name, known=", ".join(FORMULAS))
    formula, works = FORMULAS[name]
    return Words(name, formula, tuple(citation(key) for key in works))


@dataclass(frozen=True, slots=True)
class SpaceAdvice:
    """Whether to control joints or tip, and why.

    Attributes:
        space: `joint_space` or `task_space`.
        reasons: keys and details of sentences, what decided first.
    """

    space: str
    reasons: tuple[tuple[str, dict[str, str | int]], ...]

    def sentence(self, language: str | None = None) -> str:
        """The advice with what decided it."""
        key, details = self.reasons[0]
        reason = say(f"explanation.{key}", language=language, **details)
        kind = "task" if self.space == "task_space" else "joint"
        return say(f"explanation.advice_{kind}", language=language, reason=reason)

    def __str__(self) -> str:
        return f"{self.sentence()}\n{words_for(self.space).paragraph()}"


def joint_or_task_space(
    robot: Robot, trajectory: Trajectory, *, contact: bool = False, coordinates: TaskCoordinates | None = None
) -> SpaceAdvice:
    """In which space a motion is better controlled: what the path shows decides, in this order.

    A singular pose on the way speaks for joints, then contact for the tip; else it is joints, for their limits, for
    those to spare, or because nothing speaks against them.

    Args:
        robot: that moves.
        trajectory: of its joints.
        contact: whether the tip touches something.
        coordinates: of the task; all six, decoupled, if None.
    """
    arm, task = as_robot(robot), coordinates or TaskCoordinates()
    require_kind("trajectory", trajectory, "Trajectory", "at", "duration")
    u = trajectory.at(np.linspace(0.0, trajectory.duration, PLACES)).u
    sizes = np.linalg.svd(task.jacobian(arm, u), compute_uv=False)
    needed = len(task.rows)
    ratio = float((sizes[:, -1] / np.maximum(sizes[:, 0], LEAST_DIVISOR)).min()) if arm.n >= needed else 0.0
    reasons: list[tuple[str, dict[str, str | int]]] = []
    if ratio < NEAR_SINGULAR:
        reasons.append(("reason_singular", {"ratio": digits(ratio)}))
    wide = arm.limits.upper - arm.limits.lower
    bounded = np.isfinite(wide) & (wide > 0.0)
    left = np.minimum(u - arm.limits.lower, arm.limits.upper - u).min(axis=0)
    share = np.where(bounded, left / np.where(bounded, wide, 1.0), np.inf)
    if share.min() < NEAR_LIMIT:
        joint = visible(arm.joint_names[int(share.argmin())])
        reasons.append(("reason_limits", {"joint": joint, "share": quantity(max(float(share.min()), 0.0), "share")}))
    if contact and ratio >= NEAR_SINGULAR:
        return SpaceAdvice("task_space", (("reason_contact", {}), *reasons))
    if arm.n > needed:
        reasons.append(("reason_redundant", {"count": arm.n - needed}))
    return SpaceAdvice("joint_space", (*reasons, ("reason_free", {})))
