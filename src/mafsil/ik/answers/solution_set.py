"""All answers to one pose: joint vectors, their branches, families and limits, and the reason where there is none."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from itertools import islice, product
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil.algebra.tolerance import DESCRIBED
from mafsil.answer import Answer
from mafsil.arrays import Floats, JointVector, PoseMatrix, as_batch
from mafsil.floating_point import LEAST_DIVISOR
from mafsil.ik.answers.branch import Branch, angle_units, solution_table
from mafsil.ik.answers.candidate_table import CandidateTable
from mafsil.ik.answers.pose_question import LimitExcess, PoseQuestion, SolutionFamily, number_list
from mafsil.ik.answers.setting import Setting, folding, nearly_there, structure_decides
from mafsil.ik.refine import TURN
from mafsil.ik.result import IKStatus
from mafsil.ik.tolerances import FAR_ALONG, ON_LIMIT, SELF_MOTION, WHOLE_TURN
from mafsil.kernels.lazy import lazy
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.messages.tables import on_screen

if TYPE_CHECKING:
    import mafsil.ik.refine_loops as winding_loops
else:
    winding_loops = lazily("mafsil.ik.refine_loops")

ROUNDED_LIMIT = 1e-12
"""By how much a joint may seem beyond its limit by rounding, which is not said [rad | m]."""
SENTENCES = {
    IKStatus.SOLVED: "ik.set_solved",
    IKStatus.CONTINUUM: "ik.set_continuum",
    IKStatus.BEYOND_LIMITS: "ik.set_beyond_limits",
    IKStatus.OUT_OF_REACH: "ik.set_out_of_reach",
    IKStatus.NOT_OF_THIS_ARM: "ik.set_not_of_this_arm",
    IKStatus.NOT_FOUND: "ik.set_not_found",
    IKStatus.NOT_FOUND_WITHIN_LIMITS: "ik.set_not_found_within_limits",
}
"""How the answer to one pose explains a status, with its numbers."""


class SolutionSet(Answer, data="complete in_doubt method q residual within", entries="q"):
    """All solutions of one pose.

    What is not read costs nothing: branches, families and reasons are made when they are asked for.

    Attributes:
        q: (k, n) solutions, revolute joints wound into their limits where possible; joints that do not move the frame
            are where `q0` has them [rad | m].
        own: (k, m) the coordinates of the joints that move the frame.
        method: how they were found: `closed form`, `refined closed form`, `elimination`, `search`.
    """

    own: JointVector
    q: JointVector
    method = "closed form"
    # What a clear list is made of, see `clear_set`; sets with another origin carry what is computed from it.
    _ask: Callable[[SolutionSet], PoseQuestion]
    _setting: Setting
    _details: Floats
    _chosen: slice | NDArray[np.intp]
    _isolated = True
    # Whether no two branches meet: then solutions without a joint that may be chosen are isolated.
    _apart = False

    def __init__(
        self,
        question: PoseQuestion,
        q: JointVector,
        residual: Floats,
        within: NDArray[np.bool_],
        rows: NDArray[np.int64],
        codes: NDArray[np.int64],
        free: NDArray[np.int64],
        *,
        method: str,
        complete: bool | None,
        isolated: bool,
    ) -> None:
        part = question.setting.part
        self.own, self.q = q, q if part.places is None else part.lift(q, question.others)
        self.method, self._setting, self._isolated = method, question.setting, isolated
        # Set here, these stand in front of the properties that compute them.
        vars(self).update(residual=residual, within=within, rows=rows, codes=codes, own_free=free, _question=question)
        if complete is not None:
            vars(self)["complete"] = complete

    def __bool__(self) -> bool:
        return bool(self.within.any())

    def __repr__(self) -> str:
        return self.printed()

    def printed(self, *, degrees: bool = False) -> str:
        """The sentences and a row for each solution.

        Args:
            degrees: angles in degrees.
        """
        return on_screen("\n".join([self.explain(degrees=degrees), *self._table(degrees)]))

    def _table(self, degrees: bool = False) -> list[str]:
        return solution_table(self.q, self.branches, self.residual, self.within, self.revolute, degrees=degrees)

    @lazy
    def residual(self) -> Floats:
        """(k,) error of forward kinematics, the larger of distance [m] and angle [rad]."""
        return CandidateTable.of(self._details).residual[self._chosen]

    @lazy
    def within(self) -> NDArray[np.bool_]:
        """(k,) whether the solution is within the joint limits."""
        return np.asarray(CandidateTable.of(self._details).excess[self._chosen] <= ON_LIMIT, dtype=np.bool_)

    @lazy
    def rows(self) -> NDArray[np.int64]:
        """(k,) row of the closed form's table that each solution is; -1 if found otherwise."""
        return np.arange(len(self._details))[self._chosen]

    @lazy
    def codes(self) -> NDArray[np.int64]:
        """(k,) roots of the closed form that each is, as a number, see `mafsil.mechanics.closed_form.table`."""
        return CandidateTable.of(self._details).code[self._chosen].astype(np.int64)

    @lazy
    def own_free(self) -> NDArray[np.int64]:
        """(k,) sum of 2^i over those of the part's own coordinates that may be chosen."""
        if self._isolated or not len(self.own):
            return np.zeros(len(self.own), dtype=np.int64)
        return self._question.free_of(self.own, CandidateTable.of(self._details[self._chosen]))

    @lazy
    def complete(self) -> bool:
        """Whether it is proven that there are no further solutions and families."""
        if self._isolated or not len(self.own):
            return self._isolated or self._setting.decisive or self._question.proven(0)
        exact = "_details" in vars(self)
        known = exact and self._question.list_known(CandidateTable.of(self._details[self._chosen]))
        return known or self._question.proven(len(self.own))

    @lazy
    def in_doubt(self) -> bool:
        """Whether a description of six digits leaves the count open: the arm that was meant may have another one."""
        setting, asked = self._setting, self._question
        if structure_decides(setting) or folding(setting, self.own).any():
            return True
        if setting.arm.form is None and not len(self.own):
            return bool(asked.refusal.residual <= DESCRIBED * max(1.0, setting.length))
        return bool(nearly_there(setting, asked.T[None], asked.start_q0)[0])

    @lazy
    def _question(self) -> PoseQuestion:
        """The question that it answers; that of a clear list is made when something is asked of it."""
        return self._ask(self)

    @lazy
    def free(self) -> NDArray[np.int64]:
        """(k,) sum of 2^i over the coordinates that may be chosen."""
        return np.asarray(self._setting.part.lifted_bits(self.own_free), dtype=np.int64)

    @lazy
    def branches(self) -> tuple[Branch, ...]:
        """Of each solution."""
        names = self._setting.branch_names
        return (Branch(),) * len(self.own) if names is None else names.branches(self.own, self.rows)

    @lazy
    def families(self) -> tuple[SolutionFamily, ...]:
        """Continua through some of the solutions."""
        if self._isolated or not len(self.q) or (self._apart and not self.own_free.any()):
            return ()
        return tuple(self._question.families(self.own, self.rows, self.own_free))

    @lazy
    def status(self) -> IKStatus:
        """What can be said."""
        if not len(self.q):
            return self._question.verdict
        moving = not self._isolated and (bool(self.own_free.any()) or len(self.families) > 0)
        if self.within.any():
            return IKStatus.CONTINUUM if moving else IKStatus.SOLVED
        # Where the closed form's own free joints are, it has decided that none of their values leads into the limits.
        decided = "_details" in vars(self) and bool((CandidateTable.of(self._details).free[self._chosen] > 0).any())
        proven = (self.complete and not moving) or decided or self._question.refuted
        return IKStatus.BEYOND_LIMITS if proven else IKStatus.NOT_FOUND_WITHIN_LIMITS

    @lazy
    def details(self) -> Mapping[str, object]:
        """What the sentence of the status mentions."""
        counts = {"count": len(self.q), "allowed": int(self.within.sum()), "families": len(self.families)}
        if not len(self.q):
            return {**counts, **self._question.refusal.details}
        if self.within.any():
            return counts
        return {**counts, **self._question.tried, **self._worst()}

    def _worst(self, *, degrees: bool = False) -> dict[str, object]:
        """The joint that is farthest beyond its limit [rad | m] in the solution that is nearest to the limits."""
        k, _ = max(enumerate(self.violations(self._least_beyond)), key=lambda one: one[1].excess)
        found = vars(self.violations(self._least_beyond, degrees=degrees)[k])
        return {"bound" if name == "limit" else name: value for name, value in found.items()}

    @lazy
    def q_nearest(self) -> JointVector:
        """(n,) the best solution; where there is none, the configuration of the nearest pose that was found."""
        if not len(self.q):
            return self._setting.part.lift(self._question.refusal.q, self._question.others)
        return self.q[int(np.flatnonzero(self.within)[0])] if self.within.any() else self.q[self._least_beyond]

    @lazy
    def T_nearest(self) -> PoseMatrix:
        """(4, 4) pose of `q_nearest`."""
        part = self._setting.part
        return self._setting.robot.forward_kinematics(part.own(self.q_nearest))

    @lazy
    def conditioning(self) -> Floats:
        """(k,) smallest over largest singular value of the Jacobian, lengths in units of the arm's reach.

        Zero at a singular configuration.
        """
        if not len(self.q):
            return np.zeros(0)
        setting = self._setting
        values = np.linalg.svd(setting.scaled_jacobians(self.own), compute_uv=False)
        return values[:, min(int(setting.mask.sum()), setting.robot.n) - 1] / np.maximum(values[:, 0], LEAST_DIVISOR)

    @property
    def own_names(self) -> tuple[str, ...]:
        """Names of the joints that move the frame."""
        return self._setting.robot.joint_names

    @property
    def lower(self) -> Floats:
        """(n,) limits."""
        return self._setting.part.lower

    @property
    def upper(self) -> Floats:
        """(n,) limits."""
        return self._setting.part.upper

    @property
    def revolute(self) -> NDArray[np.bool_]:
        """(n,) which coordinates are angles."""
        return self._setting.part.revolute

    def violations(self, k: int, *, degrees: bool = False) -> tuple[LimitExcess, ...]:
        """The joints that a solution needs beyond their limits; empty if it is within.

        Args:
            k: index of the solution.
            degrees: angles in degrees.
        """
        setting, q = self._setting, self.own[k]
        limit = np.where(q < setting.lower, setting.lower, setting.upper)
        excess = np.maximum(setting.lower - q, q - setting.upper)
        scale, units = angle_units(setting.revolute, degrees=degrees)
        return tuple(
            LimitExcess(
                setting.robot.joint_names[i],
                float(scale[i] * q[i]),
                float(scale[i] * limit[i]),
                float(scale[i] * excess[i]),
                units[i],
            )
            for i in np.flatnonzero(excess > ON_LIMIT).tolist()
        )

    def dependent(self, k: int) -> tuple[str, ...]:
        """Names of the joints whose axes depend on each other at a solution: it is singular; empty if it is regular.

        Args:
            k: index of the solution.
        """
        setting = self._setting
        _, values, Vt = np.linalg.svd(setting.scaled_jacobians(self.own[k : k + 1])[0])
        null = Vt[int((values > SELF_MOTION * values[0]).sum()) :]
        excess = max(0, setting.robot.n - int(setting.mask.sum()))
        if len(null) <= excess:
            return ()
        motion = np.linalg.norm(null, axis=0)
        return tuple(name for name, x in zip(setting.robot.joint_names, motion, strict=True) if x > FAR_ALONG)

    def explain(self, language: str | None = None, *, degrees: bool = False) -> str:
        """The answer in sentences: how many solutions, which continua, why none, whether the list is complete.

        Args:
            language: `en` or `ar`; the current one if None.
            degrees: angles in degrees.
        """
        details = dict(self.details)
        if not len(self.q):
            details |= self._question.refusal.words(language, degrees=degrees)
        elif "bound" in details:
            details |= self._worst(degrees=degrees)
        lines = [say(SENTENCES[self.status], language=language, **details)]
        if not len(self.q):
            lines += [say(key, language=language, **details) for key in self._question.refusal.steps]
        alike: dict[tuple[str, str], list[int]] = {}
        lines += self._on_limits(language, degrees)
        for family in self.families:
            alike.setdefault((family.joint, ", ".join(family.moving)), []).append(family.solution + 1)
        for (joint, moving), solutions in alike.items():
            details = {"joint": joint, "moving": moving, "solutions": number_list(solutions)}
            lines.append(say("ik.family", language=language, **details))
        if not self._isolated:
            lines.extend(self._singular(language))
        method = say(f"ik.method_{self.method.replace(' ', '_')}", language=language)
        if len(self.q) or self.complete:
            lines.append(say("ik.complete" if self.complete else "ik.not_proven", language=language, method=method))
        if self.in_doubt:
            lines.append(say("ik.in_doubt", language=language))
        return "\n".join(lines)

    def _on_limits(self, language: str | None, degrees: bool) -> list[str]:
        """Solutions that count as within the limits though joints lie a measured number beyond them."""
        excess = np.maximum(self._setting.lower - self.own, self.own - self._setting.upper)
        most = excess.max(axis=1, initial=-np.inf)
        on = np.flatnonzero(self.within & (most > ROUNDED_LIMIT))
        if not len(on):
            return []
        i = int(excess[on[most[on].argmax()]].argmax())
        scale, units = angle_units(self._setting.revolute, degrees=degrees)
        details = {"solutions": number_list((on + 1).tolist()), "joint": self._setting.robot.joint_names[i]}
        details |= {"excess": float(most[on].max() * scale[i]), "measured": ON_LIMIT * scale[i], "unit": units[i]}
        return [say("ik.on_limits", language=language, **details)]

    def to_dict(self) -> dict[str, Any]:
        """Plain data; arrays are those of the answer."""
        return Answer.to_dict(self) | {
            "solved": bool(self),
            "branches": [str(one) for one in self.branches],
            "free": [family.joint for family in self.families],
        }

    def nearest(self, q: ArrayLike) -> JointVector:
        """(n,) the solution nearest to a configuration, wound as near as the limits allow; within the limits if any is.

        Joints that do not move the frame stay where the configuration has them.

        Raises:
            InputError: a wrong shape.
            IndexError: there is no solution.
        """
        given, setting = as_batch("q", q, (self.q.shape[-1],), finite=True), self._setting
        if not len(self.own):
            raise IndexError
        start, valid = setting.part.own(given)[None], np.ones((1, len(self.own)), dtype=np.bool_)
        nearest = winding_loops.nearest_rows(
            self.own[None], valid, start, setting.lower, setting.upper, setting.revolute
        )
        return setting.part.lift(nearest[0], given)

    def multi_turn_solutions(self, limit: int = 4096) -> JointVector:
        """(m, n) every solution within the limits, with every whole turn that its joints have room for.

        Joints without limits are not turned.

        Args:
            limit: most rows to return.
        """
        choices = ([self._turns(float(x), i) for i, x in enumerate(q)] for q in self.own[self.within])
        rows = list(islice((row for one in choices for row in product(*one)), limit))
        own = np.reshape(rows, (-1, self.own.shape[-1]))
        return self._setting.part.lift(own, self._question.others)

    @property
    def _least_beyond(self) -> int:
        """The solution that leaves the limits least."""
        setting = self._setting
        excess = np.maximum(np.maximum(setting.lower - self.own, self.own - setting.upper), 0.0)
        return int(excess.max(axis=1).argmin())

    def _singular(self, language: str | None) -> list[str]:
        """A sentence for every group of joints whose axes depend on each other."""
        alike: dict[tuple[str, ...], list[int]] = {}
        for k in range(len(self.q)):
            if joints := self.dependent(k):
                alike.setdefault(joints, []).append(k + 1)
        return [
            say("ik.singular", language=language, solutions=number_list(which), joints=", ".join(joints))
            for joints, which in alike.items()
        ]

    def _turns(self, x: float, i: int) -> list[float]:
        setting = self._setting
        low, high = setting.lower[i], setting.upper[i]
        if not setting.revolute[i] or not (np.isfinite(low) and np.isfinite(high)):
            return [x]
        first, last = int(np.ceil((low - x) / TURN - WHOLE_TURN)), int(np.floor((high - x) / TURN + WHOLE_TURN))
        return [x + k * TURN for k in range(first, last + 1)]
