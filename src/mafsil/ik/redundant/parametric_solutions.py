"""Configurations of seven coordinates at values of the free parameter, as an answer: how many, within which limits."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector
from mafsil.ik.tolerances import REACHED
from mafsil.messages import say
from mafsil.messages.tables import on_screen, table


class ParameterStatus(Status):
    """What was found at the values of the parameter; it says nothing about other values."""

    FOUND = ("ik.parameter_found", True)
    BEYOND_LIMITS = ("ik.parameter_beyond_limits", False)
    NOT_FOUND = ("ik.parameter_not_found", False)


STATUSES = tuple(ParameterStatus)
_MEMBERS = np.array(STATUSES, dtype=np.object_)


@dataclass(frozen=True, eq=False, repr=False)
class ParametricSolutions(Answer, data="values q residual within labelled"):
    """Configurations at values of the free parameter: true if every pose has one within the limits.

    Attributes:
        values: (*batch, m) of the parameter [rad | m].
        q: (*batch, m, branches, 7) joint coordinates, wound into the limits where possible; NaN where there is none.
        residual: (*batch, m, branches) by which forward kinematics misses the pose; NaN where there is none.
        within: (*batch, m, branches) whether the configuration is one, and within the joint limits.
        labelled: whether a branch keeps its place along the parameter.
    """

    values: Floats
    q: JointVector
    residual: Floats
    within: NDArray[np.bool_]
    labelled: bool

    @property
    def solved(self) -> NDArray[np.bool_]:
        """(*batch,) which poses have a configuration within the limits."""
        return np.asarray(self.within.any(axis=(-2, -1)), dtype=np.bool_)

    @property
    def exists(self) -> NDArray[np.bool_]:
        """(*batch, m, branches) where there is a configuration, within the limits or not."""
        return np.asarray(self.residual <= REACHED, dtype=np.bool_)

    @property
    def status(self) -> Any:
        """What was found, a member of `ParameterStatus`; of a batch an array (*batch,) of them."""
        codes = np.where(self.solved, 0, np.where(self.exists.any(axis=(-2, -1)), 1, 2))
        return STATUSES[int(codes)] if not codes.ndim else _MEMBERS[codes]

    def __bool__(self) -> bool:
        return bool(self.solved.all())

    def __len__(self) -> int:
        return len(self.values) if self.values.ndim > 1 else 1

    def __iter__(self) -> Iterator[ParametricSolutions]:
        if self.values.ndim == 1:
            return iter((self,))
        rows = zip(self.values, self.q, self.residual, self.within, strict=True)
        return (ParametricSolutions(*row, self.labelled) for row in rows)

    def explain(self, language: str | None = None) -> str:
        """How many configurations there are, and how many within the limits; of a batch, how many poses have one."""
        if self.values.ndim > 1:
            solved, count = int(self.solved.sum()), self.solved.size
            return say("ik.parameter_batch", language=language, solved=solved, count=count)
        counts = {"count": int(self.exists.sum()), "allowed": int(self.within.sum()), "values": len(self.values)}
        return self.status.sentence(language, **counts)

    def __repr__(self) -> str:
        if self.values.ndim > 1:
            return on_screen(self.explain())
        head = [say(f"ik.column_{name}") for name in ("value", "solutions", "allowed", "residual")]
        rows = [
            [f"{value:.4f}", str(int(at.sum())), str(int(allowed.sum())), f"{off[at].max(initial=0.0):.0e}"]
            for value, at, allowed, off in zip(self.values, self.exists, self.within, self.residual, strict=True)
        ]
        return on_screen("\n".join([self.explain(), *table(head, rows)]))
