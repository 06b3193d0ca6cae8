"""How planning of an arm ended: a path of proved motions, or what stands in the way and where."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil import trajectory
from mafsil.arrays import Floats, JointVector, positive, real_array, require_finite, whole
from mafsil.collision.status import SMALLEST_GAP
from mafsil.errors import InputError
from mafsil.lazy_module import lazily
from mafsil.messages import clauses, say
from mafsil.messages.quantities import quantity
from mafsil.planning.arm_limits import Moving, bounds_of
from mafsil.planning.kept_planning import Kept, Measured
from mafsil.planning.outcome import Plan, PlanningStatus

if TYPE_CHECKING:
    import mafsil.planning.path_optimisation as path_optimisation
    from mafsil.planning.path_optimisation import Descent
else:
    path_optimisation = lazily("mafsil.planning.path_optimisation")

if TYPE_CHECKING:
    from mafsil.collision import Checker, Clearance, CollisionCheck, ContactPair
    from mafsil.trajectory import JointPath, MotionLimits
    from mafsil.trajectory.timing import TimeOptimal


@dataclass(frozen=True, eq=False, repr=False)
class ArmPlan(Plan):
    """A verified collision-free path of an arm, or why there is none.

    Attributes:
        checker: the arm in its scene.
        ends: what the start or the goals meet, where that is the reason.
        proofs: motions that were proved or tried to be.
        goal: which of the goals the path leads to; -1 where there is no path.
        kept: what the path keeps, if something was to be kept.
        descent: how `optimise` made it, if it did.
        moving: joints that were named as free to move, if they were.
    """

    checker: Checker | None = None
    ends: tuple[CollisionCheck, ...] = ()
    proofs: int = 0
    goal: int = -1
    kept: Kept | None = None
    descent: Descent | None = None
    moving: Moving = None

    def kept_bounds(self) -> Floats:
        """(k,) largest angle [rad] or distance [m] of each constraint that the proof along the path leaves possible.

        Raises:
            InputError: there is no path.
        """
        if not self or self.checker is None:
            raise InputError("planning.no_path", why=self.explain())
        if self.kept is None:
            return np.zeros(0)
        worst = self.kept.along(self.checker, self.path[:-1], self.path[1:])
        assert worst is not None
        return Measured(self.kept, worst).amounts

    def at(self, s: ArrayLike) -> JointVector:
        """(*batch, n) configurations at shares 0..1 of the length of the path.

        Args:
            s: (*batch).

        Raises:
            InputError: a number that is not finite.
        """
        shares = require_finite("s", real_array("s", s))
        lengths = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(self.path, axis=0), axis=1))])
        places = shares * lengths[-1]
        columns: list[Floats] = [np.interp(places, lengths, self.path[:, k]) for k in range(self.path.shape[1])]
        return np.stack(columns, axis=-1)

    def clearance(self, count: int = 200) -> Clearance:
        """Smallest distances at places evenly along the path.

        Args:
            count: how many places.
        """
        assert self.checker is not None
        return self.checker.distance(self.at(np.linspace(0.0, 1.0, whole("count", count))))

    def optimise(
        self, *, enough_clearance: float = 0.03, smoothness: float = 0.0, points: int = 30, iterations: int = 100,
        seconds: float = 5.0,
    ) -> ArmPlan:  # fmt: skip
        """The path made shorter and smoother, away from obstacles, by gradients of distances; each motion proved free.

        The best that was proved stays when the budget ends, so the cost is never higher than that of this path.

        Args:
            enough_clearance: distance below which nearness costs [m].
            smoothness: weight of bending against length^2 / 2; 0 for the shortest.
            points: of the new path between its ends.
            iterations, seconds: the budget; equal iterations give equal paths where the time does not end it.

        Raises:
            InputError: there is no path; numbers out of range; a path that keeps constraints.
        """
        if not self or self.checker is None:
            raise InputError("planning.no_path", why=self.explain())
        if self.kept is not None:
            raise InputError("planning.optimise_kept")
        positive("enough_clearance", enough_clearance)
        positive("seconds", seconds)
        if not np.isfinite(smoothness) or smoothness < 0.0:
            raise InputError("input.range", name="smoothness", value=smoothness, low=0.0, high=np.inf)
        whole("points", points, least=1)
        whole("iterations", iterations, least=1)
        bounds = bounds_of(self.checker, self.path[[0, -1]], self.moving)
        descent = path_optimisation.descend(
            self.checker, self.path, bounds, enough_clearance, smoothness, points, iterations, seconds
        )
        return replace(self, path=descent.path, descent=descent)

    def joint_path(self, *, share: float = 0.5) -> JointPath:
        """The path with corners rounded as far as that is proved free; motions stop at corners that stay.

        Args:
            share: of the shorter leg that a corner may take, 0 to 0.5.

        Raises:
            InputError: there is no path; a share out of range.
        """
        if not self or self.checker is None:
            raise InputError("planning.no_path", why=self.explain())
        if not 0.0 <= share <= 0.5:
            raise InputError("input.range", name="share", value=share, low=0.0, high=0.5)
        return path_optimisation.round_corners(self.checker, self.path, share, self.kept)

    def time_optimal(self, limits: MotionLimits, *, share: float = 0.5) -> TimeOptimal:
        """The rounded path in the shortest time within limits: free at every moment, for it is the same path.

        Args:
            limits: of the joints; with a finite jerk, limited jerk.
            share: as for `joint_path`.

        Raises:
            InputError: there is no path; limits that do not fit.
        """
        return trajectory.time_optimal(self.joint_path(share=share), limits)

    def explain(self, language: str | None = None) -> str:
        """The status, what the ends meet, the account, and what was not checked."""
        more = say("planning.proofs", language=language, proofs=self.proofs)
        lines = [super().explain(language) + more]
        for k, check in enumerate(self.ends):
            at_start = self.status is PlanningStatus.START_BLOCKED
            which = say("planning.start_itself" if at_start else "planning.goal_number", language=language, number=k)
            contacts = clauses((each.sentence(language) for each in check.contacts), language)
            lines.append(say("planning.end_meets", language=language, which=which, contacts=contacts))
        own = self._own_pair()
        if own is not None:
            always = self.checker is not None and own.distance > 0.0 and self.checker.never_apart(own.first, own.second)
            key = "planning.own_always_near" if always else "planning.own_bodies"
            lines.append(say(key, language=language, first=own.first, second=own.second))
        lines += self._narrow(language)
        if self.descent is not None:
            before, after, steps = self.descent.before, self.descent.after, self.descent.iterations
            numbers = {"length": before.length, "shorter": after.length, "cost": before.total, "lower": after.total}
            lines.append(say("planning.optimised", language=language, steps=steps, **numbers))
        if self and self.kept is not None and self.checker is not None:
            worst = self.kept.along(self.checker, self.path[:-1], self.path[1:])
            lines += [] if worst is None else self.kept.sentences(worst, language)
        lines += [say(key, language=language) for key in self._unchecked()]
        if self and self.checker is not None and (endless := self.checker.robot.mechanism.endless):
            lines.append(say("collision.unchecked_range", language=language, joints=", ".join(endless)))
        return "\n".join(lines)

    def _unchecked(self) -> tuple[str, ...]:
        """Keys of sentences about what nobody looked at on the way; a path among nothing says so."""
        return self.checker.unchecked if self and self.checker is not None else ()

    def _narrow(self, language: str | None) -> list[str]:
        """That the path comes nearer to something than any arm should, if it does."""
        if not self or self.checker is None:
            return []
        near = self.clearance()
        distance = near.distance
        if not np.isfinite(distance).any() or distance.min() >= SMALLEST_GAP:
            return []
        nearest = list(near)[int(distance.argmin())].sentence(language)
        smallest = quantity(SMALLEST_GAP, "m")
        return [say("planning.narrow", language=language, nearest=nearest, smallest=smallest)]

    def _own_pair(self) -> ContactPair | None:
        """Two bodies of the robot itself that meet at an end, where nothing else meets there."""
        contacts = [contact for check in self.ends for contact in check.contacts]
        own = set[str]() if self.checker is None else {body.name for body in self.checker.bodies}
        return contacts[0] if contacts and all(each.second in own for each in contacts) else None

    def to_dict(self) -> dict[str, Any]:
        """Plain data."""
        ends = [check.to_dict() for check in self.ends]
        kept: dict[str, Any] = {"kept": self.kept_bounds().tolist()} if self and self.kept is not None else {}
        unchecked = [key.rpartition("_")[2] for key in self._unchecked()]
        return (
            super().to_dict() | {"proofs": self.proofs, "goal": self.goal, "ends": ends, "unchecked": unchecked} | kept
        )
