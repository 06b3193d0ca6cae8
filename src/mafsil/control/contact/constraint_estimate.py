"""What a tip learns of its surroundings by force: the directions that are blocked, and efforts for a known contact."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, real_array, require_finite, require_kind
from mafsil.control.contact.environment import Environment, tip_wrench_of
from mafsil.control.laws.law import Law
from mafsil.errors import InputError
from mafsil.robot import Robot, of_robot
from mafsil.trajectory import Motion

SPARE = 4.0
"""Added to sqrt(k) + sqrt(m), above which noise alone gets with a probability below exp(-8)."""


class EstimatedConstraintStatus(Status):
    """Whether any direction is blocked."""

    BLOCKED = ("control.felt_blocked", True)
    NOTHING = ("control.felt_nothing", False)


@dataclass(frozen=True, eq=False, repr=False)
class EstimatedConstraint(Answer, data="A sizes samples"):
    """The directions along which forces were felt; true if there are some.

    Attributes:
        status: BLOCKED or NOTHING.
        A: (r, m) rows of unit length that span the forces that were felt: A V = 0 for what moves without friction.
        sizes: (m,) decreasing: how far the forces stand out along each principal direction, as share of what noise
            alone could do.
        samples: how many forces were seen.
    """

    status: EstimatedConstraintStatus
    A: Floats
    sizes: Floats
    samples: int

    def explain(self, language: str | None = None) -> str:
        """How many directions, and how clearly."""
        r = len(self.A)
        clear = float(self.sizes[r - 1]) if r else float(self.sizes[0])
        return self.status.sentence(language, count=r, of=len(self.sizes), clear=clear, samples=self.samples)


def estimate_contact_constraint(forces: ArrayLike, noise: ArrayLike) -> EstimatedConstraint:
    """The blocked directions of a contact without friction, from forces that a sensor measured.

    Algorithm:
        1. Forces are divided by the noise of their components, so that newtons and newton metres compare.
        2. The singular values of all of them are held against what noise alone gives, sqrt(k) + sqrt(m) and a margin.
        3. The directions above are what the environment pushes along. One that was never pressed is not found.

    Args:
        forces: (k, m) measured, k samples along a motion, without the weight of the tool.
        noise: standard deviations, a number or (m,), above zero.

    Raises:
        InputError: a wrong shape, a number that is not finite, noise that is not positive.

    Reference: Davidson and Silverstein, Local operator theory, random matrices and Banach spaces, 2001, th. II.13, for
        the bound; Bruyninckx and De Schutter, IEEE Trans. Robotics and Automation 12(4), 1996, for the task.
    """
    given = require_finite("forces", real_array("forces", forces))
    if given.ndim != 2 or not given.size:
        raise InputError("input.shape", name="forces", expected="(k, m)", got=given.shape, hint="")
    k, m = given.shape
    spread = require_finite("noise", real_array("noise", noise))
    if spread.shape not in ((), (m,)):
        raise InputError("input.shape", name="noise", expected=(m,), got=spread.shape, hint="")
    if not (spread > 0.0).all():
        raise InputError("input.positive", name="noise", value=float(spread.min()))
    # 1
    _, values, rows = np.linalg.svd(given / spread, full_matrices=False)
    # 2
    sizes = np.zeros(m)
    sizes[: len(values)] = values / (np.sqrt(k) + np.sqrt(m) + SPARE)
    # 3
    A = rows[: int((sizes > 1.0).sum())] * spread
    A = A / np.linalg.norm(A, axis=1, keepdims=True)
    return EstimatedConstraint(
        EstimatedConstraintStatus.BLOCKED if len(A) else EstimatedConstraintStatus.NOTHING, A, sizes, k
    )


@dataclass(frozen=True, eq=False, slots=True)
class ContactFeedforward:
    """tau = M(u) a + c(u, v) + g(u) - J(u)' F(u, v): the efforts of the reference, what it touches included.

    Attributes:
        robot: the model.
        environment: the model of what the tip touches.
    """

    robot: Robot
    environment: Environment

    def __call__(self, t: float, q: JointVector, qd: JointVector, reference: Motion) -> JointVector:
        """Joint efforts (*batch, n) [N m | N]."""
        u, v, a = reference
        wrench = tip_wrench_of(self.robot, self.environment, u, v)
        return self.robot.inverse_dynamics(u, v, a, -wrench) + 0.0 * q

    def session(self, period: float) -> Law:
        """The law itself: it has no memory."""
        return self


@of_robot
def contact_feedforward(robot: Robot, environment: Environment) -> ContactFeedforward:
    """The efforts that a model of arm and environment needs for a reference; combine it with feedback.

    Args:
        robot: the model.
        environment: what the tip touches, such as a `Wall` or a `SpringDamper`.

    Reference: Lynch and Park, Modern Robotics, sec. 11.4.1.
    """
    require_kind("environment", environment, "Environment", "wrench")
    return ContactFeedforward(robot, environment)
