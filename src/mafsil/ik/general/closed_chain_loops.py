"""The loop of six joints in lanes: frames moved along it, joints as cosine and sine."""

from __future__ import annotations

from typing import TYPE_CHECKING

from mafsil.arrays import Floats
from mafsil.kernels.loops.lanes import square_root, where
from mafsil.kernels.loops.loop import reordered

if TYPE_CHECKING:
    from mafsil.kernels.loops.lanes import Buffer, Lanes


@reordered
def apply_joint(T: Buffer, prismatic: bool, c: Lanes, s: Lanes, frames: Floats, k: int) -> None:
    """T Z F_k in place of T: the joint moves about z by an angle, or along z.

    Args:
        T: twelve places, (3, 4) by rows.
        prismatic: whether the joint is prismatic.
        c, s: cosine and sine of the angle, or length and zero.
        frames: (7, 3, 4) constants of the loop.
        k: which of them.
    """
    for r in range(3):
        x, y, z, p = T[4 * r], T[4 * r + 1], T[4 * r + 2], T[4 * r + 3]
        if prismatic:
            p += c * z
        else:
            x, y = c * x + s * y, c * y - s * x
        T[4 * r] = x * frames[k, 0, 0] + y * frames[k, 1, 0] + z * frames[k, 2, 0]
        T[4 * r + 1] = x * frames[k, 0, 1] + y * frames[k, 1, 1] + z * frames[k, 2, 1]
        T[4 * r + 2] = x * frames[k, 0, 2] + y * frames[k, 1, 2] + z * frames[k, 2, 2]
        T[4 * r + 3] = p + x * frames[k, 0, 3] + y * frames[k, 1, 3] + z * frames[k, 2, 3]


@reordered
def unit(turns: Buffer, k: int, c: Lanes, s: Lanes) -> None:
    """Cosine and sine of a joint from multiples of both; angle zero where there are none.

    Args:
        turns: places 2 k and 2 k + 1 are filled.
        k: the joint.
        c, s: multiples of cosine and sine.
    """
    length = square_root(c * c + s * s)
    turns[2 * k] = where(length > 0.0, c / length, 1.0)
    turns[2 * k + 1] = where(length > 0.0, s / length, 0.0)


@reordered
def small_rotation(step: Lanes) -> tuple[Lanes, Lanes]:
    """Cosine and sine of an angle of at most 0.6 rad, by their series: what is left out is below 1e-17."""
    x = step * step
    c = 1.0 - x / 182.0
    s = 1.0 - x / 210.0
    for k in range(12, 0, -2):
        c = 1.0 - x * c * (1.0 / (k * (k - 1.0)))
        s = 1.0 - x * s * (1.0 / (k * (k + 1.0)))
    return c, step * s
