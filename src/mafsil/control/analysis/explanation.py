"""Laws, measures and plots of control for readers new to them: a formula, a paragraph and the works behind."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from mafsil.arrays import require_kind
from mafsil.control.contact.admittance import AdmittanceControl, ImpedanceByForce
from mafsil.control.contact.force import ForceControl
from mafsil.control.contact.hybrid import HybridControl
from mafsil.control.contact.impedance import ImpedanceControl
from mafsil.control.contact.tip_sensor import ContactSwitch
from mafsil.control.joints.friction_compensation import FrictionCompensation
from mafsil.control.joints.hardware_around import CurrentLoopLaw, Delayed, EncoderLoop
from mafsil.control.laws.adaptive import AdaptiveControl
from mafsil.control.laws.joint_feedback import ComputedTorque, Feedforward, JointFeedback
from mafsil.control.laws.matrix_feedback import MatrixFeedback
from mafsil.control.laws.optimal import LinearQuadratic, ModelPredictive
from mafsil.control.laws.sliding_mode import MinMax, SlidingMode
from mafsil.control.laws.task_coordinates import TaskCoordinates
from mafsil.control.laws.tip_motion import TaskComputedTorque
from mafsil.errors import InputError
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.messages import say
from mafsil.messages.quantities import digits, quantity
from mafsil.messages.visible import visible
from mafsil.robot import Robot, as_robot
from mafsil.toml_source import own_tables
from mafsil.trajectory import Trajectory


@dataclass(frozen=True, slots=True)
class Citation:
    """One work.

    Attributes:
        key: short name, such as `khatib1987`.
        authors, title, where: as one cites it.
        year: of publication.
        modules: of the package that follow it.
    """

    key: str
    authors: str
    title: str
    where: str
    year: int
    modules: tuple[str, ...]

    def __str__(self) -> str:
        return f"{self.authors}: {self.title}. {self.where}, {self.year}."

    def bibtex(self) -> str:
        """The entry for a bibliography in LaTeX."""
        return (
            f"@misc{{{self.key},\n  author = {{{self.authors.replace(', ', ' and ')}}},\n  title = {{{self.title}}},\n"
            f"  howpublished = {{{self.where}}},\n  year = {{{self.year}}}\n}}"
        )


_TOML = own_tables(__file__)
CITATIONS = tuple(Citation(key, **work | {"modules": tuple(work["modules"])}) for key, work in _TOML["works"].items())
"""All works, each with the modules that follow it or whose matter it treats."""
FORMULAS: dict[str, tuple[str, tuple[str, ...]]] = {
    name: (formula, tuple(works)) for name, (formula, *works) in _TOML["formulas"].items()
}
"""Of each law, measure, plot and space: its formula and the works behind it."""


def citation(key: str) -> Citation:
    """A work by its key.

    Raises:
        InputError: no such work.
    """
    found = {one.key: one for one in CITATIONS}
    if not isinstance(key, str) or key not in found:  # pyright: ignore[reportUnnecessaryIsInstance] - what users give
        raise InputError("input.choice", name="key", value=key, known=", ".join(found))
    return found[key]


def citations_of(module: str) -> tuple[Citation, ...]:
    """The works that a module follows.

    Args:
        module: its full name, such as `mafsil.control.hybrid`.
    """
    return tuple(one for one in CITATIONS if module in one.modules)


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
