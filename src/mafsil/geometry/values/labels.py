"""Frame letters of values: adjacent letters cancel, T_ab T_bc = T_ac, and what does not cancel is refused."""

from __future__ import annotations

from typing import TypeAlias

from mafsil.errors import InputError

Frames: TypeAlias = tuple[str, str]
"""(a, b) of R_ab or T_ab."""


def join_frames(name: str, left: Frames | None, right: Frames | None) -> Frames | None:
    """(a, c) of (a, b) and (b, c); None where one side carries no letters.

    Args:
        name: the operation, for the error.
        left: (a, b).
        right: (b, c).

    Raises:
        InputError: the inner letters differ.
    """
    if left is None or right is None:
        return None
    require_same(name, left[1], right[0])
    return left[0], right[1]


def carry_frame(name: str, frames: Frames | None, frame: str | None) -> str | None:
    """{a} of something seen from {b}, carried by (a, b); None where one side carries no letters.

    Args:
        name: the operation, for the error.
        frames: (a, b).
        frame: b.

    Raises:
        InputError: the inner letters differ.
    """
    if frames is None or frame is None:
        return None
    require_same(name, frames[1], frame)
    return frames[0]


def reversed_frames(frames: Frames | None) -> Frames | None:
    """(b, a) of (a, b)."""
    return None if frames is None else (frames[1], frames[0])


def same(name: str, left: str | None, right: str | None) -> str | None:
    """The common letter of two values, or the one that is known.

    Args:
        name: the operation, for the error.
        left: letter of one value.
        right: letter of the other.

    Raises:
        InputError: they differ.
    """
    if left is not None and right is not None:
        require_same(name, left, right)
    return left if left is not None else right


def require_same(name: str, left: str, right: str) -> None:
    """Refuse letters `left` and `right` that differ; `name` is the operation."""
    if left != right:
        raise InputError("geometry.frames", name=name, inner_left=left, inner_right=right)
