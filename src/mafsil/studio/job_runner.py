"""The job of a studio: its text, which every window can edit, and the run that is going on."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Iterator, Mapping
from itertools import islice, takewhile
from pathlib import Path
from typing import Any

import numpy as np

from mafsil.arrays import PoseMatrix
from mafsil.errors import FileError, InputError, MafsilError
from mafsil.ik import SolutionSet, inverse_kinematics
from mafsil.job import Job, Refusal, Run, parse_job, solve
from mafsil.job.language.text import Places
from mafsil.job.planning.equipment import equip_robot
from mafsil.job.planning.plan import Plan
from mafsil.messages import say
from mafsil.messages.visible import visible
from mafsil.page.session import pose_from
from mafsil.report.content import Scene
from mafsil.report.page import around_data
from mafsil.report.replay import waiting_scene
from mafsil.report.results import require_replaceable, write_results
from mafsil.robot import Robot
from mafsil.studio.broadcast import Broadcast, in_all_languages
from mafsil.studio.placing import is_placed, placeable, placed_text, things_data
from mafsil.studio.recordings import PAUSE, LiveMotion
from mafsil.whole_file import write_whole

MOST_FINDINGS = 40
STEM = "job"


class Stopped(Exception):
    """Somebody stopped the run."""


class JobRunner:
    """Runs one job at a time in a thread of its own, and tells all windows how it goes.

    Args:
        broadcast: to the windows.
        path: file of the job, or None.
        text: of the job.
        results: folder into which each run gets a folder of its own.
        finished: is called with every run and the path of its report; says the number under which it is kept.
        robot: of the windows, around which a job's scene is drawn.
    """

    def __init__(
        self,
        broadcast: Broadcast,
        path: Path | None,
        text: str,
        results: Path,
        finished: Callable[[Run, Path], int],
        robot: Robot,
    ) -> None:
        self._robot = robot
        self._broadcast, self._path, self.results, self._finished = broadcast, path, results, finished
        self._source = "job.toml" if path is None else path.name
        self._thread: threading.Thread | None = None
        self._stop = threading.Event()
        self._sent_at = 0.0
        self._seen: tuple[Job, Scene] | None = None
        self.job: Mapping[str, Any] = self._job(text, "")
        self.run: Mapping[str, Any] = {"kind": "run", "status": "none"}
        self.motion = LiveMotion(broadcast)

    @property
    def running(self) -> bool:
        """Whether a run is going on."""
        return self._thread is not None and self._thread.is_alive()

    def edit(self, text: str, window: str) -> None:
        """Take another text, and say what is wrong with it.

        Args:
            text: TOML.
            window: in which it was written.
        """
        job = self._job(text, window)
        with self._broadcast.lock:
            self.job = job
            self._broadcast.send(job)

    def place(self, thing: int, T: PoseMatrix) -> None:
        """Take the text with a thing of it somewhere else.

        Args:
            thing: its number among those that can be placed.
            T: (4, 4) where it is wished for in {s}.

        Raises:
            InputError: no such thing, or the text would not have it there.
        """
        seen, text = self._seen, str(self.job["text"])
        things = [] if seen is None else placeable(seen[0], text)
        if seen is None or not 0 <= thing < len(things):
            raise InputError("studio.not_placed")
        job, scene = seen
        before = things[thing].pose(scene)
        new = self._job(placed_text(text, job, things[thing], before, T), "")
        if self._seen is None or not is_placed(things[thing], self._seen[1], before, T):
            self._seen = seen
            raise InputError("studio.not_placed")
        with self._broadcast.lock:
            self.job = new
            self._broadcast.send(new)

    def save(self) -> Path:
        """Write the text into the file that it came from.

        Raises:
            InputError: it came from none.
            FileError: the file cannot be written.
        """
        if self._path is None:
            raise InputError("studio.no_job_file")
        write_whole(self._path, str(self.job["text"]).encode())
        return self._path

    def start(self) -> None:
        """Run the job as it is written now.

        Raises:
            InputError: a run is going on.
        """
        with self._broadcast.lock:
            if self.running:
                raise InputError("studio.running")
            self._stop.clear()
            self._tell(status="running", stage="stage_robot", share=0.0)
            self._thread = threading.Thread(target=self._work, args=(str(self.job["text"]),), daemon=True)
            self._thread.start()

    def stop(self, patience: float = 0.0) -> None:
        """End the run that is going on, if there is one.

        Args:
            patience: how long to wait for its end [s].
        """
        self._stop.set()
        if self._thread is not None and patience > 0.0:
            self._thread.join(patience)

    def enter(self, stage: str) -> None:
        """A stage of the run begins."""
        self._progress(stage, 0.0)

    def update(self, share: float) -> None:
        """Share of the stage that is done.

        Raises:
            Stopped: somebody stopped the run.
        """
        if self._stop.is_set():
            raise Stopped
        if time.monotonic() - self._sent_at > PAUSE:
            self._progress(str(self.run.get("stage")), share)

    def show_plan(self, plan: Plan) -> None:
        """The motion is planned."""
        self.motion.show_plan(plan)

    def _work(self, text: str) -> None:
        try:
            self._finish(self._solve(text))
        except Stopped:
            self._tell(status="stopped")
        except MafsilError as error:
            self._tell(status="wrong", **complaint(error))
        except Exception as error:
            details = {"kind": type(error).__name__, "reason": str(error)}
            failure = in_all_languages(lambda code: say("cli.internal", language=code, **details))
            self._tell(status="wrong", code="cli.internal", line=None, sentence=failure)

    def _solve(self, text: str) -> Run | Refusal:
        self.motion = LiveMotion(self._broadcast)
        job = parse_job(text, self._source, folder=self._folder)
        return solve(job, text, self._folder, self, self._source, log=self.motion)

    @property
    def _folder(self) -> Path:
        """To which paths in the job are relative."""
        return Path() if self._path is None else self._path.parent

    def _finish(self, outcome: Run | Refusal) -> None:
        sentence = in_all_languages(lambda code: outcome.explain(code).split("\n")[0])
        if isinstance(outcome, Refusal):
            self._tell(status="refused", sentence=sentence, findings=[])
            return
        self._progress("stage_writing", 0.0)
        number = self._finished(outcome, self._written(outcome))
        findings = [{"level": one.level, **in_all_languages(one.sentence)} for one in outcome.remarks]
        self._tell(
            status=outcome.status.name.lower(),
            sentence=sentence,
            findings=findings[:MOST_FINDINGS],
            more=max(0, len(findings) - MOST_FINDINGS),
            recording=number,
        )

    def _written(self, run: Run) -> Path:
        """The report, in the first folder of a number that is not there yet."""
        stem, k = STEM if self._path is None else self._path.stem, 1
        while (self.results / f"{stem}-{k}").exists():
            k += 1
        target = self.results / f"{stem}-{k}"
        require_replaceable(target)
        try:
            return write_results(run, target)
        except OSError as error:
            raise FileError("file.cannot_write", path=str(target), reason=error.strerror or str(error)) from None

    def _job(self, text: str, window: str) -> Mapping[str, Any]:
        self._seen = None
        job: dict[str, Any] = {"kind": "job", "text": text, "window": window, "file": self._path is not None}
        try:
            asked = parse_job(text, self._source, folder=self._folder)
            scene = waiting_scene(asked, equip_robot(asked, self._folder), self._folder, text)
            if scene.q.shape[1] == self._robot.n:
                self._seen = asked, scene
                around = around_data(scene) | {"things": list(things_data(asked, placeable(asked, text)))}
                job |= {"title": visible(asked.title), "start": scene.q[0].tolist(), "around": around}
                lines = _lines_of_targets(asked, text)
                job["remarks"] = list(islice(_beyond_reach(asked, scene, self._robot, lines), MOST_FINDINGS))
        except MafsilError as error:
            job["wrong"] = complaint(error)
        return job

    def _progress(self, stage: str, share: float) -> None:
        self._sent_at = time.monotonic()
        self._tell(status="running", stage=stage, share=share)

    def _tell(self, **details: Any) -> None:
        with self._broadcast.lock:
            self.run = {"kind": "run", **details}
            self._broadcast.send(self.run)


def _lines_of_targets(job: Job, text: str) -> list[int | None]:
    """For each target the line on which its position stands; None of what is relative, or comes from another file."""
    places, goals = Places(text).of(job), [(k, move.pose) for k, move in enumerate(job.move) if move.pose is not None]
    return [None if goal.relative else places.line(("move", k, "pose", "position")) for k, goal in goals]


def _beyond_reach(job: Job, scene: Scene, robot: Robot, lines: list[int | None]) -> Iterator[dict[str, Any]]:
    """Targets that no configuration reaches: the line, the reason and what helps; of the tool that is mounted first."""
    moves = takewhile(lambda move: move.tool is None, job.move) if not robot.mechanism.loops else ()
    goals = [move.pose for move in moves if move.pose is not None]
    for goal, line, (_, at) in zip(goals, lines, scene.targets, strict=False):
        if goal.carrier is not None:
            continue
        T = np.array(pose_from(at[:3].tolist(), at[3:].tolist())).reshape(4, 4)
        found = inverse_kinematics(robot, T, q0=scene.q[0], task=goal.task)
        assert isinstance(found, SolutionSet)
        if not (len(found) and np.any(found.within)):
            yield {
                "line": line,
                "sentence": in_all_languages(lambda code, found=found: found.explain(code).split("\n")[0]),
            }


def complaint(error: MafsilError) -> dict[str, Any]:
    """An error for windows: its code, the line if it knows one, and its sentence in all languages."""
    line = error.details.get("line")
    sentence = in_all_languages(error.message)
    return {"code": error.key, "line": line if isinstance(line, int) else None, "sentence": sentence}
