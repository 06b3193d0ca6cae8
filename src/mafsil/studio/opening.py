"""What a studio opens with: a robot, a job or recordings, told apart by what they are."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from mafsil.errors import FileError, InputError, MafsilError
from mafsil.job.language.reading import parse_job, read_job
from mafsil.job.language.text import LARGEST_FILE, text_of
from mafsil.job.planning.equipment import equip_robot
from mafsil.messages.visible import visible
from mafsil.model import library
from mafsil.regular_file import regular_bytes
from mafsil.robot import Robot
from mafsil.simulation import Recording
from mafsil.studio.recordings import Recorded
from mafsil.studio.studio import Script, Studio
from mafsil.toml_source import parsed_toml

DEFAULT_ROBOT = "panda"
TAPE, JOB, REPORT = "recording.npz", "job.toml", "report.html"
"""Names of the files in a folder of results."""


@dataclass(frozen=True, eq=False)
class _Tape:
    """A recording as it was given: its motion, and the folder of its results if it lies in one."""

    path: Path
    recording: Recording
    folder: Path | None


def studio_of(what: Sequence[str], port: int, views: Sequence[str] = ()) -> Studio:
    """The studio of what was given.

    Args:
        what: at most one robot or job, any number of recordings.
        port: 0 for any that is free.
        views: files with views of your own.

    Raises:
        InputError: two robots or jobs, a recording of another robot, a port that is taken.
        MafsilError: something cannot be read.
    """
    tapes = [_tape(Path(word)) for word in what if _is_tape(Path(word))]
    others = [word for word in what if not _is_tape(Path(word))]
    if len(others) > 1:
        raise InputError("studio.one_robot", first=visible(others[0]), second=visible(others[1]))
    studio = _studio(others[0], port, views) if others else _studio_of_tapes(tapes, port, views)
    _add(studio, tapes)
    return studio


def robot_of_job(path: str | Path) -> Robot:
    """The robot of a job file, with its tool and its locked joints.

    Args:
        path: of the file.

    Raises:
        MafsilError: the file or its robot cannot be read.
    """
    return equip_robot(read_job(Path(path)), Path(path).parent)


def _studio(word: str, port: int, views: Sequence[str]) -> Studio:
    path = Path(word)
    if not _is_job(path):
        return Studio(word, port=port, views=views)
    robot = robot_of_job(path)
    return Studio(robot, port=port, script=_script(path), job=(text_of(path), path), views=views)


def _studio_of_tapes(tapes: Sequence[_Tape], port: int, views: Sequence[str]) -> Studio:
    """The studio of the robot that the first recording was made with."""
    if not tapes:
        return Studio(DEFAULT_ROBOT, port=port, views=views)
    first = tapes[0]
    job = None if first.folder is None else first.folder / JOB
    if job is not None and job.is_file():
        robot, script = _robot_of_results(job), _script(job)
        return Studio(robot, port=port, script=script, job=(text_of(job), None), views=views)
    name = str(first.recording.metadata.get("robot"))
    if library.library_name(name) is None:
        raise InputError("studio.which_robot", path=visible(str(first.path)), robot=visible(name))
    return Studio(name, port=port, views=views)


def _robot_of_results(job: Path) -> Robot:
    """The robot of a job that was copied beside its results: files are looked for here, where they may still be."""
    asked = parse_job(text_of(job), job.name)
    try:
        return equip_robot(asked, Path())
    except FileError as error:
        raise InputError("studio.robot_gone", path=visible(str(job)), reason=error) from None


def _add(studio: Studio, tapes: Sequence[_Tape]) -> None:
    names = [str(name) for name in studio.arm.robot.joint_names]
    try:
        for tape in tapes:
            joints = [str(name) for name in tape.recording.metadata["joints"]]
            if joints != names:
                raise InputError(
                    "studio.other_joints", path=visible(str(tape.path)), robot=visible(studio.arm.robot.name)
                )
            report = None if tape.folder is None or not (tape.folder / REPORT).is_file() else tape.folder / REPORT
            studio.recordings.add(Recorded(_title(tape), tape.recording, report))
    except MafsilError:
        studio.server.close()
        raise


def _title(tape: _Tape) -> str:
    return (tape.path if tape.folder is None else tape.folder.absolute()).name


def _tape(path: Path) -> _Tape:
    folder = path if path.is_dir() else path.parent if path.name == TAPE else None
    return _Tape(path, Recording.load(path / TAPE if path.is_dir() else path), folder)


def _is_tape(path: Path) -> bool:
    return path.suffix.lower() == ".npz" or (path.is_dir() and (path / TAPE).is_file())


def _is_job(path: Path) -> bool:
    """Whether a TOML file is a job: it names a robot and moves; what cannot be read is left to whoever reads it."""
    if path.suffix.lower() != ".toml" or not path.is_file():
        return False
    try:
        data = parsed_toml(text_of(path))
    except (ValueError, MafsilError):
        return b"[[move]]" in regular_bytes(path, LARGEST_FILE)
    return "move" in data or isinstance(data.get("robot"), str)


def _script(job: Path) -> Script:
    return Script(f"robot_of_job({str(job)!r})", ("from mafsil.studio.opening import robot_of_job",))
