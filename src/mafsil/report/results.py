"""The files that a run leaves: written beside the goal, then put in its place in one step."""

from __future__ import annotations

import ctypes
import errno
import json
import math
import os
import platform
import shutil
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

from mafsil.errors import InputError
from mafsil.job.driving.arrival import goal_of
from mafsil.job.driving.run import Run
from mafsil.job.judging.judgement import Summary, summary
from mafsil.job.language.units import tolerances
from mafsil.job.planning.cell_signals import CellSignals
from mafsil.job.planning.limiting import MORE, CycleLimit
from mafsil.job.planning.neighbours import NeighbourMotion
from mafsil.messages import language
from mafsil.messages.visible import visible
from mafsil.model.diagnostics import shown
from mafsil.report import contents, page

RECORDED, TABLED = 0.5, 0.35
"""Shares of the size of the results that the recording and its table may take; the rest is the report's."""
NUMBER, TYPED_NUMBER = 8, 18
"""Bytes of a number in the recording, and in its table."""
FILES = ("report.html", "recording.npz", "recording.csv", "recording.json", "results.json", "job.toml")
MOST_CHANGES = 20_000
"""Of signals, that are listed."""
FORMAT = "mafsil-results-1"
_ORPHAN_AGE = 3600.0
_EXCHANGE = 2


def write_results(run: Run, directory: str | os.PathLike[str]) -> Path:
    """Write report, recording and numbers of a run into a directory.

    Args:
        run: what happened.
        directory: to be created; an earlier result in it is replaced.

    Returns:
        Path of the report.

    Raises:
        InputError: the directory holds something that is no result of ours.
        OSError: the disk is full, the place is not writable.
    """
    return write_folder(Path(directory), lambda partial: _write_all(run, partial))


def write_folder(directory: Path, write: Callable[[Path], None]) -> Path:
    """Write results into a directory, with `report.html` among them.

    All files are written into a hidden directory beside it, synced, and exchanged with it in one step: whatever
    happens, the directory holds the old results or the new ones, whole.

    Args:
        directory: to be created; an earlier result in it is replaced.
        write: puts files into a directory that is there.

    Returns:
        Path of the report.

    Raises:
        InputError: the directory holds something that is no result of ours.
        OSError: the disk is full, the place is not writable.
    """
    directory = directory.absolute()
    require_replaceable(directory)
    directory.parent.mkdir(parents=True, exist_ok=True)
    _sweep(directory)
    writer = f"{platform.node()}-{os.getpid()}"
    partial = Path(tempfile.mkdtemp(prefix=f".{directory.name}.partial-{writer}-", dir=directory.parent))
    try:
        os.chmod(partial, 0o755)
        write(partial)
        _sync(partial)
        _put(partial, directory)
    finally:
        shutil.rmtree(partial, ignore_errors=True)
    return directory / "report.html"


def require_replaceable(directory: Path) -> None:
    """Refuse to replace anything but an empty directory or an earlier result.

    Raises:
        InputError: it is a file, holds other things, or lies where nothing can be written.
    """
    try:
        exists = directory.exists()
        above = next(parent for parent in directory.absolute().parents if parent.exists())
    except OSError as error:
        raise InputError("report.unwritable", path=_short(directory), reason=error.strerror or str(error)) from None
    if not os.access(above, os.W_OK | os.X_OK) or not above.is_dir():
        raise InputError("report.unwritable", path=_short(directory), reason=os.strerror(errno.EACCES))
    if not exists:
        return
    if not directory.is_dir() or directory.is_symlink():
        raise InputError("report.no_directory", path=visible(str(directory)))
    strangers = sorted(item.name for item in directory.iterdir() if item.name not in FILES)
    if strangers:
        raise InputError("report.not_ours", path=visible(str(directory)), what=visible(strangers[0]))


def _short(path: Path) -> str:
    return shown(str(path))


def _write_all(run: Run, directory: Path) -> None:
    numbers = summary(run)
    code = run.job.report.language or language()
    write_file(directory / "report.html", page.render(*contents.pages(run, numbers, code)).encode())
    data = json.dumps(as_data(run, numbers), ensure_ascii=False, indent=2, allow_nan=False)
    write_file(directory / "results.json", data.encode())
    write_file(directory / "job.toml", run.text.encode())
    size = 1e6 * run.job.report.megabytes
    tape = run.recording.thinned(int(RECORDED * size / NUMBER))
    tape.save(directory / "recording", table_numbers=int(TABLED * size / TYPED_NUMBER))


def _sync(directory: Path) -> None:
    """The names of the files reach the disk, where the system opens directories (Windows does not)."""
    try:
        folder = os.open(directory, os.O_RDONLY)
    except PermissionError:
        return
    os.fsync(folder)
    os.close(folder)


def as_data(run: Run, numbers: Summary) -> dict[str, Any]:
    """Numbers, findings and steps as plain data."""
    names = run.robot.joint_names
    per_joint = ("joint_error", "peak_effort", "rms_effort", "peak_speed", "peak_acceleration", "lowest", "highest")
    per_joint += ("saturated",)
    single = ("duration", "cycle", "tip_error", "tip_error_time", "tip_turn", "tip_turn_time", "energy")
    return {
        "format": FORMAT,
        **run.to_dict(),
        "variables": dict(run.job.variables),
        "verdict": contents.verdict(run).level,
        "numbers": {name: _known(getattr(numbers, name)) for name in single},
        "joints": [
            {"name": joint} | {name: _known(getattr(numbers, name)[k]) for name in per_joint}
            for k, joint in enumerate(names)
        ],
        "limits": [_limit(run, one) for one in run.limits],
        "clearance": None if numbers.clearances is None else numbers.clearances.to_dict(),
        "contact": None if numbers.touching is None else numbers.touching.to_dict(),
        "signals": signals_data(run.plan.signals, numbers.duration),
        "variation": None if run.variation is None else run.variation.to_dict(),
        "steps": _steps(run),
        "other_robots": others_data(run.plan.neighbours),
        "targets": _targets(run, numbers),
        "simulation": {
            "step": run.job.simulation.step,
            "method_requested": run.job.simulation.method,
            "method": contents.method(run),
            "seconds": run.recording.metadata["seconds"],
        },
        "versions": contents.versions(),
        "files": list(FILES),
    }


def _known(value: float) -> float | None:
    """A number; None of efforts that a kinematic run does not know."""
    return None if math.isnan(value) else float(value)


def signals_data(signals: CellSignals | None, duration: float) -> dict[str, Any] | None:
    """Values of all signals at the beginning, and their changes; None where the job names none.

    Args:
        signals: of a plan.
        duration: until when [s].
    """
    if signals is None:
        return None
    changes = signals.timeline(duration, MOST_CHANGES)[len(signals.names) :]
    return {
        "outputs": list(signals.job.output),
        "inputs": list(signals.job.input),
        "start": {name: signals.value(name, 0.0) for name in signals.names},
        "changes": [change._asdict() for change in changes],
        "complete": len(changes) + len(signals.names) < MOST_CHANGES,
    }


def others_data(neighbours: tuple[NeighbourMotion, ...]) -> list[dict[str, Any]]:
    """What other robots do, move by move; nothing of those that stand."""
    return [{"name": each.neighbour.asked.name, "steps": [one.to_dict() for one in each.steps]} for each in neighbours]


def _limit(run: Run, one: CycleLimit) -> dict[str, Any]:
    """A limit of the cycle; null where more of it leaves a move without a motion."""
    return {
        "quantity": one.quantity,
        "joint": None if one.joint < 0 else run.robot.joint_names[one.joint],
        "deciding": one.deciding,
        "more": MORE,
        "saved": one.saved if math.isfinite(one.saved) else None,
    }


def _steps(run: Run) -> list[dict[str, Any]]:
    return [
        {
            "name": leg.name,
            "kind": leg.kind,
            "start": float(start),
            "end": float(start + leg.trajectory.duration),
            "target": None if leg.target is None else leg.target.tolist(),
            "choice": None if leg.decision is None else leg.decision.to_dict(),
            "way_round": None if leg.way is None else leg.way.to_dict(),
        }
        for leg, start in zip(run.plan.legs, run.plan.starts, strict=False)
    ]


def _targets(run: Run, numbers: Summary) -> list[dict[str, Any]]:
    """Every target with all its errors [m, rad, rad | m], what is allowed, what is judged; null if never come to."""
    judged = {one.leg: one for one in numbers.arrivals}
    found: list[dict[str, Any]] = []
    for k, leg in enumerate(run.plan.legs):
        goal = goal_of(leg)
        if goal is None:
            continue
        one, allowed = judged.get(k), tolerances(run.job, run.robot, leg.index)
        found.append(
            {
                "step": k,
                "move": leg.index,
                "name": leg.name,
                "judged": ["joints"] if goal == "joints" else ["position", "orientation"],
                "time": float(run.plan.starts[k + 1]),
                "position_error": None if one is None else one.position_error,
                "orientation_error": None if one is None else one.orientation_error,
                "joint_errors": None if one is None else one.joint_errors.tolist(),
                "tolerance": {
                    "position": allowed.position,
                    "orientation": allowed.orientation,
                    "joints": allowed.joints.tolist(),
                },
                "reached": one is not None and one.reached,
            }
        )
    return found


def write_file(path: Path, data: bytes) -> None:
    """Write a file so that it survives a power cut.

    Args:
        path, data: of the file.
    """
    with path.open("wb") as file:
        file.write(data)
        file.flush()
        os.fsync(file.fileno())


def _put(partial: Path, directory: Path) -> None:
    """Put the new directory in its place; the old one ends up where the new one was, to be removed."""
    if not directory.exists():
        os.rename(partial, directory)
    elif not _exchange(partial, directory):
        old = partial.with_name(partial.name + "-old")
        os.rename(directory, old)
        os.rename(partial, directory)
        shutil.rmtree(old, ignore_errors=True)


def _exchange(first: Path, second: Path) -> bool:
    """Swap two names at once, where the system can (Linux); otherwise two renames have to do."""
    if not sys.platform.startswith("linux"):
        return False
    try:
        rename = ctypes.CDLL(None, use_errno=True).renameat2
    except (OSError, AttributeError):
        return False
    here = ctypes.c_int(-100)
    return rename(here, os.fsencode(first), here, os.fsencode(second), ctypes.c_uint(_EXCHANGE)) == 0


def _sweep(directory: Path) -> None:
    """Remove what runs that were killed have left behind."""
    for orphan in directory.parent.glob(f".{directory.name}.partial-*"):
        if orphan.is_dir() and (_writer_is_gone(orphan) or time.time() - orphan.stat().st_mtime > _ORPHAN_AGE):
            shutil.rmtree(orphan, ignore_errors=True)


def _writer_is_gone(partial: Path) -> bool:
    """Whether the process that wrote there ran on this machine and does not any more."""
    host, _, number = partial.name.rpartition("-")[0].partition(".partial-")[2].rpartition("-")
    if host != platform.node() or not number.isdigit() or os.name == "nt":  # there, `kill` ends whom it asks
        return False
    try:
        os.kill(int(number), 0)
    except ProcessLookupError:
        return True
    except OSError:
        return False
    return False
