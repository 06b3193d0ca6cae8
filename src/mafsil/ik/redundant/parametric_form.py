"""The closed form of an arm with redundant joints as kernels that take these joints' values as an input."""

from __future__ import annotations

from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, TypeAlias

from mafsil import kernels
from mafsil.ik.answers.setting import BENT, CLEAR, NEARLY, SPLIT, Setting
from mafsil.ik.tolerances import APART_BRANCH, FREE_BRANCH, NEARLY_REACHED
from mafsil.kernels import Port, Signature
from mafsil.kernels.lazy import lazy
from mafsil.lazy_module import lazily
from mafsil.mechanics.arm_pattern import ArmAnglePattern, ArmPattern

if TYPE_CHECKING:
    import mafsil.mechanics.closed_form.parametric as function
    import mafsil.mechanics.closed_form.parametric as parametric
    from mafsil.kernels import Kernel
else:
    function = lazily("mafsil.mechanics.closed_form.parametric")
    parametric = lazily("mafsil.mechanics.closed_form.parametric")

Numbers = tuple[float, ...]

Pattern: TypeAlias = ArmPattern | ArmAnglePattern
"""Of arms that are solved once a parameter is given: values of redundant joints, or the arm angle."""


class ParametricForm:
    """Kernels of a pattern with redundant joints.

    All take (T_sd, values, near, turns, lower, upper, most): pose (4, 4); values (h,) of the redundant joints by
    coordinate; coordinates `near` (n,) to which angles are wound and which free joints take, and their cosines and
    sines (n, 2); limits (n,); the largest residual of a solution.

    Attributes:
        pattern: what the arm was recognised as.
        numbers: thresholds of regular answers.
        joints: coordinates of the redundant joints.
    """

    def __init__(self, pattern: Pattern, numbers: Numbers) -> None:
        self.pattern, self.numbers = pattern, numbers
        self.joints = sorted(locked.joint for locked in pattern.locked) if isinstance(pattern, ArmPattern) else []

    @lazy
    def solutions(self) -> Kernel:
        """To (branches, n) coordinates, (branches, 4) residual, code, mark and excess, and the summary (4,).

        The summary: how far T is from a pose, whether a branch needs refinement, whether rounding may have moved one
        far off, the least excess of a solution.
        """
        rows = self.pattern.branches
        return self._made(
            "solutions", Port("q", (rows, self.pattern.n)), Port("details", (rows, 4)), Port("summary", (4,))
        )

    @lazy
    def check(self) -> Kernel:
        """To (3,): least excess of a solution, infinite without one; least residual; how far T is from a pose."""
        return self._made("check", Port("check", (3,)))

    @lazy
    def configurations(self) -> Kernel:
        """To (branches, n) coordinates, (branches,) residuals and excesses, and how far T is from a pose.

        Coordinates and residuals are NaN and the excess infinite where there is no configuration.
        """
        rows = (self.pattern.branches,)
        outputs = Port("q", (*rows, self.pattern.n)), Port("residual", rows), Port("excess", rows), Port("defect")
        return self._made("configurations", *outputs)

    def _made(self, kind: str, *outputs: Port) -> Kernel:
        # Only answers depend on the thresholds: the others are shared.
        return _compile(self.pattern, kind, self.numbers if kind == "solutions" else (0.0,) * 6, outputs)


def has_redundant_joints(setting: Setting) -> bool:
    """Whether the arm has an exact closed form once joints are locked, and no equation of fourth degree in it."""
    arm = setting.arm
    return bool(arm.locked) and arm.exact and not setting.quartic


@lru_cache(maxsize=128)
def parametric_form(setting: Setting) -> ParametricForm:
    """The kernels for an arm whose exact closed form holds joints.

    Args:
        setting: the arm.
    """
    form = setting.arm.form
    assert form is not None
    margin = FREE_BRANCH if setting.plain else APART_BRANCH
    return ParametricForm(form.pattern, (CLEAR, setting.candidate, margin, SPLIT, NEARLY, BENT))


@lru_cache(maxsize=128)
def form_of_pattern(pattern: Pattern) -> ParametricForm:
    """The kernels of a pattern by itself, made once.

    Args:
        pattern: with redundant joints, or counted by its arm angle.
    """
    return ParametricForm(pattern, (CLEAR, NEARLY_REACHED, APART_BRANCH, SPLIT, NEARLY, BENT))


def _compile(pattern: Pattern, kind: str, numbers: Numbers, outputs: tuple[Port, ...]) -> Kernel:
    n = pattern.n
    vectors = (Port("near", (n,)), Port("turns", (n, 2)), Port("lower", (n,)), Port("upper", (n,)))
    return kernels.compile(
        Signature(
            f"parametric_{kind}",
            (Port("T_sd", (4, 4)), Port("values", (pattern.parameters,)), *vectors, Port("most")),
            outputs,
        ),
        partial(_build, pattern, kind, numbers),
        key=f"parametric {kind} {numbers} {pattern.key}",
        fingerprints=(kernels.fingerprint("mafsil.algebra", "mafsil.mechanics"),),
        recipe=(_compile, (pattern, kind, numbers, outputs)),
    )


def _build(pattern: Pattern, kind: str, numbers: Numbers) -> Any:
    """The function; its expressions are loaded only when a kernel has to be made."""
    return function.parametric_function(pattern, kind, parametric.Thresholds(*numbers))
