"""All files judged one after the other in a process that may fail, and the figures counted."""

from __future__ import annotations

import json
import multiprocessing
import os
import platform
import time
from collections import Counter
from collections.abc import Iterable
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from queue import Queue
from typing import Any, TextIO

from tests.corpus import manifest
from tests.corpus.comparing import EQUAL, Verdict, judged
from tests.corpus.manifest import Repository, RobotFile
from tests.corpus.xacro_peer import Xacro

LONGEST_SECONDS = 60.0


def run(
    rows: Iterable[tuple[Repository, RobotFile]],
    places: dict[Repository, Path],
    output: Path | None,
    workspaces: dict[Repository, Path] | None = None,
    python_with_xacro: str = "",
    processes: int = 1,
    resume: bool = False,
) -> dict[str, Any]:
    """Judge all files, each in a process of its own for as long as it behaves, and count.

    Args:
        rows: files to judge.
        places: folders of the repositories.
        output: folder for the figures and verdicts.
        workspaces: folders of packages of each repository.
        python_with_xacro: an interpreter with ROS's xacro, or empty: xacro files are loaded without being compared.
        processes: that judge side by side.
        resume: keeps the verdicts that stand in the output folder, also those of other rows.
    """
    started = time.perf_counter()
    judges: Queue[_Judge] = Queue()
    for _ in range(processes):
        judges.put(_Judge(places, workspaces or {}, python_with_xacro))

    def judge(row: tuple[Repository, RobotFile]) -> dict[str, Any]:
        judge = judges.get()
        try:
            return judge.verdict(*row)
        finally:
            judges.put(judge)

    verdicts = _earlier(output) if resume and output is not None else []
    done = {(v["repository"], v["path"]) for v in verdicts}
    rows = [(repository, file) for repository, file in rows if (repository.repository, file.path) not in done]
    with ThreadPoolExecutor(processes) as threads, _lines(output) as lines:
        lines.writelines(json.dumps(verdict) + "\n" for verdict in verdicts)
        for verdict in threads.map(judge, rows):
            verdicts.append(verdict)
            lines.write(json.dumps(verdict) + "\n")
    while not judges.empty():
        judges.get().close()
    figures = counted(verdicts, time.perf_counter() - started)
    if output is not None:
        (output / "R4c.json").write_text(json.dumps(figures, indent=1), "utf-8")
        (output / "summary.json").write_text(json.dumps(summary(verdicts), indent=1), "utf-8")
    return figures


def _lines(output: Path | None) -> TextIO:
    """The file of the verdicts, a line each, readable while the run goes on."""
    if output is None:
        return Path(os.devnull).open("w", encoding="utf-8")
    output.mkdir(parents=True, exist_ok=True)
    return (output / "verdicts.jsonl").open("w", buffering=1, encoding="utf-8")


def _earlier(output: Path) -> list[dict[str, Any]]:
    path = output / "verdicts.jsonl"
    return [json.loads(line) for line in path.read_text("utf-8").splitlines()] if path.exists() else []


class _Judge:
    """One worker with its own xacro of ROS."""

    def __init__(self, places: dict[Repository, Path], workspaces: dict[Repository, Path], python: str) -> None:
        self.places, self.workspaces = places, workspaces
        self.worker, self.xacro = _Worker(), Xacro(python) if python else None

    def verdict(self, repository: Repository, file: RobotFile) -> dict[str, Any]:
        about = {"repository": repository.repository, "path": file.path, "format": file.format, "kind": repository.kind}
        if file.no_robot:
            about["no_robot"] = file.no_robot
        path = self.places.get(repository, Path()) / file.path
        if repository not in self.places or not path.exists() or manifest.digest(path.read_bytes()) != file.sha256:
            return {**about, "absent": True}
        workspace = self.workspaces.get(repository, path.parent)
        arguments, expansion, reason = file.arguments_in(workspace), None, ""
        if file.format == "xacro" and self.xacro is not None:
            expansion, reason = self.xacro.expanded(path, workspace, arguments)
        verdict = self.worker.judge(path, file.format, workspace, arguments, expansion)
        if reason:
            verdict |= {"peer": False, "peer_says": reason}
        return {**about, **verdict}

    def close(self) -> None:
        self.worker.close()
        if self.xacro is not None:
            self.xacro.close()


def counted(verdicts: list[dict[str, Any]], seconds: float) -> dict[str, Any]:
    """The figures of a run, flat: names that begin with `bad_` are failures.

    A file that the own reader of its format takes (urdfdom in Pinocchio, MuJoCo) and we refuse is one.
    """
    present = [v for v in verdicts if not v.get("absent")]
    makers = [v for v in present if v["kind"] == "maker" and v["format"] != "mjcf" and not v.get("no_robot")]
    manipulators = [v for v in present if v["format"] == "mjcf" and v.get("peer") and v.get("manipulator")]
    compared = [v for v in present if v.get("error") is not None]
    taken = [v for v in present if v.get("peer")]
    return {
        "row": "R4c",
        "machine": platform.machine(),
        "python": platform.python_version(),
        "seconds": seconds,
        "files": len(present),
        "absent": len(verdicts) - len(present),
        "loaded": _loaded(present),
        "no_robots_by_themselves": sum(bool(v.get("no_robot")) for v in present),
        "makers_robots": len(makers),
        "makers_robots_loaded": _loaded(makers),
        "MJCF_manipulators_that_MuJoCo_reads": len(manipulators),
        "MJCF_manipulators_loaded": _loaded(manipulators),
        "taken_by_the_own_reader": len(taken),
        "of_those_loaded": _loaded(taken),
        "compared": len(compared),
        "bad_different": sum(not v["error"] < EQUAL for v in compared),
        "bad_crashed": sum("crashed" in v for v in present),
        "bad_refused": len(taken) - _loaded(taken),
    }


def summary(verdicts: list[dict[str, Any]]) -> dict[str, Any]:
    """What was refused, and what each format counts."""
    present = [v for v in verdicts if not v.get("absent")]
    forms = {form: [v for v in present if v["format"] == form] for form in sorted({v["format"] for v in present})}
    return {
        "by_format": {
            form: {
                "files": len(rows),
                "loaded": _loaded(rows),
                "peer_reads": sum(bool(v.get("peer")) for v in rows),
                "both": sum(bool(v.get("peer") and v.get("loaded")) for v in rows),
            }
            for form, rows in forms.items()
        },
        "refusals": _ranked(present),
        "refusals_that_the_peer_reads": _ranked([v for v in present if v.get("peer")]),
    }


def _loaded(rows: list[dict[str, Any]]) -> int:
    return sum(bool(v.get("loaded")) for v in rows)


def _ranked(rows: list[dict[str, Any]]) -> dict[str, int]:
    return dict(Counter(" ".join(v["codes"]) for v in rows if v.get("codes")).most_common())


class _Worker:
    """A process that judges files one after the other; a file that takes too long or ends it costs only itself."""

    def __init__(self) -> None:
        self.process: multiprocessing.process.BaseProcess | None = None

    def judge(self, path: Path, form: str, workspace: Path, *rest: object) -> dict[str, Any]:
        if self.process is None or not self.process.is_alive():
            context = multiprocessing.get_context("spawn")
            self.line, other = context.Pipe()
            self.process = context.Process(target=_serve, args=(other,), daemon=True)
            self.process.start()
        self.line.send((path, form, workspace, *rest))
        try:
            if self.line.poll(LONGEST_SECONDS):
                return self.line.recv()
            reason = f"longer than {LONGEST_SECONDS:.0f} s"
        except EOFError:
            reason = "the process ended"
        self.process.kill()
        self.process.join()
        return {"crashed": reason}

    def close(self) -> None:
        if self.process is not None:
            self.process.kill()


def _serve(line: Any) -> None:
    while True:
        path, form, workspace, *rest = line.recv()
        os.environ["ROS_PACKAGE_PATH"] = str(workspace)
        try:
            line.send(judged(path, form, *rest).as_dict())
        except Exception as error:
            line.send({**Verdict().as_dict(), "crashed": f"{type(error).__name__}: {error}"[:300]})
