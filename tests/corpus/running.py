"""All files judged one after the other in a process that may fail, and the figures counted."""

from __future__ import annotations

import json
import multiprocessing
import platform
import time
from collections import Counter
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from tests.corpus import manifest
from tests.corpus.comparing import EQUAL, Verdict, judged
from tests.corpus.manifest import Repository, RobotFile

LONGEST_SECONDS = 60.0


def run(
    rows: Iterable[tuple[Repository, RobotFile]], places: dict[Repository, Path], output: Path | None
) -> dict[str, Any]:
    """Judge all files, each in a process of its own for as long as it behaves, and count."""
    started = time.perf_counter()
    verdicts: list[dict[str, Any]] = []
    worker = _Worker()
    for repository, file in rows:
        path = places[repository] / file.path
        about = {"repository": repository.repository, "path": file.path, "format": file.format, "kind": repository.kind}
        if not path.exists() or manifest.digest(path.read_bytes()) != file.sha256:
            verdicts.append({**about, "absent": True})
            continue
        verdicts.append({**about, **worker.judge(path, file.format)})
    worker.close()
    if output is not None:
        output.mkdir(parents=True, exist_ok=True)
        (output / "verdicts.jsonl").write_text("\n".join(json.dumps(v) for v in verdicts) + "\n", "utf-8")
    figures = counted(verdicts, time.perf_counter() - started)
    if output is not None:
        (output / "R4c.json").write_text(json.dumps(figures, indent=1), "utf-8")
        (output / "summary.json").write_text(json.dumps(summary(verdicts), indent=1), "utf-8")
    return figures


def counted(verdicts: list[dict[str, Any]], seconds: float) -> dict[str, Any]:
    """The figures of a run, flat: names that begin with `bad_` must stay zero."""
    present = [v for v in verdicts if not v.get("absent")]
    makers = [v for v in present if v["kind"] == "maker" and v["format"] != "mjcf"]
    manipulators = [v for v in present if v["format"] == "mjcf" and v.get("peer") and v.get("manipulator")]
    compared = [v for v in present if v.get("error") is not None]
    return {
        "row": "R4c",
        "machine": platform.machine(),
        "python": platform.python_version(),
        "seconds": seconds,
        "files": len(present),
        "absent": len(verdicts) - len(present),
        "loaded": _loaded(present),
        "makers_robots": len(makers),
        "makers_robots_loaded": _loaded(makers),
        "MJCF_manipulators_that_MuJoCo_reads": len(manipulators),
        "MJCF_manipulators_loaded": _loaded(manipulators),
        "compared": len(compared),
        "bad_different": sum(not v["error"] < EQUAL for v in compared),
        "bad_crashed": sum("crashed" in v for v in present),
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

    def judge(self, path: Path, form: str) -> dict[str, Any]:
        if self.process is None or not self.process.is_alive():
            context = multiprocessing.get_context("spawn")
            self.line, other = context.Pipe()
            self.process = context.Process(target=_serve, args=(other,), daemon=True)
            self.process.start()
        self.line.send((path, form))
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
        path, form = line.recv()
        try:
            line.send(judged(path, form).as_dict())
        except Exception as error:
            line.send({**Verdict().as_dict(), "crashed": f"{type(error).__name__}: {error}"[:300]})
