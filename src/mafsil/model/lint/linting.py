"""Everything that looks wrong in a robot description: what its reader found, and what no reader looks for."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from dataclasses import replace
from pathlib import Path
from typing import Protocol, TypeAlias, cast, runtime_checkable

import numpy as np

from mafsil.errors import FileError, InputError
from mafsil.model.diagnostics import Report
from mafsil.model.file_reader import FileReader
from mafsil.model.lint.bodies import bodies
from mafsil.model.lint.catalogue import GRAVITY_SIZE, GRAVITY_UP, NO_MASSES
from mafsil.model.lint.finding import Finding
from mafsil.model.lint.joints import joints
from mafsil.model.mechanism import Mechanism
from mafsil.model.reading import Reading
from mafsil.model.repairing import Change, mended
from mafsil.model.source import Text, load
from mafsil.model.xml_tree import DEFAULT_LIMITS, Refusal, parse

EARTH = (9.7, 9.9)
"""Gravity on the ground [m/s^2]; 0 is orbit, 1.62 the Moon, 3.7 Mars."""
ELSEWHERE = ((0.0, 0.0), (1.6, 1.64), (3.68, 3.75))


@runtime_checkable
class Described(Protocol):
    """Anything that has a mechanism, such as a Robot."""

    @property
    def mechanism(self) -> Mechanism:
        """The description."""
        ...


Source: TypeAlias = "str | Path | Mechanism | Described"


def lint(source: Source, *, packages: Iterable[str | Path] = ()) -> Report:
    """All that is wrong or looks wrong in a description, with numbers, places and repairs.

    Args:
        source: a robot, a mechanism, a file (.urdf, .xml, .toml), or a name of the library.
        packages: directories of packages for `package://` references of a file.

    Returns:
        The report of the file's reader, with the plausibility rules' diagnostics among its own; `errors` stop a reader.

    Raises:
        FileError: no such file or name, or a table that cannot be read.
        InputError: something else was given.
    """
    if isinstance(source, Mechanism):
        return _without_file(source)
    if isinstance(source, str | Path):
        reader = _reader(source, packages)
        if reader is None:
            return _without_file(_described(source))
        try:
            text = load(Path(source))
        except Refusal as refusal:
            return Report(str(source), (refusal.diagnostic,))
        return _combined(reader, repairs=_is_urdf(source))(text)
    if isinstance(source, Described):  # pyright: ignore[reportUnnecessaryIsInstance]
        return _without_file(source.mechanism)
    raise InputError("lint.source", got=type(cast(object, source)).__name__)


def mend(source: str | Path, *, packages: Iterable[str | Path] = ()) -> tuple[str, tuple[Change, ...]]:
    """A corrected URDF document, and what was changed in it; what has no single repair remains.

    Args:
        source: a URDF file; it is not touched.
        packages: as for `lint`.

    Raises:
        FileError: it cannot be read at all.
        InputError: not a URDF file.
    """
    reader = _reader(source, packages) if _is_urdf(source) else None
    if reader is None:
        raise InputError("lint.only_urdf", source=str(source))
    text, changes = mended(Path(source), DEFAULT_LIMITS, _combined(reader, repairs=True))
    return text.data.decode("utf-8"), changes


def findings(mechanism: Mechanism, *, from_file: bool = False) -> Iterator[Finding]:
    """What the plausibility rules find in a mechanism.

    Args:
        mechanism: any.
        from_file: leave out what the file readers judge.
    """
    yield from bodies(mechanism, from_file=from_file)
    yield from joints(mechanism, from_file=from_file)
    yield from _whole(mechanism)


def _whole(mechanism: Mechanism) -> Iterator[Finding]:
    """Gravity, and whether there is any mass."""
    up, size = float(mechanism.gravity[2]), float(np.linalg.norm(mechanism.gravity))
    facts: dict[str, object] = {"gravity": ", ".join(f"{x:.4g}" for x in mechanism.gravity), "size": f"{size:.4g}"}
    if up > 0.5 * size > 0:
        yield Finding(GRAVITY_UP, "robot", mechanism.name, facts)
    if not any(low <= size <= high for low, high in (EARTH, *ELSEWHERE)):
        yield Finding(GRAVITY_SIZE, "robot", mechanism.name, facts)
    if not any(link.inertial is not None and link.inertial.mass for link in mechanism.links):
        yield Finding(NO_MASSES, "robot", mechanism.name, {"robot": mechanism.name})


def _without_file(mechanism: Mechanism) -> Report:
    remarks = tuple(finding.without_place() for finding in findings(mechanism))
    return Report(mechanism.name, remarks, mechanism)


def _combined(reader: FileReader, *, repairs: bool) -> Callable[[Text], Report]:
    """A reader whose reports hold the plausibility rules' diagnostics too."""

    def report_of(text: Text) -> Report:
        report = reader.report_of(text)
        if report.mechanism is None:
            return report
        reading = Reading(parse(text.data, reader.limits), list(report.diagnostics))
        for finding in findings(report.mechanism, from_file=True):
            finding.report(reading, repairs=repairs)
        ordered = sorted(reading.diagnostics, key=lambda d: (d.file, d.line, d.column))
        return replace(report, diagnostics=tuple(ordered))

    return report_of


def _reader(source: str | Path, packages: Iterable[str | Path]) -> FileReader | None:
    """The reader of a file's format, or None for a table or a name."""
    match Path(source).suffix.lower():
        case ".urdf":
            from mafsil.model.urdf.reader import file_reader

            return file_reader(packages)
        case ".xml" | ".mjcf":
            from mafsil.model.mjcf.reader import file_reader

            return file_reader(packages)
        case _:
            return None


def _described(source: str | Path) -> Mechanism:
    """The mechanism of a table or of a library name."""
    if Path(source).suffix.lower() == ".toml":
        from mafsil.model import table

        return table.read(Path(source))
    from mafsil.model import library

    if str(source) not in (*library.names(), "default"):
        raise FileError("robot.no_file", source=str(source)[:100], close="", known=", ".join(library.names()))
    return library.load(str(source))


def _is_urdf(source: str | Path) -> bool:
    return Path(source).suffix.lower() == ".urdf"
