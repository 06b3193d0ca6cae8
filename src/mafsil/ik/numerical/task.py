"""What numerical inverse kinematics is asked for: which components of a pose count, how much, and how exactly."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal, cast, get_args

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, Vector3, Vector6, as_batch, positive
from mafsil.errors import InputError

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
