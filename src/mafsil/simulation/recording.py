"""What a run leaves behind: arrays on one time axis, a status, and files that are whole or not there."""

from __future__ import annotations

import json
import os
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import NDArray

from mafsil.answer import Answer, Status
from mafsil.arrays import Floats, Integers
from mafsil.errors import FileError
from mafsil.lazy_module import lazily
from mafsil.messages import say
from mafsil.messages.tables import in_notebook
from mafsil.messages.visible import visible
from mafsil.simulation.clock import Deadlines
from mafsil.simulation.findings import (
    alternating_sentence,
    brief_contact_sentence,
    chatter_sentence,
    joined_events,
    joint_table,
    near_singular_sentence,
    rigid_sentences,
    saturation_sentence,
)
from mafsil.simulation.live_log import SUFFIX
from mafsil.simulation.stepping import IMPLICIT_FRICTION, STIFF
from mafsil.whole_file import write_whole

if TYPE_CHECKING:
    import mafsil.csv_table as csv_table
    import mafsil.simulation.log_reading as log_reading
    import mafsil.simulation.stored_arrays as stored_arrays
else:
    csv_table = lazily("mafsil.csv_table")
    log_reading = lazily("mafsil.simulation.log_reading")
    stored_arrays = lazily("mafsil.simulation.stored_arrays")

if TYPE_CHECKING:
    from mafsil.simulation.log_reading import LoggedRun

FORMAT = 1
ENDS = ("run_ends", "runs_lost", "runs_blown_up")
"""What the metadata say of runs side by side that ended early: the last time of each [s], and which did why."""
"""Version of the file layout."""
OPTIONAL = ("contact_wrench",)
"""Arrays that a recording may lack."""
WRENCH = ("mx", "my", "mz", "fx", "fy", "fz")
"""Names of its columns in tables."""
TABLE_NUMBERS = 1_000_000
"""Numbers that the CSV file holds at most (about 20 MB). Longer runs leave ticks out there, never in the npz file."""


class SimulationStatus(Status):
    """How a run ended."""

    COMPLETED = ("simulation.completed", True)
    BLOWN_UP = ("simulation.blown_up", False)
    NOT_FINITE = ("simulation.not_finite", False)
    CANCELLED = ("simulation.cancelled", False)
    INTERRUPTED = ("simulation.interrupted", False)
    LAW_RAISED = ("simulation.law_raised", False)
    LAW_NONSENSE = ("simulation.law_nonsense", False)
    BLIND = ("simulation.blind", False)
    LOOPS_LOST = ("simulation.run_lost_loops", False)
    NO_CONTACT_FORCE = ("simulation.run_no_contact_force", False)
    LOG_TORN = ("simulation.log_torn", False)


@dataclass(frozen=True, eq=False, kw_only=True, repr=False)
class Recording(Answer):
    """A run, tick by tick: the time is the first axis, then batch dimensions, then joints.

    True if the run reached its end; iterable over the runs of a batch.

    Attributes:
        t: (k,) times of the control ticks [s].
        q, qd, qdd: (k, *batch, n) motion [rad | m] and time derivatives.
        q_ref, qd_ref, qdd_ref: (k, *batch, n) the reference.
        tau: (k, *batch, n) efforts that acted after each tick [N m | N].
        tau_commanded: (k, *batch, n) efforts before clipping [N m | N].
        tip_position_error: (k, *batch) distance of the tip from the reference tip [m].
        tip_rotation_error: (k, *batch) angle between them [rad].
        status: how the run ended.
        contact_wrench: (k, *batch, 6) what the environment exerts on the tip, in the tip frame [N m, N]; None without
            one.
        metadata: version, robot, joints, integrator, step, period, seeds, seconds of computing; with a rigid surface
            `rigid_contact`, the events of contact.
    """

    t: Floats
    q: Floats
    qd: Floats
    qdd: Floats
    q_ref: Floats
    qd_ref: Floats
    qdd_ref: Floats
    tau: Floats
    tau_commanded: Floats
    tip_position_error: Floats
    tip_rotation_error: Floats
    status: SimulationStatus
    metadata: dict[str, Any]
    contact_wrench: Floats | None = None

    def __len__(self) -> int:
        return self.q.shape[1] if self.q.ndim > 2 else 1

    def __iter__(self) -> Iterator[Recording]:
        if self.q.ndim <= 2:
            return iter((self,))
        return (self._run(k) for k in range(len(self)))

    def __repr__(self) -> str:
        peaks = {"error": self.q_ref - self.q, "rate": self.qd, "acceleration": self.qdd, "effort": self.tau}
        return joint_table(self.explain(), [str(name) for name in self.metadata["joints"]], self.q, peaks)

    def _repr_html_(self) -> str:
        return in_notebook(repr(self))

    @property
    def saturated(self) -> NDArray[np.bool_]:
        """(k, *batch, n) where an effort was clipped; nowhere in a kinematic run, whose efforts are NaN."""
        return (self.tau != self.tau_commanded) & ~np.isnan(self.tau)

    @property
    def duration(self) -> float:
        """Time of the last tick [s]."""
        return float(self.t[-1]) if len(self.t) else 0.0

    def explain(self, language: str | None = None) -> str:
        """How the run ended; singular poses near, clipped efforts, contact that chattered or was short, if any."""
        timed = Deadlines.of(self.metadata)
        joints = [str(name) for name in self.metadata["joints"]]
        found = [
            self._ending(language),
            near_singular_sentence(self.metadata.get("near_singular"), language),
            saturation_sentence(self.t, self.saturated, joints, language),
            alternating_sentence(self.t, self.tau, joints, language),
            *self._contact_sentences(language),
            None if timed is None else timed.explain(language),
            self._log_fault(language),
        ]
        return ". ".join(sentence for sentence in found if sentence)

    def _ending(self, language: str | None) -> str:
        ends = self.metadata.get("run_ends")
        if ends is not None and self.q.ndim > 2:
            lost, blown = (self.metadata[name] for name in ("runs_lost", "runs_blown_up"))
            first = min([*lost, *blown], key=lambda k: float(ends[k]))
            return say(
                "simulation.runs_ended", language=language, good=len(ends) - len(lost) - len(blown), count=len(ends),
                end=self.duration, lost=len(lost), blown=len(blown), first=first, time=float(ends[first]),
            )  # fmt: skip
        details = {"time": self.duration, "end": self.metadata.get("end", self.duration), "step": self.metadata["step"]}
        details |= {name: self.metadata.get(name, "") for name in ("law", "fault")}
        sentence = self.status.sentence(language, **details)
        if self.status is not SimulationStatus.BLOWN_UP or not self._stiff:
            return sentence
        known = {"integrator": self.metadata["integrator"], "other": IMPLICIT_FRICTION}
        return f"{sentence}. {say('simulation.stiff_friction', language=language, **known)}"

    def _contact_sentences(self, language: str | None) -> list[str | None]:
        """What is to be said of contact: of a rigid surface its events, of others what the ticks show."""
        rigid = self.metadata.get("rigid_contact")
        if rigid is not None:
            return [*rigid_sentences(rigid, language)]
        step = float(self.metadata["step"])
        return [
            chatter_sentence(self.t, self.contact_wrench, language),
            brief_contact_sentence(self.t, self.contact_wrench, step, language),
        ]

    def _log_fault(self, language: str | None) -> str | None:
        fault = self.metadata.get("log_fault")
        return say("simulation.log_fault", language=language, fault=visible(str(fault))) if fault else None

    @property
    def _stiff(self) -> bool:
        """Whether friction was too stiff for the step of an explicit integrator."""
        explicit = self.metadata.get("integrator") != IMPLICIT_FRICTION
        return explicit and float(self.metadata.get("friction_stiffness", 0.0)) > STIFF

    def arrays(self) -> dict[str, Floats]:
        """All arrays by name."""
        named = {f.name: getattr(self, f.name) for f in fields(self) if f.name not in ("status", "metadata")}
        return {name: array for name, array in named.items() if array is not None}

    def columns(self) -> dict[str, Floats]:
        """Every scalar over time, (k,) each, by a name such as `q[joint1]` or, in a batch, `q[3,joint1]`."""
        joints = [str(name) for name in self.metadata["joints"]]
        table: dict[str, Floats] = {"t": self.t}
        for name, array in self.arrays().items():
            if name == "t":
                continue
            per_joint = array.ndim == self.q.ndim
            labels = WRENCH if name == "contact_wrench" else joints
            for index in np.ndindex(array.shape[1:]):
                batch: tuple[int, ...] = index[:-1] if per_joint else index
                parts: list[str] = [*map(str, batch), *([labels[index[-1]]] if per_joint else [])]
                table[f"{name}[{','.join(parts)}]" if parts else name] = array[(slice(None), *index)]
        return table

    def to_dict(self) -> dict[str, Any]:
        """Status, metadata and all arrays by name."""
        return {"status": self.status.name.lower(), "metadata": dict(self.metadata), **self.arrays()}

    def thinned(self, numbers: int) -> Recording:
        """Every m-th tick and the last, of as many numbers at most; m stands in the metadata as `every_tick`.

        Args:
            numbers: of all arrays together.
        """
        every = max(1, -(-sum(array.size for array in self.arrays().values()) // max(numbers, 1)))
        if every == 1:
            return self
        rows = _rows(len(self.t), every)
        arrays: dict[str, Any] = {name: array[rows] for name, array in self.arrays().items()}
        return replace(self, **arrays, metadata={**self.metadata, "every_tick": every})

    def save(self, path: str | os.PathLike[str], *, table_numbers: int | None = None) -> tuple[Path, Path, Path]:
        """Write `path`.npz (all of it, what `load` reads), .csv (every column) and .json (status and metadata).

        A CSV file of more than so many numbers holds every m-th tick and the last; the JSON file says which m. Each
        file is written beside its place and renamed: it is whole or not there.

        Args:
            path: without suffix, or with one of the three.
            table_numbers: most in the CSV file; a million if None.

        Returns:
            The three paths.

        Raises:
            FileError: the place cannot be written.
        """
        stem = _stem(path)
        table = self.columns()
        most = TABLE_NUMBERS if table_numbers is None else max(table_numbers, 1)
        every = max(1, -(-len(self.t) * len(table) // most))
        ticks = every * int(self.metadata.get("every_tick", 1))
        about = json.dumps({**self._about(), "csv_every_tick": ticks}, indent=2, ensure_ascii=False)
        arrays: dict[str, Any] = {**self.arrays(), "about": np.array(about)}
        npz, csv, note = (stem.with_name(stem.name + suffix) for suffix in (".npz", ".csv", ".json"))
        write_whole(npz, lambda file: np.savez_compressed(file, allow_pickle=False, **arrays))
        write_whole(csv, lambda file: file.writelines(csv_table.csv_text(_every(table, every))))
        write_whole(note, about.encode())
        return npz, csv, note

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> Recording:
        """Read what `save` wrote, or a live log (`.mcap`): that of a run that still goes on or was killed, too.

        Args:
            path: as given to `save`, or to `LiveLog`.

        Raises:
            FileError: the file is missing, damaged or not a recording; a log of several runs, see `load_runs`.
        """
        if Path(path).suffix == SUFFIX:
            return _from_log(Path(path))
        file = _stem(path).with_name(_stem(path).name + ".npz")
        names = [f.name for f in fields(cls) if f.name not in ("status", "metadata")]
        about, arrays = stored_arrays.read(file, names, OPTIONAL)
        if about.get("format") != FORMAT:
            raise FileError("simulation.format", path=str(file), got=about.get("format"), known=FORMAT)
        try:
            status, metadata = SimulationStatus[about["status"]], dict(about["metadata"])
            stored_arrays.require_whole(arrays, metadata)
        except (KeyError, TypeError, ValueError) as fault:
            raise FileError("simulation.bad_file", path=str(file), fault=str(fault)) from None
        return cls(**arrays, status=status, metadata=metadata)

    @classmethod
    def load_runs(cls, path: str | os.PathLike[str]) -> tuple[Recording, ...]:
        """All runs of a live log, each in its own time.

        Args:
            path: of the log.

        Raises:
            FileError: the file is missing or not a log of runs.
        """
        return tuple(_of_logged(run, Path(path)) for run in log_reading.logged_runs(Path(path)))

    def _run(self, k: int) -> Recording:
        """One run of a batch, up to its own end."""
        only = replace(self, **{name: array[:, k] for name, array in self.arrays().items() if name != "t"})
        ends = self.metadata.get("run_ends")
        if ends is None:
            return only
        known = {name: value for name, value in self.metadata.items() if name not in ENDS}
        lost, blown = k in self.metadata["runs_lost"], k in self.metadata["runs_blown_up"]
        status = SimulationStatus.LOOPS_LOST if lost else SimulationStatus.BLOWN_UP if blown else None
        if status is None:
            return replace(only, status=SimulationStatus.COMPLETED, metadata=known)
        kept = self.t <= ends[k]
        arrays = {name: array[kept] for name, array in only.arrays().items()}
        fault = {"fault": say("simulation.loops_not_followed")} if lost else {}
        return replace(only, **arrays, status=status, metadata=known | {"end": self.duration} | fault)

    def _about(self) -> dict[str, object]:
        worst = {
            "tip_position_error": float(self.tip_position_error.max(initial=0.0)),
            "tip_rotation_error": float(self.tip_rotation_error.max(initial=0.0)),
            "saturated_ticks": int(self.saturated.any(axis=tuple(range(1, self.q.ndim))).sum()),
        }
        return {"format": FORMAT, "status": self.status.name, "worst": worst, "metadata": self.metadata}


def _stem(path: str | os.PathLike[str]) -> Path:
    given = Path(path)
    return given.with_suffix("") if given.suffix in (".npz", ".csv", ".json") else given


def _every(table: dict[str, Floats], every: int) -> dict[str, Floats]:
    """Every so many rows, and the last."""
    rows = _rows(len(table["t"]), every)
    return {name: column[rows] for name, column in table.items()}


def _rows(count: int, every: int) -> Integers:
    """Every so many of some rows, and the last."""
    return np.unique(np.append(np.arange(0, count, every), count - 1)) if count else np.zeros(0, dtype=np.int64)


def _of_logged(run: LoggedRun, path: Path) -> Recording:
    """One run of a log."""
    metadata = {name: value for name, value in run.metadata.items() if not name.startswith("log_")}
    try:
        status = SimulationStatus[metadata.pop("status")] if run.ended else SimulationStatus.LOG_TORN
        return Recording(**run.rows(), status=status, metadata=metadata)
    except (KeyError, TypeError) as fault:
        raise FileError("simulation.foreign_log", path=str(path), fault=str(fault)) from None


def _from_log(path: Path) -> Recording:
    """The one motion that a log holds."""
    runs = log_reading.logged_runs(path)
    duration = runs[0].metadata.get("log_duration")
    if duration is None and len(runs) > 1:
        raise FileError("simulation.several_runs", path=str(path), count=len(runs))
    whole = join_recordings([_of_logged(run, path) for run in runs])
    if duration is None:
        return whole
    # Between two of its runs a log may end, too.
    missing = duration - whole.duration > whole.metadata["period"] and whole.status.succeeded
    status = SimulationStatus.LOG_TORN if missing else whole.status
    return replace(whole, status=status, metadata=whole.metadata | {"end": duration})


def join_recordings(recordings: Sequence[Recording]) -> Recording:
    """One recording of runs that follow each other: each last tick is the first one of what follows.

    Args:
        recordings: at least one; where only some of them touched something, the force is zero in the others.
    """
    if any(each.contact_wrench is not None for each in recordings):
        recordings = [
            replace(each, contact_wrench=np.zeros((*each.q.shape[:-1], 6))) if each.contact_wrench is None else each
            for each in recordings
        ]
    last = recordings[-1]
    starts = np.concatenate([[0.0], np.cumsum([recording.t[-1] for recording in recordings])])
    parts: dict[str, list[Floats]] = {name: [] for name in last.arrays()}
    for recording, start in zip(recordings, starts, strict=False):
        kept = slice(None) if recording is last else slice(0, -1)
        for name, array in recording.arrays().items():
            parts[name].append(array[kept] + start if name == "t" else array[kept])
    arrays = {name: np.concatenate(rows) for name, rows in parts.items()}
    seconds = sum(float(recording.metadata.get("seconds", 0.0)) for recording in recordings)
    timed = [kept for each in recordings if (kept := Deadlines.of(each.metadata)) is not None]
    found: dict[str, Any] = {"clock": Deadlines.of_all(timed).to_dict()} if timed else {}
    touched = joined_events(starts.tolist(), [each.metadata.get("rigid_contact") for each in recordings])
    if touched is not None:
        found["rigid_contact"] = touched
    found |= _nearest_singular(recordings, starts)
    metadata = last.metadata | found | {"seconds": seconds, "end": float(starts[-2] + last.metadata["end"])}
    return Recording(**arrays, status=last.status, metadata=metadata)


def _nearest_singular(recordings: Sequence[Recording], starts: Floats) -> dict[str, Any]:
    """Where the runs together come nearest to a singular pose, in the time of all; nothing where none came near."""
    near = [
        {"ratio": pose["ratio"], "time": pose["time"] + float(start)}
        for each, start in zip(recordings, starts, strict=False)
        if (pose := each.metadata.get("near_singular")) is not None
    ]
    return {"near_singular": min(near, key=lambda one: one["ratio"])} if near else {}
