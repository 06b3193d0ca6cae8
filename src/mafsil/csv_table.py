"""Tables of numbers in CSV files: named columns in any order, and a complaint that names the line."""

from __future__ import annotations

import csv
import errno
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from io import StringIO
from os import PathLike
from pathlib import Path

import numpy as np

from mafsil.arrays import Floats
from mafsil.errors import FileError
from mafsil.regular_file import reason, whole_text

TIMES = ("t", "time")
"""Names of the column of times."""
MOST_BYTES = 1 << 31
"""Larger files are not read."""
ROWS_AT_ONCE = 4096
"""Rows that are turned into text together, so that a long table takes little memory."""


@dataclass(frozen=True, slots=True)
class CsvTable:
    """Cells under a heading line.

    Attributes:
        file: its name, for sentences.
        heads: names of the columns.
        rows: cells of each row, as text.
        lines: line of each row in the file.
    """

    file: str
    heads: list[str]
    rows: list[list[str]]
    lines: list[int]

    def column(self, *names: str) -> int | None:
        """Place of the first column that bears one of the names, None if there is none."""
        return next((self.heads.index(name) for name in names if name in self.heads), None)

    def joint_column(self, signal: str, joint: str, number: int) -> int | None:
        """Place of a joint's column: `q[NAME]`, `q_NAME`, `q[1]`, `q1` or `q_1`.

        Args:
            signal: what is recorded of the joint.
            joint: its name.
            number: its place among the joints, counted from 1.
        """
        return self.column(
            f"{signal}[{joint}]", f"{signal}_{joint}", f"{signal}[{number}]", f"{signal}{number}", f"{signal}_{number}"
        )

    def joint_columns(self, signal: str, joints: Sequence[str], *, required: bool) -> list[int] | None:
        """Places of one column for each joint, in the order of the joints; None if there is none at all.

        Raises:
            FileError: some joints lack their column, or all do and they are required.
        """
        found = [self.joint_column(signal, joint, k) for k, joint in enumerate(joints, start=1)]
        places = [place for place in found if place is not None]
        if not places and not required:
            return None
        if len(places) < len(found):
            raise self.no_column(f"{signal}[{joints[found.index(None)]}]")
        return places

    def time_column(self) -> int:
        """Place of the column of times.

        Raises:
            FileError: there is none.
        """
        place = self.column(*TIMES)
        if place is None:
            raise self.no_column(TIMES[0])
        return place

    def no_column(self, name: str) -> FileError:
        """The complaint that a column is missing, with the columns that there are."""
        shown = ", ".join(self.heads[:12]) + (" ..." if len(self.heads) > 12 else "")
        return FileError("csv_table.no_column", path=self.file, column=name, found=shown)

    def numbers(self, columns: Sequence[int]) -> Floats:
        """(N, columns) the cells of these columns, all finite numbers.

        Raises:
            FileError: a row of another length, or a cell that is no finite number; line and column are named.
        """
        for row, line in zip(self.rows, self.lines, strict=True):
            if len(row) != len(self.heads):
                details = {"path": self.file, "line": line, "got": len(row), "expected": len(self.heads)}
                raise FileError("csv_table.cells", **details)
        try:
            values = np.array([[float(row[k]) for k in columns] for row in self.rows])
        except ValueError:
            values = np.array([[_number(row[k]) for k in columns] for row in self.rows])
        bad = np.argwhere(~np.isfinite(values))
        if len(bad):
            row, place = int(bad[0, 0]), columns[int(bad[0, 1])]
            cell = self.rows[row][place].strip()[:40]
            raise FileError("csv_table.cell", path=self.file, line=self.lines[row], column=self.heads[place], cell=cell)
        return values

    def require_increasing(self, times: Floats) -> None:
        """Refuse times (N,) that do not increase.

        Raises:
            FileError: the first line whose time does not come after that of the line before it.
        """
        backward = np.flatnonzero(np.diff(times) <= 0.0)
        if len(backward):
            k = int(backward[0]) + 1
            details = {"path": self.file, "line": self.lines[k], "now": times[k], "before": times[k - 1]}
            raise FileError("csv_table.time_order", **details)


def read_csv_table(path: str | PathLike[str], *, fewest: int = 2) -> CsvTable:
    """The table of a CSV file: comma, semicolon or tab between columns.

    Empty lines and lines that begin with # are passed over; the first other line holds the names of the columns.

    Args:
        path: of the file, in UTF-8.
        fewest: rows of numbers that make sense.

    Raises:
        FileError: no such file, no text, too large, too few rows, a broken line, or two columns of one name.
    """
    file = Path(path)
    body = _text(file).splitlines()
    head = next((line for line in body if line.strip() and not line.startswith("#")), "")
    rows, lines = list[list[str]](), list[int]()
    for line, cells in enumerate(_cells(file, body, max(",;\t", key=head.count)), start=1):
        if any(cell.strip() for cell in cells) and not cells[0].startswith("#"):
            rows.append(cells)
            lines.append(line)
    if len(rows) <= fewest:
        raise FileError("csv_table.empty", path=file.name, rows=max(len(rows) - 1, 0))
    heads = [cell.strip() for cell in rows[0]]
    twice = next((name for k, name in enumerate(heads) if name in heads[:k]), None)
    if twice is not None:
        raise FileError("csv_table.column_twice", path=file.name, column=twice)
    return CsvTable(file.name, heads, rows[1:], lines[1:])


def csv_text(columns: dict[str, Floats]) -> Iterator[bytes]:
    """A CSV file in pieces: heading, then rows with the shortest digits that read back exactly.

    Args:
        columns: (N,) numbers of each column, by its name.
    """
    yield _heading(columns)
    count = len(next(iter(columns.values()), ()))
    for first in range(0, count, ROWS_AT_ONCE):
        piece = np.stack([column[first : first + ROWS_AT_ONCE] for column in columns.values()], axis=1)
        yield "".join(",".join(map(repr, row)) + "\n" for row in piece.tolist()).encode()


def joint_columns(signals: Sequence[str], values: Sequence[Floats], joints: Sequence[str]) -> dict[str, Floats]:
    """(N,) columns `SIGNAL[JOINT]` of signals whose values are (N, joints) each."""
    return {
        f"{signal}[{joint}]": array[:, k]
        for signal, array in zip(signals, values, strict=True)
        for k, joint in enumerate(joints)
    }


def _heading(names: Iterable[str]) -> bytes:
    line = StringIO()
    csv.writer(line, lineterminator="\n").writerow(names)
    return line.getvalue().encode()


def _text(file: Path) -> str:
    try:
        return whole_text(file, MOST_BYTES, "utf-8-sig")
    except FileNotFoundError:
        raise FileError("csv_table.no_file", path=str(file)) from None
    except (OSError, ValueError) as fault:
        if isinstance(fault, OSError) and fault.errno == errno.EFBIG:
            raise FileError("csv_table.too_large", path=file.name, limit=MOST_BYTES >> 20) from None
        raise FileError("csv_table.unreadable", path=str(file), fault=reason(fault)) from None


def _cells(file: Path, body: Iterable[str], separator: str) -> Iterator[list[str]]:
    """Line by line: a quoted cell cannot run over lines."""
    for number, line in enumerate(body, start=1):
        try:
            yield next(csv.reader([line], delimiter=separator), [""]) or [""]
        except csv.Error as fault:
            raise FileError("csv_table.bad_line", path=file.name, line=number, fault=str(fault)) from None


def _number(cell: str) -> float:
    try:
        return float(cell)
    except ValueError:
        return float("nan")
