"""A pose as people type it: x y z, and perhaps roll pitch yaw or a quaternion, or the rows of a matrix."""

from __future__ import annotations

import numpy as np

from mafsil.arrays import PoseMatrix
from mafsil.cli.numerals import angle, number
from mafsil.errors import InputError

PLACES = ("x", "y", "z", "roll", "pitch", "yaw")


def typed_pose(name: str, words: list[str], *, degrees: bool) -> PoseMatrix:
    """(4, 4) from x y z [m] and perhaps roll pitch yaw about fixed axes or a quaternion w x y z; or 12 or 16 numbers.

    Args:
        name: of the argument, for errors.
        words: as typed.
        degrees: whether bare angles are degrees.

    Raises:
        InputError: not 3, 6, 7, 12 or 16 finite numbers, or no rotation.
    """
    from mafsil.cli.motion_input import read
    from mafsil.geometry import rotation

    if len(words) == 7:
        return read({"quaternion": words[3:]}, words[:3], degrees=False, project=False).T
    if len(words) in (12, 16):
        return read({"pose": words}, None, degrees=False, project=False).T
    if len(words) not in (3, 6):
        raise InputError("cli.ik_pose_count", name=name, got=len(words))
    values = [number(f"{name}[{place}]", word) for place, word in zip(PLACES[:3], words[:3], strict=True)]
    for place, word in zip(PLACES[3:], words[3:], strict=False):
        values.append(angle(f"{name}[{place}]", word, degrees=degrees))
    for place, value in zip(PLACES, values, strict=False):
        if not np.isfinite(value):
            raise InputError("input.finite", name=name, value=value, index=place)
    T = np.eye(4)
    T[:3, 3] = values[:3]
    if len(values) == 6:
        T[:3, :3] = rotation.from_rpy(np.array(values[3:]))
    return T
