"""All answers to one pose: joint vectors, their branches, families and limits, and the reason where there is none."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from itertools import product
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.arrays import Floats, JointVector, PoseMatrix, gate
from mafsil.messages import say
from mafsil.solvers import Status

TURN = 2 * np.pi


class Verdict(Status):
    """What can be said about a pose."""

    SOLVED = ("ik.set_solved", True)
    CONTINUUM = ("ik.set_continuum", True)
    BEYOND_LIMITS = ("ik.set_beyond_limits", False)
    OUT_OF_REACH = ("ik.set_out_of_reach", False)
    NOT_OF_THIS_ARM = ("ik.set_not_of_this_arm", False)
    NOT_FOUND = ("ik.set_not_found", False)


class Branch(NamedTuple):
    """Which root of each step a solution is: `+` or `-`, empty where the arm has no such step.

    Attributes:
        shoulder: of the step that places the first joints.
        elbow: of the step that sets the distance.
        wrist: of the wrist.
    """

    shoulder: str = ""
    elbow: str = ""
    wrist: str = ""

    def __str__(self) -> str:
        return "".join((self.shoulder, self.elbow, self.wrist)) or "-"


@dataclass(frozen=True, eq=False)
class SolutionFamily:
    """A continuum of solutions.

    Attributes:
        solution: index of the member in the solution set.
        joint: name of the joint that may be chosen.
        moving: names of the joints that move within the family.
        rates: (n,) their rates along the family at the member, that of `joint` one [rad | m per rad | m].
        member: solution (n,) with the joint at a value; NaN where the family does not go so far.
    """

    solution: int
    joint: str
    moving: tuple[str, ...]
    rates: JointVector
    member: Callable[[float], JointVector]

    def relation(self) -> str:
        """How the joints move together near the member, such as `joint6 = -1 joint4 + const`."""
        others = [(name, rate) for name, rate in zip(self.moving, self.rates[self.rates != 0.0], strict=True)]
        return ", ".join(f"{name}: {rate:+.6g}" for name, rate in others)


@dataclass(frozen=True, eq=False)
class SolutionSet:
    """All solutions of one pose.

    Attributes:
        q: (k, n) solutions, turning joints wound into their limits where possible [rad | m].
        branches: of each solution.
        status: what can be said.
        families: continua through some of the solutions.
        residual: (k,) distance [m] and angle [rad] by which forward kinematics misses the pose, the larger.
        complete: whether it is proven that there are no further solutions and families.
        conditioning: (k,) smallest over largest singular value of the Jacobian, lengths in units of the arm's reach;
            zero at a singular posture.
        within: (k,) whether the solution is within the joint limits.
        q_nearest: (n,) where there is no solution, the best posture that was found.
        T_nearest: (4, 4) its pose.
        method: name of the road that was taken: `closed form`, `refined closed form`, `elimination`, `search`.
        facts: what the sentence of the status mentions.
    """

    q: JointVector
    branches: tuple[Branch, ...]
    status: Verdict
    families: tuple[SolutionFamily, ...]
    residual: Floats
    complete: bool
    conditioning: Floats
    within: NDArray[np.bool_]
    q_nearest: JointVector
    T_nearest: PoseMatrix
    method: str
    lower: Floats
    upper: Floats
    turning: NDArray[np.bool_]
    facts: Mapping[str, object] = field(default_factory=dict[str, object])

    def __len__(self) -> int:
        return len(self.q)

    def __bool__(self) -> bool:
        return self.status.succeeded

    def explain(self, language: str | None = None) -> str:
        """The answer in sentences: how many solutions, which continua, why none, whether the list is complete."""
        lines = [self.status.sentence(language, **self.facts)]
        alike: dict[tuple[str, str], list[str]] = {}
        for family in self.families:
            alike.setdefault((family.joint, ", ".join(family.moving)), []).append(str(family.solution + 1))
        for (joint, moving), solutions in alike.items():
            facts = {"joint": joint, "moving": moving, "solutions": ", ".join(solutions)}
            lines.append(say("ik.family", language=language, **facts))
        method = say(f"ik.method_{self.method.replace(' ', '_')}", language=language)
        lines.append(say("ik.complete" if self.complete else "ik.not_proven", language=language, method=method))
        return "\n".join(lines)

    def nearest(self, q: ArrayLike) -> JointVector:
        """(n,) the solution nearest to a configuration, wound as near as the limits allow; within the limits if any is.

        Raises:
            InputError: a wrong shape.
            IndexError: there is no solution.
        """
        start = gate("q", q, (self.q.shape[-1],), finite=True)
        wound = wound_near(self.q, start, self.lower, self.upper, self.turning)
        allowed = ((wound >= self.lower) & (wound <= self.upper)).all(axis=1)
        cost = np.linalg.norm(wound - start, axis=1) + np.where(allowed, 0.0, 1e6)
        return wound[int(cost.argmin())]

    def windings(self, limit: int = 4096) -> JointVector:
        """(m, n) every solution within the limits, each winding of its turning joints apart.

        Joints without limits are not wound.

        Args:
            limit: most rows to return.
        """
        rows: list[tuple[float, ...]] = []
        for q in self.q[self.within]:
            choices = [self._turns(float(x), i) for i, x in enumerate(q)]
            for row in product(*choices):
                if len(rows) == limit:
                    return np.array(rows)
                rows.append(row)
        return np.reshape(rows, (-1, self.q.shape[-1]))

    def _turns(self, x: float, i: int) -> list[float]:
        low, high = self.lower[i], self.upper[i]
        if not self.turning[i] or not (np.isfinite(low) and np.isfinite(high)):
            return [x]
        first, last = int(np.ceil((low - x) / TURN - 1e-12)), int(np.floor((high - x) / TURN + 1e-12))
        return [x + k * TURN for k in range(first, last + 1)]


def wound_near(
    q: JointVector, near: JointVector, lower: Floats, upper: Floats, turning: NDArray[np.bool_]
) -> JointVector:
    """Turning joints moved by whole turns as near to `near` as possible, into the limits where that can be done.

    Args:
        q, near: (*batch, n) coordinates.
        lower, upper: (n,) limits.
        turning: (n) which coordinates are angles.
    """
    moved = q - np.where(turning, TURN * np.round((q - near) / TURN), 0.0)
    up = np.where(turning & (moved < lower), np.ceil((lower - moved) / TURN - 1e-12), 0.0)
    down = np.where(turning & (moved > upper), np.ceil((moved - upper) / TURN - 1e-12), 0.0)
    shifted = moved + TURN * (up - down)
    return np.where((shifted >= lower - 1e-12) & (shifted <= upper + 1e-12), shifted, moved)
