"""Printed answers of inverse kinematics: the sentences, then a row for each solution, or for each pose of a batch."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from mafsil.arrays import Floats, JointVector
from mafsil.ik.answers.branch import Branch
from mafsil.ik.result import STATUSES
from mafsil.messages import say
from mafsil.messages.tables import COLUMNS, MOST_ROWS, table

BESIDE = 46
"""Columns that number, branch, residual and limits take at most."""
COORDINATE = 8
"""Columns of a coordinate with the space before it: three decimals."""
MOST_COORDINATES = (COLUMNS - BESIDE) // COORDINATE + 1
"""Beyond these a row does not fit a screen: the last is then left out for a mark."""
ELLIPSIS = "\N{HORIZONTAL ELLIPSIS}"


def solution_table(
    q: JointVector,
    branches: Sequence[Branch],
    residual: Floats,
    within: NDArray[np.bool_],
    revolute: NDArray[np.bool_],
    language: str | None = None,
    *,
    degrees: bool = False,
) -> list[str]:
    """Lines: number, branch, coordinates, residual, and whether the limits are kept, of each solution.

    Args:
        q: (k, n) solutions of one pose.
        branches: of each.
        residual, within: (k,) of each.
        revolute: (n,) which coordinates are angles.
        language: `en` or `ar`; the current one if None.
        degrees: angles in degrees.
    """
    n = q.shape[-1]
    shown = n if n <= MOST_COORDINATES else MOST_COORDINATES - 1
    cut = [ELLIPSIS] if shown < n else []
    scale, units = angle_units(revolute[:shown], degrees=degrees)
    head = ["#", _column("branch", language), *(f"q{i} {unit}" for i, unit in enumerate(units, 1)), *cut]
    rows = [
        [
            str(k + 1),
            str(branches[k]),
            *(f"{x + 0.0:.3f}" for x in q[k, :shown] * scale),
            *cut,
            f"{residual[k]:.0e}",
            say("ik.inside" if within[k] else "ik.outside", language=language),
        ]
        for k in range(min(len(q), MOST_ROWS))
    ]
    # Rows beyond the last that is printed are counted only.
    rows += [[]] * (len(q) - len(rows))
    return table([*head, _column("residual", language), _column("limits", language)], rows, language) if rows else []


def angle_units(revolute: NDArray[np.bool_], *, degrees: bool) -> tuple[Floats, list[str]]:
    """(n,) the factor to what is printed, and its unit, of each coordinate.

    Args:
        revolute: (n,) which coordinates are angles.
        degrees: angles in degrees.
    """
    scale = np.where(revolute & degrees, 180.0 / np.pi, 1.0)
    return scale, [("deg" if degrees else "rad") if turns else "m" for turns in revolute]


def pose_table(
    valid: NDArray[np.bool_],
    within: NDArray[np.bool_],
    residual: Floats,
    codes: NDArray[np.int8],
    language: str | None = None,
) -> list[str]:
    """Lines: index, number of solutions, of those within the limits, largest residual, status, of each pose.

    Args:
        valid, within, residual: (*batch, k) of the rows of each pose.
        codes: (*batch,) index into `STATUSES`.
        language: `en` or `ar`; the current one if None.
    """
    shape = codes.shape
    rows: list[list[str]] = []
    for flat in range(min(codes.size, MOST_ROWS)):
        at = np.unravel_index(flat, shape)
        off = f"{residual[at][valid[at]].max():.0e}" if valid[at].any() else "-"
        counts = str(int(valid[at].sum())), str(int(within[at].sum()))
        status = STATUSES[int(codes[at])].name.lower().replace("_", " ")
        rows.append([", ".join(str(int(i)) for i in at), *counts, off, status])
    rows += [[]] * (codes.size - len(rows))
    head = [_column(name, language) for name in ("pose", "solutions", "allowed", "residual", "status")]
    return table(head, rows, language) if rows else []


def _column(name: str, language: str | None) -> str:
    return say(f"ik.column_{name}", language=language)
