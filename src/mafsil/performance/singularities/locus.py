"""The singularity locus of an arm: every component of singular configurations, its condition, sampled and verified."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats
from mafsil.messages import say
from mafsil.performance.singularities.determinant import (
    LONGEST,
    DeterminantFactor,
    DeterminantFactors,
    determinant_factors,
)
from mafsil.performance.singularities.ranks import is_singular
from mafsil.performance.singularities.singular_configuration import Singularity, singularity
from mafsil.performance.tolerances import WITHIN
from mafsil.performance.velocity.scaling import TOLERANCE, random_configurations, ranges
from mafsil.robot import Robot, of_robot

SAMPLES = 64


@dataclass(frozen=True, eq=False)
class LocusComponent:
    """Configurations at which one factor of the determinant vanishes.

    Attributes:
        factor: which.
        joints: indices of the coordinates that the condition ties.
        condition: the equation in the coordinates, solved if it has only one unknown.
        samples: (k, n) configurations on it [rad | m], k = 0 if the factor never vanishes.
        verified: how many of the samples are singular by rank.
        within_limits: how many of the samples keep the joint limits.
        causes: names of the geometric cases seen at samples, with the joints' names.
    """

    robot: Robot
    factor: DeterminantFactor
    joints: tuple[int, ...]
    condition: str
    samples: Floats
    verified: int
    within_limits: int
    causes: tuple[str, ...]

    @property
    def empty(self) -> bool:
        """Whether the arm has no such configuration at all."""
        return not len(self.samples)

    def example(self) -> Singularity:
        """A close look at the first sample."""
        return singularity(self.robot, self.samples[0])

    def explain(self, language: str | None = None) -> str:
        """Condition, meaning, and how it was verified."""
        key = "component_empty" if self.empty else "component"
        return say(
            f"performance.{key}",
            language=language,
            condition=self.condition,
            meaning=self.factor.sentence(language),
            verified=self.verified,
            count=len(self.samples),
            within=self.within_limits,
            causes="; ".join(self.causes) or "-",
        )


class LocusStatus(Status):
    """Whether the sampled components are singular by rank too."""

    VERIFIED = ("performance.locus_verified", True)
    EMPTY = ("performance.locus_empty", True)
    """No configuration was found at which a factor vanishes."""
    NOT_VERIFIED = ("performance.locus_not_verified", False)


@dataclass(frozen=True, eq=False, repr=False)
class SingularityLocus(Answer, entries="components", data="components"):
    """All components of the singularity locus of an arm, iterable; true if every sample is singular by rank.

    Attributes:
        determinant: in factors; a configuration is singular exactly where one of them vanishes.
        components: one for each factor that depends on the configuration.
    """

    determinant: DeterminantFactors
    components: tuple[LocusComponent, ...]

    @property
    def verified(self) -> bool:
        """Whether every sample of every component is singular."""
        return all(component.verified == len(component.samples) for component in self.components)

    @property
    def status(self) -> LocusStatus:
        """From the counts of samples."""
        if not self.verified:
            return LocusStatus.NOT_VERIFIED
        return LocusStatus.EMPTY if all(component.empty for component in self.components) else LocusStatus.VERIFIED

    def explain(self, language: str | None = None) -> str:
        """The determinant, then the components, then how many samples are singular by rank."""
        lines = [f"{k}. {component.explain(language)}" for k, component in enumerate(self.components, 1)]
        verified, count = (
            sum(numbers)
            for numbers in zip((0, 0), *((c.verified, len(c.samples)) for c in self.components), strict=True)
        )
        last = self.status.sentence(language, verified=verified, count=count)
        return "\n".join([self.determinant.explain(language), *lines, last])

    def to_dict(self) -> dict[str, Any]:
        """Plain data; arrays are those of the components."""
        return Answer.to_dict(self) | {"factors": [factor.formula for factor in self.determinant.factors]}


@of_robot
def singularity_locus(
    robot: Robot, task: str | None = None, *, samples: int = SAMPLES, seed: int = 1
) -> SingularityLocus:
    """Every component of singular configurations of an arm with a square Jacobian.

    Args:
        robot: the arm: PUMA-like, UR, SCARA, Stanford, planar, and others whose determinant factors.
        task: as for `determinant_factors`.
        samples: configurations drawn on each component; all joint limits are left aside.
        seed: of the generator.

    Raises:
        InputError: the Jacobian is not square.
    """
    determinant = determinant_factors(robot, task)
    components = [
        _component(robot, determinant.task, factor, samples, seed)
        for factor in determinant.factors
        if factor.form is None or factor.form.joints
    ]
    return SingularityLocus(determinant, tuple(components))


def _component(robot: Robot, task: str, factor: DeterminantFactor, count: int, seed: int) -> LocusComponent:
    form = factor.form
    joints = tuple(range(robot.n)) if form is None else form.joints
    q = sample_locus(robot, factor, count, seed)
    singular = is_singular(robot, q, task=task, tolerance=10 * TOLERANCE) if len(q) else np.zeros(0, bool)
    lower, upper = ranges(robot)
    inside = ((q >= lower) & (q <= upper)).all(axis=-1)
    return LocusComponent(
        robot,
        factor,
        joints,
        _condition(robot, factor),
        q,
        int(singular.sum()),
        int(inside.sum()),
        _causes(robot, q[:6]) if task == "pose" else (),
    )


def sample_locus(robot: Robot, factor: DeterminantFactor, count: int, seed: int = 1) -> Floats:
    """Random configurations at which a factor vanishes: all coordinates drawn but one, which is solved for.

    Args:
        robot: the arm.
        factor: of its determinant, with a form in the coordinates.
        count: how many are wanted.
        seed: of the generator.

    Returns:
        (k, n), k <= count; none if the factor never vanishes or has no written form.
    """
    if factor.form is None or not factor.form.joints:
        return np.zeros((0, robot.n))
    rng = np.random.default_rng(seed)
    found: list[Floats] = []
    for trial in random_configurations(robot, 8 * count, seed, limited=False):
        joint = int(rng.choice(factor.form.joints))
        roots = factor.form.roots(trial, joint)
        if len(roots):
            trial[joint] = rng.choice(roots)
            found.append(trial)
        if len(found) == count:
            break
    return np.array(found).reshape(-1, robot.n)


def _condition(robot: Robot, factor: DeterminantFactor) -> str:
    form = factor.form
    if form is None:
        return f"{factor.formula} = 0"
    if len(form.joints) == 1:
        joint = form.joints[0]
        roots = form.roots(np.zeros(robot.n), joint)
        if len(roots):
            return f"q{joint + 1} = " + ", ".join(_number(x) for x in roots)
    return f"{form.text(LONGEST)} = 0"


def _number(x: float) -> str:
    """Multiples of a quarter turn by name."""
    quarters = x / (np.pi / 2)
    names = {0: "0", 1: "pi/2", 2: "pi", -1: "-pi/2", -2: "-pi"}
    return names[round(quarters)] if abs(quarters - round(quarters)) < WITHIN and abs(quarters) < 2.5 else f"{x:.6g}"


def _causes(robot: Robot, q: Floats) -> tuple[str, ...]:
    """The geometric cases at a few samples, each once."""
    seen: dict[str, None] = {}
    for configuration in q:
        for cause in singularity(robot, configuration, tolerance=10 * TOLERANCE).causes:
            number = f" ({cause.number})" if cause.number else ""
            seen[f"{cause.case}{number}: {', '.join(cause.names)}"] = None
    return tuple(seen)
