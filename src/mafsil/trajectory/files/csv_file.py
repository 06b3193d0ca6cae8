"""Trajectories as CSV: t, q[JOINT], qd[JOINT], qdd[JOINT], written and read back."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from os import PathLike

import numpy as np

from mafsil.arrays import Floats
from mafsil.csv_table import CsvTable, csv_text, joint_columns, read_csv_table
from mafsil.errors import FileError
from mafsil.trajectory.files.ros2 import Samples
from mafsil.trajectory.profiles.polynomial import cubic_coefficients, quintic_coefficients
from mafsil.trajectory.splines.cubic_spline import cubic_through
from mafsil.trajectory.splines.piecewise import PiecewisePolynomial

SIGNALS = ("q", "qd", "qdd")


def as_csv(samples: Samples) -> bytes:
    """The rows as text that reads back to the last bit."""
    values = (samples.q, samples.qd, samples.qdd)
    return b"".join(csv_text({"t": samples.t, **joint_columns(SIGNALS, values, samples.joints)}))


def read_trajectory(
    path: str | PathLike[str], joints: Sequence[str] = (), *, driven: bool = False
) -> PiecewisePolynomial:
    """The trajectory of a CSV file, through every row; of a recording the plan that was to be driven.

    Between rows: quintics where velocities and accelerations are recorded, cubics where velocities are, and the cubic
    spline at rest at both ends where only positions are. Its time begins at zero whatever that of the file.

    Args:
        path: of a file with a heading line, columns `t` or `time`, and for every joint `q[NAME]` (or `q1`, `q_1`),
            if recorded `qd[NAME]` and `qdd[NAME]`; other columns are passed over. In rad or m, and seconds.
        joints: names of the joints, in the order of coordinates; as the file names them if empty.
        driven: of a recording, which holds the plan in `q_ref[NAME]`, `qd_ref[NAME]`, `qdd_ref[NAME]`, the motion that
            was driven instead, in `q[NAME]` and its derivatives.

    Raises:
        FileError: no such file, a missing column, a cell that is no number, times that do not increase.

    Example: `mf.trajectory.read_trajectory("motion.csv").at(0.5).u`
    """
    table = read_csv_table(path)
    names = tuple(joints) or joint_names(table)
    if not names:
        names = tuple(str(k) for k in range(1, 1 + sum(_is_numbered(head) for head in table.heads)))
    if not names:
        raise table.no_column("q[JOINT]")
    planned = not driven and is_recording(table, names)
    signals = [f"{signal}_ref" if planned else signal for signal in SIGNALS]
    found = [table.joint_columns(signal, names, required=signal == "q") for signal in signals]
    time = table.numbers([table.time_column()])[:, 0]
    table.require_increasing(time)
    q, qd, qdd = (None if columns is None else table.numbers(columns) for columns in found)
    if q is None:
        raise FileError("csv_table.no_column", path=table.file, column="q", found="")
    return _through(time, q, qd, qdd)


def is_recording(table: CsvTable, joints: Sequence[str]) -> bool:
    """Whether a table holds a plan beside the motion that was driven.

    Raises:
        FileError: it does for some of the joints only.
    """
    return table.joint_columns(f"{SIGNALS[0]}_ref", joints, required=False) is not None


def joint_names(table: CsvTable) -> tuple[str, ...]:
    """Names of the joints in columns `q[NAME]`, in the order of the file; none where joints are numbered."""
    named = tuple(head[2:-1] for head in table.heads if head.startswith("q[") and head.endswith("]"))
    return () if all(name.isdecimal() for name in named) else named


def _is_numbered(head: str) -> bool:
    return head.startswith("q") and head[1:].strip("_[]").isdecimal()


def _through(t: Floats, q: Floats, qd: Floats | None, qdd: Floats | None) -> PiecewisePolynomial:
    """The smoothest curve that the recorded derivatives determine."""
    h = np.diff(t)
    if qd is None:
        return cubic_through(q, h)
    if qdd is None:
        pieces = [cubic_coefficients(q[i], q[j], qd[i], qd[j], float(h[i])) for i, j in pairwise(range(len(t)))]
    else:
        pieces = [
            quintic_coefficients(q[i], q[j], qd[i], qd[j], qdd[i], qdd[j], float(h[i]))
            for i, j in pairwise(range(len(t)))
        ]
    return PiecewisePolynomial.from_pieces(h, pieces)
