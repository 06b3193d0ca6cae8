"""A studio: one robot, the windows that show it, and what Python does for them.

All configurations of a pose, by every method that Python has: closed forms, elimination, search.

The journal that all windows share: named lines in one order.
"""

from __future__ import annotations

import json
import os
import threading
import webbrowser
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

import msgspec
import numpy as np

from mafsil.errors import InputError
from mafsil.ik import Branch, SolutionSet, inverse_kinematics
from mafsil.job import Run
from mafsil.kernels.lazy import lazy
from mafsil.messages import language as current_language
from mafsil.model.loading import RobotLike
from mafsil.page.arm import Arm
from mafsil.page.assemble import assemble, needed_quantities
from mafsil.page.content import content
from mafsil.page.session import Session, pose_from
from mafsil.report.replay import replay_scene
from mafsil.report.results import FILES
from mafsil.robot import as_open_tree
from mafsil.studio.broadcast import Broadcast, in_all_languages
from mafsil.studio.job_runner import JobRunner
from mafsil.studio.protocol import Changes, Drop, JobText, Nothing, Number, Pair, Placement, Pose, Put, action, read
from mafsil.studio.recordings import Recorded, Recordings
from mafsil.studio.server import HTML, Content, Server

MOST_LINES = 20_000
MOST_AT_ONCE = 600_000
"""Steps of 1 ms by which one message may drive the loop on: ten minutes, some seconds of work for every window."""
MOST_SHOWN = 64
AREAS = ("page", "studio")
"""Of the catalogue, whose sentences the windows have."""
MAIN = "studio/main.js"
RESULTS = Path("mafsil-results")
PATIENCE = 15.0
"""How long the end waits for a run that was stopped [s]: a report that is being written is finished."""
KINDS = {".html": HTML, ".json": "application/json", ".csv": "text/csv; charset=utf-8"}


@dataclass(frozen=True)
class Script:
    """How the scripts that windows save name the robot.

    Attributes:
        python: the expression.
        imports: lines in front of it.
    """

    python: str
    imports: tuple[str, ...] = ()


class Studio:
    """A robot served to the browser of this machine.

    Args:
        robot: any robot; a name or a file.
        port: 0 for any that is free.
        language: in which windows open; the current one if None.
        script: how saved scripts name the robot; what was given if None.
        job: text of the job that windows begin with, and its file or None.
        results: folder into which runs write.
        views: files with views of your own, one each (docs/adding_a_view.md); their script runs in the windows.

    Raises:
        InputError: the port is taken.
        MafsilError: no such robot, or a view that cannot be read.
    """

    def __init__(
        self,
        robot: RobotLike,
        *,
        port: int = 0,
        language: str | None = None,
        script: Script | None = None,
        job: tuple[str, Path | None] | None = None,
        results: Path = RESULTS,
        views: Sequence[str | os.PathLike[str]] = (),
    ) -> None:
        self._own = tuple(os.path.abspath(view) for view in views)
        self.arm = Arm(as_open_tree(robot), needed_quantities(self._own))
        self.language = language or current_language()
        self._script = script or Script(
            repr(str(robot)) if isinstance(robot, str | Path) else repr(self.arm.robot.name)
        )
        self.broadcast = Broadcast(self._everything)
        self.journal = Journal(self.arm, self.broadcast)
        self.recordings = Recordings(self.arm.robot, self.broadcast)
        text, path = job or (
            _first_job(self.arm, str(robot) if isinstance(robot, str | Path) else self.arm.robot.name),
            None,
        )
        self.jobs = JobRunner(self.broadcast, path, text, results, self._ran, self.arm.robot)
        if path is not None and "start" in self.jobs.job:
            given = msgspec.Raw(msgspec.json.encode({"values": self.jobs.job["start"]}))
            self.journal.change([Put("job-0", "set_joints", given)])
        self._heavy = threading.Lock()
        try:
            self.server = Server(port, self._look, self._deeds(), self.broadcast)
        except OSError as error:
            raise InputError("studio.port_taken", port=port, reason=error.strerror or str(error)) from None

    def __enter__(self) -> Studio:
        return self

    def __exit__(self, *_: object) -> None:
        self.server.close()
        self.jobs.stop(PATIENCE)

    @property
    def address(self) -> str:
        """Of the page; whoever knows it can use the studio."""
        return self.server.address

    @lazy
    def html(self) -> str:
        """The page that the server sends."""
        data = content(self.arm, self.language, self._script.python, AREAS)
        data["robot"]["imports"] = list(self._script.imports)
        return assemble(data, (*_views(), *self._own), MAIN)

    def serve(self, *, show: bool = False) -> None:
        """Serve until Ctrl-C.

        Args:
            show: open the page in the browser.

        Raises:
            KeyboardInterrupt: Ctrl-C.
        """
        self.html  # noqa: B018 - made before the first window asks
        if show:
            webbrowser.open(self.address)
        self.server.serve_forever()

    def _everything(self) -> Mapping[str, Any]:
        motion = [self.jobs.motion.message] if self.jobs.running and self.jobs.motion.message else []
        latest = (self.jobs.job, self.jobs.run, self.recordings.list_recordings(), *motion)
        return {"kind": "all", "journal": self.journal.lines(), "rest": {one["kind"]: one for one in latest}}

    def _look(self, path: str) -> Content | None:
        """What stands at a path: the page, a recording, a file of a run's results."""
        folder, _, rest = path.partition("/")
        number, _, name = rest.partition("/")
        if path == "":
            return Content(self.html.encode(), HTML)
        if folder != "reports" or not (number.isascii() and number.isdigit() and len(number) < 10):
            return None
        return self._file(int(number), name or FILES[0])

    def _file(self, number: int, name: str) -> Content | None:
        """A file of the results of a run; no other file."""
        try:
            report = self.recordings.of(number).report
        except InputError:
            return None
        if report is None or name not in FILES:
            return None
        try:
            return Content(
                report.with_name(name).read_bytes(), KINDS.get(Path(name).suffix, "application/octet-stream")
            )
        except OSError:
            return None

    def _deeds(self) -> dict[str, Callable[[bytes], Mapping[str, Any]]]:
        """What windows can ask for, by path."""
        return {
            "actions": lambda body: _done(self.journal.change(read(Changes, body))),
            "job": lambda body: _done(self._edit(read(JobText, body))),
            "job/place": lambda body: self._place(read(Placement, body)),
            "job/save": lambda body: self._save(read(Nothing, body)),
            "job/run": lambda body: _done(self._start(read(Nothing, body))),
            "job/stop": lambda body: _done(self._stop(read(Nothing, body))),
            "recording": lambda body: self.recordings.data(read(Number, body).number),
            "compare": lambda body: self._compare(read(Pair, body)),
            "configurations": lambda body: self._configurations(read(Pose, body)),
        }

    def _edit(self, job: JobText) -> None:
        self.jobs.edit(job.text, job.window)

    def _place(self, asked: Placement) -> Mapping[str, Any]:
        self.jobs.place(asked.thing, np.array(pose_from(asked.position, asked.quaternion)).reshape(4, 4))
        return {"text": self.jobs.job["text"]}

    def _save(self, _: Nothing) -> Mapping[str, Any]:
        return {"file": str(self.jobs.save())}

    def _start(self, _: Nothing) -> None:
        self.jobs.start()

    def _stop(self, _: Nothing) -> None:
        self.jobs.stop()

    def _compare(self, pair: Pair) -> Mapping[str, Any]:
        with self._heavy:
            return self.recordings.compare(pair.first, pair.second)

    def _configurations(self, asked: Pose) -> Mapping[str, Any]:
        with self._heavy:
            return configurations(self.arm, asked)

    def _ran(self, run: Run, report: Path) -> int:
        title = f"{report.parent.name} · {run.job.title or run.robot.name}"
        return self.recordings.add(Recorded(title, run.recording, report, replay_scene(run)))


def _done(_: None) -> Mapping[str, Any]:
    return {}


def _first_job(arm: Arm, robot: str) -> str:
    """A job to begin with: from where the arm stands to where it began."""
    start = ", ".join(f"{value:.4g}" for value in arm.start)
    other = ", ".join(f"{0.5 * value:.4g}" for value in arm.start)
    moves = "".join(f"\n[[move]]\njoints = [{where}]\n" for where in (other, start))
    name = json.dumps(robot, ensure_ascii=False)
    return f'robot = {name}\nangles = "radians"\n\n[start]\njoints = [{start}]\n{moves}'


def _views() -> Sequence[str]:
    """Paths of the views that only a studio has."""
    folder = resources.files("mafsil.studio").joinpath("views")
    return sorted(str(file) for file in folder.iterdir() if file.name.endswith(".js"))


def configurations(arm: Arm, asked: Pose) -> Mapping[str, Any]:
    """The configurations that bring the tip to a pose, as data for a window.

    Args:
        arm: whose tip; with fewer than six joints only the position counts.
        asked: the pose, and where the arm is.

    Raises:
        InputError: the pose is none, or there are not as many coordinates as joints.
    """
    robot = arm.robot
    if len(asked.q) != robot.n:
        raise InputError("session.count", got=len(asked.q), wanted=robot.n)
    T = np.array(pose_from(asked.position, asked.quaternion)).reshape(4, 4)
    found = inverse_kinematics(robot, T, q0=np.array(asked.q), task="pose" if arm.rotates else "position")
    assert isinstance(found, SolutionSet)
    order = np.argsort(~found.within, kind="stable")[:MOST_SHOWN]
    branches: tuple[Branch, ...] = found.branches
    return {
        "count": len(found),
        "sentence": in_all_languages(found.explain),
        "rows": [
            {
                "q": found.q[k].tolist(),
                "within": bool(found.within[k]),
                "residual": float(found.residual[k]),
                **in_all_languages(branches[k].label),
            }
            for k in map(int, order)
        ],
    }


class Journal:
    """What has been done, line after line.

    Args:
        arm: whose actions they are.
        broadcast: who hears of every change.
    """

    def __init__(self, arm: Arm, broadcast: Broadcast) -> None:
        self._arm = arm
        self._broadcast = broadcast
        self._lines: dict[str, dict[str, Any]] = {}

    def change(self, changes: Sequence[Put | Drop]) -> None:
        """Take changes of a window: all of them, or none.

        Args:
            changes: lines put in the journal or taken back; a line that is there already is done in its place.

        Raises:
            InputError: one of them cannot be done or drives too far, or the journal is full.
        """
        checked = [(one.id, None if isinstance(one, Drop) else action(one, self._arm)) for one in changes]
        with self._broadcast.lock:
            new = {name for name, done in checked if done is not None and name not in self._lines}
            if len(self._lines) + len(new) > MOST_LINES:
                raise InputError("studio.journal_full", most=MOST_LINES)
            for name, done in checked:
                if done is not None:
                    self._require_short(name, done)
            for name, done in checked:
                self._apply(name, done)

    def lines(self) -> list[dict[str, Any]]:
        """Every line with its name."""
        with self._broadcast.lock:
            return [{"id": name, **done} for name, done in self._lines.items()]

    def replay(self) -> Session:
        """The arm as the windows show it, to the last bit."""
        session = Session(self._arm.robot)
        session.do([{"do": one["do"], "with": one["with"]} for one in self.lines()])
        return session

    def _require_short(self, name: str, done: Mapping[str, Any]) -> None:
        """Refuse a drive that would hold every window for long; a line that grows is driven on by what it grew."""
        before = self._lines.get(name, {}).get("with", {})
        steps = done["with"].get("ticks", 0) - before.get("ticks", 0)
        if steps > MOST_AT_ONCE:
            raise InputError("studio.ticks", steps=steps, most=MOST_AT_ONCE)

    def _apply(self, name: str, done: Mapping[str, Any] | None) -> None:
        if done is not None:
            self._lines[name] = dict(done)
            self._broadcast.send({"kind": "put", "id": name, **done})
        elif self._lines.pop(name, None) is not None:
            self._broadcast.send({"kind": "drop", "id": name})
