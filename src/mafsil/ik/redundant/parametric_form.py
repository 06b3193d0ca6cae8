"""The closed form of an arm with redundant joints, whose values are an input, and the configurations it gives.

Arms with a spherical shoulder, an elbow and a spherical wrist have eight configurations for every arm angle.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, TypeAlias

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil import kernels
from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, JointVector, PoseMatrix
from mafsil.geometry import pose
from mafsil.ik.answers.setting import BENT, CLEAR, FAR, NEARLY, SPLIT, Setting, turns_of
from mafsil.ik.chain import Chain, common_point
from mafsil.ik.tolerances import APART_BRANCH, COINCIDENT, DEFECT, EXACT_POSE, FREE_BRANCH, NEARLY_REACHED, REACHED
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


_ANGLES: Floats = 2 * np.pi / 3 * np.arange(3.0)

THIRDS: Floats = np.stack([np.ones(3), 2 * np.cos(_ANGLES), 2 * np.sin(_ANGLES)]) / 3
"""From values at three thirds of a turn to a, b and c of a + b cos + c sin."""

_ZERO, _WIDE, _UNTURNED = np.zeros(7), np.full(7, FAR), turns_of(np.zeros(7))


@dataclass(frozen=True, eq=False)
class ArmAngleForm:
    """All configurations of an S-R-S arm with seven joints by its arm angle.

    The arm angle is that of the elbow about the line from shoulder to wrist, from the side to which the first axis
    points; where the first axis runs along that line, from the home direction of the second axis instead.

    Attributes:
        chain: of the arm.
        shoulder, elbow, wrist: (3,) at q = 0; the elbow is the point of axis 4 nearest to the shoulder [m].
    """

    chain: Chain
    shoulder: Floats
    elbow: Floats
    wrist: Floats

    @lazy
    def kernels(self) -> ParametricForm:
        """Of poses and arm angles to configurations."""
        chain = self.chain
        pattern = ArmAnglePattern(np.array(chain.axes), chain.home, self.shoulder, self.elbow, self.wrist)
        return form_of_pattern(pattern)

    def solve(self, T: ArrayLike, angle: ArrayLike) -> JointVector:
        """(*batch, m, 8, 7) configurations, elbow, shoulder and wrist each with its two roots; NaN where out of reach.

        Args:
            T: (*batch, 4, 4) poses of the tip in {s}.
            angle: (*batch, m) arm angles [rad].
        """
        X, psi = np.asarray(T, dtype=np.float64), np.asarray(angle, dtype=np.float64)
        return self.kernels.configurations(X[..., None, :, :], psi[..., None], _ZERO, _UNTURNED, -_WIDE, _WIDE, np.inf)[
            0
        ]

    def breaks(self, T: PoseMatrix, lower: Floats, upper: Floats) -> list[Floats]:
        """Of each elbow all arm angles at which a configuration of one pose may come within the limits or leave them.

        The rotations of shoulder and wrist are A + B cos + C sin of the arm angle, so a joint is at its limit where
        a + b cos + c sin = 0: at most two angles. Where the middle joint of three stands still for a moment, its
        neighbours may leap: these angles are given too.

        Args:
            T: (4, 4) pose of the tip in {s}.
            lower, upper: (7,) limits [rad].

        Returns:
            Of both elbows angles in [-pi, pi), in order; without any where the elbow cannot be made.
        """
        configurations = self.solve(T, _ANGLES)
        return [self._breaks(configurations[:, 4 * elbow], lower, upper) for elbow in range(2)]

    def _breaks(self, q: JointVector, lower: Floats, upper: Floats) -> Floats:
        """Of one elbow, from its configurations at three arm angles."""
        if not np.isfinite(q).all():
            return np.zeros(0)
        found: list[Floats] = []
        for first in (0, 4):
            axes = self.chain.axes[first : first + 3]
            frame, turn = _frame(axes), _turn(axes)
            E = [pose.exp(self.chain.screws[k] * q[:, k, None])[:, :3, :3] for k in range(first, first + 3)]
            Q = frame.T @ E[0] @ E[1] @ E[2] @ frame @ _about_y(turn)
            a, b, c = (_wave(Q, weights) for weights in THIRDS)
            # The middle joint is least or most bent.
            still = float(np.arctan2(c[2, 2], b[2, 2]))
            found.append(np.array([still, still + np.pi], dtype=np.float64))
            for k, limits in enumerate(zip(lower[first : first + 3], upper[first : first + 3], strict=True)):
                for limit in limits:
                    if np.isfinite(limit):
                        weights = _at_limit(k, float(limit))
                        total = [float((weights * x).sum()) for x in (a, b, c)]
                        found.append(_zeros(total[0] - (np.cos(limit + turn) if k == 1 else 0.0), *total[1:]))
        return np.sort((np.concatenate(found) + np.pi) % (2 * np.pi) - np.pi)

    def angle(self, q: ArrayLike) -> Floats:
        """(*batch,) arm angle of configurations (*batch, 7), in (-pi, pi] [rad]; NaN if the elbow is straight."""
        x = np.asarray(q, dtype=np.float64)
        E = [pose.exp(self.chain.screws[k] * x[..., k, None]) for k in range(4)]
        before = E[0] @ E[1] @ E[2]
        elbow = _apply(before, self.elbow)
        wrist = _apply(before @ E[3], self.wrist)
        w = wrist - self.shoulder
        w = w / np.linalg.norm(w, axis=-1, keepdims=True)
        along = np.linalg.norm(np.cross(w, self.chain.axes[0]), axis=-1) < DEFECT
        up = np.asarray(np.where(along[..., None], self.chain.axes[1], self.chain.axes[0]), dtype=np.float64)
        reference, side = _across(up, w), _across(elbow - self.shoulder, w)
        straight = np.linalg.norm(side, axis=-1) < EXACT_POSE
        found = np.arctan2((np.cross(reference, side) * w).sum(-1), (reference * side).sum(-1))
        return np.where(straight, np.nan, found)


def arm_angle_form(chain: Chain) -> ArmAngleForm | None:
    """The arm angle form of a chain; None unless seven joints turn and shoulder and wrist are spherical, orthogonal."""
    if len(chain) != 7 or any(chain.prismatic):
        return None
    size = chain.size
    ends: list[Floats] = []
    for part in (slice(0, 3), slice(4, 7)):
        axes = chain.axes[part]
        place, distance = common_point(axes, chain.points[part])
        if not distance <= DEFECT * size or max(abs(axes[0] @ axes[1]), abs(axes[1] @ axes[2])) > DEFECT:
            return None
        ends.append(place)
    w, r = chain.axes[3], chain.points[3]
    elbow = r + w * (w @ (ends[0] - r))
    offsets = [np.linalg.norm(np.cross(w, place - r)) for place in ends]
    if min(offsets) < COINCIDENT * size:
        return None
    return ArmAngleForm(chain, ends[0], elbow, ends[1])


def _frame(axes: Floats) -> Floats:
    """(3, 3) z along the first axis, y along the second."""
    y = axes[1] - (axes[1] @ axes[0]) * axes[0]
    y = y / np.linalg.norm(y)
    x = np.asarray(np.cross(y, axes[0]), dtype=np.float64)
    return np.ascontiguousarray(np.stack([x, y, axes[0]], axis=1))


def _turn(axes: Floats) -> float:
    """Angle from the first to the third axis about the second."""
    return float(np.arctan2(axes[1] @ np.cross(axes[0], axes[2]), axes[0] @ axes[2]))


def _about_y(angle: float) -> Floats:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, 0.0, s], [0.0, 1.0, 0.0], [-s, 0.0, c]])


def _wave(Q: Floats, weights: Floats) -> Floats:
    """(3, 3) sum of matrices at three thirds of a turn, weighted by cosine or sine."""
    return np.asarray((Q * weights[:, None, None]).sum(axis=0), dtype=np.float64)


def _at_limit(k: int, limit: float) -> Floats:
    """(3, 3) weights of the elements of Rot(z, a) Rot(y, b) Rot(z, c): their sum is zero, or cos b, at a limit of one.

    Args:
        k: which of the three.
        limit: its value [rad].
    """
    weights, c, s = np.zeros((3, 3)), np.cos(limit), np.sin(limit)
    if k == 0:
        weights[1, 2], weights[0, 2] = c, -s
    elif k == 2:
        weights[2, 1], weights[2, 0] = c, s
    else:
        weights[2, 2] = 1.0
    return weights


def _zeros(a: float, b: float, c: float) -> Floats:
    """Where a + b cos + c sin vanishes: none or two angles; both are the extremum where it nearly touches."""
    size = float(np.hypot(b, c))
    if not abs(a) <= size * (1 + DEFECT):
        return np.zeros(0)
    opening = np.arccos(np.clip(-a / size, -1.0, 1.0)) if size > 0.0 else 0.0
    return np.arctan2(c, b) + np.array([-opening, opening])


def _apply(T: Floats, p: Floats) -> Floats:
    return T[..., :3, :3] @ p + T[..., :3, 3]


def _across(v: Floats, w: Floats) -> Floats:
    return v - (v * w).sum(-1, keepdims=True) * w
