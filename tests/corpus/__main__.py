"""Fetch, load and compare the files of the manifest, or make the manifest from a mirror.

python -m tests.corpus fetch --cache FOLDER [--mirror FOLDER]
python -m tests.corpus run --cache FOLDER [--mirror FOLDER] [--format mjcf ...] [--only TEXT] [--output FOLDER]
python -m tests.corpus manifest --mirror FOLDER --repositories FILE
"""

from __future__ import annotations

import argparse
import json
from collections import Counter
from pathlib import Path

from tests.corpus import manifest
from tests.corpus.fetching import blobs, checked_out, git_directory, head_of
from tests.corpus.manifest import Repository, RobotFile
from tests.corpus.running import run


def main(words: list[str] | None = None) -> int:
    """The command line."""
    parser = argparse.ArgumentParser(prog="python -m tests.corpus", description="Robot files as they are published.")
    parser.add_argument("task", choices=("fetch", "run", "manifest"))
    parser.add_argument("--cache", type=Path, default=Path.home() / ".cache" / "mafsil-corpus")
    parser.add_argument("--mirror", type=Path, help="folder of git directories named owner+name")
    parser.add_argument("--format", nargs="*", choices=manifest.FORMATS, default=list(manifest.FORMATS))
    parser.add_argument("--only", default="", help="only paths owner/name/... that hold this text")
    parser.add_argument("--output", type=Path, help="folder for the figures and the verdicts")
    parser.add_argument("--repositories", type=Path, help="JSON lines: repository, licence, kind")
    options = parser.parse_args(words)
    if options.task == "manifest":
        return _make(options)
    rows = [
        (repository, file)
        for repository, file in manifest.read()
        if file.format in options.format and options.only in f"{repository.repository}/{file.path}"
    ]
    places = {r: checked_out(r, options.cache, options.mirror) for r in dict.fromkeys(r for r, _ in rows)}
    if options.task == "run":
        figures = run(rows, places, options.output)
        print(json.dumps(figures, indent=1))
        return int(figures["bad_different"] + figures["bad_crashed"] > 0)
    return 0


def _make(options: argparse.Namespace) -> int:
    made: list[tuple[Repository, list[RobotFile]]] = []
    seen: set[str] = set()
    for line in options.repositories.read_text("utf-8").splitlines():
        about = json.loads(line)
        source = git_directory(options.mirror / about["repository"].replace("/", "+"))
        commit = about.get("commit") or head_of(source)
        files = [
            RobotFile(path, manifest.digest(data), form)
            for path, data in blobs(source, commit)
            if path.lower().endswith((".xml", ".urdf", ".xacro", ".sdf", ".mjcf"))
            and (form := manifest.format_of(path, data))
        ]
        files = [file for file in files if not (file.sha256 in seen or seen.add(file.sha256))]
        made.append((Repository(about["repository"], commit, about["licence"], about["kind"]), files))
        print(about["repository"], commit, dict(Counter(file.format for file in files)))
    manifest.write(made)
    return 0


if __name__ == "__main__":
    raise SystemExit(main())
