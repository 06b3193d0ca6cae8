"""The closed form of an arm as a compiled kernel: all branches of whole batches of poses at once."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil import kernels
from mafsil.arrays import Floats, JointVector
from mafsil.kernels import Port, Signature
from mafsil.kernels.lazy import lazy
from mafsil.lazy_module import lazily
from mafsil.mechanics.arm_pattern import ArmPattern

if TYPE_CHECKING:
    import mafsil.mechanics.closed_form.parametric as function
    from mafsil.kernels import Kernel
else:
    function = lazily("mafsil.mechanics.closed_form.parametric")


@dataclass(frozen=True, eq=False)
class Branches:
    """All rows of a closed form, those included that solve nothing.

    Attributes:
        table: (*batch, branches, n + 3) rows (q, residual, subproblem residual, free).
    """

    table: Floats

    @property
    def q(self) -> JointVector:
        """(*batch, branches, n) joint coordinates; angles in (-pi, pi] [rad | m]."""
        return self.table[..., :-3]

    @property
    def residual(self) -> Floats:
        """(*batch, branches) error of forward kinematics, the larger of distance and angle [m | rad]."""
        return self.table[..., -3]

    @property
    def subproblem_residual(self) -> Floats:
        """(*batch, branches) residual of the worst subproblem, zero where all are solved [m | rad]."""
        return self.table[..., -2]

    @property
    def free(self) -> NDArray[np.int64]:
        """(*batch, branches) sum of 2^i over the coordinates i that are free."""
        return np.nan_to_num(self.table[..., -1]).astype(np.int64)

    def solves_pose(self, tolerance: float = 1e-9) -> NDArray[np.bool_]:
        """(*batch, branches) which rows solve the pose."""
        return self.residual <= tolerance


@dataclass(frozen=True, eq=False)
class ClosedForm:
    """All solutions of an arm for a pose, by one kernel call.

    Attributes:
        pattern: what the arm was recognised as.
    """

    pattern: ArmPattern

    def solve(self, T: ArrayLike, q0: ArrayLike | None = None) -> Branches:
        """All branches for poses of the tip.

        Args:
            T: (*batch, 4, 4) poses in {s}.
            q0: (*batch, n) coordinates that free and locked joints take; zero if None.
        """
        return Branches(self._kernel.call(T) if q0 is None else self._kernel_q0.call(T, q0))

    @property
    def kernel(self) -> Kernel:
        """Of T_sd to the table itself, for those who need every microsecond; locked joints are at zero."""
        return self._kernel

    @lazy
    def labelled(self) -> Kernel:
        """Of (T_sd, q0, turns, lower, upper) to all branches with names and limits.

        Inputs: pose (4, 4); coordinates `q0` (n,) to which angles are wound and which free joints take; their cosines
        and sines (n, 2); limits (n,). Outputs: coordinates (branches, n); details (branches, 6): residual, subproblem
        residual,
        sum of 2^i over the free coordinates, code of the branch, smallest branch margin of a branch, excess over the
        limits; how
        far the matrix is from a pose.
        """
        return _compiled_labelled(self.pattern)

    @lazy
    def judged(self) -> Kernel:
        """Of (T_sd, q0, turns, lower, upper, tolerance): as `labelled`, with what is decided in place of the defect.

        The decision is the sum of 2^k over the rows k that are solutions, where these are distinct, isolated and exact
        and there are no others; else one of `mafsil.ik.answers.candidate_table.Decision`. For arms without locked
        joints.
        """
        return _compiled_judged(self.pattern)

    @lazy
    def _kernel(self) -> Kernel:
        return _compile(self.pattern, False)

    @lazy
    def _kernel_q0(self) -> Kernel:
        return _compile(self.pattern, True)


def structure_kernel(pattern: ArmPattern) -> Kernel:
    """Of (T_sd, numbers) to the table of branches, for all arms of the same structure: nothing is compiled per arm.

    Args:
        pattern: of one of the arms, none of its joints locked.
    """
    return _structure_kernel(_Structure(pattern))


class _Structure:
    """A pattern that is equal to all of the same structure."""

    def __init__(self, pattern: ArmPattern) -> None:
        self.pattern = pattern

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _Structure) and other.pattern.structure == self.pattern.structure

    def __hash__(self) -> int:
        return hash(self.pattern.structure)


@lru_cache(maxsize=256)
def _structure_kernel(structure: _Structure) -> Kernel:
    pattern = structure.pattern
    return _made(
        "closed_form",
        (Port("T_sd", (4, 4)), Port("numbers", (len(pattern.numbers),))),
        (Port("table", (pattern.branches, pattern.n + 3)),),
        partial(_build_structure, pattern),
        f"structure {pattern.structure}",
        (structure_kernel, (pattern,)),
    )


def _compile(pattern: ArmPattern, with_q0: bool) -> Kernel:
    inputs = (Port("T_sd", (4, 4)), *((Port("q0", (pattern.n,)),) if with_q0 else ()))
    outputs = (Port("table", (pattern.branches, pattern.n + 3)),)
    key = f"{pattern.key} {with_q0}"
    return _made("closed_form", inputs, outputs, partial(_build, pattern, with_q0), key, (_compile, (pattern, with_q0)))


def _compiled_labelled(pattern: ArmPattern) -> Kernel:
    n, rows = pattern.n, pattern.branches
    vectors = (Port("q0", (n,)), Port("turns", (n, 2)), Port("lower", (n,)), Port("upper", (n,)))
    return _made(
        "labelled_closed_form",
        (Port("T_sd", (4, 4)), *vectors),
        (Port("q", (rows, n)), Port("details", (rows, 6)), Port("defect")),
        partial(_build_labelled, pattern),
        f"labelled {pattern.key}",
        (_compiled_labelled, (pattern,)),
    )


def _compiled_judged(pattern: ArmPattern) -> Kernel:
    n, rows = pattern.n, pattern.branches
    vectors = (Port("q0", (n,)), Port("turns", (n, 2)), Port("lower", (n,)), Port("upper", (n,)))
    return _made(
        "judged_closed_form",
        (Port("T_sd", (4, 4)), *vectors, Port("tolerance")),
        (Port("q", (rows, n)), Port("details", (rows, 6)), Port("decision")),
        partial(_build_judged, pattern),
        f"judged {pattern.key}",
        (_compiled_judged, (pattern,)),
    )


def _made(
    name: str,
    inputs: tuple[Port, ...],
    outputs: tuple[Port, ...],
    build: Callable[[], Any],
    key: str,
    recipe: tuple[Callable[..., Kernel], tuple[Any, ...]],
) -> Kernel:
    return kernels.compile(
        Signature(name, inputs, outputs),
        build,
        key=key,
        fingerprints=(kernels.fingerprint("mafsil.algebra", "mafsil.mechanics"),),
        recipe=recipe,
    )


def _build(pattern: ArmPattern, with_q0: bool) -> Any:
    """The function of a pattern; its expressions are loaded only when a kernel has to be made."""
    return function.table_function(pattern, with_q0)


def _build_structure(pattern: ArmPattern) -> Any:
    """The same with the arm's numbers as an input."""
    return function.structure_function(pattern)


def _build_labelled(pattern: ArmPattern) -> Any:
    """The same with preferences of the caller."""
    return function.labelled_function(pattern)


def _build_judged(pattern: ArmPattern) -> Any:
    """The same with the decision."""
    return function.judged_function(pattern)
