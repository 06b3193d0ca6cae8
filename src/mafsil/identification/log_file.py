"""Logs in CSV files: named columns in any order, and a complaint that names the line."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Iterator
from os import PathLike
from pathlib import Path

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import FileError
from mafsil.identification.log import MotionLog
from mafsil.model import JointKind
from mafsil.model.loading import RobotLike
from mafsil.robot import Robot, as_robot

SIGNALS = ("q", "tau", "qd", "qdd")
"""What a log may hold of every joint; the first two it must."""
TIMES = ("t", "time")
"""Names of the column of times."""
MOST_BYTES = 1 << 31
"""Larger files are not read."""


def read_log(path: str | PathLike[str], robot: RobotLike, *, degrees: bool = False) -> MotionLog:
    """A log from a CSV file with a heading line; columns in any order, others are passed over.

    `t` [s]; for every joint `q[NAME]` [rad | m] and `tau[NAME]` [N m | N], and if recorded `qd[NAME]` and `qdd[NAME]`.
    Instead of names, joints may be numbered from 1 in the robot's order: `q1`, `q_1` or `q[1]`.

    Args:
        path: of the file; comma, semicolon or tab between columns.
        robot: whose joints they are.
        degrees: whether revolute joints are in degrees, their rates and accelerations too.

    Raises:
        FileError: no such file, missing columns, a cell that is no number, times that do not increase; the line is
            named.
    """
    file = Path(path)
    heads, rows, lines = _table(file)
    columns = {head: k for k, head in enumerate(heads)}
    if len(columns) < len(heads):
        twice = next(head for k, head in enumerate(heads) if head in heads[:k])
        raise FileError("identification.column_twice", path=file.name, column=twice)
    arm = as_robot(robot)
    places = _places(file, columns, arm)
    needed = sorted({k for group in places.values() for k in group})
    where = {column: k for k, column in enumerate(needed)}
    values = _numbers(file, heads, rows, lines, needed)
    arrays = {name: values[:, [where[k] for k in group]] for name, group in places.items()}
    if degrees:
        revolute = np.array([joint.kind is not JointKind.PRISMATIC for joint in arm.mechanism.coordinates])
        for name in ("q", "qd", "qdd"):
            if name in arrays:
                arrays[name] = np.where(revolute, np.radians(arrays[name]), arrays[name])
    times = arrays.pop("t")[:, 0]
    return _log(file, times, arrays, np.array(lines, dtype=np.int64))


def _log(file: Path, times: Floats, arrays: dict[str, Floats], lines: np.ndarray) -> MotionLog:
    """The log; what is wrong with its rows is a fault of the file."""
    backward = np.flatnonzero(np.diff(times) <= 0.0)
    if len(backward):
        k = int(backward[0]) + 1
        details = {"path": file.name, "line": int(lines[k]), "now": times[k], "before": times[k - 1]}
        raise FileError("identification.file_time_order", **details)
    return MotionLog(t=times, source=file.name, lines=lines, **arrays)


def _table(file: Path) -> tuple[list[str], list[list[str]], list[int]]:
    """Heading, rows and their line numbers; empty lines and lines that begin with # are passed over."""
    try:
        if file.stat().st_size > MOST_BYTES:
            raise FileError("identification.too_large", path=file.name, limit=MOST_BYTES >> 20)
        text = file.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        raise FileError("identification.no_file", path=str(file)) from None
    except (OSError, UnicodeDecodeError) as fault:
        reason = (isinstance(fault, OSError) and fault.strerror) or "UTF-8"
        raise FileError("identification.unreadable", path=str(file), fault=reason) from None
    body = text.splitlines()
    head = next((line for line in body if line.strip() and not line.startswith("#")), "")
    separator = max(",;\t", key=head.count)
    rows, lines = list[list[str]](), list[int]()
    for line, cells in enumerate(_cells(file, body, separator), start=1):
        if any(cell.strip() for cell in cells) and not cells[0].startswith("#"):
            rows.append(cells)
            lines.append(line)
    if len(rows) < 3:
        raise FileError("identification.empty", path=file.name, rows=max(len(rows) - 1, 0))
    return [cell.strip() for cell in rows[0]], rows[1:], lines[1:]


def _cells(file: Path, body: Iterable[str], separator: str) -> Iterator[list[str]]:
    """Line by line: a quoted cell cannot run over lines."""
    for number, line in enumerate(body, start=1):
        try:
            yield next(csv.reader([line], delimiter=separator), [""]) or [""]
        except csv.Error as fault:
            raise FileError("identification.bad_line", path=file.name, line=number, fault=str(fault)) from None


def _places(file: Path, columns: dict[str, int], robot: Robot) -> dict[str, list[int]]:
    """Columns of time and of every signal, joints in the robot's order."""
    time = next((columns[name] for name in TIMES if name in columns), None)
    if time is None:
        raise FileError("identification.no_column", path=file.name, column="t", found=_shown(columns))
    places = {"t": [time]}
    for signal in SIGNALS:
        found = [_column(columns, signal, name, k) for k, name in enumerate(robot.joint_names, start=1)]
        missing = [k for k, place in enumerate(found) if place is None]
        if signal not in SIGNALS[:2] and len(missing) == len(found):
            continue
        if missing:
            missing_column = f"{signal}[{robot.joint_names[missing[0]]}]"
            raise FileError("identification.no_column", path=file.name, column=missing_column, found=_shown(columns))
        places[signal] = [place for place in found if place is not None]
    return places


def _column(columns: dict[str, int], signal: str, joint: str, number: int) -> int | None:
    names = (
        f"{signal}[{joint}]",
        f"{signal}_{joint}",
        f"{signal}[{number}]",
        f"{signal}{number}",
        f"{signal}_{number}",
    )
    return next((columns[name] for name in names if name in columns), None)


def _shown(columns: dict[str, int]) -> str:
    shown = list(columns)[:12]
    return ", ".join(shown) + (" ..." if len(columns) > len(shown) else "")


def _numbers(file: Path, heads: list[str], rows: list[list[str]], lines: list[int], needed: list[int]) -> Floats:
    """(N, columns) the needed cells, all finite numbers."""
    for row, line in zip(rows, lines, strict=True):
        if len(row) != len(heads):
            raise FileError("identification.cells", path=file.name, line=line, got=len(row), expected=len(heads))
    try:
        values = np.array([[float(row[k]) for k in needed] for row in rows])
    except ValueError:
        values = np.array([[_number(row[k]) for k in needed] for row in rows])
    bad = np.argwhere(~np.isfinite(values))
    if len(bad):
        row, column = int(bad[0, 0]), needed[int(bad[0, 1])]
        details = {
            "path": file.name,
            "line": lines[row],
            "column": heads[column],
            "cell": rows[row][column].strip()[:40],
        }
        raise FileError("identification.cell", **details)
    return values


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return float("nan")
