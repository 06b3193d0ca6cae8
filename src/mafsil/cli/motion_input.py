"""A rotation or pose as people type it, in any representation, checked."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from math import isinf

import numpy as np

from mafsil.algebra.tolerance import PRINTED, PRINTED_UNIT, ROTATION, UNIT
from mafsil.arrays import Floats, PoseMatrix
from mafsil.cli.state import angle, coordinate, number
from mafsil.errors import InputError
from mafsil.geometry import euler, membership, planar, pose, quaternion, rotation, screw


@dataclass(frozen=True, slots=True)
class Motion:
    """What was typed.

    Attributes:
        T: (4, 4) pose; of a mere rotation with its origin at zero.
        kind: `rotation`, `pose` or `planar`.
        source: the option that gave it.
        sequence: of Euler angles, if they were given.
        moved: distance to the nearest member that `--project` took, or None if it was one already.
    """

    T: PoseMatrix
    kind: str
    source: str
    sequence: str | None = None
    moved: float | None = None


@dataclass(frozen=True, slots=True)
class _Words:
    """The words of one option, and how they are to be read."""

    option: str
    words: list[str]
    degrees: bool
    project: bool

    def numbers(self, kinds: str) -> Floats:
        """One number per letter of `kinds`: `a` is an angle, `n` any other number."""
        return self.of(self.words, kinds)

    def of(self, words: list[str], kinds: str) -> Floats:
        """The same for some of the words."""
        self.require_count(len(words), len(kinds))
        values: list[float] = []
        for k, (word, kind) in enumerate(zip(words, kinds, strict=True)):
            value = angle(f"{self.option}[{k}]", word, degrees=kind == "a" and self.degrees)
            if not np.isfinite(value):
                raise InputError("input.finite", name=self.option, value=value, index=k)
            values.append(value)
        return np.array(values)

    def require_count(self, got: int, *expected: int) -> None:
        """Refuse another number of words."""
        if got not in expected:
            counts = " | ".join(map(str, expected))
            raise InputError("convert.count", name=self.option, expected=counts, got=got)


def read(given: Mapping[str, list[str] | None], position: list[str] | None, *, degrees: bool, project: bool) -> Motion:
    """The motion that was typed.

    Args:
        given: words of each option; exactly one is not None.
        position: three words, the origin that goes with a mere rotation.
        degrees: bare angles are degrees.
        project: take the nearest rotation, or unit quaternion, of what is none.

    Raises:
        InputError: not exactly one option, not as many numbers as it needs, or no rotation within the tolerance.
    """
    options = {_option(name): words for name, words in given.items() if words is not None}
    if len(options) != 1:
        known = ", ".join(_option(name) for name in given)
        raise InputError("convert.one_source", got=", ".join(options) or "-", known=known)
    ((option, words),) = options.items()
    motion = _READERS[option](_Words(option, words, degrees, project))
    if position is None:
        return motion
    if motion.kind != "rotation":
        raise InputError("convert.position_twice", name=option)
    p = _Words("--position", position, degrees, project).numbers("nnn")
    T = pose.from_rotation_translation(motion.T[:3, :3], p)
    return Motion(T, "pose", option, motion.sequence, motion.moved)


def bare_angles(given: Mapping[str, list[str] | None]) -> list[tuple[str, str]]:
    """What is printed and what was typed of each angle.

    Args:
        given: words of each option, as `read` takes them.
    """
    places = {"rpy": (0, 3), "euler": (1, 4), "axis_angle": (3, 4), "rotation_vector": (0, 3), "planar": (0, 1)}
    words = [word for name, (start, end) in places.items() for word in (given[name] or [])[start:end]]
    return [(word, word) for word in words]


def _option(name: str) -> str:
    return "--" + name.replace("_", "-")


def _turn(words: _Words, R: Floats, sequence: str | None = None, moved: float | None = None) -> Motion:
    T = pose.from_rotation_translation(R, np.zeros(3))
    return Motion(T, "rotation", words.option, sequence, moved)


def _matrix(words: _Words) -> Motion:
    R, moved = _member(words, words.numbers("n" * 9).reshape(3, 3))
    return _turn(words, R, moved=moved)


def _pose(words: _Words) -> Motion:
    words.require_count(len(words.words), 12, 16)
    T = np.eye(4)
    rows = words.numbers("n" * len(words.words)).reshape(-1, 4)
    T[: len(rows)] = rows
    if np.abs(T[3] - (0, 0, 0, 1)).max() > 0:
        raise InputError("geometry.last_row", name=words.option, row=T[3].tolist())
    R, moved = _member(words, T[:3, :3])
    return Motion(pose.from_rotation_translation(R, T[:3, 3]), "pose", words.option, moved=moved)


def _member(words: _Words, M: Floats) -> tuple[Floats, float | None]:
    """The matrix if it is a rotation; the nearest one, and how far off it was, if asked, or of printed digits."""
    distance = float(membership.measure("rotation", M))
    if distance <= ROTATION:
        return M, None
    if words.project or distance <= PRINTED:
        R = rotation.project(M)
        return R, float(np.linalg.norm(R - M))
    if isinf(distance):
        determinant = float(np.linalg.det(M))
        raise InputError("convert.improper", name=words.option, determinant=determinant)
    raise InputError("convert.no_rotation", name=words.option, distance=distance, limit=PRINTED)


def _quaternion(words: _Words) -> Motion:
    q = words.numbers("nnnn")
    length = float(np.linalg.norm(q))
    if length == 0:
        raise InputError("geometry.quaternion", name=words.option)
    if abs(length - 1) > PRINTED_UNIT and not words.project:
        raise InputError("convert.no_unit", name=words.option, distance=abs(length - 1), limit=PRINTED_UNIT)
    moved = abs(length - 1) if abs(length - 1) > UNIT else None
    return _turn(words, rotation.from_quaternion(q / length), moved=moved)


def _axis_angle(words: _Words) -> Motion:
    values = words.numbers("nnna")
    return _turn(words, rotation.from_axis_angle(values[:3], values[3]))


def _euler(words: _Words) -> Motion:
    words.require_count(len(words.words), 4)
    sequence = euler.sequence_named(words.words[0]).name
    return _turn(words, rotation.from_euler(words.of(words.words[1:], "aaa"), sequence), sequence)


def _screw(words: _Words) -> Motion:
    """Seven words: S and the amount; eight: direction, point, pitch (perhaps inf) and the amount."""
    words.require_count(len(words.words), 7, 8)
    *axis, amount = words.words
    if len(axis) == 6:
        S = words.of(axis, "n" * 6)
    elif isinf(coordinate(words.option, axis[6])[0]):
        S = screw.from_direction(words.of(axis[:3], "nnn"))
    else:
        values = words.of(axis, "n" * 7)
        S = screw.from_axis(values[:3], values[3:6], values[6])
    if words.project:
        S = screw.normalise(S)
    distance = words.of([amount], "a" if np.any(S[:3]) else "n")[0]
    S = membership.require("unit_screw", words.option, S)
    return Motion(screw.displacement(S, distance), "pose", words.option)


def _planar(words: _Words) -> Motion:
    theta, *p = words.numbers("ann")
    return Motion(planar.to_spatial_pose(planar.pose(theta, p)), "planar", words.option)


_READERS: dict[str, Callable[[_Words], Motion]] = {
    "--rpy": lambda words: _turn(words, rotation.from_rpy(words.numbers("aaa")), "xyz"),
    "--quaternion": _quaternion,
    "--matrix": _matrix,
    "--axis-angle": _axis_angle,
    "--euler": _euler,
    "--rotation-vector": lambda words: _turn(words, rotation.exp(words.numbers("aaa"))),
    "--gibbs": lambda words: _turn(words, rotation.from_quaternion(quaternion.from_gibbs(words.numbers("nnn")))),
    "--pose": _pose,
    "--exponential": lambda words: Motion(pose.exp(words.numbers("aaannn")), "pose", words.option),
    "--screw": _screw,
    "--planar": _planar,
}
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
