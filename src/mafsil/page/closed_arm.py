"""What a page knows of a robot with loops: driven joints that may be moved, and what the others do then."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from mafsil.arrays import Floats, JointVector
from mafsil.kernels.lazy import lazy
from mafsil.lazy_module import lazily
from mafsil.mechanics.loop_terms import Holding
from mafsil.robot import Robot

if TYPE_CHECKING:
    import mafsil.parallel as parallel
    import mafsil.parallel.closed_choice as closed_choice
    import mafsil.parallel.closed_kernels as closed_kernels
    import mafsil.parallel.closing as closing
    from mafsil.kernels import Kernel
    from mafsil.parallel import ClosedChain
else:
    parallel = lazily("mafsil.parallel")
    closed_choice = lazily("mafsil.parallel.closed_choice")
    closed_kernels = lazily("mafsil.parallel.closed_kernels")
    closing = lazily("mafsil.parallel.closing")

STRIDE = 0.02
"""Way of a driven joint at once [rad | m]: Newton's method finds the other joints from where they were before."""
PATIENCE = 4
"""Calls for one stride, each of some steps with one matrix."""
DECIDED = 1e-6
"""Smallest singular value of conditions of the loops that are independent."""


@dataclass(frozen=True, eq=False)
class ClosedArm:
    """The loops of a robot.

    Attributes:
        robot: with loops.
    """

    robot: Robot

    @lazy
    def chain(self) -> ClosedChain:
        """Its closed chain."""
        return parallel.ClosedChain(self.robot)

    def start(self, q: JointVector) -> JointVector:
        """(n,) the configuration with closed loops that is found from q; the nearest to it where none is found."""
        return np.asarray(self.chain.closed(q).q, dtype=np.float64)

    def driven(self, q: JointVector) -> list[int]:
        """Driven joints that move all others, the best of them where there are too many; none where they do not.

        Args:
            q: (n,) with closed loops.
        """
        chain = self.chain
        if not len(chain.actuated) or not chain.closed(q):
            return []
        J: Floats = np.asarray(chain.terms(q).J)
        freedoms = chain.n - int(np.linalg.matrix_rank(J * chain.unit, tol=DECIDED))
        deciding = closed_choice.deciding_joints(J[None], chain.actuated, freedoms)
        if deciding is None or len(deciding) < freedoms:
            return []
        return sorted(int(chain.actuated[k]) for k in deciding)

    def kernels(self, q: JointVector, *, masses: bool) -> Mapping[str, Kernel]:
        """Of (guess, motion of the moved joints) to that of all joints; of (q, qd, qdd) to efforts of the driven ones.

        Args:
            q: (n,) with closed loops.
            masses: whether efforts mean something.
        """
        driven, holding = self.driven(q), self.chain.holding(q) if masses else None
        moved = holding or self._without_masses(q)
        if not driven or moved is None:
            return {}
        moved = replace(moved, driven=tuple(driven))
        found = {"closed_following": closed_kernels.following_kernel(self.robot.mechanism, moved)}
        if holding is not None and holding.deciding:
            found["closed_efforts"] = closed_kernels.inverse_kernel(self.robot.mechanism, holding)
        return found

    def _without_masses(self, q: JointVector) -> Holding | None:
        """How the loops hold the robot at q, where no masses say which rows are better."""
        J: Floats = np.asarray(self.chain.terms(q).J)[None]
        rows = closed_choice.independent_rows(np.eye(self.chain.n)[None], J)
        return None if rows is None else Holding(rows, (), (), closing.CLOSED * self.chain.size)
