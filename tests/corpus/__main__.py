"""Fetch, load and compare the files of the manifest, or make the manifest from a mirror.

python -m tests.corpus fetch --cache FOLDER [--mirror FOLDER]
python -m tests.corpus run --cache FOLDER [--mirror FOLDER] [--format mjcf ...] [--only TEXT] [--output FOLDER]
                           [--xacro PYTHON] [--processes 2] [--resume]
python -m tests.corpus manifest --cache FOLDER --mirror FOLDER --repositories FILE --xacro PYTHON
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path
from typing import Any

from tests.corpus import manifest
from tests.corpus.fetching import checked_out, git_directory, head_of, workspace
from tests.corpus.manifest import Repository, RobotFile
from tests.corpus.running import run
from tests.corpus.xacro_peer import Xacro


def main(words: list[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.corpus", description="Robot files as they are published.")
    parser.add_argument("task", choices=("fetch", "run", "manifest"))
    parser.add_argument("--cache", type=Path, default=Path.home() / ".cache" / "mafsil-corpus")
    parser.add_argument("--mirror", type=Path, help="folder of git directories named owner+name")
    parser.add_argument("--format", nargs="*", choices=manifest.FORMATS, default=list(manifest.FORMATS))
    parser.add_argument("--only", default="", help="only paths owner/name/... that hold this text")
    parser.add_argument("--output", type=Path, help="folder for the figures and the verdicts")
    parser.add_argument("--xacro", default="", metavar="PYTHON", help="an interpreter with the package xacro")
    parser.add_argument("--processes", type=int, default=1)
    parser.add_argument("--resume", action="store_true", help="keep the verdicts that the output folder holds")
    parser.add_argument(
        "--repositories",
        type=Path,
        help="JSON lines: repository, licence, kind, perhaps commit, arguments {path: {name: value}} of xacro files",
    )
    options = parser.parse_args(words)
    if options.task == "manifest":
        return _make(options)
    rows = [
        (repository, file)
        for repository, file in manifest.read()
        if file.format in options.format and options.only in f"{repository.repository}/{file.path}"
    ]
    places, workspaces = _laid_out(dict.fromkeys(r for r, _ in manifest.read()), options)
    if options.task == "run":
        xacro, processes, resume = options.xacro, options.processes, options.resume
        figures = run(rows, places, options.output, workspaces, xacro, processes, resume)
        print(json.dumps(figures, indent=1))
        return int(any(count for name, count in figures.items() if name.startswith("bad_")))
    return 0


def _laid_out(
    repositories: Iterable[Repository], options: argparse.Namespace
) -> tuple[dict[Repository, Path], dict[Repository, Path]]:
    """Folders of the repositories, and of their workspaces; files of those that a mirror lacks count as absent."""
    here = [r for r in repositories if options.mirror is None or (options.mirror / r.folder).exists()]
    places = {r: checked_out(r, options.cache, options.mirror) for r in here}
    return places, {r: workspace(r, places, options.cache) for r in places}


def _make(options: argparse.Namespace) -> int:
    lines = [json.loads(line) for line in options.repositories.read_text("utf-8").splitlines()]
    sources = [git_directory(options.mirror / about["repository"].replace("/", "+")) for about in lines]
    repositories = [
        Repository(about["repository"], about.get("commit") or head_of(source), about["licence"], about["kind"])
        for about, source in zip(lines, sources, strict=True)
    ]
    places, workspaces = _laid_out(repositories, options)
    xacro = Xacro(options.xacro)
    made: list[tuple[Repository, list[RobotFile]]] = []
    seen: set[str] = set()
    for repository, about in zip(repositories, lines, strict=True):
        files: list[RobotFile] = []
        for path in sorted(p.relative_to(places[repository]) for p in places[repository].rglob("*") if p.is_file()):
            name = path.as_posix()
            file = _file(name, (places[repository] / path).read_bytes(), about)
            if file is None or file.sha256 in seen:
                continue
            seen.add(file.sha256)
            if file.format == "xacro":
                place = places[repository] / path, workspaces[repository]
                document, reason = xacro.expanded(*place, file.arguments_in(place[1]))
                reason = reason.replace(f"{places[repository]}/", "")
                file = replace(file, no_robot=_no_robot(document, reason))
            files.append(file)
        made.append((repository, files))
        print(repository.repository, repository.commit, dict(Counter(file.format for file in files)))
    xacro.close()
    manifest.write(made)
    return 0


def _file(path: str, data: bytes, about: dict[str, Any]) -> RobotFile | None:
    """The row of a file, if it is one of a robot format."""
    if not path.lower().endswith((".xml", ".urdf", ".xacro", ".sdf", ".mjcf")):
        return None
    form = manifest.format_of(path, data)
    if form is None:
        return None
    reason = manifest.missing_link(data) if form == "urdf" else ""
    return RobotFile(path, manifest.digest(data), form, about.get("arguments", {}).get(path, {}), reason)


def _no_robot(document: str | None, reason: str) -> str:
    """Why ROS's xacro makes no robot of a file, or nothing."""
    if document is None:
        return reason.splitlines()[0].partition(" [Errno")[0].replace("<class 'LookupError'>: ", "")
    return manifest.missing_link(document)


if __name__ == "__main__":
    raise SystemExit(main())
