"""`mafsil check-homework`: a Denavit-Hartenberg table, screw axes or a Jacobian, in a file or typed, against a robot.

A file of homework is a robot table in TOML, of which only the rows count, or holds a Jacobian:

    jacobian = [["-L1*s1 - L2*s12", "-L2*s12"], ["L1*c1 + L2*c12", "L2*c12"]]
    kind = "tip"                 # space (default), body or tip
    values = { l = 0.5 }         # of letters of your own
    q = [0.1, 0.2]               # rad | m, only if the entries are numbers
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from math import radians
from pathlib import Path
from typing import Literal, cast

import msgspec
import numpy as np
from numpy.typing import ArrayLike

from mafsil.cli.answer import Answer, Toned
from mafsil.cli.state import coordinate, joint_values, number
from mafsil.derivation import Review, check_dh, check_jacobian, check_screws
from mafsil.derivation.check_jacobian import Kind
from mafsil.errors import FileError, InputError
from mafsil.messages import in_sentence, say
from mafsil.model import Mechanism
from mafsil.model.denavit_hartenberg import DHRow
from mafsil.model.loading import load_mechanism
from mafsil.model.table.building import constants_of, rows_of, screws_of
from mafsil.model.table.reading import SIZE_LIMIT, decode
from mafsil.regular_file import regular_bytes
from mafsil.toml_source import parsed_toml

_ANGLES = ("alpha", "theta")
_ORDER = ("a", "alpha", "d", "theta")
_PLAIN = re.compile(r"[\s\d.eE+-]*")


class JacobianWork(msgspec.Struct, forbid_unknown_fields=True, frozen=True):
    """A file with a Jacobian."""

    jacobian: list[list[str | float]]
    kind: Literal["space", "body", "tip"] | None = None
    values: dict[str, float] = {}
    q: list[float] | None = None


def check_homework(
    robot: str,
    file: str | None,
    dh: list[str] | None,
    screws: list[str] | None,
    jacobian: list[str] | None,
    convention: str | None,
    kind: str | None,
    q: list[str] | None,
    letter: list[str] | None,
    tip: str | None,
    degrees: bool,
) -> Answer:
    """Whether a student's table, screws or Jacobian are those of a robot, and where they are wrong.

    Args:
        robot: name or file.
        file: with the work, or None if it is typed.
        dh: rows `a alpha d theta [R|P]`, or with names: `alpha=90 d=0.4`.
        screws: rows of six numbers (omega, v).
        jacobian: rows of numbers or formulas, entries separated by commas.
        convention: of the rows, modified if None; a file has its own.
        kind: form of screws (space, body) or of the Jacobian (space, body, tip); space if None.
        q: configuration of a Jacobian in numbers.
        letter: numbers of the student's own letters.
        tip: another tip link.
        degrees: angles without a unit are degrees.

    Raises:
        MafsilError: nothing to check or too much, no such robot, a file or a row that cannot be read.
    """
    mechanism = load_mechanism(robot, tip=tip)
    if sum(work is not None for work in (file, dh, screws, jacobian)) != 1:
        raise InputError("cli.check_homework_one")
    if file is not None:
        review = _of_file(file, mechanism, convention, kind)
    elif dh is not None:
        rows = [_dh_row(k, text, degrees=degrees) for k, text in enumerate(dh, start=1)]
        review = check_dh(rows, mechanism, convention or "modified")
    elif screws is not None:
        review = check_screws(_screw_rows(screws), mechanism, _form(kind))
    else:
        state = None if q is None else joint_values("q", q, mechanism, degrees=degrees)
        letters = dict(_letter(text) for text in letter or ())
        review = _of_jacobian([row.split(",") for row in jacobian or ()], mechanism, kind, state, letters)
    first, *rest = [in_sentence(line) for line in review.message().split("\n")]
    lines = (Toned(first, "good" if review.correct else "bad"), *rest)
    refusal = (
        None if review.correct else say("cli.check_homework_wrong", robot=mechanism.name, count=len(review.findings))
    )
    return Answer({"robot": mechanism.name, **review.to_dict()}, lines, refusal)


def _of_file(file: str, mechanism: Mechanism, convention: str | None, kind: str | None) -> Review:
    """The review of a file: what it holds is seen from its keys."""
    try:
        text = regular_bytes(Path(file), SIZE_LIMIT).decode("utf-8-sig")
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise FileError("table.open", path=file, reason=reason) from None
    if re.search(r"(?m)^\s*jacobian\s*=", text):
        work = _jacobian_work(text, file)
        entries = [[str(entry) for entry in row] for row in work.jacobian]
        return _of_jacobian(entries, mechanism, kind or work.kind, work.q, work.values)
    table = decode(text, file)
    if table.convention in ("space", "body"):
        return check_screws(np.array(screws_of(table)), mechanism, _form(kind or table.convention))
    if table.convention == "frames":
        raise InputError("cli.check_homework_frames", path=file)
    base, tool = constants_of(table)
    return check_dh(rows_of(table), mechanism, convention or table.convention, base=base, tool=tool)


def _jacobian_work(text: str, file: str) -> JacobianWork:
    try:
        return msgspec.convert(parsed_toml(text), JacobianWork)
    except ValueError as error:
        raise FileError("table.toml", path=file, reason=str(error)) from None


def _of_jacobian(
    rows: Sequence[Sequence[str]],
    mechanism: Mechanism,
    kind: str | None,
    q: ArrayLike | None,
    letters: dict[str, float],
) -> Review:
    """Numbers at a configuration, else formulas."""
    form = cast("Kind", kind or "space")
    entries = [[entry.strip() for entry in row] for row in rows]
    if len({len(row) for row in entries}) > 1:
        raise InputError("derivation.ragged")
    if q is not None and all(entry and _PLAIN.fullmatch(entry) for row in entries for entry in row):
        values = [[number("jacobian", entry) for entry in row] for row in entries]
        return check_jacobian(values, mechanism, q, form)
    return check_jacobian(entries, mechanism, None, form, values=letters)


def _form(kind: str | None) -> Literal["space", "body"]:
    if kind not in (None, "space", "body"):
        raise InputError("derivation.form", value=kind, known="space, body")
    return kind or "space"


def _screw_rows(texts: list[str]) -> list[list[float]]:
    """Rows of six numbers."""
    rows = [[number("screws", word) for word in text.replace(",", " ").split()] for text in texts]
    for k, row in enumerate(rows, start=1):
        if len(row) != 6:
            raise InputError("cli.check_homework_screw", row=k, got=len(row))
    return rows


def _dh_row(k: int, text: str, *, degrees: bool) -> DHRow:
    """One typed row: numbers in order, or names with numbers, and the kind of the joint."""
    values: dict[str, float] = {}
    kind: Literal["R", "P"] = "R"
    for word in text.replace(",", " ").split():
        name, sign, typed = word.rpartition("=")
        if not sign and word.upper() in ("R", "P"):
            kind = "R" if word.upper() == "R" else "P"
            continue
        if not sign and len(values) < len(_ORDER):
            name = _ORDER[len(values)]
        if name not in _ORDER or name in values:
            raise InputError("cli.check_homework_row", row=k, word=word)
        value, marked = coordinate(f"dh[{k}].{name}", typed)
        values[name] = radians(value) if degrees and name in _ANGLES and not marked else value
    return DHRow(kind=kind, **values)


def _letter(text: str) -> tuple[str, float]:
    name, sign, value = text.partition("=")
    if not sign or not name.strip().isidentifier():
        raise InputError("cli.check_homework_letter_unread", text=text)
    return name.strip(), number(name.strip(), value)
