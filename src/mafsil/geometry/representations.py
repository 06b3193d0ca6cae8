"""Every representation of a rotation side by side: how many numbers, how often one rotation, and any to any."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, gate
from mafsil.errors import InputError
from mafsil.geometry import euler, quaternion, rotation
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
    array = gate("axis_angle", value, (4,))
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
"""All representations by name; general axis triples stand in `mafsil.geometry.euler`."""


def convert(value: Any, source: str, target: str) -> Any:
    """A rotation in another representation, principal value.

    Args:
        value: (*batch, *shape) in the source representation.
        source, target: names in REPRESENTATIONS.

    Returns:
        (*batch, *shape) in the target representation.
    """
    return _named(target).from_matrix(_named(source).to_matrix(value))


def _named(name: str) -> Representation:
    if name not in REPRESENTATIONS:
        known = ", ".join(REPRESENTATIONS)
        raise InputError("input.choice", name="representation", value=name, known=known)
    return REPRESENTATIONS[name]
