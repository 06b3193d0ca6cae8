"""Every representation of a rotation side by side: how many numbers, how often one rotation, and any to any."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch, single
from mafsil.errors import InputError
from mafsil.geometry import euler, pose, quaternion, rotation
from mafsil.messages import say


@dataclass(frozen=True)
class Representation:
    """One way to write a rotation.

    Attributes:
        name: as `convert` knows it.
        shape: core shape of its array.
        parameters: how many numbers are stored; three of them are independent.
        names: how many values of the principal range one rotation has in general.
        to_matrix: (*batch, *shape) -> (*batch, 3, 3).
        from_matrix: (*batch, 3, 3) -> principal value (*batch, *shape).
    """

    name: str
    shape: tuple[int, ...]
    parameters: int
    names: int
    to_matrix: Callable[[Any], Any]
    from_matrix: Callable[[Any], Any]

    @property
    def note(self) -> str:
        """Range and singular set, in the current language."""
        return say(f"geometry.representation_{self.name}")


def _to_axis_angle(R: ArrayLike) -> Floats:
    axis, angle = rotation.to_axis_angle(R)
    return np.concatenate([axis, np.asarray(angle)[..., None]], axis=-1)


def _from_axis_angle(value: ArrayLike) -> Floats:
    array = as_batch("axis_angle", value, (4,))
    return rotation.from_axis_angle(array[..., :3], array[..., 3])


_ALL = (
    Representation("matrix", (3, 3), 9, 1, rotation.check, rotation.check),
    Representation("zyx", (3,), 3, 2, lambda a: euler.from_euler(a, "ZYX"), lambda R: euler.to_euler(R, "ZYX")),
    Representation("zyz", (3,), 3, 2, lambda a: euler.from_euler(a, "ZYZ"), lambda R: euler.to_euler(R, "ZYZ")),
    Representation("rpy", (3,), 3, 2, euler.from_rpy, euler.to_rpy),
    Representation("axis_angle", (4,), 4, 1, _from_axis_angle, _to_axis_angle),
    Representation("exponential", (3,), 3, 1, rotation.exp, rotation.log),
    Representation("quaternion", (4,), 4, 2, quaternion.from_quaternion, quaternion.to_quaternion),
    Representation(
        "su2",
        (2, 2),
        8,
        2,
        lambda U: quaternion.from_quaternion(quaternion.from_su2(U)),
        lambda R: quaternion.to_su2(quaternion.to_quaternion(R)),
    ),
    Representation(
        "gibbs",
        (3,),
        3,
        1,
        lambda g: quaternion.from_quaternion(quaternion.from_gibbs(g)),
        lambda R: quaternion.to_gibbs(quaternion.to_quaternion(R)),
    ),
    Representation(
        "modified_rodrigues",
        (3,),
        3,
        1,
        lambda m: quaternion.from_quaternion(quaternion.from_modified_rodrigues(m)),
        lambda R: quaternion.to_modified_rodrigues(quaternion.to_quaternion(R)),
    ),
)

REPRESENTATIONS: dict[str, Representation] = {entry.name: entry for entry in _ALL}
"""Representations by name; `convert` knows, besides, the 24 Euler sequences and general axis triples."""


def convert(value: Any, source: str | ArrayLike, target: str | ArrayLike) -> Any:
    """A rotation in another representation, principal value.

    Args:
        value: (*batch, *shape) in the source representation.
        source, target: names in REPRESENTATIONS; one of the 24 Euler sequences, such as `ZXZ` or `xyz`; or (3, 3) unit
            axes as rows, for angles about a general orthogonal triple.

    Returns:
        (*batch, *shape) in the target representation.

    Raises:
        InputError: an unknown name, a value that is no rotation (mirror images are none), axes that are not orthogonal.
    """
    return _name(target).from_matrix(_name(source).to_matrix(value))


def _name(name: str | ArrayLike) -> Representation:
    if not isinstance(name, str):
        return _of_axes(name)
    if name in REPRESENTATIONS:
        return REPRESENTATIONS[name]
    if name in euler.SEQUENCES:
        return Representation(name, (3,), 3, 2, lambda a: euler.from_euler(a, name), lambda R: euler.to_euler(R, name))
    known = ", ".join([*REPRESENTATIONS, *euler.SEQUENCES])
    raise InputError("input.choice", name="representation", value=name, known=known)


def _of_axes(axes: ArrayLike) -> Representation:
    """Angles about a general orthogonal triple."""
    n = single("axes", axes, (3, 3))
    return Representation(
        "axes", (3,), 3, 2, lambda a: euler.from_davenport(a, n), lambda R: euler.to_davenport(R, n)[..., 0, :]
    )


@dataclass(frozen=True)
class PoseChart:
    """One way to write a displacement of space.

    Attributes:
        name: of the chart.
        parameters: how many numbers are stored; six are independent.
        names: how many values of the principal range one displacement has in general.
        carried: whether a change of frame carries it linearly, x_a = Ad(T_ab) x_b.
        to_pose: (*batch, *shape) -> (*batch, 4, 4).
        from_pose: (*batch, 4, 4) -> principal value (*batch, *shape).
    """

    name: str
    parameters: int
    names: int
    carried: bool
    to_pose: Callable[[Any], Any]
    from_pose: Callable[[Any], Any]

    @property
    def note(self) -> str:
        """Range, singular set, and what a change of frame does, in the current language."""
        return say(f"geometry.chart_{self.name}")


def _beside_position(to_matrix: Callable[[Any], Any], from_matrix: Callable[[Any], Any]) -> dict[str, Any]:
    """Three numbers of the rotation, then the position."""

    def to_pose(value: ArrayLike) -> Floats:
        x = as_batch("value", value, (6,))
        return pose.from_rotation_translation(to_matrix(x[..., :3]), x[..., 3:])

    def from_pose(T: ArrayLike) -> Floats:
        matrix = pose.check(T, "T")
        return np.concatenate([from_matrix(matrix[..., :3, :3]), matrix[..., :3, 3]], axis=-1)

    return {"to_pose": to_pose, "from_pose": from_pose}


POSE_CHARTS: dict[str, PoseChart] = {
    chart.name: chart
    for chart in (
        PoseChart("matrix", 16, 1, False, lambda T: pose.check(T, "T"), lambda T: pose.check(T, "T")),
        PoseChart("euler_position", 6, 2, False, **_beside_position(euler.from_rpy, euler.to_rpy)),
        PoseChart("vector_position", 6, 1, False, **_beside_position(rotation.exp, rotation.log)),
        PoseChart("exponential", 6, 1, True, pose.exp, pose.log),
    )
}
"""Ways to write a displacement, by name: T, (roll, pitch, yaw, p), (rotation vector, p), and S theta."""
