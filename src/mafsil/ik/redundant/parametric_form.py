"""The closed form of an arm with redundant joints, whose values are an input, and the configurations it gives."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import NDArray

from mafsil import kernels
from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector
from mafsil.ik.answers.setting import BENT, CLEAR, NEARLY, SPLIT, Setting
from mafsil.ik.tolerances import APART_BRANCH, FREE_BRANCH, NEARLY_REACHED, REACHED
from mafsil.kernels import Port, Signature
from mafsil.kernels.lazy import lazy
from mafsil.lazy_module import lazily
from mafsil.mechanics.arm_pattern import ArmAnglePattern, ArmPattern
from mafsil.messages import say
from mafsil.messages.tables import on_screen, table

if TYPE_CHECKING:
    import mafsil.mechanics.closed_form.parametric as parametric
    from mafsil.kernels import Kernel
else:
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
    return parametric.parametric_function(pattern, kind, parametric.Thresholds(*numbers))


class ParameterStatus(Status):
    """What was found at the values of the parameter; it says nothing about other values."""

    FOUND = ("ik.parameter_found", True)
    BEYOND_LIMITS = ("ik.parameter_beyond_limits", False)
    NOT_FOUND = ("ik.parameter_not_found", False)


STATUSES = np.array(tuple(ParameterStatus), dtype=np.object_)


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
        return STATUSES[codes]

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
