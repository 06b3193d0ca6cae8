"""A studio: one robot, the windows that show it, and what Python does for them."""

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

from mafsil.errors import InputError
from mafsil.job import Run
from mafsil.kernels.lazy import lazy
from mafsil.messages import language as current_language
from mafsil.model.loading import RobotLike
from mafsil.page.arm import Arm
from mafsil.page.assemble import assembled, needed
from mafsil.page.content import content
from mafsil.report.results import FILES
from mafsil.robot import as_open_tree
from mafsil.studio.broadcast import Broadcast
from mafsil.studio.configurations import configurations
from mafsil.studio.job_runner import JobRunner
from mafsil.studio.journal import Journal
from mafsil.studio.protocol import Changes, JobText, Nothing, Number, Pair, Pose, read
from mafsil.studio.recordings import Recordings
from mafsil.studio.server import HTML, Content, Server

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
        self.arm = Arm(as_open_tree(robot), needed(self._own))
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
        self.jobs = JobRunner(self.broadcast, path, text, results, self._ran)
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
        return assembled(data, (*_views(), *self._own), MAIN)

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
        latest = (self.jobs.job, self.jobs.run, self.recordings.listed())
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
            "job/save": lambda body: self._saved(read(Nothing, body)),
            "job/run": lambda body: _done(self._start(read(Nothing, body))),
            "job/stop": lambda body: _done(self._stop(read(Nothing, body))),
            "recording": lambda body: self.recordings.data(read(Number, body).number),
            "compare": lambda body: self._compare(read(Pair, body)),
            "configurations": lambda body: self._configurations(read(Pose, body)),
        }

    def _edit(self, job: JobText) -> None:
        self.jobs.edit(job.text, job.window)

    def _saved(self, _: Nothing) -> Mapping[str, Any]:
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
        return self.recordings.add(f"{report.parent.name} · {run.job.title or run.robot.name}", run.recording, report)


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
