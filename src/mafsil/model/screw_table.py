"""Screw axes for reading: the table of omega and v, the matrices [S_i], and how many numbers each description needs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from mafsil.arrays import Floats, as_batch
from mafsil.model.exponentials import Screws
from mafsil.model.placement import skew


def screw_matrices(S: ArrayLike) -> Floats:
    """(n, 4, 4) matrices [S] = [[ [omega], v ], [0, 0]] of screws (n, 6); the last row is zero.

    Args:
        S: (n, 6) screws (omega, v).
    """
    axes = np.atleast_2d(as_batch("S", S, (6,), finite=True))
    matrices = np.zeros((len(axes), 4, 4))
    for matrix, axis in zip(matrices, axes, strict=True):
        matrix[:3, :3], matrix[:3, 3] = skew(axis[:3]), axis[3:]
    return matrices


def screw_table(screws: Screws, form: str = "space") -> str:
    """The table i, omega_i, v_i as text, then every [S_i] (or [B_i]).

    Args:
        screws: of an arm.
        form: `space` or `body`.
    """
    axes, letter = (screws.S_b, "B") if form == "body" else (screws.S_s, "S")
    rows = [f"{'i':>3}  {'omega_i':^27}  {'v_i':^27}"]
    rows += [f"{i:>3}  {_triple(S[:3])}  {_triple(S[3:])}" for i, S in enumerate(axes, 1)]
    for i, matrix in enumerate(screw_matrices(axes), 1):
        rows += ["", f"[{letter}_{i}] ="]
        rows += ["  [" + " ".join(_number(x) for x in line) + " ]" for line in matrix]
    return "\n".join(rows) + "\n"


class Representation(NamedTuple):
    """One way to describe an arm of n joints.

    Attributes:
        name: `denavit_hartenberg`, `free_frames`, `exponentials` or `local_exponentials`.
        numbers: parameters written down, joint coordinates not counted.
        independent: how many constants the arm has with fixed and tip frame prescribed, however it is described.
        needs_link_frames: whether a frame has to be put on every link.
    """

    name: str
    numbers: int
    independent: int
    needs_link_frames: bool


def representations(revolute: int, prismatic: int = 0) -> tuple[Representation, ...]:
    """How many numbers each description of an arm takes.

    A table has four per joint, the zero of the joint's own coordinate among them, and covers only the fixed and tip
    frames that its rules choose; base and tool poses add six each when others are prescribed. A revolute axis is a
    line, four independent numbers; a prismatic axis is a direction, two; prescribed frames at both ends add six.

    Args:
        revolute, prismatic: numbers of joints.

    Returns:
        One entry per description.
    """
    n = revolute + prismatic
    independent = 4 * revolute + 2 * prismatic + 6
    return (
        Representation("denavit_hartenberg", 4 * n, independent, True),
        Representation("free_frames", 6 * n, independent, True),
        Representation("exponentials", 6 * n + 6, independent, False),
        Representation("local_exponentials", 12 * n, independent, True),
    )


def _triple(x: Floats) -> str:
    return "(" + " ".join(_number(value) for value in x) + ")"


def _number(value: float) -> str:
    return f"{0.0 if abs(value) < 1e-12 else value:8.4g}"
