"""What numerical inverse kinematics is asked: a task, which components of a pose count, for one frame of a robot."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, Literal, cast, get_args

import numpy as np
from numpy.typing import ArrayLike, NDArray

from mafsil import kernels
from mafsil.arrays import Floats, JointVector, PoseMatrix, Vector3, Vector6, as_batch, positive
from mafsil.errors import InputError
from mafsil.ik.chain import MovingPart, middle_of, moving_part
from mafsil.ik.result import reach_bound
from mafsil.ik.tolerances import FACTOR_DAMPING
from mafsil.kernels import Port, Signature
from mafsil.kernels.lazy import lazy
from mafsil.lazy_module import lazily
from mafsil.model import JointKind, Mechanism
from mafsil.model.fingerprint import fingerprint
from mafsil.robot import Robot

if TYPE_CHECKING:
    import mafsil.mechanics.damped_least_squares as damped_least_squares
    from mafsil.kernels import Kernel
else:
    damped_least_squares = lazily("mafsil.mechanics.damped_least_squares")


TaskKind = Literal["pose", "position", "orientation", "axis", "direction"]
KINDS: tuple[str, ...] = get_args(TaskKind)
WeightAxes = Literal["body", "aligned"]
AXES: tuple[str, ...] = get_args(WeightAxes)
_ROWS: dict[str, tuple[float, float]] = {
    "pose": (1.0, 1.0),
    "position": (0.0, 1.0),
    "orientation": (1.0, 0.0),
    "axis": (1.0, 1.0),
    "direction": (1.0, 0.0),
}
"""Kind -> whether rotation and position count."""
RELATIVE_DAMPING = 0.02
"""Damping relative to the squared error norm. Small enough for long steps, which also leave poor valleys."""


@dataclass(frozen=True, eq=False)
class PoseProblem:
    """Where a frame of a robot can be, and how it gets there.

    Attributes:
        part: the joints that move the frame, among those of the whole robot.
        limits: whether the joints' position limits hold.
    """

    part: MovingPart
    limits: bool

    @property
    def robot(self) -> Robot:
        """Of the joints that are sought."""
        return self.part.robot

    @property
    def frame(self) -> str | None:
        """Name of the link as that robot is asked for it, or None for its tip."""
        return self.part.frame

    @lazy
    def lower(self) -> Floats:
        """(n,) bounds, infinite for joints without [rad | m]."""
        return np.array(self.robot.limits.lower) if self.limits else np.full(self.robot.n, -np.inf)

    @lazy
    def upper(self) -> Floats:
        """(n,) bounds, infinite for joints without [rad | m]."""
        return np.array(self.robot.limits.upper) if self.limits else np.full(self.robot.n, np.inf)

    @lazy
    def bounded(self) -> bool:
        """Whether any joint has a bound."""
        return bool(np.isfinite(self.lower).any() or np.isfinite(self.upper).any())

    @lazy
    def reach(self) -> tuple[Floats, float]:
        """A sphere that the frame cannot leave: centre (3,) in {s} [m] and radius [m], infinite if unlimited."""
        centre, radius = reach_bound(self.robot.mechanism, self.frame)
        return np.array(centre, order="C"), radius

    @lazy
    def length(self) -> float:
        """Scale that makes positions comparable with angles [m]."""
        return unit_length(self.robot.mechanism, self.frame)

    @lazy
    def revolute(self) -> NDArray[np.int64]:
        """(n,) 1 for revolute joints."""
        return np.array([joint.kind is JointKind.REVOLUTE for joint in self.robot.mechanism.coordinates], np.int64)

    @lazy
    def middle(self) -> JointVector:
        """(n,) the middle of the joints' limits, zero where one is missing."""
        return middle_of(self.robot)

    def poses(self, q: JointVector) -> PoseMatrix:
        """(k, 4, 4) poses of the frame."""
        if self.frame is None:
            return self.robot.forward_kinematics(q)
        return self.robot.forward_kinematics(q, frame=self.frame)

    def step(self, one_axis: bool, aligned: bool = False) -> Kernel:
        """Of (q, T_sd, task) to (q_next, e): one bounded damped step."""
        return _kernel("step", self.robot.mechanism, self.frame, one_axis, aligned)

    def step_with_self_motion(self, one_axis: bool, aligned: bool = False) -> Kernel:
        """Of (q, T_sd, task, z) to (q_next, e, self-motion)."""
        return _kernel("step_with_self_motion", self.robot.mechanism, self.frame, one_axis, aligned)

    def check(self, one_axis: bool, aligned: bool = False) -> Kernel:
        """Of (q, T_sd, task) to (T_sf, e)."""
        return _kernel("check", self.robot.mechanism, self.frame, one_axis, aligned)

    def sample(self, generator: np.random.Generator, count: int) -> JointVector:
        """(count, n) uniform configurations within the bounds; within a turn, or the length, where there are none."""
        span = np.where(self.revolute == 1, np.pi, self.length)
        lower = np.where(np.isfinite(self.lower), self.lower, np.minimum(-span, self.upper - 2 * span))
        upper = np.where(np.isfinite(self.upper), self.upper, np.maximum(span, self.lower + 2 * span))
        return generator.uniform(lower, upper, (count, self.robot.n))


def unit_length(mechanism: Mechanism, frame: str | None) -> float:
    """How far the frame reaches [m]; one where that is unlimited or nothing.

    Args:
        mechanism: whose frame it is.
        frame: name of the link, or None for the tip.
    """
    _, radius = reach_bound(mechanism, frame)
    return radius if np.isfinite(radius) and radius > 0.0 else 1.0


@lru_cache(maxsize=64)
def problem_of(robot: Robot, frame: str | None, limits: bool) -> PoseProblem:
    """The problem of a frame, made once for each robot.

    Args:
        robot: whose joints are sought, as far as they move the frame.
        frame: name of the link, or None for the tip.
        limits: whether joint limits are respected.
    """
    return PoseProblem(moving_part(robot, frame), limits)


@lru_cache(maxsize=128)
def _kernel(what: str, mechanism: Mechanism, frame: str | None, one_axis: bool, aligned: bool) -> Kernel:
    n = mechanism.n
    inputs = (Port("q", (n,)), Port("T_sd", (4, 4)), Port("task", (9 + 2 * n,)))
    size = {"check": 22, "step": n + 6, "step_with_self_motion": 2 * n + 6}[what]
    if what == "step_with_self_motion":
        inputs = (*inputs, Port("z", (n,)))
    numbers = () if what == "check" else (RELATIVE_DAMPING, FACTOR_DAMPING, unit_length(mechanism, frame))
    return kernels.compile(
        Signature(f"pose_{what}", inputs, (Port("out", (size,)),)),
        partial(_build, what, mechanism, frame, one_axis, aligned, numbers),
        key=f"{fingerprint(mechanism)} pose_{what} {frame!r} {one_axis} {aligned} {numbers}",
        fingerprints=(kernels.fingerprint("mafsil.algebra", "mafsil.mechanics"),),
        recipe=(_kernel, (what, mechanism, frame, one_axis, aligned)),
    )


def _build(
    what: str, mechanism: Mechanism, frame: str | None, one_axis: bool, aligned: bool, numbers: tuple[float, ...]
) -> Any:
    """The function; its expressions are loaded only when a kernel has to be made."""
    if what == "check":
        return damped_least_squares.error(mechanism, frame, one_axis, aligned)
    build = {
        "step": damped_least_squares.step,
        "step_with_self_motion": damped_least_squares.step_with_self_motion,
    }[what]
    return build(mechanism, frame, one_axis, aligned, *numbers)


@dataclass(frozen=True, eq=False)
class PoseTask:
    """Components of the twist to the desired pose.

    Attributes:
        kind: see `pose_task`.
        weights: (6,) of rotations, then of positions; zero where a component is free.
        axis: (3,) unit vector in the frame, for the kinds `axis` and `direction`.
        rotation_tolerance: [rad].
        position_tolerance: [m].
        aligned: whether components are those along the axes of {s}, not along the frame's own.
    """

    kind: TaskKind
    weights: Vector6
    axis: Vector3
    rotation_tolerance: float
    position_tolerance: float
    aligned: bool = False

    @property
    def one_axis(self) -> bool:
        """Whether only the direction of one axis counts, not the turn about it."""
        return self.kind in ("axis", "direction")

    @property
    def rotates(self) -> bool:
        """Whether any rotation counts."""
        return bool(self.weights[:3].any())

    @property
    def translates(self) -> bool:
        """Whether any position counts."""
        return bool(self.weights[3:].any())

    @property
    def all_positions(self) -> bool:
        """Whether all components of the position count: then a place out of reach cannot be reached."""
        return bool(self.weights[3:].all())

    @property
    def dimension(self) -> int:
        """Number of equations."""
        return int(np.count_nonzero(self.weights)) - int(self.one_axis and bool(self.weights[:3].all()))

    def scaled_weights(self, length: float) -> Vector6:
        """(6,) weights times 1 for rotations and 1 / length for positions; the largest of each kind counts so much."""
        most = float(self.weights.max())
        return self.weights / most * np.repeat([1.0, 1.0 / length], 3)


def pose_task(
    kind: str,
    axis: ArrayLike,
    weights: ArrayLike | None,
    tolerance: float,
    rotation_tolerance: float | None,
    expressed_in: str = "body",
) -> PoseTask:
    """A task, from what a user says.

    Args:
        kind: `pose`; `position` of the origin; `orientation`; `axis`: position, and direction of one axis of the
            frame; `direction` of that axis alone.
        axis: (3,) in the frame.
        weights: (6,) of rotations about and positions along axes, zero for free components; ones if None.
        tolerance: of the position [m], and of the rotation [rad] if that is not given.
        rotation_tolerance: [rad].
        expressed_in: whose axes those of the weights are: `body`: the frame's own; `aligned`: those of {s}.

    Raises:
        InputError: an unknown kind, other axes, negative weights or none, a tolerance that is not positive, an axis of
            length zero.
    """
    if kind not in KINDS:
        raise InputError("input.choice", name="task", value=kind, known=", ".join(KINDS))
    if expressed_in not in AXES:
        raise InputError("input.choice", name="expressed_in", value=expressed_in, known=", ".join(AXES))
    shift = positive("tolerance", tolerance)
    turn = shift if rotation_tolerance is None else positive("rotation_tolerance", rotation_tolerance)
    direction = as_batch("axis", axis, (3,), finite=True)
    size = float(np.linalg.norm(direction))
    if direction.ndim != 1 or size == 0.0:
        raise InputError("ik.zero_axis", name="axis")
    rows = np.repeat(_ROWS[kind], 3) * _weights(weights)
    if not rows.any():
        raise InputError("ik.no_weight", name="weights", task=kind)
    return PoseTask(cast("TaskKind", kind), rows, direction / size, turn, shift, expressed_in == "aligned")


def _weights(weights: ArrayLike | None) -> Floats:
    if weights is None:
        return np.ones(6)
    given = as_batch("weights", weights, (6,), finite=True)
    if given.ndim != 1 or (given < 0.0).any():
        raise InputError("ik.weight", name="weights", value=float(given.min()))
    return given
