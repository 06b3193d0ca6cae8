"""Everything that looks wrong in a robot description: what its reader found, and what no reader looks for.

Limits of URDF files that our reader takes and urdfdom refuses, and with it ROS, MoveIt and Pinocchio.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator
from dataclasses import replace
from difflib import get_close_matches
from os import PathLike
from pathlib import Path
from typing import Protocol, TypeAlias, cast, runtime_checkable

import numpy as np

from mafsil.errors import FileError, InputError
from mafsil.model import library, table
from mafsil.model.diagnostics import Diagnostic, Repair, Report
from mafsil.model.faults import DH_DEGREES, NO_BOUND, NO_LIMIT
from mafsil.model.faults import FAULTS as READER_FAULTS
from mafsil.model.file_reader import Change, FileReader, apply_repairs, of_errors
from mafsil.model.limits import UNBOUNDED
from mafsil.model.lint.bodies import bodies
from mafsil.model.lint.finding import BOUND_REFUSED, FAULTS, GRAVITY_SIZE, GRAVITY_UP, LIMIT_REFUSED, NO_MASSES, Finding
from mafsil.model.lint.joints import joints
from mafsil.model.loading import RobotFile
from mafsil.model.mechanism import Mechanism
from mafsil.model.reading import Reading, written
from mafsil.model.robot_source import reader_of, root_tag
from mafsil.model.source import Text, load
from mafsil.model.urdf.vocabulary import WIDER_LIMITS, version_of
from mafsil.model.xacro import is_xacro, left_over
from mafsil.model.xml_tree import DEFAULT_LIMITS, Element, Refusal, parse
from mafsil.regular_file import is_file

MOVING = ("revolute", "prismatic", "continuous")
"""Joints whose limits our reader looks at."""
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


Source: TypeAlias = "str | PathLike[str] | Mechanism | Described"


def lint(source: Source, *, packages: Iterable[str | Path] = ()) -> Report:
    """Errors and suspicious values of a robot description, each with its number, place and repair.

    Args:
        source: a robot, a mechanism, a file (URDF, xacro, MJCF, SDFormat, a table), or a name of the library.
        packages: directories of packages for `package://` references of a file.

    Returns:
        The report of the file's reader, with the plausibility rules' diagnostics among its own; `errors` stop a reader,
        ours or, of limits in URDF, that of ROS and Pinocchio.

    Raises:
        FileError: no such file or name, or a table that cannot be read.
        InputError: something else was given.
    """
    if isinstance(source, Mechanism):
        return _without_file(source)
    if isinstance(source, str | PathLike):
        reader = _reader(source, packages)
        if reader is None:
            return _without_file(_describe(source))
        try:
            text = load(Path(source))
        except Refusal as refusal:
            return Report(str(source), (refusal.diagnostic,))
        return _combine(reader, repairs=_can_be_mended(source))(text)
    if isinstance(source, Described):  # pyright: ignore[reportUnnecessaryIsInstance]
        return _without_file(source.mechanism)
    raise InputError("lint.source", got=type(cast(object, source)).__name__)


def repair(
    source: str | PathLike[str], *, packages: Iterable[str | Path] = (), only: Collection[str] = ()
) -> tuple[str, tuple[Change, ...]]:
    """A corrected document and its changes; findings with several possible repairs are left as they are.

    A repair never takes a freedom from the robot.

    Args:
        source: a URDF, MJCF or SDFormat file; it is not touched.
        packages: as for `lint`.
        only: codes such as `I0506`: their repairs alone are carried out, those of warnings and guesses too. By default
            errors are repaired, where the repair leaves no choice, and what only forgiving readers take.

    Raises:
        FileError: it cannot be read at all.
        InputError: a xacro, a table, no robot file, or a code that does not exist.
    """
    for code in only:
        if code not in READER_FAULTS and code not in FAULTS:
            close = get_close_matches(code.upper(), [*READER_FAULTS, *FAULTS], n=3)
            raise InputError("lint.no_code", code=code[:40], close=", ".join(close))
    is_urdf, reader = _can_be_mended(source), _reader(source, packages)
    if reader is None or (not is_urdf and root_tag(Path(source)) == "robot"):
        raise InputError("lint.only_urdf", source=str(source))

    def requested(diagnostic: Diagnostic) -> bool:
        return diagnostic.code in only if only else of_errors(diagnostic)

    text, changes = apply_repairs(Path(source), DEFAULT_LIMITS, _combine(reader, repairs=is_urdf), requested)
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
    details: dict[str, object] = {"gravity": ", ".join(f"{x:.4g}" for x in mechanism.gravity), "size": f"{size:.4g}"}
    if up > 0.5 * size > 0:
        yield Finding(GRAVITY_UP, "robot", mechanism.name, details)
    if not any(low <= size <= high for low, high in (EARTH, *ELSEWHERE)):
        yield Finding(GRAVITY_SIZE, "robot", mechanism.name, details)
    if not any(link.inertial is not None and link.inertial.mass for link in mechanism.links):
        yield Finding(NO_MASSES, "robot", mechanism.name, {"robot": mechanism.name})


def _without_file(mechanism: Mechanism) -> Report:
    """The remarks about a robot without a file, with those about the table that it was made of."""
    of_table = [d for d in mechanism.provenance.remarks if isinstance(d, Diagnostic) and d.fault is DH_DEGREES]
    remarks = (*of_table, *(finding.without_place() for finding in findings(mechanism)))
    return Report(mechanism.name, remarks, mechanism)


def _combine(reader: FileReader, *, repairs: bool) -> Callable[[Text], Report]:
    """A reader whose reports hold the plausibility rules' diagnostics too."""

    def report_of(text: Text) -> Report:
        report = reader.report_of(text)
        if report.mechanism is None:
            return report
        reading = Reading(parse(text.data, reader.limits), list(report.diagnostics))
        for finding in findings(report.mechanism, from_file=True):
            finding.report(reading, repairs=repairs)
        if reading.document.root.tag == "robot":
            refuse_limits(reading, repairs=repairs)
        ordered = sorted(reading.diagnostics, key=lambda d: (d.file, d.line, d.column))
        return replace(report, diagnostics=tuple(ordered))

    return report_of


def _reader(source: str | PathLike[str], packages: Iterable[str | Path]) -> FileReader | None:
    """The reader of a file's format, or None for a table or a name."""
    path = Path(source)
    if path.suffix.lower() == ".toml" or not (path.suffix or is_file(path)):
        return None
    requested = source if isinstance(source, RobotFile) else RobotFile(str(source), {})
    return reader_of(path, packages, requested.texts, requested.model)


def _describe(source: str | PathLike[str]) -> Mechanism:
    """The mechanism of a table or of a library name."""
    if Path(source).suffix.lower() == ".toml":
        return table.read(Path(source))
    if library.library_name(str(source)) is None:
        raise FileError("robot.no_file", source=str(source)[:100], close="", known=", ".join(library.robots()))
    return library.load(str(source))


def _can_be_mended(source: str | PathLike[str]) -> bool:
    """Whether a file is URDF as it stands; a xacro is mended where its parts are written."""
    try:
        root = parse(load(Path(source)).data).root
    except Refusal:
        return Path(source).suffix.lower() == ".urdf"
    return root.tag == "robot" and (not is_xacro(root) or bool(left_over(root)))


def refuse_limits(reading: Reading, *, repairs: bool) -> None:
    """Make errors of the remarks that a limit is missing, and look at joints whose limits our reader does not need.

    Args:
        reading: of a URDF file, with its reader's diagnostics.
        repairs: whether the file itself can be changed.
    """
    root = reading.document.root
    joints = {joint.get("name"): joint for joint in root.all("joint")}
    reading.diagnostics[:] = [_raise(reading, remark, joints, repairs) for remark in reading.diagnostics]
    wider = version_of(Reading(reading.document), root) >= WIDER_LIMITS
    for joint in joints.values():
        for limit, attribute in _gaps(joint, wider=wider):
            if wider or joint.get("type") not in MOVING:
                none = written(-UNBOUNDED if attribute == "lower" else UNBOUNDED)
                repair = reading.set_attribute(limit, attribute, none) if repairs else None
                reading.report(BOUND_REFUSED, limit, None, repair, joint=joint.get("name"), attribute=attribute)


def _raise(reading: Reading, remark: Diagnostic, joints: dict[str, Element], repairs: bool) -> Diagnostic:
    """The remark as an error with its repair, if it is about a limit that urdfdom demands."""
    if remark.fault not in (NO_LIMIT, NO_BOUND):
        return remark
    joint = joints.get(str(remark.details["joint"])) if repairs else None
    limit = None if joint is None else joint.first("limit")
    if remark.fault is NO_BOUND:
        attribute = str(remark.details["attribute"])
        repair = None if limit is None else reading.set_attribute(limit, attribute, written(UNBOUNDED))
        return replace(remark, fault=BOUND_REFUSED, repair=repair)
    return replace(remark, fault=LIMIT_REFUSED, repair=None if joint is None else _with_limit(reading, joint))


def _with_limit(reading: Reading, joint: Element) -> Repair:
    """A joint without a `limit` may turn without end, or its range is open: a guess either way."""
    if joint.get("type") == "revolute":
        return reading.set_attribute(joint, "type", "continuous", guess=True)
    none = written(UNBOUNDED)
    text = f'<limit lower="-{none}" upper="{none}" effort="{none}" velocity="{none}"/>'
    return replace(reading.append(joint, text), guess=True)


def _gaps(joint: Element, *, wider: bool) -> Iterator[tuple[Element, str]]:
    """What a `limit` has to have: effort and velocity, from URDF 1.2 on the range alone, where there is one."""
    ranged = joint.get("type") in ("revolute", "prismatic")
    demanded = (("lower", "upper") if ranged else ()) if wider else ("effort", "velocity")
    for limit in joint.all("limit")[:1]:
        yield from ((limit, attribute) for attribute in demanded if attribute not in limit.attributes)
