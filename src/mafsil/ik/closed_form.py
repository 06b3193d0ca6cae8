"""The closed form of an arm as a compiled kernel: all branches of whole batches of poses at once."""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil import kernels
from mafsil.arrays import Floats, JointVector
from mafsil.kernels import Kernel, Port, Signature
from mafsil.kernels.lazy import lazy
from mafsil.mechanics.arm_pattern import ArmPattern


@dataclass(frozen=True, eq=False)
class Branches:
    """All rows of a closed form, those included that solve nothing.

    Attributes:
        table: (*batch, branches, n + 3) rows (q, residual, shortfall, free).
    """

    table: Floats

    @property
    def q(self) -> JointVector:
        """(*batch, branches, n) joint coordinates; angles in (-pi, pi] [rad | m]."""
        return self.table[..., :-3]

    @property
    def residual(self) -> Floats:
        """(*batch, branches) distance and angle by which forward kinematics misses the pose, the larger [m | rad]."""
        return self.table[..., -3]

    @property
    def shortfall(self) -> Floats:
        """(*batch, branches) by how much the worst step misses [m | rad]."""
        return self.table[..., -2]

    @property
    def free(self) -> NDArray[np.int64]:
        """(*batch, branches) sum of 2^i over the coordinates i that are free."""
        return np.nan_to_num(self.table[..., -1]).astype(np.int64)

    def found(self, tolerance: float = 1e-9) -> NDArray[np.bool_]:
        """(*batch, branches) which rows solve the pose."""
        return self.residual <= tolerance


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """All solutions of an arm for a pose, by one kernel call.

    Attributes:
        pattern: what the arm was recognised as.
    """

    pattern: ArmPattern

    def solve(self, T: ArrayLike, near: ArrayLike | None = None) -> Branches:
        """All branches for poses of the tip.

        Args:
            T: (*batch, 4, 4) poses in {s}.
            near: (*batch, n) coordinates that free joints take; zero if None.
        """
        return Branches(self._kernel.call(T) if near is None else self._kernel_near.call(T, near))

    @property
    def kernel(self) -> Kernel:
        """Of T_sd to the table itself, for those who need every microsecond."""
        return self._kernel

    @lazy
    def _kernel(self) -> Kernel:
        return _compiled(self.pattern, False)

    @lazy
    def _kernel_near(self) -> Kernel:
        return _compiled(self.pattern, True)


def _compiled(pattern: ArmPattern, near: bool) -> Kernel:
    inputs = (Port("T_sd", (4, 4)), *((Port("near", (pattern.n,)),) if near else ()))
    shape = (pattern.branches, pattern.n + 3)
    return kernels.compile(
        Signature("closed_form", inputs, (Port("table", shape),)),
        partial(_build, pattern, near),
        key=f"{pattern.key} {near}",
        fingerprints=(kernels.fingerprint("mafsil.algebra", "mafsil.mechanics"),),
        recipe=(_compiled, (pattern, near)),
    )


def _build(pattern: ArmPattern, near: bool) -> Any:
    """The casadi.Function of a pattern; CasADi is loaded only when a kernel has to be made."""
    from mafsil.mechanics.closed_form_function import function

    return function(pattern, near)
